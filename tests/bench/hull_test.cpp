// Laws of the evaluator for hulls: gaps against boxes and against all axes tried one by one, masses, frames.
#include "bench/evaluate.h"
#include "tools/scenes/hulls.h"
#include "tools/scenes/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace scree::bench {
namespace {

using Eigen::Vector3d;
using scenes::Scene;

constexpr double kExactHull = 2e-6;  // m: scenes hold floats

Geometry hull_of(const std::vector<Vec3>& points, Vec3 scale = {1.0f, 1.0f, 1.0f}) {
  return ConvexHull{Hull(points), scale};
}

double hull_gap(const Geometry& a, const Pose& pose_a, const Geometry& b, const Pose& pose_b) {
  const double there = signed_gap(place(a, {}, pose_a), place(b, {}, pose_b));
  const double back = signed_gap(place(b, {}, pose_b), place(a, {}, pose_a));
  EXPECT_NEAR(there, back, 1e-9);
  return there;
}

Pose random_pose(scenes::Random& random, float reach) {
  const Vec3 position{random.between(-reach, reach), random.between(-reach, reach),
                      random.between(-reach, reach)};
  return {position, random.rotation()};
}

// The corners of a hull in the world.
std::vector<Vector3d> corners(const PlacedShape& shape) {
  std::vector<Vector3d> all;
  for (const Vector3d& vertex : shape.polytope->vertices) all.push_back(shape.center + shape.axes * vertex);
  return all;
}

double gap_along(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b, const Vector3d& axis) {
  double a_low = 1e30, a_high = -1e30, b_low = 1e30, b_high = -1e30;
  for (const Vector3d& point : a) {
    a_low = std::min(a_low, axis.dot(point));
    a_high = std::max(a_high, axis.dot(point));
  }
  for (const Vector3d& point : b) {
    b_low = std::min(b_low, axis.dot(point));
    b_high = std::max(b_high, axis.dot(point));
  }
  return std::max(b_low - a_high, a_low - b_high);
}

// The largest gap over all normals and all cross products of edges, without any pruning.
double gap_by_all_axes(const PlacedShape& a, const PlacedShape& b) {
  const auto points_a = corners(a);
  const auto points_b = corners(b);
  double best = -std::numeric_limits<double>::infinity();
  for (const PlacedShape* shape : {&a, &b}) {
    for (const Vector3d& normal : shape->polytope->normals) {
      best = std::max(best, gap_along(points_a, points_b, shape->axes * normal));
    }
  }
  const auto edge = [](const PlacedShape& shape, const Polytope::Edge& e) -> Vector3d {
    const auto& vertices = shape.polytope->vertices;
    return shape.axes * (vertices[static_cast<std::size_t>(e.vertex[1])] -
                         vertices[static_cast<std::size_t>(e.vertex[0])]);
  };
  for (const Polytope::Edge& edge_a : a.polytope->edges) {
    for (const Polytope::Edge& edge_b : b.polytope->edges) {
      const Vector3d axis = edge(a, edge_a).cross(edge(b, edge_b));
      if (axis.norm() > 1e-6) best = std::max(best, gap_along(points_a, points_b, axis.normalized()));
    }
  }
  return best;
}

TEST(HullGap, OfABoxsCornersIsThatOfTheBox) {
  const Vec3 half{0.5f, 0.3f, 0.7f};
  const Geometry box = Box{half};
  const Geometry hull = hull_of(scenes::box_points(half));
  const Geometry others[] = {Sphere{0.4f}, Capsule{0.5f, 0.2f}, Box{{0.4f, 0.6f, 0.2f}}};
  scenes::Random random(11);
  int overlaps = 0;
  for (int i = 0; i < 600; ++i) {
    const Geometry& other = others[i % 3];
    const Pose pose = random_pose(random, 1.3f);
    const double expected = hull_gap(box, {}, other, pose);
    const double actual = hull_gap(hull, {}, other, pose);
    EXPECT_NEAR(actual, expected, kExactHull) << i;
    overlaps += expected < 0.0 ? 1 : 0;
  }
  EXPECT_GT(overlaps, 100);
}

TEST(HullGap, OfTwoHullsIsTheBestOverAllAxes) {
  const Geometry hulls[] = {
      hull_of(scenes::tetrahedron_points(0.7f)), hull_of(scenes::fibonacci_points(10, 0.8f)),
      hull_of(scenes::random_sphere_points(24, 0.7f, 42), {1.0f, 0.6f, 1.4f}),
      hull_of(scenes::prism_points(6, 0.5f, 0.9f)), hull_of(scenes::box_points({0.9f, 0.05f, 0.4f}))};
  scenes::Random random(5);
  int overlaps = 0;
  for (int i = 0; i < 400; ++i) {
    const PlacedShape a = place(hulls[i % 5], {}, {{3.0f, -2.0f, 1.0f}, random.rotation()});
    Pose pose = random_pose(random, 0.9f);
    pose.position = {pose.position.x + 3.0f, pose.position.y - 2.0f, pose.position.z + 1.0f};
    const PlacedShape b = place(hulls[i / 5 % 5], {}, pose);
    const double expected = gap_by_all_axes(a, b);
    const double actual = signed_gap(a, b);
    if (expected > 0.0) {
      // Any axis proves that the hulls are apart; the pruned search may find a smaller lower bound.
      EXPECT_GT(actual, 0.0) << i;
      EXPECT_LE(actual, expected + 1e-9) << i;
    } else {
      ++overlaps;
      EXPECT_NEAR(actual, expected, 1e-7) << i;
    }
  }
  EXPECT_GT(overlaps, 150);
}

TEST(HullGap, OfASphereIsToTheClosestFaceEdgeOrCorner) {
  const Geometry octahedron = hull_of(scenes::octahedron_points({1.0f, 1.0f, 1.0f}));
  const float third = 1.0f / 3.0f;
  const double beyond_face = std::sqrt(3.0) * 0.2;
  const Vec3 over_face{third + 0.2f, third + 0.2f, third + 0.2f};
  EXPECT_NEAR(hull_gap(octahedron, {}, Sphere{0.1f}, {over_face, {}}), beyond_face - 0.1, kExactHull);
  EXPECT_NEAR(hull_gap(octahedron, {}, Sphere{0.1f}, {{0.8f, 0.8f, 0.0f}, {}}), 0.3 * std::sqrt(2.0) - 0.1,
              kExactHull);
  EXPECT_NEAR(hull_gap(octahedron, {}, Sphere{0.1f}, {{0.0f, 1.5f, 0.0f}, {}}), 0.4, kExactHull);
  EXPECT_NEAR(hull_gap(octahedron, {}, Sphere{0.1f}, {{0.0f, 0.0f, 0.0f}, {}}), -1.0 / std::sqrt(3.0) - 0.1,
              kExactHull);
}

TEST(HullGap, StopsEarlyOnlyIfTheGapIsWiderThanTheLimit) {
  const Geometry hulls[] = {hull_of(scenes::fibonacci_points(20, 0.6f)), Box{{0.5f, 0.5f, 0.5f}},
                            Sphere{0.5f}, Capsule{0.4f, 0.3f}};
  scenes::Random random(3);
  for (int i = 0; i < 400; ++i) {
    const PlacedShape a = place(hulls[0], {}, {});
    const PlacedShape b = place(hulls[i % 4], {}, random_pose(random, 1.2f));
    const double exact = signed_gap(a, b);
    const double quick = signed_gap(a, b, 1e-3);
    if (exact <= 1e-3) {
      EXPECT_EQ(quick, exact) << i;
    } else {
      EXPECT_GT(quick, 1e-3) << i;
      EXPECT_LE(quick, exact + 1e-9) << i;
    }
  }
}

TEST(HullGap, HonorsScaleAndTheShapesPlaceInItsBody) {
  const Geometry hull = hull_of(scenes::box_points({1.0f, 1.0f, 1.0f}), {0.5f, 2.0f, 1.0f});
  const Pose local{{0.0f, 3.0f, 0.0f}, {}};
  EXPECT_NEAR(signed_gap(place(hull, local, {}), place(Sphere{0.5f}, {}, {{0.0f, 5.4f, 0.0f}, {}})), -0.1,
              kExactHull);
  EXPECT_NEAR(signed_gap(place(hull, local, {}), place(Sphere{0.5f}, {}, {{1.2f, 3.0f, 0.0f}, {}})), 0.2,
              kExactHull);
}

void add_hull_body(Scene& scene, const Geometry& geometry, const Pose& pose) {
  scenes::SceneBody body;
  body.def.position = pose.position;
  body.def.rotation = pose.rotation;
  body.first_shape = static_cast<std::uint32_t>(scene.shapes.size());
  body.shape_count = 1;
  scene.shapes.push_back({geometry, {}, {}});
  scene.bodies.push_back(body);
}

TEST(HullMass, OfABoxsCornersIsThatOfTheBox) {
  Scene scene;
  add_hull_body(scene, Box{{0.5f, 1.0f, 1.5f}}, {});
  add_hull_body(scene, hull_of(scenes::box_points({0.5f, 0.5f, 0.5f}), {1.0f, 2.0f, 3.0f}), {});
  add_hull_body(scene, hull_of(scenes::moved(scenes::box_points({0.5f, 1.0f, 1.5f}), {4.0f, -1.0f, 2.0f})),
                {});
  const BodyMass box = body_mass(scene, scene.bodies[0]);
  for (const std::size_t i : {1u, 2u}) {
    const BodyMass hull = body_mass(scene, scene.bodies[i]);
    EXPECT_NEAR(hull.mass, box.mass, 1e-3);
    EXPECT_NEAR((hull.inertia - box.inertia).norm(), 0.0, 1e-2);
  }
  EXPECT_NEAR((body_mass(scene, scene.bodies[2]).center - Vector3d(4, -1, 2)).norm(), 0.0, 1e-6);
}

TEST(HullMass, OfATetrahedronIsAnalytic) {
  // Corners at the origin and one unit along each axis: volume 1/6, center (1/4, 1/4, 1/4).
  Scene scene;
  add_hull_body(scene, hull_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}), {});
  const BodyMass mass = body_mass(scene, scene.bodies[0]);
  EXPECT_NEAR(mass.mass, 1000.0 / 6.0, 1e-6);
  EXPECT_NEAR((mass.center - Vector3d::Constant(0.25)).norm(), 0.0, 1e-7);
  // About the center: x^2 integrates to V (1/10 - 1/16), x y to V (1/20 - 1/16).
  EXPECT_NEAR(mass.inertia(0, 0), mass.mass * 2.0 * (0.1 - 0.0625), 1e-6);
  EXPECT_NEAR(mass.inertia(0, 1), -mass.mass * (0.05 - 0.0625), 1e-6);
}

