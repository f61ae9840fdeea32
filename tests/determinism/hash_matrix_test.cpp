// Laws of the results: every scene comes to the golden hash, and to the same hash at every step, whatever the
// instruction set and the number of threads.
#include <gtest/gtest.h>
#include <tests/determinism/golden.h>
#include <tests/determinism/many_threads.h>

#include <algorithm>
#include <set>

namespace scree::determinism {
namespace {

std::vector<Golden> scene_goldens() {
  std::vector<Golden> goldens = read_goldens(golden_path());
  std::erase_if(goldens, [](const Golden& golden) { return golden.what.scene == kRandomCalls; });
  return goldens;
}

class HashMatrix : public ManyThreads, public ::testing::WithParamInterface<Golden> {};

TEST_P(HashMatrix, EveryBackendComesToTheGoldenHashByTheSameSteps) {
  const Golden& golden = GetParam();
  report_unsupported_isas();
  const std::vector<std::uint64_t> expected = play(golden.what, {kReference});
  EXPECT_EQ(digest_of(expected), golden.digest)
      << golden.name() << " on " << name_of({kReference}) << " does not come to the golden hash.\n"
      << "If results were meant to change: tools/update_goldens \"why\"";
  for (const Schedule& schedule : schedules(wants_full_matrix())) {
    const std::vector<std::uint64_t> hashes = play(golden.what, schedule);
    ASSERT_EQ(digest_of(hashes), digest_of(expected))
        << golden.name() << " on " << name_of(schedule) << " differs from " << name_of({kReference}) << ": "
        << where_they_part(golden.what, schedule);
  }
}

// Named after the scene; a number keeps several sizes of one scene apart.
std::string test_name(const ::testing::TestParamInfo<Golden>& info) {
  return info.param.what.scene + "_" + std::to_string(info.index);
}
INSTANTIATE_TEST_SUITE_P(Scenes, HashMatrix, ::testing::ValuesIn(scene_goldens()), test_name);

TEST(GoldenHashes, CoverEveryBuiltInScene) {
  std::set<std::string> covered;
  for (const Golden& golden : scene_goldens()) covered.insert(golden.what.scene);
  for (const scenes::SceneInfo& info : scenes::catalog())
    EXPECT_TRUE(covered.contains(info.name)) << info.name;
}

TEST(GoldenHashes, BelongToRunsInWhichBodiesCollideFallAsleepAndWake) {
  bool somebody_slept = false, somebody_woke = false;
  for (const Golden& golden : scene_goldens()) {
    Workers workers(WorkersOptions{.threads = 1});
    Playback playback(golden.what);
    std::int64_t contacts = 0, awake_before = 0;
    for (int i = 0; i < golden.what.steps; ++i) {
      playback.advance(workers);
      const StepStats& stats = playback.worlds().front().stats();
      contacts = std::max(contacts, stats.contacts);
      if (i > 0 && stats.awake_bodies < awake_before) somebody_slept = true;
      if (somebody_slept && stats.awake_bodies > awake_before) somebody_woke = true;
      awake_before = stats.awake_bodies;
    }
    EXPECT_GT(contacts, 0) << golden.name();
  }
  EXPECT_TRUE(somebody_slept);
  EXPECT_TRUE(somebody_woke);
}

}  // namespace
}  // namespace scree::determinism
