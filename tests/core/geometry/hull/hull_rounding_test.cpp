// Mass properties of rounded hulls: against closed forms, Steiner's formula and sums over a fine grid.
#include <scree/snapshot.h>
#include <tests/core/geometry/hull/hull_masses.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace scree::test {
namespace {

TEST(HullRounding, ARoundedBoxOfPointsWeighsWhatARoundedBoxWeighs) {
  for (const Vec3& half : {Vec3{0.5f, 1.0f, 1.5f}, Vec3{0.1f, 0.2f, 0.3f}, Vec3{10.0f, 0.01f, 1.0f}}) {
    for (const float rounding : {1e-3f, 0.1f, 2.0f, 300.0f}) {
      const ConvexHull hull{.hull = Hull(lattice(2, 2.0f * half)), .rounding = rounding};
      expect_near(sum_of(hull, 7.0), sum_of(Box{half, rounding}, 7.0), 1e-6);
    }
  }
}

TEST(HullRounding, AVerySmallHullIsTheBallOfItsRounding) {
  const ConvexHull hull{.hull = Hull(lattice(2, Vec3{2e-3f, 2e-3f, 2e-3f})), .rounding = 50.0f};
  expect_near(sum_of(hull), sum_of(Sphere{50.0f}), 1e-4);
}

TEST(HullRounding, AVerySmallRoundingChangesNothing) {
  const Hull hull(cube_cloud(40, 3));
  expect_near(sum_of(ConvexHull{.hull = hull, .rounding = 1e-9f}), sum_of(ConvexHull{hull}), 1e-6);
}

// V + S r + r^2 / 2 sum of length times angle between the faces' normals + 4 pi / 3 r^3.
TEST(HullRounding, HasTheVolumeOfSteinersFormula) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const Hull hull(cube_cloud(30, seed));
    const auto vertex = [&](std::size_t i) { return hull.vertices()[i]; };
    double area = 0.0, edges = 0.0;
    std::vector<Vec3> normals;
    for (std::size_t f = 0; f < hull.face_count(); ++f) {
      const auto loop = hull.face(f);
      Vec3 sum{};
      for (std::size_t k = 1; k + 1 < loop.size(); ++k)
        sum = sum + cross(vertex(loop[k]) - vertex(loop[0]), vertex(loop[k + 1]) - vertex(loop[0]));
      area += 0.5 * double{length(sum)};
      normals.push_back(normalize(sum));
    }
    for (std::size_t f = 0; f < hull.face_count(); ++f) {
      for (std::size_t g = 0; g < f; ++g) {
        const auto a = hull.face(f), b = hull.face(g);
        for (std::size_t i = 0; i < a.size(); ++i) {
          for (std::size_t k = 0; k < b.size(); ++k) {
            if (a[i] != b[(k + 1) % b.size()] || a[(i + 1) % a.size()] != b[k]) continue;
            const double cosine = std::min(1.0, double{dot(normals[f], normals[g])});
            edges += double{length(vertex(b[k]) - vertex(a[i]))} * std::acos(cosine);
          }
        }
      }
    }
    for (const double r : {0.05, 1.0, 20.0}) {
      const double volume =
          double{hull.volume()} + area * r + 0.5 * edges * r * r + 4.0 / 3.0 * kPi * r * r * r;
      const MassSum sum = sum_of(ConvexHull{.hull = hull, .rounding = static_cast<float>(r)});
      EXPECT_NEAR(sum.mass, volume, 3e-6 * volume) << r;
    }
  }
}

// The sum over a grid of all points within the rounding of a stretched tetrahedron, found by a search for the
// nearest point that knows nothing of faces: of 4 weights that add up to 1.
double distance_from_tetrahedron(const double (&corner)[4][3], const double (&p)[3]) {
  double weight[4] = {0.25, 0.25, 0.25, 0.25}, at[3], best = 1e300;
  for (int step = 0; step < 400; ++step) {
    for (int k = 0; k < 3; ++k) {
      at[k] = 0.0;
      for (int i = 0; i < 4; ++i) at[k] += weight[i] * corner[i][k];
    }
    double slope[4], square = 0.0;
    for (int k = 0; k < 3; ++k) square += (at[k] - p[k]) * (at[k] - p[k]);
    best = std::min(best, square);
    int lowest = 0, highest = -1;
    for (int i = 0; i < 4; ++i) {
      slope[i] = 0.0;
      for (int k = 0; k < 3; ++k) slope[i] += (at[k] - p[k]) * corner[i][k];
      if (slope[i] < slope[lowest]) lowest = i;
      if (weight[i] > 0.0 && (highest < 0 || slope[i] > slope[highest])) highest = i;
    }
    // Moves weight from the worst corner to the best, as far as that helps.
    double way = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double d = corner[lowest][k] - corner[highest][k];
      way += d * d;
    }
    if (!(slope[highest] - slope[lowest] > 1e-13) || !(way > 0.0)) break;
    const double moved = std::min((slope[highest] - slope[lowest]) / way, weight[highest]);
    weight[lowest] += moved;
    weight[highest] -= moved;
  }
  return std::sqrt(best);
}

