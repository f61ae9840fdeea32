// Laws of `mpirun scree run --distributed`: the hash of a single process, and what it prints.
#include <tests/run_program.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace {

using scree::testing::Outcome;

class DistributedCommand : public scree::testing::ProgramTest {
 protected:
  Outcome scree(const std::string& arguments) { return run("'" SCREE_COMMAND "' run " + arguments); }
  // More ranks than cores take turns. Ranks that wait for one another for ever end as a failure.
  Outcome launch(int ranks, const std::string& program) { return run(launch_line(ranks, program)); }
  std::string launch_line(int ranks, const std::string& program) {
    return "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 timeout 300 '" SCREE_MPIRUN
           "' --oversubscribe --mca mpi_yield_when_idle 1 -np " +
           std::to_string(ranks) + " " + program;
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  static std::string hash_of(const Outcome& outcome) {
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.exit_code == 0 ? nlohmann::json::parse(outcome.out)["hash"] : nlohmann::json("none");
  }
  Outcome mpirun(int ranks, const std::string& arguments) {
    return launch(ranks, "'" SCREE_COMMAND "' run --distributed --threads 1 " + arguments);
  }
};

const std::string kScene = "pile --set bodies=300 --steps 60 --quiet --json - ";

TEST_F(DistributedCommand, HasTheHashOfOneProcess) {
  const Outcome one = scree(kScene + "--no-sleep --isa scalar");
  ASSERT_EQ(one.exit_code, 0) << one.err;
  const nlohmann::json expected = nlohmann::json::parse(one.out);
  for (const int ranks : {1, 3}) {
    const Outcome outcome = mpirun(ranks, kScene + "--no-sleep --latency 5");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const nlohmann::json figures = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(figures["hash"], expected["hash"]) << ranks << " ranks";
    EXPECT_EQ(figures["contacts"], expected["contacts"]) << ranks << " ranks";
    EXPECT_EQ(figures["awake_bodies"], expected["awake_bodies"]) << ranks << " ranks";
    ASSERT_EQ(figures["ranks"].size(), static_cast<std::size_t>(ranks));
    for (const nlohmann::json& rank : figures["ranks"]) EXPECT_LT(rank["load"], 1.5);
  }
}

// The pile falls asleep.
TEST_F(DistributedCommand, CountsWhatSleepsAsOneProcessDoes) {
  const std::string scene = "pile --set bodies=60 --steps 300 --quiet --json - ";
  const Outcome one = scree(scene), two = mpirun(2, scene);
  ASSERT_EQ(one.exit_code, 0) << one.err;
  ASSERT_EQ(two.exit_code, 0) << two.err;
  const nlohmann::json expected = nlohmann::json::parse(one.out), figures = nlohmann::json::parse(two.out);
  EXPECT_EQ(expected["awake_bodies"], 0);
  for (const char* const name : {"awake_bodies", "contacts", "hash"})
    EXPECT_EQ(figures[name], expected[name]);
}

TEST_F(DistributedCommand, PrintsARowForEachRank) {
  const Outcome outcome = mpirun(3, "pile --set bodies=100 --steps 5 --no-sleep --quiet");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* const name : {"ranks", "rank 0", "rank 2", "waiting", "load", "hash"})
    EXPECT_NE(outcome.out.find(name), std::string::npos) << name << "\n" << outcome.out;
}

