// Cylinders, cones, rounded boxes and rounded hulls in whole worlds: rolling, resting, stacking, spinning.
#include <scree/height_field.h>
#include <tests/physics/lab.h>
#include <tools/scenes/random.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace scree::physics::smooth {
namespace {

constexpr double kPi = 3.14159265358979;
constexpr float kRadius = 0.2f;  // m

// Its axis along z.
Quat lying() { return rotation_about({1, 0, 0}, 0.5 * kPi); }

double total_energy(const Lab& lab, BodyId body) {
  return lab.kinetic_energy(body) + lab.mass(body) * kGravity * lab.height(body);
}

enum class Ground { box, half_space, mesh };
constexpr Ground kGrounds[] = {Ground::box, Ground::half_space, Ground::mesh};
const char* name_of(Ground ground) {
  return ground == Ground::box ? "box" : ground == Ground::half_space ? "half_space" : "mesh";
}

// A flat square of triangles, seen from above.
TriangleMesh flat_mesh(float half, int cells) {
  std::vector<Vec3> vertices;
  std::vector<MeshTriangle> triangles;
  const auto side = static_cast<std::uint32_t>(cells) + 1;
  const float cell = 2.0f * half / static_cast<float>(cells);
  scenes::Random random(7);
  for (std::uint32_t row = 0; row < side; ++row) {
    for (std::uint32_t column = 0; column < side; ++column) {
      const bool inner = row > 0 && column > 0 && row + 1 < side && column + 1 < side;
      const float jitter = inner ? 0.3f * cell : 0.0f;
      const float x = cell * static_cast<float>(column) - half + random.between(-jitter, jitter);
      const float z = cell * static_cast<float>(row) - half + random.between(-jitter, jitter);
      vertices.push_back({x, 0.0f, z});
    }
  }
  for (std::uint32_t row = 0; row + 1 < side; ++row) {
    for (std::uint32_t column = 0; column + 1 < side; ++column) {
      const std::uint32_t a = row * side + column, b = a + 1, c = a + side, d = c + 1;
      triangles.push_back({a, c, d});
      triangles.push_back({a, d, b});
    }
  }
  return TriangleMesh(vertices, triangles);
}

void add_ground(Lab& lab, Ground ground, const Material& material = {}, Quat tilt = {}) {
  if (ground == Ground::box) {
    lab.add_ground(material, tilt, 200.0f);
  } else if (ground == Ground::half_space) {
    lab.add({.type = BodyType::fixed, .rotation = tilt}, HalfSpace{}, material);
  } else {
    lab.add({.type = BodyType::fixed, .rotation = tilt}, flat_mesh(60.0f, 60), material);
  }
}

TEST(Smooth, ACylinderRollsDownAnInclineByTheLaw) {
  constexpr double kSlope = 0.2;
  for (const Ground ground : kGrounds) {
    Lab lab;
    const Material material{.friction = 1.0f};
    const Quat tilt = rotation_about({0, 0, 1}, -kSlope);  // down along +x
    add_ground(lab, ground, material, tilt);
    const Vec3 above = rotate(tilt, Vec3{-20.0f, kRadius, 0.0f});
    const BodyId body = lab.add({.position = above, .rotation = tilt * lying()},
                                Cylinder{.half_height = 0.3f, .radius = kRadius}, material);
    lab.run(30);
    const double v_0 = lab.velocity(body).norm();
    lab.run(120);
    const Eigen::Vector3d v = lab.velocity(body);
    const double expected = 2.0 / 3.0 * kGravity * std::sin(kSlope) * 2.0;
    EXPECT_NEAR(v.norm() - v_0, expected, 0.01 * expected) << name_of(ground);
    EXPECT_LT(std::abs(v.z()), 0.005 * v.norm()) << name_of(ground);
    EXPECT_LT(std::abs(lab.position(body).z()), 0.02) << name_of(ground);
  }
}

TEST(Smooth, ACylinderRollsOnWithoutBumpsAndLoss) {
  for (const Ground ground : kGrounds) {
    WorldSettings settings = without_sleep();
    settings.max_angular_speed = 1000.0f;
    Lab lab(settings);
    const Material material{.friction = 1.0f, .patch_radius = 0.0f};
    add_ground(lab, ground, material);
    constexpr float kSpeed = 5.0f;
    const BodyId body = lab.add({.position = {-20, kRadius, 0},
                                 .rotation = lying(),
                                 .linear_velocity = {kSpeed, 0, 0},
                                 .angular_velocity = {0, 0, -kSpeed / kRadius}},
                                Cylinder{.half_height = 0.3f, .radius = kRadius}, material);
    lab.run(60);
    double vertical = 0.0;
    for (int i = 0; i < 240; ++i) {
      lab.run(1);
      vertical = std::max(vertical, std::abs(lab.velocity(body).y()));
    }
    EXPECT_LT(vertical, 1e-3) << name_of(ground);
    EXPECT_NEAR(lab.velocity(body).x(), 5.0, 0.005) << name_of(ground);
    EXPECT_LT(std::abs(lab.velocity(body).z()), 0.01) << name_of(ground);
    EXPECT_NEAR(lab.height(body), double{kRadius}, 1e-3) << name_of(ground);
  }
}

TEST(Smooth, StandingShapesSleepWhereTheyStand) {
  const std::vector<std::pair<const char*, Geometry>> shapes = {
      {"cylinder", Cylinder{.half_height = 0.4f, .radius = 0.2f}},
      {"coin", Cylinder{.half_height = 0.01f, .radius = 0.2f}},
      {"cone", Cone{.half_height = 0.4f, .radius = 0.2f}},
      {"rounded box", Box{{0.2f, 0.35f, 0.15f}, 0.05f}}};
  for (const Ground ground : kGrounds) {
    for (const auto& [name, geometry] : shapes) {
      Lab lab{WorldSettings{}};
      add_ground(lab, ground);
      const float height = std::string(name) == "coin" ? 0.01f : 0.4f;
      const BodyId body =
          lab.add({.position = {1.0f, height, 0.5f}, .rotation = rotation_about({0, 1, 0}, 0.7)}, geometry);
      lab.run(240);
      const std::string where = std::string(name) + " on " + name_of(ground);
      EXPECT_FALSE(lab.world.is_awake(body)) << where;
      const Pose pose = lab.world.pose(body);
      EXPECT_NEAR(pose.position.x, 1.0, 1e-4) << where;
      EXPECT_NEAR(pose.position.z, 0.5, 1e-4) << where;
      EXPECT_NEAR(pose.position.y, height, 1e-3) << where;
    }
  }
}

TEST(Smooth, StacksStand) {
  const std::vector<std::pair<const char*, Geometry>> shapes = {
      {"cylinders", Cylinder{.half_height = 0.2f, .radius = 0.25f}},
      {"rounded boxes", Box{{0.2f, 0.15f, 0.2f}, 0.05f}}};
  for (const auto& [name, geometry] : shapes) {
    Lab lab;
    lab.add_ground();
    std::vector<BodyId> bodies;
    for (int k = 0; k < 10; ++k) {
      bodies.push_back(lab.add({.position = {0, 0.2f + 0.4f * static_cast<float>(k), 0},
                                .rotation = rotation_about({0, 1, 0}, 0.3 * k)},
                               geometry));
    }
    lab.run(600);
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      const Eigen::Vector3d p = lab.position(bodies[k]);
      EXPECT_LT(std::hypot(p.x(), p.z()), 0.01) << name << " " << k;
      EXPECT_NEAR(p.y(), 0.2 + 0.4 * static_cast<double>(k), 0.02 + 0.005 * static_cast<double>(k))
          << name << " " << k;
      EXPECT_LT(lab.velocity(bodies[k]).norm(), 0.01) << name << " " << k;
    }
  }
}

