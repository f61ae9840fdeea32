// Laws of rays: against brute force, between the kinds of calls, and where rays are extreme.
#include <parallel/crew/crew.h>
#include <parallel/queries/ray_order.h>
#include <tests/parallel/queries/query_fixture.h>

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <span>

namespace scree {
namespace {

using testing::Dice;
using testing::MixedWorld;
using testing::Placed;
using testing::RayAnswer;

constexpr double kGraze = 2e-5;     // m; a ray that goes less deep may miss
constexpr double kRayError = 2e-5;  // m, of a hit's place, where the ray does not graze

// Compares all hits of a ray with those of brute force.
void expect_right_hits(const World& world, const std::vector<ShapeId>& shapes, const Ray& ray) {
  const std::vector<CastHit> hits = cast_ray_all(world, ray);
  std::map<ShapeId, CastHit> by_shape;
  for (const CastHit& hit : hits) by_shape[hit.shape] = hit;
  ASSERT_EQ(by_shape.size(), hits.size());
  const double size = length(ray.translation);
  for (const ShapeId shape : shapes) {
    const Placed placed = testing::placed_of(world, shape);
    const std::optional<RayAnswer> answer = testing::ray_answer(placed, ray);
    const auto found = by_shape.find(shape);
    if (!answer) {
      if (found == by_shape.end()) continue;
      const double gap = testing::beyond(placed, testing::to_point(found->second.point));
      EXPECT_LT(std::abs(gap), kGraze) << "of shape " << shape.index;
      continue;
    }
    if (found == by_shape.end()) {
      EXPECT_LT(answer->depth, kGraze) << "misses shape " << shape.index;
      continue;
    }
    const CastHit& hit = found->second;
    EXPECT_EQ(hit.body, world.body_of(shape));
    EXPECT_LT(std::abs(testing::beyond(placed, testing::to_point(hit.point))),
              answer->fraction > 0.0 ? kRayError : 1e9);
    EXPECT_NEAR(hit.distance, hit.fraction * size, 1e-5);
    if (answer->depth > 0.01) {
      EXPECT_NEAR(hit.distance, answer->fraction * size, 5e-4) << shape.index;
    }
    if (answer->fraction > 1e-5) {
      EXPECT_FALSE(hit.starts_inside);
      EXPECT_NEAR(length(hit.normal), 1.0f, 1e-5f);
      EXPECT_LE(dot(hit.normal, ray.translation), 1e-4f * static_cast<float>(size));
    }
  }
  EXPECT_EQ(by_shape.size(), hits.size());
}

std::vector<Ray> random_rays(Dice& dice, float reach, int count) {
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) rays.push_back(dice.ray(reach));
  return rays;
}

TEST(RayQueries, FindWhatBruteForceFindsInAWorldThatHasNotBeenStepped) {
  MixedWorld mixed(1);
  for (const Ray& ray : random_rays(mixed.dice, 9.0f, 60))
    expect_right_hits(mixed.world, mixed.all_shapes(), ray);
}

TEST(RayQueries, FindWhatBruteForceFindsAfterStepsAndAfterCallsBetweenThem) {
  MixedWorld mixed(2);
  for (int round = 0; round < 12; ++round) {
    mixed.step(round % 3 == 0 ? 7 : 1);
    expect_right_hits(mixed.world, mixed.all_shapes(), mixed.dice.ray(9.0f));
    for (int change = 0; change < 4; ++change) {
      mixed.change_something();
      const std::vector<ShapeId> shapes = mixed.all_shapes();
      for (int i = 0; i < 4; ++i) expect_right_hits(mixed.world, shapes, mixed.dice.ray(9.0f));
    }
  }
}

TEST(RayQueries, FindWhatBruteForceFindsInRestoredAndClonedWorlds) {
  MixedWorld mixed(3);
  mixed.step(20);
  mixed.change_something();
  Snapshot snapshot;
  save(mixed.world, snapshot);
  const std::vector<Ray> rays = random_rays(mixed.dice, 9.0f, 50);
  std::vector<std::vector<CastHit>> before;
  for (const Ray& ray : rays) before.push_back(cast_ray_all(mixed.world, ray));
  const World copy = clone(mixed.world);
  for (int i = 0; i < 10; ++i) mixed.change_something();
  mixed.step(3);
  for (const Ray& ray : rays) expect_right_hits(mixed.world, mixed.all_shapes(), ray);
  restore(mixed.world, snapshot);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(cast_ray_all(mixed.world, rays[i]), before[i]);
    EXPECT_EQ(cast_ray_all(copy, rays[i]), before[i]);
  }
}

