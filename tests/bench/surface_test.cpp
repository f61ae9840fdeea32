// Laws of the evaluator for meshes and half-spaces: depths of bodies in planes, ridges, valleys and peaks.
#include "bench/evaluate.h"
#include "tools/scenes/hulls.h"
#include "tools/scenes/random.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace scree::bench {
namespace {

using Eigen::Vector3d;
using scenes::Scene;

constexpr double kExactSurface = 2e-6;  // m: scenes hold floats

const Box kCube{{0.5f, 0.5f, 0.5f}};

Geometry convex_hull_of(const std::vector<Vec3>& points) { return ConvexHull{.hull = Hull(points)}; }

std::vector<Geometry> convex_samples() {
  return {Sphere{0.5f}, Capsule{0.4f, 0.2f}, Box{{0.5f, 0.3f, 0.7f}},
          convex_hull_of(scenes::tetrahedron_points(0.7f)),
          convex_hull_of(scenes::fibonacci_points(16, 0.6f))};
}

Pose at(float x, float y, float z, Quat rotation = {}) { return {{x, y, z}, rotation}; }

double surface_pair_gap(const Geometry& a, const Pose& pose_a, const Geometry& b, const Pose& pose_b,
                        double enough = std::numeric_limits<double>::infinity()) {
  const double there = signed_gap(place(a, {}, pose_a), place(b, {}, pose_b), enough);
  const double back = signed_gap(place(b, {}, pose_b), place(a, {}, pose_a), enough);
  EXPECT_TRUE(there == back || std::abs(there - back) < 1e-12) << there << " and " << back;
  return there;
}

// Corners and faces of a mesh that looks up unless turned.
TriangleMesh one_triangle(float size) {
  const std::vector<Vec3> vertices = {{-size, 0, -size}, {-size, 0, 2 * size}, {2 * size, 0, -size}};
  return TriangleMesh(vertices, std::vector<MeshTriangle>{{0, 1, 2}});
}

// A grid in the plane y = 0 around the origin.
TriangleMesh grid(int cells, float cell) {
  std::vector<Vec3> vertices;
  std::vector<MeshTriangle> triangles;
  const auto side = static_cast<std::uint32_t>(cells) + 1;
  const float corner = -0.5f * cell * static_cast<float>(cells);
  for (std::uint32_t row = 0; row < side; ++row) {
    for (std::uint32_t column = 0; column < side; ++column) {
      vertices.push_back(
          {corner + cell * static_cast<float>(column), 0.0f, corner + cell * static_cast<float>(row)});
    }
  }
  for (std::uint32_t row = 0; row + 1 < side; ++row) {
    for (std::uint32_t column = 0; column + 1 < side; ++column) {
      const std::uint32_t a = row * side + column, b = a + 1, c = a + side, d = c + 1;
      triangles.push_back({a, c, b});
      triangles.push_back({b, c, d});
    }
  }
  return TriangleMesh(vertices, triangles);
}

// Two slopes of 45 degrees that meet at x = y = 0: a ridge, or with `sign` -1 a valley.
TriangleMesh slopes(float sign) {
  const float low = -4.0f * sign;
  const std::vector<Vec3> vertices = {{0, 0, -4},   {0, 0, 4},    {-4, low, -4},
                                      {-4, low, 4}, {4, low, -4}, {4, low, 4}};
  return TriangleMesh(vertices, std::vector<MeshTriangle>{{2, 3, 0}, {0, 3, 1}, {0, 1, 4}, {4, 1, 5}});
}

TEST(HalfSpaceGap, IsThatOfTheLowestPointAlongItsNormal) {
  scenes::Random random(3);
  for (int i = 0; i < 200; ++i) {
    const std::vector<Geometry> shapes = convex_samples();
    const Geometry& shape = shapes[static_cast<std::size_t>(i) % shapes.size()];
    const Pose pose =
        at(random.between(-3, 3), random.between(-0.5f, 1.5f), random.between(-3, 3), random.rotation());
    // The top of a box that is as deep as any of them is wide stands in for it.
    const double expected = surface_pair_gap(Box{{50, 5, 50}}, at(0, -5, 0), shape, pose);
    const double actual = surface_pair_gap(HalfSpace{}, {}, shape, pose);
    if (expected < 0.0) {
      EXPECT_NEAR(actual, expected, kExactSurface) << i;
    } else {
      EXPECT_GE(actual, -kExactSurface) << i;
    }
  }
}

TEST(HalfSpaceGap, TurnsWithItsBody) {
  const auto half = static_cast<float>(std::sqrt(0.5));
  const Quat up_to_x{0.0f, 0.0f, -half, half};
  EXPECT_NEAR(surface_pair_gap(HalfSpace{}, at(2, 0, 0, up_to_x), Sphere{0.5f}, at(2.4f, 30, -70)), -0.1,
              kExactSurface);
  EXPECT_NEAR(surface_pair_gap(HalfSpace{}, at(2, 0, 0, up_to_x), kCube, at(-7, 0, 0)), -9.5, kExactSurface);
}

TEST(SurfaceGap, InTheMiddleOfALargeTriangleIsThatOfItsPlane) {
  const Geometry mesh = one_triangle(20.0f);
  scenes::Random random(4);
  int cuts = 0;
  for (int i = 0; i < 300; ++i) {
    const std::vector<Geometry> shapes = convex_samples();
    const Geometry& shape = shapes[static_cast<std::size_t>(i) % shapes.size()];
    const Pose pose =
        at(random.between(-1, 1), random.between(-0.2f, 0.9f), random.between(-1, 1), random.rotation());
    const double expected = surface_pair_gap(HalfSpace{}, {}, shape, pose);
    EXPECT_NEAR(surface_pair_gap(mesh, {}, shape, pose), expected, kExactSurface) << i;
    cuts += expected < 0.0 ? 1 : 0;
  }
  EXPECT_GT(cuts, 100);
}

TEST(SurfaceGap, OnAFlatGridIsNeverDeeperThanThePlaneAndAsDeepForWhatCoversTriangles) {
  const Geometry mesh = grid(24, 0.2f);
  scenes::Random random(5);
  for (int i = 0; i < 100; ++i) {
    const std::vector<Geometry> shapes = convex_samples();
    const Geometry& shape = shapes[static_cast<std::size_t>(i) % shapes.size()];
    Pose pose = at(random.between(-1, 1), 0, random.between(-1, 1), random.rotation());
    const double depth = double{random.between(0.001f, 0.03f)};
    pose.position.y = static_cast<float>(-surface_pair_gap(HalfSpace{}, {}, shape, pose) - depth);
    const double found = surface_pair_gap(mesh, {}, shape, pose, kTouchGap);
    EXPECT_GE(found, -depth - kExactSurface) << i;
    EXPECT_LT(found, -0.5 * depth) << i;
  }
  EXPECT_NEAR(surface_pair_gap(mesh, {}, kCube, at(0.03f, 0.49f, 0.07f)), -0.01, kExactSurface);
  EXPECT_NEAR(surface_pair_gap(mesh, {}, kCube, at(0.03f, 0.5005f, 0.07f)), 0.0005, kExactSurface);
}

TEST(SurfaceGap, AtARidgeIsUpward) {
  const Geometry ridge = slopes(1.0f);
  EXPECT_NEAR(surface_pair_gap(ridge, {}, kCube, at(0.1f, 0.49f, 0)), -0.01, kExactSurface);
  EXPECT_NEAR(surface_pair_gap(ridge, {}, Sphere{0.5f}, at(0, 0.47f, 0.1f)), -0.03, kExactSurface);
}

TEST(SurfaceGap, InAValleyIsAcrossTheDeeperSide) {
  const Geometry valley = slopes(-1.0f);
  const double root = std::sqrt(2.0);
  // Its center is (x - y) / sqrt(2) from the one side and (-x - y) / sqrt(2) from the other.
  const auto height = static_cast<float>(0.48 * root);
  EXPECT_NEAR(surface_pair_gap(valley, {}, Sphere{0.5f}, at(0, height, 0.1f)), -0.02, kExactSurface);
  const auto aside = static_cast<float>(0.01 * root);
  EXPECT_NEAR(surface_pair_gap(valley, {}, Sphere{0.5f}, at(aside, height, 0.1f)), -0.03, kExactSurface);
}

TEST(SurfaceGap, OfAPeakInAFaceIsThePeaksDepth) {
  const std::vector<Vec3> vertices = {{0, 0, 0}, {-1, -1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, -1, -1}};
  const Geometry peak =
      TriangleMesh(vertices, std::vector<MeshTriangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}});
  EXPECT_NEAR(surface_pair_gap(peak, {}, kCube, at(0.2f, 0.46f, -0.1f)), -0.04, kExactSurface);
}

