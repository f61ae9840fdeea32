// Laws of the kernels of sliders, distance joints and joints of six degrees.
#include "joint_fixture.h"

namespace scree::joint_tests {
namespace {

constexpr JointType kSlider = JointType::slider, kDistance = JointType::distance,
                    kSixDegree = JointType::six_degree;
struct Variant {
  JointType type;
  bool rich;
};
constexpr Variant kVariants[] = {{kSlider, false}, {kSlider, true}, {kDistance, true}, {kSixDegree, true}};

const simd::Kernels& widest() { return simd::widest_kernels(); }

JointAxisRow random_axis(Random& random, bool length) {
  JointAxisRow axis = kFreeAxis;
  const float kind = random.uniform(0, 4);
  if (kind > 1) axis.lower = random.uniform(length ? 0.0f : -0.5f, 0.5f);
  if (kind > 2) axis.upper = axis.lower + random.uniform(0, 1);
  if (kind > 3) axis.upper = axis.lower;
  const float drive = random.uniform(0, 3);
  axis.drive = drive > 2 ? kDriveSpring : drive > 1 ? kDriveMotor : kDriveNone;
  axis.target = random.uniform(0, 1);
  axis.speed = random.uniform(-1, 1);
  axis.hertz = random.uniform(0.5f, 5);
  axis.damping_ratio = random.uniform(0, 2);
  axis.max_force = random.uniform(0, 100);
  return axis;
}

// Pairs of bodies of their own, near each other; of the fixed side, if any, none can be pushed.
Bench random_bench(Variant variant, simd::BodySide fixed, int count, unsigned seed, bool isotropic = false) {
  Random random(seed);
  Bench bench;
  bench.fixed = fixed;
  bench.gravity = {0, -9.81f, 0};
  for (int k = 0; k < count; ++k) {
    const auto body = [&](simd::BodySide side) {
      const float moment = random.uniform(0.1f, 1);
      const Vec3 moments =
          isotropic ? Vec3{moment, moment, moment}
                    : Vec3{moment, moment * random.uniform(1, 1.5f), moment * random.uniform(1, 1.5f)};
      const float mass = fixed == side ? 0.0f : random.uniform(0.5f, 2);
      return bench.add_body(mass, moments, random.vector(1), random.rotation(), random.vector(1),
                            random.vector(1));
    };
    const std::int32_t a = body(simd::BodySide::a), b = body(simd::BodySide::b);
    const Pose frame{random.vector(1), random.rotation()};
    Pose near = frame;
    near.position = near.position + random.vector(0.02f);
    near.rotation = normalize(near.rotation * turn({0.6f, 0, 0.8f}, random.uniform(-0.05f, 0.05f)));
    const std::size_t joint = bench.add_joint(a, frame, b, near);
    JointParameters& p = bench.parameters[joint];
    if (k % 3 == 0) p.hertz = p.angular_hertz = random.uniform(1, 40);
    if (!variant.rich) continue;
    for (JointAxisRow& axis : p.axis) axis = random_axis(random, variant.type == kDistance);
  }
  return bench;
}

template <class Row>
void expect_same(const Column<Row>& a, const Column<Row>& b, const char* what, const char* name) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t row = 0; row < a.size(); ++row) {
    ASSERT_EQ(std::memcmp(&a[row], &b[row], sizeof(Row)), 0) << what << " " << row << " of " << name;
  }
}

TEST(JointKernelsLinear, EveryInstructionSetGivesTheSameBits) {
  for (const Variant variant : kVariants) {
    for (const simd::BodySide fixed : {simd::BodySide::none, simd::BodySide::a, simd::BodySide::b}) {
      Bench expected = random_bench(variant, fixed, 101, 1);
      for (int step = 0; step < 5; ++step) {
        expected.step(scalar_kernels(), variant.type, variant.rich);
      }
      for (const simd::Kernels* kernels : all_kernels()) {
        Bench bench = random_bench(variant, fixed, 101, 1);
        for (int step = 0; step < 5; ++step) bench.step(*kernels, variant.type, variant.rich);
        expect_same(expected.pose, bench.pose, "pose", kernels->name);
        expect_same(expected.velocity, bench.velocity, "velocity", kernels->name);
        expect_same(expected.impulses, bench.impulses, "impulses", kernels->name);
        expect_same(expected.reactions, bench.reactions, "reaction", kernels->name);
        expect_same(expected.residual, bench.residual, "residual", kernels->name);
      }
    }
  }
}

