// Laws of scree_bench_scenes and bench/plot, run as programs: their output and their refusals.
#include <scree/stats.h>
#include <tests/run_program.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

namespace {

namespace fs = std::filesystem;

using scree::testing::Outcome;
using scree::testing::read_file;

class BenchProgram : public scree::testing::ProgramTest {
 protected:
  Outcome bench(const std::string& arguments) { return run("'" SCREE_BENCH_PROGRAM "' " + arguments); }

  nlohmann::json figures(const std::string& arguments, int repeats = 1) {
    const fs::path file = folder_ / "figures.json";
    const Outcome outcome = bench("--engines scree --repeats " + std::to_string(repeats) + " --json '" +
                                  file.string() + "' " + arguments);
    EXPECT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.err;
    return nlohmann::json::parse(read_file(file));
  }

  void expect_refusal(const std::string& arguments, const std::string& reason) {
    const Outcome outcome = bench(arguments);
    EXPECT_NE(outcome.exit_code, 0) << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_NE(outcome.err.find(reason), std::string::npos) << arguments << "\n" << outcome.err;
  }
};

TEST_F(BenchProgram, WritesFiguresOfEveryEntry) {
  const nlohmann::json json =
      figures("--scenes stack:bodies=4,wall:columns=3:rows=2 --threads 1,2 --steps 5");
  EXPECT_EQ(json.at("sweep"), "");
  EXPECT_EQ(json.at("engines").at("scree").at("multithreaded"), true);
  ASSERT_EQ(json.at("entries").size(), 4u);
  for (const nlohmann::json& entry : json.at("entries")) {
    EXPECT_GT(entry.at("ms_per_step").get<double>(), 0.0);
    EXPECT_EQ(entry.at("engine"), "scree");
    EXPECT_EQ(entry.at("phases").size(), static_cast<std::size_t>(scree::kPhaseCount));
    EXPECT_EQ(entry.at("repeats").at(0).at("timed_steps"), 4);
    EXPECT_EQ(entry.at("bodies"), entry.at("name") == "stack" ? 4 : 7);
  }
  EXPECT_EQ(json.at("entries").at(0).at("parameters").at("bodies"), 4);
}

TEST_F(BenchProgram, SweepsEverySceneOverAParameter) {
  const nlohmann::json json = figures("--scenes stack,pile --sweep bodies=10,20 --threads 1 --steps 3");
  EXPECT_EQ(json.at("sweep"), "bodies");
  std::multiset<std::string> scenes;
  for (const nlohmann::json& entry : json.at("entries")) scenes.insert(entry.at("scene"));
  EXPECT_EQ(scenes, (std::multiset<std::string>{"stack:bodies=10", "stack:bodies=20", "pile:bodies=10",
                                                "pile:bodies=20"}));
}

TEST_F(BenchProgram, NamesContinuousCollisionInEveryReport) {
  const std::string markdown = (folder_ / "table.md").string();
  const std::string brief = (folder_ / "brief.md").string();
  const nlohmann::json json =
      figures("--scenes stack:bodies=3 --threads 1 --steps 3 --continuous off --markdown '" + markdown +
              "' --brief '" + brief + "'");
  const std::string continuous = json.at("entries").at(0).at("repeats").at(0).at("continuous");
  EXPECT_TRUE(continuous == "off" || continuous == "none") << continuous;
  for (const std::string& file : {markdown, brief}) {
    EXPECT_NE(read_file(file).find("| continuous |"), std::string::npos) << file;
    EXPECT_NE(read_file(file).find("| " + continuous + " |"), std::string::npos) << file;
  }
  EXPECT_NE(read_file(markdown).find("continuous collision: "), std::string::npos);
}

TEST_F(BenchProgram, ReportsTheDriftOfJointsWhereASceneHasAny) {
  const std::string markdown = (folder_ / "table.md").string();
  const auto drift_columns = [&](const std::string& scene) {
    const nlohmann::json json = figures(
        "--scenes " + scene + " --threads 1 --steps 6 --evaluate-every 2 --markdown '" + markdown + "'");
    const bool has = read_file(markdown).find("| drift mean mm | drift max mm |") != std::string::npos;
    const nlohmann::json& entry = json.at("entries").at(0);
    const nlohmann::json& run = entry.at("repeats").at(0);
    EXPECT_LE(run.at("drift_mean").get<double>(), run.at("drift_max").get<double>());
    EXPECT_EQ(entry.at("quality").at("pooled_drift_max").get<double>() > 0.0, has) << scene;
    return std::pair{run.at("drift_joints").get<int>(), has};
  };
  // Down the columns 4 x 2, along the rows 2 x 3: the upper row cannot move.
  EXPECT_EQ(drift_columns("joint_grid:columns=4:rows=3"), (std::pair{14, true}));
  EXPECT_EQ(drift_columns("stack:bodies=3"), (std::pair{0, false}));
}

TEST_F(BenchProgram, DrivesBodiesLikeTheCommandDoes) {
  // The pusher moves in the same way in both programs, so that both give the same bits in every run.
  const std::string arguments = "--scenes junkyard:columns=2:layers=1 --threads 1 --steps 4";
  const nlohmann::json first = figures(arguments).at("entries").at(0).at("repeats").at(0);
  const nlohmann::json again = figures(arguments).at("entries").at(0).at("repeats").at(0);
  EXPECT_EQ(first.at("bits"), again.at("bits"));
  EXPECT_EQ(first.at("bodies"), 4);
}

TEST_F(BenchProgram, EveryEngineRunsScenesOfMeshesJointsAndCompoundsOrSaysWhyNot) {
  const fs::path file = folder_ / "figures.json";
  const Outcome outcome =
      run("'" SCREE_BENCH_PROGRAM
          "' --scenes terrain:bodies=12:triangles=800,height_field:bodies=12:cells=400,"
          "ragdoll_rain:ragdolls=1:triangles=200,wheel_pile:wheels=2,drum:bodies=30,"
          "bullets:bullets=8:columns=3:rows=2 --steps 90 --threads 1 --repeats 1 --json '" +
          file.string() + "'");
  const nlohmann::json json = nlohmann::json::parse(read_file(file));
  EXPECT_EQ(outcome.err.find("killed"), std::string::npos) << outcome.err;
  std::set<std::string> engines;
  for (const nlohmann::json& entry : json.at("entries")) {
    const std::string who = entry.at("engine").get<std::string>() + " on " + entry.at("scene").dump();
    const nlohmann::json& one = entry.at("repeats").at(0);
    engines.insert(entry.at("engine"));
    const std::string error = one.at("error");
    if (!error.empty()) {
      EXPECT_NE(entry.at("engine"), "scree") << error;
      EXPECT_NE(error.find("does not support "), std::string::npos) << who << ": " << error;
      continue;
    }
    EXPECT_EQ(one.at("complaint"), "") << who;
    EXPECT_LE(one.at("awake").get<int>(), one.at("bodies").get<int>()) << who;
    if (entry.at("scene").get<std::string>().rfind("bullets", 0) == 0) continue;  // they are to fly off
    EXPECT_EQ(one.at("bodies_left"), 0) << who;
    EXPECT_LT(one.at("penetration_mean").get<double>(), 0.05) << who;
    if (one.at("drift_joints").get<int>() > 0) {
      EXPECT_LT(one.at("drift_mean").get<double>(), 0.05) << who;
    }
  }
  EXPECT_EQ(engines.count("scree"), 1u);
}

TEST_F(BenchProgram, PatienceLimitsTheRepeatsOfSlowEntries) {
  const auto runs = [&](const std::string& arguments) {
    return figures("--scenes stack:bodies=3 --steps 5 --threads 1 " + arguments, 3)
        .at("entries")
        .at(0)
        .at("repeats")
        .size();
  };
  EXPECT_EQ(runs("--patience 1e-9"), 1u);
  EXPECT_EQ(runs("--patience 1000"), 3u);
}

TEST_F(BenchProgram, RefusesWhatItCannotMeasureBeforeItMeasures) {
  expect_refusal("--scenes nowhere", "unknown scene \"nowhere\"; there are: large_pyramid");
  expect_refusal("--scenes stack:height=3", "scene stack has no parameter \"height\"");
  expect_refusal("--scenes stack:bodies=0", "bodies = 0 must be from 1");
  expect_refusal("--scenes stack:bodies", "\"bodies\" is not key=value");
  expect_refusal("--scenes stack:bodies=many", "\"many\" is not a finite number");
  expect_refusal("--scenes stack:bodies=2:bodies=3", "bodies is given twice");
  expect_refusal("--scenes convex_pile:layers=0", "layers = 0 must be from 1");
  expect_refusal("--scenes junkyard:columns=22", "columns = 22 must be from 1 to 21");
  expect_refusal("--scenes hull_zoo:max_vertices=257", "max_vertices = 257 must be from 4 to 256");
  expect_refusal("--scenes stack --sweep bodies", "expected key=value,value");
  expect_refusal("--scenes stack --sweep bodies=", "expected key=value,value");
  expect_refusal("--scenes stack --sweep bodies=2,x", "\"x\" is not a finite number");
  expect_refusal("--scenes stack --sweep height=2", "no parameter \"height\"");
  expect_refusal("--continuous sometimes", "sometimes");
  expect_refusal("--engines none", "unknown engine none");
  expect_refusal("--threads 0", "0");
  expect_refusal("--scenes stack --json /no/such/folder/x.json", "x.json: cannot be written: No such file");
}

TEST_F(BenchProgram, NeverWritesOneFileTwiceAndWritesNoneIfNothingIsMeasured) {
  const std::string file = (folder_ / "figures").string();
  expect_refusal("--json " + file + " --markdown " + file, "is the same file as --markdown " + file);
  expect_refusal("--json ''", "the name of the file is empty");
  std::ofstream(file) << "old";
  expect_refusal("--scenes nowhere --json " + file, "unknown scene");
  EXPECT_EQ(read_file(file), "old");
}

TEST_F(BenchProgram, ReportsThatItsOutputWasLost) {
  for (const char* arguments : {"--list", "--help"}) {
    const Outcome outcome = run(std::string("( '" SCREE_BENCH_PROGRAM "' ") + arguments + " > /dev/full )");
    EXPECT_EQ(outcome.exit_code, 1) << arguments;
    EXPECT_NE(outcome.err.find("standard output cannot be written: No space left"), std::string::npos);
  }
}

TEST_F(BenchProgram, PlotsAreTheSameFromRunToRunAndBadFiguresAreRefused) {
  ASSERT_EQ(run("/usr/bin/python3 -c 'import matplotlib'").exit_code, 0) << "install python3-matplotlib";
  const Outcome outcome = run("'" SCREE_BENCH_PLOT "' --self-test");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("the same from run to run"), std::string::npos);
}

