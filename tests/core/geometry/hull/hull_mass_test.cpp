// Mass properties of hulls against closed forms, against sums over a fine grid, and under scale and
// placement.
#include <tests/core/geometry/hull/hull_masses.h>

#include <limits>

namespace scree::test {
namespace {

TEST(HullMass, ABoxOfPointsWeighsWhatABoxWeighs) {
  for (const Vec3& half : {Vec3{0.5f, 1.0f, 1.5f}, Vec3{0.1f, 0.2f, 0.3f}, Vec3{10.0f, 0.01f, 1.0f}}) {
    const ConvexHull hull{Hull(lattice(2, 2.0f * half))};
    expect_near(sum_of(hull, 7.0), sum_of(Box{half}, 7.0), 1e-6);
  }
}

// With corners 0 and on the axes: volume abc/6, centroid (a, b, c)/4, and about it int x^2 = V 3 a^2 / 80,
// int x y = -V a b / 80.
TEST(HullMass, ATetrahedronHasItsClosedForm) {
  const double a = 1.0, b = 2.0, c = 0.5, volume = a * b * c / 6.0;
  MassSum expected;
  expected.mass = volume;
  const double xx = volume * 3 * a * a / 80, yy = volume * 3 * b * b / 80, zz = volume * 3 * c * c / 80;
  const double center[3] = {a / 4, b / 4, c / 4};
  std::copy_n(center, 3, expected.center);
  expected.inertia = {
      {yy + zz, volume * a * b / 80, volume * a * c / 80, xx + zz, volume * b * c / 80, xx + yy}};
  const Hull hull(Cloud{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 0.5f}});
  expect_near(sum_of(ConvexHull{hull}), expected, 1e-6);
  EXPECT_NEAR(hull.volume(), volume, 1e-7);
  EXPECT_NEAR(hull.centroid().y, 0.5, 1e-7);
}

// A regular polygon of n corners on radius r has the area n r^2 sin(2 pi/n) / 2 and, about any axis in its
// plane, the second moment area r^2 (2 + cos(2 pi/n)) / 12.
TEST(HullMass, AnUprightPrismHasItsClosedForm) {
  for (const int n : {3, 6, 50}) {
    const double r = 0.75, h = 2.5, angle = 2 * kPi / n;
    MassSum expected;
    expected.mass = n * r * r * std::sin(angle) / 2 * h;
    const double across = expected.mass * r * r * (2 + std::cos(angle)) / 12;
    const double along = expected.mass * h * h / 12;
    expected.inertia = {{across + along, 0, 0, 2 * across, 0, across + along}};
    expect_near(sum_of(ConvexHull{Hull(prism(n, 0.75f, 1.25f))}), expected, 1e-6);
  }
}

// Sums over lines along x through a fine grid of y and z, each cut exactly by the planes.
MassSum sum_over_lines(const Hull& hull, int lines) {
  const HullSolid& solid = solid_of(hull);
  Vec3 reach;
  for (const Vec3& v : solid.topology.vertices) {
    reach = {std::max(reach.x, std::abs(v.x)), std::max(reach.y, std::abs(v.y)),
             std::max(reach.z, std::abs(v.z))};
  }
  double mass = 0, first[3]{}, second[6]{};
  const double dy = 2.0 * reach.y / lines, dz = 2.0 * reach.z / lines;
  for (int j = 0; j < lines; ++j) {
    for (int k = 0; k < lines; ++k) {
      const double y = -reach.y + (j + 0.5) * dy, z = -reach.z + (k + 0.5) * dz;
      double low = -reach.x, high = reach.x;
      for (const auto& [n, offset] : solid.topology.planes) {
        const double rest = offset - n[1] * y - n[2] * z;
        if (n[0] > 0) high = std::min(high, rest / n[0]);
        if (n[0] < 0) low = std::max(low, rest / n[0]);
        if (n[0] == 0 && rest < 0) high = low;
      }
      if (high <= low) continue;
      const double m = (high - low) * dy * dz, x = (low + high) / 2;
      mass += m;
      first[0] += m * x, first[1] += m * y, first[2] += m * z;
      second[0] += m * (x * x + (high - low) * (high - low) / 12);
      second[1] += m * x * y, second[2] += m * x * z, second[3] += m * y * y;
      second[4] += m * y * z, second[5] += m * z * z;
    }
  }
  MassSum sum;
  sum.mass = mass;
  for (int i = 0; i < 3; ++i) sum.center[i] = first[i] / mass;
  const double* c = sum.center;
  const double xx = second[0] - mass * c[0] * c[0], yy = second[3] - mass * c[1] * c[1];
  const double zz = second[5] - mass * c[2] * c[2];
  sum.inertia = {{yy + zz, mass * c[0] * c[1] - second[1], mass * c[0] * c[2] - second[2], xx + zz,
                  mass * c[1] * c[2] - second[4], xx + yy}};
  for (int i = 0; i < 3; ++i) sum.center[i] += solid.origin[i];
  return sum;
}

TEST(HullMass, RandomHullsWeighWhatTheirSlicesWeigh) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const int points = 4 + static_cast<int>(seed * seed);
    const Cloud cloud = stretched(cube_cloud(points, seed), {1.0f, 0.3f, 2.0f});
    const Hull hull(turned(cloud, kTurn, {5, -3, 1}));
    expect_near(sum_of(ConvexHull{hull}), sum_over_lines(hull, 400), 2e-3);  // 400 lines see so much of a rim
  }
}

