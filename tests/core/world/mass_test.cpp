// Mass properties against closed forms.
#include <core/world/edit.h>
#include <core/world/mass.h>
#include <core/world/math.h>
#include <scree/eigen.h>
#include <tests/core/world/world_fixture.h>

#include <Eigen/Dense>

#include <cmath>
#include <numbers>

namespace scree::test {
namespace {

constexpr double kPi = std::numbers::pi;

Eigen::Matrix3d matrix(const Symmetric& s) {
  Eigen::Matrix3d m;
  m << s.m[0], s.m[1], s.m[2], s.m[1], s.m[3], s.m[4], s.m[2], s.m[4], s.m[5];
  return m;
}

MassSum sum_of(const Geometry& geometry, double density, const Pose& pose = {}) {
  return part_of(geometry, density, pose);
}

MassSum sum_of(std::initializer_list<MassSum> parts) {
  MassMoments moments;
  for (const MassSum& part : parts) moments.add(part);
  return moments.sum();
}

void expect_near(const Eigen::Matrix3d& found, const Eigen::Matrix3d& expected, double relative) {
  EXPECT_LE((found - expected).norm(), relative * expected.norm()) << found << "\nexpected\n" << expected;
}

Quat turn(Vec3 axis, double angle) {
  const double scale = std::sin(angle / 2) / std::sqrt(dot(axis, axis));
  return {static_cast<float>(axis.x * scale), static_cast<float>(axis.y * scale),
          static_cast<float>(axis.z * scale), static_cast<float>(std::cos(angle / 2))};
}

TEST(Mass, ASphereHasTwoFifthsOfItsMassTimesRadiusSquared) {
  const MassSum sum = sum_of(Sphere{2.0f}, 3.0);
  EXPECT_DOUBLE_EQ(sum.mass, 3.0 * 4.0 / 3.0 * kPi * 8.0);
  expect_near(matrix(sum.inertia), 0.4 * sum.mass * 4.0 * Eigen::Matrix3d::Identity(), 1e-15);
}

TEST(Mass, ABoxHasATwelfthOfItsMassTimesTheSquaresOfItsSides) {
  const MassSum sum = sum_of(Box{{0.5f, 1.0f, 1.5f}}, 10.0);
  EXPECT_DOUBLE_EQ(sum.mass, 60.0);
  expect_near(matrix(sum.inertia), Eigen::Vector3d(5.0 * 13.0, 5.0 * 10.0, 5.0 * 5.0).asDiagonal(), 1e-15);
}

// The exact moments of a solid of revolution of profile r(y): m = pi int r^2, I_yy = pi/2 int r^4,
// I_xx = pi int (r^4 / 4 + y^2 r^2). The integrand is a polynomial in y on the cap, so that Gauss-Legendre
// quadrature with three points is exact.
TEST(Mass, ACapsuleIsTheSolidOfRevolutionOfItsProfile) {
  const double r = 0.75, half = 1.25, density = 2.0;
  const double node = std::sqrt(0.6), nodes[] = {-node, 0.0, node}, weights[] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
  double mass = 2 * half * r * r, along = half * std::pow(r, 4);
  double across = 2 * half * std::pow(r, 4) / 4 + r * r * 2 * std::pow(half, 3) / 3;
  for (int i = 0; i < 3; ++i) {
    const double t = 0.5 * r * (1 + nodes[i]), weight = 2 * 0.5 * r * weights[i];  // both caps
    const double squared = r * r - t * t, y = half + t;
    mass += weight * squared;
    along += weight * squared * squared / 2;
    across += weight * (squared * squared / 4 + y * y * squared);
  }
  const double scale = kPi * density;
  const MassSum sum = sum_of(Capsule{1.25f, 0.75f}, density);
  EXPECT_NEAR(sum.mass, scale * mass, 1e-12 * sum.mass);
  expect_near(matrix(sum.inertia), scale * Eigen::Vector3d(across, along, across).asDiagonal(), 1e-14);
}

// As above; the integrands of a cylinder and a cone are polynomials of degree 4 at most.
MassSum solid_of_revolution(double low, double high, double (*squared_radius)(double)) {
  const double node = std::sqrt(0.6), nodes[] = {-node, 0.0, node}, weights[] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
  double mass = 0.0, first = 0.0, second = 0.0, along = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double y = 0.5 * (low + high) + 0.5 * (high - low) * nodes[i];
    const double area = kPi * squared_radius(y), weight = 0.5 * (high - low) * weights[i] * area;
    mass += weight;
    first += weight * y;
    second += weight * y * y;
    along += weight * squared_radius(y) / 2;
  }
  MassSum sum;
  sum.mass = mass;
  sum.center[1] = first / mass;
  const double across = along / 2 + second - first * first / mass;
  sum.inertia = {{across, 0, 0, along, 0, across}};
  return sum;
}

void expect_near(const MassSum& found, const MassSum& expected) {
  EXPECT_NEAR(found.mass, expected.mass, 1e-12 * expected.mass);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(found.center[i], expected.center[i], 1e-12);
  expect_near(matrix(found.inertia), matrix(expected.inertia), 1e-12);
}

TEST(Mass, ACylinderAndAConeAreTheSolidsOfRevolutionOfTheirProfiles) {
  expect_near(sum_of(Cylinder{1.25f, 0.75f}, 1.0),
              solid_of_revolution(-1.25, 1.25, [](double) { return 0.75 * 0.75; }));
  expect_near(sum_of(Cone{1.25f, 0.75f}, 1.0), solid_of_revolution(-1.25, 1.25, [](double y) {
                const double radius = 0.75 * (1.25 - y) / 2.5;
                return radius * radius;
              }));
  EXPECT_EQ(sum_of(Cone{1.25f, 0.75f}, 3.0).center[1], -0.625);
}

TEST(Mass, AConesCenterTurnsWithIt) {
  World world;
  const BodyId body = world.create_body({.position = {1, 2, 3}});
  world.add_shape(body, Cone{2.0f, 1.0f}, {}, {.local_pose = {{5, 0, 0}, turn({0, 0, 1}, kPi / 2)}});
  const MassProperties mass = world.mass_properties(body);
  EXPECT_NEAR(mass.center.x, 5.0f + 1.0f, 1e-6f);  // its axis points to -x
  EXPECT_NEAR(mass.center.y, 0.0f, 1e-6f);
  EXPECT_NEAR(world.pose(body).position.x, 1.0f, 1e-6f);
}

// The sum over a grid of the points whose distance from the box within is at most the rounding, with the
// surface smoothed over a cell. By symmetry one eighth is enough.
TEST(Mass, ARoundedBoxIsTheSumOfItsPoints) {
  const Vec3 half{0.5f, 1.0f, 0.3f};
  const float rounding = 0.4f;
  constexpr int kCells = 96;
  const double step = 1.6 / kCells;
  double mass = 0.0, moment[3]{};
  for (int i = 0; i < kCells * kCells * kCells; ++i) {
    const double p[3] = {step * (0.5 + i % kCells), step * (0.5 + i / kCells % kCells),
                         step * (0.5 + i / (kCells * kCells))};
    const double x = std::max(p[0] - half.x, 0.0), y = std::max(p[1] - half.y, 0.0),
                 z = std::max(p[2] - half.z, 0.0);
    const double cell = 8 * step * step * step *
                        std::clamp(0.5 + (rounding - std::sqrt(x * x + y * y + z * z)) / step, 0.0, 1.0);
    mass += cell;
    for (int k = 0; k < 3; ++k) moment[k] += cell * p[k] * p[k];
  }
  const MassSum sum = sum_of(Box{half, rounding}, 1.0);
  EXPECT_NEAR(sum.mass, mass, 1e-3 * mass);
  expect_near(
      matrix(sum.inertia),
      Eigen::Vector3d(moment[1] + moment[2], moment[0] + moment[2], moment[0] + moment[1]).asDiagonal(),
      2e-3);
}

TEST(Mass, ARoundingIsContinuousAtNoneAndABallWhereTheBoxIsSmall) {
  const Box sharp{{0.5f, 1.0f, 1.5f}};
  const MassSum almost = sum_of(Box{sharp.half_extents, 1e-9f}, 3.0), exact = sum_of(sharp, 3.0);
  EXPECT_NEAR(almost.mass, exact.mass, 1e-8 * exact.mass);
  expect_near(matrix(almost.inertia), matrix(exact.inertia), 1e-8);
  const MassSum round = sum_of(Box{{1e-4f, 1e-4f, 1e-4f}, 10.0f}, 1.0), ball = sum_of(Sphere{10.0f}, 1.0);
  EXPECT_NEAR(round.mass, ball.mass, 1e-4 * ball.mass);
  expect_near(matrix(round.inertia), matrix(ball.inertia), 1e-4);
}

TEST(Mass, NewShapesOfAllSizesHaveAFiniteInertia) {
  for (const float a : {1e-4f, 1.0f, 1e5f}) {
    for (const float b : {1e-4f, 1.0f, 1e5f}) {
      for (const Geometry& geometry : {Geometry{Cylinder{a, b}}, Geometry{Cone{a, b}},
                                       Geometry{Box{{a, b, a}, b}}, Geometry{Box{{a, b, a}, 1e5f}}}) {
        World world;
        const BodyId body = world.create_body({.rotation = turn({1, 2, 3}, 1.0)});
        world.add_shape(body, geometry, {.density = a < 1.0f && b < 1.0f ? 1e3f : 1.0f},
                        {.local_pose = {{1, 1, 1}, turn({3, 1, 2}, 2.0)}});
        const InertiaRow& row = internals(world).bodies.local_mass[body.index];
        EXPECT_TRUE(std::isfinite(row.inverse_mass) && row.inverse_mass > 0.0f);
        for (const float entry : row.inverse_inertia) EXPECT_TRUE(std::isfinite(entry));
      }
    }
  }
}

TEST(Mass, AShapeAwayFromTheOriginObeysTheParallelAxisTheorem) {
  const Quat rotation = turn({1, 2, -1}, 0.8);
  const Pose pose{{3, -2, 5}, rotation};
  const Box box{{0.5f, 1.0f, 1.5f}};
  const MassSum alone = sum_of(box, 10.0), placed = sum_of(box, 10.0, pose);
  EXPECT_EQ(placed.center[0], 3.0);
  EXPECT_EQ(placed.center[1], -2.0);
  EXPECT_EQ(placed.center[2], 5.0);
  const Eigen::Matrix3d r =
      Eigen::Quaterniond(rotation.w, rotation.x, rotation.y, rotation.z).normalized().matrix();
  expect_near(matrix(placed.inertia), r * matrix(alone.inertia) * r.transpose(), 1e-14);

  const MassSum ball = sum_of(Sphere{1.0f}, 5.0);
  const MassSum with_ball = sum_of({placed, ball});
  const Eigen::Vector3d box_center(3, -2, 5);
  const Eigen::Vector3d center = placed.mass / (placed.mass + ball.mass) * box_center;
  const auto shifted = [](double mass, const Eigen::Vector3d& d) {
    return Eigen::Matrix3d(mass * (d.squaredNorm() * Eigen::Matrix3d::Identity() - d * d.transpose()));
  };
  expect_near(matrix(with_ball.inertia),
              matrix(placed.inertia) + shifted(placed.mass, box_center - center) + matrix(ball.inertia) +
                  shifted(ball.mass, center),
              1e-14);
}

TEST(Mass, EightOctantsOfABoxAreTheBox) {
  const Quat rotation = turn({-1, 0.5f, 2}, 1.3);
  MassMoments moments;
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner{(i & 1) != 0 ? 0.5f : -0.5f, (i & 2) != 0 ? 1.0f : -1.0f, (i & 4) != 0 ? 1.5f : -1.5f};
    const Vec3 place = rotate(rotation, corner) + Vec3{100, 20, -40};
    moments.add(part_of(Box{{0.5f, 1.0f, 1.5f}}, 7.0, {place, rotation}));
  }
  const MassSum parts = moments.sum();
  const MassSum whole = sum_of(Box{{1, 2, 3}}, 7.0, {{100, 20, -40}, rotation});
  EXPECT_NEAR(parts.mass, whole.mass, 1e-12 * whole.mass);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(parts.center[i], whole.center[i], 1e-5);
  expect_near(matrix(parts.inertia), matrix(whole.inertia), 1e-5);  // corners are rounded to float
}