TEST_F(BenchProgram, AccuracyRunsEveryEngineThatIsThere) {
  const Outcome outcome =
      run("'" SCREE_BENCH_ACCURACY "' --quiet --cases slide_to_roll,rolling --dt 0.01 --json -");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json.at("entries").at(0).at("engine"), "scree");
  for (const nlohmann::json& entry : json.at("entries")) {
    // Every adapter can push and roll balls but ODE's, which has no forces.
    if (entry.contains("refusal")) continue;
    const double error = entry.at("errors").at(entry.at("case") == "rolling" ? "velocity" : "speed");
    EXPECT_LT(error, 0.1) << entry.dump();
  }
  const Outcome refusal = run("'" SCREE_BENCH_ACCURACY "' --engines steam");
  EXPECT_EQ(refusal.exit_code, 2);
  EXPECT_NE(refusal.err.find("unknown engine; there are: scree"), std::string::npos) << refusal.err;
}

TEST_F(BenchProgram, AccuracyPlotsAreTheSameFromRunToRunAndBadFiguresAreRefused) {
  ASSERT_EQ(run("/usr/bin/python3 -c 'import matplotlib'").exit_code, 0) << "install python3-matplotlib";
  const Outcome outcome = run("'" SCREE_ACCURACY_PLOT "' --self-test");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST_F(BenchProgram, TheSummaryHasARowForEachSceneAndNumberOfThreads) {
  const Outcome self_test = run("'" SCREE_BENCH_SUMMARIZE "' --self-test");
  EXPECT_EQ(self_test.exit_code, 0) << self_test.err;
  figures("--scenes pile:bodies=20 --threads 1,2 --steps 3");
  const Outcome summary = run("'" SCREE_BENCH_SUMMARIZE "' '" + (folder_ / "figures.json").string() + "'");
  EXPECT_EQ(summary.exit_code, 0) << summary.err;
  EXPECT_NE(summary.out.find("| pile:bodies=20 | 1 | "), std::string::npos) << summary.out;
  EXPECT_NE(summary.out.find("| pile:bodies=20 | 2 | "), std::string::npos) << summary.out;
}

}  // namespace
