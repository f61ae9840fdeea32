// Wheel, universal, planar, gear, rack, pulley, motor and mouse joints in whole worlds.
#include <tests/physics/lab.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace scree::physics {
namespace {

constexpr double kRowsPi = std::numbers::pi;

// A hinge with the world through the body's center, as a bearing would hold it.
JointId add_bearing(Lab& lab, BodyId body, Quat axes, const JointAxis& angle = {}) {
  const Vec3 center = lab.world.center_of_mass(body);
  const JointAxis held{.lower = 0, .upper = 0};
  return lab.world.create_joint(
      {.body_a = kWorld, .body_b = body, .frame_a = {center, axes}, .frame_b = {{}, axes}},
      PlanarJoint{.offset_y = held, .offset_z = held, .angle = angle});
}

constexpr float kWheelRadius = 0.35f;

// A car that faces along x, with its axles along z.
struct Car {
  Lab lab;
  BodyId chassis, wheel[4];
  JointId joint[4];  // front ones first
  static constexpr float kAxles = 2.6f, kTrack = 1.5f;

  Car() {
    lab.add_ground({.friction = 0.9f}, {}, 500.0f);
    const float height = 0.65f;
    chassis = lab.world.create_body({.position = {0, height, 0}});
    lab.world.add_shape(chassis, Box{{1.8f, 0.2f, 0.6f}}, {.density = 700.0f});
    const Quat up = rotation_about({0, 0, 1}, 0.5 * kRowsPi);  // x of the frames is y of the world
    for (int i = 0; i < 4; ++i) {
      const Vec3 at{i < 2 ? kAxles / 2 : -kAxles / 2, kWheelRadius - height,
                    i % 2 == 0 ? kTrack / 2 : -kTrack / 2};
      wheel[i] = lab.world.create_body({.position = at + Vec3{0, height, 0}});
      lab.world.add_shape(wheel[i], Sphere{kWheelRadius}, {.friction = 0.9f, .density = 100.0f});
      joint[i] = lab.world.create_joint(
          {.body_a = chassis, .body_b = wheel[i], .frame_a = {at, up}, .frame_b = {{}, up}}, WheelJoint{});
    }
  }
  void set(int i, float steering, float forward_speed) {
    WheelJoint to;
    to.steering.lower = to.steering.upper = steering;
    if (i >= 2) {  // driven behind
      to.spin = {.drive = Drive::motor, .speed = -forward_speed / kWheelRadius, .max_force = 600.0f};
    }
    lab.world.set_joint(joint[i], to);
  }
  double heading() const {
    const Eigen::Vector3d x = to_eigen(lab.world.pose(chassis).rotation) * Eigen::Vector3d::UnitX();
    return std::atan2(-x.z(), x.x());
  }
};

TEST(Car, StandsOnItsSuspension) {
  Car car;
  car.lab.run(240);
  // Each spring carries a fourth of the chassis and has the hertz of the chassis's mass at its corner.
  const double mass = car.lab.mass(car.chassis);
  const Eigen::Matrix3d inertia = car.lab.inertia(car.chassis);
  const double pitch = std::pow(static_cast<double>(Car::kAxles) / 2, 2) / inertia(2, 2);
  const double roll = std::pow(static_cast<double>(Car::kTrack) / 2, 2) / inertia(0, 0);
  const double corner = 1 / (1 / mass + pitch + roll);
  const double expected = mass / 4 * kGravity / (corner * std::pow(2 * kRowsPi * 2, 2));
  for (const JointId joint : car.joint) {
    EXPECT_NEAR(static_cast<double>(car.lab.world.joint_pose(joint).position.x), expected, 0.02 * expected);
  }
  EXPECT_LT(car.lab.velocity(car.chassis).norm(), 1e-3);
}

TEST(Car, DrivesStraight) {
  Car car;
  for (int i = 0; i < 4; ++i) car.set(i, 0.0f, 8.0f);
  car.lab.run(600);
  EXPECT_GT(car.lab.position(car.chassis).x(), 50.0);
  EXPECT_NEAR(car.lab.velocity(car.chassis).x(), 8.0, 0.2);
  // Solving wheels one after the other is slightly asymmetric: a thousandth of the distance.
  EXPECT_LT(std::abs(car.lab.position(car.chassis).z()), 0.001 * car.lab.position(car.chassis).x());
  // The wheel solved last decides: 4.03 mrad.
  EXPECT_LT(std::abs(car.heading()), 4.5e-3);
}

TEST(Car, TurnsWhenSteered) {
  for (const float steering : {0.2f, -0.2f}) {
    Car car;
    for (int i = 0; i < 4; ++i) car.set(i, 0.0f, 3.0f);
    car.lab.run(180);
    for (int i = 0; i < 4; ++i) car.set(i, i < 2 ? steering : 0.0f, 3.0f);
    car.lab.run(60);
    double turned = 0.0, last = car.heading();
    for (int i = 0; i < 240; ++i) {
      car.lab.run(1);
      turned += std::remainder(car.heading() - last, 2 * kRowsPi);
      last = car.heading();
    }
    // The turning radius is that of a bicycle of the same length.
    const double speed = std::hypot(car.lab.velocity(car.chassis).x(), car.lab.velocity(car.chassis).z());
    const double expected =
        4.0 * speed * std::tan(static_cast<double>(steering)) / static_cast<double>(Car::kAxles);
    EXPECT_NEAR(speed, 3.0, 0.3);  // both rear wheels turn alike and slip
    EXPECT_NEAR(turned, expected, 0.1 * std::abs(expected));
  }
}

// Angle of a body about an axis, over any number of turns; `mark` is a direction of the body perpendicular to
// the axis.
class TurnCounter {
 public:
  TurnCounter(const Lab& lab, BodyId body, Eigen::Vector3d zero, Eigen::Vector3d quarter)
      : lab_(&lab), body_(body), zero_(zero), quarter_(quarter) {}
  double turn() {
    const Eigen::Vector3d mark = to_eigen(lab_->world.pose(body_).rotation) * zero_;
    const double angle = std::atan2(mark.dot(quarter_), mark.dot(zero_));
    turn_ += std::remainder(angle - last_, 2 * kRowsPi);
    last_ = angle;
    return turn_;
  }