TEST(RayQueries, ClosestHitIsTheFirstOfAllHits) {
  MixedWorld mixed(4);
  mixed.step(30);
  int hit_any = 0;
  for (const Ray& ray : random_rays(mixed.dice, 9.0f, 400)) {
    const std::vector<CastHit> all = cast_ray_all(mixed.world, ray);
    const std::optional<CastHit> first = cast_ray(mixed.world, ray);
    ASSERT_EQ(first.has_value(), !all.empty());
    EXPECT_EQ(is_blocked(mixed.world, ray), !all.empty());
    if (first) {
      EXPECT_EQ(*first, all[0]);
    }
    hit_any += first ? 1 : 0;
    for (std::size_t i = 1; i < all.size(); ++i) {
      EXPECT_LE(all[i - 1].fraction, all[i].fraction);
      if (all[i - 1].fraction == 0.0f && all[i].fraction == 0.0f) {
        EXPECT_LT(all[i - 1].shape.index, all[i].shape.index);
      }
    }
  }
  EXPECT_GT(hit_any, 100);
}

TEST(RayQueries, BatchedRaysEqualSingleOnesForEveryInstructionSetAndThreadCount) {
  MixedWorld mixed(5, 400, 12.0f);
  mixed.step(10);
  mixed.change_something();
  const std::vector<Ray> rays = random_rays(mixed.dice, 13.0f, 1000);
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    for (const int threads : {1, 2, 4}) {
      Workers workers({.threads = threads, .isa = isa});
      const World copy = clone(mixed.world);  // whose trees are made with this set
      std::vector<std::optional<CastHit>> hits(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      cast_rays(copy, rays, hits, workers);
      are_blocked(copy, rays, blocked, workers);
      const AnswerLists<CastHit> all = cast_rays_all(copy, rays, workers);
      ASSERT_EQ(all.size(), rays.size());
      for (std::size_t i = 0; i < rays.size(); ++i) {
        EXPECT_EQ(hits[i], cast_ray(mixed.world, rays[i]));
        EXPECT_EQ(blocked[i] != 0, is_blocked(mixed.world, rays[i]));
        const std::span<const CastHit> list = all[i];
        EXPECT_EQ(std::vector<CastHit>(list.begin(), list.end()), cast_ray_all(mixed.world, rays[i]));
      }
    }
  }
}

// m, on the mean, between where a ray and the one that is asked next enter a box of half the size.
double mean_leap(std::span<const Ray> rays, std::span<const std::int32_t> order, float half) {
  const auto entry = [&](std::size_t i) {
    const Ray& ray = rays[static_cast<std::size_t>(order[i])];
    float begin = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
      const float way = ray.translation[axis];
      if (way != 0.0f) begin = std::max(begin, ((way > 0.0f ? -half : half) - ray.origin[axis]) / way);
    }
    return ray.origin + std::min(begin, 1.0f) * ray.translation;
  };
  double sum = 0.0;
  for (std::size_t i = 1; i < order.size(); ++i) sum += static_cast<double>(distance(entry(i - 1), entry(i)));
  return sum / static_cast<double>(order.size() - 1);
}

