// The kernel of smooth shapes against brute force: the largest gap along any direction.
#include <tests/simd/collide/smooth_fixture.h>

namespace scree::collide_tests::smooth {
namespace {

struct Kinds {
  int a, b;
};
std::vector<Kinds> all_kinds() {
  std::vector<Kinds> kinds;
  for (int a = 0; a < kSmoothKinds; ++a) {
    for (int b = 0; b < kSmoothKinds; ++b) {
      if (is_smooth_kind(a) || is_smooth_kind(b)) kinds.push_back({a, b});
    }
  }
  return kinds;
}

double size_of(const SmoothPairs& pairs, std::size_t row) {
  const auto size = [](const Solid& s) {
    return double(std::max({s.extent.half[0], s.extent.half[1], s.extent.half[2]}) + s.extent.radius);
  };
  return std::min(size(pairs.solids[2 * row]), size(pairs.solids[2 * row + 1]));
}

constexpr double kAccuracy = 1e-4;        // of the size of the smaller shape
constexpr double kFeatureSlack = 0.5e-3;  // m, by which a deepest point may be replaced by a steadier one

class SmoothOracle : public testing::TestWithParam<Kinds> {};

TEST_P(SmoothOracle, TouchingPairsAreFoundWithTheirDepthAndNormal) {
  const Kinds kinds = GetParam();
  const SmoothPairs pairs =
      random_smooth_pairs(kinds.a, kinds.b, 60, 100u + unsigned(8 * kinds.a + kinds.b), -0.25f, 0.04f);
  const Rows rows = pairs.run(scalar_kernels());
  int touching = 0;
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    const Placed a = pairs.solid(row, 0), b = pairs.solid(row, 1);
    const TrueGap truth = true_gap(a, b);
    const double slack = kAccuracy * size_of(pairs, row) + 2e-6;
    const Manifold& m = rows.manifold[row];
    if (truth.separation > double(kSpeculativeDistance) + slack) {
      EXPECT_EQ(rows.points[row], 0) << "row " << row << " gap " << truth.separation;
      continue;
    }
    if (truth.separation > double(kSpeculativeDistance) - slack) continue;
    ++touching;
    ASSERT_GE(rows.points[row], 1) << "row " << row << " gap " << truth.separation;
    const Vector3d n = normal_of(m);
    EXPECT_NEAR(n.norm(), 1.0, 1e-5);
    const double along = gap_along(a, b, n.normalized());
    EXPECT_GE(along, truth.separation - slack) << "row " << row << " " << n.transpose();
    EXPECT_GE(double(deepest(m)), along - slack) << "row " << row;
    EXPECT_LE(double(deepest(m)), along + slack + kFeatureSlack) << "row " << row;
    if (truth.separation > 0.01) {  // apart, the normal is unique
      EXPECT_GT(n.dot(truth.normal), 0.999) << "row " << row;
    }
  }
  EXPECT_GE(touching, 25);
}

INSTANTIATE_TEST_SUITE_P(Kinds, SmoothOracle, testing::ValuesIn(all_kinds()), [](const auto& param) {
  return std::string(kind_name(param.param.a)) + "_" + kind_name(param.param.b);
});

}  // namespace
}  // namespace scree::collide_tests::smooth
