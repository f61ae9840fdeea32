// Joints take energy from what they cannot hold, and never give any: without motors, springs, bias and warm
// start every sweep over a joint is a projection of the velocities.
#include "joint_world_fixture.h"

#include <array>
#include <string>

namespace scree::joint_tests {
namespace {

enum class Axes { free, limited, held };
struct Kind {
  JointType type;
  Axes axes;
};
std::string name_of(const Kind& kind) {
  constexpr const char* kNames[] = {"Free", "Limited", "Held"};
  return "Type" + std::to_string(static_cast<int>(kind.type)) + kNames[static_cast<int>(kind.axes)];
}
void PrintTo(const Kind& kind, std::ostream* out) { *out << name_of(kind); }

JointParameters parameters_of(const Kind& kind) {
  JointParameters parameters = free_rotation();
  JointAxisRow limited = kFreeAxis;
  limited.lower = -0.3f;
  limited.upper = 0.4f;
  for (int axis = 0; axis < kJointAxes; ++axis) {
    if (kind.type == JointType::ball && axis == 3) break;  // what follows is no axis
    parameters.axis[axis] = kind.axes == Axes::free      ? kFreeAxis
                            : kind.axes == Axes::limited ? limited
                                                         : kHeldAxis;
  }
  if (kind.type == JointType::distance) {
    parameters.axis[0].lower = kind.axes == Axes::limited ? 0.8f : 1.0f;
    parameters.axis[0].upper = kind.axes == Axes::limited ? 1.3f : 1.0f;
  }
  if (kind.type == JointType::wheel) parameters.axis[2] = kFreeAxis;  // its spin has no limits
  if (kind.type == JointType::gear || kind.type == JointType::rack_and_pinion)
    parameters.axis[0].target = 0.7f;
  return parameters;
}

class JointEnergy : public testing::TestWithParam<Kind> {};

TEST_P(JointEnergy, NeverGrowsWithoutDrivesBiasAndWarmStart) {
  const Kind kind = GetParam();
  constexpr std::size_t kPairs = 50;
  JointWorld world;
  world.bare = true;
  Random random(7);
  const JointParameters parameters = parameters_of(kind);
  const bool rich = kind.axes != Axes::free;
  for (std::size_t pair = 0; pair < kPairs; ++pair) {
    const auto body = [&](Vec3 position) {
      const float moment = random.uniform(0.1f, 1);
      return world.add_body(random.uniform(0.5f, 2),
                            {moment, moment * random.uniform(1, 1.5f), moment * 1.2f}, position,
                            random.rotation(), {random.vector(3), random.vector(4)});
    };
    const float gap = kind.type == JointType::distance ? 1.0f : 0.0f;
    const std::int32_t a = body({0, 0, 0}), b = body({1 + gap, 0, 0});
    const Quat back_a = conjugate(world.rotation_of(a)), back_b = conjugate(world.rotation_of(b));
    // Frames that lie on each other in the world.
    world.add_joint(a, {rotate(back_a, Vec3{0.5f, 0, 0}), back_a}, b,
                    {rotate(back_b, Vec3{-0.5f, 0, 0}), back_b}, parameters);
  }
  const auto energy_of = [&](std::size_t pair) {
    return world.energy[2 * pair] + world.energy[2 * pair + 1];
  };
  world.step(simd::widest_kernels(), kind.type, rich);
  std::array<float, kPairs> first, before;
  for (std::size_t pair = 0; pair < kPairs; ++pair) first[pair] = before[pair] = energy_of(pair);
  for (int step = 0; step < 120; ++step) {
    world.step(simd::widest_kernels(), kind.type, rich);
    for (std::size_t pair = 0; pair < kPairs; ++pair) {
      EXPECT_LE(energy_of(pair), before[pair] + 1e-5f * first[pair]) << "pair " << pair << ", step " << step;
      before[pair] = energy_of(pair);
    }
  }
  for (const float energy : before) EXPECT_GT(energy, 0.0f);
}

constexpr Kind kKinds[] = {
    {JointType::ball, Axes::free},
    {JointType::ball, Axes::limited},
    {JointType::hinge, Axes::free},
    {JointType::hinge, Axes::limited},
    {JointType::slider, Axes::free},
    {JointType::slider, Axes::limited},
    {JointType::distance, Axes::held},
    {JointType::distance, Axes::limited},
    {JointType::weld, Axes::free},
    {JointType::six_degree, Axes::held},
    {JointType::six_degree, Axes::limited},
    {JointType::wheel, Axes::free},
    {JointType::wheel, Axes::limited},
    {JointType::universal, Axes::free},
    {JointType::universal, Axes::limited},
    {JointType::planar, Axes::free},
    {JointType::planar, Axes::limited},
    {JointType::gear, Axes::free},
    {JointType::rack_and_pinion, Axes::free},
};
INSTANTIATE_TEST_SUITE_P(OfAllKindsThatHold, JointEnergy, testing::ValuesIn(kKinds),
                         [](const auto& parameters) { return name_of(parameters.param); });

}  // namespace
}  // namespace scree::joint_tests
