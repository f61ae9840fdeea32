// The reference geometry of hulls: of boxes it says what that of boxes says.
#include <core/geometry/hull/hull_build.h>
#include <core/geometry/reference/collide_hull.h>
#include <core/geometry/reference/collide_hull_round.h>
#include <tests/core/geometry/reference/solids.h>

#include <gtest/gtest.h>

namespace scree::reference_tests {
namespace {

constexpr double kClose = 1e-5;  // m; poses and corners of hulls are floats
constexpr int kHullPairs = 300;

// A box as a solid and as hulls.
struct HullBox {
  Solid solid;
  reference::Polyhedron polyhedron;
  reference::FacedHull faced;

  explicit HullBox(Random& random) {
    float half[3];
    for (float& it : half) it = static_cast<float>(random.between(0.3, 1.2));
    const Vector position = random.vector(1.2);
    const Eigen::Quaterniond q(random.turn());
    PoseRow pose{};
    for (int k = 0; k < 3; ++k) pose.position[k] = static_cast<float>(position[k]);
    for (int k = 0; k < 4; ++k) pose.rotation[k] = static_cast<float>(q.coeffs()[k]);
    solid = reference::make_solid(ShapeType::box, {{half[0], half[1], half[2]}, 0.0f}, pose);
    std::vector<Vec3> points;
    for (const float x : {-1.0f, 1.0f}) {
      for (const float y : {-1.0f, 1.0f}) {
        for (const float z : {-1.0f, 1.0f}) points.push_back({x * half[0], y * half[1], z * half[2]});
      }
    }
    const HullTopology topology = build_hull("test", points, {})->topology;
    polyhedron = reference::make_polyhedron(topology, pose, Vector::Zero());
    std::vector<Vector> corners;
    for (const Vec3& v : topology.vertices) corners.emplace_back(v.x, v.y, v.z);
    std::vector<std::vector<int>> faces;
    for (std::size_t f = 0; f + 1 < topology.begin.size(); ++f) {
      faces.emplace_back(topology.loops.begin() + topology.begin[f],
                         topology.loops.begin() + topology.begin[f + 1]);
    }
    faced = reference::make_faced_hull(corners, faces, pose);
  }
};

void expect_same(const Gap& gap, const Gap& expected) {
  EXPECT_NEAR(gap.separation, expected.separation, kClose);
  if (expected.separation - expected.runner_up < 1e-3) return;  // the normal is not unique
  EXPECT_LE((gap.normal - expected.normal).norm(), 1e-3);
}

TEST(ReferenceHulls, OfBoxesHaveTheGapOfTheBoxes) {
  Random random(1);
  int apart = 0;
  for (int i = 0; i < kHullPairs; ++i) {
    const HullBox a(random), b(random);
    const Gap expected = reference::find_gap(a.solid, b.solid);
    // The boxes' reference looks at all pairs of edges; of boxes that are apart, pairs that do not touch may
    // be better than those that do.
    expect_same(reference::polyhedra_gap(a.polyhedron, b.polyhedron, false), expected);
    apart += expected.separation > 0.0 ? 1 : 0;
    if (expected.separation > 0.0) continue;
    expect_same(reference::polyhedra_gap(a.polyhedron, b.polyhedron), expected);
  }
  EXPECT_GT(apart, kHullPairs / 10);
  EXPECT_LT(apart, kHullPairs - kHullPairs / 10);
}

TEST(ReferenceHulls, SiftingKeepsEveryPairOfEdgesThatIsBestWhereHullsOverlap) {
  Random random(2);
  int by_edges = 0;
  for (int i = 0; i < kHullPairs; ++i) {
    const HullBox a(random), b(random);
    const Gap all = reference::polyhedra_gap(a.polyhedron, b.polyhedron, false);
    if (all.separation > 0.0) continue;
    const Gap sifted = reference::polyhedra_gap(a.polyhedron, b.polyhedron, true);
    EXPECT_NEAR(sifted.separation, all.separation, 1e-9);
    double of_faces = -1e300;
    for (const Vector& n : a.polyhedron.normals) {
      of_faces = std::max(of_faces, reference::gap_of_axis(a.polyhedron, b.polyhedron, n));
    }
    for (const Vector& n : b.polyhedron.normals) {
      of_faces = std::max(of_faces, reference::gap_of_axis(a.polyhedron, b.polyhedron, -n));
    }
    by_edges += all.separation > of_faces + 1e-3 ? 1 : 0;
  }
  EXPECT_GT(by_edges, 5);
}

TEST(ReferenceHulls, RoundSolidsHaveTheGapThatTheyHaveToTheBox) {
  Random random(3);
  for (const ShapeType type : {ShapeType::sphere, ShapeType::capsule}) {
    int apart = 0, within = 0;
    for (int i = 0; i < kHullPairs; ++i) {
      const HullBox hull(random);
      const Solid round = random.solid(type);
      double core = -1.0;
      const Gap gap = reference::gap_to_hull(round, hull.faced, core);
      const Gap expected = reference::find_gap(round, hull.solid);
      expect_same(gap, expected);
      EXPECT_NEAR(core, std::max(expected.separation + round.radius, 0.0), kClose);
      apart += gap.separation > 0.0 ? 1 : 0;
      within += core == 0.0 ? 1 : 0;
    }
    EXPECT_GT(apart, kHullPairs / 20);
    EXPECT_GT(within, kHullPairs / 20);
  }
}

TEST(ReferenceHulls, DistancesOfPointsAreThoseOfTheBox) {
  Random random(4);
  for (int i = 0; i < kHullPairs; ++i) {
    const HullBox hull(random);
    const Vector point = random.vector(2.5);
    const double distance = reference::distance_to_surface(hull.solid, point);
    EXPECT_NEAR(reference::distance_to_surface(hull.faced, point), distance, kClose);
    EXPECT_LE(reference::distance_beyond(hull.polyhedron, point), distance + kClose);
    if (distance < 0.0) {
      EXPECT_NEAR(reference::distance_beyond(hull.polyhedron, point), distance, kClose);
    }
    const Vector closest = reference::closest_on_hull(hull.faced, point);
    EXPECT_NEAR((closest - point).norm(), std::max(distance, 0.0), kClose);
    EXPECT_LE(reference::distance_to_surface(hull.solid, closest), kClose);
  }
}

}  // namespace
}  // namespace scree::reference_tests