struct Momentum {
  Vec3 linear, angular;
};
Momentum momentum_of(const Bench& bench) {
  Momentum sum{};
  for (const std::int32_t body : bench.moving) {
    const auto row = static_cast<std::size_t>(body);
    const float *v = bench.velocity[row].linear, *w = bench.velocity[row].angular;
    const Vec3 p = bench.mass[row] * Vec3{v[0], v[1], v[2]};
    sum.linear = sum.linear + p;
    // All moments are equal.
    sum.angular = sum.angular + cross(bench.position_of(body), p) +
                  bench.local_inertia[row].inertia[0] * Vec3{w[0], w[1], w[2]};
  }
  return sum;
}

TEST(JointKernelsLinear, ConserveMomentum) {
  for (const Variant variant : kVariants) {
    for (unsigned seed = 0; seed < 30; ++seed) {
      Bench bench = random_bench(variant, simd::BodySide::none, 1, seed, true);
      bench.gravity = {0, 0, 0};
      const Momentum before = momentum_of(bench);
      float pushed = 0;
      for (int step = 0; step < 20; ++step) {
        bench.step(widest(), variant.type, variant.rich);
        const JointReactionRow& r = bench.reactions[0];
        pushed += length(Vec3{r.force[0], r.force[1], r.force[2]}) * bench.dt;
      }
      const Momentum after = momentum_of(bench);
      EXPECT_LT(length(after.linear - before.linear), 1e-5f * (1 + pushed))
          << static_cast<int>(variant.type) << " " << seed;
      EXPECT_LT(length(after.angular - before.angular), 1e-4f * (1 + pushed))
          << static_cast<int>(variant.type) << " " << seed;
    }
  }
}

// Soft joints with limits and drives, many of them pulled far out: springs give back what was in them, no
// more.
TEST(JointKernelsLinear, NothingGainsSpeedWithoutBounds) {
  for (const Variant variant : kVariants) {
    Bench bench = random_bench(variant, simd::BodySide::none, 1000, 9);
    for (JointParameters& p : bench.parameters) {
      if (p.hertz > 0) p.damping_ratio = p.angular_damping_ratio = 0.1f;
    }
    for (int step = 0; step < 120; ++step) bench.step(widest(), variant.type, variant.rich);
    for (const std::int32_t body : bench.moving) {
      const float* v = bench.velocity[static_cast<std::size_t>(body)].linear;
      const float* w = bench.velocity[static_cast<std::size_t>(body)].angular;
      EXPECT_LT(std::hypot(v[0], v[1], v[2]) + std::hypot(w[0], w[1], w[2]), 200.0f)
          << static_cast<int>(variant.type);
    }
  }
}

// Velocity of anchor b against the point of body a that it meets, in the axes of frame a.
Vec3 anchor_speed(const Bench& bench, std::size_t joint) {
  const JointFrames& f = bench.frames[joint];
  const Vec3 place = bench.frame_b(joint).position;
  const auto at_place = [&](std::int32_t body) {
    const VelocityRow& v = bench.velocity[static_cast<std::size_t>(body)];
    return Vec3{v.linear[0], v.linear[1], v.linear[2]} +
           cross({v.angular[0], v.angular[1], v.angular[2]}, place - bench.position_of(body));
  };
  return rotate_back(bench.frame_a(joint).rotation, at_place(f.row_b) - at_place(f.row_a));
}
Vec3 spin_speed(const Bench& bench, std::size_t joint) {
  const JointFrames& f = bench.frames[joint];
  const float *a = bench.velocity[static_cast<std::size_t>(f.row_a)].angular,
              *b = bench.velocity[static_cast<std::size_t>(f.row_b)].angular;
  return rotate_back(bench.frame_a(joint).rotation, Vec3{b[0] - a[0], b[1] - a[1], b[2] - a[2]});
}

constexpr float kSpeedLeft = 5e-5f;  // m/s or rad/s, of some meters a second

