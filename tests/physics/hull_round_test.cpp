// Spheres and capsules obey the same laws on hulls as on boxes.
#include <tests/physics/lab.h>

#include <numbers>
#include <vector>

namespace scree::physics {
namespace {

Geometry box_hull(Vec3 half) {
  std::vector<Vec3> points;
  for (const float x : {-half.x, half.x}) {
    for (const float y : {-half.y, half.y}) {
      for (const float z : {-half.z, half.z}) points.push_back({x, y, z});
    }
  }
  return ConvexHull{Hull(points)};
}
// A flat stone: a polygon of `sides` corners above a wider one.
Geometry stone(int sides, float radius, float half_height) {
  std::vector<Vec3> points;
  for (int k = 0; k < sides; ++k) {
    const float angle = 2.0f * std::numbers::pi_v<float> * static_cast<float>(k) / static_cast<float>(sides);
    const float x = radius * std::cos(angle), z = radius * std::sin(angle);
    points.push_back({x, half_height, z});
    points.push_back({1.2f * x, -half_height, 1.2f * z});
  }
  return ConvexHull{Hull(points)};
}

/// A fixed hull whose upper face passes through the origin, level unless tilted.
BodyId add_hull_ground(Lab& lab, const Material& material = {}, Quat tilt = {}) {
  const Eigen::Vector3d center = to_eigen(tilt) * Eigen::Vector3d(0, -1, 0);
  const BodyDef def{.type = BodyType::fixed,
                    .position = {static_cast<float>(center.x()), static_cast<float>(center.y()),
                                 static_cast<float>(center.z())},
                    .rotation = tilt};
  return lab.add(def, box_hull({100, 1, 100}), material);
}
Vec3 above(Quat tilt, double height) {
  const Eigen::Vector3d up = to_eigen(tilt) * Eigen::Vector3d(0, height, 0);
  return {static_cast<float>(up.x()), static_cast<float>(up.y()), static_cast<float>(up.z())};
}

TEST(HullRound, ASlidingSphereEndsAtFiveSeventhsOfItsSpeed) {
  for (const float friction : {0.1f, 0.3f, 0.6f, 1.0f}) {
    Lab lab;
    add_hull_ground(lab, {.friction = friction});
    const BodyDef def{.position = {-40, 0.5f, 0}, .linear_velocity = {8, 0, 6}};
    const BodyId ball = lab.add(def, Sphere{0.5f}, {.friction = friction});
    lab.run(240);
    const double expected = 10.0 * 5.0 / 7.0;
    EXPECT_NEAR(lab.velocity(ball).norm(), expected, 0.01 * expected) << "friction " << friction;
    EXPECT_NEAR(lab.spin(ball).norm() * 0.5, expected, 0.01 * expected) << "friction " << friction;
  }
}

TEST(HullRound, RollingResistanceStopsABallAfterThePredictedDistance) {
  for (const float resistance : {0.02f, 0.05f}) {
    Lab lab;
    add_hull_ground(lab, {.friction = 0.8f});
    const BodyDef def{.position = {0, 0.5f, 0}, .linear_velocity = {3, 0, 0}, .angular_velocity = {0, 0, -6}};
    const BodyId ball = lab.add(def, Sphere{0.5f}, {.friction = 0.8f, .rolling_resistance = resistance});
    lab.run(1200);
    const double expected = 7.0 * 9.0 * 0.5 / (10.0 * kGravity * static_cast<double>(resistance));
    EXPECT_LT(lab.velocity(ball).norm(), 1e-3);
    EXPECT_NEAR(lab.position(ball).x(), expected, 0.03 * expected) << "resistance " << resistance;
  }
}

TEST(HullRound, ASphereRollsDownASlopeWithFiveSeventhsOfItsPull) {
  Lab lab;
  const double angle = 0.2;
  const Quat tilt = rotation_about({0, 0, 1}, angle);
  add_hull_ground(lab, {.friction = 0.8f}, tilt);
  const BodyId ball = lab.add({.position = above(tilt, 0.5)}, Sphere{0.5f}, {.friction = 0.8f});
  lab.run(120);
  const double expected = 5.0 / 7.0 * kGravity * std::sin(angle) * 2.0;
  EXPECT_NEAR(lab.velocity(ball).norm(), expected, 0.01 * expected);
}

// Whether a capsule that points downhill slips.
bool capsule_slips(double friction, double angle) {
  Lab lab;
  const Material material{.friction = static_cast<float>(friction)};
  const Quat tilt = rotation_about({0, 0, 1}, angle);
  add_hull_ground(lab, material, tilt);
  const BodyId capsule = lab.add(
      {.position = above(tilt, 0.25), .rotation = rotation_about({0, 0, 1}, angle + 0.5 * std::numbers::pi)},
      Capsule{0.5f, 0.25f}, material);
  lab.run(60);
  const double speed = lab.velocity(capsule).norm();
  lab.run(120);
  return lab.velocity(capsule).norm() > speed + 0.002;
}

TEST(HullRound, ACapsuleSlipsAtTheAngleOfFriction) {
  for (const double friction : {0.2, 0.5}) {
    const double expected = std::atan(friction);
    EXPECT_FALSE(capsule_slips(friction, 0.98 * expected)) << "friction " << friction;
    EXPECT_TRUE(capsule_slips(friction, 1.02 * expected)) << "friction " << friction;
  }
}

TEST(HullRound, ACapsuleComesToRestLyingDown) {
  for (const double lean : {0.0, 0.3, 1.0, 1.5}) {
    Lab lab;
    add_hull_ground(lab);
    const BodyId capsule = lab.add({.position = {0, 1.2f, 0},
                                    .rotation = rotation_about({0.3f, 0, 1}, lean + 0.01),
                                    .angular_velocity = {0.5f, 0.2f, 0}},
                                   Capsule{0.5f, 0.25f}, {.friction = 0.6f, .rolling_resistance = 0.02f});
    lab.run(900);
    EXPECT_LT(lab.velocity(capsule).norm(), 1e-3) << "lean " << lean;
    EXPECT_LT(lab.spin(capsule).norm(), 1e-2) << "lean " << lean;
    EXPECT_NEAR(lab.height(capsule), 0.25, 0.006) << "lean " << lean;
    const Eigen::Vector3d axis = to_eigen(lab.world.pose(capsule).rotation) * Eigen::Vector3d::UnitY();
    EXPECT_NEAR(axis.y(), 0.0, 1e-3) << "lean " << lean;
  }
}

TEST(HullRound, StonesOfManyCornersRestOnACapsuleBed) {
  // The hull is the dynamic body here, and lies on two fixed capsules.
  for (const int sides : {3, 6, 16, 100}) {
    Lab lab;
    for (const float x : {-0.4f, 0.4f}) {
      lab.add({.type = BodyType::fixed,
               .position = {x, 0, 0},
               .rotation = rotation_about({1, 0, 0}, 0.5 * std::numbers::pi)},
              Capsule{2.0f, 0.2f}, {.friction = 0.6f});
    }
    const BodyId body = lab.add({.position = {0, 0.42f, 0}}, stone(sides, 1.0f, 0.2f), {.friction = 0.6f});
    lab.run(300);
    EXPECT_LT(lab.velocity(body).norm(), 1e-3) << sides;
    EXPECT_LT(lab.spin(body).norm(), 1e-3) << sides;
    EXPECT_LT(std::hypot(lab.position(body).x(), lab.position(body).z()), 0.02) << sides;
    const Eigen::Vector3d up = to_eigen(lab.world.pose(body).rotation) * Eigen::Vector3d::UnitY();
    EXPECT_GT(up.y(), 0.9999) << sides;
  }
}

TEST(HullRound, CollisionsKeepMomentumAndGainNoEnergy) {
  Random random(5);
  for (int k = 0; k < 30; ++k) {
    Lab lab(without_gravity());
    const Geometry round = k % 2 == 0 ? Geometry{Sphere{0.4f}} : Geometry{Capsule{0.5f, 0.2f}};
    const Material material{.friction = 0.5f, .restitution = 0.5f};
    const BodyId a = lab.add({.position = {-2, random.uniform(-0.3f, 0.3f), random.uniform(-0.3f, 0.3f)},
                              .rotation = random.rotation(),
                              .linear_velocity = {4, 0, 0},
                              .angular_velocity = random.vector(2)},
                             round, material);
    const BodyId b = lab.add({.position = {0, 0, 0}, .rotation = random.rotation()},
                             stone(3 + k % 9, 0.6f, 0.2f), material);
    const Eigen::Vector3d before = lab.mass(a) * lab.velocity(a) + lab.mass(b) * lab.velocity(b);
    const double energy = lab.kinetic_energy(a) + lab.kinetic_energy(b);
    lab.run(90);
    const Eigen::Vector3d after = lab.mass(a) * lab.velocity(a) + lab.mass(b) * lab.velocity(b);
    EXPECT_GT(lab.velocity(b).norm(), 0.1) << k;  // they did meet
    EXPECT_LT((after - before).norm(), 1e-4 * before.norm()) << k;
    EXPECT_LT(lab.kinetic_energy(a) + lab.kinetic_energy(b), energy * 1.001) << k;
  }
}

}  // namespace
}  // namespace scree::physics
