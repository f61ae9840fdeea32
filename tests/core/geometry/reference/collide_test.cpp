// The reference geometry of spheres, capsules and boxes, by which the tests of kernels judge, against cases
// that are known and laws of gaps.
#include <tests/core/geometry/reference/solids.h>

#include <gtest/gtest.h>

namespace scree::reference_tests {
namespace {

constexpr double kExact = 1e-9;        // m
constexpr double kDirection = 1e-6;    // of a normal: closest points on a segment are searched for
const double kRoot2 = std::sqrt(2.0);  // half the diagonal of a square of side 2
constexpr double kQuarter = std::numbers::pi / 4.0;

void expect_gap(const Solid& a, const Solid& b, double separation, const Vector& normal) {
  const Gap gap = reference::find_gap(a, b);
  EXPECT_NEAR(gap.separation, separation, kExact);
  EXPECT_LE((gap.normal - normal.normalized()).norm(), kDirection) << gap.normal.transpose();
}

TEST(ReferenceGap, OfSpheresIsTheDistanceOfTheirCentersLessTheirRadii) {
  expect_gap(sphere(1.0, {0, 0, 0}), sphere(2.0, {0, 5, 0}), 2.0, {0, 1, 0});
  expect_gap(sphere(1.0, {0, 0, 0}), sphere(2.0, {0, -3, 0}), 0.0, {0, -1, 0});
  expect_gap(sphere(1.0, {1, 1, 1}), sphere(2.0, {3, 2, -1}), 0.0, {2, 1, -2});
  expect_gap(sphere(1.0, {0, 0, 0}), sphere(2.0, {0.25, 0, 0}), -2.75, {1, 0, 0});
}

TEST(ReferenceGap, OfACapsuleIsMeasuredFromTheClosestPointOfItsSegment) {
  const Solid upright = capsule(2.0, 0.5, {0, 0, 0});
  expect_gap(upright, sphere(1.0, {3, 1.5, 0}), 1.5, {1, 0, 0});     // beside
  expect_gap(upright, sphere(1.0, {0, 4, 0}), 0.5, {0, 1, 0});       // above
  expect_gap(upright, sphere(1.0, {3, 6, 0}), 3.5, {3, 4, 0});       // beyond the end
  expect_gap(upright, sphere(1.0, {0.1, 0.5, 0}), -1.4, {1, 0, 0});  // overlap
}

TEST(ReferenceGap, OfCapsulesIsThatOfTheirSegments) {
  const Solid upright = capsule(2.0, 0.5, {0, 0, 0});
  const Eigen::Matrix3d flat = turn_about({0, 0, 1}, 2.0 * kQuarter);         // along x
  expect_gap(upright, capsule(2.0, 0.25, {0, 0, 3}, flat), 2.25, {0, 0, 1});  // crossed
  expect_gap(upright, capsule(2.0, 0.25, {3, 1, 0}), 2.25, {1, 0, 0});        // parallel
  expect_gap(upright, capsule(2.0, 0.25, {0, 5, 0}), 0.25, {0, 1, 0});        // in a row
  expect_gap(upright, capsule(2.0, 0.25, {4, 1, 0}, flat), 1.25, {1, 0, 0});  // a T
  expect_gap(upright, capsule(2.0, 0.25, {3, 6, 0}, turn_about({1, 0, 0}, 2.0 * kQuarter)), 4.25, {3, 4, 0});
  expect_gap(upright, capsule(2.0, 0.25, {0, 0, 0.1}, flat), -0.65, {0, 0, 1});  // crossed, overlap
}

TEST(ReferenceGap, OfARoundSolidAndABoxIsMeasuredFromTheClosestFaceEdgeOrCorner) {
  const Solid b = box({1, 2, 3}, {0, 0, 0});
  expect_gap(sphere(0.5, {0.3, 3, -1}), b, 0.5, {0, -1, 0});        // face
  expect_gap(sphere(0.5, {4, 6, 1}), b, 4.5, {-3, -4, 0});          // edge
  expect_gap(sphere(0.5, {2, 4, 5}), b, 2.5, {-1, -2, -2});         // corner
  expect_gap(sphere(0.5, {1.25, 0, 0}), b, -0.25, {-1, 0, 0});      // overlap, center outside
  expect_gap(sphere(0.5, {0.75, 0.5, 0.5}), b, -0.75, {-1, 0, 0});  // center inside: out at the closest face
  expect_gap(sphere(0.5, {0, 0.5, -2.75}), b, -0.75, {0, 0, 1});
  const Solid turned = box({1, 2, 3}, {0, 0, 0}, turn_about({0, 0, 1}, kQuarter));
  const Vector along = Vector(1, 1, 0).normalized();  // the x axis of the box
  expect_gap(sphere(0.5, 3.0 * along), turned, 1.5, -along);
}

TEST(ReferenceGap, OfACapsuleAndABoxIsMeasuredFromTheClosestPointsOfItsSegment) {
  const Solid b = box({1, 1, 2}, {0, 0, 0});
  const Eigen::Matrix3d flat = turn_about({0, 0, 1}, 2.0 * kQuarter);
  expect_gap(capsule(0.5, 0.25, {0.2, 2, 0.3}, flat), b, 0.75, {0, -1, 0});  // lies above a face
  expect_gap(capsule(3.0, 0.25, {0.2, 2, 0.3}, flat), b, 0.75, {0, -1, 0});  // reaches beyond it
  expect_gap(capsule(0.5, 0.25, {0, 2.5, 0}), b, 0.75, {0, -1, 0});          // stands on it
  // Across the edge that runs along z, at right angles to its diagonal.
  const Eigen::Matrix3d slanted = turn_about({0, 0, 1}, kQuarter);
  expect_gap(capsule(3.0, 0.25, {2, 2, 0}, slanted), b, kRoot2 - 0.25, {-1, -1, 0});
  // Passes through: out sideways is closest, as the box is shorter along x than what is left along y.
  expect_gap(capsule(3.0, 0.25, {0.75, 0, 0}), b, -0.5, {-1, 0, 0});
  expect_gap(b, capsule(3.0, 0.25, {0.75, 0, 0}), -0.5, {1, 0, 0});
}

TEST(ReferenceGap, OfBoxesIsThatOfTheBestFaceOrPairOfEdges) {
  const Solid a = box({1, 1, 1}, {0, 0, 0});
  expect_gap(a, box({1, 2, 1}, {2.5, 0.3, 0.2}), 0.5, {1, 0, 0});     // faces apart
  expect_gap(a, box({1, 2, 1}, {1.75, 0.3, 0.2}), -0.25, {1, 0, 0});  // faces overlap
  expect_gap(a, box({1, 2, 1}, {0.3, -2.75, 0.2}), -0.25, {0, -1, 0});
  // The edges along z and along y face each other along x.
  const Solid edge_z = box({1, 1, 1}, {0, 0, 0}, turn_about({0, 0, 1}, kQuarter));
  for (const double separation : {-0.125, 0.125}) {
    const Vector place(2.0 * kRoot2 + separation, 0.25, -0.25);
    expect_gap(edge_z, box({1, 1, 1}, place, turn_about({0, 1, 0}, kQuarter)), separation, {1, 0, 0});
  }
  // A corner over a face.
  const double height = std::sqrt(3.0);  // of the center over the corner
  const Eigen::Matrix3d on_corner =
      Eigen::Quaterniond::FromTwoVectors(Vector(-1, -1, -1), Vector(0, -1, 0)).toRotationMatrix();
  const Solid floor = box({5, 1, 5}, {0, -1, 0});
  for (const double separation : {-0.125, 0.125}) {
    expect_gap(floor, box({1, 1, 1}, {0.5, height + separation, 0.5}, on_corner), separation, {0, 1, 0});
  }
}

TEST(ReferenceGap, OfBoxesThatAreApartIsAtMostTheirDistance) {
  const Gap gap = reference::find_gap(box({1, 1, 1}, {0, 0, 0}), box({1, 1, 1}, {3, 3.5, 0}));
  EXPECT_NEAR(gap.separation, 1.5, kExact);  // the distance is sqrt(1 + 1.5^2)
  EXPECT_NEAR(gap.runner_up, 1.0, kExact);
}

TEST(ReferenceGap, ShowsByTheRunnerUpThatANormalIsNotUnique) {
  const Solid a = box({1, 1, 1}, {0, 0, 0});
  const Gap tie = reference::find_gap(a, box({1, 1, 1}, {1.75, 1.75, 0.25}));
  EXPECT_NEAR(tie.separation, -0.25, kExact);
  EXPECT_NEAR(tie.runner_up, tie.separation, kExact);
  const Gap unique = reference::find_gap(a, box({1, 1, 1}, {1.75, 1.0, 0.25}));
  EXPECT_NEAR(unique.runner_up, -1.0, kExact);
}

TEST(ReferenceGap, DistancesOfPointsAreThoseOfTheSurface) {
  const Eigen::Matrix3d rotation = turn_about({1, 2, 3}, 0.7);
  const Vector place(0.3, -0.4, 0.5);
  const auto distance = [&](const Solid& solid, const Vector& local) {
    return reference::distance_to_surface(solid, place + rotation * local);
  };
  const Solid b = box({1, 2, 3}, place, rotation);
  EXPECT_NEAR(distance(b, {2, 0, 0}), 1.0, kExact);
  EXPECT_NEAR(distance(b, {4, 6, 0}), 5.0, kExact);
  EXPECT_NEAR(distance(b, {2, 4, 5}), 3.0, kExact);
  EXPECT_NEAR(distance(b, {0.5, 0, 0}), -0.5, kExact);
  EXPECT_NEAR(distance(b, {0, 0, -2.9}), -0.1, kExact);
  const Solid c = capsule(2.0, 0.5, place, rotation);
  EXPECT_NEAR(distance(c, {1, 1, 0}), 0.5, kExact);
  EXPECT_NEAR(distance(c, {3, 6, 0}), 4.5, kExact);
  EXPECT_NEAR(distance(c, {0, 0.5, 0.25}), -0.25, kExact);
  EXPECT_NEAR(distance(sphere(0.5, place), {0, 0, 2}), 1.5, kExact);
}

TEST(ReferenceGap, SolidsStandWhereTheirRowsSay) {
  const ExtentRow extent{{1, 2, 3}, 0.5f};
  // A quarter turn about z, not quite of unit length.
  const PoseRow pose{{4, 5, 6}, 0, {0, 0, 0.70710678f * 1.001f, 0.70710678f * 1.001f}};
  const Solid b = reference::make_solid(ShapeType::box, extent, pose);
  for (const Vector& corner : reference::corners(b)) {
    const Vector way = (corner - Vector(4, 5, 6)).cwiseAbs();
    EXPECT_LE((way - Vector(2, 1, 3)).norm(), 1e-6) << corner.transpose();
  }
  EXPECT_EQ(b.radius, 0.0);
  const Solid c = reference::make_solid(ShapeType::capsule, extent, pose);
  EXPECT_LE((reference::corners(c)[1] - Vector(2, 5, 6)).norm(), 1e-6);
  EXPECT_EQ(c.radius, 0.5);
  const Solid s = reference::make_solid(ShapeType::sphere, extent, pose);
  EXPECT_EQ(s.half, Vector::Zero());
  EXPECT_EQ(s.radius, 0.5);
}

// --- laws of random pairs ---

template <class Visit>
void for_random_pairs(unsigned seed, Visit&& visit) {
  Random random(seed);
  for (const ShapeType type_a : kTypes) {
    for (const ShapeType type_b : kTypes) {
      int apart = 0;
      constexpr int kPairs = 300;
      for (int i = 0; i < kPairs; ++i) {
        const Solid a = random.solid(type_a), b = random.solid(type_b);
        const Gap gap = reference::find_gap(a, b);
        apart += gap.separation > 0.0 ? 1 : 0;
        ASSERT_NEAR(gap.normal.norm(), 1.0, kExact);
        visit(a, b, gap, random);
      }
      EXPECT_GT(apart, 20);
      EXPECT_LT(apart, kPairs - 20);
    }
  }
}

// A gap that is best along any direction is the distance of solids that are apart, and of others the shortest
// way out of each other with the sign reversed.
TEST(ReferenceGap, IsThatAlongItsNormalAndNoDirectionHasALargerOne) {
  const std::vector<Vector> all = directions(1500);
  for_random_pairs(1, [&](const Solid& a, const Solid& b, const Gap& gap, Random& random) {
    ASSERT_NEAR(gap_of(a, b, gap.normal), gap.separation, 2.0 * kDirection);  // at the end of 2 m
    ASSERT_LE(gap.runner_up, gap.separation);
    const bool are_boxes = a.type == ShapeType::box && b.type == ShapeType::box;
    if (are_boxes && gap.separation > 0.0) return;  // see Gap
    for (const Vector& direction : all) ASSERT_LE(gap_of(a, b, direction), gap.separation + 1e-8);
    for (int i = 0; i < 50; ++i) {  // close by
      const Vector direction = (gap.normal + random.vector(0.05)).normalized();
      ASSERT_LE(gap_of(a, b, direction), gap.separation + 1e-8);
    }
  });
}

bool is_unique(const Gap& gap) { return gap.separation - gap.runner_up > 1e-6; }

TEST(ReferenceGap, IsTheSameForTheSolidsInEitherOrderWithTheNormalReversed) {
  for_random_pairs(2, [](const Solid& a, const Solid& b, const Gap& gap, Random&) {
    const Gap other = reference::find_gap(b, a);
    ASSERT_NEAR(other.separation, gap.separation, kExact);
    if (is_unique(gap)) {
      ASSERT_LE((other.normal + gap.normal).norm(), kDirection);
    }
  });
}

TEST(ReferenceGap, MovesWithTheSolids) {
  for_random_pairs(3, [](const Solid& a, const Solid& b, const Gap& gap, Random& random) {
    const Eigen::Matrix3d turn = random.turn();
    const Vector way = random.vector(10.0);
    const auto moved = [&](Solid solid) {
      solid.position = turn * solid.position + way;
      solid.rotation = turn * solid.rotation;
      return solid;
    };
    const Gap other = reference::find_gap(moved(a), moved(b));
    ASSERT_NEAR(other.separation, gap.separation, kExact);
    if (is_unique(gap)) {
      ASSERT_LE((other.normal - turn * gap.normal).norm(), kDirection);
    }
  });
}

}  // namespace
}  // namespace scree::reference_tests