TEST(Mass, DistanceFromTheOriginChangesTheInertiaOnlyByRounding) {
  const float far = 65536.0f;
  const MassSum parts = sum_of({sum_of(Sphere{0.125f}, 1000.0, {{far - 1.0f, far, far}, {}}),
                                sum_of(Sphere{0.125f}, 1000.0, {{far + 1.0f, far, far}, {}})});
  const MassSum ball = sum_of(Sphere{0.125f}, 1000.0);
  const double own = 2 * ball.inertia.m[0], shift = 2 * ball.mass;
  expect_near(matrix(parts.inertia), Eigen::Vector3d(own, own + shift, own + shift).asDiagonal(), 1e-14);
}

TEST(Mass, RowsHoldTheInverse) {
  World world;
  const BodyId body = world.create_body({});
  world.add_shape(body, Box{{0.5f, 1.0f, 1.5f}}, {}, {.local_pose = {{1, 0, 0}, turn({1, 1, 0}, 0.7)}});
  world.add_shape(body, Capsule{1.0f, 0.25f}, {.density = 500.0f}, {.local_pose = {{0, 0, 2}, {}}});
  const Bodies& bodies = internals(world).bodies;
  const InertiaRow& inverse = bodies.local_mass[row_of(body)];
  Symmetric row;
  for (int i = 0; i < 6; ++i) row.m[i] = inverse.inverse_inertia[i];
  const Eigen::Matrix3d inertia = inertia_matrix(world.mass_properties(body)).cast<double>();
  expect_near(matrix(row) * inertia, Eigen::Matrix3d::Identity(), 1e-6);
  EXPECT_NEAR(inverse.inverse_mass * world.mass_properties(body).mass, 1.0f, 1e-6f);
}