TEST(SurfaceGap, AtTheRimOfAStepIsNotAcrossItsWall) {
  // A floor for x < 0 that ends in a wall down to y = -3.
  const std::vector<Vec3> vertices = {{-4, 0, -4}, {-4, 0, 4},  {0, 0, -4},
                                      {0, 0, 4},   {0, -3, -4}, {0, -3, 4}};
  const Geometry step =
      TriangleMesh(vertices, std::vector<MeshTriangle>{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {4, 3, 5}});
  EXPECT_NEAR(surface_pair_gap(step, {}, kCube, at(-0.1f, 0.48f, 0.3f)), -0.02, kExactSurface);
  EXPECT_NEAR(surface_pair_gap(step, {}, kCube, at(0.47f, -1, 0.3f)), -0.03, kExactSurface);
}

TEST(SurfaceGap, IsOneSidedAndInfiniteFarAway) {
  const Geometry mesh = grid(20, 0.2f);
  EXPECT_EQ(surface_pair_gap(mesh, {}, kCube, at(0, -0.501f, 0)), std::numeric_limits<double>::infinity());
  EXPECT_EQ(surface_pair_gap(mesh, {}, Sphere{0.5f}, at(0, -0.7f, 0)),
            std::numeric_limits<double>::infinity());
  EXPECT_GT(surface_pair_gap(mesh, {}, Sphere{0.5f}, at(0, 0.6f, 0), 1e-3), 1e-3);
  EXPECT_EQ(surface_pair_gap(mesh, {}, Sphere{0.5f}, at(0, 90, 0)), std::numeric_limits<double>::infinity());
  // Deep, but still cut: the way to the front, which is longer than the one to the back.
  EXPECT_NEAR(surface_pair_gap(one_triangle(20.0f), {}, Sphere{0.5f}, at(0.05f, -0.3f, 0)), -0.8,
              kExactSurface);
}

