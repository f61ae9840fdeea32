// Laws of timelines that the command writes: they are what viewers open, zones lie within each other, and
// nothing is left out without a word.
#include <scree/scree.h>
#include <tests/run_program.h>
#include <tools/command/trace.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace {

using scree::testing::Outcome;
using scree::testing::read_file;

class TraceCommand : public scree::testing::ProgramTest {
 protected:
  Outcome scree(const std::string& arguments) { return run("'" SCREE_COMMAND "' " + arguments); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  nlohmann::json events_of(const std::string& name) const {
    return nlohmann::json::parse(read_file(folder_ / name)).at("traceEvents");
  }
};

std::map<std::string, int> count_by(const nlohmann::json& events, const char* key) {
  std::map<std::string, int> counts;
  for (const nlohmann::json& event : events) {
    if (event.contains(key)) ++counts[event.at(key).get<std::string>()];
  }
  return counts;
}

// Of one thread: whether each zone ends before the one around it does.
bool nests(const nlohmann::json& events) {
  constexpr double kRounding = 0.002;  // us, of two numbers of three decimals
  std::map<int, std::vector<double>> ends;
  for (const nlohmann::json& event : events) {
    if (event.at("ph") != "X") continue;
    std::vector<double>& open = ends[event.at("tid").get<int>()];
    const double begin = event.at("ts"), end = begin + event.at("dur").get<double>();
    while (!open.empty() && open.back() <= begin + kRounding) open.pop_back();
    if (!open.empty() && end > open.back() + kRounding) return false;
    open.push_back(end);
  }
  return true;
}

TEST_F(TraceCommand, OfARunHasItsStepsPhasesAndCounters) {
  const Outcome outcome = scree("run pile --set bodies=200 --steps 90 --threads 2 --quiet --trace " +
                                path("run.trace") + " --json " + path("run.json"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("trace"), std::string::npos);
  const nlohmann::json events = events_of("run.trace");
  std::map<std::string, int> kinds = count_by(events, "cat"), names = count_by(events, "name");
  EXPECT_EQ(kinds["step"], 90);
  EXPECT_GT(kinds["stage"], 500);
  EXPECT_GT(kinds["chunk"], kinds["stage"]);
  for (const char* name : {"find_pairs", "collide", "solve", "finish_step", "relax", "integrate_poses",
                           "contacts", "awake bodies", "islands", "colors", "lane fill", "thread_name"}) {
    EXPECT_GT(names[name], 0) << name;
  }
  EXPECT_TRUE(nests(events));
  const nlohmann::json figures = nlohmann::json::parse(read_file(folder_ / "run.json"));
  const Outcome plain = scree("run pile --set bodies=200 --steps 90 --threads 2 --quiet --json -");
  EXPECT_EQ(nlohmann::json::parse(plain.out).at("hash"), figures.at("hash"));
  EXPECT_EQ(figures.at("trace").at("left_out"), 0);
  EXPECT_EQ(figures.at("trace").at("zones"),
            kinds["step"] + kinds["phase"] + kinds["stage"] + kinds["chunk"]);
  std::vector<double> contacts;
  for (const nlohmann::json& event : events) {
    if (event.at("ph") == "C" && event.at("name") == "contacts")
      contacts.push_back(event.at("args").at("contacts").get<double>());
  }
  ASSERT_EQ(contacts.size(), 90u);
  EXPECT_EQ(contacts.back(), figures.at("contacts").get<double>());
}

TEST_F(TraceCommand, OfAReplayHasItsSteps) {
  ASSERT_EQ(scree("run stack --steps 20 --quiet --record " + path("stack.scree")).exit_code, 0);
  ASSERT_EQ(scree("replay " + path("stack.scree") + " --quiet --trace " + path("replay.trace")).exit_code, 0);
  EXPECT_EQ(count_by(events_of("replay.trace"), "cat")["step"], 20);
  EXPECT_EQ(count_by(events_of("replay.trace"), "name")["contacts"], 20);
  ASSERT_EQ(
      scree("replay " + path("stack.scree") + " --verify --quiet --trace " + path("verify.trace")).exit_code,
      0);
  EXPECT_GE(count_by(events_of("verify.trace"), "cat")["step"], 20);
}

TEST_F(TraceCommand, ThatCannotBeWrittenIsRefusedBeforeTheRun) {
  const Outcome outcome = scree("run pile --quiet --trace " + path("absent/run.trace"));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("--trace"), std::string::npos) << outcome.err;
  const Outcome same = scree("run pile --quiet --trace " + path("a") + " --json " + path("a"));
  EXPECT_EQ(same.exit_code, 2) << same.err;
}

TEST_F(TraceCommand, OfManyWorldsNests) {
  ASSERT_EQ(scree("run many_worlds --set bodies=20 worlds=3 --steps 20 --threads 2 --quiet --trace " +
                  path("worlds.trace"))
                .exit_code,
            0);
  const nlohmann::json events = events_of("worlds.trace");
  EXPECT_EQ(count_by(events, "cat")["step"], 60);
  EXPECT_TRUE(nests(events));
}

TEST_F(TraceCommand, OfPartOfAReplayIsOfThatPart) {
  ASSERT_EQ(scree("run stack --steps 20 --quiet --record " + path("stack.scree")).exit_code, 0);
  ASSERT_EQ(
      scree("replay " + path("stack.scree") + " --from 12 --to 17 --quiet --trace " + path("part.trace"))
          .exit_code,
      0);
  EXPECT_EQ(count_by(events_of("part.trace"), "cat")["step"], 5);
}

TEST_F(TraceCommand, GoesToNoStandardStream) {
  const Outcome outcome = scree("run stack --steps 2 --quiet --trace /dev/stdout");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("--trace /dev/stdout: is where standard output goes"), std::string::npos)
      << outcome.err;
}