TEST(HullMass, HullsOfASphereConvergeToTheSphere) {
  double last_volume = 1.0, last_inertia = 1.0;
  for (const int limit : {16, 32, 64, 128, 256}) {
    const Hull hull(sphere_cloud(20000, 1), {.max_vertices = limit});
    const MassSum sum = sum_of(ConvexHull{hull});
    const double volume_gap = 1.0 - sum.mass / (4.0 / 3.0 * kPi);
    const double inertia_gap = 1.0 - sum.inertia.m[0] / (8.0 / 15.0 * kPi);
    // Corners twice as many halve the gap, or nearly so.
    EXPECT_LT(volume_gap, 0.65 * last_volume) << limit;
    EXPECT_LT(inertia_gap, 0.65 * last_inertia) << limit;
    EXPECT_GT(volume_gap, 0.0);
    last_volume = volume_gap;
    last_inertia = inertia_gap;
  }
  EXPECT_LT(last_volume, 0.03);
}

TEST(HullMass, AScaledHullWeighsWhatTheHullOfScaledPointsWeighs) {
  const Vec3 scale{2.0f, 0.25f, 3.0f};
  for (const NamedCloud& cloud : all_clouds()) {
    if (std::string(cloud.name) == "tiny" || std::string(cloud.name) == "huge") continue;
    if (std::string(cloud.name) == "box far away") continue;  // rounded to another grid of floats
    const Hull hull(cloud.points);
    const Hull scaled(stretched(Cloud(hull.vertices().begin(), hull.vertices().end()), scale));
    SCOPED_TRACE(cloud.name);
    // The plate is a thousand times as wide as thick: rounding of its scaled corners shows in its thickness.
    expect_near(sum_of(ConvexHull{hull, scale}), sum_of(ConvexHull{scaled}), 1e-4);
  }
}

TEST(HullMass, MassDoesNotDependOnThePlaceOfTheHullInItsPointsAndItsBody) {
  const Cloud cloud = cube_cloud(30, 3);
  const Pose pose{{1, 2, 3}, kTurn};
  const MassSum placed = sum_of(ConvexHull{Hull(cloud)}, 2.0, pose);
  const MassSum moved = sum_of(ConvexHull{Hull(turned(cloud, kTurn, pose.position))}, 2.0);
  expect_near(placed, moved, 2e-6);
}

TEST(HullMass, ABodyOfAHullTurnsAboutItsCentroid) {
  World world;
  const Hull hull(turned(cube_cloud(40, 4), {}, {3, 4, 5}));
  const BodyId body = world.create_body({.position = {10, 0, 0}});
  world.add_shape(body, ConvexHull{hull}, {.density = 100.0f});
  const MassProperties properties = world.mass_properties(body);
  EXPECT_NEAR(properties.mass, 100.0f * hull.volume(), 1e-4f * properties.mass);
  EXPECT_NEAR(properties.center.x, hull.centroid().x, 1e-6);
  EXPECT_NEAR(world.center_of_mass(body).x, 10.0f + hull.centroid().x, 2e-6);
  // The shape's frame is the centroid's, as the body's is.
  place_matter(internals(world));
  const PoseRow& local = internals(world).shapes.local_pose[0];
  for (const float x : local.position) EXPECT_NEAR(x, 0.0, 1e-6);
}

}  // namespace
}  // namespace scree::test
