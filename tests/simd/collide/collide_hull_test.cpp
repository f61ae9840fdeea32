// Hulls on hulls and boxes: equal bits everywhere, contacts at rest, recycling, degenerate placements.
#include <core/world/edit.h>
#include <tests/simd/same_bits.h>
#include "hull_fixture.h"

#include <algorithm>
#include <limits>
#include <set>

namespace scree::collide_tests {
namespace {

// Touching and apart, hulls and boxes, with aligned and coincident ones among them.
HullPairs mixed_hull_pairs() {
  HullPairs pairs = random_hull_pairs(small_zoo(), 300, 11, -0.3f, 0.1f, false);
  const auto append = [&](const HullPairs& from) {
    for (std::size_t s = 0; s < from.pose.size(); s += 2) {
      pairs.add(from.bodies[s], from.pose[s], from.bodies[s + 1], from.pose[s + 1]);
    }
  };
  append(random_hull_pairs(large_zoo(), 9, 16, -0.3f, 0.1f, false));
  append(random_hull_pairs(small_zoo(), 200, 12, -0.3f, 0.1f, true));
  Random random(13);
  for (const ZooHull& entry : whole_zoo()) {
    const PoseRow pose = pose_row(20.0f * random.vector(), random.rotation());
    pairs.add(hull_body(entry.hull), pose, hull_body(entry.hull), pose);
    pairs.add(box_body(0.5f, 0.5f, 0.5f), pose, hull_body(entry.hull), pose);
    pairs.add(hull_body(entry.hull), pose_row({1, 2, 3}), hull_body(entry.hull), pose_row({1.01f, 2.1f, 3}));
  }
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    if (row % 3 == 1) pairs.items[row].flags = simd::kItemFlip | simd::kItemStatic | simd::kItemFixed;
    if (row % 7 == 2) pairs.items[row].flags = simd::kItemStatic;
  }
  return pairs;
}

// The same pairs after a small motion.
HullPairs jittered(const HullPairs& pairs) {
  HullPairs result;
  Random random(14);
  for (std::size_t s = 0; s < pairs.pose.size(); s += 2) {
    PoseRow moved = pairs.pose[s + 1];
    for (float& x : moved.position) x += random.uniform(-2e-3f, 2e-3f);
    result.add(pairs.bodies[s], pairs.pose[s], pairs.bodies[s + 1], moved);
  }
  for (std::size_t row = 0; row < pairs.items.size(); ++row) result.items[row].flags = pairs.items[row].flags;
  return result;
}

void expect_same_bits(const HullRows& a, const HullRows& b, const char* name) {
  for (std::size_t row = 0; row < a.manifold.size(); ++row) {
    ASSERT_EQ(std::memcmp(&a.axis[row], &b.axis[row], sizeof(ContactAxis)), 0) << name << " row " << row;
  }
  collide_tests::expect_same_bits(a, b, name, 301);
}

TEST(CollideHullBits, EveryInstructionSetGivesTheBitsOfScalar) {
  const HullPairs first = mixed_hull_pairs(), second = jittered(first);
  const HullRows before = first.run(scalar_kernels());
  for (const bool recycle : {false, true}) {
    const HullRows after = second.run(scalar_kernels(), &before, recycle);
    for (const simd::Kernels* kernels : all_kernels()) {
      const HullRows wide = first.run(*kernels);
      expect_same_bits(before, wide, kernels->name);
      expect_same_bits(after, second.run(*kernels, &wide, recycle), kernels->name);
    }
  }
}

TEST(CollideHullBits, NeighborsInAChunkChangeNothing) {
  HullPairs pairs = mixed_hull_pairs();
  const HullRows expected = pairs.run(scalar_kernels());
  std::mt19937 engine(15);
  std::shuffle(pairs.items.begin(), pairs.items.end(), engine);
  for (const simd::Kernels* kernels : all_kernels()) {
    HullRows rows;
    rows.resize(pairs.items.size());
    rows.axis.resize(pairs.items.size());
    const simd::CollideColumns columns = pairs.columns(rows);
    // Chunks of growing sizes.
    for (const bool boxes : {false, true}) {
      Column<simd::CollideItem> group;
      for (const simd::CollideItem& item : pairs.items) {
        if ((pairs.shape_hull[static_cast<std::size_t>(item.shape_1)] < 0) == boxes) group.push_back(item);
      }
      int count = 0;
      for (std::size_t begin = 0; begin < group.size(); begin += static_cast<std::size_t>(count)) {
        count = std::min({static_cast<int>(group.size() - begin), count + 1, simd::kCollideChunk});
        const int type = boxes ? simd::kBoxHull : simd::kHullHull;
        kernels->collide.collide[type](columns, group.data() + begin, count);
      }
    }
    expect_same_bits(expected, rows, kernels->name);
  }
}

TEST(CollideHullBits, NonFiniteShapesDoNotTouchAndChangeNoOtherLane) {
  HullPairs pairs = mixed_hull_pairs();
  const HullRows expected = pairs.run(scalar_kernels());
  for (std::size_t row = 0; row < pairs.items.size(); row += kSpoiledStride) {
    spoil(pairs.pose[static_cast<std::size_t>(pairs.items[row].shape_2)], row);
  }
  for (const simd::Kernels* kernels : all_kernels()) {
    expect_only_spoiled_to_part(expected, pairs.run(*kernels), kernels->name);
  }
}

TEST(CollideHull, CoincidentHullsGetAFiniteContact) {
  HullPairs pairs;
  const PoseRow pose = pose_row({1, 2, 3}, turn({1, 2, 3}, 0.5f));
  for (const ZooHull& entry : whole_zoo())
    pairs.add(hull_body(entry.hull), pose, hull_body(entry.hull), pose);
  const HullRows rows = pairs.run(scalar_kernels());
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    const Manifold& m = rows.manifold[row];
    ASSERT_GT(points_of(m), 0) << row;
    EXPECT_NEAR(to_vector(m.normal).norm(), 1.0, 1e-5);
    EXPECT_NEAR(deepest(m), pairs.gap(row).separation, 1e-4 * pairs.size(row)) << row;
  }
}

