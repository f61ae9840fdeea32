// Sliders: held axes, limits, drives.
#include <tests/physics/lab.h>

#include <algorithm>
#include <cmath>

namespace scree::physics {
namespace {

const Quat kUpright = rotation_about({0, 0, 1}, 0.5 * 3.14159265358979);  // x points up

// Anchor b, and the rotation of frame b, as seen from frame a.
struct Seen {
  Eigen::Vector3d offset;
  double angle;
};
Seen look_at(const World& world, JointId joint) {
  const JointDef def = world.joint_def(joint);
  const auto place = [&](BodyId body, const Pose& frame) {
    const Pose pose = body == kWorld ? Pose{} : world.pose(body);
    const Eigen::Quaterniond q = to_eigen(pose.rotation);
    return std::pair{Eigen::Vector3d(to_eigen(pose.position) + q * to_eigen(frame.position)),
                     Eigen::Quaterniond(q * to_eigen(frame.rotation))};
  };
  const auto [anchor_a, rotation_a] = place(def.body_a, def.frame_a);
  const auto [anchor_b, rotation_b] = place(def.body_b, def.frame_b);
  return {rotation_a.conjugate() * (anchor_b - anchor_a), rotation_a.angularDistance(rotation_b)};
}

// A cube of 1000 kg on a rail of the world through the origin. Its center is 0.5 m off the rail.
struct Rail {
  Lab lab;
  BodyId cube;
  JointId joint;

  explicit Rail(const JointAxis& axis = {}, Quat rotation = {},
                const WorldSettings& settings = without_sleep())
      : lab(settings) {
    cube = lab.add({.position = {0, 0, 0.5f}}, Box{{0.5f, 0.5f, 0.5f}});
    joint = lab.world.create_joint(
        {.body_a = kWorld, .body_b = cube, .frame_a = {{}, rotation}, .frame_b = {{0, 0, -0.5f}, rotation}},
        SliderJoint{axis});
  }
  Seen seen() const { return look_at(lab.world, joint); }
};

TEST(SliderJoint, HoldsItsAxesUnderAWeightBesideTheRail) {
  for (const bool limited : {false, true}) {
    Rail rail(limited ? JointAxis{.lower = -1, .upper = 1} : JointAxis{});
    for (int i = 0; i < 240; ++i) {
      rail.lab.run(1);
      const Seen seen = rail.seen();
      ASSERT_LT(std::hypot(seen.offset.y(), seen.offset.z()), 1e-4) << i;
      ASSERT_LT(seen.angle, 1e-4) << i;
    }
    const JointReaction reaction = rail.lab.world.joint_reaction(rail.joint);
    const double weight = rail.lab.mass(rail.cube) * kGravity;
    EXPECT_NEAR(reaction.force.y / weight, 1.0, 1e-3);
    EXPECT_NEAR(reaction.torque.x / (-0.5 * weight), 1.0, 1e-3);
  }
}

TEST(SliderJoint, StopsAtItsLimit) {
  Rail rail({.lower = -0.5f, .upper = 0.2f}, kUpright);
  double lowest = 0.0;
  for (int i = 0; i < 240; ++i) {
    rail.lab.run(1);
    lowest = std::min(lowest, rail.seen().offset.x());
  }
  EXPECT_GT(lowest, -0.502);
  EXPECT_LT(rail.seen().offset.x(), -0.499);
}

TEST(SliderJoint, OfEqualLimitsHoldsItsPlace) {
  Rail rail({.lower = 0.3f, .upper = 0.3f}, kUpright);
  rail.lab.run(240);
  EXPECT_NEAR(rail.seen().offset.x(), 0.3, 1e-4);
}

TEST(SliderJoint, ItsMotorReachesItsSpeedWithBoundedForce) {
  const float mass = 1000.0f;
  Rail rail({.drive = Drive::motor, .speed = 1.0f, .max_force = 2 * mass});
  rail.lab.run(24);
  EXPECT_NEAR(rail.lab.velocity(rail.cube).x(), 0.8, 1e-3);
  EXPECT_NEAR(rail.lab.world.joint_reaction(rail.joint).force.x, 2 * mass, 2.0f);
  rail.lab.run(24);
  EXPECT_NEAR(rail.lab.velocity(rail.cube).x(), 1.0, 1e-4);
}

// Two bodies that slide on their common axis; measures the times at which they pass the middle.
TEST(SliderJoint, ItsSpringHasItsFrequency) {
  Lab lab(without_gravity());
  const BodyId a = lab.add({.position = {0, 0, 0.3f}}, Box{{0.5f, 0.5f, 0.5f}});
  const BodyId b = lab.add({.position = {2, 0, -0.3f}}, Box{{0.3f, 0.5f, 0.5f}});
  const JointId joint = lab.world.create_joint(
      {.body_a = a, .body_b = b, .frame_a = {{0, 0, -0.3f}, {}}, .frame_b = {{0, 0, 0.3f}, {}}},
      SliderJoint{{.drive = Drive::spring, .target = 1.5f, .hertz = 2.0f, .damping_ratio = 0.0f}});
  double first = 0.0, last = 0.0, before = 0.5;
  int count = -1;
  for (int i = 0; i < 600; ++i) {
    lab.run(1);
    const double now = look_at(lab.world, joint).offset.x() - 1.5;
    if (before > 0.0 && now <= 0.0) {
      last = (i + before / (before - now)) * static_cast<double>(kStep);
      if (++count == 0) first = last;
    }
    before = now;
  }
  ASSERT_GT(count, 10);
  EXPECT_NEAR(count / (last - first), 2.0, 0.04);
}

TEST(SliderJoint, OfFreeBodiesKeepsTheirMomentum) {
  Lab lab(without_gravity());
  const BodyId a = lab.add({}, Box{{0.5f, 0.5f, 0.5f}});
  const BodyId b = lab.add({.position = {2, 0.5f, 0}}, Box{{0.4f, 0.4f, 0.4f}});
  const JointId joint = lab.world.create_joint(
      {.body_a = a, .body_b = b, .frame_a = {{1, 0, 0}, {}}, .frame_b = {{-1, -0.5f, 0}, {}}}, SliderJoint{});
  lab.world.set_linear_velocity(b, {0.5f, 1, 0});
  lab.world.set_angular_velocity(a, {1, 0, 1});
  const auto momentum = [&] {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const BodyId body : {a, b}) {
      sum += lab.angular_momentum(body) + lab.position(body).cross(lab.mass(body) * lab.velocity(body));
    }
    return sum;
  };
  const Eigen::Vector3d before = momentum();
  for (int i = 0; i < 120; ++i) {
    lab.run(1);
    const Seen seen = look_at(lab.world, joint);
    ASSERT_LT(std::hypot(seen.offset.y(), seen.offset.z()), 5e-3) << i;
    ASSERT_LT(seen.angle, 5e-3) << i;
  }
  EXPECT_LT((momentum() - before).norm(), 2e-3 * before.norm());
}

}  // namespace
}  // namespace scree::physics
