// Laws of the engine behind pages: what is asked for comes, in order, and nobody's mistake stops the others.
#include <tests/parallel/recording/recording_fixture.h>
#include <tests/tools/recordings.h>
#include <tests/tools/view/frames.h>
#include <tools/view/engine.h>

#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <mutex>
#include <optional>
#include <string>

namespace scree::view {
namespace {

using test::TemporaryFile;

// An engine, and all that its pages have been told.
class Theater {
 public:
  explicit Theater(std::vector<Opening> openings)
      : engine_({.openings = std::move(openings), .threads = 1},
                [this](PageId page, Bytes message, bool is_text) {
                  const std::lock_guard lock(mutex_);
                  told_.push_back({page, std::move(message), is_text});
                  changed_.notify_all();
                }) {}

  Engine& engine() { return engine_; }

  void ask(PageId page, const Json& message) { engine_.ask(page, message.dump()); }
  // The next text of a kind; waits for it.
  Json next(const std::string& kind, PageId page = 1) {
    Json found;
    EXPECT_TRUE(wait([&](const Told& told) {
      if (!told.is_text || told.page != page) return false;
      found = Json::parse(*told.message);
      return found.at("kind") == kind;
    })) << "nothing of the kind "
        << kind;
    return found;
  }
  ReadFrame next_frame(PageId page = 1) {
    std::optional<ReadFrame> found;
    EXPECT_TRUE(wait([&](const Told& told) {
      if (told.is_text || told.page != page || kind_of(*told.message) != 3) return false;
      found.emplace(*told.message);
      return true;
    })) << "no frame";
    return *found;
  }

