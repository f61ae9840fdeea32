// Coulomb friction, twist, rolling resistance and moving surfaces.
#include <tests/physics/lab.h>

#include <algorithm>
#include <numbers>
#include <string>
#include <utility>

namespace scree::physics {
namespace {

// Whether a box slips down a ramp of `angle`: the gain of speed 2 % above the angle of friction is at least
// 0.02 g mu / 2 or so, far above the limit here.
bool slips(double friction, double angle, const Geometry& geometry, double height) {
  Lab lab;
  const Quat tilt = rotation_about({0, 0, 1}, angle);
  const Material material{.friction = static_cast<float>(friction)};
  lab.add_ground(material, tilt);
  const Eigen::Vector3d up = to_eigen(tilt) * Eigen::Vector3d(0, height, 0);
  const BodyDef def{.position = {static_cast<float>(up.x()), static_cast<float>(up.y()), 0},
                    .rotation = tilt};
  const BodyId body = lab.add(def, geometry, material);
  lab.run(60);
  const double speed = lab.velocity(body).norm();
  lab.run(120);
  return lab.velocity(body).norm() > speed + 0.002;
}

TEST(Friction, SlipOnTheSlopeStartsAtTheAngleOfFriction) {
  for (const double friction : {0.1, 0.2, 0.3, 0.45, 0.6, 0.8}) {
    const double expected = std::atan(friction);
    double low = 0.5 * expected, high = 1.5 * expected;
    for (int i = 0; i < 12; ++i) {
      const double middle = 0.5 * (low + high);
      (slips(friction, middle, Box{{0.5f, 0.2f, 0.4f}}, 0.2) ? high : low) = middle;
    }
    EXPECT_NEAR(high, expected, 0.02 * expected) << "friction " << friction;
  }
}

TEST(Friction, SlidingBoxStopsAfterTheDistanceOfItsEnergy) {
  // v^2 / (2 mu g), equal in every direction of the plane.
  for (const double direction : {0.0, 0.4, 0.785, 1.3, 2.5}) {
    Lab lab;
    lab.add_ground({.friction = 0.5f});
    const float speed = 6.0f;
    const BodyDef def{.position = {0, 0.1f, 0},
                      .linear_velocity = {speed * static_cast<float>(std::cos(direction)), 0,
                                          speed * static_cast<float>(std::sin(direction))}};
    const BodyId box = lab.add(def, Box{{0.5f, 0.1f, 0.5f}}, {.friction = 0.5f});
    lab.run(180);
    const double expected = 36.0 / (2.0 * 0.5 * kGravity);
    const Eigen::Vector3d way = lab.position(box);
    EXPECT_NEAR(std::hypot(way.x(), way.z()), expected, 0.02 * expected);
    EXPECT_NEAR(std::atan2(way.z(), way.x()), direction, 0.01);
    EXPECT_LT(lab.velocity(box).norm(), 1e-3);
  }
}

// Friction turns bars less easily along their length than across it. It opposes their slip all the same.
TEST(Friction, ABarSlidesStraightInEveryDirection) {
  constexpr double kSpeed = 5, kTime = 0.5;
  constexpr int kSteps = 30;
  for (const float width : {0.5f, 0.1f, 0.02f}) {
    for (const int substeps : {1, 4, 16}) {
      for (const double direction : {0.3, 0.785, 1.2, 2.5}) {
        WorldSettings settings = without_sleep();
        settings.substeps = substeps;
        Lab lab(settings);
        lab.add_ground({.friction = 0.5f});
        const Eigen::Vector3d way(std::cos(direction), 0, std::sin(direction));
        const BodyId bar = lab.add({.position = {0, width, 0},
                                    .linear_velocity = {static_cast<float>(kSpeed * way.x()), 0,
                                                        static_cast<float>(kSpeed * way.z())}},
                                   Box{{1, width, width}}, {.friction = 0.5f});
        lab.run(kSteps);
        const Eigen::Vector3d expected = (kSpeed - 0.5 * kGravity * kTime) * way;
        EXPECT_LT((lab.velocity(bar) - expected).norm(), 0.01 * expected.norm())
            << "width " << width << ", " << substeps << " substeps, direction " << direction << ": "
            << lab.velocity(bar).transpose() << " instead of " << expected.transpose();
        EXPECT_LT(lab.spin(bar).norm(), 0.05) << "width " << width;
      }
    }
  }
}

TEST(Friction, ActsInEverySubstepWithoutWarmStartToo) {
  WorldSettings settings = without_sleep();
  settings.warm_start = false;
  Lab lab(settings);
  lab.add_ground({.friction = 0.5f});
  const BodyId box = lab.add({.position = {0, 0.1f, 0}, .linear_velocity = {6, 0, 0}},
                             Box{{0.5f, 0.1f, 0.5f}}, {.friction = 0.5f});
  lab.run(180);
  const double expected = 36.0 / (2.0 * 0.5 * kGravity);
  EXPECT_NEAR(lab.position(box).x(), expected, 0.05 * expected);
}

TEST(Friction, ASlidingSphereEndsAtFiveSeventhsOfItsSpeed) {
  for (const float friction : {0.1f, 0.3f, 0.6f, 1.0f}) {
    Lab lab;
    lab.add_ground({.friction = friction});
    const BodyDef def{.position = {-40, 0.5f, 0}, .linear_velocity = {8, 0, 6}};
    const BodyId ball = lab.add(def, Sphere{0.5f}, {.friction = friction});
    // It slides for 2 v / (7 mu g), at most 3 s.
    lab.run(240);
    const double expected = 10.0 * 5.0 / 7.0;
    EXPECT_NEAR(lab.velocity(ball).norm(), expected, 0.01 * expected) << "friction " << friction;
    EXPECT_NEAR(lab.spin(ball).norm() * 0.5, expected, 0.01 * expected) << "friction " << friction;
  }
}

TEST(Friction, TwistStopsASpinningBox) {
  // A square plate of side a under its own weight: the twist row bounds the torque by mu N times the mean
  // distance of the corners, a / sqrt(2).
  Lab lab;
  lab.add_ground({.friction = 0.4f});
  const BodyDef def{.position = {0, 0.1f, 0}, .angular_velocity = {0, 8, 0}};
  const BodyId plate = lab.add(def, Box{{0.5f, 0.1f, 0.5f}}, {.friction = 0.4f});
  const double torque = 0.4 * lab.mass(plate) * kGravity * std::sqrt(0.5);
  const double expected = 0.5 * 64.0 * lab.inertia(plate)(1, 1) / torque;  // rad
  double turned = 0.0;
  for (int i = 0; i < 180; ++i) {
    lab.run(1);
    turned += lab.spin(plate).y() * static_cast<double>(kStep);
  }
  EXPECT_LT(lab.spin(plate).norm(), 1e-3);
  EXPECT_NEAR(turned, expected, 0.05 * expected);
}

TEST(Friction, TwistStopsABallThatSpinsInPlace) {
  // The contact patch of a ball that yields by d = 5 mm, at most 0.02 r, has the radius sqrt(r d). Under
  // Hertz's pressure the friction torque is mu N times 3 pi / 16 of that radius.
  const std::vector<Vec3> corners = {{-5, -2, -5}, {5, -2, -5}, {-5, -2, 5}, {5, -2, 5},
                                     {-5, 0, -5},  {5, 0, -5},  {-5, 0, 5},  {5, 0, 5}};
  for (const Geometry& floor : {Geometry{Box{{5, 1, 5}}}, Geometry{ConvexHull{Hull(corners)}}}) {
    for (const double radius : {0.1, 0.25, 0.5}) {
      Lab lab;
      const float y = std::holds_alternative<Box>(floor) ? -1.0f : 0.0f;
      lab.add({.type = BodyType::fixed, .position = {0, y, 0}}, floor, {.friction = 0.5f});
      const auto r = static_cast<float>(radius);
      const BodyId ball =
          lab.add({.position = {0, r, 0}, .angular_velocity = {0, 5, 0}}, Sphere{r}, {.friction = 0.5f});
      const double patch = std::sqrt(radius * std::min(0.005, 0.02 * radius));
      const double torque = 0.5 * lab.mass(ball) * kGravity * 3.0 * std::numbers::pi / 16.0 * patch;
      const double expected = 0.5 * 25.0 * lab.inertia(ball)(1, 1) / torque;  // rad
      double turned = 0.0;
      for (int i = 0; i < 400; ++i) {
        lab.run(1);
        turned += lab.spin(ball).y() * static_cast<double>(kStep);
      }
      EXPECT_LT(lab.spin(ball).norm(), 1e-3) << radius;
      EXPECT_NEAR(turned, expected, 0.05 * expected) << radius;
      EXPECT_LT(std::hypot(lab.position(ball).x(), lab.position(ball).z()), 1e-3);
    }
  }
}

TEST(Friction, TwistStopsTheSpinOfARollingBallButNotItsRolling) {
  Lab lab;
  lab.add_ground({.friction = 0.6f});
  const BodyId ball =
      lab.add({.position = {0, 0.3f, 0}, .linear_velocity = {3, 0, 0}, .angular_velocity = {0, 5, -10}},
              Sphere{0.3f}, {.friction = 0.6f});
  // The same torque as for a ball that spins in place.
  const double patch = std::sqrt(0.3 * 0.005);
  const double torque = 0.6 * lab.mass(ball) * kGravity * 3.0 * std::numbers::pi / 16.0 * patch;
  const double slower = torque / lab.inertia(ball)(1, 1);  // rad/s^2
  lab.run(60);
  EXPECT_NEAR(5.0 - lab.spin(ball).y(), slower, 0.05 * slower);
  lab.run(540);
  EXPECT_LT(std::abs(lab.spin(ball).y()), 1e-3);
  EXPECT_NEAR(lab.velocity(ball).x(), 3.0, 0.01);
  EXPECT_LT(std::abs(lab.velocity(ball).z()), 1e-3);
  EXPECT_LT((lab.spin(ball) - Eigen::Vector3d(0, 0, -10)).norm(), 0.05);
}

// The torque is friction x weight x 3 pi / 16 of the patch's radius.
TEST(Friction, APatchOfAGivenRadiusStopsTheSpinOfABallInThePredictedTime) {
  for (const float patch : {0.02f, 0.1f}) {
    for (const bool on_ground : {false, true}) {  // the larger radius of two surfaces counts
      Lab lab;
      Material ball_material{.friction = 0.5f, .patch_radius = 0.0f}, ground_material = ball_material;
      (on_ground ? ground_material : ball_material).patch_radius = patch;
      lab.add_ground(ground_material);
      const BodyId ball =
          lab.add({.position = {0, 0.3f, 0}, .angular_velocity = {0, 20, 0}}, Sphere{0.3f}, ball_material);
      const double torque =
          0.5 * lab.mass(ball) * kGravity * 3.0 * std::numbers::pi / 16.0 * static_cast<double>(patch);
      const double time = lab.inertia(ball)(1, 1) * 20.0 / torque;
      const int steps = static_cast<int>(time / static_cast<double>(kStep));
      lab.run(steps / 2);
      EXPECT_NEAR(lab.spin(ball).y(), 20.0 * (1.0 - steps / 2 * static_cast<double>(kStep) / time), 0.2)
          << patch;
      lab.run(steps - steps / 2 - steps / 50);
      EXPECT_GT(lab.spin(ball).y(), 0.0) << patch;
      lab.run(steps / 25 + 2);
      EXPECT_LT(lab.spin(ball).norm(), 1e-3) << patch;
    }
  }
}

TEST(Friction, WithoutAPatchABallSpinsForEver) {
  const Geometry supports[] = {Box{{1, 1, 1}}, Sphere{1.0f}, Capsule{0.5f, 0.5f},
                               ConvexHull{Hull(std::vector<Vec3>{{-1, -1, -1},
                                                                 {-1, -1, 1},
                                                                 {1, -1, 1},
                                                                 {1, -1, -1},
                                                                 {-1, 1, -1},
                                                                 {-1, 1, 1},
                                                                 {1, 1, 1},
                                                                 {1, 1, -1},
                                                                 {0, -2, 0}})}};
  for (const Geometry& support : supports) {
    Lab lab;
    // A radius has no effect unless a surface specifies it.
    lab.add({.type = BodyType::fixed, .position = {0, -1, 0}}, support, {.friction = 0.9f});
    const BodyId ball = lab.add({.position = {0, 0.3f, 0}, .angular_velocity = {0, 20, 0}}, Sphere{0.3f},
                                {.friction = 0.9f, .patch_radius = 0.0f});
    lab.run(300);
    EXPECT_NEAR(lab.height(ball), 0.3, 0.01);
    EXPECT_NEAR(lab.spin(ball).y(), 20.0, 1e-3) << "support " << support.index();
  }
}

// The manifold is recycled from step to step while its points turn away with the capsule; a sphere has
// nothing to recycle. Up to half a radian a step.
TEST(Friction, ACapsuleRollsAsASphereDoes) {
  const std::pair<float, float> cases[] = {{0.1f, 0.5f}, {0.1f, 3.0f}, {0.3f, 0.5f}, {0.3f, 3.0f},
                                           {0.3f, 8.0f}, {0.5f, 3.0f}, {0.5f, 8.0f}};
  for (const auto& [radius, speed] : cases) {
    SCOPED_TRACE(std::to_string(radius) + " m, " + std::to_string(speed) + " m/s");
    Lab lab;
    lab.add_ground();
    BodyDef def{.position = {-50, radius, -3},
                .rotation = rotation_about({1, 0, 0}, 0.5 * std::numbers::pi),
                .linear_velocity = {speed, 0, 0},
                .angular_velocity = {0, 0, -speed / radius}};
    const BodyId capsule = lab.add(def, Capsule{0.5f, radius});
    def.position.z = 3;
    const BodyId ball = lab.add(def, Sphere{radius});
    double low = 1e9, high = -1e9;
    for (int i = 0; i < 600; ++i) {
      lab.run(1);
      const double expected = lab.velocity(ball).norm();
      ASSERT_NEAR(lab.velocity(capsule).norm(), expected, 0.005 * expected) << "step " << i;
      if (i < 60) continue;  // it settles
      low = std::min(low, lab.height(capsule));
      high = std::max(high, lab.height(capsule));
    }
    EXPECT_LT(high - low, 1e-4);
  }
}

void expect_to_stop_as_predicted(AxisLocks locks) {
  // The torque b N slows rolling by 5 g b / (7 r), so the distance is 7 v^2 r / (10 g b).
  for (const float resistance : {0.02f, 0.05f}) {
    Lab lab;
    lab.add_ground({.friction = 0.8f});
    const BodyDef def{.position = {0, 0.5f, 0},
                      .linear_velocity = {3, 0, 0},
                      .angular_velocity = {0, 0, -6},
                      .locks = locks};
    const BodyId ball = lab.add(def, Sphere{0.5f}, {.friction = 0.8f, .rolling_resistance = resistance});
    lab.run(1200);
    const double expected = 7.0 * 9.0 * 0.5 / (10.0 * kGravity * static_cast<double>(resistance));
    EXPECT_LT(lab.velocity(ball).norm(), 1e-3);
    EXPECT_NEAR(lab.position(ball).x(), expected, 0.03 * expected) << "resistance " << resistance;
  }
}

TEST(RollingResistance, StopsABallAfterThePredictedDistance) { expect_to_stop_as_predicted(AxisLocks::none); }

TEST(RollingResistance, StopsABallInAPlaneAfterThePredictedDistance) {
  expect_to_stop_as_predicted(AxisLocks::translation_z | AxisLocks::rotation_x | AxisLocks::rotation_y);
}

TEST(RollingResistance, IsTheSameForABallOfTinyMass) {
  Eigen::Vector3d expected = Eigen::Vector3d::Zero();
  for (const float mass : {1.0f, 1e-15f, 1e-20f}) {
    Lab lab;
    lab.add_ground({.friction = 0.8f});
    const BodyDef def{
        .position = {0, 0.5f, 0}, .linear_velocity = {3, 0, 0}, .angular_velocity = {0, 0, -6}, .mass = mass};
    const BodyId ball = lab.add(def, Sphere{0.5f}, {.friction = 0.8f, .rolling_resistance = 0.05f});
    lab.run(60);
    if (mass == 1.0f) expected = lab.position(ball);
    EXPECT_GT(lab.position(ball).x(), 1.0);
    EXPECT_LT((lab.position(ball) - expected).norm(), 1e-3) << "mass " << mass;
  }
}

TEST(RollingResistance, HoldsABallOnASlopeBelowItsAngle) {
  // The ball stays in place while tan(angle) < b / r.
  for (const bool rolls : {false, true}) {
    Lab lab;
    const Quat tilt = rotation_about({0, 0, 1}, rolls ? 0.11 : 0.09);
    lab.add_ground({.friction = 0.8f}, tilt);
    const Eigen::Vector3d up = to_eigen(tilt) * Eigen::Vector3d(0, 0.5, 0);
    const BodyId ball = lab.add({.position = {static_cast<float>(up.x()), static_cast<float>(up.y()), 0}},
                                Sphere{0.5f}, {.friction = 0.8f, .rolling_resistance = 0.05f});
    lab.run(240);
    EXPECT_EQ(lab.velocity(ball).norm() > 0.05, rolls) << lab.velocity(ball).norm();
  }
}

TEST(Conveyor, DrivesABoxAtItsSpeed) {
  // The belt's velocity is in the belt's frame.
  for (const double turn : {0.0, 0.5 * std::numbers::pi, 2.0}) {
    Lab lab;
    const Quat heading = rotation_about({0, 1, 0}, turn);
    lab.add_ground({.friction = 0.6f, .surface_velocity = {2, 0, 0}}, heading);
    const BodyId box = lab.add({.position = {0, 0.3f, 0}}, Box{{0.3f, 0.3f, 0.3f}}, {.friction = 0.6f});
    lab.run(120);
    const Eigen::Vector3d expected = to_eigen(heading) * Eigen::Vector3d(2, 0, 0);
    EXPECT_LT((lab.velocity(box) - expected).norm(), 0.02) << lab.velocity(box).transpose();
    EXPECT_LT(lab.spin(box).norm(), 0.02);
    EXPECT_NEAR(lab.height(box), 0.3, 0.01);
  }
}

TEST(Conveyor, OfADynamicBodyDrivesIt) {
  // A tracked vehicle: its own lower surface runs backwards.
  Lab lab;
  lab.add_ground({.friction = 0.6f});
  const BodyId crawler = lab.add({.position = {0, 0.3f, 0}}, Box{{0.6f, 0.3f, 0.4f}},
                                 {.friction = 0.6f, .surface_velocity = {-1.5f, 0, 0}});
  lab.run(120);
  EXPECT_NEAR(lab.velocity(crawler).x(), 1.5, 0.015);
}

}  // namespace
}  // namespace scree::physics
