// Manifolds of smooth shapes where they are known, in degenerate poses, and on every instruction set.
#include <tests/simd/collide/smooth_fixture.h>
#include <tests/simd/same_bits.h>

#include <limits>

namespace scree::collide_tests::smooth {
namespace {

constexpr double kPi = 3.14159265358979;
const Quat kLying = turn({1, 0, 0}, float(0.5 * kPi));  // a shape's y axis along z

struct Point {
  Vector3d place;
  double separation;
};
// In the world.
std::vector<Point> points_of_row(const SmoothPairs& pairs, const Rows& rows, std::size_t row) {
  const Manifold& m = rows.manifold[row];
  const bool flip = (pairs.items[row].flags & simd::kItemFlip) != 0;
  const auto body = static_cast<std::size_t>(flip ? pairs.items[row].body_2 : pairs.items[row].body_1);
  const Frame frame = frame_of(m, pairs.pose[body]);
  std::vector<Point> points;
  for (int k = 0; k < rows.points[row]; ++k) points.push_back({point_of(m, frame, k), m.separation[k]});
  return points;
}

double largest_angle_gap(const std::vector<Point>& points, const Vector3d& center) {
  std::vector<double> angles;
  for (const Point& p : points) {
    const Vector3d way = p.place - center;
    angles.push_back(std::atan2(way.z(), way.x()));
  }
  std::sort(angles.begin(), angles.end());
  double most = angles.front() + 2 * kPi - angles.back();
  for (std::size_t k = 1; k < angles.size(); ++k) most = std::max(most, angles[k] - angles[k - 1]);
  return most;
}

// The upper shape of each stands on a ground whose surface is y = 0, as a box and as a half-space.
struct OnGround {
  SmoothPairs pairs;
  simd::CollideType type;
};
OnGround on_ground(const Solid& solid, const PoseRow& pose, bool half_space) {
  OnGround on{{}, half_space ? simd::kSmoothHalfSpace : simd::kSmooth};
  const Solid ground = half_space ? Solid{ShapeType::half_space, kHalfSpaceExtent} : solid_of(box(5, 1, 5));
  on.pairs.add(solid, pose, ground, pose_row({0, half_space ? 0.0f : -1.0f, 0}));
  return on;
}

TEST(CollideSmooth, AStandingCylinderHasFourSpreadPointsOnItsRim) {
  for (const bool half_space : {false, true}) {
    const auto [pairs, type] =
        on_ground(cylinder(0.3f, 0.5f), pose_row({1, 0.497f, 2}, turn({0, 1, 0}, 0.4f)), half_space);
    const Rows rows = pairs.run(scalar_kernels(), nullptr, type);
    const std::vector<Point> points = points_of_row(pairs, rows, 0);
    ASSERT_EQ(points.size(), 4u);
    for (const Point& p : points) {
      EXPECT_NEAR(std::hypot(p.place.x() - 1, p.place.z() - 2), 0.3, 1e-5);
      EXPECT_NEAR(p.separation, -0.003, 1e-6);
    }
    EXPECT_NEAR(largest_angle_gap(points, {1, 0, 2}), 0.5 * kPi, 1e-3);
    EXPECT_NEAR(rows.manifold[0].normal[1], -1.0f, 1e-6f);
  }
}

TEST(CollideSmooth, ATiltedCylinderHasTheLowestPointOfItsRim) {
  for (const bool half_space : {false, true}) {
    for (const double tilt : {0.01, 0.05, 0.2, 0.7, 0.85, 1.2}) {
      for (const double around : {0.0, 0.3, 2.0}) {
        const Quat rotation = turn({0, 1, 0}, float(around)) * turn({0, 0, 1}, float(tilt));
        const double lowest = 0.3 * std::sin(tilt) + 0.5 * std::cos(tilt);
        const auto [pairs, type] =
            on_ground(cylinder(0.3f, 0.5f), pose_row({0, float(lowest) - 0.004f, 0}, rotation), half_space);
        const Rows rows = pairs.run(scalar_kernels(), nullptr, type);
        const std::vector<Point> points = points_of_row(pairs, rows, 0);
        ASSERT_GE(points.size(), 1u);
        const auto deepest_point =
            std::min_element(points.begin(), points.end(),
                             [](const Point& a, const Point& b) { return a.separation < b.separation; });
        EXPECT_NEAR(deepest_point->separation, -0.004, 2e-6) << tilt;
        // Tilted about z, it stands on what was its -x side.
        const Vector3d local(-0.3 * std::cos(tilt) + 0.5 * std::sin(tilt), 0, 0);
        const Vector3d expected(local.x() * std::cos(around), 0, -local.x() * std::sin(around));
        EXPECT_NEAR(
            std::hypot(deepest_point->place.x() - expected.x(), deepest_point->place.z() - expected.z()), 0.0,
            2e-5)
            << tilt << " " << around;
      }
    }
  }
}

TEST(CollideSmooth, ALyingCylinderHasBothEndsOfItsLowestLine) {
  for (const bool half_space : {false, true}) {
    const auto [pairs, type] =
        on_ground(cylinder(0.2f, 0.6f), pose_row({0.5f, 0.195f, 0}, kLying), half_space);
    const Rows rows = pairs.run(scalar_kernels(), nullptr, type);
    const std::vector<Point> points = points_of_row(pairs, rows, 0);
    ASSERT_EQ(points.size(), 2u);
    for (const Point& p : points) {
      EXPECT_NEAR(p.place.x(), 0.5, 1e-6);
      EXPECT_NEAR(std::abs(p.place.z()), 0.6, 1e-6);
      EXPECT_NEAR(p.separation, -0.005, 1e-6);
    }
    EXPECT_LT(points[0].place.z() * points[1].place.z(), 0.0);
    // It turns with its axis, and the ground with its surface.
    const Manifold& m = rows.manifold[0];
    EXPECT_NEAR(m.point_u[kCoreA], 0.2f - 0.0025f, 1e-5f);
    EXPECT_NEAR(m.point_u[kCoreB], -0.0025f, 1e-5f);
    EXPECT_GT(m.point_v[kTwistArm], 0.0f);
  }
}

TEST(CollideSmooth, AConeOnItsSideHasItsApexAndARimPoint) {
  const double radius = 0.2, height = 0.6, half_angle = std::atan2(radius, height);
  for (const bool half_space : {false, true}) {
    const Quat rotation = turn({0, 0, 1}, float(0.5 * kPi + half_angle));
    const double middle = 0.5 * height * std::sin(half_angle);
    const auto [pairs, type] =
        on_ground(cone(0.2f, 0.3f), pose_row({0, float(middle) - 0.002f, 0}, rotation), half_space);
    const Rows rows = pairs.run(scalar_kernels(), nullptr, type);
    const std::vector<Point> points = points_of_row(pairs, rows, 0);
    ASSERT_EQ(points.size(), 2u);
    const double apex = -0.5 * height * std::cos(half_angle), rim = apex + std::hypot(radius, height);
    EXPECT_NEAR(std::min(points[0].place.x(), points[1].place.x()), apex, 1e-5);
    EXPECT_NEAR(std::max(points[0].place.x(), points[1].place.x()), rim, 1e-5);
    for (const Point& p : points) EXPECT_NEAR(p.separation, -0.002, 2e-6);
  }
}

TEST(CollideSmooth, AStandingConeHasFourPointsOnItsRim) {
  for (const bool half_space : {false, true}) {
    const auto [pairs, type] = on_ground(cone(0.3f, 0.4f), pose_row({0, 0.398f, 0}), half_space);
    const Rows rows = pairs.run(scalar_kernels(), nullptr, type);
    const std::vector<Point> points = points_of_row(pairs, rows, 0);
    ASSERT_EQ(points.size(), 4u);
    for (const Point& p : points) EXPECT_NEAR(std::hypot(p.place.x(), p.place.z()), 0.3, 1e-5);
    EXPECT_NEAR(largest_angle_gap(points, {0, 0, 0}), 0.5 * kPi, 1e-3);
  }
}

TEST(CollideSmooth, ARoundedBoxStandsOnTheCornersOfItsCore) {
  for (const bool half_space : {false, true}) {
    const auto [pairs, type] =
        on_ground(rounded_box(0.3f, 0.2f, 0.4f, 0.1f), pose_row({0, 0.299f, 0}), half_space);
    const Rows rows = pairs.run(scalar_kernels(), nullptr, type);
    const std::vector<Point> points = points_of_row(pairs, rows, 0);
    ASSERT_EQ(points.size(), 4u);
    for (const Point& p : points) {
      EXPECT_NEAR(std::abs(p.place.x()), 0.3, 1e-6);
      EXPECT_NEAR(std::abs(p.place.z()), 0.4, 1e-6);
      EXPECT_NEAR(p.separation, -0.001, 1e-6);
    }
  }
}

// Beyond a corner the normal of a rounded box is that of the ball around it.
TEST(CollideSmooth, RoundedCornersAreBalls) {
  SmoothPairs pairs;
  const Vector3d way = Vector3d(1, 2, 3).normalized();
  const Vector3d center = Vector3d(0.3, 0.2, 0.4) + (0.1 + 0.25 + 0.005) * way;
  pairs.add(rounded_box(0.3f, 0.2f, 0.4f, 0.1f), pose_row({}), solid_of(sphere(0.25f)),
            pose_row({float(center.x()), float(center.y()), float(center.z())}));
  const Rows rows = pairs.run(scalar_kernels());
  ASSERT_EQ(rows.points[0], 1);
  EXPECT_NEAR(normal_of(rows.manifold[0]).dot(way), 1.0, 1e-6);
  EXPECT_NEAR(rows.manifold[0].separation[0], 0.005, 1e-6);
}

TEST(CollideSmooth, TheOrderOfTheShapesDoesNotMatter) {
  for (int a = 4; a < kSmoothKinds; ++a) {
    for (int b = 0; b < kSmoothKinds; ++b) {
      const SmoothPairs pairs = random_smooth_pairs(a, b, 40, 900u + unsigned(8 * a + b), -0.1f, 0.02f);
      SmoothPairs swapped;
      for (std::size_t row = 0; row < pairs.items.size(); ++row) {
        swapped.add(pairs.solids[2 * row + 1], pairs.pose[2 * row + 1], pairs.solids[2 * row],
                    pairs.pose[2 * row]);
      }
      const Rows one = pairs.run(scalar_kernels()), two = swapped.run(scalar_kernels());
      for (std::size_t row = 0; row < pairs.items.size(); ++row) {
        if (one.points[row] == 0 && two.points[row] == 0) continue;
        ASSERT_NE(one.points[row] == 0, two.points[row] != 0) << kind_name(a) << " " << kind_name(b);
        EXPECT_NEAR(deepest(one.manifold[row]), deepest(two.manifold[row]), 6e-4f)
            << kind_name(a) << " " << kind_name(b) << " row " << row;
      }
    }
  }
}

// --- bits ---

SmoothPairs mixed_pairs() {
  SmoothPairs pairs;
  for (int a = 0; a < kSmoothKinds; ++a) {
    for (int b = 0; b < kSmoothKinds; ++b) {
      if (!is_smooth_kind(a) && !is_smooth_kind(b)) continue;
      const SmoothPairs more = random_smooth_pairs(a, b, 17, 300u + unsigned(8 * a + b), -0.2f, 0.06f);
      for (std::size_t row = 0; row < more.items.size(); ++row) {
        const std::int32_t flags = row % 3 == 1   ? simd::kItemFlip | simd::kItemStatic | simd::kItemFixed
                                   : row % 7 == 2 ? simd::kItemStatic
                                                  : 0;
        pairs.add(more.solids[2 * row], more.pose[2 * row], more.solids[2 * row + 1], more.pose[2 * row + 1],
                  flags);
      }
    }
  }
  Random random(12);
  pairs.dt = 1.0f / 60.0f;
  for (std::size_t s = 0; s < pairs.pose.size(); ++s) {
    for (float& v : pairs.velocity[s].linear) v = random.uniform(-3, 3);
    for (float& w : pairs.velocity[s].angular) w = random.uniform(-5, 5);
    if (s % 5 == 0) pairs.material[s].restitution = 0.5f;
    if (s % 7 == 0) pairs.material[s].rolling_resistance = 0.01f;
  }
  return pairs;
}

SmoothPairs jittered_pairs(float by) {
  SmoothPairs pairs = mixed_pairs();
  Random random(13);
  for (std::size_t s = 1; s < pairs.pose.size(); s += 2) {
    for (float& x : pairs.pose[s].position) x += random.uniform(-by, by);
  }
  return pairs;
}

TEST(CollideSmooth, EveryInstructionSetGivesTheBitsOfScalar) {
  const SmoothPairs first = mixed_pairs(), second = jittered_pairs(1e-3f);
  Rows before = first.run(scalar_kernels());
  fill_impulses(before);
  const Rows after = second.run(scalar_kernels(), &before);
  for (const simd::Kernels* kernels : all_kernels()) {
    Rows wide = first.run(*kernels);
    fill_impulses(wide);
    expect_same_bits(before, wide, kernels->name, 400);
    expect_same_bits(after, second.run(*kernels, &wide), kernels->name, 400);
  }
}

TEST(CollideSmooth, NeighborsInAChunkChangeNothing) {
  SmoothPairs pairs = mixed_pairs();
  const Rows expected = pairs.run(scalar_kernels());
  std::mt19937 engine(14);
  std::shuffle(pairs.items.begin(), pairs.items.end(), engine);
  for (const simd::Kernels* kernels : all_kernels()) {
    expect_same_bits(expected, pairs.run(*kernels), kernels->name, 400);
  }
}

TEST(CollideSmooth, NonFiniteShapesDoNotTouchAndChangeNoOtherPair) {
  SmoothPairs pairs = mixed_pairs();
  const Rows expected = pairs.run(scalar_kernels());
  for (std::size_t row = 0; row < pairs.items.size(); row += kSpoiledStride) {
    spoil(pairs.pose[static_cast<std::size_t>(pairs.items[row].shape_2)], row);
  }
  for (const simd::Kernels* kernels : all_kernels()) {
    expect_only_spoiled_to_part(expected, pairs.run(*kernels), kernels->name);
  }
}

// While a pair hardly moves, most of its points keep their names, so that impulses stay with them.
TEST(CollideSmooth, PointsKeepTheirNamesWhileShapesJitter) {
  const SmoothPairs first = mixed_pairs(), second = jittered_pairs(2e-5f);
  const Rows before = first.run(scalar_kernels());
  const Rows after = second.run(scalar_kernels(), &before);
  int points = 0, kept = 0;
  for (std::size_t row = 0; row < first.items.size(); ++row) {
    if (before.points[row] == 0 || after.points[row] == 0) continue;
    for (int k = 0; k < before.points[row]; ++k) {
      ++points;
      const auto& ids = after.features[row].id;
      kept += std::find(std::begin(ids), std::end(ids), before.features[row].id[k]) != std::end(ids) ? 1 : 0;
    }
  }
  EXPECT_GT(points, 800);
  EXPECT_GT(kept, points * 97 / 100);
}

// --- degenerate poses ---

void expect_sound(const SmoothPairs& pairs, const Rows& rows, const std::string& where) {
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    if (rows.points[row] == 0) continue;
    const Manifold& m = rows.manifold[row];
    ASSERT_NEAR(normal_of(m).norm(), 1.0, 1e-4) << where << " row " << row;
    for (int k = 0; k < rows.points[row]; ++k) {
      ASSERT_TRUE(std::isfinite(m.separation[k]) && std::isfinite(m.point_u[k]) &&
                  std::isfinite(m.point_v[k]))
          << where << " row " << row;
    }
    for (const float arm : m.arm_a) ASSERT_TRUE(std::isfinite(arm)) << where << " row " << row;
    for (const float value : m.point_u) ASSERT_TRUE(std::isfinite(value)) << where << " row " << row;
    for (const float value : m.point_v) ASSERT_TRUE(std::isfinite(value)) << where << " row " << row;
  }
}

std::vector<Solid> sample_solids(float size) {
  return {solid_of(sphere(size)),
          solid_of(capsule(size, 0.5f * size)),
          solid_of(box(size, size, size)),
          rounded_hull(hull_of(box_points(size, size, size)), 0.0f),
          rounded_hull(hull_of(box_points(size, 0.5f * size, size)), 0.1f * size),
          rounded_box(size, size, 0.5f * size, 0.1f * size),
          cylinder(size, size),
          cone(size, size)};
}

TEST(CollideSmooth, AlignedAndConcentricPosesAreSound) {
  const float s = 0.5f;
  const std::vector<Solid> solids = sample_solids(s);
  const std::vector<Quat> turns = {
      {}, turn({1, 0, 0}, float(0.5 * kPi)), turn({0, 0, 1}, float(kPi)), turn({1, 1, 1}, 1.0f)};
  const std::vector<Vec3> places = {
      {0, 0, 0}, {0, s, 0},     {0, 2 * s, 0},  {2 * s, 0, 0}, {s, 0, 0},
      {s, s, s}, {2 * s, s, 0}, {0, -2 * s, 0}, {1e-7f, 0, 0}, {2 * s, 2 * s, 2 * s}};
  SmoothPairs pairs;
  std::vector<double> truth;
  for (const Solid& a : solids) {
    for (const Solid& b : solids) {
      if (a.type < ShapeType::rounded_box && b.type < ShapeType::rounded_box) continue;
      for (const Quat& q : turns) {
        for (const Vec3& p : places) pairs.add(a, pose_row({}), b, pose_row(p, q));
      }
    }
  }
  const Rows rows = pairs.run(scalar_kernels());
  expect_sound(pairs, rows, "aligned");
  const Rows again = pairs.run(scalar_kernels(), &rows);
  expect_sound(pairs, again, "aligned again");
  for (std::size_t row = 0; row < pairs.items.size(); row += 31) {
    const Placed a = pairs.solid(row, 0), b = pairs.solid(row, 1);
    const TrueGap gap = true_gap(a, b);
    if (gap.separation > 0.019) continue;
    ASSERT_GE(rows.points[row], 1) << row << " gap " << gap.separation;
    EXPECT_GE(gap_along(a, b, normal_of(rows.manifold[row]).normalized()), gap.separation - 1e-4) << row;
  }
}

TEST(CollideSmooth, TinyHugeAndSlenderShapesAreSound) {
  Random random(77);
  SmoothPairs pairs;
  std::vector<Solid> solids;
  for (const float size : {1e-4f, 1e-2f, 1.0f, 1e3f, 1e5f}) {
    const std::vector<Solid> more = sample_solids(size);
    solids.insert(solids.end(), more.begin() + 5, more.end());
    solids.push_back(more[0]);
    solids.push_back(more[2]);
  }
  for (const float length : {1.0f, 1e3f}) {
    solids.push_back(cylinder(1e-4f, length));
    solids.push_back(cylinder(length, 1e-4f));
    solids.push_back(cone(1e-4f, length));
    solids.push_back(cone(length, 1e-4f));
    solids.push_back(rounded_box(1e-4f, length, 1e-4f, 1e-4f));
  }
  for (const Solid& a : solids) {
    for (const Solid& b : solids) {
      if (a.type < ShapeType::rounded_box && b.type < ShapeType::rounded_box) continue;
      const float reach = std::min(a.extent.half[0] + a.extent.half[1] + a.extent.radius,
                                   b.extent.half[0] + b.extent.half[1] + b.extent.radius);
      pairs.add(a, pose_row({}, random.rotation()), b,
                pose_row(0.5f * reach * random.unit(), random.rotation()));
      pairs.add(a, pose_row({}), b, pose_row(0.3f * reach * random.unit()));
    }
  }
  const Rows rows = pairs.run(scalar_kernels());
  expect_sound(pairs, rows, "sizes");
  expect_sound(pairs, pairs.run(scalar_kernels(), &rows), "sizes again");
}

// A deep overlap keeps its direction while it is about as good as any other.
TEST(CollideSmooth, DeepContactsDoNotFlicker) {
  SmoothPairs pairs;
  pairs.add(cylinder(0.3f, 0.3f), pose_row({}), solid_of(box(0.3f, 0.3f, 0.3f)), pose_row({0.2f, 0.2f, 0}));
  Rows rows = pairs.run(scalar_kernels());
  const Vector3d first = normal_of(rows.manifold[0]);
  Random random(3);
  for (int step = 0; step < 100; ++step) {
    pairs.pose[1] = pose_row({0.2f + random.uniform(-5e-3f, 5e-3f), 0.2f + random.uniform(-5e-3f, 5e-3f), 0},
                             turn(random.vector(), random.uniform(0, 1e-2f)));
    rows = pairs.run(scalar_kernels(), &rows);
    ASSERT_GT(normal_of(rows.manifold[0]).dot(first), 0.99) << step;
  }
}

}  // namespace
}  // namespace scree::collide_tests::smooth
