// Laws of the kernels of balls, hinges and welds.
#include "joint_world_fixture.h"

namespace scree::joint_tests {
namespace {

constexpr int kPlainBall = simd::joint_variant(JointType::ball, false),
              kDrivenBall = simd::joint_variant(JointType::ball, true);
constexpr int kPlainHinge = simd::joint_variant(JointType::hinge, false),
              kDrivenHinge = simd::joint_variant(JointType::hinge, true);
constexpr int kRigidWeld = simd::joint_variant(JointType::weld, false);
constexpr int kBlockVariants[] = {kPlainBall, kDrivenBall, kPlainHinge, kDrivenHinge, kRigidWeld};

JointParameters random_parameters(Random& random) {
  JointParameters p = free_rotation();
  if (random.uniform(0, 1) < 0.3f) p.hertz = p.angular_hertz = random.uniform(1, 40);
  JointAxisRow& first = p.axis[0];
  if (random.uniform(0, 1) < 0.5f) first.lower = random.uniform(-3, 0);
  if (random.uniform(0, 1) < 0.5f) first.upper = random.uniform(0, 3);
  p.axis[1].upper = random.uniform(0, 2);
  for (const int axis : {0, 2}) {
    p.axis[axis].drive = static_cast<std::uint32_t>(random.uniform(0, 2.99f));
    p.axis[axis].target = random.uniform(-4, 4);
    p.axis[axis].hertz = random.uniform(0.5f, 50);
    if (random.uniform(0, 1) < 0.5f) p.axis[axis].max_force = random.uniform(0, 3);
  }
  for (int axis = 0; axis < 3; ++axis) p.axis[axis].speed = random.uniform(-5, 5);
  const Quat target = random.rotation();
  p.axis[3] = {target.x, target.y, target.z, target.w, 1, 1, 0, kDriveNone};
  return p;
}

// Pairs of bodies, some against the world, whose frames are together but for `error`.
JointWorld random_pairs(int count, unsigned seed, float error) {
  JointWorld world;
  world.gravity = kWeight;
  Random random(seed);
  const auto inertia = [&] {
    return Vec3{random.uniform(0.1f, 0.2f), random.uniform(0.1f, 0.2f), random.uniform(0.11f, 0.2f)};
  };
  for (int i = 0; i < count; ++i) {
    const auto body = [&](Vec3 position, Quat rotation) {
      return world.add_body(random.uniform(0.5f, 2), inertia(), position, rotation,
                            {random.vector(2), random.vector(3)});
    };
    const Quat rotation = random.rotation();
    const Pose local_a{random.vector(0.7f), random.rotation()},
        local_b{random.vector(0.7f), random.rotation()};
    const Vec3 position = random.vector(5);
    const std::int32_t a = i % 5 == 0 ? kFixedRow : body(position, rotation);
    const Pose at = a == kFixedRow
                        ? local_a
                        : Pose{position + rotate(rotation, local_a.position), rotation * local_a.rotation};
    const Quat rotation_b =
        normalize(at.rotation * about({0.3f, 0.5f, 1}, error) * conjugate(local_b.rotation));
    const Vec3 position_b = at.position - rotate(rotation_b, local_b.position) + random.vector(error);
    world.add_joint(a, local_a, body(position_b, rotation_b), local_b, random_parameters(random));
  }
  return world;
}

// Drives without bounds fight limits with so much that rounding and the turning of inertia hide the laws.
void bound_drives(JointWorld& world) {
  for (JointParameters& p : world.parameters) {
    for (JointAxisRow& axis : p.axis) axis.max_force = std::min(axis.max_force, 3.0f);
  }
}

template <class Row>
void expect_same(const Column<Row>& a, const Column<Row>& b, const std::string& what) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t row = 0; row < a.size(); ++row) {
    ASSERT_EQ(std::memcmp(&a[row], &b[row], sizeof(Row)), 0) << what << " row " << row;
  }
}

TEST(JointKernels, EveryInstructionSetGivesTheBitsOfScalar) {
  for (const int variant : kBlockVariants) {
    JointWorld expected = random_pairs(67, 1, 0.3f);
    for (int step = 0; step < 5; ++step) expected.step(scalar_kernels(), variant);
    for (const simd::Kernels* kernels : all_kernels()) {
      JointWorld world = random_pairs(67, 1, 0.3f);
      for (int step = 0; step < 5; ++step) world.step(*kernels, variant);
      const std::string what = kernels->name + std::string(", variant ") + std::to_string(variant);
      expect_same(expected.pose, world.pose, what + ", pose");
      expect_same(expected.velocity, world.velocity, what + ", velocity");
      expect_same(expected.impulses, world.impulses, what + ", impulse");
      expect_same(expected.reactions, world.reactions, what + ", reaction");
      EXPECT_EQ(expected.residual[0], world.residual[0]) << what;
    }
  }
}