TEST(Trace, ThatIsFullRecordsNothingMoreAndSaysSo) {
  constexpr std::size_t kMost = 100;
  scree::command::Trace trace(kMost);
  scree::Workers workers({.threads = 1, .zones = trace.hooks()});
  scree::World world;
  world.add_shape(world.create_body({}), scree::Sphere{});
  for (int i = 0; i < 50; ++i) {
    scree::step(world, 1.0f / 60.0f, workers);
    trace.count({&world.stats()});
  }
  const scree::command::TraceFigures figures = trace.finish("full.trace");
  const nlohmann::json events = nlohmann::json::parse(figures.json).at("traceEvents");
  std::map<std::string, int> kinds = count_by(events, "cat");
  EXPECT_GT(kinds["step"], 0);
  EXPECT_GT(kinds["stage"], 0);
  EXPECT_EQ(kinds["step"] + kinds["phase"] + kinds["stage"] + kinds["chunk"], static_cast<int>(kMost));
  EXPECT_LT(count_by(events, "name")["contacts"], 50);
  EXPECT_EQ(figures.zones, kMost);
  EXPECT_GT(figures.left_out, 0u);
  EXPECT_NE(trace_row(figures).find("left out"), std::string::npos);
}

TEST(Trace, LeavesOutWhatIsDeeperThanItCanHold) {
  scree::command::Trace trace;
  const scree::ZoneHooks hooks = trace.hooks();
  constexpr int kDeep = 40;
  for (int i = 0; i < kDeep; ++i) hooks.begin(hooks.context, {scree::ZoneKind::stage, "deep", i});
  for (int i = kDeep; i-- > 0;) hooks.end(hooks.context, {scree::ZoneKind::stage, "deep", i});
  const scree::command::TraceFigures figures = trace.finish("deep.trace");
  const nlohmann::json events = nlohmann::json::parse(figures.json).at("traceEvents");
  EXPECT_EQ(figures.zones + figures.left_out, static_cast<std::uint64_t>(kDeep));
  std::int64_t next = 0;  // outer ones first, also within a tick of the clock
  for (const nlohmann::json& event : events) {
    if (event.at("ph") == "X") {
      EXPECT_EQ(event.at("args").at("chunks"), next++);
    }
  }
  EXPECT_EQ(next, static_cast<std::int64_t>(figures.zones));
}

}  // namespace
