// Round shapes that turn fast while they touch: the surface at the contact does not turn with them.
#include <tests/physics/lab.h>

#include <algorithm>
#include <string>
#include <vector>

namespace scree::physics {
namespace {

constexpr float kRollingRadius = 0.1f;  // m

// The heights that a body passes through, and its largest vertical speed.
struct Ride {
  double lowest, highest, vertical_speed;
};

WorldSettings settings_for(Solver solver, int substeps) {
  WorldSettings settings = without_sleep();
  settings.solver = solver;
  settings.substeps = substeps;
  settings.max_angular_speed = 1000.0f;
  return settings;
}

// Rolls along x at `speed`, its axis along z.
Ride roll(const WorldSettings& settings, const Geometry& geometry, float speed) {
  Lab lab(settings);
  const Material material{.friction = 1.0f, .patch_radius = 0.0f};
  lab.add_ground(material, {}, 500.0f);
  const BodyId body = lab.add({.position = {0, kRollingRadius, 0},
                               .rotation = rotation_about({1, 0, 0}, 1.5707963267948966),
                               .linear_velocity = {speed, 0, 0},
                               .angular_velocity = {0, 0, -speed / kRollingRadius}},
                              geometry, material);
  lab.run(60);
  Ride ride{lab.height(body), lab.height(body), 0};
  for (int i = 0; i < 120; ++i) {
    lab.run(1);
    ride.lowest = std::min(ride.lowest, lab.height(body));
    ride.highest = std::max(ride.highest, lab.height(body));
    ride.vertical_speed = std::max(ride.vertical_speed, std::abs(lab.velocity(body).y()));
  }
  return ride;
}

// Before, the point of contact turned with the ball within the step, which left the ground for the solver: a
// ball at 5 m/s sank by 4.9 mm, one at 10 m/s by 10 mm.
TEST(Rolling, ABallRollsAsHighAsItRestsHoweverFast) {
  for (const Solver solver : {Solver::soft_step, Solver::sequential_impulse}) {
    for (const int substeps : {1, 4}) {
      const WorldSettings settings = settings_for(solver, substeps);
      const Ride rest = roll(settings, Sphere{kRollingRadius}, 0);
      EXPECT_NEAR(rest.lowest, kRollingRadius, substeps == 1 ? 1.2e-3 : 1e-4);
      for (const float speed : {1.0f, 5.0f, 20.0f, 50.0f, -50.0f}) {
        const Ride ride = roll(settings, Sphere{kRollingRadius}, speed);
        const std::string where = std::to_string(speed) + " m/s, " + std::to_string(substeps) + " substeps";
        EXPECT_NEAR(ride.lowest, rest.lowest, 1e-6) << where;
        EXPECT_NEAR(ride.highest, rest.lowest, 1e-6) << where;
        EXPECT_LT(ride.vertical_speed, 1e-5) << where;
      }
    }
  }
}

TEST(Rolling, ACapsuleRollsAsHighAsItRests) {
  const WorldSettings settings = settings_for(Solver::soft_step, 4);
  const Capsule capsule{.half_height = 0.3f, .radius = kRollingRadius};
  const Ride rest = roll(settings, capsule, 0);
  for (const float speed : {1.0f, 5.0f, 20.0f}) {
    const Ride ride = roll(settings, capsule, speed);
    EXPECT_NEAR(ride.lowest, rest.lowest, 2e-6) << speed << " m/s";
    EXPECT_NEAR(ride.highest, rest.lowest, 2e-6) << speed << " m/s";
    EXPECT_LT(ride.vertical_speed, 1e-4) << speed << " m/s";
  }
}

// The balls are the bodies A here.
TEST(Rolling, APlateRestsAsHighOnFastRollersAsOnStillOnes) {
  const auto height = [](float spin, BodyType type) {
    WorldSettings settings = settings_for(Solver::soft_step, 4);
    Lab lab(settings);
    const Material smooth{.friction = 0.0f, .patch_radius = 0.0f};
    for (const float x : {-1.0f, 1.0f}) {
      for (const float z : {-1.0f, 1.0f}) {
        BodyDef def{.type = type, .position = {x, -kRollingRadius, z}, .angular_velocity = {0, 0, spin}};
        if (type == BodyType::dynamic) def.mass = 1e3f, def.gravity_factor = 0;
        lab.add(def, Sphere{kRollingRadius}, smooth);
      }
    }
    const BodyId plate = lab.add({.position = {0, 0.1f, 0}, .mass = 1}, Box{{2, 0.1f, 2}}, smooth);
    lab.run(60);
    return lab.height(plate);
  };
  for (const BodyType type : {BodyType::kinematic, BodyType::dynamic}) {
    const double still = height(0, type);
    for (const float spin : {50.0f, 200.0f}) EXPECT_NEAR(height(spin, type), still, 2e-6) << spin;
  }
}

// Balls of any size roll alike: at the same angle a step they sank by the same share of their radius.
TEST(Rolling, BallsOfEverySizeKeepTheirHeight) {
  for (const float radius : {0.01f, 1.0f, 100.0f}) {
    const auto depth = [radius](float spin) {
      Lab lab(settings_for(Solver::soft_step, 4));
      const Material material{.friction = 1.0f, .patch_radius = 0.0f};
      lab.add_ground(material, {}, 20000.0f);
      const BodyId ball = lab.add({.position = {0, radius, 0},
                                   .linear_velocity = {-spin * radius, 0, 0},
                                   .angular_velocity = {0, 0, spin}},
                                  Sphere{radius}, material);
      lab.run(120);
      return lab.height(ball);
    };
    EXPECT_NEAR(depth(3.0f), depth(0), 1e-6 + 1e-6 * static_cast<double>(radius)) << radius;
  }
}

// Its velocity turns at 2/7 of the table's rate (Weltner, 1979). Before, the place at which the table was
// asked for its speed was that of the step's beginning, and the ball gained 5.4 % in two circles.
TEST(Rolling, ABallOnATurntableGoesRoundInACircle) {
  constexpr double kRate = 1.75;  // rad/s
  for (const int substeps : {4, 8}) {
    Lab lab(settings_for(Solver::soft_step, substeps));
    const Material material{.friction = 1.0f, .patch_radius = 0.0f};
    const BodyDef table{.type = BodyType::kinematic,
                        .position = {0, -0.5f, 0},
                        .angular_velocity = {0, static_cast<float>(kRate), 0}};
    lab.add(table, Box{{5, 0.5f, 5}}, material);
    const Eigen::Vector3d up(0, 1, 0), place(0.7, 0, 0), velocity(0, 0, 0.25);
    const Eigen::Vector3d spin =
        up.cross(velocity - kRate * up.cross(place)) / static_cast<double>(kRollingRadius);
    const BodyId ball =
        lab.add({.position = {0.7f, kRollingRadius, 0},
                 .linear_velocity = {0, 0, 0.25f},
                 .angular_velocity = {static_cast<float>(spin.x()), 0, static_cast<float>(spin.z())}},
                Sphere{kRollingRadius}, material);
    const double circle = 2 * 3.14159265358979 / (2.0 / 7.0 * kRate);
    const int steps = static_cast<int>(std::lround(2 * circle / static_cast<double>(kStep)));
    lab.run(steps);
    EXPECT_NEAR(lab.velocity(ball).norm(), 0.25, 0.003 * 0.25) << substeps << " substeps";
    const double angle = 2.0 / 7.0 * kRate * steps * static_cast<double>(kStep);
    const Eigen::Vector3d expected = Eigen::AngleAxisd(angle, up) * velocity;
    EXPECT_LT((lab.velocity(ball) - expected).norm(), 0.01 * 0.25) << substeps << " substeps";
  }
}

// Before, it was driven outward by 1.3 m in a minute.
TEST(Rolling, ABoxAtRestOnATurntableStaysThere) {
  for (const float offset : {0.0f, 0.15f}) {
    Lab lab(settings_for(Solver::soft_step, 4));
    const Material material{.friction = 1.0f};
    const BodyDef table{
        .type = BodyType::kinematic, .position = {0, -0.5f, 0}, .angular_velocity = {0, 1, 0}};
    lab.add(table, Box{{5, 0.5f, 5}}, material);
    const BodyId body = lab.world.create_body(
        {.position = {2, 0.2f, 0}, .linear_velocity = {0, 0, -2}, .angular_velocity = {0, 1, 0}});
    lab.world.add_shape(body, Box{{0.2f, 0.2f, 0.2f}}, material, {.local_pose = {{offset, 0, 0}, {}}});
    const double start = std::hypot(lab.position(body).x(), lab.position(body).z());
    lab.run(3600);
    EXPECT_NEAR(std::hypot(lab.position(body).x(), lab.position(body).z()), start, 0.01) << offset;
  }
}

// A core away from the body's center of mass does turn. The levers of its contact stay as they are where the
// step begins, so that the surface leaves the ground by the way that the lever's change makes in a step.
// Before it sank by 4 mm.
TEST(Rolling, AWeightedBallLeavesTheGroundByNoMoreThanItsLeverTurns) {
  constexpr double kSpin = 30;  // rad/s; not enough to hop: the center of mass falls by at most 4 m/s^2
  Lab lab(settings_for(Solver::soft_step, 4));
  const Material material{.friction = 1.0f, .patch_radius = 0.0f};
  lab.add_ground(material);
  const BodyId body =
      lab.world.create_body({.position = {0, kRollingRadius, 0},
                             .linear_velocity = {static_cast<float>(-kSpin) * kRollingRadius, 0, 0},
                             .angular_velocity = {0, 0, static_cast<float>(kSpin)}});
  lab.world.add_shape(body, Sphere{kRollingRadius}, material);
  lab.world.add_shape(body, Sphere{0.5f * kRollingRadius}, material,
                      {.local_pose = {{0, -0.4f * kRollingRadius, 0}, {}}});
  const double lever = std::abs(lab.height(body) - static_cast<double>(kRollingRadius));
  EXPECT_GT(lever, 0.04 * static_cast<double>(kRollingRadius));
  const double step = static_cast<double>(kStep), most = lever * kSpin * kSpin * step * step;
  for (int i = 0; i < 240; ++i) {
    lab.run(1);
    EXPECT_NEAR(static_cast<double>(lab.world.pose(body).position.y), static_cast<double>(kRollingRadius),
                most);
  }
}

}  // namespace
}  // namespace scree::physics
