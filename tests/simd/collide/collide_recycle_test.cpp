// Manifolds that are carried along with body A: where both bodies turn together, as in a drum or on a
// turntable, and where one turns on the other.
#include <core/world/edit.h>
#include <tests/simd/same_bits.h>
#include "hull_fixture.h"

#include <limits>

namespace scree::collide_tests {
namespace {

using reference::Vector;

// Turns both bodies of all pairs by the same turn about the origin.
void turn_all(HullPairs& pairs, Quat by) {
  for (PoseRow& pose : pairs.pose) {
    pose = pose_row(rotate(by, to_vec3(pose.position)), normalize(by * to_quat(pose.rotation)));
  }
}

Vector turned(Quat by, Vector v) { return Eigen::Quaterniond(by.w, by.x, by.y, by.z).normalized() * v; }

// Recycles the only pair in its row; whether its manifold was kept.
bool is_kept(const HullPairs& pairs, HullRows& rows) {
  simd::CollideItem item = pairs.items[0], left;
  item.flags |= simd::kItemKnown;
  return scalar_kernels().collide.recycle_hulls(pairs.columns(rows), &item, 1, &left) == 0;
}

// A small cube, pressed slightly askew into a larger one.
HullPairs two_cubes(std::int32_t flags) {
  HullPairs pairs;
  pairs.add(hull_body(hull_of(box_points(0.5f, 0.5f, 0.5f))), pose_row({3, 1, -2}),
            hull_body(hull_of(box_points(0.3f, 0.3f, 0.3f))),
            pose_row({3.05f, 1.793f, -1.9f}, turn({0.02f, 1, 0}, 0.2f)));
  pairs.items[0].flags = flags;
  return pairs;
}

TEST(CollideRecycle, ManifoldsOfBodiesThatTurnTogetherAreCarriedAlong) {
  const std::int32_t flips = simd::kItemFlip | simd::kItemStatic;
  for (const std::int32_t flags : {0, flips}) {
    Random random(31);
    for (int trial = 0; trial < 20; ++trial) {
      HullPairs pairs = two_cubes(flags);
      HullRows rows = pairs.run(scalar_kernels());
      rows.manifold[0].friction_impulse[0] = 0.7f;
      rows.manifold[0].friction_impulse[1] = -0.4f;
      rows.manifold[0].twist_impulse = 0.1f;
      for (int k = 0; k < 4; ++k) rows.manifold[0].normal_impulse[k] = static_cast<float>(k + 1);
      const Manifold made = rows.manifold[0];
      ASSERT_EQ(points_of(made), 4);
      const std::size_t a = flags == 0 ? 0 : 1;
      const Frame before = frame_of(made, pairs.pose[a]);
      const Vector force = 0.7 * before.tangent_1 - 0.4 * before.tangent_2;
      const Quat step = turn(random.unit(), random.uniform(0.05f, 0.5f));
      Quat whole;
      for (int i = 0; i < 30; ++i) {
        turn_all(pairs, step);
        whole = normalize(step * whole);
        ASSERT_TRUE(is_kept(pairs, rows)) << "trial " << trial << " step " << i;
      }
      const Manifold& m = rows.manifold[0];
      const Frame now = frame_of(m, pairs.pose[a]);
      EXPECT_LT((now.normal - turned(whole, before.normal)).norm(), 1e-5);
      EXPECT_LT((now.center - turned(whole, before.center)).norm(), 2e-5);
      for (int k = 0; k < 4; ++k) {
        EXPECT_LT((point_of(m, now, k) - turned(whole, point_of(made, before, k))).norm(), 2e-5);
        EXPECT_NEAR(m.separation[k], made.separation[k], 2e-5f);
        EXPECT_EQ(m.normal_impulse[k], made.normal_impulse[k]);
      }
      const Vector kept =
          double{m.friction_impulse[0]} * now.tangent_1 + double{m.friction_impulse[1]} * now.tangent_2;
      EXPECT_LT((kept - turned(whole, force)).norm(), 1e-5);
      EXPECT_EQ(m.twist_impulse, made.twist_impulse);
      // Both arms lead to one point, or friction would change angular momentum.
      const Vector offset = to_vector(pairs.pose[1 - a].position) - to_vector(pairs.pose[a].position);
      EXPECT_LT((to_vector(m.arm_a) - to_vector(m.arm_b) - offset).norm(), 1e-6);
      EXPECT_EQ(m.info, made.info);
      EXPECT_EQ(rows.points[0], 4);
    }
  }
}

// B lifts off A while both turn: separations are those along the turned normal.
TEST(CollideRecycle, SeparationsFollowTheBodiesAsTheManifoldIsCarriedAlong) {
  HullPairs pairs = two_cubes(0);
  HullRows rows = pairs.run(scalar_kernels());
  const Manifold made = rows.manifold[0];
  const Vec3 lift = 1e-3f * Vec3{made.normal[0], made.normal[1], made.normal[2]};
  pairs.pose[1] = pose_row(to_vec3(pairs.pose[1].position) + lift, to_quat(pairs.pose[1].rotation));
  turn_all(pairs, turn({1, 2, -1}, 0.3f));
  ASSERT_TRUE(is_kept(pairs, rows));
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(rows.manifold[0].separation[k], made.separation[k] + 1e-3f, 1e-5f);
}

// Else a body that slides slowly on a turntable would keep the points that it had at first for ever.
TEST(CollideRecycle, WhatMovesAsItTurnsKeepsItsManifoldForNoLongerThanWhatDoesNotTurn) {
  const auto steps_kept = [](float angle) {
    HullPairs pairs = two_cubes(0);
    HullRows rows = pairs.run(scalar_kernels());
    const Vec3 normal{rows.manifold[0].normal[0], rows.manifold[0].normal[1], rows.manifold[0].normal[2]};
    Vec3 slide = 1e-3f * normalize(cross(normal, {1, 0, 0}));
    const Quat by = turn({0.3f, 1, 0.2f}, angle);
    int steps = 0;
    for (; steps < 200; ++steps) {
      pairs.pose[1] = pose_row(to_vec3(pairs.pose[1].position) + slide, to_quat(pairs.pose[1].rotation));
      turn_all(pairs, by);
      slide = rotate(by, slide);
      if (!is_kept(pairs, rows)) break;
    }
    return steps;
  };
  const int standing = steps_kept(0.0f);
  EXPECT_GT(standing, 10);
  EXPECT_LT(standing, 100);
  EXPECT_NEAR(steps_kept(0.05f), standing, 1);
  EXPECT_NEAR(steps_kept(1.0f), standing, 1);
}

// Random pairs, some of them flipped.
HullPairs some_pairs() {
  HullPairs pairs = random_hull_pairs(small_zoo(), 300, 33, -0.3f, 0.1f, false);
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    if (row % 3 == 1) pairs.items[row].flags = simd::kItemFlip | simd::kItemStatic | simd::kItemFixed;
  }
  return pairs;
}

// The arms are made to fit at every carry, so that no point lags behind by more than what moves may.
TEST(CollideRecycle, WhatTurnsOnABodyAtRestKeepsItsManifoldUntilItsCornersHaveMovedAsFarAsTheyMay) {
  HullPairs pairs = two_cubes(simd::kItemStatic | simd::kItemFixed);
  HullRows rows = pairs.run(scalar_kernels());
  const Manifold made = rows.manifold[0];
  const Vec3 normal{made.normal[0], made.normal[1], made.normal[2]};
  constexpr float kStep = 1e-3f, kCorner = 0.52f;  // rad, m
  int steps = 0;
  for (; steps < 1000; ++steps) {
    PoseRow& pose = pairs.pose[1];
    pose = pose_row(to_vec3(pose.position), normalize(turn(normal, kStep) * to_quat(pose.rotation)));
    if (!is_kept(pairs, rows)) break;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(rows.manifold[0].normal[axis], made.normal[axis], 1e-6f);
      EXPECT_NEAR(rows.manifold[0].arm_b[axis], made.arm_b[axis], 1e-5f);
    }
  }
  EXPECT_GT(steps, 10);
  EXPECT_LT(static_cast<float>(steps) * kStep * kCorner, 0.05f);
}