TEST(SurfaceGap, DoesNotChangeWhenBothMoveTogether) {
  const Geometry ridge = slopes(1.0f);
  scenes::Random random(6);
  for (int i = 0; i < 20; ++i) {
    const Quat turn = random.rotation();
    const Vector3d arm = to_double(turn) * Vector3d(0.1, 0.49, 0);
    const Pose mesh_pose = at(70, -30, 20, turn);
    const Pose pose = at(static_cast<float>(70 + arm.x()), static_cast<float>(-30 + arm.y()),
                         static_cast<float>(20 + arm.z()), turn);
    EXPECT_NEAR(surface_pair_gap(ridge, mesh_pose, kCube, pose), -0.01, 2e-5) << i;
  }
}

TEST(SurfaceGap, OfTwoSurfacesIsInfinite) {
  const Geometry mesh = grid(2, 1.0f);
  EXPECT_EQ(surface_pair_gap(mesh, {}, HalfSpace{}, at(0, 5, 0)), std::numeric_limits<double>::infinity());
  EXPECT_EQ(surface_pair_gap(mesh, {}, mesh, {}), std::numeric_limits<double>::infinity());
}

TEST(Surface, AgreesWithAllTrianglesTriedOneByOne) {
  std::vector<Vec3> vertices;
  std::vector<MeshTriangle> triangles;
  scenes::Random random(7);
  for (std::uint32_t i = 0; i < 300; ++i) {
    const Vec3 middle{random.between(-3, 3), random.between(-3, 3), random.between(-3, 3)};
    for (int corner = 0; corner < 3; ++corner) {
      vertices.push_back({middle.x + random.between(-0.5f, 0.5f), middle.y + random.between(-0.5f, 0.5f),
                          middle.z + random.between(-0.5f, 0.5f)});
    }
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const PlacedShape all = place(TriangleMesh(vertices, triangles), {}, {});
  std::vector<PlacedShape> single;
  for (const MeshTriangle& triangle : triangles) {
    single.push_back(place(TriangleMesh(vertices, std::vector<MeshTriangle>{triangle}), {}, {}));
  }
  int cuts = 0;
  for (int i = 0; i < 60; ++i) {
    const std::vector<Geometry> shapes = convex_samples();
    const PlacedShape shape =
        place(shapes[static_cast<std::size_t>(i) % shapes.size()], {},
              at(random.between(-3, 3), random.between(-3, 3), random.between(-3, 3), random.rotation()));
    double least = std::numeric_limits<double>::infinity();
    for (const PlacedShape& one : single) least = std::min(least, signed_gap(one, shape, kTouchGap));
    EXPECT_EQ(signed_gap(all, shape, kTouchGap), least) << i;
    cuts += least < 0.0 ? 1 : 0;
  }
  EXPECT_GT(cuts, 20);
}

TEST(Surface, KeepsWhatTheMeshKeeps) {
  const std::vector<Vec3> vertices = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {1, 0, 1}, {9, 9, 9}};
  const std::vector<MeshTriangle> given = {{0, 0, 1}, {0, 1, 2}, {0, 1, 2}, {2, 1, 3}};
  const TriangleMesh mesh(vertices, given);
  EXPECT_EQ(triangles_of(mesh).size(), mesh.triangle_count());
  EXPECT_EQ(make_surface(mesh)->triangles.size(), 2u);
}