TEST(HullRounding, HasTheMomentsOfASumOverAGrid) {
  const Hull hull(Cloud{{-0.3f, -0.2f, -0.4f}, {0.6f, -0.1f, 0}, {0, 0.7f, 0.1f}, {0.1f, 0, 0.8f}});
  const Vec3 scale{1.5f, 0.8f, 1.1f};
  const double rounding = 0.4;
  double corner[4][3];
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 v = hull.vertices()[i];
    corner[i][0] = double{v.x} * double{scale.x};
    corner[i][1] = double{v.y} * double{scale.y};
    corner[i][2] = double{v.z} * double{scale.z};
  }
  constexpr int kCells = 64;
  const double low = -1.2, step = 2.8 / kCells;
  double mass = 0.0, first[3]{}, second[6]{};
  for (int i = 0; i < kCells * kCells * kCells; ++i) {
    const double p[3] = {low + step * (0.5 + i % kCells), low + step * (0.5 + i / kCells % kCells),
                         low + step * (0.5 + i / (kCells * kCells))};
    // The surface is smoothed over a cell.
    const double inside =
        std::clamp(0.5 + (rounding - distance_from_tetrahedron(corner, p)) / step, 0.0, 1.0);
    const double cell = inside * step * step * step;
    mass += cell;
    for (int k = 0; k < 3; ++k) first[k] += cell * p[k];
    for (int k = 0; k < 6; ++k) {
      constexpr int kRow[6] = {0, 0, 0, 1, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 2};
      second[k] += cell * p[kRow[k]] * p[kColumn[k]];
    }
  }
  MassSum expected;
  expected.mass = mass;
  for (int k = 0; k < 3; ++k) expected.center[k] = first[k] / mass;
  const double* c = expected.center;
  const double xx = second[0] - mass * c[0] * c[0], yy = second[3] - mass * c[1] * c[1],
               zz = second[5] - mass * c[2] * c[2];
  expected.inertia = {{yy + zz, -(second[1] - mass * c[0] * c[1]), -(second[2] - mass * c[0] * c[2]), xx + zz,
                       -(second[4] - mass * c[1] * c[2]), xx + yy}};
  expect_near(sum_of(ConvexHull{hull, scale, static_cast<float>(rounding)}), expected, 2e-3);
}

TEST(HullRounding, MovesAndTurnsWithItsShape) {
  const ConvexHull hull{Hull(cube_cloud(25, 5)), {1, 2, 0.5f}, 0.3f};
  const Pose pose{{3, -2, 5}, from_axis_angle({1, 2, -1}, 0.8f)};
  const MassSum at_rest = sum_of(hull, 3.0), moved = sum_of(hull, 3.0, pose);
  EXPECT_NEAR(moved.mass, at_rest.mass, 1e-12 * at_rest.mass);
  double center[3];
  rotate(pose.rotation, at_rest.center, center);
  const double place[3] = {3, -2, 5};
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(moved.center[k], center[k] + place[k], 1e-6);
  const Symmetric turned = rotated(pose.rotation, at_rest.inertia);
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(moved.inertia.m[k], turned.m[k], 1e-9 * turned.m[0]);
}

TEST(HullRounding, RoundingsHaveSlotsOfTheirOwnAndShareTheSolid) {
  World world;
  const Hull hull(cube_cloud(40, 3));
  const BodyId body = world.create_body({});
  const ConvexHull given[] = {{hull}, {hull, {1, 1, 1}, 0.25f}, {hull, {1, 1, 1}, 0.5f}};
  std::vector<ShapeId> shapes;
  for (const ConvexHull& convex : given) {
    shapes.push_back(world.add_shape(body, convex));
    world.add_shape(body, convex);
  }
  const WorldData& data = internals(world);
  ASSERT_EQ(data.hulls.shared.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(data.hulls.shapes[i], 2);
    EXPECT_EQ(data.hulls.shared[i].solid, data.hulls.shared[0].solid);
    EXPECT_EQ(data.hulls.data[i]->rounding, given[i].rounding);
    EXPECT_EQ(data.hulls.data[i]->vertex[0], data.hulls.data[0]->vertex[0]);
    EXPECT_EQ(std::get<ConvexHull>(world.geometry(shapes[i])), given[i]);
    const ExtentRow& extent = data.shapes.extent[shapes[i].index];
    const ExtentRow& sharp = data.shapes.extent[shapes[0].index];
    EXPECT_EQ(data.shapes.type[shapes[i].index], i == 0 ? ShapeType::hull : ShapeType::rounded_hull);
    for (int k = 0; k < 3; ++k) EXPECT_FLOAT_EQ(extent.half[k], sharp.half[k] + given[i].rounding);
    EXPECT_FLOAT_EQ(extent.radius, sharp.radius + given[i].rounding);
  }
  world.set_geometry(shapes[1], given[2]);
  EXPECT_EQ(data.hulls.shapes[2], 3);
  EXPECT_EQ(data.hulls.shapes[1], 1);
  Snapshot before;
  save(world, before);
  world.destroy_body(body);
  EXPECT_EQ(data.hulls.shared[1].data, nullptr);
  restore(world, before);
  EXPECT_EQ(data.hulls.data[1]->rounding, 0.25f);
}

}  // namespace
}  // namespace scree::test
