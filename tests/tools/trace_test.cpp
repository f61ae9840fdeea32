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

TEST(Trace, ThatIsFullLeavesOutStagesAndChunksAndSaysSo) {
  constexpr std::size_t kMost = 100;
  scree::command::Trace trace(kMost);
  scree::Workers workers({.threads = 1, .zones = trace.hooks()});
  scree::World world;
  world.add_shape(world.create_body({}), scree::Sphere{});
  constexpr int kSteps = 50;
  for (int i = 0; i < kSteps; ++i) scree::step(world, 1.0f / 60.0f, workers);
  const scree::command::TraceFigures figures = trace.finish("full.trace");
  const nlohmann::json events = nlohmann::json::parse(figures.json).at("traceEvents");
  std::map<std::string, int> kinds = count_by(events, "cat");
  EXPECT_EQ(kinds["step"], kSteps);
  EXPECT_GT(kinds["phase"], 8 * kSteps);
  EXPECT_LE(kinds["stage"] + kinds["chunk"], static_cast<int>(kMost));
  EXPECT_GT(figures.left_out, 0u);
  EXPECT_NE(trace_row(figures).find("left out"), std::string::npos);
}

}  // namespace