// Euler's disk: the coin wobbles faster and faster until it lies flat.
TEST(Smooth, ASpinningCoinComesToRestWithoutGainingEnergy) {
  for (const Ground ground : kGrounds) {
    Lab lab;
    const Material material{.friction = 0.5f};
    add_ground(lab, ground, material);
    // On its edge, 20 degrees from upright.
    const Quat tilted = rotation_about({1, 0, 0}, 0.5 * kPi - 0.35);
    const float radius = 0.1f, half = 0.005f;
    const float height = radius * std::cos(0.35f) + half * std::sin(0.35f);
    const BodyId coin =
        lab.add({.position = {0, height + 0.001f, 0}, .rotation = tilted, .angular_velocity = {0, 12, 0}},
                Cylinder{.half_height = half, .radius = radius}, material);
    double energy = total_energy(lab, coin);
    const double first = energy, scale = lab.mass(coin) * kGravity * double{radius};
    double most_gain = 0.0;
    for (int i = 0; i < 1500; ++i) {
      lab.run(1);
      const double now = total_energy(lab, coin);
      most_gain = std::max(most_gain, now - energy);
      energy = std::min(energy, now);
    }
    EXPECT_LT(most_gain, 0.02 * scale) << name_of(ground);
    EXPECT_LT(energy, first);
    EXPECT_NEAR(lab.height(coin), double{half}, 1e-3) << name_of(ground);
    EXPECT_LT(lab.velocity(coin).norm(), 1e-2) << name_of(ground);
    EXPECT_LT(lab.spin(coin).norm(), 0.1) << name_of(ground);
  }
}

