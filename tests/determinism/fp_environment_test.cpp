// Laws of the caller's floating-point environment: it affects neither World's calls nor the step, and it is
// unchanged afterwards.
#include <gtest/gtest.h>
#include <tests/determinism/many_threads.h>
#include <tests/determinism/random_calls.h>
#include <tests/determinism/replay.h>

#include <cfenv>

namespace scree::determinism {
namespace {

const SceneCase kPile{"pile", {{"bodies", 120}, {"seed", 3}}, 60};

// Steps the pile and makes random calls; returns the hash of the results.
std::vector<std::uint64_t> everything(const std::vector<scenes::Scene>& scenes, const Sequence& sequence) {
  Shift shift({{Isa::automatic, 2}});
  Playback playback(scenes, kPile.steps);
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < kPile.steps; ++i) {
    playback.advance(shift.at(i));
    hashes.push_back(playback.hash());
  }
  const Played played = play(sequence, {{Isa::automatic, 2}}, false);
  EXPECT_EQ(played.broken_promise, "");
  EXPECT_FALSE(played.hashes.empty());
  hashes.insert(hashes.end(), played.hashes.begin(), played.hashes.end());
  return hashes;
}

class CallersFpEnvironment : public ManyThreads {
 protected:
  const std::vector<scenes::Scene> scenes_ = scenes::build(kPile.scene, kPile.parameters);
  const Sequence calls_ = random_sequence(11, 200, 40);  // drawn in the default environment
};

#if defined(__SSE__)
constexpr unsigned kFlushToZero = 1u << 15, kDenormalsAreZero = 1u << 6;

TEST_F(CallersFpEnvironment, FlushToZeroChangesNoResultAndStaysSet) {
  const std::vector<std::uint64_t> expected = everything(scenes_, calls_);
  const unsigned before = __builtin_ia32_stmxcsr();
  const unsigned hostile = (before | kFlushToZero | kDenormalsAreZero) & ~0x3fu;
  __builtin_ia32_ldmxcsr(hostile);
  const std::vector<std::uint64_t> hashes = everything(scenes_, calls_);
  const unsigned after = __builtin_ia32_stmxcsr();
  __builtin_ia32_ldmxcsr(before);
  EXPECT_EQ(after & ~0x3fu, hostile);
  EXPECT_EQ(hashes, expected);
}
#endif

TEST_F(CallersFpEnvironment, RoundingModeChangesNoStepAndStaysSet) {
  const std::vector<std::uint64_t> expected = play(kPile, {{Isa::automatic, 2}});
  for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
    Workers workers(2);
    Playback playback(scenes_, kPile.steps);
    bool kept = true;
    std::vector<std::uint64_t> hashes;
    for (int i = 0; i < kPile.steps; ++i) {
      std::fesetround(mode);
      playback.advance(workers);
      kept = kept && std::fegetround() == mode;
      std::fesetround(FE_TONEAREST);
      hashes.push_back(playback.hash());
    }
    EXPECT_TRUE(kept);
    EXPECT_EQ(hashes, expected);
  }
}

TEST_F(CallersFpEnvironment, RoundingModeChangesNoCall) {
  const std::vector<std::uint64_t> expected = everything(scenes_, calls_);
  for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
    std::fesetround(mode);
    const std::vector<std::uint64_t> hashes = everything(scenes_, calls_);
    std::fesetround(FE_TONEAREST);
    EXPECT_EQ(hashes, expected) << mode;
  }
}

}  // namespace
}  // namespace scree::determinism
