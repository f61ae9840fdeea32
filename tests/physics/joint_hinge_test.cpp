// Hinges, ball joints with limits, and welds in a world.
#include <tests/physics/lab.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace scree::physics {
namespace {

constexpr double kHingePi = std::numbers::pi;
constexpr double kHalfDegree = 0.5 / 180 * kHingePi;

// A rotation that takes the x axis to the given one.
Quat x_to(Vec3 axis) {
  const Eigen::Quaterniond q =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitX(), to_eigen(axis).normalized());
  return {static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
          static_cast<float>(q.w())};
}

// A plate that a joint with the given axis, a frame's x axis, holds at its edge at the origin.
struct Flap {
  Lab lab;
  BodyId plate;
  JointId joint;

  Flap(const Joint& kind, Vec3 axis, const WorldSettings& settings = without_sleep()) : lab(settings) {
    plate = lab.add({.position = {0.5f, 0, 0}}, Box{{0.5f, 0.05f, 0.4f}});
    const Quat turn = x_to(axis);
    joint = lab.world.create_joint(
        {.body_a = kWorld, .body_b = plate, .frame_a = {{}, turn}, .frame_b = {{-0.5f, 0, 0}, turn}}, kind);
  }
  Pose pose() const { return lab.world.joint_pose(joint); }
  double offset() const { return to_eigen(pose().position).norm(); }
  // Between the x axes of the frames.
  double tilt() const {
    const Eigen::Vector3d x = to_eigen(pose().rotation) * Eigen::Vector3d::UnitX();
    return std::atan2(std::hypot(x.y(), x.z()), x.x());
  }
  // Of a hinge.
  double angle() const { return 2 * std::atan2(pose().rotation.x, pose().rotation.w); }
};

TEST(Hinge, HoldsItsAxisUnderItsOwnWeight) {
  // A door, and a flap that ends at rest hanging down from a level axis.
  Flap door(HingeJoint{}, {0, 1, 0});
  door.lab.run(300);
  RecordProperty("door_offset", std::to_string(door.offset()));
  EXPECT_LT(door.offset(), 1e-4);
  EXPECT_LT(door.tilt(), 1e-4);

  Flap flap(HingeJoint{}, {0, 0, 1});
  flap.lab.world.set_angular_damping(flap.plate, 2.0f);
  flap.lab.run(1200);
  RecordProperty("flap_offset", std::to_string(flap.offset()));
  EXPECT_LT(flap.offset(), 1e-4);
  EXPECT_LT(flap.tilt(), 1e-4);
  EXPECT_NEAR(flap.lab.height(flap.plate), -0.5, 1e-3);
}

TEST(Hinge, StopsAtItsLimits) {
  for (const float speed : {0.0f, 3.0f, 10.0f, -10.0f}) {
    Flap flap(HingeJoint{{.lower = -1.0f, .upper = 0.5f}}, {0, 0, 1});
    flap.lab.world.set_angular_velocity(flap.plate, {0, 0, speed});
    flap.lab.world.set_linear_velocity(flap.plate, {0, 0.5f * speed, 0});
    double lowest = 0, highest = 0;
    for (int i = 0; i < 300; ++i) {
      flap.lab.run(1);
      lowest = std::min(lowest, flap.angle());
      highest = std::max(highest, flap.angle());
    }
    EXPECT_GT(lowest, -1.0 - kHalfDegree) << speed;
    EXPECT_LT(highest, 0.5 + kHalfDegree) << speed;
    EXPECT_NEAR(flap.angle(), -1.0, kHalfDegree) << "it ends on the lower one";
  }
}

TEST(Hinge, AMotorReachesItsSpeedWithItsTorque) {
  Flap wheel(HingeJoint{{.drive = Drive::motor, .speed = 5.0f, .max_force = 40.0f}}, {0, 1, 0},
             without_gravity());
  const double mass = wheel.lab.mass(wheel.plate);
  const double inertia = wheel.lab.inertia(wheel.plate)(1, 1) + mass * 0.25;
  const double needed = 5.0 * inertia / 40.0;  // s
  const int half = static_cast<int>(0.5 * needed / static_cast<double>(kStep));
  wheel.lab.run(half);
  EXPECT_NEAR(wheel.lab.spin(wheel.plate).y() / (half * static_cast<double>(kStep) * 40.0 / inertia), 1.0,
              0.01);
  EXPECT_NEAR(wheel.lab.world.joint_reaction(wheel.joint).torque.y, 40.0f, 0.5f);
  wheel.lab.run(half + 30);
  EXPECT_NEAR(wheel.lab.spin(wheel.plate).y(), 5.0, 1e-3);
}

