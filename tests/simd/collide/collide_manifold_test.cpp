// Data of a manifold besides geometry: bodies, materials, impulses of the last step, friction center; and the
// degenerate positions of round shapes.
#include "collide_fixture.h"

#include <utility>

namespace scree::collide_tests {
namespace {

const Shape kCube = box(0.5f, 0.5f, 0.5f);

Pairs resting(std::int32_t flags = 0, Vec3 upper = {0.1f, 0.995f, 0.2f}) {
  Pairs pairs;
  pairs.add(kCube, pose_row({0, 0, 0}), kCube, pose_row(upper), flags);
  return pairs;
}

TEST(CollideManifold, BodyAIsTheOneThatIsNotDynamic) {
  Pairs pairs = resting();
  pairs.items[0].body_1 = 0;
  pairs.items[0].body_2 = 1;
  const Manifold plain = pairs.run(scalar_kernels()).manifold[0];
  EXPECT_EQ(plain.info, 4u);
  EXPECT_EQ(plain.row_a, 0);
  EXPECT_EQ(plain.row_b, 1);

  pairs.items[0].flags = simd::kItemFlip | simd::kItemStatic;
  const Manifold kinematic = pairs.run(scalar_kernels()).manifold[0];
  EXPECT_EQ(kinematic.info, 4u | kManifoldStatic);
  EXPECT_EQ(kinematic.row_a, 1);
  EXPECT_EQ(kinematic.row_b, 0);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(kinematic.normal[k], -plain.normal[k]);
    EXPECT_EQ(kinematic.arm_a[k], plain.arm_b[k]);
    EXPECT_EQ(kinematic.arm_b[k], plain.arm_a[k]);
  }
  pairs.items[0].flags |= simd::kItemFixed;
  EXPECT_EQ(pairs.run(scalar_kernels()).manifold[0].row_a, kFixedRow);
}

TEST(CollideManifold, ArmsReachFromEachCenterOfMassToTheFrictionCenter) {
  Pairs pairs = resting();
  const Manifold m = pairs.run(scalar_kernels()).manifold[0];
  EXPECT_NEAR(m.arm_a[0], 0.05f, 1e-4f);
  EXPECT_NEAR(m.arm_a[1], 0.4975f, 1e-4f);
  EXPECT_NEAR(m.arm_a[2], 0.1f, 1e-4f);
  EXPECT_NEAR(m.arm_b[0], -0.05f, 1e-4f);
  EXPECT_NEAR(m.arm_b[1], -0.4975f, 1e-4f);
  EXPECT_NEAR(m.arm_b[2], -0.1f, 1e-4f);
}

TEST(CollideManifold, StrongerMixRuleOfTheTwoIsTaken) {
  const float a = 0.25f, b = 0.64f;
  const float expected[] = {a, 0.5f * (a + b), a * b, std::sqrt(a * b), b};
  for (std::uint32_t rule_a = 0; rule_a < 5; ++rule_a) {
    for (std::uint32_t rule_b = 0; rule_b < 5; ++rule_b) {
      Pairs pairs = resting();
      pairs.material[0] = {a, b, 0.01f, rule_a | rule_b << 8, {0, 0, 0}, kAutomaticPatch};
      pairs.material[1] = {b, a, 0.03f, rule_b | rule_a << 8, {0, 0, 0}, kAutomaticPatch};
      const Rows rows = pairs.run(scalar_kernels());
      const float want = expected[std::max(rule_a, rule_b)];
      EXPECT_EQ(rows.manifold[0].friction, want);
      EXPECT_EQ(rows.manifold[0].info & kManifoldRich, std::uint32_t(kManifoldRich));
      EXPECT_EQ(rows.surface[0].restitution, want);
      EXPECT_EQ(rows.surface[0].rolling_resistance, 0.03f);
    }
  }
}

TEST(CollideManifold, OnlySurfacesThatNeedItAreRich) {
  Pairs pairs = resting();
  EXPECT_EQ(pairs.run(scalar_kernels()).manifold[0].info & kManifoldRich, 0u);
  pairs.material[1].rolling_resistance = 0.1f;
  EXPECT_NE(pairs.run(scalar_kernels()).manifold[0].info & kManifoldRich, 0u);
}

TEST(CollideManifold, SurfaceVelocityIsThatOfBRelativeToAInTheTangentPlane) {
  for (const bool flip : {false, true}) {
    Pairs pairs = resting(flip ? simd::kItemFlip : 0);
    const Quat q = turn({0, 1, 0}, 1.5707963f);  // local x -> world -z
    pairs.pose[0] = pose_row({0, 0, 0}, q);
    pairs.material[0].surface_velocity[0] = 2.0f;
    pairs.material[0].surface_velocity[1] = 5.0f;
    pairs.material[0].rules |= kMaterialMoves;
    const Rows rows = pairs.run(scalar_kernels());
    ASSERT_NE(rows.manifold[0].info & kManifoldRich, 0u);
    EXPECT_NEAR(rows.surface[0].surface_velocity[0], 0.0f, 1e-5f);
    EXPECT_NEAR(rows.surface[0].surface_velocity[1], 0.0f, 1e-5f);
    EXPECT_NEAR(rows.surface[0].surface_velocity[2], flip ? -2.0f : 2.0f, 1e-5f);
  }
}

TEST(CollideManifold, ImpulsesFollowTheirFeatures) {
  Pairs pairs = resting();
  for (MaterialRow& material : pairs.material) material.restitution = 0.5f;
  Rows before = pairs.run(scalar_kernels());
  for (int k = 0; k < 4; ++k) before.manifold[0].normal_impulse[k] = 1.0f + float(k);
  before.manifold[0].friction_impulse[0] = 0.3f;
  before.manifold[0].friction_impulse[1] = -0.4f;
  before.manifold[0].twist_impulse = 0.5f;
  for (int k = 0; k < 3; ++k) before.surface[0].rolling_impulse[k] = 7.0f + float(k);
  // Tilted and shifted a little: the same features in another order or depth.
  pairs.pose[1] = pose_row({0.101f, 0.994f, 0.199f}, turn({1, 0.3f, -1}, 1e-3f));
  const Rows after = pairs.run(scalar_kernels(), &before);
  for (int k = 0; k < 4; ++k) {
    for (int old = 0; old < 4; ++old) {
      if (after.features[0].id[k] != before.features[0].id[old]) continue;
      EXPECT_EQ(after.manifold[0].normal_impulse[k], before.manifold[0].normal_impulse[old]);
    }
    EXPECT_GT(after.manifold[0].normal_impulse[k], 0.0f);
  }
  for (int k = 0; k < 3; ++k) EXPECT_EQ(after.surface[0].rolling_impulse[k], 7.0f + float(k));
  const auto world_friction = [&](const Manifold& m) {
    const Frame frame = frame_of(m, pairs.pose[0]);
    return reference::Vector(double(m.friction_impulse[0]) * frame.tangent_1 +
                             double(m.friction_impulse[1]) * frame.tangent_2);
  };
  EXPECT_LT((world_friction(after.manifold[0]) - world_friction(before.manifold[0])).norm(), 2e-3);
  EXPECT_NEAR(after.manifold[0].twist_impulse, 0.5f, 1e-3f);
}

TEST(CollideManifold, ContactsWithoutHistoryStartWithoutImpulses) {
  Pairs pairs = resting();
  Rows before = pairs.run(scalar_kernels());
  before.manifold[0].normal_impulse[0] = 1.0f;
  before.manifold[0].friction_impulse[0] = 1.0f;
  before.manifold[0].twist_impulse = 1.0f;
  before.manifold[0].info = 0;  // it did not touch
  const Rows after = pairs.run(scalar_kernels(), &before);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(after.manifold[0].normal_impulse[k], 0.0f);
  EXPECT_EQ(after.manifold[0].friction_impulse[0], 0.0f);
  EXPECT_EQ(after.manifold[0].twist_impulse, 0.0f);
}

TEST(CollideManifold, FrictionCenterMovesContinuouslyWithTheSeparations) {
  // A box that tips until two of its corners leave: each small turn moves the center a little.
  reference::Vector last;
  bool first = true;
  int points = 4;
  for (float angle = 0.0f; angle < 0.06f; angle += 1e-4f) {
    Pairs pairs;
    pairs.add(box(5, 0.5f, 5), pose_row({0, 0, 0}), kCube, pose_row({0, 0.995f, 0}, turn({0, 0, 1}, angle)));
    const Manifold m = pairs.run(scalar_kernels()).manifold[0];
    ASSERT_GT(points_of(m), 0);
    const reference::Vector center = to_vector(m.arm_a);
    if (!first) {
      EXPECT_LT((center - last).norm(), 6e-3) << angle;
    }
    last = center;
    first = false;
    points = points_of(m);
  }
  EXPECT_EQ(points, 2);
  EXPECT_LT(last.x(), -0.45);
}

TEST(CollideManifold, AbsentPointsHaveNeitherPlaceNorImpulse) {
  Pairs pairs;
  pairs.add(sphere(0.5f), pose_row({0, 0, 0}), sphere(0.5f), pose_row({0.99f, 0, 0}));
  const Rows rows = pairs.run(scalar_kernels());
  ASSERT_EQ(points_of(rows.manifold[0]), 1);
  for (int k = 1; k < 4; ++k) {
    EXPECT_EQ(rows.manifold[0].separation[k], kAbsentSeparation);
    if (k != kCoreA && k != kCoreB) {
      EXPECT_EQ(rows.manifold[0].point_u[k], 0.0f);
    }
    if (k != kTwistArm) {
      EXPECT_EQ(rows.manifold[0].point_v[k], 0.0f);
    }
    EXPECT_EQ(rows.manifold[0].normal_impulse[k], 0.0f);
    EXPECT_EQ(rows.features[0].id[k], 0u);
  }
}

// How far a place is from a sphere's center or a capsule's segment.
double distance_from_core(const Pairs& pairs, std::size_t shape, const reference::Vector& place) {
  const PoseRow& pose = pairs.pose[shape];
  const Eigen::Quaterniond rotation(double(pose.rotation[3]), double(pose.rotation[0]),
                                    double(pose.rotation[1]), double(pose.rotation[2]));
  const reference::Vector local = rotation.conjugate() * (place - to_vector(pose.position));
  const reference::Vector half = to_vector(pairs.extent[shape].half);
  return (local - local.cwiseMax(-half).cwiseMin(half)).norm();
}

TEST(CollideManifold, CoresAreWhatTurnsWithTheBodies) {
  const std::pair<ShapeType, ShapeType> kinds[] = {{ShapeType::sphere, ShapeType::sphere},
                                                   {ShapeType::sphere, ShapeType::capsule},
                                                   {ShapeType::sphere, ShapeType::box},
                                                   {ShapeType::capsule, ShapeType::capsule},
                                                   {ShapeType::capsule, ShapeType::box}};
  int contacts = 0;
  for (const auto& [first, second] : kinds) {
    Pairs pairs = random_pairs(first, second, 200, 91, -0.02f, 0.01f);
    for (std::size_t row = 0; row < pairs.items.size(); row += 2) pairs.items[row].flags = simd::kItemFlip;
    const Rows rows = pairs.run(scalar_kernels());
    for (std::size_t row = 0; row < pairs.items.size(); ++row) {
      const Manifold& m = rows.manifold[row];
      if (points_of(m) == 0) continue;
      ++contacts;
      const simd::CollideItem& item = pairs.items[row];
      const bool flip = (item.flags & simd::kItemFlip) != 0;
      const std::size_t a = static_cast<std::size_t>(flip ? item.shape_2 : item.shape_1),
                        b = static_cast<std::size_t>(flip ? item.shape_1 : item.shape_2);
      const Frame frame = frame_of(m, pairs.pose[a]);
      const auto check = [&](std::size_t shape, float core, const reference::Vector& place) {
        if (pairs.type[shape] != ShapeType::box) {
          // Two points share the normal of the first one, as is_beside allows.
          const double radius = double(pairs.extent[shape].radius);
          const double most = points_of(m) == 1 ? 1e-4 : std::sqrt(double(kLinearSlop) * radius);
          EXPECT_LT(distance_from_core(pairs, shape, place), most) << "row " << row;
        } else if (points_of(m) == 1) {
          EXPECT_FLOAT_EQ(core, 0.5f * m.separation[0]) << "row " << row;
        }
      };
      check(a, m.point_u[kCoreA], frame.center - double(m.point_u[kCoreA]) * frame.normal);
      check(b, m.point_u[kCoreB], frame.center + double(m.point_u[kCoreB]) * frame.normal);
    }
  }
  EXPECT_GT(contacts, 500);
}

TEST(CollideManifold, ShapesAtOnePlaceGetAFiniteUnitNormal) {
  const Shape shapes[] = {sphere(0.5f), capsule(0.5f, 0.25f), box(0.5f, 0.4f, 0.3f)};
  Pairs pairs;
  for (const Shape& a : shapes) {
    for (const Shape& b : shapes) {
      for (const Quat q : {Quat{}, turn({0, 0, 1}, 1.5707963f), turn({1, 2, 3}, 1.0f)}) {
        pairs.add(a, pose_row({5, 6, 7}), b, pose_row({5, 6, 7}, q));
      }
    }
  }
  const Rows rows = pairs.run(scalar_kernels());
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    ASSERT_GT(points_of(rows.manifold[row]), 0);
    EXPECT_NEAR(to_vector(rows.manifold[row].normal).norm(), 1.0, 1e-5) << row;
    EXPECT_LT(deepest(rows.manifold[row]), -0.3f);
    EXPECT_TRUE(std::isfinite(to_vector(rows.manifold[row].arm_a).norm()));
  }
}

