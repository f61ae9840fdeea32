// Bit tests of collide kernels: the same bits on every instruction set and with any neighbors, and no effect
// of non-finite shapes on other pairs.
#pragma once

#include <tests/simd/collide/collide_fixture.h>

#include <cstring>
#include <limits>

namespace scree::collide_tests {

// As the solver would: some impulse at every point.
inline void fill_impulses(Rows& rows) {
  for (std::size_t row = 0; row < rows.manifold.size(); ++row) {
    Manifold& m = rows.manifold[row];
    if (m.info == 0) continue;
    for (int k = 0; k < points_of(m); ++k) m.normal_impulse[k] = 0.1f * float(row % 17) + float(k);
    m.friction_impulse[0] = 0.3f;
    m.friction_impulse[1] = -0.7f;
    m.twist_impulse = 0.2f;
    for (float& r : rows.surface[row].rolling_impulse) r = float(row % 5);
  }
}

// Requires at least this many touching pairs. The kernels do not write rows of features, surfaces and anchors
// for pairs that do not touch or whose kind has none.
inline void expect_same_bits(const Rows& a, const Rows& b, const char* name, int least) {
  int touching = 0;
  const auto same = [&](const auto& rows_a, const auto& rows_b, std::size_t row) {
    return std::memcmp(&rows_a[row], &rows_b[row], sizeof(rows_a[row])) == 0;
  };
  for (std::size_t row = 0; row < a.manifold.size(); ++row) {
    ASSERT_EQ(a.points[row], b.points[row]) << name << " row " << row;
    ASSERT_EQ(a.manifold[row].info, b.manifold[row].info) << name << " row " << row;
    if (a.manifold[row].info == 0) continue;
    ++touching;
    ASSERT_TRUE(same(a.manifold, b.manifold, row)) << name << " row " << row;
    ASSERT_TRUE(same(a.features, b.features, row)) << name << " row " << row;
    ASSERT_TRUE(same(a.surface, b.surface, row)) << name << " row " << row;
    ASSERT_TRUE(same(a.anchor, b.anchor, row)) << name << " row " << row;
  }
  EXPECT_GE(touching, least);
}

// One number of a pose becomes NaN or infinite, each in turn.
inline constexpr std::size_t kSpoiledStride = 5;  // of the rows whose second shape is spoiled
inline void spoil(PoseRow& pose, std::size_t row) {
  constexpr float kBad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity()};
  const std::size_t turn = row / kSpoiledStride, place = turn / 6;
  (turn % 4 < 2 ? pose.position[place % 3] : pose.rotation[place % 4]) = kBad[turn % 3];
}

inline void expect_only_spoiled_to_part(const Rows& expected, const Rows& rows, const char* name) {
  for (std::size_t row = 0; row < rows.manifold.size(); ++row) {
    if (row % kSpoiledStride == 0) {
      ASSERT_EQ(rows.manifold[row].info, 0u) << name;
      ASSERT_EQ(rows.points[row], 0);
    } else if (expected.manifold[row].info != 0) {
      ASSERT_EQ(std::memcmp(&rows.manifold[row], &expected.manifold[row], sizeof(Manifold)), 0) << name;
    }
  }
}

}  // namespace scree::collide_tests