 private:
  struct Told {
    PageId page;
    Bytes message;
    bool is_text;
  };
  // Takes the first message that fits from the list, and leaves the others.
  template <class Fits>
  bool wait(const Fits& fits) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(60), [&] {
      for (auto told = told_.begin(); told != told_.end(); ++told) {
        if (!fits(*told)) continue;
        told_.erase(told);
        return true;
      }
      return false;
    });
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Told> told_;
  Engine engine_;  // the last: it tells until its end
};

Opening scene_of(const std::string& name, const scenes::Parameters& parameters) {
  return {.name = name, .file = {}, .scene = scenes::build(name, parameters).front()};
}
Opening recording_of(const std::string& file) { return {.name = "recording", .file = file, .scene = {}}; }

Json frames(std::initializer_list<std::uint64_t> steps, std::uint32_t track = 0) {
  Json list = Json::array();
  for (const std::uint64_t step : steps) list.push_back({track, step});
  return {{"ask", "frames"}, {"frames", list}};
}

TEST(ViewEngine, BringsFramesInTheOrderTheyWereAskedFor) {
  TemporaryFile file;
  testing::record_stack(file.path(), 50);
  Theater theater({recording_of(file.path())});
  theater.engine().join(1);
  const Json hello = theater.next("hello");
  EXPECT_EQ(hello.at("tracks").at("tracks").at(0).at("last"), 50);
  theater.ask(1, frames({50, 3, 20, 19}));
  for (const double step : {50.0, 3.0, 20.0, 19.0}) EXPECT_EQ(theater.next_frame().step, step);
}

TEST(ViewEngine, RunsASceneOnWhereAFrameBehindItsEndIsAskedFor) {
  Theater theater({scene_of("stack", {{"bodies", 3}})});
  theater.engine().join(1);
  theater.ask(1, frames({5}));
  EXPECT_EQ(theater.next_frame().step, 5.0);
  const Json past = theater.next("past");
  EXPECT_EQ(past.at("track"), 0);
  theater.ask(1, {{"ask", "run"}, {"track", 0}, {"to", 30}});
  for (std::uint64_t last = 0; last < 30;) {
    const Json more = theater.next("past");
    last = more.at("from").get<std::uint64_t>() + more.at("rows").size() - 1;
  }
}

TEST(ViewEngine, ChangesTheEndOfASceneAndBranchesOffItsPast) {
  Theater theater({scene_of("stack", {{"bodies", 3}})});
  theater.engine().join(1);
  theater.ask(1, frames({20}));
  const ReadFrame before = theater.next_frame();
  const Json ball = {{"kind", "shoot"}, {"from", {0, 9, 0}}, {"toward", {0, -1, 0}}};
  theater.ask(1, {{"ask", "touch"}, {"track", 0}, {"step", 20}, {"what", ball}});
  EXPECT_EQ(theater.next("changed").at("track"), 0);
  theater.ask(1, frames({21}));
  EXPECT_EQ(theater.next_frame().numbers.size(), before.numbers.size() + 1);
  theater.ask(1, {{"ask", "touch"}, {"track", 0}, {"step", 10}, {"what", ball}});
  EXPECT_EQ(theater.next("branched").at("track"), 1);
  const Json parted_before = {{"ask", "parted"}, {"a", 0}, {"b", 1}};
  theater.ask(1, frames({15}, 1));
  EXPECT_EQ(theater.next_frame().numbers.size(), before.numbers.size() + 1);
  theater.ask(1, parted_before);
  EXPECT_EQ(theater.next("parted").at("step"), 11);
}

TEST(ViewEngine, FindsWhereBranchesOfBranchesPart) {
  Theater theater({scene_of("pile", {{"bodies", 20}})});
  theater.engine().join(1);
  theater.ask(1, frames({60}));
  theater.next_frame();
  theater.ask(1, {{"ask", "branch"}, {"track", 0}, {"step", 20}});
  EXPECT_EQ(theater.next("branched").at("track"), 1);
  theater.ask(1, frames({50}, 1));
  theater.next_frame();
  theater.ask(1, {{"ask", "parted"}, {"a", 0}, {"b", 1}});
  EXPECT_TRUE(theater.next("parted").at("step").is_null()) << "nothing was changed";
  const Json lighter = {{"kind", "settings"}, {"gravity", {0, -5, 0}}};
  theater.ask(1, {{"ask", "touch"}, {"track", 1}, {"step", 40}, {"what", lighter}});
  EXPECT_EQ(theater.next("branched").at("track"), 2);
  theater.ask(1, {{"ask", "parted"}, {"a", 2}, {"b", 0}});
  EXPECT_TRUE(theater.next("parted").at("step").is_null()) << "it has not gone on";
  theater.ask(1, frames({45}, 2));
  theater.next_frame();
  for (const std::uint32_t other : {0u, 1u}) {
    theater.ask(1, {{"ask", "parted"}, {"a", 2}, {"b", other}});
    EXPECT_EQ(theater.next("parted").at("step"), 41) << other;
  }
}

TEST(ViewEngine, FindsWhatDiffFinds) {
  TemporaryFile a, b;
  testing::record_stack(a.path(), 50);
  testing::record_stack(b.path(), 40, {}, -12.0f);
  Workers workers(1);
  Player first(a.path()), second(b.path());
  const std::optional<Divergence> expected = compare(first, second, workers);
  ASSERT_TRUE(expected.has_value());
  Theater theater({recording_of(a.path()), recording_of(b.path())});
  theater.engine().join(1);
  EXPECT_TRUE(theater.next("hello").at("compares"));
  theater.ask(1, {{"ask", "parted"}, {"a", 0}, {"b", 1}});
  const Json parted = theater.next("parted");
  EXPECT_EQ(parted.at("step"), expected->step);
  EXPECT_EQ(parted.at("text"), expected->difference);
}

TEST(ViewEngine, GivesPagesThatLookAtDifferentStepsOfATrackTheirFrames) {
  TemporaryFile file;
  testing::record_stack(file.path(), 200);
  Theater theater({recording_of(file.path())});
  theater.engine().join(1);
  theater.engine().join(2);
  const auto ask = [&](PageId page, std::uint64_t step) {
    theater.ask(page, {{"ask", "frames"}, {"frames", {{0, step}}}, {"details", true}, {"shade", 4}});
  };
  for (int i = 0; i < 5; ++i) {
    ask(1, 15);
    ask(2, 195);
    EXPECT_EQ(theater.next_frame(1).step, 15.0);
    EXPECT_EQ(theater.next_frame(2).step, 195.0);
  }
}

TEST(ViewEngine, ShowsTheForcesOfKeyframesHoweverTheyWereGoneTo) {
  TemporaryFile file;
  testing::record_stack(file.path(), 100);  // keyframes at 20, 40 ...
  Theater theater({recording_of(file.path())});
  theater.engine().join(1);
  double sums[2] = {};
  for (const int turn : {0, 1}) {
    Json wanted = {{"ask", "frames"}, {"frames", {{0, 60}}}, {"details", true}, {"shade", 4}};
    if (turn == 0) wanted["frames"] = {{0, 63}, {0, 60}};  // past the keyframe first
    theater.ask(1, wanted);
    ReadFrame frame = theater.next_frame();
    if (turn == 0) frame = theater.next_frame();
    EXPECT_EQ(frame.step, 60.0);
    for (const float force : frame.values) sums[turn] += static_cast<double>(force);
  }
  EXPECT_GT(sums[0], 1000.0);
  EXPECT_EQ(sums[0], sums[1]);
}

TEST(ViewEngine, TellsANewPageOfTheSettingsAtTheEnd) {
  Theater theater({scene_of("stack", {{"bodies", 2}})});
  theater.engine().join(1);
  theater.ask(1, frames({30}));
  theater.next_frame();
  theater.ask(1, {{"ask", "touch"},
                  {"track", 0},
                  {"step", 30},
                  {"what", {{"kind", "settings"}, {"gravity", {0, -1, 0}}}}});
  const auto gravity_in = [](const nlohmann::json& message) {
    return message.at("tracks").at(0).at("settings").at("gravity").at(1).get<double>();
  };
  EXPECT_EQ(gravity_in(theater.next("tracks")), -1.0) << "those that are there are told";
  theater.next("changed");
  theater.ask(1, frames({40, 5}));
  theater.next_frame();
  theater.next_frame();
  theater.engine().join(2);
  EXPECT_EQ(gravity_in(theater.next("hello", 2).at("tracks")), -1.0);
}

TEST(ViewEngine, LeavesNoBranchOfATouchThatCannotBe) {
  Theater theater({scene_of("stack", {{"bodies", 2}})});
  theater.engine().join(1);
  theater.ask(1, frames({30}));
  theater.next_frame();
  const Json wrong = {{"kind", "delete"}, {"body", 99999}};
  theater.ask(1, {{"ask", "touch"}, {"track", 0}, {"step", 10}, {"what", wrong}});
  theater.next("error");
  theater.ask(1, {{"ask", "branch"}, {"track", 0}, {"step", 10}});
  EXPECT_EQ(theater.next("branched").at("track"), 1) << "the first one";
}

TEST(ViewEngine, DoesNotHoldBodiesInBranches) {
  Theater theater({scene_of("pile", {{"bodies", 10}})});
  theater.engine().join(1);
  theater.ask(1, {{"ask", "frames"}, {"frames", {{0, 0}}}});
  theater.next_frame();
  std::uint32_t body = 0;
  const scenes::Stage stage({scenes::build("pile", {{"bodies", 10}}).front()});
  const World& world = stage.worlds().front();
  for (std::uint32_t i = 0; i < world.poses().size(); ++i) {
    if (world.is_alive(world.body_at(i)) && world.body_type(world.body_at(i)) == BodyType::dynamic) body = i;
  }
  const Json hold = {{"kind", "drag"}, {"body", body}, {"point", {0, 30, 0}}};
  theater.ask(1, {{"ask", "touch"}, {"track", 0}, {"step", 0}, {"what", hold}});
  theater.next("changed");
  theater.ask(1, {{"ask", "frames"}, {"frames", {{0, 20}}}, {"details", true}});
  EXPECT_EQ(theater.next_frame().joints.size(), 12u);
  theater.ask(1, {{"ask", "branch"}, {"track", 0}, {"step", 15}});
  theater.next("branched");
  theater.ask(1, {{"ask", "frames"}, {"frames", {{1, 18}}}, {"details", true}});
  EXPECT_TRUE(theater.next_frame().joints.empty());
}

TEST(ViewEngine, FindsNoPartingInABranchOfARecordingThatWasNotChanged) {
  TemporaryFile file;
  testing::record_stack(file.path(), 100);  // whose keyframes have no measures of contacts
  Theater theater({recording_of(file.path())});
  theater.engine().join(1);
  theater.ask(1, {{"ask", "branch"}, {"track", 0}, {"step", 30}});
  theater.next("branched");
  theater.ask(1, frames({100}, 1));
  theater.next_frame();
  theater.ask(1, {{"ask", "parted"}, {"a", 1}, {"b", 0}});
  EXPECT_TRUE(theater.next("parted").at("step").is_null());
}

TEST(ViewEngine, BranchesWithTheTimeStepOfTheStep) {
  TemporaryFile file;
  {
    World world;
    world.add_shape(world.create_body({.position = {0.0f, 50.0f, 0.0f}}), Sphere{});
    Workers workers(1);
    Recorder recorder(world, file.path());
    for (int i = 0; i < 40; ++i) step(world, i < 10 ? 1.0f / 60.0f : 1.0f / 240.0f, workers);
    recorder.finish();
  }
  Theater theater({recording_of(file.path())});
  theater.engine().join(1);
  theater.ask(1, {{"ask", "branch"}, {"track", 0}, {"step", 20}});
  theater.next("branched");
  theater.ask(1, frames({40}, 1));
  theater.next_frame();
  theater.ask(1, {{"ask", "parted"}, {"a", 0}, {"b", 1}});
  EXPECT_TRUE(theater.next("parted").at("step").is_null());
}

TEST(ViewEngine, RefusesToBranchWhereStepsWereCountedAnew) {
  TemporaryFile file;
  {
    World world;
    world.add_shape(world.create_body({.position = {0.0f, 50.0f, 0.0f}}), Sphere{});
    Workers workers(1);
    Recorder recorder(world, file.path());
    Snapshot snapshot;
    for (int i = 0; i < 40; ++i) {
      if (i == 10) save(world, snapshot);
      if (i == 30) restore(world, snapshot);
      step(world, 1.0f / 60.0f, workers);
    }
    recorder.finish();
  }
  Theater theater({recording_of(file.path())});
  theater.engine().join(1);
  theater.ask(1, {{"ask", "branch"}, {"track", 0}, {"step", 35}});
  EXPECT_NE(theater.next("error").at("text").get<std::string>().find("restored"), std::string::npos);
  theater.ask(1, {{"ask", "branch"}, {"track", 0}, {"step", 25}});
  theater.next("branched");
}

TEST(ViewEngine, TellsAPageOfItsMistakesAndGoesOn) {
  Theater theater({scene_of("stack", {{"bodies", 3}})});
  theater.engine().join(1);
  theater.engine().join(2);
  const Json mistakes[] = {
      {{"ask", "frames"}},
      {{"ask", "frames"}, {"frames", {{9, 0}}}},
      {{"ask", "frames"}, {"frames", {{0, -5}, {0}}}},
      {{"ask", "frames"}, {"frames", Json::array()}, {"shade", 77}},
      {{"ask", "branch"}, {"track", 0}, {"step", 12345}},
      {{"ask", "touch"}, {"track", 0}, {"step", 0}, {"what", {{"kind", "delete"}, {"body", 99999}}}},
      {{"ask", "touch"}, {"track", 0}, {"step", 0}},
      {{"ask", "name"}, {"track", 0}, {"name", 7}},
      {{"ask", "run"}, {"track", 4}, {"to", 9}},
      {{"ask", "wish"}},
      Json::array({1, 2}),
  };
  for (const Json& mistake : mistakes) {
    theater.ask(1, mistake);
    EXPECT_FALSE(theater.next("error").at("text").get<std::string>().empty()) << mistake;
  }
  theater.engine().ask(1, "no JSON \xff");
  theater.next("error");
  theater.engine().ask(77, "of a page that is not there");
  theater.ask(2, frames({2}));
  EXPECT_EQ(theater.next_frame(2).step, 2.0);
}

TEST(ViewEngine, LetsGoOfWhatAPageHeldWhenItLeaves) {
  Theater theater({scene_of("stack", {{"bodies", 3}})});
  theater.engine().join(1);
  theater.engine().join(2);
  theater.ask(1, {{"ask", "frames"}, {"frames", {{0, 0}}}, {"details", true}});
  const ReadFrame before = theater.next_frame();
  EXPECT_TRUE(before.joints.empty());
  const scenes::Scene scene = scenes::build("stack", {{"bodies", 3}}).front();
  scenes::Stage stage({scene});
  std::uint32_t body = 0;
  for (std::uint32_t i = 0; i < stage.worlds().front().poses().size(); ++i) {
    const BodyId each = stage.worlds().front().body_at(i);
    if (stage.worlds().front().is_alive(each) && stage.worlds().front().body_type(each) == BodyType::dynamic)
      body = i;
  }
  theater.ask(1, {{"ask", "touch"},
                  {"track", 0},
                  {"step", 0},
                  {"what", {{"kind", "drag"}, {"body", body}, {"point", {0, 1, 0}}}}});
  theater.next("changed");
  theater.ask(2, {{"ask", "frames"}, {"frames", {{0, 1}}}, {"details", true}});
  EXPECT_EQ(theater.next_frame(2).joints.size(), 12u);
  theater.engine().leave(1);
  theater.ask(2, {{"ask", "frames"}, {"frames", {{0, 2}}}, {"details", true}});
  EXPECT_TRUE(theater.next_frame(2).joints.empty());
}

TEST(ViewEngine, GivesRecordingsThatPlay) {
  Theater theater({scene_of("pile", {{"bodies", 20}})});
  theater.engine().join(1);
  theater.ask(1, frames({30}));
  theater.next_frame();
  std::promise<std::string> promise;
  theater.engine().copy_recording(0, [&](std::string bytes, const std::string& error) {
    EXPECT_EQ(error, "");
    promise.set_value(std::move(bytes));
  });
  const std::string bytes = promise.get_future().get();
  Player player(std::as_bytes(std::span(bytes)));
  EXPECT_EQ(player.info().last_step, 30u);
  Workers workers(1);
  EXPECT_FALSE(player.verify(0, 30, workers).has_value());
  std::promise<std::string> refused;
  theater.engine().copy_recording(
      8, [&](std::string, std::string error) { refused.set_value(std::move(error)); });
  EXPECT_NE(refused.get_future().get(), "");
}

// A place for temporary files, where no other program puts any.
class OwnTemporaryFolder {
 public:
  OwnTemporaryFolder() : path_(std::filesystem::path(::testing::TempDir()) / "scree_leaves_no_files") {
    if (const char* before = std::getenv("TMPDIR")) before_ = before;
    std::filesystem::create_directories(path_);
    setenv("TMPDIR", path_.c_str(), 1);
  }
  ~OwnTemporaryFolder() {
    if (before_) {
      setenv("TMPDIR", before_->c_str(), 1);
    } else {
      unsetenv("TMPDIR");
    }
    std::filesystem::remove_all(path_);
  }
  OwnTemporaryFolder(const OwnTemporaryFolder&) = delete;
  OwnTemporaryFolder& operator=(const OwnTemporaryFolder&) = delete;

 private:
  std::filesystem::path path_;
  std::optional<std::string> before_;
};

TEST(ViewEngine, LeavesNoFilesBehind) {
  const OwnTemporaryFolder own;
  const auto count = [] {
    int folders = 0;
    for (const auto& each : std::filesystem::directory_iterator(std::filesystem::temp_directory_path()))
      folders += each.path().filename().string().starts_with("scree-view-");
    return folders;
  };
  const int before = count();
  {
    Theater theater({scene_of("stack", {{"bodies", 2}})});
    theater.engine().join(1);
    theater.next("hello");
    EXPECT_GE(count(), before + 1);
  }
  EXPECT_LE(count(), before);
  EXPECT_ANY_THROW(Theater({recording_of("/nowhere/nothing.scree")}));
  EXPECT_LE(count(), before);
}

}  // namespace
}  // namespace scree::view