TEST(CollideHull, FarApartHullsDoNotTouch) {
  HullPairs pairs;
  const Hull cube = hull_of(box_points(0.5f, 0.5f, 0.5f));
  for (const float distance : {1e3f, 1e19f, 3e38f}) {
    pairs.add(hull_body(cube), pose_row({-distance, 0, 0}), hull_body(cube), pose_row({distance, 0, 0}));
    pairs.add(box_body(1, 1, 1), pose_row({-distance, 0, 0}), hull_body(cube), pose_row({distance, 0, 0}));
  }
  const HullRows rows = pairs.run(scalar_kernels());
  for (const std::uint8_t points : rows.points) EXPECT_EQ(points, 0);
}

TEST(CollideHull, FarFromTheOriginOnlyTheOffsetCounts) {
  const Hull cube = hull_of(box_points(0.5f, 0.5f, 0.5f));
  HullPairs pairs;
  // 0.9375 m apart: a multiple of what a float resolves at 1e6 m.
  pairs.add(hull_body(cube), pose_row({0, 0, 0}), hull_body(cube), pose_row({0.25f, 0.9375f, 0.125f}));
  pairs.add(hull_body(cube), pose_row({1e6f, -1e6f, 1e6f}), hull_body(cube),
            pose_row({1e6f + 0.25f, -1e6f + 0.9375f, 1e6f + 0.125f}));
  const HullRows rows = pairs.run(scalar_kernels());
  for (int k = 0; k < 4; ++k) EXPECT_EQ(rows.manifold[0].separation[k], rows.manifold[1].separation[k]);
  EXPECT_EQ(std::memcmp(rows.manifold[0].arm_a, rows.manifold[1].arm_a, 12), 0);
}