void add_placed_body(Scene& scene, const Geometry& geometry, const Pose& pose,
                     BodyType type = BodyType::dynamic) {
  scenes::SceneBody body;
  body.def.type = type;
  body.def.position = pose.position;
  body.def.rotation = pose.rotation;
  body.first_shape = static_cast<std::uint32_t>(scene.shapes.size());
  body.shape_count = 1;
  scene.shapes.push_back({geometry, {}, {}});
  scene.bodies.push_back(body);
}

std::vector<BodyState> first_states(const Scene& scene) {
  std::vector<BodyState> states;
  for (const scenes::SceneBody& body : scene.bodies) {
    states.push_back({{body.def.position, body.def.rotation}, {}, {}});
  }
  return states;
}

TEST(Evaluator, CountsEachBodyOnceOnAMeshAndOnAHalfSpace) {
  Scene scene;
  add_placed_body(scene, grid(40, 0.25f), {}, BodyType::fixed);
  add_placed_body(scene, HalfSpace{}, at(0, -3, 0), BodyType::fixed);
  for (int i = 0; i < 4; ++i)
    add_placed_body(scene, kCube, at(2.0f * static_cast<float>(i) - 3.0f, 0.49f, 0));
  for (int i = 0; i < 3; ++i)
    add_placed_body(scene, Sphere{0.5f}, at(300.0f * static_cast<float>(i), -2.52f, 20));
  PenetrationStatistics statistics;
  Evaluator(scene).add_touching_pairs(first_states(scene), statistics);
  EXPECT_EQ(statistics.pairs(), 7);
  EXPECT_NEAR(statistics.max(), 0.02, 2e-6);
  EXPECT_NEAR(statistics.mean(), (4 * 0.01 + 3 * 0.02) / 7, 2e-6);
}

TEST(Evaluator, FollowsAKinematicMesh) {
  Scene scene;
  add_placed_body(scene, grid(10, 0.5f), {}, BodyType::kinematic);
  add_placed_body(scene, Sphere{0.5f}, at(0.1f, 0.48f, 0.2f));
  std::vector<BodyState> states = first_states(scene);
  for (BodyState& state : states) state.pose.position.y += 20.0f;
  PenetrationStatistics together, apart;
  const Evaluator evaluator(scene);
  evaluator.add_touching_pairs(states, together);
  EXPECT_NEAR(together.max(), 0.02, 2e-6);
  states[0].pose.position.y -= 1.0f;
  evaluator.add_touching_pairs(states, apart);
  EXPECT_EQ(apart.pairs(), 0);
}

TEST(Evaluator, BodiesLeaveThroughAHalfSpaceButNotAlongIt) {
  Scene scene;
  add_placed_body(scene, HalfSpace{}, at(0, 2, 0), BodyType::fixed);
  add_placed_body(scene, Sphere{0.5f}, at(0, 3, 0));
  const Evaluator evaluator(scene);
  std::vector<BodyState> states = first_states(scene);
  const auto left = [&](float x, float y) {
    states[1].pose.position = {x, y, -x};
    return evaluator.body_figures(states).bodies_left;
  };
  EXPECT_EQ(left(0, 3), 0);
  EXPECT_EQ(left(5000, 2.5f), 0);
  EXPECT_EQ(left(5000, 1.1f), 0);
  EXPECT_EQ(left(0, 0.9f), 1);
  EXPECT_EQ(left(std::numeric_limits<float>::quiet_NaN(), 3), 1);
}

TEST(Evaluator, BodiesThatFallThroughAMeshHaveLeft) {
  Scene scene;
  add_placed_body(scene, grid(10, 1.0f), {}, BodyType::fixed);
  add_placed_body(scene, Sphere{0.5f}, at(0, 0.5f, 0));
  const Evaluator evaluator(scene);
  std::vector<BodyState> states = first_states(scene);
  EXPECT_EQ(evaluator.body_figures(states).bodies_left, 0);
  states[1].pose.position.y = -2.0f;
  EXPECT_EQ(evaluator.body_figures(states).bodies_left, 1);
  states[1].pose.position = {7.0f, 0.5f, 0.0f};
  EXPECT_EQ(evaluator.body_figures(states).bodies_left, 1);
}

}  // namespace
}  // namespace scree::bench