TEST(Mass, OnlyUnequalMomentsAreGyroscopic) {
  World world;
  const auto gyroscopic = [&](const Geometry& geometry) {
    const BodyId body = world.create_body({});
    world.add_shape(body, geometry, {}, {.local_pose = {{}, turn({1, 2, 3}, 1.0)}});
    return (internals(world).bodies.motion[row_of(body)].flags & kMotionGyroscopic) != 0;
  };
  EXPECT_FALSE(gyroscopic(Sphere{}));
  EXPECT_FALSE(gyroscopic(Box{}));
  EXPECT_TRUE(gyroscopic(Box{{0.5f, 0.5f, 0.51f}}));
  EXPECT_TRUE(gyroscopic(Capsule{}));
}

TEST(Mass, AGivenMassScalesTheShapesInertia) {
  World world;
  const BodyId plain = world.create_body({}), given = world.create_body({.mass = 16.0f});
  for (const BodyId body : {plain, given}) {
    world.add_shape(body, Box{{0.5f, 1.0f, 1.0f}}, {.density = 2.0f}, {.local_pose = {{0, 3, 0}, {}}});
  }
  const MassProperties a = world.mass_properties(plain), b = world.mass_properties(given);
  EXPECT_EQ(a.mass, 8.0f);
  EXPECT_EQ(b.mass, 16.0f);
  EXPECT_EQ(a.center, b.center);
  for (int i = 0; i < 6; ++i) EXPECT_FLOAT_EQ(b.inertia[i], 2.0f * a.inertia[i]);
  world.reset_mass(given);
  EXPECT_EQ(world.mass_properties(given).mass, 8.0f);
}