TEST(JointKernelsLinear, ALoneSliderIsLeftWithoutSpeedOffItsAxis) {
  for (const bool rich : {false, true}) {
    for (const simd::BodySide fixed : {simd::BodySide::none, simd::BodySide::a, simd::BodySide::b}) {
      Bench bench = random_bench({kSlider, rich}, fixed, 101, 2);
      // What is held softly is a spring, and keeps its speed.
      for (JointParameters& p : bench.parameters) p.hertz = p.angular_hertz = 0;
      for (int step = 0; step < 5; ++step) bench.step(widest(), kSlider, rich);
      for (std::size_t joint = 0; joint < bench.frames.size(); ++joint) {
        const Vec3 v = anchor_speed(bench, joint);
        EXPECT_LT(std::hypot(v.y, v.z), kSpeedLeft) << joint;
        EXPECT_LT(length(spin_speed(bench, joint)), kSpeedLeft) << joint;
      }
    }
  }
}

// A body on the end of a rail, 0.5 m beside it.
Bench shelf(Quat axes, float off = 0.5f) {
  Bench bench;
  bench.gravity = {0, -9.81f, 0};
  bench.fixed = simd::BodySide::a;
  const std::int32_t body = bench.add_body(2, {0.2f, 0.3f, 0.3f}, {3, 2, 1 + off});
  bench.add_joint(kFixedRow, {{3, 2, 1}, axes}, body, {{3, 2, 1}, axes});
  return bench;
}
void run(Bench& bench, Variant variant, int steps) {
  for (int step = 0; step < steps; ++step) bench.step(widest(), variant.type, variant.rich);
}
const Quat kUpright = turn({0, 0, 1}, std::numbers::pi_v<float> / 2);  // x points up

TEST(JointKernelsLinear, ASliderCarriesAWeightBesideItsRail) {
  for (const Variant variant : {Variant{kSlider, false}, Variant{kSlider, true}}) {
    Bench bench = shelf({});
    run(bench, variant, 240);
    const Vec3 offset = bench.offset(0);
    EXPECT_LT(std::hypot(offset.y, offset.z), 1e-4f);
    EXPECT_LT(length(bench.angles(0)), 1e-4f);
    const JointReactionRow& r = bench.reactions[0];
    EXPECT_NEAR(r.force[1], 2 * 9.81f, 0.01f);
    EXPECT_NEAR(r.torque[0], -0.5f * 2 * 9.81f, 0.01f);
  }
}

TEST(JointKernelsLinear, ASliderStopsAtItsLimit) {
  Bench bench = shelf(kUpright);
  bench.parameters[0].axis[0].lower = -0.3f;
  float lowest = 0;
  for (int step = 0; step < 240; ++step) {
    bench.step(widest(), kSlider, true);
    lowest = std::min(lowest, bench.offset(0).x);
  }
  EXPECT_LT(bench.offset(0).x, -0.29f);
  EXPECT_GT(lowest, -0.302f);
}

// From the times at which the coordinate passes its mean downwards.
template <class Coordinate>
float frequency_of(Bench& bench, Variant variant, float mean, int steps, Coordinate&& coordinate) {
  float first = -1, last = 0, before = coordinate(bench) - mean;
  int count = -1;
  for (int step = 0; step < steps; ++step) {
    run(bench, variant, 1);
    const float now = coordinate(bench) - mean;
    if (before > 0 && now <= 0) {
      last = (static_cast<float>(step) + before / (before - now)) * bench.dt;
      if (first < 0) first = last;
      ++count;
    }
    before = now;
  }
  return static_cast<float>(count) / (last - first);
}

TEST(JointKernelsLinear, ASpringOnASliderHasItsFrequencyBesideTheRail) {
  for (const float off : {0.0f, 0.5f, 1.0f}) {
    Bench bench = shelf(kUpright, off);
    bench.gravity = {0, 0, 0};
    JointAxisRow& axis = bench.parameters[0].axis[0];
    axis.drive = kDriveSpring;
    axis.hertz = 2;
    axis.damping_ratio = 0;
    axis.target = 0.2f;
    const float hertz =
        frequency_of(bench, {kSlider, true}, 0.2f, 300, [](const Bench& b) { return b.offset(0).x; });
    EXPECT_NEAR(hertz, 2, 0.04f) << off;
  }
}

TEST(JointKernelsLinear, AMotorOnASliderReachesItsSpeedWithBoundedForce) {
  Bench bench = shelf({});
  JointAxisRow& axis = bench.parameters[0].axis[0];
  axis.drive = kDriveMotor;
  axis.speed = 1;
  axis.max_force = 4;  // 2 m/s^2: half a second
  run(bench, {kSlider, true}, 24);
  EXPECT_NEAR(anchor_speed(bench, 0).x, 0.8f, 1e-3f);
  EXPECT_NEAR(bench.reactions[0].force[0], 4, 1e-3f);
  run(bench, {kSlider, true}, 24);
  EXPECT_NEAR(anchor_speed(bench, 0).x, 1, 1e-4f);
  EXPECT_NEAR(bench.reactions[0].force[0], 0, 1e-2f);
}