// Its apex stays in place, and its base runs around it.
TEST(Smooth, AConeRollsInACircleAboutItsApex) {
  for (const Ground ground : kGrounds) {
    Lab lab;
    const Material material{.friction = 1.0f, .patch_radius = 0.0f};
    add_ground(lab, ground, material);
    const double radius = 0.2, height = 0.6, half_angle = std::atan2(radius, height);
    const double slant = std::hypot(radius, height);
    // The axis points along +x, tilted so that the apex lies at the origin's left on the ground.
    const Quat rotation = rotation_about({0, 0, 1}, 0.5 * kPi + half_angle);
    const Eigen::Vector3d axis = to_eigen(rotation) * Eigen::Vector3d::UnitY();  // to the apex
    const Eigen::Vector3d apex(0, 0, 0), middle = apex - 0.5 * height * axis;
    // About the line on the ground, whose points are at rest.
    const double spin = 3.0;
    const Eigen::Vector3d omega(spin, 0, 0), center = apex - 0.75 * height * axis;
    const Eigen::Vector3d velocity = omega.cross(center);
    BodyDef def{.position = {static_cast<float>(middle.x()), static_cast<float>(middle.y()),
                             static_cast<float>(middle.z())},
                .rotation = rotation,
                .linear_velocity = {static_cast<float>(velocity.x()), static_cast<float>(velocity.y()),
                                    static_cast<float>(velocity.z())},
                .angular_velocity = {static_cast<float>(spin), 0, 0}};
    const BodyId cone = lab.add(
        def, Cone{.half_height = static_cast<float>(0.5 * height), .radius = static_cast<float>(radius)},
        material);
    lab.world.set_linear_velocity(cone, def.linear_velocity);  // of the center of mass that it has now
    // The center of mass goes around at a distance of 3/4 h cos(half angle) from the vertical.
    const double around = velocity.norm() / (0.75 * height * std::cos(half_angle));
    const int steps = static_cast<int>(std::lround(2 * kPi / around / double{kStep}));
    double far = 0.0, high = 0.0;
    for (int i = 0; i < steps; ++i) {
      lab.run(1);
      const Pose pose = lab.world.pose(cone);
      const Eigen::Vector3d tip =
          to_eigen(pose.position) + to_eigen(pose.rotation) * Eigen::Vector3d(0, 0.5 * height, 0);
      far = std::max(far, std::hypot(tip.x(), tip.z()));
      high = std::max(high, std::abs(tip.y()));
    }
    EXPECT_LT(far, 0.05 * slant) << name_of(ground);
    EXPECT_LT(high, 0.02 * slant) << name_of(ground);
    EXPECT_LT((lab.position(cone) - center).norm(), 0.1 * slant) << name_of(ground);
    EXPECT_NEAR(lab.velocity(cone).norm(), velocity.norm(), 0.05 * velocity.norm()) << name_of(ground);
  }
}