TEST(Mass, ABodyWithoutShapesWeighsOneKilogram) {
  World world;
  const MassProperties bare = world.mass_properties(world.create_body({}));
  EXPECT_EQ(bare.mass, 1.0f);
  EXPECT_EQ(bare.inertia[0], 1.0f);
  const MassProperties given = world.mass_properties(world.create_body({.mass = 5.0f}));
  EXPECT_EQ(given.mass, 5.0f);
  EXPECT_EQ(given.inertia[1], 5.0f);
}

TEST(Mass, FollowsEveryChangeOfShapesAndBack) {
  World world;
  const BodyId body = world.create_body({});
  const ShapeId first = world.add_shape(body, Box{}, {.density = 100.0f});
  EXPECT_FLOAT_EQ(world.mass_properties(body).mass, 100.0f);
  const ShapeId second = world.add_shape(body, Box{}, {.density = 300.0f}, {.local_pose = {{4, 0, 0}, {}}});
  EXPECT_FLOAT_EQ(world.mass_properties(body).mass, 400.0f);
  EXPECT_FLOAT_EQ(world.mass_properties(body).center.x, 3.0f);
  world.set_geometry(second, Box{{0.5f, 0.5f, 1.0f}});
  EXPECT_FLOAT_EQ(world.mass_properties(body).mass, 700.0f);
  world.set_material(second, {.density = 50.0f});
  EXPECT_FLOAT_EQ(world.mass_properties(body).mass, 200.0f);
  world.set_local_pose(second, {{-4, 0, 0}, {}});
  EXPECT_FLOAT_EQ(world.mass_properties(body).center.x, -2.0f);
  world.destroy_shape(first);
  EXPECT_FLOAT_EQ(world.mass_properties(body).center.x, -4.0f);
  world.destroy_shape(second);
  EXPECT_EQ(world.mass_properties(body).mass, 1.0f);
  EXPECT_EQ(world.mass_properties(body).center, Vec3{});
}

