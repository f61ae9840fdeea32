// Collide kernels against the double-precision reference.
#include "collide_fixture.h"

namespace scree::collide_tests {
namespace {

using reference::Gap;
using reference::Vector;

struct TypePair {
  ShapeType a, b;
};
constexpr ShapeType kSphere = ShapeType::sphere, kCapsule = ShapeType::capsule, kBox = ShapeType::box;
constexpr TypePair kTypePairs[] = {{kSphere, kSphere}, {kSphere, kCapsule}, {kCapsule, kSphere},
                                   {kSphere, kBox},    {kBox, kSphere},     {kCapsule, kCapsule},
                                   {kCapsule, kBox},   {kBox, kCapsule},    {kBox, kBox}};

// Largest extent of the pair's smaller shape.
double size_of(const Pairs& pairs, const simd::CollideItem& item) {
  const reference::Solid a = pairs.solid(item.shape_1), b = pairs.solid(item.shape_2);
  return std::min(a.half.maxCoeff() + a.radius, b.half.maxCoeff() + b.radius);
}

// Depth that a manifold may lose to the preference for faces.
double preference(const Pairs& pairs, const simd::CollideItem& item, double separation) {
  const bool boxes = pairs.type[static_cast<std::size_t>(item.shape_1)] == kBox;
  return boxes ? std::max(1.5e-3, 0.11 * std::abs(separation)) : 6e-4;
}

bool is_face_normal(const reference::Solid& box, const Vector& normal) {
  return (box.rotation.transpose() * normal).cwiseAbs().maxCoeff() > 1.0 - 1e-5;
}

class CollideOracle : public testing::TestWithParam<TypePair> {};

TEST_P(CollideOracle, TouchingPairsAreFoundWithTheirDepthAndNormal) {
  const Pairs pairs = random_pairs(GetParam().a, GetParam().b, 1500, 1, -0.08f, 0.03f);
  const Rows rows = pairs.run(scalar_kernels());
  int compared_normals = 0;
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    const simd::CollideItem& item = pairs.items[row];
    const Gap gap = find_gap(pairs.solid(item.shape_1), pairs.solid(item.shape_2));
    const Manifold& manifold = rows.manifold[row];
    const double error = 1e-4 * size_of(pairs, item);
    ASSERT_EQ(points_of(manifold), rows.points[row]);
    if (gap.separation < -error) {
      ASSERT_GT(points_of(manifold), 0) << "row " << row << " gap " << gap.separation;
    }
    if (gap.separation > kSpeculativeDistance + error) {
      ASSERT_EQ(points_of(manifold), 0) << "row " << row;
    }
    if (points_of(manifold) == 0 || gap.separation > 0.0) continue;
    const double slack = error + preference(pairs, item, gap.separation);
    EXPECT_NEAR(deepest(manifold), gap.separation, slack) << "row " << row;
    if (gap.separation - gap.runner_up > 2.0 * slack) {
      // Boxes may touch by a face although an axis of two edges is best: the depth of the faces' overlap is
      // bounded, as checked above.
      const Vector normal = to_vector(manifold.normal);
      const reference::Solid a = pairs.solid(item.shape_1), b = pairs.solid(item.shape_2);
      const auto is_face = [&](const Vector& of) { return is_face_normal(a, of) || is_face_normal(b, of); };
      const bool boxes = GetParam().a == kBox && GetParam().b == kBox;
      if (boxes && !is_face(gap.normal) && is_face(normal)) {
        EXPECT_GT(normal.dot(gap.normal), 0.95 - 1e-5) << "row " << row;
        continue;
      }
      EXPECT_GT(normal.dot(gap.normal), 1.0 - 1e-5) << "row " << row;
      ++compared_normals;
    }
  }
  EXPECT_GT(compared_normals, 250);
}

// The gap of separated boxes is that of their best axis, so it is no distance.
class CollideRoundOracle : public CollideOracle {};

TEST_P(CollideRoundOracle, SeparatedPairsAreFoundWithTheirDistance) {
  const Pairs pairs = random_pairs(GetParam().a, GetParam().b, 1000, 2, 0.0f, 0.019f);
  const Rows rows = pairs.run(scalar_kernels());
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    const simd::CollideItem& item = pairs.items[row];
    const Gap gap = find_gap(pairs.solid(item.shape_1), pairs.solid(item.shape_2));
    ASSERT_GT(points_of(rows.manifold[row]), 0) << "row " << row;
    EXPECT_NEAR(deepest(rows.manifold[row]), gap.separation, 1e-4 * size_of(pairs, item) + 6e-4);
  }
}