// The second shape rests on the first one, lowered by `depth`.
struct Rest {
  Body lower, upper;
  Vec3 offset;
  float angle;  // about y
  int points;
};
std::vector<Rest> rests() {
  const Body cube = hull_body(hull_of(box_points(0.5f, 0.5f, 0.5f))), ground = box_body(50, 0.5f, 50);
  const Body prism = hull_body(hull_of(prism_points(16, 0.8f, 0.3f)));
  const Body drum = hull_body(hull_of(prism_points(64, 0.6f, 0.6f)));
  const Body plate = hull_body(hull_of(prism_points(7, 1.0f, 0.02f)));
  return {{cube, cube, {0, 0.998f, 0}, 0, 4},
          {cube, cube, {0.3f, 0.998f, 0.2f}, 0, 4},
          {cube, cube, {0.1f, 0.998f, 0}, 0.6f, 4},
          {ground, cube, {3, 0.998f, 4}, 0.3f, 4},
          {ground, prism, {3, 0.798f, 4}, 0.1f, 4},
          {ground, drum, {3, 1.098f, 4}, 0.2f, 4},
          {ground, plate, {3, 0.518f, 4}, 0.2f, 4},
          {prism, drum, {0.2f, 0.898f, 0.1f}, 0.2f, 4},
          {cube, plate, {0.2f, 0.518f, 0.1f}, 0.2f, 4},
          {box_body(0.5f, 0.5f, 0.5f), cube, {0.3f, 0.998f, 0.1f}, 0.2f, 4}};
}

TEST(CollideHull, FacesAtRestTouchInFourSpreadPoints) {
  for (const Rest& rest : rests()) {
    HullPairs pairs;
    pairs.add(rest.lower, pose_row({7, 1, -4}), rest.upper,
              pose_row(Vec3{7, 1, -4} + rest.offset, turn({0, 1, 0}, rest.angle)));
    const HullRows rows = pairs.run(scalar_kernels());
    const Manifold& m = rows.manifold[0];
    ASSERT_EQ(points_of(m), rest.points);
    EXPECT_NEAR(m.normal[1], 1.0f, 1e-5f);
    double spread = 0.0;
    for (int k = 0; k < 4; ++k) {
      EXPECT_NEAR(m.separation[k], -0.002f, 1e-4f);
      for (int j = 0; j < k; ++j) {
        spread =
            std::max<double>(spread, std::hypot(m.point_u[k] - m.point_u[j], m.point_v[k] - m.point_v[j]));
      }
    }
    EXPECT_GT(spread, 0.9);
  }
}

TEST(CollideHull, FeaturesStayWhileAHullAtRestJitters) {
  Random random(22);
  for (const Rest& rest : rests()) {
    std::set<std::uint32_t> expected;
    for (int k = 0; k < 200; ++k) {
      const auto jitter = [&] { return random.uniform(-1e-6f, 1e-6f); };
      const Quat wobble = normalize(Quat{jitter() / 2, jitter() / 2, jitter() / 2, 1});
      HullPairs pairs;
      pairs.add(rest.lower, pose_row({7, 1, -4}), rest.upper,
                pose_row(Vec3{7, 1, -4} + rest.offset + Vec3{jitter(), jitter(), jitter()},
                         normalize(wobble * turn({0, 1, 0}, rest.angle))));
      const HullRows rows = pairs.run(scalar_kernels());
      ASSERT_EQ(points_of(rows.manifold[0]), 4);
      const std::set<std::uint32_t> ids(rows.features[0].id, rows.features[0].id + 4);
      ASSERT_EQ(ids.size(), 4u);
      if (k == 0) expected = ids;
      EXPECT_EQ(ids, expected) << "step " << k;
    }
  }
}

// A flat roof with its ridge along x at the top, and the same upside down.
Hull roof(bool upside_down) {
  std::vector<Vec3> points;
  for (const float x : {-1.0f, 1.0f}) {
    points.push_back({x, 0.2f, 0});
    for (const float z : {-1.0f, 1.0f}) points.push_back({x, -0.2f, z});
  }
  for (Vec3& point : points) point.y *= upside_down ? -1.0f : 1.0f;
  return hull_of(points);
}
// One roof upside down on the other, turned by the angle; the ridges cross at x.
HullRows roofs(float gap, float angle, float x) {
  HullPairs pairs;
  const float between = roof(true).centroid().y - roof(false).centroid().y;
  const Vec3 at{x - x * std::cos(angle), 0.4f + gap + between, x * std::sin(angle)};
  pairs.add(hull_body(roof(false)), pose_row({}), hull_body(roof(true)),
            pose_row(at, turn({0, 1, 0}, angle)));
  return pairs.run(scalar_kernels());
}