TEST(CollideManifold, ParallelCapsulesTouchAtBothEndsOfTheirCommonStretch) {
  Pairs pairs;
  pairs.add(capsule(1, 0.25f), pose_row({0, 0, 0}), capsule(1, 0.25f), pose_row({0.495f, 0.5f, 0}));
  const Manifold m = pairs.run(scalar_kernels()).manifold[0];
  ASSERT_EQ(points_of(m), 2);
  EXPECT_NEAR(m.arm_a[1], 0.25f, 1e-5f);
  EXPECT_NEAR(std::hypot(m.point_u[0] - m.point_u[1], m.point_v[0] - m.point_v[1]), 1.5f, 1e-5f);
}

TEST(CollideManifold, ACapsuleLyingOnABoxTouchesAtTwoPoints) {
  Random random(31);
  for (int k = 0; k < 200; ++k) {
    Pairs pairs;
    const Quat lying =
        turn({0, 1, 0}, random.uniform(0, 6)) * turn({0, 0, 1}, 1.5707963f + random.uniform(-1e-4f, 1e-4f));
    pairs.add(capsule(0.5f, 0.25f), pose_row({0.3f, 0.745f, 0}, normalize(lying)), box(5, 0.5f, 5),
              pose_row({0, 0, 0}));
    const Rows rows = pairs.run(scalar_kernels());
    ASSERT_EQ(points_of(rows.manifold[0]), 2);
    EXPECT_NEAR(rows.manifold[0].arm_a[0], 0.0f, 1e-2f);
    EXPECT_EQ(rows.features[0].id[0], 1u);
    EXPECT_EQ(rows.features[0].id[1], 2u);
  }
  // Beyond the border the friction center stays at the border.
  Pairs pairs;
  pairs.add(capsule(1, 0.25f), pose_row({5, 0.745f, 0}, turn({0, 0, 1}, 1.5707963f)), box(5, 0.5f, 5),
            pose_row({0, 0, 0}));
  const Manifold m = pairs.run(scalar_kernels()).manifold[0];
  ASSERT_EQ(points_of(m), 2);
  EXPECT_NEAR(m.arm_a[0], -0.5f, 1e-4f);
}

TEST(CollideManifold, ACapsuleAlongABoxEdgeTouchesAtTwoPoints) {
  Pairs pairs;
  const float reach = 0.5f + 0.245f * std::sqrt(0.5f);
  pairs.add(capsule(0.4f, 0.25f), pose_row({reach, 0.1f, reach}), box(0.5f, 0.5f, 0.5f), pose_row({0, 0, 0}));
  const Manifold m = pairs.run(scalar_kernels()).manifold[0];
  ASSERT_EQ(points_of(m), 2);
  EXPECT_NEAR(m.separation[0], -0.005f, 1e-4f);
  EXPECT_NEAR(m.separation[1], -0.005f, 1e-4f);
}

}  // namespace
}  // namespace scree::collide_tests