// Grounds without end and bodies far away do not spoil that.
TEST(RayQueries, ManyAreAskedSideBySide) {
  for (const bool is_odd : {false, true}) {
    MixedWorld mixed(17, 300, 10.0f);
    if (is_odd) {
      mixed.world.add_shape(mixed.world.create_body({.type = BodyType::fixed, .position = {0, -90, 0}}),
                            HalfSpace{});
      mixed.world.add_shape(mixed.world.create_body({.position = {8e6f, 9e6f, -9e6f}}), Sphere{0.5f});
    }
    mixed.step(2);
    const std::vector<Ray> rays = random_rays(mixed.dice, 12.0f, 4000);
    Crew crew(mixed.workers);
    const QueryOptions options;
    const queries::Scope scope(internals(mixed.world), crew.kernels(), options);
    const std::vector<std::int32_t> order = queries::order_rays(scope, rays, crew);
    std::vector<std::int32_t> as_given(rays.size());
    std::iota(as_given.begin(), as_given.end(), 0);
    EXPECT_TRUE(std::is_permutation(order.begin(), order.end(), as_given.begin(), as_given.end()));
    EXPECT_LT(mean_leap(rays, order, 10.0f), 0.4 * mean_leap(rays, as_given, 10.0f)) << is_odd;
    EXPECT_TRUE(queries::order_rays(scope, std::span(rays).first(511), crew).empty());
  }
}

TEST(RayQueries, OfAnyNumberAreAnsweredInTheirPlaces) {
  for (const bool is_empty : {false, true}) {
    MixedWorld mixed(11, is_empty ? 0 : 100, 10.0f);
    if (!is_empty) {
      mixed.world.add_shape(mixed.world.create_body({.type = BodyType::fixed, .position = {0, -9, 0}}),
                            HalfSpace{});
      mixed.world.add_shape(mixed.world.create_body({.position = {8e6f, 9e6f, -9e6f}}), Sphere{0.5f});
    }
    mixed.step(2);
    for (const int count : {0, 1, 511, 512, 513, 3000}) {
      std::vector<Ray> rays = random_rays(mixed.dice, 12.0f, count);
      if (count > 10) {
        rays[3].translation = {};
        rays[4] = {{0, 0, 0}, {1e7f, 0, 0}};
        rays[5] = {{-9e6f, 3, 4}, {0, -1e-30f, 0}};
        rays[6] = rays[7];
      }
      std::vector<std::optional<CastHit>> hits(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      cast_rays(mixed.world, rays, hits, mixed.workers);
      are_blocked(mixed.world, rays, blocked, mixed.workers);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(hits[i], cast_ray(mixed.world, rays[i])) << count << ", ray " << i;
        ASSERT_EQ(blocked[i] != 0, hits[i].has_value()) << count << ", ray " << i;
      }
    }
  }
}

TEST(RayQueries, RaysHitWhatTheyDidBeforeTheEditUndone) {
  MixedWorld mixed(6);
  mixed.step(10);
  const std::vector<Ray> rays = random_rays(mixed.dice, 9.0f, 100);
  std::vector<std::vector<CastHit>> before;
  for (const Ray& ray : rays) before.push_back(cast_ray_all(mixed.world, ray));
  for (const BodyId body : mixed.bodies) {
    if (mixed.world.body_type(body) != BodyType::fixed) continue;
    const Pose pose = mixed.world.pose(body);
    mixed.world.set_pose(body, {pose.position + Vec3{0, 100, 0}, pose.rotation});
    cast_ray(mixed.world, rays[0]);
    mixed.world.set_pose(body, pose);
  }
  const BodyId extra = mixed.add_body();
  mixed.world.add_shape(extra, Sphere{2.0f});
  EXPECT_FALSE(cast_ray_all(mixed.world, {mixed.world.pose(extra).position, {}}).empty());
  mixed.world.destroy_body(extra);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::vector<CastHit> now = cast_ray_all(mixed.world, rays[i]);
    ASSERT_EQ(now.size(), before[i].size());
    for (std::size_t k = 0; k < now.size(); ++k) {
      EXPECT_EQ(now[k].shape, before[i][k].shape);
      EXPECT_NEAR(now[k].distance, before[i][k].distance, 1e-4f);
    }
  }
}

