// Spheres and capsules against hulls: the reference in double precision, rest, bad input, equal bits.
#include <core/plain/rows.h>

#include <tests/simd/same_bits.h>
#include "round_hull_fixture.h"

#include <limits>
#include <set>

namespace scree::collide_tests {
namespace {

using reference::Gap;
using reference::Vector;

// Pairs of one hull with round shapes, from deep overlap to beyond reach.
RoundHullPairs random_round_pairs(const TestHull& hull, bool is_sphere, int count, unsigned seed) {
  Random random(seed);
  RoundHullPairs pairs;
  const float size = hull.data.outer_radius;
  for (int k = 0; k < count; ++k) {
    const Shape round = round_shape(random, is_sphere, size);
    const Vec3 place = 5.0f * size * random.vector();
    const PoseRow hull_pose = pose_row(place, random.rotation());
    const PoseRow start = pose_row(place + 1.5f * size * random.unit(), random.rotation());
    const double radius = double(round.extent.radius);
    const double gap = k % 4 == 0   ? double(random.uniform(0.0f, 1.5f)) * double(kSpeculativeDistance)
                       : k % 4 == 1 ? -radius * double(random.uniform(0.0f, 0.05f))
                       : k % 4 == 2 ? -radius * double(random.uniform(0.0f, 1.0f))
                                    : -radius * double(random.uniform(0.9f, 1.6f));
    pairs.add(round, place_at_gap(round, start, hull, hull_pose, gap), hull, hull_pose);
  }
  return pairs;
}

// Number of compared pairs: by the axis along which the core leaves the hull, by their distance, and with
// their normal.
struct Judged {
  int deep = 0, shallow = 0, normals = 0;
};

void judge(const RoundHullPairs& pairs, const Rows& rows, const std::string& name, Judged& judged) {
  for (std::size_t row = 0; row < pairs.size(); ++row) {
    const reference::Solid round = pairs.solid(row);
    double core;
    const Gap gap = reference::gap_to_hull(round, pairs.polyhedron(row), core);
    const double outer = double(pairs.hull[row]->data.outer_radius);
    const double size = std::min(round.half.y() + round.radius, outer);
    const double error = 1e-4 * size + 1e-6 * std::abs(gap.separation);
    const Manifold& m = rows.manifold[row];
    ASSERT_EQ(points_of(m), rows.points[row]);
    if (gap.separation < double(kSpeculativeDistance) - error) {
      ASSERT_GT(points_of(m), 0) << name << " row " << row << " gap " << gap.separation;
    }
    if (gap.separation > double(kSpeculativeDistance) + error) {
      ASSERT_EQ(points_of(m), 0) << name << " row " << row << " gap " << gap.separation;
    }
    if (points_of(m) == 0) continue;
    const double off = std::abs(double(deepest(m)) - gap.separation);
    EXPECT_LT(off, error) << name << " row " << row << " gap " << gap.separation;
    ++(core > 0.0 ? judged.shallow : judged.deep);
    // A segment that nearly touches the hull can leave it in many directions.
    const bool tie =
        core > 0.0 ? core < 1e-3 * (outer + round.radius) : gap.separation - gap.runner_up < 2.0 * error;
    if (tie) continue;
    const double sine = to_vector(m.normal).cross(gap.normal).norm();
    EXPECT_GT(to_vector(m.normal).dot(gap.normal), 0.0) << name << " row " << row;
    EXPECT_LT(sine, std::sin(0.1 / 57.29578)) << name << " row " << row << " gap " << gap.separation;
    ++judged.normals;
  }
}

TEST(CollideRoundHull, TouchingPairsAreFoundWithTheirDepthAndNormal) {
  for (const float scale : {1e-3f, 1.0f, 1e3f}) {
    const std::deque<NamedHull> hulls = all_hulls(scale);
    for (const bool is_sphere : {true, false}) {
      Judged judged;
      for (const NamedHull& named : hulls) {
        const std::string name = std::string(is_sphere ? "sphere" : "capsule") + " on " + named.name +
                                 " at scale " + std::to_string(scale);
        // The reference is slow with many faces.
        const int count = (named.hull.faces.size() > 100 ? 39 : 150) / (scale == 1.0f ? 1 : 3);
        const RoundHullPairs pairs = random_round_pairs(named.hull, is_sphere, count, 1);
        judge(pairs, pairs.run(scalar_kernels()), name, judged);
      }
      EXPECT_GT(judged.deep, scale == 1.0f ? 100 : 20);
      EXPECT_GT(judged.shallow, scale == 1.0f ? 700 : 150);
      EXPECT_GT(judged.normals, scale == 1.0f ? 700 : 150);
    }
  }
}

// A rotation that turns y to `axis` and z to about `aside`.
Quat rotation_with(const Vector& axis, const Vector& aside) {
  Eigen::Matrix3d matrix;
  matrix.col(1) = axis.normalized();
  matrix.col(0) = axis.cross(aside).normalized();
  matrix.col(2) = matrix.col(0).cross(matrix.col(1));
  const Eigen::Quaterniond q(matrix);
  return normalize(Quat{float(q.x()), float(q.y()), float(q.z()), float(q.w())});
}
PoseRow pose_at(const Vector& p, Quat q) { return pose_row({float(p.x()), float(p.y()), float(p.z())}, q); }

// The round shape's axis along `axis`, its center `height` above a point of the hull, both in the hull's
// frame; the hull somewhere in the world.
void add_above(RoundHullPairs& pairs, const Shape& round, const TestHull& hull, const Vector& point,
               const Vector& normal, const Vector& axis, double height, Random& random) {
  const PoseRow pose = pose_row(2.0f * random.vector(), random.rotation());
  const float* q = pose.rotation;
  const Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
  const Vector place(pose.position[0], pose.position[1], pose.position[2]);
  pairs.add(round,
            pose_at(place + turn * (point + height * normal), rotation_with(turn * axis, turn * normal)),
            hull, pose);
}

// Corners of a face, in the hull's frame.
std::vector<Vector> corners_of(const TestHull& hull, std::size_t face) {
  std::vector<Vector> corners;
  for (const int corner : hull.faces[face]) corners.push_back(hull.corners[static_cast<std::size_t>(corner)]);
  return corners;
}
Vector middle_of(const std::vector<Vector>& corners) {
  Vector sum = Vector::Zero();
  for (const Vector& corner : corners) sum += corner / double(corners.size());
  return sum;
}
double width_of(const std::vector<Vector>& corners) {  // least distance of the middle from a side, doubled
  const Vector middle = middle_of(corners);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vector side = (corners[(k + 1) % corners.size()] - corners[k]).normalized();
    const Vector way = middle - corners[k];
    least = std::min(least, 2.0 * (way - way.dot(side) * side).norm());
  }
  return least;
}

TEST(CollideRoundHull, ACapsuleAtRestOnAFaceTouchesAtBothEndsOfItsStretchEquallyDeep) {
  Random random(2);
  for (const NamedHull& named : all_hulls(1.0f)) {
    RoundHullPairs pairs;
    std::vector<double> stretch;  // length of the capsule's stretch over the face
    std::vector<double> height;
    for (std::size_t face = 0; face < named.hull.faces.size(); ++face) {
      const std::vector<Vector> corners = corners_of(named.hull, face);
      const Vector middle = middle_of(corners),
                   normal = reference::normal_of(named.hull.corners, named.hull.faces[face]);
      const double width = width_of(corners);
      for (const bool is_long : {false, true}) {
        // Short ones lie within the face, long ones stick out on both sides.
        const Vector axis = (corners[0] - middle).normalized();
        const float half = is_long ? 10.0f : 0.4f * float(width), radius = 0.3f * float(width);
        const double gap = -0.01 * double(radius);
        height.push_back(gap);
        stretch.push_back(is_long ? 0.0 : 2.0 * double(half));
        add_above(pairs, capsule(half, radius), named.hull, middle, normal, axis, double(radius) + gap,
                  random);
      }
    }
    const Rows rows = pairs.run(scalar_kernels());
    for (std::size_t row = 0; row < pairs.size(); ++row) {
      const std::string where = std::string(named.name) + " row " + std::to_string(row);
      const Manifold& m = rows.manifold[row];
      const double size = double(named.hull.data.outer_radius);
      ASSERT_EQ(points_of(m), 2) << where;
      EXPECT_EQ(rows.features[row].id[0], 1u);
      EXPECT_EQ(rows.features[row].id[1], 2u);
      EXPECT_NEAR(m.separation[0], m.separation[1], 4e-6 * size) << where;
      EXPECT_NEAR(m.separation[0], height[row], 4e-6 * size) << where;
      const double apart = std::hypot(m.point_u[0] - m.point_u[1], m.point_v[0] - m.point_v[1]);
      if (stretch[row] > 0.0) {
        EXPECT_NEAR(apart, stretch[row], 1e-5 * size) << where;
      }
      const Frame frame = frame_of(m, pairs.pairs.pose[2 * row]);
      for (int k = 0; k < 2; ++k) {
        // On the hull's surface; at a face's border it may lie a little beside it, and coordinates along a
        // capsule of 10 m are rounded to its length, not to the radius.
        const Vector on_hull = point_of(m, frame, k) + 0.5 * double(m.separation[k]) * frame.normal;
        EXPECT_NEAR(distance_to_surface(pairs.polyhedron(row), on_hull), 0.0,
                    0.01 * double(pairs.solid(row).radius) + 1e-6 * pairs.solid(row).half.norm())
            << where;
      }
    }
  }
}

TEST(CollideRoundHull, LyingCapsulesKeepDepthAndNormal) {
  Random random(3);
  Judged judged;
  for (const NamedHull& named : all_hulls(1.0f)) {
    RoundHullPairs pairs;
    const int count = named.hull.faces.size() > 100 ? 30 : 120;
    for (int k = 0; k < count; ++k) {
      const std::size_t face =
          static_cast<std::size_t>(random.uniform(0.0f, 0.999f) * float(named.hull.faces.size()));
      const std::vector<Vector> corners = corners_of(named.hull, face);
      const Vector normal = reference::normal_of(named.hull.corners, named.hull.faces[face]);
      // Around the face, from exactly level to a tilt of 3 degrees, as often beside its border as above it.
      const double reach = double(random.uniform(0.0f, 1.3f));
      const Vector point =
          middle_of(corners) +
          reach * (corners[static_cast<std::size_t>(k) % corners.size()] - middle_of(corners));
      const Vector side = corners[1] - corners[0];
      Vector axis =
          k % 3 == 0 ? side.normalized()
                     : (side.normalized() + double(random.uniform(-2, 2)) * normal.cross(side).normalized())
                           .normalized();
      if (k % 2 == 0) axis += double(random.uniform(-0.05f, 0.05f)) * normal;
      const float radius = named.hull.data.outer_radius * random.uniform(0.02f, 0.5f);
      const float half = named.hull.data.outer_radius * random.uniform(0.1f, 1.5f);
      const double gap = double(random.uniform(-0.5f, 0.02f) * radius);
      add_above(pairs, capsule(half, radius), named.hull, point, normal, axis, double(radius) + gap, random);
    }
    judge(pairs, pairs.run(scalar_kernels()), std::string("lying on ") + named.name, judged);
  }
  EXPECT_GT(judged.normals, 800);
}

TEST(CollideRoundHull, ACapsuleAlongAnEdgeTouchesAtTwoPoints) {
  Random random(4);
  const TestHull cube(scaled(box_points(), {0.5f, 0.5f, 0.5f}));
  const double diagonal = std::sqrt(0.5);
  RoundHullPairs pairs;
  const double gap = -0.003;
  // Within the edge's length, and beyond one of its ends.
  for (const double along : {0.1, 0.4}) {
    add_above(pairs, capsule(0.3f, 0.25f), cube, {0.5, along, 0.5}, {diagonal, 0, diagonal}, {0, 1, 0},
              0.25 + gap, random);
  }
  const Rows rows = pairs.run(scalar_kernels());
  const double expected_spread[] = {0.6, 0.4};
  for (std::size_t row = 0; row < pairs.size(); ++row) {
    const Manifold& m = rows.manifold[row];
    ASSERT_EQ(points_of(m), 2);
    EXPECT_NEAR(m.separation[0], gap, 1e-5);
    EXPECT_NEAR(m.separation[1], gap, 1e-5);
    EXPECT_NEAR(std::hypot(m.point_u[0] - m.point_u[1], m.point_v[0] - m.point_v[1]), expected_spread[row],
                1e-5);
  }
}

TEST(CollideRoundHull, MovingAShapeChangesTheDepthByAtMostTheDistanceMoved) {
  // The gap between two convex shapes is a distance, or the shortest way out: neither changes faster than the
  // shapes move.
  Random random(5);
  int steps = 0;
  for (const NamedHull& named : all_hulls(1.0f)) {
    for (const bool is_sphere : {true, false}) {
      RoundHullPairs pairs;
      constexpr int kSteps = 100;
      const float size = named.hull.data.outer_radius;
      for (int walk = 0; walk < 10; ++walk) {
        const Shape round = round_shape(random, is_sphere, size);
        PoseRow pose = pose_row(0.7f * size * random.unit(), random.rotation());
        const Vec3 way = 0.01f * size * random.unit();
        for (int step = 0; step < kSteps; ++step) {
          pairs.add(round, pose, named.hull, pose_row({0, 0, 0}));
          pose.position[0] += way.x;
          pose.position[1] += way.y;
          pose.position[2] += way.z;
        }
      }
      const Rows rows = pairs.run(scalar_kernels());
      for (std::size_t row = 1; row < pairs.size(); ++row) {
        if (row % kSteps == 0 || rows.points[row] == 0 || rows.points[row - 1] == 0) continue;
        const double change = std::abs(double(deepest(rows.manifold[row]) - deepest(rows.manifold[row - 1])));
        EXPECT_LE(change, 0.01 * double(size) * (1.0 + 1e-2)) << named.name << " row " << row;
        ++steps;
      }
    }
  }
  EXPECT_GT(steps, 5000);
}

// Deep, shallow, resting and separated pairs of every hull, with every kind of material and body.
RoundHullPairs mixed_round_pairs(const std::deque<NamedHull>& hulls) {
  RoundHullPairs pairs;
  Random random(6);
  for (const NamedHull& named : hulls) {
    const float size = named.hull.data.outer_radius;
    for (int k = 0; k < 151; ++k) {
      const Shape round = round_shape(random, k % 2 == 0, size);
      pairs.add(round, pose_row(0.9f * size * random.vector(), random.rotation()), named.hull,
                pose_row(0.1f * size * random.vector(), random.rotation()));
      const std::size_t face = static_cast<std::size_t>(k) % named.hull.faces.size();
      const std::vector<Vector> corners = corners_of(named.hull, face);
      const Vector normal = reference::normal_of(named.hull.corners, named.hull.faces[face]);
      const Vector point = k % 3 == 0 ? corners[0] : middle_of(corners);
      add_above(pairs, round, named.hull, point, normal, corners[1] - corners[0],
                0.98 * double(round.extent.radius), random);
    }
  }
  for (std::size_t row = 0; row < pairs.size(); ++row) {
    simd::CollideItem& item = pairs.pairs.items[row];
    if (row % 3 == 1) item.flags = simd::kItemFlip | simd::kItemStatic | simd::kItemFixed;
    if (row % 7 == 2) item.flags = simd::kItemStatic;
    if (row % 5 == 0)
      pairs.pairs.material[2 * row] = {0.3f, 0.4f, 0.1f, 1u | 2u << 8 | kMaterialPatch, {0, 0, 0}, 0.1f};
  }
  return pairs;
}

constexpr int kLeastTouchingHulls = 1501;  // of the mixed pairs

TEST(CollideRoundHull, EveryInstructionSetGivesTheBitsOfScalar) {
  const std::deque<NamedHull> hulls = all_hulls(1.0f);
  const RoundHullPairs pairs = mixed_round_pairs(hulls);
  Rows before = pairs.run(scalar_kernels());
  fill_impulses(before);
  const Rows after = pairs.run(scalar_kernels(), &before);
  for (const simd::Kernels* kernels : all_kernels()) {
    Rows wide = pairs.run(*kernels);
    fill_impulses(wide);
    expect_same_bits(before, wide, kernels->name, kLeastTouchingHulls);
    expect_same_bits(after, pairs.run(*kernels, &wide), kernels->name, kLeastTouchingHulls);
  }
}

TEST(CollideRoundHull, NeighborsInAChunkChangeNothing) {
  const std::deque<NamedHull> hulls = all_hulls(1.0f);
  const RoundHullPairs pairs = mixed_round_pairs(hulls);
  const Rows expected = pairs.run(scalar_kernels());
  std::vector<std::size_t> order(pairs.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::shuffle(order.begin(), order.end(), std::mt19937(7));
  for (const simd::Kernels* kernels : all_kernels()) {
    for (const int chunk : {1, 7, simd::kCollideChunk}) {
      expect_same_bits(expected, pairs.run(*kernels, nullptr, order, chunk), kernels->name,
                       kLeastTouchingHulls);
    }
  }
}

TEST(CollideRoundHull, NonFiniteShapesDoNotTouchAndChangeNoOtherLane) {
  const std::deque<NamedHull> hulls = all_hulls(1.0f);
  RoundHullPairs pairs = mixed_round_pairs(hulls);
  const Rows expected = pairs.run(scalar_kernels());
  for (std::size_t row = 0; row < pairs.size(); row += kSpoiledStride) {
    spoil(pairs.pairs.pose[2 * row + row % 2], row);
  }
  for (const simd::Kernels* kernels : all_kernels()) {
    expect_only_spoiled_to_part(expected, pairs.run(*kernels), kernels->name);
  }
}

void expect_finite_contacts(const RoundHullPairs& pairs, const char* name) {
  const Rows rows = pairs.run(scalar_kernels());
  for (std::size_t row = 0; row < pairs.size(); ++row) {
    const Manifold& m = rows.manifold[row];
    ASSERT_GT(points_of(m), 0) << name << " row " << row;
    EXPECT_NEAR(to_vector(m.normal).norm(), 1.0, 1e-5) << name << " row " << row;
    EXPECT_TRUE(std::isfinite(to_vector(m.arm_a).norm() + to_vector(m.arm_b).norm()))
        << name << " row " << row;
    for (int k = 0; k < points_of(m); ++k) {
      EXPECT_TRUE(std::isfinite(m.separation[k] + m.point_u[k] + m.point_v[k])) << name << " row " << row;
      EXPECT_LE(m.separation[k], kSpeculativeDistance);
    }
    EXPECT_LT(deepest(m), 0.0f) << name << " row " << row;
  }
}

TEST(CollideRoundHull, CentersExactlyOnFeaturesGetAFiniteUnitNormal) {
  for (const float scale : {1e-3f, 1.0f, 1e3f}) {
    for (const NamedHull& named : all_hulls(scale)) {
      RoundHullPairs pairs;
      const float radius = 0.2f * named.hull.data.outer_radius;
      const Quat turns[] = {{}, turn({0, 0, 1}, std::numbers::pi_v<float> / 2), turn({1, 2, 3}, 1.0f)};
      const auto add = [&](const Vector& at) {
        pairs.add(sphere(radius), pose_at(at, {}), named.hull, pose_row({0, 0, 0}));
        for (const Quat q : turns) {
          pairs.add(capsule(radius, radius), pose_at(at, q), named.hull, pose_row({0, 0, 0}));
          pairs.add(capsule(0, radius), pose_at(at, q), named.hull, pose_row({0, 0, 0}));
        }
        // With the capsule's axis along a feature.
        for (const std::size_t face : {std::size_t(0), named.hull.faces.size() / 2}) {
          const std::vector<Vector> corners = corners_of(named.hull, face);
          const Vector normal = reference::normal_of(named.hull.corners, named.hull.faces[face]);
          const Vector side = corners[1] - corners[0];
          for (const Vector& axis : {normal, side}) {
            pairs.add(capsule(2 * radius, radius),
                      pose_at(at, rotation_with(axis, axis == side ? normal : side)), named.hull,
                      pose_row({0, 0, 0}));
          }
        }
      };
      add(Vector::Zero());
      for (const Vector& corner : named.hull.corners) add(corner);
      for (std::size_t face = 0; face < named.hull.faces.size(); ++face) {
        const std::vector<Vector> corners = corners_of(named.hull, face);
        add(middle_of(corners));
        for (std::size_t k = 0; k < corners.size(); ++k)
          add(0.5 * (corners[k] + corners[(k + 1) % corners.size()]));
      }
      expect_finite_contacts(pairs, named.name);
    }
  }
}

TEST(CollideRoundHull, FarFromTheOriginOnlyTheOffsetCounts) {
  const TestHull cube(scaled(box_points(), {0.5f, 0.5f, 0.5f}));
  RoundHullPairs near, far;
  for (const Shape& round : {sphere(0.5f), capsule(0.5f, 0.25f)}) {
    // 0.6875 m apart: a multiple of what a float resolves at 1e6 m.
    near.add(round, pose_row({0.25f, 0.6875f, 0.125f}), cube, pose_row({0, 0, 0}));
    far.add(round, pose_row({1e6f + 0.25f, -1e6f + 0.6875f, 1e6f + 0.125f}), cube,
            pose_row({1e6f, -1e6f, 1e6f}));
  }
  const Rows here = near.run(scalar_kernels()), there = far.run(scalar_kernels());
  for (std::size_t row = 0; row < 2; ++row) {
    ASSERT_GT(here.points[row], 0);
    EXPECT_EQ(std::memcmp(&here.manifold[row], &there.manifold[row], sizeof(Manifold)), 0);
  }
}

}  // namespace
}  // namespace scree::collide_tests
