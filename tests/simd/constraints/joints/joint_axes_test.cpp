// Laws of the limits and drives of hinges and balls, and of soft welds.
#include "joint_world_fixture.h"

namespace scree::joint_tests {
namespace {

constexpr int kRichBall = simd::joint_variant(JointType::ball, true),
              kRichHinge = simd::joint_variant(JointType::hinge, true);
constexpr int kWeld = simd::joint_variant(JointType::weld, false);

// A bar of 1 kg and 1 m that turns about its end, which is the origin, about the z axis of the world.
struct Bar {
  JointWorld world;
  std::int32_t body;
  std::size_t joint;

  explicit Bar(const JointAxisRow& axis, float spin = 0.0f) {
    JointParameters p = free_rotation();
    p.axis[0] = axis;
    world.gravity = kWeight;
    const Quat to_z = about({0, 1, 0}, -kPi / 2);
    body = world.add_body(1, {0.01f, 1.0f / 12, 1.0f / 12}, {0.5f, 0, 0}, {},
                          {{0, 0.5f * spin, 0}, {0, 0, spin}});
    joint = world.add_joint(kFixedRow, {{}, to_z}, body, {{-0.5f, 0, 0}, to_z}, p);
  }
  static constexpr float kInertia = 1.0f / 3;  // about the end
  float angle() const {
    const Vec3 along = rotate(world.rotation_of(body), {1, 0, 0});
    return std::atan2(along.y, along.x);
  }
  float speed() const { return world.angular(body).z; }
  void step() { world.step(scalar_kernels(), kRichHinge); }
};

JointAxisRow no_axis() { return free_rotation().axis[0]; }

TEST(HingeAxis, AMotorReachesItsSpeedWithItsTorqueAndNoMore) {
  JointAxisRow axis = no_axis();
  axis.drive = kDriveMotor;
  axis.speed = 3.0f;
  axis.max_force = 0.5f;
  Bar bar(axis);
  bar.world.gravity = {0, 0, 0};
  const float time = axis.speed * Bar::kInertia / axis.max_force;  // 2 s
  for (int step = 0; step < 60; ++step) bar.step();
  EXPECT_NEAR(bar.speed(), axis.speed / time, 0.01f);
  EXPECT_NEAR(bar.world.reactions[bar.joint].torque[2], axis.max_force, 1e-3f);
  for (int step = 60; step < 180; ++step) bar.step();
  EXPECT_NEAR(bar.speed(), axis.speed, 1e-3f);
}

TEST(HingeAxis, AMotorAtRestIsDryFriction) {
  for (const float torque : {4.8f, 5.0f}) {  // the bar's weight asks for 4.905
    JointAxisRow axis = no_axis();
    axis.drive = kDriveMotor;
    axis.max_force = torque;
    Bar bar(axis);
    for (int step = 0; step < 120; ++step) bar.step();
    if (torque > 4.905f) {
      EXPECT_NEAR(bar.angle(), 0, 1e-3f);
    } else {
      EXPECT_LT(bar.angle(), -0.05f);
    }
  }
}

TEST(HingeAxis, LimitsArePassedByAtMostHalfADegree) {
  for (const float spin : {0.0f, -3.0f, 3.0f, -10.0f, 10.0f}) {
    JointAxisRow axis = no_axis();
    axis.lower = -1.0f;
    axis.upper = 3.0f;  // the bar passes pi where it is passed
    Bar bar(axis, spin);
    float least = 0, most = 0;
    for (int step = 0; step < 300; ++step) {
      bar.step();
      least = std::min(least, bar.angle());
      most = std::max(most, bar.angle());
    }
    EXPECT_GT(least, -1.0f - kPi / 360) << spin;
    EXPECT_LT(most, 3.0f + kPi / 360) << spin;
    // Lies on one of them in the end: past the top the weight pulls to the upper one.
    EXPECT_NEAR(bar.angle(), spin > 5 ? 3.0f : -1.0f, 2e-3f) << spin;
  }
}

// Of a soft joint a limit is a spring that begins there: without damping half a swing is its overshoot.
TEST(HingeAxis, SoftLimitsAreSpringsThatTakeNothingAway) {
  for (const float start : {0.0f, 0.013f, 0.029f, 0.041f}) {
    JointWorld world;
    const Quat to_z = about({0, 1, 0}, -kPi / 2);
    const std::int32_t body = world.add_body(1, {0.1f, 0.1f, 0.1f}, {}, {}, {{}, {0, 0, 5}});
    JointParameters p = free_rotation();
    p.axis[0].lower = -0.5f - start;
    p.axis[0].upper = 0.5f + start;
    p.hertz = p.angular_hertz = 2.0f;
    p.damping_ratio = p.angular_damping_ratio = 0.0f;
    world.add_joint(kFixedRow, {{}, to_z}, body, {{}, to_z}, p);
    float least = 0, most = 0;
    for (int step = 0; step < 60; ++step) {
      world.step(scalar_kernels(), kRichHinge);
      const Quat q = world.rotation_of(body);
      const float angle = 2 * std::atan2(q.z, q.w);
      least = std::min(least, angle);
      most = std::max(most, angle);
    }
    const float overshoot = 5.0f / (2 * kPi * 2);
    EXPECT_NEAR(most - p.axis[0].upper, overshoot, 0.1f * overshoot) << start;
    EXPECT_NEAR(p.axis[0].lower - least, 0.85f * overshoot, 0.15f * overshoot)
        << "after a swing, implicitly damped";
  }
}

TEST(HingeAxis, EqualLimitsHoldTheAngle) {
  JointAxisRow axis = no_axis();
  axis.lower = axis.upper = 0.5f;
  Bar bar(axis);
  for (int step = 0; step < 120; ++step) bar.step();
  EXPECT_NEAR(bar.angle(), 0.5f, 1e-3f);
  EXPECT_NEAR(bar.speed(), 0.0f, 1e-3f);
}

TEST(HingeAxis, ASpringSwingsAtItsFrequency) {
  JointAxisRow axis = no_axis();
  axis.drive = kDriveSpring;
  axis.target = 0.4f;
  axis.hertz = 1.0f;
  axis.damping_ratio = 0.0f;
  Bar bar(axis);
  bar.world.gravity = {0, 0, 0};
  int crossings = 0;
  float before = -0.4f;
  for (int step = 0; step < 600; ++step) {
    bar.step();
    const float now = bar.angle() - axis.target;
    if ((now > 0) != (before > 0)) ++crossings;
    before = now;
  }
  EXPECT_NEAR(crossings, 20, 1);  // two a second, for 10 s
}

TEST(HingeAxis, ASpringTakesTheShorterWayAndFollowsItsMovingTarget) {
  JointAxisRow axis = no_axis();
  axis.drive = kDriveSpring;
  axis.target = 2 * kPi - 0.5f;
  axis.hertz = 3.0f;
  Bar bar(axis);
  bar.world.gravity = {0, 0, 0};
  for (int step = 0; step < 120; ++step) {
    bar.step();
    EXPECT_LT(bar.angle(), 1e-3f);
  }
  EXPECT_NEAR(bar.angle(), -0.5f, 1e-3f);
  for (int step = 0; step < 240; ++step) {  // the caller's target moves at 2 rad/s
    bar.world.parameters[0].axis[0].speed = 2.0f;
    bar.world.parameters[0].axis[0].target = -0.5f + 2.0f * static_cast<float>(step) / 60;
    bar.step();
  }
  EXPECT_NEAR(std::remainder(bar.angle() - (-0.5f + 8.0f), 2 * kPi), 0.0f, 5e-3f);
}

// A bar that hangs from its end by a ball joint; x along the bar.
struct Hanging {
  JointWorld world;
  std::int32_t body;
  std::size_t joint;