TEST_F(DistributedCommand, RefusesOptionsThatSayNothing) {
  const auto refused = [&](const std::string& arguments, const std::string& reason) {
    const Outcome outcome = scree("pile --quiet " + arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_NE(outcome.err.find(reason), std::string::npos) << arguments << "\n" << outcome.err;
  };
  const std::string file = path("of_another_scene");
  refused("--latency 5", "without --distributed");
  refused("--checkpoint-steps 5", "without --checkpoint");
  refused("--resume '" + file + "'", file);
  ASSERT_EQ(scree("pile --set bodies=20 --steps 3 --quiet --checkpoint '" + file + "' --checkpoint-steps 2")
                .exit_code,
            0);
  refused("--set bodies=30 --resume '" + file + "'", "of another scene");
  refused("--set bodies=20 --steps 2 --resume '" + file + "'", "--steps 2");
  refused("--set bodies=20 --steps 9 --dt 2 --resume '" + file + "'", "--dt");
}

TEST_F(DistributedCommand, EndsAllProcessesWithTheReason) {
  const auto refused = [&](const std::string& arguments, const std::string& reason) {
    const Outcome outcome = mpirun(2, arguments);
    EXPECT_NE(outcome.exit_code, 0) << arguments;
    EXPECT_NE(outcome.err.find(reason), std::string::npos) << arguments << "\n" << outcome.err;
  };
  refused("no_such_scene", "no_such_scene");
  refused("pile --steps 0", "--steps");
  refused("pile --picture x.png", "not with --distributed");
  refused("many_worlds --set worlds=2 --set bodies=10", "--set worlds=1");
  const std::string script = path("of_rank.sh");
  std::ofstream(script) << "exec '" SCREE_COMMAND << "' run --distributed --threads 1 $(eval echo $1)\n";
  const std::string scene = path("of_rank_");
  for (const char* const rank : {"0", "1", "2"}) {
    const char* const radius = *rank == '2' ? "0.4" : "0.5";  // which a world's hash does not hold
    std::ofstream(scene + rank + ".json")
        << R"({"bodies": [{"shapes": [{"type": "sphere", "radius": )" << radius << "}]}]}";
  }
  for (const std::string& of_rank : {std::string("pile --steps 3 --set bodies=4$OMPI_COMM_WORLD_RANK"),
                                     std::string("pile --set bodies=40 --steps 3$OMPI_COMM_WORLD_RANK"),
                                     scene + "$OMPI_COMM_WORLD_RANK.json --steps 3"}) {
    const Outcome differ = launch(3, "sh '" + script + "' '" + of_rank + "'");
    EXPECT_NE(differ.exit_code, 0);
    const std::string reason = "the scenes or steps of the processes differ";
    EXPECT_NE(differ.err.find(reason), std::string::npos) << of_rank << "\n" << differ.err;
    EXPECT_EQ(differ.err.find(reason), differ.err.rfind(reason)) << "told more than once: " << differ.err;
  }
}

TEST_F(DistributedCommand, ReadmeProgramPrintsTheSameHashForEachNumberOfRanks) {
  const Outcome one = launch(1, "'" SCREE_MPI_PROGRAM "'");
  ASSERT_EQ(one.exit_code, 0) << one.err;
  EXPECT_EQ(one.out.find("hash "), 0u) << one.out;
  EXPECT_EQ(launch(3, "'" SCREE_MPI_PROGRAM "'").out, one.out);
}

TEST_F(DistributedCommand, RecordsWhatOneProcessVerifies) {
  const std::string file = path("ranks.scree");
  const Outcome recorded = mpirun(4, kScene + "--keyframes 25 --record '" + file + "'");
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  const Outcome replayed =
      run("'" SCREE_COMMAND "' replay '" + file + "' --verify --isa scalar --quiet --json -");
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  const Outcome described = run("'" SCREE_COMMAND "' info '" + file + "' --json -");
  EXPECT_EQ(nlohmann::json::parse(described.out)["keyframes"], 4) << described.out;
}

// By one process and by others than recorded it.
TEST_F(DistributedCommand, ReplaysOnAnyNumberOfRanks) {
  const std::string of_ranks = path("of_ranks.scree"), of_one = path("of_one.scree");
  ASSERT_EQ(mpirun(3, kScene + "--keyframes 25 --record '" + of_ranks + "'").exit_code, 0);
  const Outcome one = scree(kScene + "--keyframes 25 --record '" + of_one + "'");
  const std::string hash = hash_of(one);
  const std::string replay = "'" SCREE_COMMAND "' replay --distributed --threads 1 --quiet --json - ";
  for (const std::string& file : {of_ranks, of_one}) {
    for (const std::string options : {" --verify", " --from 30", " --from 7 --to 60 --verify"}) {
      const Outcome outcome = launch(2, replay + "'" + file + "'" + options);
      ASSERT_EQ(hash_of(outcome), hash) << options;
      const nlohmann::json figures = nlohmann::json::parse(outcome.out);
      EXPECT_EQ(figures["ranks"], 2);
      EXPECT_EQ(figures["recorded_hash"], hash);
      EXPECT_EQ(figures["verified"], options.find("--verify") != std::string::npos);
    }
  }
  const auto refused = [&](const std::string& arguments, const std::string& reason) {
    const Outcome outcome = launch(2, replay + arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_NE(outcome.err.find(reason), std::string::npos) << arguments << "\n" << outcome.err;
    return outcome.err;
  };
  const auto refused_once = [&](const std::string& arguments, const std::string& reason) {
    const std::string told = refused(arguments, reason);
    EXPECT_EQ(told.find(reason), told.rfind(reason)) << "told more than once: " << told;
  };
  refused_once("/no/such/recording", "/no/such/recording: cannot be read");
  refused_once("'" + of_one + "' --from 9 --to 8", "--from 9 must not be beyond --to 8");
  refused("'" + of_one + "' --from 61", "step is 61, must lie in [0, 60]");
  refused("'" + of_one + "' --to 61", "--to 61 must be from 0 to 60");
  refused("'" + of_one + "' --trace x", "not with --distributed");
}

// Bodies that come after the checkpoint, go after it, or are driven, are those of a run that nothing has
// ended.
TEST_F(DistributedCommand, GoesOnFromACheckpointWhereBodiesComeAndGo) {
  for (const std::string scene : {"spawning --set bodies=20 --set life=30", "drum --set bodies=60"}) {
    const std::string file = path("changing.checkpoint"), run_of = scene + " --quiet --json - --steps ";
    const std::string expected = hash_of(scree(run_of + "100"));
    const Outcome first = mpirun(2, run_of + "60 --checkpoint-steps 50 --checkpoint '" + file + "'");
    ASSERT_EQ(first.exit_code, 0) << first.err;
    EXPECT_EQ(hash_of(scree(run_of + "100 --resume '" + file + "'")), expected) << scene;
    EXPECT_EQ(hash_of(mpirun(3, run_of + "100 --resume '" + file + "'")), expected) << scene;
  }
}

// A rank is killed after the first checkpoint; what goes on from the last one, on another number of ranks,
// has the hash of a run that nothing has ended.
TEST_F(DistributedCommand, GoesOnFromTheLastCheckpointWhereARankWasKilled) {
  const std::string file = path("ranks.checkpoint"), process = path("rank_1"), script = path("rank.sh");
  const std::string pile = "pile --set bodies=300 --quiet --json - ";
  std::ofstream(script) << "test \"$OMPI_COMM_WORLD_RANK\" != 1 || echo $$ > '" << process << "'\n"
                        << "exec '" SCREE_COMMAND "' run --distributed --threads 1 --steps 100000000 " << pile
                        << "--checkpoint '" << file << "' --checkpoint-steps 40\n";
  const std::string kill =
      "(until [ -e '" + file + "' ]; do sleep 0.05; done; kill -9 $(cat '" + process + "')) & ";
  const Outcome killed = run("{ " + kill + launch_line(3, "sh '" + script + "'") + "; }");
  EXPECT_NE(killed.exit_code, 0);
  EXPECT_NE(killed.err.find("rank 1 (process "), std::string::npos) << killed.err;
  const std::string told = "the last checkpoint is " + file + ", after step ";
  const std::size_t at = killed.err.find(told);
  ASSERT_NE(at, std::string::npos) << killed.err;
  const int steps = std::stoi(killed.err.substr(at + told.size())) + 60;
  const std::string all_steps = pile + "--steps " + std::to_string(steps);
  const std::string expected = hash_of(scree(all_steps));
  const std::string go_on = all_steps + " --resume '" + file + "'";
  EXPECT_EQ(hash_of(mpirun(2, go_on)), expected);
  EXPECT_EQ(hash_of(scree(go_on)), expected);
}

}  // namespace