// The largest reactions of a step's substeps.
TEST(JointKernels, KeepTheLargestReactionsWhereTheyAreAskedFor) {
  for (const int variant : kBlockVariants) {
    const auto run = [&](const simd::Kernels& kernels, bool peaks) {
      JointWorld world = random_pairs(67, 1, 0.3f);
      world.peaks = peaks;
      for (int step = 0; step < 3; ++step) world.step(kernels, variant);
      return world;
    };
    const JointWorld expected = run(scalar_kernels(), true), plain = run(scalar_kernels(), false);
    expect_same(expected.velocity, plain.velocity, "velocity");
    int higher = 0;
    for (std::size_t joint = 0; joint < expected.reactions.size(); ++joint) {
      const JointReactionRow &row = expected.reactions[joint], &other = plain.reactions[joint];
      EXPECT_EQ(std::memcmp(row.force, other.force, 6 * sizeof(float)), 0);
      EXPECT_EQ(other.force_peak_squared + other.torque_peak_squared, 0.0f);
      const float last =
          row.force[0] * row.force[0] + row.force[1] * row.force[1] + row.force[2] * row.force[2];
      EXPECT_GE(row.force_peak_squared, last * 0.9999f);
      if (row.force_peak_squared > 1.1f * last) ++higher;
    }
    EXPECT_GT(higher, 10) << variant;
    for (const simd::Kernels* kernels : all_kernels()) {
      expect_same(expected.reactions, run(*kernels, true).reactions, kernels->name);
    }
  }
}

TEST(JointKernels, NonFiniteJointsChangeNoOtherLaneAndForgetTheirImpulses) {
  for (const int variant : kBlockVariants) {
    const auto run = [&](const simd::Kernels& kernels, bool spoiled) {
      JointWorld world = random_pairs(32, 2, 0.1f);
      world.step(kernels, variant);
      if (spoiled) {
        const std::int32_t body = world.frames[7].row_b;
        world.velocity[static_cast<std::size_t>(body)].angular[1] = std::numeric_limits<float>::quiet_NaN();
      }
      world.step(kernels, variant);
      return world;
    };
    for (const simd::Kernels* kernels : all_kernels()) {
      const JointWorld expected = run(*kernels, false), world = run(*kernels, true);
      for (std::size_t joint = 0; joint < world.frames.size(); ++joint) {
        if (joint == 7) {
          for (const float impulse : world.impulses[joint].impulse) EXPECT_TRUE(std::isfinite(impulse));
          continue;
        }
        EXPECT_EQ(std::memcmp(&expected.impulses[joint], &world.impulses[joint], sizeof(JointImpulses)), 0);
      }
    }
  }
}

// One pass over a joint is exact: its held rows are solved as one.
TEST(JointKernels, HeldRowsOfALoneJointHaveNoSpeedLeft) {
  for (const int variant : kBlockVariants) {
    JointWorld world = random_pairs(200, 3, 0.0f);
    bound_drives(world);
    for (JointParameters& p : world.parameters) p.hertz = p.angular_hertz = 0.0f;  // no springs
    for (int step = 0; step < 3; ++step) world.step(scalar_kernels(), variant);
    for (std::size_t joint = 0; joint < world.frames.size(); ++joint) {
      EXPECT_LT(length(world.anchor_speed(joint)), 2e-5f) << variant << " joint " << joint;
      const Vec3 turning =
          world.angular(world.frames[joint].row_b) - world.angular(world.frames[joint].row_a);
      const Vec3 x = rotate(world.frame_a(joint).rotation, {1, 0, 0});
      if (variant == kPlainHinge || variant == kDrivenHinge) {
        EXPECT_LT(length(cross(x, turning)), 4e-5f) << variant << " joint " << joint;
      }
      if (variant == kRigidWeld) {
        EXPECT_LT(length(turning), 4e-5f) << joint;
      }
    }
  }
}

// Limits and drives beside springs of any softness, some of them against each other.
TEST(JointKernels, NothingGainsSpeedWithoutBounds) {
  for (const int variant : kBlockVariants) {
    JointWorld world = random_pairs(200, 5, 0.1f);
    bound_drives(world);
    for (int step = 0; step < 120; ++step) world.step(scalar_kernels(), variant);
    for (std::size_t joint = 0; joint < world.frames.size(); ++joint) {
      EXPECT_LT(length(world.angular(world.frames[joint].row_b)), 60.0f) << variant << " joint " << joint;
    }
  }
}