TEST(Mass, GivenPropertiesOutliveChangesOfShapesUntilReset) {
  World world;
  const BodyId body = world.create_body({});
  const MassProperties given{.mass = 3.0f, .center = {1, 0, 0}, .inertia = {2, 3, 4, 0.1f, 0.2f, 0.3f}};
  world.set_mass_properties(body, given);
  const auto expect_given = [&] {
    const MassProperties found = world.mass_properties(body);
    EXPECT_EQ(found.mass, given.mass);
    EXPECT_EQ(found.center, given.center);
    for (int i = 0; i < 6; ++i) EXPECT_EQ(found.inertia[i], given.inertia[i]);
  };
  expect_given();
  world.add_shape(body, Box{});
  expect_given();
  for (const BodyType type : {BodyType::fixed, BodyType::kinematic, BodyType::dynamic}) {
    world.set_body_type(body, type);
    expect_given();
    const bool pushed = internals(world).bodies.local_mass[row_of(body)].inverse_mass > 0.0f;
    EXPECT_EQ(pushed, type == BodyType::dynamic);
  }
  world.reset_mass(body);
  EXPECT_FLOAT_EQ(world.mass_properties(body).mass, 1000.0f);
  EXPECT_EQ(world.mass_properties(body).center, Vec3{});
}

TEST(Mass, AFlatPlateIsASolid) {
  World world;
  const BodyId body = world.create_body({});
  world.set_mass_properties(body, {.mass = 1.0f, .center = {}, .inertia = {1, 1, 2, 0, 0, 0}});
  EXPECT_EQ(world.mass_properties(body).inertia[2], 2.0f);
}

TEST(Mass, TheInverseOfATurnedNeedleStaysPositiveDefinite) {
  World world;
  for (int i = 0; i < 20; ++i) {
    const BodyId body = world.create_body({});
    world.add_shape(body, Capsule{1e4f, 1e-3f}, {},
                    {.local_pose = {{}, turn({1, 0.3f * static_cast<float>(i), -0.7f}, 0.3 * i + 0.1)}});
    Symmetric inverse_row;
    for (int k = 0; k < 6; ++k) {
      inverse_row.m[k] = internals(world).bodies.local_mass[row_of(body)].inverse_inertia[k];
    }
    EXPECT_TRUE(is_positive_definite(inverse_row));
  }
}

