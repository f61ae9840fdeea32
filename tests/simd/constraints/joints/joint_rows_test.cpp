// Laws of the joints made of rows, and of motors and mice, as kernels: the same bits from every instruction
// set, momentum kept, and no speed left in what is held.
#include "joint_world_fixture.h"

namespace scree::joint_tests {
namespace {

constexpr int type_of(JointType type) { return static_cast<int>(type); }
constexpr JointType kFramed[] = {JointType::wheel, JointType::universal, JointType::planar};
constexpr JointType kRowKinds[] = {
    JointType::wheel,           JointType::universal, JointType::planar, JointType::gear,
    JointType::rack_and_pinion, JointType::pulley,    JointType::motor,  JointType::mouse};

bool is_framed(JointType type) {
  return type == JointType::wheel || type == JointType::universal || type == JointType::planar;
}

// Frame b in frame a, somewhere among what the kind leaves free.
Pose free_pose(JointType type, Random& random) {
  const float angle = random.uniform(-1, 1), other = random.uniform(-1, 1);
  switch (type) {
    case JointType::wheel:
      return {{random.uniform(-0.2f, 0.2f), 0, 0}, about(kX, angle) * about(kZ, 3 * other)};
    case JointType::universal:
      return {{0, 0, 0}, about(kX, 3 * angle) * about(kY, other)};
    case JointType::planar:
      return {{0, random.uniform(-1, 1), random.uniform(-1, 1)}, about(kX, 3 * angle)};
    default:
      return {random.vector(1), random.rotation()};
  }
}

JointAxisRow random_axis(Random& random) {
  JointAxisRow axis{-kNoLimit,
                    kNoLimit,
                    random.uniform(-1, 1),
                    random.uniform(-2, 2),
                    random.uniform(0.5f, 40),
                    random.uniform(0, 2),
                    random.uniform(0.1f, 100),
                    kDriveNone};
  const float limits = random.uniform(0, 4), drive = random.uniform(0, 3);
  if (limits > 1) axis.lower = random.uniform(-1, 0.2f);
  if (limits > 2) axis.upper = axis.lower + random.uniform(0, 1);
  if (limits > 3) axis.upper = axis.lower;
  if (drive > 1) axis.drive = drive > 2 ? kDriveMotor : kDriveSpring;
  return axis;
}

JointParameters parameters_of(JointType type, bool rich, Random& random) {
  JointParameters p = free_parameters();
  if (random.uniform(0, 1) > 0.5f) p.hertz = p.angular_hertz = random.uniform(1, 60);
  if (is_framed(type) && rich) {
    for (int i = 0; i < 3; ++i) p.axis[i] = random_axis(random);
    if (type == JointType::wheel && p.axis[2].drive == kDriveSpring) p.axis[2].drive = kDriveMotor;
  }
  const Vec3 point = random.vector(3), other = random.vector(3);
  switch (type) {
    case JointType::gear:
    case JointType::rack_and_pinion:
      p.axis[0].target = random.uniform(0.2f, 3);
      break;
    case JointType::pulley:
      p.axis[0].target = random.uniform(0.3f, 3);
      p.axis[0].upper = random.uniform(1, 8);
      if (rich) p.axis[0].lower = p.axis[0].upper;
      p.axis[1] = {point.x, point.y, point.z, 0, 0, 0, 0, kDriveNone};
      p.axis[2] = {other.x, other.y, other.z, 0, 0, 0, 0, kDriveNone};
      break;
    case JointType::motor: {
      for (int i = 0; i < 6; ++i) p.axis[i] = random_axis(random);
      const Quat target = random.rotation();
      p.axis[3] = {target.x, target.y, target.z, target.w, 0, 0, 0, kDriveNone};
      p.axis[4].lower = point.x;
      p.axis[4].upper = point.y;
      p.axis[5] = {other.x, other.y, other.z, 0, 0, 0, 0, kDriveNone};
      break;
    }
    case JointType::mouse:
      p.axis[0] = random_axis(random);
      p.axis[0].drive = kDriveSpring;
      p.axis[1] = {point.x, point.y, point.z, 0, 0, 0, 0, kDriveNone};
      break;
    default:
      break;
  }
  return p;
}

// Pairs of bodies that fly about and turn; every `fixed`-th joint has the world for its body a.
JointWorld random_world(JointType type, bool rich, int joints, int fixed, bool round, float slip = 0.02f) {
  Random random(static_cast<unsigned>(type_of(type)) * 2 + (rich ? 1 : 0));
  JointWorld world;
  world.gravity = {0, 0, 0};
  const auto moment = [&] {
    const float x = random.uniform(0.1f, 0.3f);
    return round ? Vec3{x, x, x} : Vec3{x, random.uniform(0.1f, 0.3f), random.uniform(0.15f, 0.3f)};
  };
  for (int i = 0; i < joints; ++i) {
    const bool of_world = type == JointType::mouse || (fixed != 0 && i % fixed == 0);
    add_random_joint(
        world, random, of_world, slip, moment, [&] { return free_pose(type, random); },
        [&] { return parameters_of(type, rich, random); });
  }
  return world;
}

template <class Rows>
void expect_same(const Rows& expected, const Rows& rows, const std::string& what) {
  ASSERT_EQ(expected.size(), rows.size());
  for (std::size_t row = 0; row < rows.size(); ++row) {
    ASSERT_EQ(std::memcmp(&expected[row], &rows[row], sizeof(rows[row])), 0) << what << ", row " << row;
  }
}

TEST(RowJoints, HaveTheSameBitsOnEveryInstructionSet) {
  const std::vector<const simd::Kernels*> sets = all_kernels();
  for (const JointType type : kRowKinds) {
    for (const bool rich : {false, true}) {
      const auto run = [&](const simd::Kernels& kernels) {
        JointWorld world = random_world(type, rich, 37, 5, false);
        world.gravity = {0, -9.81f, 0};
        for (int step = 0; step < 4; ++step) world.step(kernels, type, rich);
        return world;
      };
      const JointWorld expected = run(*sets[0]);
      float moved = 0;  // by the joints alone: something must have happened
      for (const JointImpulses& i : expected.impulses)
        moved += std::abs(i.impulse[0]) + std::abs(i.impulse[5]);
      if (is_framed(type)) {
        EXPECT_GT(moved, 1e-3f) << type_of(type);
      }
      for (std::size_t set = 1; set < sets.size(); ++set) {
        const JointWorld world = run(*sets[set]);
        const std::string what = std::string(sets[set]->name) + ", kind " + std::to_string(type_of(type));
        expect_same(expected.pose, world.pose, what + " poses");
        expect_same(expected.velocity, world.velocity, what + " velocities");
        expect_same(expected.impulses, world.impulses, what + " impulses");
        expect_same(expected.reactions, world.reactions, what + " reactions");
      }
    }
  }
}

struct PairMomentum {
  double linear[3] = {0, 0, 0}, angular[3] = {0, 0, 0};
};

// Of a joint's two bodies, about the origin; bodies are round.
PairMomentum momentum_of(const JointWorld& world, std::size_t joint) {
  PairMomentum sum;
  for (const std::int32_t body : {world.frames[joint].row_a, world.frames[joint].row_b}) {
    const auto row = static_cast<std::size_t>(body);
    const float mass = world.mass[row], moment = world.local_inertia[row].inertia[0];
    const Vec3 v = world.linear(body) * mass, w = world.angular(body) * moment;
    const Vec3 l = cross(world.position_of(body), v) + w;
    const float add[6] = {v.x, v.y, v.z, l.x, l.y, l.z};
    for (int i = 0; i < 3; ++i) {
      sum.linear[i] += double{add[i]};
      sum.angular[i] += double{add[3 + i]};
    }
  }
  return sum;
}

// Soft joints with limits and drives: springs give back what was in them, no more.
TEST(RowJoints, GainNoSpeedWithoutBounds) {
  for (const JointType type : kRowKinds) {
    JointWorld world = random_world(type, true, 500, 5, false);
    Random random(3);
    for (JointParameters& p : world.parameters) {
      p.hertz = p.angular_hertz = random.uniform(1, 10);  // pulleys are up to 6 m out
      p.damping_ratio = p.angular_damping_ratio = random.uniform(0, 1);
      for (JointAxisRow& axis : p.axis) axis.max_force = std::min(axis.max_force, 100.0f);
    }
    for (int step = 0; step < 120; ++step) world.step(simd::widest_kernels(), type);
    for (const std::int32_t body : world.moving) {
      EXPECT_LT(length(world.linear(body)) + length(world.angular(body)), 300.0f) << static_cast<int>(type);
    }
  }
}

TEST(RowJoints, KeepTheMomentumOfTwoBodies) {
  const simd::Kernels& kernels = simd::widest_kernels();
  for (const JointType type : {JointType::wheel, JointType::universal, JointType::planar, JointType::motor,
                               JointType::rack_and_pinion, JointType::gear}) {
    for (const bool rich : {false, true}) {
      JointWorld world = random_world(type, rich, 20, 0, true);
      std::vector<PairMomentum> before;
      for (std::size_t joint = 0; joint < 20; ++joint) before.push_back(momentum_of(world, joint));
      for (int step = 0; step < 10; ++step) world.step(kernels, type, rich);
      for (std::size_t joint = 0; joint < 20; ++joint) {
        const PairMomentum after = momentum_of(world, joint);
        for (int i = 0; i < 3; ++i) {
          EXPECT_NEAR(after.linear[i], before[joint].linear[i], 2e-4) << type_of(type) << " joint " << joint;
          // Gears and pinions leave it to the bearings to carry what is missing.
          if (type == JointType::gear || type == JointType::rack_and_pinion) continue;
          EXPECT_NEAR(after.angular[i], before[joint].angular[i], 1e-3)
              << type_of(type) << " joint " << joint;
        }
      }
    }
  }
}

// The largest speed in what a joint holds, m/s or rad/s, from velocities and poses alone.
float held_speed(const JointWorld& world, std::size_t joint, JointType type) {
  const JointFrames& f = world.frames[joint];
  const Pose a = world.frame_a(joint), b = world.frame_b(joint);
  const Vec3 spin_a = world.angular(f.row_a), spin_b = world.angular(f.row_b), turning = spin_b - spin_a;
  // Of the offset as frame a sees it.
  const Vec3 sliding = world.anchor_speed(joint) - cross(spin_a, b.position - a.position);
  const Vec3 x = rotate(a.rotation, kX), y = rotate(a.rotation, kY), z = rotate(a.rotation, kZ);
  const auto largest = [](std::initializer_list<float> values) {
    float most = 0;
    for (const float value : values) most = std::max(most, std::abs(value));
    return most;
  };
  const float ratio = world.parameters[joint].axis[0].target;
  const Vec3 x_b = rotate(b.rotation, kX);
  switch (type) {
    case JointType::wheel:
      return largest({dot(sliding, y), dot(sliding, z), dot(turning, cross(x, rotate(b.rotation, kZ)))});
    case JointType::universal:
      return largest({length(sliding), dot(turning, cross(x, rotate(b.rotation, kY)))});
    case JointType::planar:
      return largest({dot(sliding, x), dot(turning, y), dot(turning, z)});
    case JointType::gear:
      return largest({dot(spin_a, x) + ratio * dot(spin_b, x_b)});
    case JointType::rack_and_pinion:
      return largest({dot(world.anchor_speed(joint), x_b) - ratio * dot(spin_a, x)});
    default:
      return 0;
  }
}

TEST(RowJoints, LeaveNoSpeedInWhatALoneJointHolds) {
  const simd::Kernels& kernels = simd::widest_kernels();
  for (const JointType type : {JointType::wheel, JointType::universal, JointType::planar, JointType::gear,
                               JointType::rack_and_pinion}) {
    for (const bool rich : {false, true}) {
      JointWorld world = random_world(type, rich, 25, 4, false);
      // What is held softly is a spring, and keeps its speed.
      for (JointParameters& p : world.parameters) p.hertz = p.angular_hertz = 0;
      world.gravity = {0, -9.81f, 0};
      float before = 0;
      for (std::size_t joint = 0; joint < 25; ++joint)
        before = std::max(before, held_speed(world, joint, type));
      EXPECT_GT(before, 1.0f);
      for (int step = 0; step < 5; ++step) {
        world.step(kernels, type, rich);
        for (std::size_t joint = 0; joint < 25; ++joint) {
          EXPECT_LT(held_speed(world, joint, type), 2e-4f) << type_of(type) << " joint " << joint;
        }
      }
    }
  }
}

// Held errors vanish: of the offset by frame a's axes and of the axes against each other.
float held_error(const JointWorld& world, std::size_t joint, JointType type) {
  const Pose a = world.frame_a(joint), b = world.frame_b(joint);
  const Vec3 offset = rotate_back(a.rotation, b.position - a.position);
  const Quat turned = conjugate(a.rotation) * b.rotation;
  const Vec3 x = rotate(turned, kX), y = rotate(turned, kY), z = rotate(turned, kZ);
  switch (type) {
    case JointType::wheel:
      return std::max({std::abs(offset.y), std::abs(offset.z), std::abs(z.x)});
    case JointType::universal:
      return std::max(length(offset), std::abs(y.x));
    case JointType::planar:
      return std::max({std::abs(offset.x), std::abs(x.y), std::abs(x.z)});
    default:
      return 0;
  }
}

TEST(RowJoints, TakeErrorsBack) {
  const simd::Kernels& kernels = simd::widest_kernels();
  for (const JointType type : kFramed) {
    JointWorld world = random_world(type, false, 25, 4, false, 0.1f);
    for (JointParameters& p : world.parameters) p.hertz = p.angular_hertz = 0;
    for (MotionRow& m : world.motion) m.linear_damping = m.angular_damping = 3;  // no load in the end
    float before = 0;
    for (std::size_t joint = 0; joint < 25; ++joint)
      before = std::max(before, held_error(world, joint, type));
    EXPECT_GT(before, 0.05f);
    for (int step = 0; step < 60; ++step) world.step(kernels, type, false);
    for (std::size_t joint = 0; joint < 25; ++joint) {
      EXPECT_LT(held_error(world, joint, type), 1e-3f) << type_of(type) << " joint " << joint;
    }
  }
}

// One number of a joint's bodies, impulses or parameters is no number: the others must not notice.
TEST(RowJoints, KeepNonFiniteNumbersInTheirLanes) {
  const simd::Kernels& kernels = simd::widest_kernels();
  for (const JointType type : kRowKinds) {
    JointWorld expected = random_world(type, true, 16, 0, false),
               world = random_world(type, true, 16, 0, false);
    const auto non_finite = static_cast<std::size_t>(world.frames[3].row_b);
    world.velocity[non_finite].linear[1] = std::numeric_limits<float>::quiet_NaN();
    expected.step(kernels, type);
    world.step(kernels, type);
    for (const float impulse : world.impulses[3].impulse) EXPECT_EQ(impulse, 0) << static_cast<int>(type);
    expected.step(kernels, type);  // in which the non-finite bodies are back
    world.step(kernels, type);
    for (std::size_t joint = 0; joint < 16; ++joint) {
      if (joint == 3) continue;
      EXPECT_EQ(std::memcmp(&world.impulses[joint], &expected.impulses[joint], sizeof(JointImpulses)), 0);
      for (const std::int32_t body : {world.frames[joint].row_a, world.frames[joint].row_b}) {
        const auto row = static_cast<std::size_t>(body);
        EXPECT_EQ(std::memcmp(&world.velocity[row], &expected.velocity[row], sizeof(VelocityRow)), 0);
      }
    }
  }
}

}  // namespace
}  // namespace scree::joint_tests