// A weight under the origin, on an arm that leads to its anchor.
Bench plumb(Vec3 anchor, Vec3 center) {
  Bench bench;
  bench.gravity = {0, -9.81f, 0};
  bench.fixed = simd::BodySide::a;
  const std::int32_t body = bench.add_body(2, {0.2f, 0.3f, 0.3f}, center);
  bench.add_joint(kFixedRow, {{0, 0, 0}, {}}, body, {anchor, {}});
  return bench;
}

TEST(JointKernelsLinear, ARodKeepsAPendulumsLengthAndFrequency) {
  const float angle = 0.1f;
  Bench bench = plumb({std::sin(angle), -std::cos(angle), 0}, {std::sin(angle), -std::cos(angle), 0});
  bench.parameters[0].axis[0].lower = bench.parameters[0].axis[0].upper = 1;
  float worst = 0;
  const float hertz = frequency_of(bench, {kDistance, true}, 0, 600, [&](const Bench& b) {
    worst = std::max(worst, std::abs(length(b.offset(0)) - 1));
    return b.offset(0).x;
  });
  EXPECT_LT(worst, 1e-4f);
  const float expected = std::sqrt(9.81f) / (2 * std::numbers::pi_v<float>)*(1 - angle * angle / 16);
  EXPECT_NEAR(hertz, expected, 0.005f * expected);
}

TEST(JointKernelsLinear, ARopeIsSlackAndThenTight) {
  Bench bench = plumb({0.1f, -0.5f, 0}, {0.1f, -0.6f, 0});
  bench.parameters[0].axis[0].upper = 2;
  bench.parameters[0].axis[0].lower = 0;
  float longest = 0;
  for (int step = 0; step < 15; ++step) bench.step(widest(), kDistance, true);
  const float t = 15 * bench.dt, h = bench.dt / 4;
  EXPECT_NEAR(bench.offset(0).y, -0.5f - 0.5f * 9.81f * t * (t + h), 1e-4f);  // free fall
  EXPECT_EQ(bench.reactions[0].force[1], 0.0f);
  for (int step = 0; step < 600; ++step) {
    bench.step(widest(), kDistance, true);
    longest = std::max(longest, length(bench.offset(0)));
  }
  EXPECT_GT(longest, 1.999f);
  EXPECT_LT(longest, 2.002f);
}

TEST(JointKernelsLinear, ADistanceSpringHasItsFrequencyAlsoThroughZero) {
  for (const float target : {1.0f, 0.0f}) {
    Bench bench = plumb({0, -1.2f, 0}, {0, -1.2f, 0});
    bench.gravity = {0, 0, 0};
    JointAxisRow& axis = bench.parameters[0].axis[0];
    axis.lower = 0;
    axis.drive = kDriveSpring;
    axis.hertz = 2;
    axis.damping_ratio = 0;
    axis.target = target;
    const float hertz =
        frequency_of(bench, {kDistance, true}, -target, 300, [](const Bench& b) { return b.offset(0).y; });
    EXPECT_NEAR(hertz, 2, 0.04f) << target;
  }
}

JointAxisRow held_at(float value) {
  JointAxisRow axis = kHeldAxis;
  axis.lower = axis.upper = value;
  return axis;
}

TEST(JointKernelsLinear, ALoneJointOfSixDegreesIsLeftWithoutSpeedOnWhatItHolds) {
  for (const simd::BodySide fixed : {simd::BodySide::none, simd::BodySide::a, simd::BodySide::b}) {
    Bench bench = random_bench({kSixDegree, true}, fixed, 64, 3);
    // All sets of held axes.
    for (std::size_t joint = 0; joint < 64; ++joint) {
      bench.parameters[joint].hertz = 0;
      for (std::size_t axis = 0; axis < 6; ++axis) {
        bench.parameters[joint].axis[axis] = (joint >> axis & 1) != 0 ? kHeldAxis : kFreeAxis;
      }
    }
    for (int step = 0; step < 20; ++step) bench.step(widest(), kSixDegree, true);
    for (std::size_t joint = 0; joint < 64; ++joint) {
      const Vec3 v = anchor_speed(bench, joint);
      const float speeds[3] = {v.x, v.y, v.z};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if ((joint >> axis & 1) != 0) {
          EXPECT_LT(std::abs(speeds[axis]), kSpeedLeft) << joint << " " << axis;
        }
      }
      if (joint >> 3 == 7) {
        EXPECT_LT(length(spin_speed(bench, joint)), kSpeedLeft) << joint;
      }
      const Vec3 angles = bench.angles(joint);
      const float parts[3] = {angles.x, angles.y, angles.z};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if ((joint >> axis & 8) != 0) {
          EXPECT_LT(std::abs(parts[axis]), 2e-3f) << joint << " " << axis;
        }
      }
    }
  }
}

