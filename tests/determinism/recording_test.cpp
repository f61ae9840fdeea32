// Laws of recordings: made on one backend, they verify on all others, for every scene and for random calls.
#include <gtest/gtest.h>
#include <tests/determinism/golden.h>
#include <tests/determinism/many_threads.h>
#include <tests/determinism/player.h>
#include <unistd.h>

#include <filesystem>
#include <memory>

namespace scree::determinism {
namespace {

// Recordings of one test's worlds; the destructor deletes them.
class Folder {
 public:
  Folder()
      : path_(std::filesystem::temp_directory_path() / ("scree_recordings_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string file(std::size_t number) const { return (path_ / std::to_string(number)).string(); }

 private:
  std::filesystem::path path_;
};

// Verifies with another backend at every step.
std::string verdict(scree::Player& player, const Schedule& schedule) {
  Shift shift(schedule);
  const RecordingInfo& info = player.info();
  for (std::uint64_t step = info.first_step; step < info.last_step; ++step) {
    const auto found = player.verify(step, step + 1, shift.at(static_cast<int>(step - info.first_step)));
    if (found) {
      return name_of(schedule) + ", step " + std::to_string(found->step) + ": " + hex(found->actual_hash) +
             " instead of " + hex(found->expected_hash) + "; " + found->difference;
    }
  }
  return {};
}

class Recordings : public ManyThreads, public ::testing::WithParamInterface<Golden> {};

TEST_P(Recordings, OfOneBackendVerifyOnTheOthers) {
  const SceneCase& what = GetParam().what;
  const Folder folder;
  Playback playback(what);
  Shift wide({{supported_isas().back(), 3}});
  {
    std::vector<Recorder> recorders;
    for (std::size_t world = 0; world < playback.worlds().size(); ++world) {
      recorders.emplace_back(playback.worlds()[world], folder.file(world),
                             RecorderOptions{.keyframe_spacing = 60});
    }
    for (int i = 0; i < what.steps; ++i) playback.advance(wide.at(i));
    for (Recorder& recorder : recorders) recorder.finish();
  }
  EXPECT_EQ(playback.hash(), GetParam().digest.last) << "recording has changed the motion";
  for (std::size_t world = 0; world < playback.worlds().size(); ++world) {
    scree::Player player(folder.file(world));
    EXPECT_EQ(player.info().last_step, static_cast<std::uint64_t>(what.steps));
    for (const Schedule& schedule : {Schedule{kReference}, schedules(false).back()}) {
      ASSERT_EQ(verdict(player, schedule), "");
    }
    EXPECT_EQ(first_difference(playback.worlds()[world], player.world()), "");
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Recordings, ::testing::ValuesIn(scene_goldens()), kGoldenName);

class RandomRecordings : public ManyThreads, public ::testing::WithParamInterface<std::uint64_t> {};

TEST_P(RandomRecordings, HoldEveryEffectOfCalls) {
  const Sequence sequence = random_sequence(GetParam(), 200, 24);
  const Folder folder;
  Shift shift(schedules(false).back());
  std::unique_ptr<Recorder> recorder;
  Snapshot snapshot;
  int steps = 0;
  {
    // The player reads all bodies around each step, which must leave no trace.
    Player player(shift, true, nullptr);
    player.stay_in_one_world();
    player.before_steps([&](World& world) {
      if (recorder == nullptr) {
        recorder = std::make_unique<Recorder>(world, folder.file(0), RecorderOptions{.keyframe_spacing = 25});
      }
      if (++steps % 40 != 10) return;
      save(world, snapshot);
      step(world, 0.01f, shift.at(steps));
      restore(world, snapshot);
    });
    for (const Call& call : sequence) player.make(call);
    recorder->finish();
  }
  scree::Player player(folder.file(0));
  EXPECT_GE(player.info().last_step, static_cast<std::uint64_t>(steps));
  EXPECT_GT(player.info().keyframes, 3u);
  EXPECT_EQ(verdict(player, {kReference}), "");
  // Also from the middle.
  const std::uint64_t middle = (player.info().first_step + player.info().last_step) / 2;
  Workers workers(2);
  player.seek(middle, workers);
  EXPECT_FALSE(player.verify(middle, player.info().last_step, workers));
}

std::uint64_t seeds() { return wish("SCREE_RANDOM_SEQUENCES", wants_all_sequences() ? 20 : 4); }
INSTANTIATE_TEST_SUITE_P(Seeds, RandomRecordings, ::testing::Range(std::uint64_t{1}, seeds() + 1),
                         ::testing::PrintToStringParamName());

}  // namespace
}  // namespace scree::determinism