TEST(Smooth, WhatSlidesOverAFlatMeshIsNotCaught) {
  const std::vector<std::pair<const char*, Geometry>> shapes = {
      {"rounded box", Box{{0.3f, 0.15f, 0.25f}, 0.05f}},
      {"cylinder", Cylinder{.half_height = 0.2f, .radius = 0.3f}},
      {"cone", Cone{.half_height = 0.2f, .radius = 0.3f}}};
  for (const auto& [name, geometry] : shapes) {
    Lab lab;
    const Material slick{.friction = 0.0f};
    lab.add({.type = BodyType::fixed}, flat_mesh(40.0f, 90), slick);
    const BodyId body =
        lab.add({.position = {-30, 0.2f, 0.3f}, .linear_velocity = {10, 0, 1}}, geometry, slick);
    lab.run(60);
    double vertical = 0.0;
    for (int i = 0; i < 240; ++i) {
      lab.run(1);
      vertical = std::max(vertical, std::abs(lab.velocity(body).y()));
    }
    EXPECT_LT(vertical, 1e-3) << name;
    EXPECT_NEAR(lab.velocity(body).x(), 10.0, 0.01) << name;
    EXPECT_LT(lab.spin(body).norm(), 0.01) << name;
  }
}

Geometry mixed_shape(int kind, Random& random, const Hull& rock) {
  const float a = random.uniform(0.12f, 0.3f), b = random.uniform(0.12f, 0.3f);
  switch (kind % 6) {
    case 0:
      return Cylinder{.half_height = a, .radius = b};
    case 1:
      return Cone{.half_height = a, .radius = b};
    case 2:
      return Box{{a, b, 0.2f}, 0.05f};
    case 3:
      return ConvexHull{.hull = rock, .scale = {a, b, 0.2f}, .rounding = 0.03f};
    case 4:
      return Cylinder{.half_height = 0.03f, .radius = a};
    default:
      return Cone{.half_height = 0.5f * a, .radius = a};
  }
}

TEST(Smooth, AHeapComesToRest) {
  WorldSettings settings = without_sleep();
  settings.measure_penetration = true;
  Lab lab(settings);
  const Material material{.friction = 0.6f};
  constexpr float kHalf = 1.6f;
  lab.add({.type = BodyType::fixed}, HalfSpace{}, material);
  for (int side = 0; side < 4; ++side) {
    const Quat inward = rotation_about({0, 0, 1}, -0.5 * kPi);  // y to x
    const Quat turned = rotation_about({0, 1, 0}, 0.5 * kPi * side) * inward;
    const Vec3 place = rotate(turned, Vec3{0, -kHalf, 0});
    lab.add({.type = BodyType::fixed, .position = place, .rotation = turned}, HalfSpace{}, material);
  }
  Random random(5);
  std::vector<Vec3> points;
  for (int k = 0; k < 14; ++k) {
    const Vec3 v = random.vector(1.0f);
    points.push_back((1.0f / length(v)) * v);
  }
  const Hull rock(points);
  std::vector<BodyId> bodies;
  for (int i = 0; i < 300; ++i) {
    const Vec3 place{-1.2f + 0.6f * static_cast<float>(i % 5), 0.5f + 0.7f * static_cast<float>(i / 25),
                     -1.2f + 0.6f * static_cast<float>(i / 5 % 5)};
    const Quat rotation = random.rotation();
    bodies.push_back(
        lab.add({.position = place, .rotation = rotation}, mixed_shape(i, random, rock), material));
  }
  const auto energy = [&] {
    double sum = 0.0;
    for (const BodyId body : bodies) sum += total_energy(lab, body);
    return sum;
  };
  double before = energy(), gain = 0.0;
  const double first = before;
  for (int i = 0; i < 600; ++i) {
    lab.run(1);
    const double now = energy();
    gain = std::max(gain, now - before);
    before = now;
  }
  EXPECT_LT(gain, 0.002 * first);
  double kinetic = 0.0;
  for (const BodyId body : bodies) {
    kinetic += lab.kinetic_energy(body);
    const Eigen::Vector3d p = lab.position(body);
    EXPECT_LT(std::max(std::abs(p.x()), std::abs(p.z())), double{kHalf});
    EXPECT_GT(p.y(), 0.0);
  }
  EXPECT_LT(kinetic, 1e-4 * first);
  EXPECT_LT(lab.world.stats().penetration_mean, 0.01);
}