TEST(CollideHull, CrossedEdgesTouchInTheirCrossingAndInTheOverlapOfTheirFaces) {
  const HullRows rows = roofs(-0.01f, 1.5707963f, 0.0f);
  const Manifold& m = rows.manifold[0];
  ASSERT_EQ(points_of(m), 4);
  EXPECT_NEAR(std::abs(m.normal[1]), 1.0f, 1e-5f);
  EXPECT_NEAR(m.separation[0], -0.01f, 1e-5f);
  const Frame frame = frame_of(m, pose_row({}));
  for (int k = 1; k < 4; ++k) {
    // Both roofs fall away from their ridges by two fifths.
    const reference::Vector from_ridges = point_of(m, frame, k) - point_of(m, frame, 0);
    const double expected = -0.01 + 0.4 * (std::abs(from_ridges.x()) + std::abs(from_ridges.z()));
    EXPECT_NEAR(m.separation[k], expected, 1e-3) << "point " << k;
    EXPECT_GT(m.separation[k], 0.3f);
  }
}

TEST(CollideHull, NearlyParallelEdgesTouchWhereTheyCross) {
  for (const float angle : {0.1f, 1e-2f, 1e-3f, 5e-4f}) {
    const HullRows rows = roofs(0.01f, angle, 0.7f);
    const Manifold& m = rows.manifold[0];
    ASSERT_GT(points_of(m), 0);
    EXPECT_EQ(rows.axis[0].feature >> 28, 3u);  // of edges
    EXPECT_NEAR(point_of(m, frame_of(m, pose_row({})), 0).x(), 0.7, 5e-3) << "angle " << angle;
  }
}

TEST(CollideHull, ImpulsesFollowTheirFeatures) {
  const Rest rest = rests()[1];
  HullPairs pairs;
  pairs.add(rest.lower, pose_row({7, 1, -4}), rest.upper, pose_row(Vec3{7, 1, -4} + rest.offset));
  HullRows before = pairs.run(scalar_kernels());
  for (int k = 0; k < 4; ++k) before.manifold[0].normal_impulse[k] = static_cast<float>(k + 1);
  const HullRows after = pairs.run(scalar_kernels(), &before);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(after.manifold[0].normal_impulse[k], static_cast<float>(k + 1));
}

TEST(CollideHull, ManifoldsAtRestAreRecycled) {
  for (const Rest& rest : rests()) {
    HullPairs pairs;
    const Vec3 at = Vec3{7, 1, -4} + rest.offset;
    pairs.add(rest.lower, pose_row({7, 1, -4}), rest.upper, pose_row(at, turn({0, 1, 0}, rest.angle)));
    const HullRows before = pairs.run(scalar_kernels());
    pairs.pose[1] = pose_row({at.x + 1e-5f, at.y - 1e-4f, at.z}, turn({0, 1, 0}, rest.angle));
    simd::CollideItem item = pairs.items[0], left;
    item.flags |= simd::kItemKnown;
    HullRows after;
    after.resize(1);
    after.take(before);
    after.axis.push_back(before.axis[0]);
    EXPECT_EQ(scalar_kernels().collide.recycle_hulls(pairs.columns(after), &item, 1, &left), 0);
    for (int k = 0; k < 4; ++k) {
      EXPECT_EQ(after.manifold[0].point_u[k], before.manifold[0].point_u[k]);
      EXPECT_NEAR(after.manifold[0].separation[k], before.manifold[0].separation[k] - 1e-4f, 1e-6f);
    }
    EXPECT_EQ(std::memcmp(&after.axis[0], &before.axis[0], sizeof(ContactAxis)), 0);
  }
}

double gap_along_last_axis(const HullPairs& pairs, const HullRows& rows, std::size_t row) {
  const float* q = pairs.pose[2 * row].rotation;
  const reference::Vector axis =
      Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized() * to_vector(rows.axis[row].axis);
  return gap_of_axis(pairs.solid(row, 0), pairs.solid(row, 1), axis);
}