TEST(RayQueries, QueriesChangeNoStep) {
  MixedWorld asked(8), silent(8);
  for (int round = 0; round < 20; ++round) {
    for (MixedWorld* mixed : {&asked, &silent}) {
      mixed->step(1);
      mixed->change_something();
    }
    Dice dice(static_cast<std::uint64_t>(round));
    for (const Ray& ray : random_rays(dice, 9.0f, 5)) cast_ray(asked.world, ray);
    ASSERT_EQ(asked.world.hash(), silent.world.hash());
  }
}

TEST(RayQueries, LookOnlyAtWhatTheOptionsLet) {
  MixedWorld mixed(9);
  mixed.step(5);
  const World& world = mixed.world;
  for (const Ray& ray : random_rays(mixed.dice, 9.0f, 100)) {
    const std::vector<CastHit> all = cast_ray_all(world, ray);
    const auto expect_those = [&](const QueryOptions& options, auto&& counts) {
      std::vector<CastHit> left;
      for (const CastHit& hit : all) {
        if (counts(hit)) left.push_back(hit);
      }
      EXPECT_EQ(cast_ray_all(world, ray, options), left);
      EXPECT_EQ(is_blocked(world, ray, options), !left.empty());
    };
    expect_those({.filter = Filter{.category = 1, .mask = 5}},
                 [&](const CastHit& hit) { return (world.filter(hit.shape).category & 5u) != 0; });
    expect_those({.types = BodyTypes::fixed | BodyTypes::kinematic},
                 [&](const CastHit& hit) { return world.body_type(hit.body) != BodyType::dynamic; });
    expect_those({.predicate = [](ShapeId shape, BodyId) { return shape.index % 2 == 0; }},
                 [&](const CastHit& hit) { return hit.shape.index % 2 == 0; });
    expect_those({.start_inside = StartInside::skip}, [&](const CastHit& hit) { return !hit.starts_inside; });
    expect_those({.types = BodyTypes::none}, [&](const CastHit&) { return false; });
    if (!all.empty()) {
      expect_those({.ignored = all[0].body}, [&](const CastHit& hit) { return hit.body != all[0].body; });
    }
  }
}

TEST(RayQueries, AGroupOverrulesCategoriesAndMasks) {
  World world;
  const ShapeId shape = world.add_shape(world.create_body({}), Sphere{}, {}, {.filter = {1, 0, 3}});
  const Ray ray{{0, 5, 0}, {0, -10, 0}};
  EXPECT_TRUE(is_blocked(world, ray));
  EXPECT_FALSE(is_blocked(world, ray, {.filter = Filter{}}));
  EXPECT_TRUE(is_blocked(world, ray, {.filter = Filter{1, 1, 3}}));
  world.set_filter(shape, {1, ~0u, -3});
  EXPECT_TRUE(is_blocked(world, ray, {.filter = Filter{}}));
  EXPECT_FALSE(is_blocked(world, ray, {.filter = Filter{1, 1, -3}}));
}

TEST(RayQueries, WhatAPredicateThrowsComesOut) {
  MixedWorld mixed(10);
  const QueryOptions options{.predicate = [](ShapeId, BodyId) -> bool { throw 7; }};
  const Ray ray{{0, 20, 0}, {0, -40, 0}};
  EXPECT_THROW(cast_ray(mixed.world, ray, options), int);
  std::vector<Ray> rays(200, ray);
  std::vector<std::optional<CastHit>> hits(rays.size());
  EXPECT_THROW(cast_rays(mixed.world, rays, hits, mixed.workers, options), int);
  EXPECT_TRUE(is_blocked(mixed.world, ray));
}

// One shape in a world of its own.
struct Lone {
  explicit Lone(const Geometry& geometry, Vec3 position = {}, Quat rotation = {}) {
    const BodyId body =
        world.create_body({.type = BodyType::fixed, .position = position, .rotation = rotation});
    shape = world.add_shape(body, geometry);
  }
  std::optional<CastHit> cast(Vec3 origin, Vec3 translation) const {
    return cast_ray(world, {origin, translation});
  }
  World world;
  ShapeId shape;
};