TEST(CollideRecycle, RichManifoldsAndThoseThatAHookHasChangedAreNotCarriedAlong) {
  for (const bool is_rich : {false, true}) {
    HullPairs pairs = two_cubes(0);
    HullRows rows = pairs.run(scalar_kernels());
    if (is_rich) {
      rows.manifold[0].info |= kManifoldRich;
    } else {
      rows.anchor[0].is_set = 0.0f;
    }
    turn_all(pairs, turn({1, 2, -1}, 0.3f));
    EXPECT_FALSE(is_kept(pairs, rows));
  }
}

// B has come too far away: the manifold is made anew, and only then is it gone.
TEST(CollideRecycle, WhatNoLongerTouchesIsNotCarriedAlong) {
  HullPairs pairs = two_cubes(0);
  HullRows rows = pairs.run(scalar_kernels());
  const Vec3 normal{rows.manifold[0].normal[0], rows.manifold[0].normal[1], rows.manifold[0].normal[2]};
  const Vec3 lift = (0.045f - deepest(rows.manifold[0])) * normal;
  pairs.pose[1] = pose_row(to_vec3(pairs.pose[1].position) + lift, to_quat(pairs.pose[1].rotation));
  turn_all(pairs, turn({1, 2, -1}, 0.3f));
  EXPECT_FALSE(is_kept(pairs, rows));
  EXPECT_EQ(pairs.run(scalar_kernels(), &rows, true).points[0], 0);
}

