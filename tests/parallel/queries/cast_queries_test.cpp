// Laws of casts. A plane that the moving shape and the one it meets both touch, from either side, and a point
// of both prove where they meet; that the moving shape comes towards the plane proves that it is the first
// such place.
#include <tests/parallel/queries/query_fixture.h>

#include <limits>
#include <set>

namespace scree {
namespace {

using testing::apart_along;
using testing::beyond;
using testing::Dice;
using testing::MixedWorld;
using testing::Placed;
using testing::Point;
using testing::to_point;

constexpr double kError = 2e-5;  // m, of floats and of poses in single precision

ShapeCast random_cast(MixedWorld& mixed) {
  const PlacedShape placed = mixed.placed_shape();
  const Vec3 end = mixed.dice.within({mixed.reach, mixed.reach, mixed.reach});
  return {placed.geometry, placed.pose, end - placed.pose.position};
}

Placed moved(const ShapeCast& cast, double fraction) {
  Placed placed = testing::placed_of(cast.geometry, cast.pose);
  placed.position = placed.position + fraction * to_point(cast.translation);
  return placed;
}

void expect_contact(const ShapeCast& cast, const Placed& shape, const CastHit& hit) {
  const Point normal = to_point(hit.normal), point = to_point(hit.point);
  const double size = testing::norm(to_point(cast.translation));
  const Placed there = moved(cast, hit.distance / size);
  EXPECT_NEAR(testing::norm(normal), 1.0, 1e-5);
  EXPECT_LE(testing::dot(normal, to_point(cast.translation)), 1e-5 * size);
  EXPECT_NEAR(apart_along(there, shape, -1.0 * normal), 0.0, 5 * kError);
  EXPECT_LT(beyond(shape, point), kError);
  EXPECT_LT(beyond(there, point), 5 * kError);
}

TEST(CastQueries, AreProvedByAPlaneBetween) {
  MixedWorld mixed(31, 100, 6.0f);
  mixed.step(4);
  int contacts = 0, passed = 0;
  for (int round = 0; round < 80; ++round) {
    if (round % 4 == 0) mixed.change_something();
    const ShapeCast cast = random_cast(mixed);
    std::set<ShapeId> met;
    for (const CastHit& hit : cast_shape_all(mixed.world, cast)) {
      met.insert(hit.shape);
      EXPECT_EQ(hit.body, mixed.world.body_of(hit.shape));
      if (hit.starts_inside) {
        EXPECT_EQ(hit.fraction, 0.0f);
        continue;
      }
      expect_contact(cast, testing::placed_of(mixed.world, hit.shape), hit);
      ++contacts;
    }
    // What it passes by is apart all along.
    for (const double fraction : {0.0, 0.13, 0.31, 0.5, 0.66, 0.87, 1.0}) {
      PlacedShape there{cast.geometry, cast.pose};
      there.pose.position = cast.pose.position + static_cast<float>(fraction) * cast.translation;
      for (const OverlapHit& hit : overlap_shape(mixed.world, there)) {
        EXPECT_EQ(met.count(hit.shape), 1u) << fraction;
        ++passed;
      }
    }
  }
  EXPECT_GT(contacts, 200);
  EXPECT_GT(passed, 100);
}

TEST(CastQueries, ClosestHitIsTheFirstOfAllHits) {
  MixedWorld mixed(32);
  mixed.step(4);
  for (int i = 0; i < 200; ++i) {
    const ShapeCast cast = random_cast(mixed);
    for (const StartInside inside : {StartInside::hit, StartInside::skip}) {
      const QueryOptions options{.start_inside = inside};
      const std::vector<CastHit> all = cast_shape_all(mixed.world, cast, options);
      const std::optional<CastHit> first = cast_shape(mixed.world, cast, options);
      ASSERT_EQ(first.has_value(), !all.empty());
      EXPECT_EQ(is_cast_blocked(mixed.world, cast, options), !all.empty());
      if (first) {
        EXPECT_EQ(*first, all[0]);
      }
    }
  }
}

TEST(CastQueries, ManyEqualSingleOnesForEveryInstructionSetAndThreadCount) {
  MixedWorld mixed(33, 300, 10.0f);
  mixed.step(6);
  mixed.change_something();
  std::vector<ShapeCast> casts;
  for (int i = 0; i < 200; ++i) casts.push_back(random_cast(mixed));
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    Workers workers({.threads = isa == Isa::sse2 ? 1 : 3, .isa = isa});
    const World copy = clone(mixed.world);
    std::vector<std::optional<CastHit>> hits(casts.size());
    std::vector<std::uint8_t> blocked(casts.size());
    cast_shapes(copy, casts, hits, workers);
    are_casts_blocked(copy, casts, blocked, workers);
    const AnswerLists<CastHit> all = cast_shapes_all(copy, casts, workers);
    for (std::size_t i = 0; i < casts.size(); ++i) {
      EXPECT_EQ(hits[i], cast_shape(mixed.world, casts[i]));
      EXPECT_EQ(blocked[i] != 0, is_cast_blocked(mixed.world, casts[i]));
      EXPECT_EQ(std::vector(all[i].begin(), all[i].end()), cast_shape_all(mixed.world, casts[i]));
    }
  }
}

TEST(CastQueries, MeetSimpleShapesWhereGeometrySays) {
  World world;
  world.add_shape(world.create_body({.type = BodyType::fixed}), Box{{1, 1, 1}});
  const auto ball = cast_shape(world, {Sphere{0.5f}, {{0, 11.5f, 0}, {}}, {0, -20, 0}});
  ASSERT_TRUE(ball);
  EXPECT_FLOAT_EQ(ball->fraction, 0.5f);
  EXPECT_FLOAT_EQ(ball->distance, 10.0f);
  EXPECT_NEAR(ball->point.y, 1.0f, 1e-6f);
  EXPECT_EQ(ball->normal, (Vec3{0, 1, 0}));
  const auto box = cast_shape(world, {Box{{1, 1, 1}}, {{-5, 0.5f, 0}, {}}, {8, 0, 0}});
  ASSERT_TRUE(box);
  EXPECT_NEAR(box->fraction, 3.0f / 8.0f, 1e-7f);
  EXPECT_NEAR(box->normal.x, -1.0f, 1e-6f);
  EXPECT_FALSE(cast_shape(world, {Box{{1, 1, 1}}, {{-5, 2.001f, 0}, {}}, {8, 0, 0}}));
  EXPECT_FALSE(cast_shape(world, {Sphere{0.5f}, {{0, 5, 0}, {}}, {0, -3.4f, 0}}));
  EXPECT_FALSE(cast_shape(world, {Sphere{0.5f}, {{0, 5, 0}, {}}, {0, 3.4f, 0}}));
  EXPECT_FALSE(cast_shape(world, {Sphere{0.5f}, {{0, 5, 0}, {}}, {}}));
}

TEST(CastQueries, ReachFarWithSmallShapes) {
  World world;
  world.add_shape(world.create_body({.type = BodyType::fixed, .position = {5e6f, 0, 0}}),
                  Capsule{1e4f, 1e-4f});
  const auto hit = cast_shape(world, {Sphere{1e-4f}, {{5e6f, 1234, 1e5f}, {}}, {0, 0, -2e5f}});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->normal.z, 1.0f, 1e-3f);
  EXPECT_NEAR(hit->point.z, 1e-4f, 1e-6f);
  EXPECT_FALSE(cast_shape(world, {Sphere{1e-4f}, {{5e6f + 0.5f, 1234, 1e5f}, {}}, {0, 0, -2e5f}}));
}

TEST(CastQueries, RefuseWhatIsNoCast) {
  World world;
  Workers workers(1);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(cast_shape(world, {Sphere{nan}, {}, {}}), Error);
  EXPECT_THROW(cast_shape(world, {ConvexHull{}, {}, {}}), Error);
  EXPECT_THROW(cast_shape_all(world, {Sphere{}, {{nan, 0, 0}, {}}, {}}), Error);
  EXPECT_THROW(is_cast_blocked(world, {Sphere{}, {}, {0, nan, 0}}), Error);
  EXPECT_THROW(cast_shape(world, {Sphere{}, {}, {0, 3e7f, 0}}), Error);
  EXPECT_THROW(cast_shape(world, {Sphere{}, {{}, {0, 0, 0, 2}}, {}}), Error);
  const std::vector<ShapeCast> casts(2);
  std::vector<std::optional<CastHit>> hits(3);
  EXPECT_THROW(cast_shapes(world, casts, hits, workers), Error);
  std::vector<std::uint8_t> blocked(1);
  EXPECT_THROW(are_casts_blocked(world, casts, blocked, workers), Error);
}

}  // namespace
}  // namespace scree
