// Joints take energy from what they can not hold, and never give any: without motors, springs, bias and warm
// start every sweep over a joint is a projection of the velocities.
#include "joint_world_fixture.h"

#include <array>

namespace scree::joint_tests {
namespace {

struct Kind {
  JointType type;
  bool held;  // its axes are held, too, or they are free
};
void PrintTo(const Kind& kind, std::ostream* out) {
  *out << "type " << static_cast<int>(kind.type) << (kind.held ? " held" : " free");
}

class JointEnergy : public testing::TestWithParam<Kind> {};

TEST_P(JointEnergy, NeverGrowsWithoutDrivesBiasAndWarmStart) {
  const Kind kind = GetParam();
  constexpr std::size_t kPairs = 50;
  JointWorld world;
  world.bare = true;
  Random random(7);
  JointParameters parameters = free_parameters();
  if (kind.held) {
    for (JointAxisRow& axis : parameters.axis) axis = kHeldAxis;
  }
  if (kind.type == JointType::distance) parameters.axis[0].lower = parameters.axis[0].upper = 1.0f;
  if (kind.type == JointType::gear || kind.type == JointType::rack_and_pinion)
    parameters.axis[0].target = 0.7f;
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
  world.step(simd::widest_kernels(), kind.type, kind.held || kind.type == JointType::distance);
  std::array<float, kPairs> first, before;
  for (std::size_t pair = 0; pair < kPairs; ++pair) first[pair] = before[pair] = energy_of(pair);
  for (int step = 0; step < 120; ++step) {
    world.step(simd::widest_kernels(), kind.type, kind.held || kind.type == JointType::distance);
    for (std::size_t pair = 0; pair < kPairs; ++pair) {
      EXPECT_LE(energy_of(pair), before[pair] + 1e-5f * first[pair]) << "pair " << pair << ", step " << step;
      before[pair] = energy_of(pair);
    }
  }
  for (const float energy : before) EXPECT_GT(energy, 0.0f);
}

INSTANTIATE_TEST_SUITE_P(OfAllKindsThatHold, JointEnergy,
                         testing::Values(Kind{JointType::ball, false}, Kind{JointType::hinge, false},
                                         Kind{JointType::slider, false}, Kind{JointType::distance, true},
                                         Kind{JointType::weld, false}, Kind{JointType::six_degree, true},
                                         Kind{JointType::wheel, false}, Kind{JointType::universal, false},
                                         Kind{JointType::planar, false}, Kind{JointType::gear, false},
                                         Kind{JointType::rack_and_pinion, false}),
                         [](const auto& parameters) {
                           return "Type" + std::to_string(static_cast<int>(parameters.param.type));
                         });

}  // namespace
}  // namespace scree::joint_tests