TEST(PrincipalFrame, HasADiagonalInertiaAndEqualsTheBodyFrameIfThatIsPrincipal) {
  Scene scene;
  add_hull_body(scene, Box{{0.5f, 1.0f, 1.5f}}, {});
  add_hull_body(scene, hull_of({{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}}), {});
  const PrincipalFrame box = principal_frame(body_mass(scene, scene.bodies[0]));
  EXPECT_EQ(box.center, Vector3d::Zero());
  EXPECT_EQ(box.rotation.coeffs(), Eigen::Quaterniond::Identity().coeffs());
  const BodyMass mass = body_mass(scene, scene.bodies[1]);
  const PrincipalFrame frame = principal_frame(mass);
  const Eigen::Matrix3d axes = frame.rotation.toRotationMatrix();
  EXPECT_NEAR((axes * frame.inertia.asDiagonal() * axes.transpose() - mass.inertia).norm(), 0.0, 1e-9);
  EXPECT_NEAR((frame.center - Vector3d(0.25, 0.5, 0.75)).norm(), 0.0, 1e-6);
}

TEST(Evaluator, CountsTouchesOfHullsLikeAllPairsTriedOneByOne) {
  Scene scene;
  const Geometry hulls[] = {hull_of(scenes::fibonacci_points(10, 0.6f)),
                            hull_of(scenes::random_sphere_points(32, 0.5f, 42))};
  scenes::Random random(17);
  for (int i = 0; i < 200; ++i) {
    const Pose pose = random_pose(random, 3.0f);
    if (i % 4 == 3) {
      add_hull_body(scene, Box{{0.4f, 0.3f, 0.2f}}, pose);
    } else {
      add_hull_body(scene, hulls[i % 2], pose);
    }
  }
  std::vector<BodyState> states;
  for (const scenes::SceneBody& body : scene.bodies) {
    states.push_back({{body.def.position, body.def.rotation}, {}, {}});
  }
  std::int64_t pairs = 0;
  double sum = 0.0;
  for (std::size_t i = 0; i < states.size(); ++i) {
    for (std::size_t j = i + 1; j < states.size(); ++j) {
      const double value = signed_gap(place(scene.shapes[i].geometry, {}, states[i].pose),
                                      place(scene.shapes[j].geometry, {}, states[j].pose));
      if (value >= kTouchGap) continue;
      ++pairs;
      sum += std::max(-value, 0.0);
    }
  }
  PenetrationStatistics statistics;
  Evaluator(scene).add_touching_pairs(states, statistics);
  EXPECT_GT(pairs, 50);
  EXPECT_EQ(statistics.pairs(), pairs);
  EXPECT_NEAR(statistics.mean(), sum / static_cast<double>(pairs), 1e-9);
}

TEST(BodyFigures, KineticEnergyOfAHullIsAboutItsCenterOfMass) {
  Scene scene;
  add_hull_body(scene, hull_of(scenes::moved(scenes::box_points({0.5f, 1.0f, 1.5f}), {4.0f, 0.0f, 0.0f})),
                {});
  std::vector<BodyState> states{{{}, {1.0f, 2.0f, 2.0f}, {3.0f, 0.0f, 0.0f}}};
  EXPECT_NEAR(Evaluator(scene).body_figures(states).kinetic_energy, 0.5 * 6000 * 9 + 0.5 * 6500 * 9, 0.1);
}

}  // namespace
}  // namespace scree::bench