TEST(RayQueries, MeetSimpleShapesWhereGeometrySays) {
  const auto sphere = Lone(Sphere{2.0f}).cast({10, 0, 0}, {-20, 0, 0});
  ASSERT_TRUE(sphere);
  EXPECT_FLOAT_EQ(sphere->fraction, 0.4f);
  EXPECT_FLOAT_EQ(sphere->distance, 8.0f);
  EXPECT_EQ(sphere->normal, (Vec3{1, 0, 0}));
  const auto end = Lone(Capsule{1.0f, 0.5f}).cast({0, 5, 0}, {0, -10, 0});
  ASSERT_TRUE(end);
  EXPECT_FLOAT_EQ(end->point.y, 1.5f);
  const auto side = Lone(Capsule{1.0f, 0.5f}).cast({5, 0.5f, 0}, {-10, 0, 0});
  ASSERT_TRUE(side);
  EXPECT_EQ(side->normal, (Vec3{1, 0, 0}));
  const auto box = Lone(Box{{1, 2, 3}}).cast({0.5f, 0.5f, 10}, {0, 0, -10});
  ASSERT_TRUE(box);
  EXPECT_EQ(box->face, 5);
  EXPECT_FLOAT_EQ(box->fraction, 0.7f);
  EXPECT_EQ(box->normal, (Vec3{0, 0, 1}));
  const std::vector<Vec3> corners{{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},
                                  {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1}};
  const Hull cube(corners);
  const auto hull = Lone(ConvexHull{cube, {1, 2, 3}}).cast({0.5f, 0.5f, 10}, {0, 0, -10});
  ASSERT_TRUE(hull);
  EXPECT_FLOAT_EQ(hull->fraction, 0.7f);
  EXPECT_NEAR(hull->normal.z, 1.0f, 1e-6f);
  for (const std::uint8_t corner : cube.face(static_cast<std::size_t>(hull->face))) {
    EXPECT_EQ(cube.vertices()[corner].z, 1.0f);
  }
}

TEST(RayQueries, ThatBeginInsideHitAtOnceUnlessSkipped) {
  const std::vector<Geometry> geometries{Sphere{1.0f}, Capsule{1.0f, 1.0f}, Box{{1, 1, 1}},
                                         ConvexHull{Dice::hull(0)}};
  for (const Geometry& geometry : geometries) {
    const Lone lone(geometry);
    const auto hit = lone.cast({0.1f, 0, 0}, {50, 0, 0});
    ASSERT_TRUE(hit);
    EXPECT_TRUE(hit->starts_inside);
    EXPECT_EQ(hit->fraction, 0.0f);
    EXPECT_EQ(hit->normal, (Vec3{}));
    EXPECT_EQ(hit->point, (Vec3{0.1f, 0, 0}));
    EXPECT_FALSE(cast_ray(lone.world, {{0.1f, 0, 0}, {50, 0, 0}}, {.start_inside = StartInside::skip}));
    EXPECT_TRUE(lone.cast({0.1f, 0, 0}, {}));  // no length
    EXPECT_FALSE(lone.cast({3, 0, 0}, {}));
    EXPECT_FALSE(lone.cast({3, 0, 0}, {1e-30f, 0, 0}));
    EXPECT_FALSE(lone.cast({3, 0, 0}, {-1e-42f, 0, 0}));
  }
}

TEST(RayQueries, MeetEdgesAndFacesThatTheyRunAlong) {
  const Lone lone(Box{{1, 1, 1}});
  EXPECT_TRUE(lone.cast({-5, 1, 0}, {10, 0, 0}));
  EXPECT_TRUE(lone.cast({-5, 1, 1}, {10, 0, 0}));
  EXPECT_TRUE(lone.cast({-5, 1, 1}, {4, 0, 0}));  // ends on the corner
  EXPECT_FALSE(lone.cast({-5, 1.000001f, 1}, {10, 0, 0}));
  EXPECT_FALSE(lone.cast({-5, 1, 1}, {3.9999f, 0, 0}));
  EXPECT_TRUE(lone.cast({2, 0, -1}, {-2, 2, 0}));  // an edge, where it comes and goes
}