TEST(CollideHull, SeparatedPairsKeepASeparatingAxis) {
  const HullPairs pairs = random_hull_pairs(small_zoo(), 300, 23, 0.03f, 0.3f, false);
  const HullRows rows = pairs.run(scalar_kernels());
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    const ContactAxis& last = rows.axis[row];
    if (rows.points[row] != 0 || to_vector(last.axis).norm() < 0.5) continue;
    EXPECT_EQ(last.feature, 0u);
    EXPECT_GT(gap_along_last_axis(pairs, rows, row), 0.99 * kSpeculativeDistance);
  }
}

// As update_bounds measures it, in single precision.
float approach(const PoseRow (&before)[2], const PoseRow (&after)[2], float lever) {
  const auto moved = [&](int i) { return to_vec3(after[i].position) - to_vec3(before[i].position); };
  const auto turned = [&](int i) {
    const Quat q = conjugate(to_quat(before[i].rotation)) * to_quat(after[i].rotation);
    return 2.0f * length(Vec3{q.x, q.y, q.z});
  };
  return length(moved(1) - moved(0)) + (turned(0) + turned(1)) * lever;
}

// Moves each pair that is clear by a random share of what its clearance allows.
TEST(CollideHull, PairsStayApartAlongTheSameAxisWhileTheyMoveLessThanTheirClearance) {
  for (const bool boxes : {false, true}) {
    HullPairs pairs = random_hull_pairs(small_zoo(), 600, 29, 0.03f, 1.0f, boxes);
    const HullRows found = pairs.run(scalar_kernels());
    const HullRows before = pairs.run(scalar_kernels(), &found);  // by the remembered axes
    const std::vector<PoseRow> start(pairs.pose.begin(), pairs.pose.end());
    Random random(31);
    int clear = 0, turned = 0;
    for (std::size_t row = 0; row < pairs.items.size(); ++row) {
      const PairClearance clearance = before.clearance[row];
      if (!(clearance.gap > kSpeculativeDistance)) continue;
      ++clear;
      turned += clearance.lever > 0.0f ? 1 : 0;
      if (clearance.lever > 0.0f) {
        EXPECT_LT(clearance.gap, gap_along_last_axis(pairs, before, row));
      }
      const float allowed = 0.999f * (clearance.gap - kSpeculativeDistance);
      const PoseRow from[2] = {start[2 * row], start[2 * row + 1]};
      PoseRow to[2];
      float share = 1.0f;
      do {
        for (int side = 0; side < 2; ++side) {
          const float angle = clearance.lever > 0.0f ? random.uniform(0.0f, share * allowed) / clearance.lever
                                                     : random.uniform(0.0f, 3.0f);
          to[side] =
              pose_row(to_vec3(from[side].position) + random.uniform(0.0f, share * allowed) * random.unit(),
                       to_quat(from[side].rotation) * turn(random.unit(), angle));
        }
        share *= 0.8f;
      } while (clearance.lever > 0.0f ? approach(from, to, clearance.lever) > allowed
                                      : approach(from, to, 0.0f) > allowed);
      pairs.pose[2 * row] = to[0];
      pairs.pose[2 * row + 1] = to[1];
    }
    EXPECT_GT(clear, 300);
    EXPECT_GT(turned, 100);
    for (const simd::Kernels* kernels : all_kernels()) {
      const HullRows after = pairs.run(*kernels, &before);
      for (std::size_t row = 0; row < pairs.items.size(); ++row) {
        if (!(before.clearance[row].gap > kSpeculativeDistance)) continue;
        EXPECT_EQ(after.points[row], 0) << row;
        EXPECT_EQ(std::memcmp(&after.axis[row], &before.axis[row], sizeof(ContactAxis)), 0) << row;
      }
    }
  }
}

TEST(CollideHull, PairsThatTouchHaveNoClearance) {
  const HullPairs pairs = random_hull_pairs(small_zoo(), 300, 37, -0.1f, 0.019f, false);
  const HullRows first = pairs.run(scalar_kernels()), rows = pairs.run(scalar_kernels(), &first);
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    EXPECT_LE(rows.clearance[row].gap, kSpeculativeDistance) << row;
  }
}

}  // namespace
}  // namespace scree::collide_tests