// Ridges, valleys and slopes: what rolls about there stays above the ground.
TEST(Smooth, NothingFallsThroughHills) {
  Lab lab;
  constexpr std::uint32_t kSide = 16;
  std::vector<float> heights;
  for (std::uint32_t row = 0; row < kSide; ++row) {
    for (std::uint32_t column = 0; column < kSide; ++column) {
      const bool rim = row == 0 || column == 0 || row + 1 == kSide || column + 1 == kSide;
      heights.push_back(rim ? 6.0f : 0.5f * static_cast<float>((row * 5 + column * 3) % 4));
    }
  }
  const Material material{.friction = 0.5f};
  const TriangleMesh hills = height_field_mesh({.columns = kSide, .rows = kSide, .heights = heights});
  lab.add({.type = BodyType::fixed}, hills, material);
  Random random(8);
  const Hull rock(
      std::vector<Vec3>{{1, 0, 0}, {-1, 0.2f, 0}, {0, 1, 0}, {0, -1, 0.1f}, {0, 0, 1}, {0.1f, 0, -1}});
  std::vector<BodyId> bodies;
  for (int i = 0; i < 60; ++i) {
    const Vec3 place{random.uniform(3.0f, 12.0f), random.uniform(3.0f, 6.0f), random.uniform(3.0f, 12.0f)};
    const Quat rotation = random.rotation();
    bodies.push_back(
        lab.add({.position = place, .rotation = rotation}, mixed_shape(i, random, rock), material));
  }
  for (int i = 0; i < 600; ++i) {
    lab.run(1);
    for (const BodyId body : bodies) {
      ASSERT_GT(lab.height(body), 0.0) << i;
      ASSERT_LT(lab.velocity(body).norm(), 15.0) << i;
    }
  }
}

TEST(Smooth, CollidingPairsKeepTheirMomentum) {
  Random random(11);
  const Hull rock(
      std::vector<Vec3>{{1, 0, 0}, {-1, 0.2f, 0}, {0, 1, 0}, {0, -1, 0.1f}, {0, 0, 1}, {0.1f, 0, -1}});
  for (int i = 0; i < 60; ++i) {
    WorldSettings settings = without_gravity();
    Lab lab(settings);
    const Material material{.friction = 0.5f, .restitution = i % 2 == 0 ? 0.0f : 0.5f};
    const float speed = random.uniform(1.0f, 8.0f);
    const Vec3 spin_a = random.vector(3.0f), spin_b = random.vector(3.0f);
    const Quat turn_a = random.rotation(), turn_b = random.rotation();
    const BodyId a = lab.add({.position = {-1, 0.1f, 0},
                              .rotation = turn_a,
                              .linear_velocity = {speed, 0, 0},
                              .angular_velocity = spin_a},
                             mixed_shape(i, random, rock), material);
    const BodyId b = lab.add({.position = {1, 0, 0.05f},
                              .rotation = turn_b,
                              .linear_velocity = {-speed, 0, 0},
                              .angular_velocity = spin_b},
                             mixed_shape(i / 6, random, rock), material);
    const auto momentum = [&]() -> Eigen::Vector3d {
      return lab.mass(a) * lab.velocity(a) + lab.mass(b) * lab.velocity(b);
    };
    const auto angular = [&]() -> Eigen::Vector3d {
      return lab.angular_momentum(a) + lab.angular_momentum(b) +
             lab.mass(a) * lab.position(a).cross(lab.velocity(a)) +
             lab.mass(b) * lab.position(b).cross(lab.velocity(b));
    };
    const Eigen::Vector3d p = momentum(), l = angular();
    const double energy = lab.kinetic_energy(a) + lab.kinetic_energy(b);
    lab.run(90);
    const double size = (lab.mass(a) + lab.mass(b)) * static_cast<double>(speed);
    EXPECT_LT((momentum() - p).norm(), 1e-5 * size) << i;
    EXPECT_LT((angular() - l).norm(), 0.02 * size) << i;
    EXPECT_LT(lab.kinetic_energy(a) + lab.kinetic_energy(b), energy * 1.001) << i;
    EXPECT_TRUE(lab.all_finite());
  }
}

}  // namespace
}  // namespace scree::physics::smooth
