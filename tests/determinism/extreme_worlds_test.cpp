// Worlds of extreme scenes: joints that pull bodies of any mass over kilometers, at any speed. Their numbers
// overflow in the middle of a step. Every instruction set must give the same bits.
#include <core/world/limits.h>
#include <tests/core/constraints/joint_samples.h>
#include <tests/determinism/backends.h>
#include <tools/scenes/random.h>

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace scree::determinism {
namespace {

constexpr int kBodies = 60, kJoints = 70, kSteps = 6;
constexpr std::uint64_t kSeeds = 40;

struct Draw {
  scenes::Random random;
  float within(float size) { return random.between(-size, size); }
  bool one_in(std::uint32_t count) { return random.below(count) == 0; }
  // Mostly of the given size, rarely of any size up to the limit.
  float any(float size, float limit) {
    if (!one_in(8)) return within(size);
    return within(1.0f) * size * std::pow(limit / size, random.unit());
  }
  Vec3 vector(float size, float limit) { return {any(size, limit), any(size, limit), any(size, limit)}; }
};

World extreme_world(std::uint64_t seed) {
  Draw draw{scenes::Random(seed)};
  WorldSettings settings;
  settings.substeps = 1 + static_cast<int>(draw.random.below(5));
  if (draw.one_in(2)) settings.max_linear_speed = settings.max_angular_speed = kMaxSpeedLimit;
  settings.measure_residual = settings.contact_forces = draw.one_in(2);
  settings.restitution_threshold = 0.1f;
  World world(settings);
  std::vector<BodyId> bodies;
  for (int i = 0; i < kBodies; ++i) {
    BodyDef def;
    if (i % 12 == 0) def.type = i % 24 == 0 ? BodyType::kinematic : BodyType::fixed;
    def.position = draw.vector(3, 1e4f);
    def.rotation = draw.random.rotation();
    def.linear_velocity = draw.vector(10, kMaxSpeed);
    def.angular_velocity = draw.vector(10, kMaxSpeed);
    if (draw.one_in(3)) def.mass = std::pow(10.0f, draw.any(2, 19));
    if (draw.one_in(8)) def.locks = static_cast<AxisLocks>(draw.random.below(64));
    const BodyId body = bodies.emplace_back(world.create_body(def));
    const Material material{.restitution = draw.one_in(3) ? 0.5f : 0.0f,
                            .rolling_resistance = draw.one_in(3) ? 0.1f : 0.0f};
    const float size = 0.5f + 0.4f * draw.within(1);
    if (i == 0) world.add_shape(body, HalfSpace{}, material);
    switch (draw.random.below(6)) {
      case 0:
        world.add_shape(body, Sphere{size}, material);
        break;
      case 1:
        world.add_shape(body, Capsule{size, 0.5f * size}, material);
        break;
      case 2:
        world.add_shape(body, Cylinder{size, 0.5f * size}, material);
        break;
      case 3:
        world.add_shape(body, Cone{size, 0.7f}, material);
        break;
      case 4:
        world.add_shape(body, Box{{size, 0.5f * size, 0.4f}, 0.3f}, material);
        break;
      default:
        world.add_shape(body, Box{{size, 0.5f * size, 0.7f}}, material);
    }
  }
  const std::vector<Joint> sound = test::sound_joints(), plain = test::plain_joints();
  for (int i = 0; i < kJoints; ++i) {
    JointDef def;
    const std::uint32_t a = draw.random.below(kBodies), b = draw.random.below(kBodies);
    if (a == b) continue;
    def.body_a = bodies[a];
    def.body_b = bodies[b];
    def.frame_a = {draw.vector(1, 1e5f), draw.random.rotation()};
    def.frame_b = {draw.vector(1, 1e5f), draw.random.rotation()};
    if (draw.one_in(4)) def.hertz = 5;
    if (draw.one_in(4)) def.break_force = 1e6f;
    const Joint& joint = (draw.one_in(2) ? sound : plain)[draw.random.below(kJointTypeCount)];
    if (std::holds_alternative<MouseJoint>(joint)) {
      def.body_a = kWorld;
      def.frame_a.rotation = {};
    }
    world.create_joint(def, joint);
  }
  return world;
}

TEST(ExtremeWorlds, HaveTheSameBitsOnEveryInstructionSet) {
  int quarantined = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    World expected = extreme_world(seed);
    std::vector<World> others;
    std::vector<Workers> workers;
    for (const Isa isa : supported_isas()) {
      others.push_back(clone(expected));
      workers.emplace_back(WorkersOptions{.threads = 1, .isa = isa});
    }
    for (int i = 0; i < kSteps; ++i) {
      for (std::size_t k = 0; k < others.size(); ++k) {
        step(others[k], 1.0f / 60.0f, workers[k]);
        ASSERT_EQ(others[k].hash(), others[0].hash()) << "seed " << seed << ", step " << i << ", set " << k;
      }
      quarantined +=
          static_cast<int>(others[0].quarantined_bodies().size() + others[0].restored_bodies().size());
    }
  }
  EXPECT_GT(quarantined, 0);
}

}  // namespace
}  // namespace scree::determinism