 private:
  const Lab* lab_;
  BodyId body_;
  Eigen::Vector3d zero_, quarter_;
  double turn_ = 0.0, last_ = 0.0;
};

TEST(Gears, KeepTheirRatioOverAThousandTurns) {
  Lab lab;
  const BodyId driver = lab.add({.position = {0, 1, 0}}, Box{{0.1f, 0.3f, 0.3f}});
  const BodyId driven = lab.add({.position = {0, 3, 0}}, Box{{0.1f, 0.6f, 0.6f}});
  add_bearing(lab, driver, {}, {.drive = Drive::motor, .speed = 40.0f, .max_force = 500.0f});
  add_bearing(lab, driven, {}, {.drive = Drive::motor, .max_force = 20.0f});  // a brake
  lab.world.create_joint({.body_a = driver, .body_b = driven}, GearJoint{.ratio = 2.5f});
  TurnCounter a(lab, driver, {0, 1, 0}, {0, 0, 1}), b(lab, driven, {0, 1, 0}, {0, 0, 1});
  double worst = 0.0, turn = 0.0;
  for (int i = 0; i < 20000 && turn < 2000 * kRowsPi; ++i) {
    lab.run(1);
    turn = a.turn();
    worst = std::max(worst, std::abs(turn + 2.5 * b.turn()));
  }
  EXPECT_GE(turn, 2000 * kRowsPi);
  EXPECT_NEAR(lab.spin(driver).x(), 40.0, 0.1);
  EXPECT_LT(worst, 0.02);
}

TEST(Gears, SteerAWayByARack) {
  Lab lab(without_gravity());
  const BodyId pinion = lab.add({.position = {0, 0, 0}}, Box{{0.05f, 0.1f, 0.1f}});
  const BodyId rack = lab.add({.position = {0, -0.1f, 0}}, Box{{0.05f, 0.05f, 0.5f}});
  add_bearing(lab, pinion, {}, {.drive = Drive::spring, .target = 2.0f, .hertz = 2.0f});
  const JointAxis held{.lower = 0, .upper = 0};
  const Quat along_z = rotation_about({0, 1, 0}, -0.5 * kRowsPi);  // x of the frames is z of the world
  // In the plane of y and z of the frames, and there only along z of the world.
  const Quat plane = rotation_about({0, 0, 1}, 0.5 * kRowsPi);
  lab.world.create_joint(
      {.body_a = kWorld, .body_b = rack, .frame_a = {{0, -0.1f, 0}, plane}, .frame_b = {{}, plane}},
      PlanarJoint{.offset_y = held, .angle = held});
  lab.world.create_joint({.body_a = pinion, .body_b = rack, .frame_b = {{}, along_z}},
                         RackAndPinionJoint{.radius = 0.1f});
  lab.run(300);
  EXPECT_NEAR(lab.position(rack).z(), 0.2, 1e-3);
  EXPECT_NEAR(lab.position(rack).x(), 0.0, 1e-3);
}

TEST(UniversalJoint, TurnsByCardansLaw) {
  Lab lab(without_gravity());
  const double bend = 0.6;
  const Eigen::Vector3d axis_b(std::cos(bend), std::sin(bend), 0);
  // Two shafts that meet in the origin; each turns about its own axis.
  const BodyId a = lab.add({.position = {-1, 0, 0}}, Box{{0.5f, 0.1f, 0.1f}});
  const Quat turned = rotation_about({0, 0, 1}, bend);
  const Vec3 center_b{static_cast<float>(axis_b.x()), static_cast<float>(axis_b.y()), 0};
  const BodyId b = lab.add({.position = center_b, .rotation = turned}, Box{{0.5f, 0.1f, 0.1f}});
  add_bearing(lab, a, {}, {.drive = Drive::motor, .speed = 5.0f});
  const Vec3 on_axis = lab.world.center_of_mass(b);
  const JointAxis held{.lower = 0, .upper = 0};
  lab.world.create_joint({.body_a = kWorld, .body_b = b, .frame_a = {on_axis, turned}},
                         PlanarJoint{.offset_y = held, .offset_z = held});
  // The pins are the y axis of a and the z axis of b: as the x axis of one frame and the y axis of the other.
  lab.world.create_joint({.body_a = a,
                          .body_b = b,
                          .frame_a = {{1, 0, 0}, rotation_about({0, 0, 1}, 0.5 * kRowsPi)},
                          .frame_b = {{-1, 0, 0}, rotation_about({1, 0, 0}, 0.5 * kRowsPi)}},
                         UniversalJoint{});
  lab.run(30);
  double worst = 0.0, fastest = 0.0, slowest = 100.0;
  for (int i = 0; i < 600; ++i) {
    lab.run(1);
    const Eigen::Vector3d pin_a = to_eigen(lab.world.pose(a).rotation) * Eigen::Vector3d::UnitY();
    const Eigen::Vector3d pin_b = to_eigen(lab.world.pose(b).rotation) * Eigen::Vector3d::UnitZ();
    const double angle_a = std::atan2(pin_a.z(), pin_a.y());
    const Eigen::Vector3d side(-std::sin(bend), std::cos(bend), 0);
    const double angle_b = std::atan2(-pin_b.dot(side), pin_b.z());
    const double expected = std::atan2(std::sin(angle_a), std::cos(bend) * std::cos(angle_a));
    worst = std::max(worst, std::abs(std::remainder(angle_b - expected, 2 * kRowsPi)));
    const double ratio = lab.spin(b).dot(axis_b) / lab.spin(a).x();
    fastest = std::max(fastest, ratio);
    slowest = std::min(slowest, ratio);
  }
  EXPECT_LT(worst, 0.01);
  EXPECT_NEAR(fastest, 1 / std::cos(bend), 0.01);
  EXPECT_NEAR(slowest, std::cos(bend), 0.01);
}

TEST(PlanarJoint, KeepsABodyInItsPlane) {
  Lab lab;
  lab.add_ground();
  // The plane of x and y: the frames' x axis is z of the world.
  const Quat axes = rotation_about({0, 1, 0}, -0.5 * kRowsPi);
  std::vector<BodyId> boxes;
  for (int i = 0; i < 6; ++i) {
    const Vec3 at{0.1f * static_cast<float>(i), 0.6f + 1.1f * static_cast<float>(i), 0};
    const BodyId box = lab.add({.position = at,
                                .rotation = rotation_about({0, 0, 1}, 0.3 * i),
                                .linear_velocity = {1, 0, 2},
                                .angular_velocity = {3, 2, 1}},
                               Box{{0.5f, 0.5f, 0.5f}});
    lab.world.create_joint(
        {.body_a = kWorld, .body_b = box, .frame_a = {{0, 0, 0}, axes}, .frame_b = {{}, axes}},
        PlanarJoint{});
    boxes.push_back(box);
  }
  double off = 0.0, tilt = 0.0;
  for (int i = 0; i < 300; ++i) {
    lab.run(1);
    for (const BodyId box : boxes) {
      off = std::max(off, std::abs(lab.position(box).z()));
      const Eigen::Vector3d z = to_eigen(lab.world.pose(box).rotation) * Eigen::Vector3d::UnitZ();
      tilt = std::max(tilt, std::hypot(z.x(), z.y()));
    }
  }
  EXPECT_LT(off, 0.02);
  EXPECT_LT(tilt, 0.02);
  double still = 0.0;  // in the end nothing pushes the boxes out of the plane
  for (const BodyId box : boxes) still = std::max(still, std::abs(lab.position(box).z()));
  EXPECT_LT(still, 1e-3);
}

TEST(PulleyJoint, RaisesTheLighterWeight) {
  Lab lab;
  const BodyId light = lab.add({.position = {-1, 0, 0}}, Box{{0.2f, 0.2f, 0.2f}});
  const BodyId heavy = lab.add({.position = {1, 0, 0}}, Box{{0.4f, 0.2f, 0.2f}});  // twice as heavy
  const Vec3 eye{0, 0.2f, 0};
  lab.world.create_joint({.body_a = light, .body_b = heavy, .frame_a = {eye, {}}, .frame_b = {eye, {}}},
                         PulleyJoint{.point_a = {-1, 8.2f, 0}, .point_b = {1, 8.2f, 0}, .length = 16.0f});
  lab.run(60);
  EXPECT_NEAR(lab.velocity(light).y(), kGravity / 3, 0.01);
  EXPECT_NEAR(lab.velocity(heavy).y(), -kGravity / 3, 0.01);
  EXPECT_NEAR(lab.height(light) + lab.height(heavy), 0.0, 2e-3);
}

TEST(MouseJoint, DragsABodyToAPoint) {
  Lab lab;
  lab.add_ground();
  const BodyId box = lab.add({.position = {0, 0.5f, 0}}, Box{{0.5f, 0.5f, 0.5f}});
  MouseJoint mouse{.target = {0.5f, 1, 0.5f}, .hertz = 5.0f};
  const JointId joint =
      lab.world.create_joint({.body_a = kWorld, .body_b = box, .frame_b = {{0.5f, 0.5f, 0.5f}, {}}}, mouse);
  for (int i = 1; i <= 120; ++i) {
    mouse.target = {0.5f + 0.02f * static_cast<float>(i), 1 + 0.02f * static_cast<float>(i), 0.5f};
    lab.world.set_joint(joint, mouse);
    lab.run(1);
  }
  lab.run(600);
  const Eigen::Vector3d corner =
      lab.position(box) + to_eigen(lab.world.pose(box).rotation) * Eigen::Vector3d(0.5, 0.5, 0.5);
  EXPECT_LT((corner - to_eigen(mouse.target)).norm(), 0.05);
  EXPECT_GT(lab.height(box), 1.5);  // it hangs there
}

TEST(MotorJoint, ReachesItsPoseAgainstGravity) {
  Lab lab;
  const BodyId box = lab.add({.position = {0, 0, 0}}, Box{{0.3f, 0.2f, 0.1f}});
  const Quat target = rotation_about({1, 2, 3}, 2.0);
  lab.world.create_joint(
      {.body_a = kWorld, .body_b = box},
      MotorJoint{.rotation = {.drive = Drive::spring, .target = target}, .target = {1, 2, 3}, .hertz = 4.0f});
  lab.run(300);
  const double sag = kGravity / std::pow(2 * kRowsPi * 4, 2);
  EXPECT_LT((lab.position(box) - Eigen::Vector3d(1, 2 - sag, 3)).norm(), 2e-3);
  EXPECT_LT(to_eigen(lab.world.pose(box).rotation).angularDistance(to_eigen(target)), 2e-3);
}

TEST(MotorJoint, GivesWayAboveItsForce) {
  Lab lab;
  const BodyId box = lab.add({.position = {0, 0, 0}}, Box{{0.3f, 0.2f, 0.1f}});
  const double weight = lab.mass(box) * kGravity;
  lab.world.create_joint({.body_a = kWorld, .body_b = box},
                         MotorJoint{.max_force = static_cast<float>(0.25 * weight)});
  lab.run(60);
  EXPECT_NEAR(lab.velocity(box).y(), -0.75 * kGravity, 0.05);
}

}  // namespace
}  // namespace scree::physics
