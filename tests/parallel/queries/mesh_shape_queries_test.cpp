// Laws of casts, overlaps and distances against meshes: against brute force over all triangles, on one side
// or both, and between the kinds of calls.
#include <tests/parallel/queries/mesh_fixture.h>

namespace scree {
namespace {

using testing::Brute;
using testing::Dice;
using testing::Point;
using testing::to_point;
using testing::Triangle;
using testing::TriangleSoup;

constexpr double kPlaceError = 2e-5;  // m, by the rounding of the mesh's place

struct Ground {
  World world;
  TriangleSoup soup;
  BodyId body;
  ShapeId shape;
  std::vector<Triangle> triangles;

  Ground(TriangleSoup given, const Pose& pose) : soup(std::move(given)) {
    body = world.create_body({.type = BodyType::fixed, .position = pose.position, .rotation = pose.rotation});
    shape = world.add_shape(body, soup.mesh());
    triangles = testing::triangles_of(world, shape, soup);
  }
};

Ground random_ground(Dice& dice, int round) {
  const Pose pose{dice.within({20, 20, 20}), dice.rotation()};
  TriangleSoup soup = round % 3 == 0   ? testing::bumpy_ball(dice, 7, 10, 2.0f, 4.0f)
                      : round % 3 == 1 ? testing::random_soup(dice, 80, 4.0f, 1.5f)
                                       : testing::random_soup(dice, 300, 4.0f, 0.3f);
  return Ground(std::move(soup), pose);
}

// Whether the shape holds a point.
bool holds(const Geometry& geometry, const Pose& pose, Point point) {
  return testing::beyond(testing::placed_of(geometry, pose), point) <= 0.0;
}

double distance_of(const PlacedShape& placed, const Brute& brute, const Triangle& triangle,
                   Point shift = {}) {
  Pose moved = placed.pose;
  if (holds(placed.geometry, moved, triangle.corner[0] - shift)) return 0.0;
  return testing::distance_of(brute, triangle, shift);
}

TEST(MeshCasts, FindWhatBruteForceFinds) {
  Dice dice(21);
  int hits = 0, overlaps = 0;
  for (int round = 0; round < 6; ++round) {
    const Ground ground = random_ground(dice, round);
    const Vec3 middle = ground.world.pose(ground.body).position;
    for (int i = 0; i < 20; ++i) {
      const Geometry geometry = dice.plain_geometry(0.7f);
      // Some begin at a corner, where they overlap triangles.
      const Point corner = ground.triangles[dice.below(60)].corner[0];
      const Vec3 at_corner{static_cast<float>(corner.x), static_cast<float>(corner.y),
                           static_cast<float>(corner.z)};
      const Vec3 from = i % 5 == 0 ? at_corner : middle + dice.within({7, 7, 7});
      const Vec3 to = middle + dice.within({3, 3, 3});
      const ShapeCast cast{geometry, {from, dice.rotation()}, to - from};
      const std::optional<CastHit> hit = cast_shape(ground.world, cast);
      EXPECT_EQ(is_cast_blocked(ground.world, cast), hit.has_value());
      const Brute brute = testing::brute_of(cast.geometry, cast.pose);
      const double reach = testing::reach_of(brute, cast.pose);
      const PlacedShape placed{cast.geometry, cast.pose};
      const Point way = to_point(cast.translation);
      if (hit && hit->starts_inside) {
        ++overlaps;
        const Triangle& met = ground.triangles[static_cast<std::size_t>(hit->triangle)];
        EXPECT_LT(distance_of(placed, brute, met), kPlaceError);
        EXPECT_LT(dot(met.normal(), way), 1e-4);
        EXPECT_EQ(hit->fraction, 0.0f);
        EXPECT_EQ(hit->normal, Vec3{});
        continue;
      }
      // No triangle that counts is met before the hit, or at all.
      const double until = hit ? hit->fraction - 2 * kPlaceError / norm(way) : 1.0;
      for (const Triangle& triangle : ground.triangles) {
        const double inward = -dot(triangle.normal(), way) / norm(way);
        if (inward < 1e-3 || !(until > 0.0)) continue;
        if (testing::is_off_the_way(triangle, to_point(cast.pose.position), way, reach)) continue;
        const auto answer = testing::first_zero([&](double t) {
          return distance_of(placed, brute, triangle, (t * until) * way) - 0.5 * kPlaceError;
        });
        if (!answer) continue;
        // A shape that only grazes a triangle may miss it.
        EXPECT_LT(answer->depth, 0.6 * kPlaceError) << "misses a triangle, or meets it later";
        break;
      }
      if (!hit) continue;
      ++hits;
      ASSERT_GE(hit->triangle, 0);
      const Triangle& met = ground.triangles[static_cast<std::size_t>(hit->triangle)];
      EXPECT_LT(dot(met.normal(), way), 1e-4);
      EXPECT_NEAR(distance_of(placed, brute, met, double{hit->fraction} * way), 0.0, kPlaceError);
      EXPECT_LT(testing::distance_from(met, to_point(hit->point)), kPlaceError);
      EXPECT_NEAR(length(hit->normal), 1.0f, 1e-5f);
      EXPECT_LT(dot(hit->normal, cast.translation), 1e-4f);
      EXPECT_NEAR(hit->distance, hit->fraction * norm(way), 1e-5);
    }
  }
  EXPECT_GT(hits, 40);
  EXPECT_GT(overlaps, 10);
}

TEST(MeshCasts, RespectTheFront) {
  TriangleSoup floor;
  floor.vertices = {{-5, 0, -5}, {-5, 0, 5}, {5, 0, -5}, {5, 0, 5}};
  floor.triangles = {{0, 1, 2}, {2, 1, 3}};
  const Ground ground(floor, {});
  const QueryOptions both{.back_sides = true}, skip{.start_inside = StartInside::skip};
  for (const Geometry& shape :
       {Geometry{Sphere{0.5f}}, Geometry{Capsule{0.25f, 0.25f}}, Geometry{Box{{0.5f, 0.5f, 0.5f}}}}) {
    const auto cast = [&](float height, Vec3 way) { return ShapeCast{shape, {{1, height, 2}, {}}, way}; };
    const std::optional<CastHit> down = cast_shape(ground.world, cast(2, {0, -4, 0}));
    ASSERT_TRUE(down.has_value());
    EXPECT_NEAR(down->distance, 1.5f, 1e-6f);
    EXPECT_NEAR(down->normal.y, 1.0f, 1e-6f);
    EXPECT_GE(down->triangle, 0);
    // From behind it is not met, whether it begins there or overlaps the floor.
    EXPECT_FALSE(cast_shape(ground.world, cast(-2, {0, 4, 0})).has_value());
    EXPECT_FALSE(cast_shape(ground.world, cast(-0.25f, {0, 4, 0})).has_value());
    EXPECT_FALSE(cast_shape(ground.world, cast(0.25f, {0, 4, 0})).has_value());
    const std::optional<CastHit> up = cast_shape(ground.world, cast(-2, {0, 4, 0}), both);
    ASSERT_TRUE(up.has_value());
    EXPECT_NEAR(up->distance, 1.5f, 1e-6f);
    EXPECT_NEAR(up->normal.y, -1.0f, 1e-6f);
    EXPECT_TRUE(cast_shape(ground.world, cast(-0.25f, {0, 4, 0}), both)->starts_inside);
    // Overlapping it, moving inward, along it and not at all.
    for (const Vec3 way : {Vec3{0, -4, 0}, Vec3{4, 0, 0}, Vec3{}}) {
      const std::optional<CastHit> inside = cast_shape(ground.world, cast(0.25f, way));
      ASSERT_TRUE(inside.has_value());
      EXPECT_TRUE(inside->starts_inside);
      EXPECT_EQ(inside->fraction, 0.0f);
      EXPECT_EQ(inside->triangle, 1);
      EXPECT_FALSE(cast_shape(ground.world, cast(0.25f, way), skip).has_value());
    }
    // Without length and beside it.
    EXPECT_FALSE(cast_shape(ground.world, cast(2, {})).has_value());
    // Along it at a distance.
    EXPECT_FALSE(cast_shape(ground.world, cast(0.6f, {9, 0, 0})).has_value());
  }
}

TEST(MeshCasts, FromFarAwayMeetWhatTheyAimAt) {
  Dice dice(22);
  const Ground ground(testing::bumpy_ball(dice, 12, 20, 0.9f, 1.1f), {});
  for (const float far : {1e3f, 1e6f}) {
    for (int i = 0; i < 30; ++i) {
      const Vec3 way = normalize(dice.within({1, 1, 1}) + Vec3{0.01f, 0, 0});
      const std::optional<CastHit> hit =
          cast_shape(ground.world, {Sphere{0.5f}, {-far * way, {}}, (2.0f * far) * way});
      ASSERT_TRUE(hit.has_value());
      EXPECT_NEAR(hit->distance, far - 1.5f, 0.3f + 2e-7f * far);
    }
  }
}

TEST(MeshOverlaps, FindWhatBruteForceFinds) {
  Dice dice(23);
  int found = 0;
  for (int round = 0; round < 9; ++round) {
    const Ground ground = random_ground(dice, round);
    const Vec3 middle = ground.world.pose(ground.body).position;
    for (int i = 0; i < 60; ++i) {
      const Geometry geometry = dice.plain_geometry(i % 2 == 0 ? 0.4f : 1.5f);
      const PlacedShape placed{geometry, {middle + dice.within({5, 5, 5}), dice.rotation()}};
      const Brute brute = testing::brute_of(placed.geometry, placed.pose);
      const std::vector<OverlapHit> hits = overlap_shape(ground.world, placed);
      std::int32_t first = -1;      // that is touched for sure
      std::int32_t may_first = -1;  // or within rounding
      for (std::size_t t = 0; t < ground.triangles.size(); ++t) {
        const double distance = distance_of(placed, brute, ground.triangles[t]);
        if (may_first < 0 && distance < kPlaceError) may_first = static_cast<std::int32_t>(t);
        if (first < 0 && distance < (brute.faces.empty() ? -kPlaceError : 1e-12))
          first = static_cast<std::int32_t>(t);
      }
      if (hits.empty()) {
        EXPECT_TRUE(first < 0 || may_first < first) << "misses a triangle";
        continue;
      }
      ++found;
      ASSERT_EQ(hits.size(), 1u);
      EXPECT_EQ(hits[0].shape, ground.shape);
      EXPECT_GE(hits[0].triangle, may_first);
      ASSERT_GE(may_first, 0);
      EXPECT_LT(distance_of(placed, brute, ground.triangles[static_cast<std::size_t>(hits[0].triangle)]),
                kPlaceError);
      if (first >= 0 && first == may_first) {
        EXPECT_EQ(hits[0].triangle, first);
      }
    }
  }
  EXPECT_GT(found, 60);
}

TEST(MeshOverlaps, BoxesTouchSurfacesAndPointsDoNot) {
  Dice dice(24);
  const Ground ground(testing::bumpy_ball(dice, 8, 12, 2.0f, 2.0f), {});
  EXPECT_TRUE(overlap_box(ground.world, {{-1, -1, -1}, {1, 1, 1}}).empty()) << "within it is nothing";
  EXPECT_EQ(overlap_box(ground.world, {{-1, -1, -1}, {3, 1, 1}}).size(), 1u);
  EXPECT_EQ(overlap_box(ground.world, {{-3, -3, -3}, {3, 3, 3}}).size(), 1u);
  EXPECT_EQ(overlap_box(ground.world, {{-3, -3, -3}, {3, 3, 3}})[0].triangle, 0);
  EXPECT_TRUE(overlap_point(ground.world, {0, 0, 0}).empty());
  EXPECT_TRUE(overlap_point(ground.world, {0, 2, 0}).empty());
}

TEST(MeshDistances, FindWhatBruteForceFinds) {
  Dice dice(25);
  for (int round = 0; round < 9; ++round) {
    const Ground ground = random_ground(dice, round);
    const Vec3 middle = ground.world.pose(ground.body).position;
    for (int i = 0; i < 60; ++i) {
      const Geometry geometry = dice.plain_geometry(0.5f);
      const Vec3 place = middle + dice.within({9, 9, 9});
      const PlacedShape placed{geometry, {place, dice.rotation()}};
      const bool is_point = i % 2 == 0;
      Brute brute = testing::brute_of(placed.geometry, placed.pose);
      if (is_point) brute = {{}, to_point(place), to_point(place), 0.0};
      const std::optional<NearHit> hit = is_point ? closest_to_point(ground.world, place, 50.0f)
                                                  : closest_to_shape(ground.world, placed, 50.0f);
      double nearest = 1e300;
      for (const Triangle& triangle : ground.triangles) {
        const double distance =
            is_point ? testing::distance_of(brute, triangle) : distance_of(placed, brute, triangle);
        nearest = std::min(nearest, std::max(distance, 0.0));
      }
      ASSERT_TRUE(hit.has_value());
      EXPECT_NEAR(hit->distance, nearest, kPlaceError);
      ASSERT_GE(hit->triangle, 0);
      const Triangle& met = ground.triangles[static_cast<std::size_t>(hit->triangle)];
      EXPECT_NEAR(
          std::max(is_point ? testing::distance_of(brute, met) : distance_of(placed, brute, met), 0.0),
          nearest, 2 * kPlaceError);
      if (nearest > 1e-3) {
        EXPECT_LT(testing::distance_from(met, to_point(hit->point)), kPlaceError);
        EXPECT_NEAR(norm(to_point(hit->from) - to_point(hit->point)), nearest, 2 * kPlaceError);
        EXPECT_NEAR(length(hit->normal), 1.0f, 1e-5f);
      }
      // Limits.
      const auto within = static_cast<float>(nearest);
      if (nearest > 0.1) {
        EXPECT_FALSE(closest_to_shape(ground.world, {Sphere{0.05f}, {place, {}}}, 0.0f).has_value());
      }
      if (is_point) {
        EXPECT_EQ(near_point(ground.world, place, within + 0.01f).size(), 1u);
        if (within > 0.02f) {
          EXPECT_TRUE(near_point(ground.world, place, within - 0.01f).empty());
        }
      }
    }
  }
}

TEST(MeshShapes, BatchedQueriesEqualSingleOnesForEveryInstructionSet) {
  Dice dice(26);
  const Ground ground = random_ground(dice, 0);
  const Vec3 middle = ground.world.pose(ground.body).position;
  std::vector<ShapeCast> casts;
  std::vector<PlacedShape> shapes;
  std::vector<Vec3> points;
  for (int i = 0; i < 150; ++i) {
    shapes.push_back({dice.geometry(0.6f), {middle + dice.within({5, 5, 5}), dice.rotation()}});
    casts.push_back({shapes.back().geometry, shapes.back().pose, dice.within({8, 8, 8})});
    points.push_back(shapes.back().pose.position);
  }
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    Workers workers({.threads = 2, .isa = isa});
    std::vector<std::optional<CastHit>> hits(casts.size());
    std::vector<std::uint8_t> blocked(casts.size());
    std::vector<std::optional<NearHit>> near(casts.size()), near_points(casts.size());
    cast_shapes(ground.world, casts, hits, workers);
    are_casts_blocked(ground.world, casts, blocked, workers);
    closest_to_shapes(ground.world, shapes, 9.0f, near, workers);
    closest_to_points(ground.world, points, 9.0f, near_points, workers);
    const AnswerLists<OverlapHit> overlaps = overlap_shapes(ground.world, shapes, workers);
    const AnswerLists<CastHit> all = cast_shapes_all(ground.world, casts, workers);
    for (std::size_t i = 0; i < casts.size(); ++i) {
      EXPECT_EQ(hits[i], cast_shape(ground.world, casts[i]));
      EXPECT_EQ(blocked[i] != 0, hits[i].has_value());
      EXPECT_EQ(near[i], closest_to_shape(ground.world, shapes[i], 9.0f));
      EXPECT_EQ(near_points[i], closest_to_point(ground.world, points[i], 9.0f));
      EXPECT_EQ(std::vector<OverlapHit>(overlaps[i].begin(), overlaps[i].end()),
                overlap_shape(ground.world, shapes[i]));
      ASSERT_EQ(all[i].size(), hits[i] ? 1u : 0u);
      if (hits[i]) {
        EXPECT_EQ(all[i][0], *hits[i]);
      }
    }
  }
}

TEST(MeshShapes, CannotBeWhatAsks) {
  Dice dice(27);
  const Ground ground = random_ground(dice, 1);
  const TriangleMesh mesh = ground.soup.mesh();
  EXPECT_THROW(cast_shape(ground.world, {mesh, {}, {1, 0, 0}}), Error);
  EXPECT_THROW(overlap_shape(ground.world, {mesh, {}}), Error);
  EXPECT_THROW(closest_to_shape(ground.world, {mesh, {}}, 1.0f), Error);
}

}  // namespace
}  // namespace scree