// --- the moving center of mass ---

TEST(CenterOfMass, ShapesAndOriginStayWhileTheCenterMoves) {
  World world;
  const Quat rotation = turn({0, 0, 1}, kPi / 2);
  const BodyId body = world.create_body({.position = {10, 0, 0}, .rotation = rotation});
  world.add_shape(body, Box{}, {.density = 1.0f});
  const ShapeId weight = world.add_shape(body, Box{}, {.density = 3.0f}, {.local_pose = {{4, 0, 0}, {}}});
  const Vec3 center = world.center_of_mass(body);
  EXPECT_NEAR(center.x, 10.0f, 1e-5f);
  EXPECT_NEAR(center.y, 3.0f, 1e-5f);
  EXPECT_NEAR(world.pose(body).position.x, 10.0f, 1e-5f);
  EXPECT_NEAR(world.pose(body).position.y, 0.0f, 1e-5f);
  place_matter(internals(world));
  const PoseRow& local = internals(world).shapes.local_pose[row_of(weight)];
  EXPECT_NEAR(local.position[0], 1.0f, 1e-5f);
  EXPECT_EQ(world.local_pose(weight).position, (Vec3{4, 0, 0}));
}

TEST(CenterOfMass, MatterKeepsItsVelocityWhenTheCenterMoves) {
  World world;
  const BodyId body =
      world.create_body({.linear_velocity = {1, 2, 3}, .angular_velocity = {0.5f, -1.0f, 2.0f}});
  world.add_shape(body, Sphere{});
  const Vec3 probe{0.3f, -0.2f, 0.7f};
  const Vec3 before = world.velocity_at(body, probe);
  world.add_shape(body, Sphere{}, {}, {.local_pose = {{3, 1, -2}, {}}});
  EXPECT_NE(world.linear_velocity(body), (Vec3{1, 2, 3}));
  const Vec3 after = world.velocity_at(body, probe);
  EXPECT_NEAR(length(after - before), 0.0f, 1e-5f);
}

TEST(CenterOfMass, KinematicBodiesTurnAboutTheirOrigin) {
  World world;
  const BodyId body = world.create_body({.type = BodyType::kinematic, .position = {1, 1, 1}});
  world.add_shape(body, Sphere{}, {}, {.local_pose = {{3, 0, 0}, {}}});
  EXPECT_EQ(world.center_of_mass(body), (Vec3{1, 1, 1}));
  world.set_body_type(body, BodyType::dynamic);
  EXPECT_EQ(world.center_of_mass(body), (Vec3{4, 1, 1}));
  EXPECT_EQ(world.pose(body).position, (Vec3{1, 1, 1}));
  world.set_body_type(body, BodyType::kinematic);
  EXPECT_EQ(world.center_of_mass(body), (Vec3{1, 1, 1}));
}

TEST(CenterOfMass, BulkCreationPlacesItAsTheSingleCallsDo) {
  World one, bulk;
  bulk.share_handles(one);
  const BodyDef def{.position = {1, 2, 3}, .rotation = turn({1, 1, 1}, 0.4), .linear_velocity = {1, 0, 0}};
  const ShapeOptions options{.local_pose = {{0.5f, 0.25f, 0}, turn({0, 1, 0}, 0.3)}};
  BodyDef single_def = def;
  single_def.linear_velocity = {};
  const BodyId single = one.create_body(single_def);
  one.add_shape(single, Capsule{}, {}, options);
  one.set_linear_velocity(single, def.linear_velocity);
  BodyId id;
  const Geometry geometry = Capsule{};
  bulk.create_bodies({&def, 1}, {&geometry, 1}, {}, options, {&id, 1});
  EXPECT_EQ(id, single);
  EXPECT_EQ(bulk.mass_properties(id).mass, one.mass_properties(single).mass);
  EXPECT_EQ(bulk.mass_properties(id).center, one.mass_properties(single).center);
  EXPECT_NEAR(length(bulk.center_of_mass(id) - one.center_of_mass(single)), 0.0f, 1e-6f);
}

}  // namespace
}  // namespace scree::test
