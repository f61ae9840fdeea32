// Boxes on boxes: corners of stacks, features of points at rest, degenerate positions.
#include "collide_fixture.h"

#include <algorithm>
#include <array>
#include <set>

namespace scree::collide_tests {
namespace {

Rows collide_pair(const Shape& a, const PoseRow& pose_a, const Shape& b, const PoseRow& pose_b) {
  Pairs pairs;
  pairs.add(a, pose_a, b, pose_b);
  return pairs.run(scalar_kernels());
}

// Points in the world, halfway between the surfaces.
std::vector<reference::Vector> points_in_world(const Manifold& m, const PoseRow& body_a) {
  const Frame frame = frame_of(m, body_a);
  std::vector<reference::Vector> result;
  for (int k = 0; k < points_of(m); ++k) result.push_back(point_of(m, frame, k));
  return result;
}

double hull_area(const std::vector<reference::Vector>& p) {
  if (p.size() < 3) return 0.0;
  double area = 0.0;  // of the largest of the three ways to order four points
  const auto quad = [&](std::array<std::size_t, 4> o) {
    return 0.5 * (p[o[2]] - p[o[0]]).cross(p[o[3]] - p[o[1]]).norm();
  };
  if (p.size() == 3) return 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm();
  for (const auto& order : {std::array<std::size_t, 4>{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 1, 3, 2}}) {
    area = std::max(area, quad(order));
  }
  return area;
}

TEST(CollideBox, StackedBoxesTouchAtTheFourCornersOfTheirOverlap) {
  const Shape cube = box(0.5f, 0.5f, 0.5f);
  for (const float shift : {0.0f, 0.25f, 0.5f}) {
    for (const float way : {1.0f, -1.0f}) {
      const PoseRow lower = pose_row({3, 1, -2}), upper = pose_row({3 + shift, 1 + way * 0.997f, -2 + shift});
      const Rows rows = collide_pair(cube, lower, cube, upper);
      const Manifold& m = rows.manifold[0];
      ASSERT_EQ(points_of(m), 4);
      EXPECT_FLOAT_EQ(m.normal[1], way);
      std::set<std::pair<int, int>> corners;
      for (const reference::Vector& p : points_in_world(m, lower)) {
        EXPECT_NEAR(std::abs(p.x() - 3 - shift / 2), 0.5 - shift / 2, 1e-3);
        EXPECT_NEAR(std::abs(p.z() + 2 - shift / 2), 0.5 - shift / 2, 1e-3);
        EXPECT_NEAR(p.y(), 1 + way * 0.4985, 1e-5);
        corners.insert({p.x() > 3 + shift / 2, p.z() > -2 + shift / 2});
      }
      EXPECT_EQ(corners.size(), 4u);
      for (int k = 0; k < 4; ++k) EXPECT_NEAR(m.separation[k], -0.003f, 1e-5f);
    }
  }
}

TEST(CollideBox, SmallOnLargeAndLargeOnSmallTouchAtTheSmallOnesCorners) {
  const Shape small = box(0.2f, 0.3f, 0.4f), large = box(5, 0.5f, 5);
  const float turn_y = 0.7f;
  for (const bool upside_down : {false, true}) {
    const float side = upside_down ? -1.0f : 1.0f;
    const PoseRow pose_large = pose_row({0, 0, 0}),
                  pose_small = pose_row({1, side * 0.8f, 2}, turn({0, 1, 0}, turn_y));
    const Rows rows = collide_pair(large, pose_large, small, pose_small);
    ASSERT_EQ(points_of(rows.manifold[0]), 4);
    const std::vector<reference::Vector> points = points_in_world(rows.manifold[0], pose_large);
    EXPECT_NEAR(hull_area(points), 0.4 * 0.8, 1e-4);
    for (const reference::Vector& p : points) {
      EXPECT_NEAR((p - reference::Vector(1, side * 0.5, 2)).norm(), std::hypot(0.2, 0.4), 1e-4);
    }
  }
}

TEST(CollideBox, FourPointsKeepMostOfAnOctagon) {
  const Shape cube = box(0.5f, 0.5f, 0.5f);
  for (float angle = 0.05f; angle < 0.8f; angle += 0.05f) {
    const PoseRow lower = pose_row({0, 0, 0}), upper = pose_row({0, 0.998f, 0}, turn({0, 1, 0}, angle));
    const Rows rows = collide_pair(cube, lower, cube, upper);
    ASSERT_EQ(points_of(rows.manifold[0]), 4) << angle;
    // A regular octagon's inscribed square has 0.707 of its area, which is 0.83 here.
    EXPECT_GT(hull_area(points_in_world(rows.manifold[0], lower)), 0.5) << angle;
  }
}

TEST(CollideBox, TheDeepestPointIsKept) {
  const Shape cube = box(0.5f, 0.5f, 0.5f);
  Random random(21);
  for (int k = 0; k < 500; ++k) {
    const Quat q = turn({random.uniform(-1, 1), 20.0f * random.uniform(-1, 1), random.uniform(-1, 1)}, 0.4f);
    Pairs pairs;
    pairs.add(cube, pose_row({0, 0, 0}), cube, pose_row({random.uniform(-0.3f, 0.3f), 0.99f, 0}, q));
    const Rows rows = pairs.run(scalar_kernels());
    const reference::Gap gap = find_gap(pairs.solid(0), pairs.solid(1));
    EXPECT_NEAR(deepest(rows.manifold[0]), gap.separation, 1e-3 + 0.05 * std::abs(gap.separation));
  }
}

TEST(CollideBox, FeaturesStayWhileABoxAtRestJitters) {
  struct Rest {
    Shape lower, upper;
    Vec3 offset;
    float angle;
  };
  const Shape cube = box(0.5f, 0.5f, 0.5f), plank = box(2, 0.1f, 0.3f), ground = box(50, 0.5f, 50);
  const Rest rests[] = {{cube, cube, {0, 0.995f, 0}, 0},       {cube, cube, {0.5f, 0.995f, 0}, 0},
                        {cube, cube, {0.3f, 0.995f, 0.2f}, 0}, {cube, cube, {0, 0.995f, 0}, 0.6f},
                        {ground, cube, {3, 0.995f, 4}, 0},     {ground, plank, {3, 0.595f, 4}, 1},
                        {plank, cube, {1, 0.595f, 0}, 0},      {plank, plank, {0, 0.195f, 0}, 1.5707963f},
                        {cube, cube, {0.995f, 0.0f, 0}, 0},    {cube, cube, {0, 0, -0.995f}, 0},
                        {cube, cube, {0.2f, 1.0f, 0.1f}, 0.5f}};
  Random random(22);
  for (const Rest& rest : rests) {
    std::set<std::uint32_t> expected;
    for (int k = 0; k < 300; ++k) {
      const auto jitter = [&] { return random.uniform(-1e-5f, 1e-5f); };
      const Quat wobble = normalize(Quat{jitter() / 2, jitter() / 2, jitter() / 2, 1});
      const Vec3 at = Vec3{7, 1, -4} + rest.offset + Vec3{jitter(), jitter(), jitter()};
      const Rows rows = collide_pair(rest.lower, pose_row({7, 1, -4}), rest.upper,
                                     pose_row(at, normalize(wobble * turn({0, 1, 0}, rest.angle))));
      ASSERT_EQ(points_of(rows.manifold[0]), 4);
      const std::set<std::uint32_t> ids(rows.features[0].id, rows.features[0].id + 4);
      ASSERT_EQ(ids.size(), 4u);
      if (k == 0) expected = ids;
      EXPECT_EQ(ids, expected) << "at rest " << (&rest - rests) << " step " << k;
    }
  }
}

TEST(CollideBox, CrossedEdgesTouchInOnePointAlongTheirCommonPerpendicular) {
  const Shape cube = box(0.5f, 0.5f, 0.5f);
  const float diagonal = std::sqrt(0.5f);
  const PoseRow lower = pose_row({0, 0, 0}, turn({0, 0, 1}, 0.7853982f));
  const PoseRow upper = pose_row({0.1f, 2 * diagonal - 0.01f, 0.2f}, turn({1, 0, 0}, 0.7853982f));
  const Rows rows = collide_pair(cube, lower, cube, upper);
  const Manifold& m = rows.manifold[0];
  ASSERT_EQ(points_of(m), 1);
  EXPECT_NEAR(m.normal[1], 1.0f, 1e-5f);
  EXPECT_NEAR(m.separation[0], -0.01f, 1e-5f);

  EXPECT_NEAR(m.arm_a[1], diagonal - 0.005f, 1e-5f);
}

TEST(CollideBox, CoincidentBoxesGetAFiniteContact) {
  for (const Shape& shape : {box(0.5f, 0.5f, 0.5f), box(1, 0.001f, 0.5f), box(0.001f, 1, 0.001f)}) {
    const PoseRow pose = pose_row({1, 2, 3}, turn({1, 2, 3}, 0.5f));
    const Rows rows = collide_pair(shape, pose, shape, pose);
    const Manifold& m = rows.manifold[0];
    ASSERT_GT(points_of(m), 0);
    EXPECT_NEAR(to_vector(m.normal).norm(), 1.0, 1e-5);
    const float smallest = std::min({shape.extent.half[0], shape.extent.half[1], shape.extent.half[2]});
    for (int k = 0; k < points_of(m); ++k) EXPECT_NEAR(m.separation[k], -2 * smallest, 1e-5f);
  }
}

TEST(CollideBox, NeedlesLieOnTheGroundWithFourPoints) {
  const Shape needle = box(0.001f, 0.001f, 1.0f), ground = box(10, 1, 10);
  for (float angle = 0.0f; angle < 3.0f; angle += 0.37f) {
    const PoseRow lower = pose_row({0, 0, 0});
    const Rows rows =
        collide_pair(ground, lower, needle, pose_row({0.1f, 1.0008f, 0.2f}, turn({0, 1, 0}, angle)));
    ASSERT_EQ(points_of(rows.manifold[0]), 4) << angle;
    EXPECT_NEAR(hull_area(points_in_world(rows.manifold[0], lower)), 0.004, 1e-4);
  }
}

TEST(CollideBox, FarFromTheOriginOnlyTheOffsetCounts) {
  const Shape cube = box(0.5f, 0.5f, 0.5f);
  // 0.9375 m apart: a multiple of what a float resolves at 1e6 m.
  const Rows near = collide_pair(cube, pose_row({0, 0, 0}), cube, pose_row({0.25f, 0.9375f, 0.125f}));
  const Rows far = collide_pair(cube, pose_row({1e6f, -1e6f, 1e6f}), cube,
                                pose_row({1e6f + 0.25f, -1e6f + 0.9375f, 1e6f + 0.125f}));
  EXPECT_EQ(std::memcmp(&near.manifold[0], &far.manifold[0], sizeof(Manifold)), 0);
}

}  // namespace
}  // namespace scree::collide_tests