// As another kind of joint would hold them: the slider of the six and the slider move alike.
TEST(JointKernelsLinear, SixDegreesMoveAsASlider) {
  for (const float off : {0.0f, 0.5f}) {
    for (const int drive : {0, 1, 2}) {
      const auto make = [&](bool six) {
        Bench bench = shelf(turn({0, 0, 1}, 0.5f), off);
        JointAxisRow axis = kFreeAxis;
        axis.lower = -0.7f;
        axis.upper = 0.5f;
        axis.drive = drive == 0 ? kDriveNone : drive == 1 ? kDriveMotor : kDriveSpring;
        axis.speed = 0.5f;
        axis.max_force = 15;
        JointAxisRow* axes = bench.parameters[0].axis;
        axes[0] = axis;
        for (int i = 1; six && i < 6; ++i) axes[i] = kHeldAxis;
        return bench;
      };
      Bench slider = make(false), six = make(true);
      for (int step = 0; step < 120; ++step) {
        run(slider, {kSlider, true}, 1);
        run(six, {kSixDegree, true}, 1);
        ASSERT_LT(length(slider.offset(0) - six.offset(0)), 1e-4f) << off << " " << drive << " " << step;
        ASSERT_LT(length(slider.angles(0) - six.angles(0)), 1e-4f);
      }
      EXPECT_GT(length(six.offset(0)), 0.03f);
    }
  }
}

TEST(JointKernelsLinear, SixDegreesHoldAPoseOutOfLine) {
  Bench bench = shelf({});
  const float values[6] = {0.1f, -0.2f, 0.3f, 0.6f, -0.8f, 1.1f};
  for (int axis = 0; axis < 6; ++axis) bench.parameters[0].axis[axis] = held_at(values[axis]);
  run(bench, {kSixDegree, true}, 240);
  EXPECT_LT(length(bench.offset(0) - Vec3{0.1f, -0.2f, 0.3f}), 1e-4f);
  EXPECT_LT(length(bench.angles(0) - Vec3{0.6f, -0.8f, 1.1f}), 1e-4f);
}

TEST(JointKernelsLinear, SixDegreesTurnAsAHingeThroughHalfATurn) {
  Bench bench = shelf({});
  bench.gravity = {0, 0, 0};
  bench.velocity[static_cast<std::size_t>(kFirstBody)].angular[0] = 3;
  bench.velocity[static_cast<std::size_t>(kFirstBody)].linear[1] = -1.5f;  // about the anchor
  JointAxisRow* axes = bench.parameters[0].axis;
  for (const int i : {0, 1, 2, 4, 5}) axes[i] = kHeldAxis;
  for (int step = 0; step < 300; ++step) {  // 15 rad
    run(bench, {kSixDegree, true}, 1);
    ASSERT_LT(length(bench.offset(0)), 1e-3f) << step;
    ASSERT_NEAR(spin_speed(bench, 0).x, 3, 0.01f) << step;
    ASSERT_LT(std::hypot(spin_speed(bench, 0).y, spin_speed(bench, 0).z), 1e-3f) << step;
  }
}

TEST(JointKernelsLinear, SixDegreesStopAnAngleAtItsLimit) {
  Bench bench = shelf({});
  JointAxisRow* axes = bench.parameters[0].axis;
  for (const int i : {0, 1, 2, 4, 5}) axes[i] = kHeldAxis;
  axes[3].upper = 0.4f;
  float most = 0;
  for (int step = 0; step < 240; ++step) {
    run(bench, {kSixDegree, true}, 1);
    most = std::max(most, bench.angles(0).x);
  }
  EXPECT_NEAR(bench.angles(0).x, 0.4f, 1e-3f);
  EXPECT_LT(most, 0.402f);
}

}  // namespace
}  // namespace scree::joint_tests
