// Laws of the caller's floating-point environment: it reaches neither World's calls nor the step, and comes
// back as it was.
#include <gtest/gtest.h>
#include <tests/determinism/many_threads.h>
#include <tests/determinism/random_calls.h>
#include <tests/determinism/replay.h>

#include <cfenv>
#include <cmath>
#include <initializer_list>
#include <vector>

namespace scree::determinism {
namespace {

const SceneCase kPile{"pile", {{"bodies", 120}, {"seed", 3}}, 60};

// Steps the pile and makes random calls; returns what they come to.
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

TEST_F(CallersFpEnvironment, FlushingDenormalsChangesNothingAndIsKept) {
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

// Motion out of a mechanism's plane dies away by a share in each substep, for ever if nothing cuts it off.
TEST(FpEnvironment, NoStateHoldsADenormal) {
  World world({.sleeping = false});
  std::vector<BodyId> links;
  for (int i = 0; i < 30; ++i) {
    links.push_back(world.create_body(
        {.type = i == 0 ? BodyType::fixed : BodyType::dynamic, .position = {static_cast<float>(i), 0, 0}}));
    world.add_shape(links.back(), Sphere{0.4f});
    if (i == 0) continue;
    world.create_joint({.body_a = links[links.size() - 2],
                        .body_b = links.back(),
                        .frame_a = {{0.5f, 0, 0}, {}},
                        .frame_b = {{-0.5f, 0, 0}, {}}},
                       HingeJoint{});
  }
  Workers workers(1);
  int denormals = 0, zeros = 0;
  const auto look_at = [&](std::initializer_list<float> numbers) {
    for (const float number : numbers) {
      denormals += std::fpclassify(number) == FP_SUBNORMAL ? 1 : 0;
      zeros += number == 0.0f ? 1 : 0;
    }
  };
  for (int i = 0; i < 120; ++i) {
    step(world, 1.0f / 60.0f, workers);
    for (const BodyId link : links) {
      const Vec3 v = world.linear_velocity(link), w = world.angular_velocity(link);
      const Pose pose = world.pose(link);
      look_at({v.x, v.y, v.z, w.x, w.y, w.z, pose.position.z, pose.rotation.x, pose.rotation.y});
    }
  }
  EXPECT_EQ(denormals, 0);
  EXPECT_GT(zeros, 0);
}

TEST_F(CallersFpEnvironment, RoundingOfTheStepsCallerChangesNothingAndIsKept) {
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

TEST_F(CallersFpEnvironment, RoundingOfWorldsCallsChangesNothing) {
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