  Hanging(const JointParameters& p, Quat rotation, Vec3 spin) {
    world.gravity = kWeight;
    const Vec3 arm = rotate(rotation, {0.5f, 0, 0});
    const Vec3 moment{0.02f, 1.0f / 12, 1.0f / 12};
    body = world.add_body(1, moment, arm, rotation, {cross(spin, arm), spin});
    joint = world.add_joint(kFixedRow, {}, body, {{-0.5f, 0, 0}, {}}, p);
  }
  void step() { world.step(scalar_kernels(), kRichBall); }
  float cone() const {
    return std::acos(std::clamp(rotate(world.rotation_of(body), {1, 0, 0}).x, -1.0f, 1.0f));
  }
  float twist() const {
    const Quat q = world.rotation_of(body);
    return std::remainder(2 * std::atan2(q.x, q.w), 2 * kPi);
  }
};

TEST(BallLimits, TheConeIsPassedByAtMostHalfADegree) {
  for (const float limit : {0.3f, 1.0f, 2.5f}) {
    for (int k = 0; k < 12; ++k) {
      Random random(static_cast<unsigned>(k));
      Vec3 spin = random.vector(1);
      spin = (k % 3 == 0 ? 2.0f : 10.0f) / length(spin) * spin;
      JointParameters p = free_rotation();
      p.axis[1].upper = limit;
      Hanging bar(p, {}, spin);
      float most = 0;
      for (int step = 0; step < 240; ++step) {
        bar.step();
        most = std::max(most, bar.cone());
      }
      EXPECT_LT(most, limit + kPi / 360) << limit << " " << k;
      EXPECT_GT(most, 0.9f * std::min(limit, 1.0f)) << limit << " " << k;  // it has been there
    }
  }
}

TEST(BallLimits, TheTwistIsPassedByAtMostHalfADegree) {
  for (int k = 0; k < 12; ++k) {
    Random random(static_cast<unsigned>(k));
    Vec3 spin = random.vector(1);
    spin = 10.0f / length(spin) * spin;
    JointParameters p = free_rotation();
    p.axis[0].lower = -0.4f;
    p.axis[0].upper = 0.7f;
    p.axis[1].upper = 2.0f;  // nearer to pi no twist is defined
    Hanging bar(p, {}, spin);
    float least = 0, most = 0;
    for (int step = 0; step < 240; ++step) {
      bar.step();
      least = std::min(least, bar.twist());
      most = std::max(most, bar.twist());
    }
    EXPECT_GT(least, -0.4f - kPi / 360) << k;
    EXPECT_LT(most, 0.7f + kPi / 360) << k;
    EXPECT_TRUE(least < -0.35f || most > 0.65f) << k;
  }
}

TEST(BallLimits, NothingBreaksWhereTheAxesAreOpposite) {
  JointParameters p = free_rotation();
  p.axis[0].lower = p.axis[0].upper = 0.0f;
  p.axis[1].upper = 1.0f;
  Hanging bar(p, about({0, 0, 1}, kPi), {});
  for (int step = 0; step < 240; ++step) {
    bar.step();
    EXPECT_LT(length(bar.world.angular(bar.body)), 20.0f);
  }
  EXPECT_LT(bar.cone(), 1.0f + kPi / 360);
}

TEST(BallDrive, ASpringHoldsItsTarget) {
  JointParameters p = free_rotation();
  const Quat target = about({1, 2, -1}, 1.2f);
  p.axis[2].drive = kDriveSpring;
  p.axis[2].hertz = 4.0f;
  p.axis[3] = {target.x, target.y, target.z, target.w, 1, 1, 0, kDriveNone};
  Hanging bar(p, {}, {});
  bar.world.gravity = {0, 0, 0};
  for (int step = 0; step < 180; ++step) bar.step();
  const Quat off = bar.world.rotation_of(bar.body) * conjugate(target);
  EXPECT_LT(length(Vec3{off.x, off.y, off.z}), 1e-3f);
}

TEST(BallDrive, AMotorTurnsAtItsVelocityWithAtMostItsTorque) {
  JointParameters p = free_rotation();
  p.axis[2].drive = kDriveMotor;
  p.axis[2].max_force = 0.5f;
  p.axis[1].speed = 3.0f;  // about y, where the bar has 1/3 kg m^2
  Hanging bar(p, {}, {});
  bar.world.gravity = {0, 0, 0};
  for (int step = 0; step < 60; ++step) {
    bar.step();
    const float* torque = bar.world.reactions[0].torque;
    EXPECT_LE(std::hypot(torque[0], torque[1], torque[2]), 0.5001f);
  }
  EXPECT_NEAR(bar.world.angular(bar.body).y, 1.5f, 0.02f);
  for (int step = 0; step < 120; ++step) bar.step();
  EXPECT_NEAR(bar.world.angular(bar.body).y, 3.0f, 0.01f);
}

TEST(Weld, ACantileverStaysStraightUnderItsWeight) {
  JointWorld world;
  world.gravity = kWeight;
  const float m = 5.0f;
  const std::int32_t beam = world.add_body(m, {0.02f, m / 12, m / 12}, {0.5f, 0, 0});
  const std::size_t joint = world.add_joint(kFixedRow, {}, beam, {{-0.5f, 0, 0}, {}});
  for (int step = 0; step < 120; ++step) {
    world.step(scalar_kernels(), kWeld);
    EXPECT_LT(length(world.frame_b(joint).position), 1.2e-4f);
    const Quat q = world.rotation_of(beam);
    EXPECT_LT(2 * length(Vec3{q.x, q.y, q.z}), 1e-4f);
  }
  EXPECT_NEAR(world.reactions[joint].force[1], m * 9.81f, 0.01f * m * 9.81f);
  EXPECT_NEAR(world.reactions[joint].torque[2], m * 9.81f * 0.5f, 0.01f * m * 9.81f * 0.5f);
}

// The rotation's spring is about the anchor, with all the inertia that turns there.
TEST(Weld, ASoftRotationSwingsAtItsFrequencyAboutTheAnchor) {
  JointWorld world;
  world.gravity = {0, 0, 0};
  JointParameters p = free_rotation();
  p.angular_hertz = 1.0f;
  p.angular_damping_ratio = 0.0f;
  const Quat tilted = about({0, 0, 1}, 0.3f);
  const std::int32_t beam =
      world.add_body(5, {0.02f, 5.0f / 12, 5.0f / 12}, rotate(tilted, {0.5f, 0, 0}), tilted);
  world.add_joint(kFixedRow, {}, beam, {{-0.5f, 0, 0}, {}}, p);
  int crossings = 0;
  bool before = true;
  for (int step = 0; step < 600; ++step) {
    world.step(scalar_kernels(), kWeld);
    const bool now = world.rotation_of(beam).z > 0;
    if (now != before) ++crossings;
    before = now;
    EXPECT_LT(length(world.frame_b(0).position), 1e-3f);
  }
  EXPECT_NEAR(crossings, 20, 1);
}

// As parallel/solvers/solve.cpp packs bodies with locks: their inertia has zero rows.
TEST(Weld, BodiesWithLockedRotationsAreHeldAboutTheOthers) {
  JointWorld world;
  world.gravity = kWeight;
  const std::int32_t body = world.add_body(1, {1, 1, 0.1f}, {0.5f, 0, 0}, {}, {{}, {0, 0, 5}});
  const auto row = static_cast<std::size_t>(body);
  world.motion[row].flags = kMotionJointed | 1u << 3 | 1u << 4;  // turns about z alone
  world.add_joint(kFixedRow, {}, body, {{-0.5f, 0, 0}, {}});
  for (int step = 0; step < 60; ++step) world.step(scalar_kernels(), kWeld);
  EXPECT_NEAR(world.rotation_of(body).z, 0.0f, 1e-3f);
  EXPECT_NEAR(world.angular(body).z, 0.0f, 1e-3f);
}

}  // namespace
}  // namespace scree::joint_tests