TEST(Hinge, AMotorTooWeakForTheWeightGivesWay) {
  for (const float factor : {0.8f, 1.2f}) {
    Flap probe(HingeJoint{}, {0, 0, 1});
    const float weight_torque = static_cast<float>(probe.lab.mass(probe.plate) * kGravity * 0.5);
    Flap flap(HingeJoint{{.drive = Drive::motor, .max_force = factor * weight_torque}}, {0, 0, 1});
    flap.lab.run(60);
    EXPECT_EQ(flap.angle() < -0.2, factor < 1.0f) << flap.angle();
  }
}

TEST(Hinge, ASpringSwingsAtItsFrequency) {
  Flap flap(HingeJoint{{.drive = Drive::spring, .target = 0.3f, .hertz = 1.0f, .damping_ratio = 0.0f}},
            {0, 1, 0}, without_gravity());
  double last = flap.angle() - 0.3, first_crossing = 0, last_crossing = 0;
  int crossings = 0;
  for (int i = 0; i < 600; ++i) {
    flap.lab.run(1);
    const double now = flap.angle() - 0.3;
    if (last < 0 && now >= 0) {
      last_crossing = (i + last / (last - now)) * static_cast<double>(kStep);
      if (crossings++ == 0) first_crossing = last_crossing;
    }
    last = now;
  }
  ASSERT_GT(crossings, 3);
  EXPECT_NEAR((crossings - 1) / (last_crossing - first_crossing), 1.0, 0.02);
}

TEST(Ball, KeepsWithinItsConeAndTwist) {
  for (const float speed : {0.0f, 4.0f, 10.0f}) {
    // A rod that points away from the wall; the cone opens about its own axis.
    Lab lab;
    const BodyId rod = lab.add({.position = {0.5f, 0, 0}}, Capsule{0.4f, 0.1f});
    lab.world.set_angular_velocity(rod, {speed, 0.5f * speed, -speed});
    const JointId joint =
        lab.world.create_joint({.body_a = kWorld, .body_b = rod, .frame_b = {{-0.5f, 0, 0}, {}}},
                               BallJoint{.cone_limit = 0.6f, .twist_lower = -0.4f, .twist_upper = 0.3f});
    double widest = 0, least = 0, most = 0;
    for (int i = 0; i < 300; ++i) {
      lab.run(1);
      const Quat q = lab.world.joint_pose(joint).rotation;
      const Eigen::Vector3d x = to_eigen(q) * Eigen::Vector3d::UnitX();
      widest = std::max(widest, std::atan2(std::hypot(x.y(), x.z()), x.x()));
      const double twist = std::remainder(2 * std::atan2(q.x, q.w), 2 * kHingePi);
      least = std::min(least, twist);
      most = std::max(most, twist);
    }
    EXPECT_LT(widest, 0.6 + kHalfDegree) << speed;
    EXPECT_GT(least, -0.4 - kHalfDegree) << speed;
    EXPECT_LT(most, 0.3 + kHalfDegree) << speed;
    EXPECT_GT(widest, 0.55) << "its weight takes it to the cone";
  }
}

TEST(Ball, ADriveTurnsItToItsTarget) {
  const Quat target = rotation_about({1, 2, 2}, 0.8);
  Flap flap(BallJoint{.drive = {.drive = Drive::spring, .target = target, .hertz = 3.0f}}, {1, 0, 0},
            without_gravity());
  flap.lab.run(240);
  const Eigen::Quaterniond error = to_eigen(target).conjugate() * to_eigen(flap.pose().rotation);
  EXPECT_LT(error.vec().norm(), 1e-3);
  EXPECT_LT(flap.offset(), 1e-4);
}

TEST(Weld, HoldsACantilever) {
  Flap beam(WeldJoint{}, {1, 0, 0});
  beam.lab.run(300);
  const Eigen::Quaterniond turn = to_eigen(beam.pose().rotation);
  RecordProperty("offset", std::to_string(beam.offset()));
  RecordProperty("turn", std::to_string(2 * turn.vec().norm()));
  EXPECT_LT(beam.offset(), 1e-4);
  EXPECT_LT(2 * turn.vec().norm(), 5e-4);
}

TEST(Weld, SoftWeldsSwingAtTheirFrequency) {
  Flap beam(WeldJoint{.angular_hertz = 1.0f, .angular_damping_ratio = 0.0f}, {1, 0, 0}, without_gravity());
  beam.lab.world.add_angular_impulse(beam.plate, {0, 0, 20});
  int crossings = 0;
  double last = 0;
  for (int i = 0; i < 600; ++i) {
    beam.lab.run(1);
    const double now = beam.lab.height(beam.plate);
    crossings += last < 0 && now >= 0 ? 1 : 0;
    last = now;
  }
  EXPECT_NEAR(crossings, 10, 1);
}

}  // namespace
}  // namespace scree::physics