TEST_P(CollideOracle, PointsLieOnBothSurfaces) {
  const Pairs pairs = random_pairs(GetParam().a, GetParam().b, 600, 3, -0.05f, 0.01f);
  const Rows rows = pairs.run(scalar_kernels());
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    const simd::CollideItem& item = pairs.items[row];
    const Manifold& manifold = rows.manifold[row];
    const Frame frame = frame_of(manifold, pairs.pose[static_cast<std::size_t>(item.body_1)]);
    const reference::Solid a = pairs.solid(item.shape_1), b = pairs.solid(item.shape_2);
    for (int k = 0; k < points_of(manifold); ++k) {
      // Somewhere on the line along the normal both surfaces are at hand: A's above, B's below by the
      // separation.
      const Vector point = point_of(manifold, frame, k);
      double best = 1e9;
      for (double height = -0.3; height < 0.3; height += 2e-4) {
        const Vector on_a = point + height * frame.normal;
        const Vector on_b = on_a + double(manifold.separation[k]) * frame.normal;
        best = std::min(
            best, std::max(std::abs(distance_to_surface(a, on_a)), std::abs(distance_to_surface(b, on_b))));
      }
      EXPECT_LT(best, 4e-3) << "row " << row << " point " << k;
    }
  }
}

TEST_P(CollideOracle, SwappedPairsGiveTheMirroredContact) {
  const Pairs pairs = random_pairs(GetParam().a, GetParam().b, 1000, 4, -0.05f, -0.001f);
  Pairs swapped;
  for (std::size_t s = 0; s < pairs.pose.size(); s += 2) {
    const Shape a{pairs.type[s], pairs.extent[s]}, b{pairs.type[s + 1], pairs.extent[s + 1]};
    swapped.add(b, pairs.pose[s + 1], a, pairs.pose[s]);
  }
  const Rows rows = pairs.run(scalar_kernels()), mirrored = swapped.run(scalar_kernels());
  const double sign = GetParam().a == GetParam().b ? -1.0 : 1.0;
  int same_normals = 0;
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    const Manifold &m = rows.manifold[row], &n = mirrored.manifold[row];
    EXPECT_NEAR(deepest(m), deepest(n), 1.5e-3) << "row " << row;
    same_normals += to_vector(m.normal).dot(sign * to_vector(n.normal)) > 0.9999 ? 1 : 0;
  }
  EXPECT_GT(same_normals, 950);  // the rest: two faces equally deep within the tolerance
}

TEST_P(CollideOracle, MovingBothShapesMovesTheContact) {
  const Pairs pairs = random_pairs(GetParam().a, GetParam().b, 1000, 5, -0.05f, -0.001f);
  Random random(6);
  Pairs moved;
  std::vector<Quat> turns;
  for (std::size_t s = 0; s < pairs.pose.size(); s += 2) {
    const Shape a{pairs.type[s], pairs.extent[s]}, b{pairs.type[s + 1], pairs.extent[s + 1]};
    const Quat q = random.rotation();
    turns.push_back(q);
    const auto move = [&](const PoseRow& row) {
      const PoseRow& origin = pairs.pose[s];
      const Vec3 offset{row.position[0] - origin.position[0], row.position[1] - origin.position[1],
                        row.position[2] - origin.position[2]};
      const Quat r{row.rotation[0], row.rotation[1], row.rotation[2], row.rotation[3]};
      return pose_row(rotate(q, offset), normalize(q * r));
    };
    moved.add(a, move(pairs.pose[s]), b, move(pairs.pose[s + 1]));
  }
  const Rows rows = pairs.run(scalar_kernels()), other = moved.run(scalar_kernels());
  int same = 0;
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    const Manifold &m = rows.manifold[row], &n = other.manifold[row];
    const Vec3 normal = rotate(turns[row], {m.normal[0], m.normal[1], m.normal[2]});
    const bool equal_normal = dot(normal, {n.normal[0], n.normal[1], n.normal[2]}) > 0.99999f;
    same += equal_normal && points_of(m) == points_of(n) && std::abs(deepest(m) - deepest(n)) < 1e-4f ? 1 : 0;
  }
  EXPECT_GT(same, 970);
}

std::string name_of(const testing::TestParamInfo<TypePair>& test) {
  constexpr const char* kNames[] = {"Sphere", "Capsule", "Box"};
  return std::string(kNames[static_cast<int>(test.param.a)]) + kNames[static_cast<int>(test.param.b)];
}
INSTANTIATE_TEST_SUITE_P(Types, CollideOracle, testing::ValuesIn(kTypePairs), name_of);
INSTANTIATE_TEST_SUITE_P(Types, CollideRoundOracle,
                         testing::ValuesIn(kTypePairs, kTypePairs + std::size(kTypePairs) - 1), name_of);

}  // namespace
}  // namespace scree::collide_tests