TEST(CollideRecycle, ManifoldsOfBoxesAreCarriedAlongAsThoseOfHulls) {
  const auto place = [](int i) {
    return i == 0 ? pose_row({3, 1, -2}) : pose_row({3.05f, 1.793f, -1.9f}, turn({0.02f, 1, 0}, 0.2f));
  };
  Pairs pairs;
  pairs.add(box(0.5f, 0.5f, 0.5f), place(0), box(0.3f, 0.3f, 0.3f), place(1));
  Rows rows = pairs.run(scalar_kernels());
  const Manifold made = rows.manifold[0];
  const Frame before = frame_of(made, pairs.pose[0]);
  const Quat by = turn({1, 2, -1}, 0.3f);
  for (PoseRow& pose : pairs.pose) {
    pose = pose_row(rotate(by, to_vec3(pose.position)), normalize(by * to_quat(pose.rotation)));
  }
  const simd::CollideColumns columns{.shape_pose = pairs.pose.data(),
                                     .shape_extent = pairs.extent.data(),
                                     .shape_material = pairs.material.data(),
                                     .body_pose = pairs.pose.data(),
                                     .body_velocity = pairs.velocity.data(),
                                     .dt = 0.0f,
                                     .manifold = rows.manifold.data(),
                                     .features = rows.features.data(),
                                     .surface = rows.surface.data(),
                                     .anchor = rows.anchor.data(),
                                     .points = rows.points.data()};
  simd::CollideItem item = pairs.items[0], left;
  item.flags |= simd::kItemKnown;
  EXPECT_EQ(scalar_kernels().collide.recycle_boxes(columns, &item, 1, &left), 0);
  const Frame now = frame_of(rows.manifold[0], pairs.pose[0]);
  ASSERT_EQ(points_of(rows.manifold[0]), 4);
  for (int k = 0; k < 4; ++k) {
    EXPECT_LT((point_of(rows.manifold[0], now, k) - turned(by, point_of(made, before, k))).norm(), 1e-5);
  }
}

TEST(CollideRecycle, CarriedManifoldsHaveTheSameBitsOnEveryInstructionSet) {
  const HullPairs first = some_pairs();
  HullPairs second = some_pairs();
  Random random(32);
  turn_all(second, turn({1, -2, 0.5f}, 0.1f));
  for (std::size_t s = 1; s < second.pose.size(); s += 2) {
    for (float& x : second.pose[s].position) x += random.uniform(-2e-3f, 2e-3f);
  }
  const HullRows before = first.run(scalar_kernels());
  const HullRows after = second.run(scalar_kernels(), &before, true);
  int carried = 0;
  for (std::size_t row = 0; row < after.points.size(); ++row) {
    if (after.points[row] != 0 && after.anchor[row].is_set > 1.0f) ++carried;
  }
  EXPECT_GT(carried, 60);
  for (const simd::Kernels* kernels : all_kernels()) {
    expect_same_bits(after, second.run(*kernels, &before, true), kernels->name, 60);
  }
}

TEST(CollideRecycle, NothingIsCarriedAlongByWhatIsNotFinite) {
  for (const float far : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    for (int value = 0; value < 14; ++value) {
      HullPairs pairs = two_cubes(0);
      HullRows rows = pairs.run(scalar_kernels());
      turn_all(pairs, turn({1, 2, -1}, 0.3f));
      PoseRow& pose = pairs.pose[static_cast<std::size_t>(value / 7)];
      const int number = value % 7;
      (number < 3 ? pose.position[number] : pose.rotation[number - 3]) = far;
      EXPECT_FALSE(is_kept(pairs, rows)) << value;
    }
  }
}

}  // namespace
}  // namespace scree::collide_tests