// Small bodies on long arms: what a difference of responses would lose all digits of.
TEST(JointKernels, HeldRowsOfASmallBodyOnALongArmHaveNoSpeedLeft) {
  for (const int variant : {kPlainHinge, kRigidWeld}) {
    JointWorld world;
    world.gravity = kWeight;
    for (int i = 0; i < 5; ++i) {
      const float arm = std::pow(2.0f, static_cast<float>(i));  // to 16 m, of a cube of 0.1 m
      const std::int32_t body =
          world.add_body(1.0f, {0.00167f, 0.00167f, 0.00167f}, {arm, 0, 0}, {}, {{0, 1, 2}, {1, 2, 3}});
      world.add_joint(kFixedRow, {}, body, {{-arm, 0, 0}, {}});
    }
    world.step(scalar_kernels(), variant);
    for (std::size_t joint = 0; joint < world.frames.size(); ++joint) {
      const Vec3 speed = world.anchor_speed(joint);
      EXPECT_LT(length(speed), 2e-3f) << "joint " << joint;
      Vec3 turning = world.angular(world.frames[joint].row_b);
      if (variant == kPlainHinge) turning.x = 0;
      EXPECT_LT(length(turning), 2e-3f) << "joint " << joint;
    }
  }
}

TEST(JointKernels, ImpulsesConserveMomentum) {
  for (const int variant : kBlockVariants) {
    JointWorld world = random_pairs(100, 4, 0.0f);
    bound_drives(world);
    world.gravity = {0, 0, 0};
    world.dt = 1e-4f;
    const auto momentum = [&](std::size_t joint, Vec3& linear, Vec3& angular) {
      const JointFrames& f = world.frames[joint];
      linear = angular = {0, 0, 0};
      for (const std::int32_t row : {f.row_a, f.row_b}) {
        const auto body = static_cast<std::size_t>(row);
        const float* i = world.local_inertia[body].inertia;
        const Vec3 local = rotate_back(world.rotation_of(row), world.angular(row));
        const Vec3 spin = rotate(world.rotation_of(row), {i[0] * local.x, i[3] * local.y, i[5] * local.z});
        linear = linear + world.mass[body] * world.linear(row);
        angular = angular + cross(world.position_of(row), world.mass[body] * world.linear(row)) + spin;
      }
    };
    std::vector<Vec3> linear(100), angular(100);
    for (std::size_t joint = 0; joint < 100; ++joint) momentum(joint, linear[joint], angular[joint]);
    for (int step = 0; step < 3; ++step) world.step(scalar_kernels(), variant);
    for (std::size_t joint = 0; joint < 100; ++joint) {
      if (joint % 5 == 0) continue;  // against the world
      Vec3 linear_now, angular_now;
      momentum(joint, linear_now, angular_now);
      EXPECT_LT(length(linear_now - linear[joint]), 1e-4f) << variant << " joint " << joint;
      EXPECT_LT(length(angular_now - angular[joint]), 1e-3f) << variant << " joint " << joint;
    }
  }
}

// A door with its hinge along the vertical edge: nothing but the hinge carries it.
TEST(JointKernels, AHingeHoldsADoorUnderItsWeight) {
  for (const simd::Kernels* kernels : all_kernels()) {
    for (const int variant : {kPlainHinge, kDrivenHinge}) {
      JointWorld world;
      world.gravity = kWeight;
      const float m = 40.0f;
      const Quat upright = about({0, 0, 1}, kPi / 2);  // x to the vertical
      const std::int32_t door = world.add_body(m, {m / 12 * 4, m / 12 * 1, m / 12 * 5}, {0.5f, 0, 0}, {},
                                               {{0, 0, -1.0f}, {0, 2, 0}});
      const std::size_t joint =
          world.add_joint(kFixedRow, {{0, 0, 0}, upright}, door, {{-0.5f, 0, 0}, upright});
      float offset = 0, tilt = 0;
      for (int step = 0; step < 600; ++step) {
        world.step(*kernels, variant);
        const Pose a = world.frame_a(joint), b = world.frame_b(joint);
        offset = std::max(offset, length(b.position - a.position));
        tilt = std::max(tilt, length(cross(rotate(a.rotation, {1, 0, 0}), rotate(b.rotation, {1, 0, 0}))));
      }
      EXPECT_LT(offset, 2e-4f) << kernels->name;
      EXPECT_LT(tilt, 1e-4f) << kernels->name;
      EXPECT_NEAR(world.angular(door).y, 2.0f, 0.02f) << kernels->name;  // nothing brakes it
      // What the joint says about itself: the door's weight, and its lean on the edge.
      const float* force = world.reactions[joint].force;
      const float* torque = world.reactions[joint].torque;
      EXPECT_NEAR(force[1], m * 9.81f, 0.01f * m * 9.81f);
      EXPECT_NEAR(std::hypot(torque[0], torque[2]), m * 9.81f * 0.5f, 0.02f * m * 9.81f * 0.5f);
      EXPECT_NEAR(torque[1], 0.0f, 0.5f);
    }
  }
}

}  // namespace
}  // namespace scree::joint_tests
