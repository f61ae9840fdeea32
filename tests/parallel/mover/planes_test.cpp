// Laws of planes that hold a displacement.
#include <gtest/gtest.h>
#include <parallel/mover/mover_limits.h>
#include <parallel/mover/planes.h>
#include <tools/scenes/random.h>

#include <algorithm>
#include <vector>

namespace scree::mover {
namespace {

constexpr double kExact = 1e-9;

Vector random_vector(scenes::Random& random) {
  const double x = double{random.between(-1.0f, 1.0f)};
  const double y = double{random.between(-1.0f, 1.0f)};
  const double z = double{random.between(-1.0f, 1.0f)};
  return {x, y, z};
}

double worst_miss(std::span<const Plane> planes, Vector x) {
  double worst = 0.0;
  for (const Plane& plane : planes) worst = std::max(worst, plane.least - dot(plane.normal, x));
  return worst;
}

// The nearest point by many small projections in turn (Boyle and Dykstra), slow and of another kind.
Vector by_projections(std::span<const Plane> planes, Vector wanted) {
  std::vector<double> factor(planes.size(), 0.0);
  Vector x = wanted;
  for (int round = 0; round < 20000; ++round) {
    for (std::size_t i = 0; i < planes.size(); ++i) {
      const double more = std::max(factor[i] + planes[i].least - dot(planes[i].normal, x), 0.0) - factor[i];
      factor[i] += more;
      x = x + more * planes[i].normal;
    }
  }
  return x;
}

TEST(Planes, TheNearestAllowedIsThatOfManyProjections) {
  scenes::Random random(3);
  int held_by_many = 0;
  for (int i = 0; i < 200; ++i) {
    // All planes leave a ball of room about a point.
    const Vector room = random_vector(random);
    std::vector<Plane> planes;
    const std::uint32_t count = 1 + random.below(9);
    for (std::uint32_t k = 0; k < count; ++k) {
      const Vector normal = queries::normalize(random_vector(random));
      planes.push_back({normal, dot(normal, room) - 0.1});
    }
    const Vector wanted = 3.0 * random_vector(random);
    Vector nearest;
    ASSERT_TRUE(nearest_allowed(planes, wanted, kExact, nearest)) << i;
    EXPECT_LE(worst_miss(planes, nearest), 2.0 * kExact);
    const Vector expected = by_projections(planes, wanted);
    EXPECT_LT(length(nearest - expected), 1e-4) << i << " of " << count;
    if (length(nearest - wanted) > 1e-3 && count > 2) ++held_by_many;
  }
  EXPECT_GT(held_by_many, 50);
}

TEST(Planes, WhatIsAllowedStaysAsItIs) {
  const std::vector<Plane> planes{{{0, 1, 0}, 0.0}, {{1, 0, 0}, -1.0}};
  Vector nearest;
  ASSERT_TRUE(nearest_allowed(planes, {-0.5, 2.0, 7.0}, kExact, nearest));
  EXPECT_EQ(nearest.x, -0.5);
  EXPECT_EQ(nearest.y, 2.0);
  EXPECT_EQ(nearest.z, 7.0);
}

TEST(Planes, ACornerOfThreeStopsEverything) {
  const std::vector<Plane> planes{{{0, 1, 0}}, {{1, 0, 0}}, {{0, 0, 1}}};
  Vector nearest;
  ASSERT_TRUE(nearest_allowed(planes, {-1.0, -2.0, -3.0}, kExact, nearest));
  EXPECT_NEAR(length(nearest), 0.0, kExact);
}

TEST(Planes, WithoutRoomAllGiveWayAlike) {
  const std::vector<Plane> planes{{{0, 1, 0}, 0.01}, {{0, -1, 0}, 0.02}};
  Vector nearest;
  EXPECT_FALSE(nearest_allowed(planes, {}, kExact, nearest));
  const Vector found = nearest_possible(planes, {1.0, 0.0, 0.0}, kExact, 0.02);
  EXPECT_NEAR(found.x, 1.0, kExact);
  EXPECT_NEAR(found.y, -0.005, 1e-5);
}

TEST(Planes, WithoutRoomWhatYieldsIsGivenUpFirst) {
  const std::vector<Plane> planes{{{0, 1, 0}, 0.0}, {{0, -1, 0}, 0.3, true}};
  const Vector found = nearest_possible(planes, {}, kExact, 0.02);
  EXPECT_NEAR(length(found), 0.0, kExact);
}

TEST(Planes, WithoutRoomBetweenFirmOnesTheWorstMissIsLeast) {
  const std::vector<Plane> planes{{{0, 1, 0}, 0.1}, {{0, -1, 0}, 0.3}};
  const Vector found = nearest_possible(planes, {}, kExact, 0.02);
  EXPECT_NEAR(found.y, -0.1, 1e-3);
}

}  // namespace
}  // namespace scree::mover
