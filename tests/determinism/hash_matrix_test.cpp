// Laws of the results: every scene gives the golden hash, and the same hash at every step, for every
// instruction set and number of threads.
#include <core/plain/rows.h>
#include <core/state/world_difference.h>
#include <gtest/gtest.h>
#include <tests/determinism/golden.h>
#include <tests/determinism/many_threads.h>

#include <algorithm>
#include <set>

namespace scree::determinism {
namespace {

class HashMatrix : public ManyThreads, public ::testing::WithParamInterface<Golden> {};

TEST_P(HashMatrix, EveryBackendGivesTheGoldenHashByTheSameSteps) {
  const Golden& golden = GetParam();
  report_unsupported_isas();
  const std::vector<std::uint64_t> expected = play(golden.what, {kReference});
  EXPECT_EQ(digest_of(expected), golden.digest)
      << golden.name() << " on " << name_of({kReference}) << " does not give the golden hash.\n"
      << "If results were meant to change: tools/update_goldens \"why\"";
  for (const Schedule& schedule : schedules(wants_full_matrix())) {
    const std::vector<std::uint64_t> hashes = play(golden.what, schedule);
    ASSERT_EQ(digest_of(hashes), digest_of(expected))
        << golden.name() << " on " << name_of(schedule) << " differs from " << name_of({kReference}) << ": "
        << where_they_part(golden.what, schedule);
  }
}

TEST_P(HashMatrix, TheWholeStateTableIsTheSameAtTheEnd) {
  // The hash covers no impulses, timers, colors and caches, but they affect later steps.
  const SceneCase& what = GetParam().what;
  Playback expected(what), actual(what);
  Shift reference({kReference}), shift(schedules(false).back());
  for (int i = 0; i < what.steps; ++i) {
    expected.advance(reference.at(i));
    actual.advance(shift.at(i));
  }
  for (std::size_t world = 0; world < expected.worlds().size(); ++world) {
    EXPECT_EQ(first_column_difference(expected.worlds()[world], actual.worlds()[world]), "");
  }
}

TEST_P(HashMatrix, EveryBackendListsTheSameEvents) {
  const SceneCase& what = GetParam().what;
  const auto play_events = [&what](const Schedule& schedule) {
    Shift shift(schedule);
    Playback playback(what, ContactEvents::all);
    std::uint64_t sum = 0;
    std::size_t events = 0, joints = 0;
    for (int i = 0; i < what.steps; ++i) {
      playback.advance(shift.at(i));
      for (const World& world : playback.worlds()) {
        sum = mixed(sum, digest_of_events(world));
        events += world.contact_begins().size() + world.contact_persists().size();
        joints += world.joint_count();
      }
    }
    EXPECT_GT(events + joints, 0u);  // a net of joints may touch nothing
    EXPECT_EQ(playback.hash(), GetParam().digest.last) << "recording events has changed the motion";
    return sum;
  };
  const std::uint64_t expected = play_events({kReference});
  for (const Schedule& schedule : schedules(false)) {
    EXPECT_EQ(play_events(schedule), expected) << name_of(schedule);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, HashMatrix, ::testing::ValuesIn(scene_goldens()), kGoldenName);

TEST(Divergence, IsNamedByBodyFieldAndColumn) {
  const SceneCase what{"stack", {{"bodies", 3}}, 1};
  Playback expected(what), actual(what);
  World& world = actual.worlds().front();
  EXPECT_EQ(first_body_difference(expected.worlds().front(), world), "");
  EXPECT_EQ(first_column_difference(expected.worlds().front(), world), "");
  const BodyId top = world.body_at(static_cast<std::uint32_t>(kFirstBody) + 3);
  world.set_linear_velocity(top, {0.0f, -0.0f, 0.0f});
  const std::string name = "body " + std::to_string(top.index);
  EXPECT_EQ(first_body_difference(expected.worlds().front(), world),
            name + ", linear_velocity.y is -0 (80000000) instead of 0 (00000000)");
  EXPECT_EQ(first_column_difference(expected.worlds().front(), world),
            "bodies.velocity, row " + std::to_string(top.index) + ", byte 7 of 32");
  EXPECT_NE(expected.hash(), actual.hash());
}

TEST(GoldenHashes, CoverEveryBuiltInScene) {
  std::set<std::string> covered;
  for (const Golden& golden : scene_goldens()) covered.insert(golden.what.scene);
  for (const scenes::SceneInfo& info : scenes::catalog())
    EXPECT_TRUE(covered.contains(info.name)) << info.name;
}

TEST(GoldenHashes, BelongToRunsWithCollisionsOrJointsSleepAndWaking) {
  bool somebody_slept = false, somebody_woke = false;
  for (const Golden& golden : scene_goldens()) {
    Workers workers(WorkersOptions{.threads = 1});
    Playback playback(golden.what);
    std::int64_t constraints = 0, awake_before = 0;
    for (int i = 0; i < golden.what.steps; ++i) {
      playback.advance(workers);
      const StepStats& stats = playback.worlds().front().stats();
      constraints = std::max(constraints, stats.contacts + stats.joints);
      if (i > 0 && stats.awake_bodies < awake_before) somebody_slept = true;
      if (somebody_slept && stats.awake_bodies > awake_before) somebody_woke = true;
      awake_before = stats.awake_bodies;
    }
    EXPECT_GT(constraints, 0) << golden.name();
  }
  EXPECT_TRUE(somebody_slept);
  EXPECT_TRUE(somebody_woke);
}

}  // namespace
}  // namespace scree::determinism
