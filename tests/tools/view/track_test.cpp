// Laws of tracks: each step is shown as it was, in whatever order one looks; branches share the past.
#include <gtest/gtest.h>
#include <tests/parallel/recording/recording_fixture.h>
#include <tests/tools/recordings.h>
#include <tools/scenes/scene.h>
#include <tools/view/track.h>

#include <map>
#include <random>
#include <utility>

namespace scree::view {
namespace {

using test::TemporaryFile;

const World& state_at(Track& track, std::uint64_t step, Workers& workers) {
  int tries = 0;
  while (!track.approach(step, workers)) {
    if (++tries > 10000) throw std::logic_error("the step is never reached");
  }
  EXPECT_EQ(track.shown_step(), step);
  return track.shown();
}

scenes::Scene small_pile() { return scenes::build("pile", {{"bodies", 40}}).front(); }

TEST(Tracks, OfRecordingsShowEachStepAsItWas) {
  TemporaryFile file;
  testing::record_stack(file.path(), 70);
  Workers workers(1);
  std::map<std::uint64_t, std::uint64_t> hashes;
  {
    Player player(file.path());
    hashes[0] = player.world().hash();
    while (player.step(workers)) hashes[player.position()] = player.world().hash();
  }
  Track track("stack", file.path());
  EXPECT_FALSE(track.is_live());
  EXPECT_EQ(track.last(), 70u);
  std::mt19937 random(5);
  for (int i = 0; i < 60; ++i) {
    const std::uint64_t step = random() % 71;
    ASSERT_EQ(state_at(track, step, workers).hash(), hashes.at(step)) << step;
    if (i % 3 == 0) track.look_ahead(workers);
  }
}

TEST(Tracks, OfRecordingsLearnAllFiguresBehindTheUsersBack) {
  TemporaryFile file;
  testing::record_stack(file.path(), 60);
  Workers workers(1);
  Track track("stack", file.path());
  EXPECT_EQ(track.past().size(), 1u);
  while (track.look_ahead(workers)) {
  }
  EXPECT_FALSE(track.look_ahead(workers));
  ASSERT_EQ(track.past().size(), 61u);
  EXPECT_NEAR(track.past().back().figures[0], 1.0, 1e-6);
  EXPECT_EQ(track.past().front().figures[7], 0.0) << "no step was played";
  EXPECT_EQ(track.past()[1].figures[7], 1.0);
  EXPECT_EQ(track.past()[5].figures[1], 6.0);
  EXPECT_EQ(track.past()[30].figures[1], 7.0) << "a ball has come";
  const auto hit = std::find_if(track.events().begin(), track.events().end(),
                                [](const PastEvent& event) { return event.kind == EventKind::hit; });
  ASSERT_NE(hit, track.events().end());
  EXPECT_GT(hit->value, 5.0f);
  EXPECT_FLOAT_EQ(track.dt(), 1.0f / 60.0f);
}

TEST(Tracks, ThatAreLiveLookBackAtWhatTheyWere) {
  TemporaryFile file;
  Workers workers(1);
  Track track("pile", small_pile(), file.path());
  std::map<std::uint64_t, std::uint64_t> hashes;
  for (std::uint64_t step = 0; step <= 150; ++step) hashes[step] = state_at(track, step, workers).hash();
  EXPECT_EQ(track.last(), 150u);
  for (const std::uint64_t step : {149u, 0u, 60u, 61u, 59u, 120u, 3u, 150u})
    EXPECT_EQ(state_at(track, step, workers).hash(), hashes.at(step)) << step;
  EXPECT_EQ(track.last(), 150u) << "looking back changes nothing";
  EXPECT_EQ(state_at(track, 151, workers).stats().step, 151u);
}

TEST(Tracks, MeasureWithoutChangingTheFuture) {
  TemporaryFile file;
  Workers workers(1);
  Track track("pile", small_pile(), file.path());
  scenes::Stage stage({small_pile()});
  for (std::uint64_t step = 1; step <= 90; ++step) {
    stage.advance(track.dt(), workers);
    ASSERT_EQ(state_at(track, step, workers).hash(), stage.worlds().front().hash()) << step;
  }
}

TEST(Tracks, BranchesHaveTheSameBitsUntilTheyAreChanged) {
  TemporaryFile file, branch_file, other_file;
  Workers workers(1);
  Track parent("pile", small_pile(), file.path());
  std::map<std::uint64_t, std::uint64_t> hashes;
  for (std::uint64_t step = 0; step <= 100; ++step) hashes[step] = state_at(parent, step, workers).hash();
  state_at(parent, 40, workers);
  Track branch("branch", parent.branch(), parent.dt(), branch_file.path());
  Track other("other", parent.branch(), parent.dt(), other_file.path());
  EXPECT_EQ(branch.first(), 40u);
  other.end().set_settings({.gravity = {1.0f, -9.0f, 0.0f}});
  for (std::uint64_t step = 41; step <= 100; ++step) {
    ASSERT_EQ(state_at(branch, step, workers).hash(), hashes.at(step)) << step;
    EXPECT_NE(state_at(other, step, workers).hash(), hashes.at(step)) << step;
  }
  Player player = other.open();
  EXPECT_EQ(player.info().first_step, 40u);
  EXPECT_EQ(player.info().last_step, 100u);
  EXPECT_FALSE(player.verify(40, 100, workers).has_value());
}

TEST(Tracks, SayWhichFileIsWrong) {
  TemporaryFile file;
  try {
    Track track("nothing", file.path() + ".no");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(file.path() + ".no"), std::string::npos);
  }
  Workers workers(1);
  testing::record_stack(file.path(), 40, {.step = 15});
  Track track("stack", file.path());
  EXPECT_ANY_THROW({
    while (track.look_ahead(workers)) {
    }
  }) << "its replay differs";
}

TEST(FrameCache, ForgetsWhatIsFarAwayFirst) {
  FrameCache cache;
  const auto big = std::make_shared<const std::string>(FrameCache::kMostBytes / 8, 'x');
  for (std::uint64_t step = 0; step < 20; ++step) cache.keep(step, {}, big, 10);
  int kept = 0;
  for (std::uint64_t step = 0; step < 20; ++step) kept += cache.find(step, {}) != nullptr;
  EXPECT_EQ(kept, 8);
  EXPECT_NE(cache.find(10, {}), nullptr);
  EXPECT_EQ(cache.find(0, {}), nullptr);
  EXPECT_EQ(cache.find(10, {.shade = Shade::force}), nullptr) << "another picture";
  cache.forget(10);
  EXPECT_EQ(cache.find(10, {}), nullptr);
}

}  // namespace
}  // namespace scree::view
