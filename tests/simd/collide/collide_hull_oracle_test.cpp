// Hull kernels against all separating axes in double precision.
#include "hull_fixture.h"

namespace scree::collide_tests {
namespace {

using reference::Gap;
using reference::Polyhedron;
using reference::Vector;

enum class Kind { hulls, large_hulls, boxes };

HullPairs pairs_of(Kind kind, int count, unsigned seed, float least_gap, float largest_gap) {
  const bool large = kind == Kind::large_hulls;
  return random_hull_pairs(large ? large_zoo() : small_zoo(), large ? count / 20 : count, seed, least_gap,
                           largest_gap, kind == Kind::boxes);
}

class CollideHullOracle : public testing::TestWithParam<Kind> {};

TEST_P(CollideHullOracle, TouchingPairsAreFoundWithTheirDepthAndNormal) {
  const HullPairs pairs = pairs_of(GetParam(), 600, 1, -0.08f, 0.03f);
  const HullRows rows = pairs.run(scalar_kernels());
  int touching = 0, compared_normals = 0;
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    const Gap gap = pairs.gap(row);
    const double error = 1e-4 * pairs.size(row);
    const Manifold& manifold = rows.manifold[row];
    ASSERT_EQ(points_of(manifold), rows.points[row]);
    if (gap.separation < -1e-5 * pairs.size(row)) {
      ASSERT_GT(points_of(manifold), 0) << "row " << row << " gap " << gap.separation;
    }
    if (gap.separation > kSpeculativeDistance + error) {
      ASSERT_EQ(points_of(manifold), 0) << "row " << row;
    }
    if (points_of(manifold) == 0 || gap.separation > 0.0) continue;
    ++touching;
    EXPECT_NEAR(deepest(manifold), gap.separation, error) << "row " << row;
    if (gap.separation - gap.runner_up > 2.0 * error) {
      const double cosine = to_vector(manifold.normal).dot(gap.normal);
      EXPECT_GT(cosine, std::cos(0.1 / 180.0 * 3.14159265358979)) << "row " << row;
      ++compared_normals;
    }
  }
  EXPECT_GT(touching, 3 * static_cast<int>(pairs.items.size()) / 5);
  EXPECT_GT(compared_normals, 2 * touching / 3);
}

TEST_P(CollideHullOracle, DeepOverlapsHaveTheirDepth) {
  const HullPairs pairs = pairs_of(GetParam(), 200, 2, -0.8f, -0.2f);
  const HullRows rows = pairs.run(scalar_kernels());
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    ASSERT_GT(points_of(rows.manifold[row]), 0) << "row " << row;
    EXPECT_NEAR(deepest(rows.manifold[row]), pairs.gap(row).separation, 1e-4 * pairs.size(row))
        << "row " << row;
  }
}

TEST_P(CollideHullOracle, PointsLieOnBothSurfaces) {
  const HullPairs pairs = pairs_of(GetParam(), 300, 3, -0.05f, 0.01f);
  const HullRows rows = pairs.run(scalar_kernels());
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    const Polyhedron a = pairs.solid(row, 0), b = pairs.solid(row, 1);
    const Manifold& manifold = rows.manifold[row];
    const Frame frame = frame_of(manifold, pose_row({}));
    for (int k = 0; k < points_of(manifold); ++k) {
      // A point on the line along the normal lies near both surfaces: near A's, and farther from B's by the
      // separation.
      const Vector point = point_of(manifold, frame, k);
      const double size = 2.0 * pairs.size(row);
      double best = 1e9, off = 0.0;
      // No distance changes faster than the height.
      for (double height = -size; height < size; height += std::max(2e-4, off - 1e-3)) {
        const Vector on_a = point + height * frame.normal;
        const Vector on_b = on_a + double(manifold.separation[k]) * frame.normal;
        off = std::max(std::abs(distance_beyond(a, on_a)), std::abs(distance_beyond(b, on_b)));
        best = std::min(best, off);
      }
      EXPECT_LT(best, 1e-3) << "row " << row << " point " << k;
    }
  }
}

TEST_P(CollideHullOracle, KeptAxesChangeNoTouchingContact) {
  const HullPairs pairs = pairs_of(GetParam(), 400, 4, -0.1f, 0.0f);
  const HullRows cold = pairs.run(scalar_kernels());
  Random random(5);
  for (int round = 0; round < 4; ++round) {
    HullRows old;
    old.resize(pairs.items.size());
    old.axis.resize(pairs.items.size());
    for (std::size_t row = 0; row < pairs.items.size(); ++row) {
      // The axes just found, then other pairs' axes and arbitrary values.
      if (round == 0) old.axis[row] = cold.axis[row];
      if (round == 1) old.axis[row] = cold.axis[(row + 7) % pairs.items.size()];
      if (round > 1) {
        const Vec3 axis = random.vector();
        const float word = random.uniform(0.0f, 4294967040.0f);
        old.axis[row] = {{axis.x, axis.y, axis.z}, static_cast<std::uint32_t>(word)};
      }
    }
    const HullRows rows = pairs.run(scalar_kernels(), &old);
    for (std::size_t row = 0; row < pairs.items.size(); ++row) {
      ASSERT_EQ(std::memcmp(&rows.manifold[row], &cold.manifold[row], sizeof(Manifold)), 0)
          << "row " << row << " round " << round;
    }
  }
}

std::string kind_name(const testing::TestParamInfo<Kind>& test) {
  constexpr const char* kNames[] = {"Hulls", "LargeHulls", "Boxes"};
  return kNames[static_cast<int>(test.param)];
}
INSTANTIATE_TEST_SUITE_P(Kinds, CollideHullOracle,
                         testing::Values(Kind::hulls, Kind::large_hulls, Kind::boxes), kind_name);

TEST(CollideHull, SwappedPairsGiveTheMirroredContact) {
  const HullPairs pairs = pairs_of(Kind::hulls, 600, 6, -0.05f, -0.001f);
  HullPairs swapped;
  for (std::size_t s = 0; s < pairs.pose.size(); s += 2) {
    swapped.add(pairs.bodies[s + 1], pairs.pose[s + 1], pairs.bodies[s], pairs.pose[s]);
  }
  const HullRows rows = pairs.run(scalar_kernels()), mirrored = swapped.run(scalar_kernels());
  int same_normals = 0;
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    const Manifold &m = rows.manifold[row], &n = mirrored.manifold[row];
    EXPECT_NEAR(deepest(m), deepest(n), 1e-4 * pairs.size(row)) << "row " << row;
    same_normals += to_vector(m.normal).dot(-to_vector(n.normal)) > 0.9999 ? 1 : 0;
  }
  EXPECT_GT(same_normals, 590);  // the rest: two axes equally good within the tolerance
}

}  // namespace
}  // namespace scree::collide_tests