TEST(RayQueries, ReachFarAndFindSmallThings) {
  // A sphere of 0.1 mm at the end of 100 km; the ray is exact along an axis.
  const Lone tiny(Sphere{1e-4f});
  const auto straight = tiny.cast({-1e5f, 0, 0}, {2e5f, 0, 0});
  ASSERT_TRUE(straight);
  EXPECT_NEAR(straight->point.x, -1e-4f, 1e-8f);
  EXPECT_NEAR(straight->normal.x, -1.0f, 1e-5f);
  EXPECT_TRUE(tiny.cast({-1e5f, 0.9e-4f, 0}, {2e5f, 0, 0}));
  EXPECT_FALSE(tiny.cast({-1e5f, 1.1e-4f, 0}, {2e5f, 0, 0}));
  EXPECT_TRUE(tiny.cast({-1e5f, -1e5f, 1e5f}, {2e5f, 2e5f, -2e5f}));
  const Lone thin(Capsule{1e5f, 1e-4f});
  EXPECT_TRUE(thin.cast({-1e5f, 77777, 0.9e-4f}, {2e5f, 0, 0}));
  EXPECT_FALSE(thin.cast({-1e5f, 77777, 1.1e-4f}, {2e5f, 0, 0}));
  EXPECT_TRUE(thin.cast({0, 1e6f, 0}, {0, -2e6f, 0}));
  // Far from the origin.
  const Lone far(Box{{1, 1, 1}}, {1e7f, 0, -1e7f});
  const auto hit = far.cast({1e7f, 1e5f, -1e7f}, {0, -2e5f, 0});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->point.y, 1.0f);
  EXPECT_FALSE(far.cast({1e7f - 2, 1e5f, -1e7f}, {0, -2e5f, 0}));
}

TEST(RayQueries, FindNeedlesFromEverySide) {
  const Lone needle(ConvexHull{Dice::hull(2), {25, 0.1f, 0.1f}});  // 100 m by 2 mm
  const std::vector<ShapeId> shapes{needle.shape};
  Dice dice(11);
  for (int i = 0; i < 300; ++i) {
    const Vec3 origin = dice.within({60, 1, 1});
    const Vec3 target = dice.within({50, 0.002f, 0.002f});
    expect_right_hits(needle.world, shapes, {origin, (target - origin) * 2.0f});
  }
}

TEST(RayQueries, RefuseWhatIsNoRay) {
  World world;
  Workers workers(1);
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (const float bad : {nan, inf, -inf, 2.1e7f}) {
    EXPECT_THROW(cast_ray(world, {{bad, 0, 0}, {}}), Error);
    EXPECT_THROW(is_blocked(world, {{0, bad, 0}, {}}), Error);
    EXPECT_THROW(cast_ray_all(world, {{}, {0, 0, bad}}), Error);
  }
  const std::vector<Ray> rays{{}, {{0, nan, 0}, {}}};
  std::vector<std::optional<CastHit>> hits(2);
  try {
    cast_rays(world, rays, hits, workers);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()),
              "cast_rays: ray 1: origin is nan, must lie in [-10000000, 10000000]");
  }
  hits.resize(1);
  const std::vector<Ray> good(2);
  EXPECT_THROW(cast_rays(world, good, hits, workers), Error);
  std::vector<std::uint8_t> blocked(3);
  EXPECT_THROW(are_blocked(world, good, blocked, workers), Error);
  EXPECT_THROW(cast_ray(world, {}, {.types = static_cast<BodyTypes>(8)}), Error);
  const BodyId dead = world.create_body({});
  world.destroy_body(dead);
  EXPECT_THROW(cast_ray(world, {}, {.ignored = dead}), Error);
  const World moved = std::move(world);
  EXPECT_THROW(cast_ray(world, {}), Error);
  EXPECT_FALSE(cast_ray(moved, {}));
}

}  // namespace
}  // namespace scree
