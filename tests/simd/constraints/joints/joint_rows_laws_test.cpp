// Laws of each kind of joint made of rows, and of motors and mice: single joints in known motions.
#include "joint_world_fixture.h"

namespace scree::joint_tests {
namespace {

constexpr float kGravity = 9.81f;
const simd::Kernels& widest_set() { return simd::widest_kernels(); }

// Sums up the turns of a body about the x axis of the world.
struct TurnCounter {
  double turn = 0.0, last = 0.0;
  void note(const JointWorld& world, std::int32_t body) {
    const Quat q = world.rotation_of(body);
    const double angle = 2 * std::atan2(double{q.x}, double{q.w});
    turn += std::remainder(angle - last, 2 * std::numbers::pi);
    last = angle;
  }
};

// A shaft that spins freely about the x axis of the world.
std::int32_t add_rotor(JointWorld& world, Vec3 position, float moment, float speed) {
  return world.add_body(1, {moment, moment, moment}, position, {}, {{0, 0, 0}, {speed, 0, 0}, {0, 0}});
}

TEST(GearJoint, KeepsItsRatioOverAThousandTurns) {
  for (const float ratio : {2.0f, -0.7f}) {
    JointWorld world;
    const std::int32_t a = add_rotor(world, {0, 0, 0}, 0.1f, 30);
    const std::int32_t b = add_rotor(world, {0, 1, 0}, 0.3f, -30 / ratio);
    JointParameters p = free_parameters();
    p.axis[0].target = ratio;
    world.add_joint(a, {}, b, {}, p);
    TurnCounter turn_a, turn_b;
    int steps = 0;
    for (; std::abs(turn_a.turn) < 2000 * std::numbers::pi && steps < 40000; ++steps) {
      // Loads that come and go must not make it slip.
      world.force[static_cast<std::size_t>(b)].torque[0] = steps % 200 < 100 ? 3.0f : -3.0f;
      world.step(widest_set(), JointType::gear);
      turn_a.note(world, a);
      turn_b.note(world, b);
      ASSERT_NEAR(turn_a.turn + double{ratio} * turn_b.turn, 0, 2e-3) << "step " << steps;
    }
    EXPECT_GT(std::abs(turn_a.turn), 2000 * std::numbers::pi);
    EXPECT_LT(steps, 40000);
  }
}

// Several turns in a step, and more than half of one in a substep.
TEST(GearJoint, CountsFastTurns) {
  JointWorld world;
  const std::int32_t a = add_rotor(world, {0, 0, 0}, 0.1f, 0), b = add_rotor(world, {0, 1, 0}, 1.0f, 30);
  JointParameters p = free_parameters();
  p.axis[0].target = 12;
  world.add_joint(a, {}, b, {}, p);
  world.dt = 1.0f / 15.0f;
  for (int step = 0; step < 300; ++step) world.step(widest_set(), JointType::gear);
  EXPECT_GT(std::abs(world.angular(a).x), 10.0f);
  EXPECT_NEAR(world.angular(a).x + 12 * world.angular(b).x, 0, 1e-3f);
  // Cayley's formula turns a little less than the speed tells, so the faster shaft falls behind and is taken
  // along: the phase is what the joint holds.
  EXPECT_NEAR(world.impulses[0].impulse[15], 0, 0.3f);
}

TEST(RackAndPinionJoint, KeepsWayAndTurnTogether) {
  constexpr float kRadius = 0.1f;
  JointWorld world;
  const std::int32_t pinion = add_rotor(world, {0, 0, 0}, 0.01f, 0);
  const std::int32_t rack = world.add_body(2, {0.3f, 0.3f, 0.3f}, {0, -kRadius, 0});
  JointParameters p = free_parameters();
  p.axis[0].target = kRadius;
  world.add_joint(pinion, {}, rack, {{0, 0, 0}, about(kY, -kPi / 2)}, p);  // the rack's axis is z
  TurnCounter turned;
  double path = 0.0, last = 0.0;
  for (int step = 0; step < 3000; ++step) {
    world.force[static_cast<std::size_t>(pinion)].torque[0] = step % 200 < 100 ? 0.4f : -0.4f;
    world.step(widest_set(), JointType::rack_and_pinion);
    turned.note(world, pinion);
    path += std::abs(turned.turn - last);
    last = turned.turn;
    const double way = double{world.position_of(rack).z} - double{world.position_of(pinion).z};
    // Cayley's formula turns the pinion a little less than its speed tells, so it is taken along. Nothing of
    // that adds up.
    ASSERT_NEAR(way, double{kRadius} * turned.turn, 5e-4) << "step " << step;
  }
  EXPECT_GT(path, 100.0);
}

struct PulleyCase {
  float mass_a, mass_b, ratio;
  bool rigid;
};

TEST(PulleyJoint, RaisesTheLighterWeight) {
  for (const PulleyCase& c : {PulleyCase{1, 3, 1, false}, PulleyCase{1, 3, 1, true},
                              PulleyCase{2, 5, 2, false}, PulleyCase{3, 1, 0.5f, true}}) {
    JointWorld world;
    world.gravity = {0, -kGravity, 0};
    const Vec3 moment{0.1f, 0.1f, 0.1f};
    const std::int32_t a = world.add_body(c.mass_a, moment, {-1, 0, 0});
    const std::int32_t b = world.add_body(c.mass_b, moment, {1, 0, 0});
    JointParameters p = free_parameters();
    p.axis[0].upper = 5 + c.ratio * 5;
    if (c.rigid) p.axis[0].lower = p.axis[0].upper;
    p.axis[0].target = c.ratio;
    p.axis[1] = {-1, 5, 0, 0, 0, 0, 0, kDriveNone};
    p.axis[2] = {1, 5, 0, 0, 0, 0, 0, kDriveNone};
    world.add_joint(a, {}, b, {}, p);
    // The rope pulls a with T and b with ratio T, and (speed of a) + ratio (speed of b) is 0.
    const float pull = (1 + c.ratio) * kGravity / (1 / c.mass_a + c.ratio * c.ratio / c.mass_b);
    for (int step = 0; step < 30; ++step) world.step(widest_set(), JointType::pulley);
    EXPECT_NEAR(world.linear(a).y, (pull / c.mass_a - kGravity) * 0.5f, 2e-3f);
    EXPECT_NEAR(world.linear(b).y, (c.ratio * pull / c.mass_b - kGravity) * 0.5f, 2e-3f);
    EXPECT_NEAR(world.position_of(a).y + c.ratio * world.position_of(b).y, 0, 1e-3f);
    EXPECT_NEAR(world.reactions[0].force[1], c.ratio * pull, 0.01f * pull);
  }
}

TEST(PulleyJoint, HangsSlack) {
  JointWorld world;
  world.gravity = {0, -kGravity, 0};
  const Vec3 moment{0.1f, 0.1f, 0.1f};
  const std::int32_t a = world.add_body(1, moment, {-1, 0, 0}), b = world.add_body(3, moment, {1, 0, 0});
  JointParameters p = free_parameters();
  p.axis[0].upper = 100;
  p.axis[0].target = 1;
  p.axis[1] = {-1, 5, 0, 0, 0, 0, 0, kDriveNone};
  p.axis[2] = {1, 5, 0, 0, 0, 0, 0, kDriveNone};
  world.add_joint(a, {}, b, {}, p);
  for (int step = 0; step < 30; ++step) world.step(widest_set(), JointType::pulley);
  EXPECT_NEAR(world.linear(a).y, -kGravity * 0.5f, 1e-4f);
  EXPECT_NEAR(world.linear(b).y, -kGravity * 0.5f, 1e-4f);
}

TEST(MouseJoint, DragsAPointToItsTarget) {
  JointWorld world;
  const std::int32_t body = world.add_body(2, {0.1f, 0.2f, 0.25f}, {0, 0, 0});
  world.motion[static_cast<std::size_t>(body)].angular_damping = 3;  // or it would swing on
  const Pose anchor{{0.5f, 0.3f, 0.2f}, {}};
  JointParameters p = free_parameters();
  p.axis[0] = {0, 0, 0, 0, 5, 0.7f, kNoLimit, kDriveSpring};
  p.axis[1] = {3, 1, -2, 0, 0, 0, 0, kDriveNone};
  const std::size_t joint = world.add_joint(0, {}, body, anchor, p);
  for (int step = 0; step < 600; ++step) world.step(widest_set(), JointType::mouse);
  EXPECT_LT(length(world.frame_b(joint).position - Vec3{3, 1, -2}), 1e-3f);
}

TEST(MouseJoint, PullsNoHarderThanAllowed) {
  JointWorld world;
  world.gravity = {0, -kGravity, 0};
  const std::int32_t body = world.add_body(2, {0.1f, 0.1f, 0.1f}, {0, 0, 0});
  JointParameters p = free_parameters();
  p.axis[0] = {0, 0, 0, 0, 5, 0.7f, 5.0f, kDriveSpring};
  p.axis[1] = {0, 100, 0, 0, 0, 0, 0, kDriveNone};
  world.add_joint(0, {}, body, {}, p);
  for (int step = 0; step < 60; ++step) world.step(widest_set(), JointType::mouse);
  EXPECT_NEAR(world.linear(body).y, 5.0f / 2 - kGravity, 1e-3f);
  EXPECT_NEAR(world.reactions[0].force[1], 5.0f, 1e-4f);
}

JointParameters motor_parameters(std::uint32_t drive, Vec3 target, Quat rotation, Vec3 velocity,
                                 Vec3 angular) {
  JointParameters p = free_parameters();
  p.axis[2] = {0, 0, 0, 0, 1, 1, kNoLimit, drive};
  p.axis[0].speed = angular.x;
  p.axis[1].speed = angular.y;
  p.axis[2].speed = angular.z;
  p.axis[3] = {rotation.x, rotation.y, rotation.z, rotation.w, 0, 0, 0, kDriveNone};
  p.axis[4] = {target.x, target.y, target.z, 0, 1, 1, kNoLimit, drive};
  p.axis[5] = {velocity.x, velocity.y, velocity.z, 0, 0, 0, 0, kDriveNone};
  return p;
}

// By the sine of half the angle between them.
float apart(Quat a, Quat b) {
  const Quat q = conjugate(a) * b;
  return length(Vec3{q.x, q.y, q.z});
}

TEST(MotorJoint, ReachesItsPose) {
  const Pose target{{1, -2, 0.5f}, about({1, 2, 3}, 2.5f)};
  for (const bool against_world : {true, false}) {
    JointWorld world;
    const Vec3 moment{0.2f, 0.3f, 0.4f};
    const std::int32_t a = against_world ? 0 : world.add_body(3, moment, {1, 1, 1}, about({3, 1, 0}, 1));
    const std::int32_t b = world.add_body(2, moment, {0, 3, 0}, about({0, 1, 1}, 2));
    const std::size_t joint =
        world.add_joint(a, {{0.1f, 0.2f, 0.3f}, about(kY, 0.4f)}, b, {{0, 0.2f, 0}, about(kX, 0.3f)},
                        motor_parameters(kDriveSpring, target.position, target.rotation, {}, {}));
    for (int step = 0; step < 600; ++step) world.step(widest_set(), JointType::motor);
    const Pose from = world.frame_a(joint), to = world.frame_b(joint);
    EXPECT_LT(length(rotate_back(from.rotation, to.position - from.position) - target.position), 1e-3f);
    EXPECT_LT(apart(conjugate(from.rotation) * to.rotation, target.rotation), 1e-3f);
  }
}

TEST(MotorJoint, KeepsItsSpeedsAgainstALoad) {
  JointWorld world;  // with gravity
  const std::int32_t b = world.add_body(2, {0.2f, 0.3f, 0.4f}, {0, 0, 0});
  const Quat axes = about(kZ, 0.5f);
  world.add_joint(0, {{0, 0, 0}, axes}, b, {},
                  motor_parameters(kDriveMotor, {}, {}, {1, 2, 3}, {0.5f, 1, 2}));
  for (int step = 0; step < 30; ++step) world.step(widest_set(), JointType::motor);
  EXPECT_LT(length(world.linear(b) - rotate(axes, {1, 2, 3})), 1e-4f);
  EXPECT_LT(length(world.angular(b) - rotate(axes, {0.5f, 1, 2})), 1e-4f);
}

TEST(MotorJoint, FollowsATargetThatMoves) {
  JointWorld world;
  const std::int32_t b = world.add_body(2, {0.2f, 0.3f, 0.4f}, {0, 0, 0});
  const Vec3 velocity{0.5f, 0, 1}, angular{0, 0.7f, 0};
  const std::size_t joint =
      world.add_joint(0, {}, b, {}, motor_parameters(kDriveSpring, {}, {}, velocity, angular));
  for (int step = 0; step < 180; ++step) {
    const float now = static_cast<float>(step) * world.dt;
    const Quat rotation = about(kY, 0.7f * now);
    world.parameters[joint] = motor_parameters(kDriveSpring, velocity * now, rotation, velocity, angular);
    world.step(widest_set(), JointType::motor);
  }
  EXPECT_LT(length(world.position_of(b) - velocity * 3.0f), 5e-3f);
  EXPECT_LT(apart(world.rotation_of(b), about(kY, 2.1f)), 5e-3f);
}

struct AxesCase {
  JointType type;
  float at[3];  // coordinates of its axes
  Pose pose;    // of frame b in frame a where they are that
};

const AxesCase kAxesCases[] = {
    {JointType::wheel, {0.1f, 0.4f, 0}, {{0.1f, 0, 0}, about(kX, 0.4f)}},
    {JointType::universal, {2.0f, -0.8f, 0}, {{0, 0, 0}, about(kX, 2.0f) * about(kY, -0.8f)}},
    {JointType::universal, {-3.0f, 0.3f, 0}, {{0, 0, 0}, about(kX, -3.0f) * about(kY, 0.3f)}},
    {JointType::planar, {0.7f, -0.4f, 1.2f}, {{0, 0.7f, -0.4f}, about(kX, 1.2f)}},
};

// By springs, and by equal limits. A wheel's spin stops by a motor.
TEST(RowAxes, GoToTheirTargets) {
  for (const bool limited : {false, true}) {
    for (const AxesCase& c : kAxesCases) {
      JointWorld world;
      const std::int32_t a = world.add_body(3, {0.3f, 0.2f, 0.4f}, {1, 1, 1}, about({3, 1, 0}, 1));
      const std::int32_t b = world.add_body(2, {0.2f, 0.3f, 0.4f}, {1, 1, 1}, about({3, 1, 0}, 1));
      JointParameters p = free_parameters();
      for (int i = 0; i < 3; ++i) {
        const float end = limited ? c.at[i] : kNoLimit;
        p.axis[i] = {
            limited ? end : -end, end, c.at[i], 0, 2, 1, kNoLimit, limited ? kDriveNone : kDriveSpring};
      }
      if (c.type == JointType::wheel) p.axis[2] = {-kNoLimit, kNoLimit, 0, 0, 1, 1, kNoLimit, kDriveMotor};
      const std::size_t joint = world.add_joint(a, {}, b, {}, p);
      for (int step = 0; step < 240; ++step) world.step(widest_set(), c.type);
      const Pose from = world.frame_a(joint), to = world.frame_b(joint);
      EXPECT_LT(length(rotate_back(from.rotation, to.position - from.position) - c.pose.position), 2e-3f);
      const Quat turned = conjugate(from.rotation) * to.rotation;
      if (c.type == JointType::wheel) {  // which has spun a little
        EXPECT_LT(length(rotate(turned, kZ) - rotate(c.pose.rotation, kZ)), 2e-3f);
      } else {
        EXPECT_LT(apart(turned, c.pose.rotation), 2e-3f);
      }
    }
  }
}

TEST(RowAxes, StayWithinTheirLimits) {
  for (const AxesCase& c : kAxesCases) {
    JointWorld world;
    const std::int32_t a = world.add_body(3, {0.3f, 0.2f, 0.4f}, {1, 1, 1});
    const std::int32_t b = world.add_body(2, {0.2f, 0.3f, 0.4f}, {1, 1, 1});
    JointParameters p = free_parameters();
    for (int i = 0; i < 2; ++i) {
      // A motor drives the axis on and on, beyond the end.
      const float end = c.at[i], way = end > 0 ? 1.0f : -1.0f;
      p.axis[i] = {end > 0 ? -kNoLimit : end, end > 0 ? end : kNoLimit, 0, 5 * way, 1, 1, 2, kDriveMotor};
    }
    const std::size_t joint = world.add_joint(a, {}, b, {}, p);
    for (int step = 0; step < 240; ++step) world.step(widest_set(), c.type);
    const Pose from = world.frame_a(joint), to = world.frame_b(joint);
    const Vec3 offset = rotate_back(from.rotation, to.position - from.position);
    const Quat turned = conjugate(from.rotation) * to.rotation;
    if (c.type == JointType::planar) {
      EXPECT_LT(length(offset - c.pose.position), 5e-3f);
    } else if (c.type == JointType::wheel) {
      EXPECT_LT(length(offset - c.pose.position), 5e-3f);
      EXPECT_LT(length(rotate(turned, kZ) - rotate(c.pose.rotation, kZ)), 5e-3f);
    } else {
      EXPECT_LT(apart(turned, c.pose.rotation), 5e-3f);
    }
  }
}

// A weight on a lever, held at half a turn from either side: an angle a little beyond reads as its negative.
TEST(RowAxes, HoldALoadAtHalfATurn) {
  for (const JointType type : {JointType::universal, JointType::planar, JointType::six_degree}) {
    const int angle = type == JointType::universal ? 0 : type == JointType::planar ? 2 : 3;
    for (const float side : {0.5f, -0.5f}) {
      for (const Vec3 limits : {Vec3{kPi, kPi, 0}, Vec3{0, kPi, 0}, Vec3{-kPi, 0, 0}}) {
        JointWorld world;
        world.gravity = kWeight;
        const float end = limits.x == 0 ? limits.y : limits.x;
        const std::int32_t body = world.add_body(2, {0.2f, 0.3f, 0.4f}, {0, 0, side}, about(kX, end));
        JointParameters p = free_parameters();
        for (JointAxisRow& axis : p.axis) axis = kHeldAxis;
        p.axis[angle].lower = limits.x;
        p.axis[angle].upper = limits.y;
        const std::size_t joint = world.add_joint(0, {}, body, {{0, 0, side}, {}}, p);
        // The weight turns it to the side: past the end, or away from it.
        const bool falls = limits.x != limits.y && (side > 0) != (end > 0);
        for (int step = 0; step < 60; ++step) {
          world.step(widest_set(), type);
          if (falls) break;
          EXPECT_LT(apart(world.rotation_of(body), about(kX, kPi)), 5e-3f)
              << static_cast<int>(type) << " " << side << " " << limits.x << " step " << step;
        }
        EXPECT_LT(length(world.frame_b(joint).position), 1e-3f);
      }
    }
  }
}

// A held coordinate of a soft joint is a spring of its hertz, whichever kind holds it.
TEST(RowAxes, OfASoftJointSwingWhereTheirLimitsAreEqual) {
  for (const JointType type :
       {JointType::wheel, JointType::planar, JointType::slider, JointType::six_degree}) {
    JointWorld world;
    const std::int32_t body = world.add_body(2, {0.2f, 0.2f, 0.2f}, {0, 0.1f, 0});
    JointParameters p = free_parameters();
    for (JointAxisRow& axis : p.axis) axis = kHeldAxis;
    p.hertz = p.angular_hertz = 2;
    p.damping_ratio = p.angular_damping_ratio = 0;
    const Quat up =
        type == JointType::planar ? Quat{} : about(kZ, kPi / 2);  // the first axis: y of the world
    world.add_joint(0, {{0, 0, 0}, up}, body, {{0, 0, 0}, up}, p);
    int crossings = 0;
    float before = 0.1f;
    for (int step = 0; step < 300; ++step) {
      world.step(widest_set(), type);
      const float now = world.position_of(body).y;
      if ((now > 0) != (before > 0)) ++crossings;
      before = now;
    }
    EXPECT_NEAR(crossings, 20, 1) << static_cast<int>(type);  // 2 Hz, for 5 s
  }
}

TEST(PlanarJoint, TurnsBackFromOpposedPlanes) {
  JointWorld world;
  const std::int32_t body = world.add_body(2, {0.2f, 0.3f, 0.4f}, {0, 0, 0}, about(kY, kPi));
  const std::size_t joint = world.add_joint(0, {}, body, {}, free_parameters());
  for (int step = 0; step < 240; ++step) world.step(widest_set(), JointType::planar);
  EXPECT_GT(rotate(world.frame_b(joint).rotation, kX).x, 0.9999f);
}

// Whatever the wheel weighs: a chassis on a suspension of f Hz sinks by g / (2 pi f)^2.
TEST(WheelJoint, SinksAsItsHertzTell) {
  for (const float mass : {10.0f, 1000.0f}) {
    JointWorld world;
    world.gravity = {0, -kGravity, 0};
    const std::int32_t chassis = world.add_body(mass, {mass, mass, mass}, {0, 1, 0});
    JointParameters p = free_parameters();
    p.axis[0] = {-kNoLimit, kNoLimit, 0, 0, 2, 0.7f, kNoLimit, kDriveSpring};
    p.axis[1].lower = p.axis[1].upper = 0;
    const Quat up = about(kZ, kPi / 2);  // x of the frames is y of the world
    world.add_joint(chassis, {{0, 0, 0}, up}, 0, {{0, 1, 0}, up}, p);
    for (int step = 0; step < 180; ++step) world.step(widest_set(), JointType::wheel);
    const float rate = 2 * kPi * 2;
    EXPECT_NEAR(1 - world.position_of(chassis).y, kGravity / (rate * rate), 1e-3f);
  }
}

TEST(WheelJoint, SpinsUpToItsMotorsSpeedWithTheMotorsTorque) {
  JointWorld world;
  const std::int32_t wheel = world.add_body(20, {0.8f, 0.8f, 1.2f}, {0, 0, 0});
  JointParameters p = free_parameters();
  p.axis[0].lower = p.axis[0].upper = p.axis[1].lower = p.axis[1].upper = 0;
  p.axis[2] = {-kNoLimit, kNoLimit, 0, 10, 1, 1, 6, kDriveMotor};
  world.add_joint(0, {}, wheel, {}, p);
  for (int step = 0; step < 60; ++step) world.step(widest_set(), JointType::wheel);
  EXPECT_NEAR(world.angular(wheel).z, 6.0f / 1.2f, 1e-3f);
  for (int step = 0; step < 120; ++step) world.step(widest_set(), JointType::wheel);
  EXPECT_NEAR(world.angular(wheel).z, 10.0f, 1e-3f);
  EXPECT_LT(length(world.position_of(wheel)), 1e-4f);
}

}  // namespace
}  // namespace scree::joint_tests
