// Laws of distances and overlaps. A pair of nearest points and a plane between the shapes that is as far from
// both prove a distance; a point that two shapes share proves that they overlap.
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

constexpr double kDistanceError = 2e-5;  // m, of floats and of poses in single precision

Placed asking_of(const PlacedShape& shape) { return testing::placed_of(shape.geometry, shape.pose); }

// Whether two shapes have come as near as `most` somewhere: the largest of the convex functions `beyond` of
// both at the best of many points, each found by a random search that narrows.
bool nearly_share_a_point(const Placed& a, const Placed& b, double most) {
  Dice dice(77);
  const auto depth = [&](Point p) { return std::max(beyond(a, p), beyond(b, p)); };
  Point best = 0.5 * (a.position + b.position);
  for (const Point start : {a.position, b.position}) {
    if (depth(start) < depth(best)) best = start;
  }
  double step = 2.0;
  for (int i = 0; i < 20000 && depth(best) > most; ++i) {
    const Point next = best + step * to_point(dice.within({1, 1, 1}));
    if (depth(next) < depth(best)) {
      best = next;
      step *= 1.5;
    } else {
      step = std::max(0.99 * step, 1e-6);
    }
  }
  return depth(best) <= most;
}

void expect_nearest_points(const Placed& asking, const Placed& shape, const NearHit& hit) {
  const Point normal = to_point(hit.normal), from = to_point(hit.from), point = to_point(hit.point);
  EXPECT_NEAR(testing::norm(normal), 1.0, 1e-5);
  EXPECT_NEAR(testing::norm(from - point), hit.distance, kDistanceError);
  EXPECT_LT(beyond(asking, from), kDistanceError);
  EXPECT_LT(beyond(shape, point), kDistanceError);
  EXPECT_GT(apart_along(asking, shape, -1.0 * normal), hit.distance - 5 * kDistanceError);
}

TEST(DistanceQueries, AreProvedByNearestPointsAndAPlaneBetween) {
  MixedWorld mixed(21, 100, 5.0f);
  mixed.step(4);
  for (int round = 0; round < 25; ++round) {
    mixed.change_something();
    const PlacedShape asked = mixed.placed_shape();
    const Placed asking = asking_of(asked);
    const std::vector<NearHit> near = near_shape(mixed.world, asked, 1.5f);
    std::set<ShapeId> found;
    for (std::size_t i = 0; i < near.size(); ++i) {
      const NearHit& hit = near[i];
      found.insert(hit.shape);
      const Placed shape = testing::placed_of(mixed.world, hit.shape);
      EXPECT_EQ(hit.body, mixed.world.body_of(hit.shape));
      if (hit.distance > 0.0f) {
        expect_nearest_points(asking, shape, hit);
      } else {
        EXPECT_TRUE(nearly_share_a_point(asking, shape, 1e-3)) << round;
      }
      if (i > 0) {
        EXPECT_LE(near[i - 1].distance, hit.distance);
      }
    }
    EXPECT_EQ(found.size(), near.size());
    const std::vector<NearHit> farther = near_shape(mixed.world, asked, 1000.0f);
    EXPECT_EQ(farther.size(), mixed.world.shape_count());
    for (std::size_t i = 0; i < farther.size(); ++i) {
      if (i < near.size()) {
        EXPECT_EQ(farther[i], near[i]);
        continue;
      }
      EXPECT_GT(farther[i].distance, 1.5f);
      expect_nearest_points(asking, testing::placed_of(mixed.world, farther[i].shape), farther[i]);
    }
  }
}

TEST(DistanceQueries, TheClosestIsTheFirstOfAllThatAreNear) {
  MixedWorld mixed(22);
  mixed.step(4);
  for (int i = 0; i < 100; ++i) {
    const PlacedShape asked = mixed.placed_shape();
    for (const float most : {0.0f, 0.3f, 2.0f}) {
      const std::vector<NearHit> shapes = near_shape(mixed.world, asked, most);
      const std::optional<NearHit> shape = closest_to_shape(mixed.world, asked, most);
      ASSERT_EQ(shape.has_value(), !shapes.empty());
      if (shape) {
        EXPECT_EQ(*shape, shapes[0]);
      }
      const std::vector<NearHit> points = near_point(mixed.world, asked.pose.position, most);
      const std::optional<NearHit> point = closest_to_point(mixed.world, asked.pose.position, most);
      ASSERT_EQ(point.has_value(), !points.empty());
      if (point) {
        EXPECT_EQ(*point, points[0]);
      }
    }
  }
}

TEST(DistanceQueries, PointsAreAsFarAsGeometrySays) {
  World world;
  const BodyId body = world.create_body({.type = BodyType::fixed, .position = {10, 0, 0}});
  world.add_shape(body, Box{{1, 2, 3}});
  const auto corner = closest_to_point(world, {8, 4, 6}, 10.0f);
  ASSERT_TRUE(corner);
  EXPECT_FLOAT_EQ(corner->distance, std::sqrt(1.0f + 4.0f + 9.0f));
  EXPECT_EQ(corner->point, (Vec3{9, 2, 3}));
  EXPECT_EQ(corner->from, (Vec3{8, 4, 6}));
  EXPECT_FALSE(closest_to_point(world, {8, 4, 6}, 3.7f));
  const auto inside = closest_to_point(world, {10.5f, 0, 0}, 0.0f);
  ASSERT_TRUE(inside);
  EXPECT_EQ(inside->distance, 0.0f);
  EXPECT_EQ(inside->normal, (Vec3{}));
  const auto face = closest_to_point(world, {10.5f, 2.25f, 0}, 1.0f);
  ASSERT_TRUE(face);
  EXPECT_EQ(face->distance, 0.25f);
  EXPECT_EQ(face->normal, (Vec3{0, 1, 0}));
}

TEST(DistanceQueries, OverlapsAreThoseAtNoDistance) {
  MixedWorld mixed(23);
  mixed.step(4);
  mixed.change_something();
  std::size_t hits = 0;
  for (int i = 0; i < 200; ++i) {
    const PlacedShape asked = mixed.placed_shape();
    std::vector<OverlapHit> near;
    for (const NearHit& hit : near_shape(mixed.world, asked, 0.0f)) near.push_back({hit.shape, hit.body});
    EXPECT_EQ(overlap_shape(mixed.world, asked), near);
    hits += near.size();
    std::vector<OverlapHit> at_start;
    for (const CastHit& hit : cast_shape_all(mixed.world, {asked.geometry, asked.pose, {}})) {
      EXPECT_TRUE(hit.starts_inside);
      at_start.push_back({hit.shape, hit.body});
    }
    EXPECT_EQ(at_start, near);
  }
  EXPECT_GT(hits, 30u);
}

TEST(OverlapQueries, PointsLieInTheShapesThatHoldThem) {
  MixedWorld mixed(24, 200, 5.0f);
  mixed.step(4);
  const std::vector<ShapeId> shapes = mixed.all_shapes();
  std::size_t held = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 point = mixed.dice.within({5, 5, 5});
    std::set<ShapeId> found;
    for (const OverlapHit& hit : overlap_point(mixed.world, point)) found.insert(hit.shape);
    held += found.size();
    for (const ShapeId shape : shapes) {
      const double outside = beyond(testing::placed_of(mixed.world, shape), to_point(point));
      if (std::abs(outside) < kDistanceError) continue;
      EXPECT_EQ(found.count(shape), outside < 0.0 ? 1u : 0u);
    }
  }
  EXPECT_GT(held, 30u);
}

TEST(OverlapQueries, ABoxMeetsWhatABoxShapeMeets) {
  MixedWorld mixed(25);
  mixed.step(4);
  for (int i = 0; i < 200; ++i) {
    const Vec3 middle = mixed.dice.within({8, 8, 8});
    const Vec3 half = Vec3{0.76f, 0.76f, 0.76f} + mixed.dice.within({0.75f, 0.75f, 0.75f});
    const AxisBox box{middle - half, middle + half};
    std::vector<OverlapHit> same = overlap_shape(mixed.world, {Box{half}, {middle, {}}});
    const std::vector<OverlapHit> found = overlap_box(mixed.world, box);
    EXPECT_EQ(found, same);
  }
  EXPECT_EQ(overlap_box(mixed.world, {{-1e7f, -1e7f, -1e7f}, {1e7f, 1e7f, 1e7f}}).size(),
            mixed.world.shape_count());
}

TEST(OverlapQueries, SurfacesThatTouchOverlap) {
  World world;
  world.add_shape(world.create_body({.type = BodyType::fixed}), Box{{1, 1, 1}});
  const float above = std::nextafter(1.0f, 2.0f);
  EXPECT_EQ(overlap_box(world, {{1, 1, 1}, {2, 2, 2}}).size(), 1u);
  EXPECT_EQ(overlap_box(world, {{above, 0, 0}, {2, 2, 2}}).size(), 0u);
  EXPECT_EQ(overlap_box(world, {{0, 0, 0}, {0, 0, 0}}).size(), 1u);
  EXPECT_EQ(overlap_point(world, {1, 1, -1}).size(), 1u);
  EXPECT_EQ(overlap_point(world, {1, above, -1}).size(), 0u);
  EXPECT_EQ(overlap_shape(world, {Sphere{1.0f}, {{0, 2, 0}, {}}}).size(), 1u);
  EXPECT_EQ(overlap_shape(world, {Sphere{1.0f}, {{0, 2.000001f, 0}, {}}}).size(), 0u);
}

TEST(DistanceQueries, HoldForTheLargestAndTheSmallestShapes) {
  World world;
  const BodyId body = world.create_body({.type = BodyType::fixed});
  world.add_shape(body, Box{{1e5f, 1.0f, 1e5f}});
  const auto speck = closest_to_shape(world, {Sphere{1e-4f}, {{77777, 1.5f, -4321}, {}}}, 1.0f);
  ASSERT_TRUE(speck);
  EXPECT_NEAR(speck->distance, 0.4999f, 1e-6f);
  EXPECT_EQ(speck->normal, (Vec3{0, 1, 0}));
  const auto far = closest_to_shape(world, {Sphere{1e-4f}, {{0, 1e7f, 0}, {}}}, 1e8f);
  ASSERT_TRUE(far);
  EXPECT_FLOAT_EQ(far->distance, 1e7f - 1.0f);
  const ConvexHull needle{Dice::hull(2), {1000, 0.01f, 0.01f}};
  const PlacedShape above{needle, {{0, 2, 0}, from_axis_angle({0, 1, 0}, 0.3f)}};
  const auto near = closest_to_shape(world, above, 10.0f);
  ASSERT_TRUE(near);
  EXPECT_NEAR(near->distance, 1.0f, 1e-6f);
}

TEST(DistanceQueries, ManyEqualSingleOnesForEveryInstructionSetAndThreadCount) {
  MixedWorld mixed(26, 300, 10.0f);
  mixed.step(6);
  mixed.change_something();
  std::vector<PlacedShape> shapes;
  std::vector<Vec3> points;
  std::vector<AxisBox> boxes;
  for (int i = 0; i < 150; ++i) {
    shapes.push_back(mixed.placed_shape());
    points.push_back(shapes.back().pose.position);
    boxes.push_back({points.back(), points.back() + Vec3{1, 2, 3}});
  }
  const auto listed = [](const auto& lists, std::size_t i) {
    return std::vector(lists[i].begin(), lists[i].end());
  };
  const World& world = mixed.world;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    Workers workers({.threads = isa == Isa::sse2 ? 1 : 3, .isa = isa});
    const World copy = clone(world);
    std::vector<std::optional<NearHit>> to_points(points.size()), to_shapes(points.size());
    closest_to_points(copy, points, 1.0f, to_points, workers);
    closest_to_shapes(copy, shapes, 1.0f, to_shapes, workers);
    const auto near_all_points = near_points(copy, points, 1.0f, workers);
    const auto near_all_shapes = near_shapes(copy, shapes, 1.0f, workers);
    const auto over_points = overlap_points(copy, points, workers);
    const auto over_boxes = overlap_boxes(copy, boxes, workers);
    const auto over_shapes = overlap_shapes(copy, shapes, workers);
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_EQ(to_points[i], closest_to_point(world, points[i], 1.0f));
      EXPECT_EQ(to_shapes[i], closest_to_shape(world, shapes[i], 1.0f));
      EXPECT_EQ(listed(near_all_points, i), near_point(world, points[i], 1.0f));
      EXPECT_EQ(listed(near_all_shapes, i), near_shape(world, shapes[i], 1.0f));
      EXPECT_EQ(listed(over_points, i), overlap_point(world, points[i]));
      EXPECT_EQ(listed(over_boxes, i), overlap_box(world, boxes[i]));
      EXPECT_EQ(listed(over_shapes, i), overlap_shape(world, shapes[i]));
    }
  }
}

TEST(DistanceQueries, RefuseWhatIsNoQuestion) {
  World world;
  Workers workers(1);
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (const float bad : {nan, inf, -inf, 1.1e7f}) {
    EXPECT_THROW(closest_to_point(world, {bad, 0, 0}, 1.0f), Error);
    EXPECT_THROW(near_point(world, {0, bad, 0}, 1.0f), Error);
    EXPECT_THROW(overlap_point(world, {0, 0, bad}), Error);
    EXPECT_THROW(overlap_box(world, {{bad, 0, 0}, {1, 1, 1}}), Error);
    EXPECT_THROW(overlap_shape(world, {Sphere{}, {{bad, 0, 0}, {}}}), Error);
    EXPECT_THROW(overlap_shape(world, {Sphere{bad}, {}}), Error);
  }
  for (const float most : {nan, -1.0f, inf, 1.1e8f}) {
    EXPECT_THROW(closest_to_point(world, {}, most), Error);
    EXPECT_THROW(near_shape(world, {}, most), Error);
  }
  EXPECT_THROW(overlap_box(world, {{1, 0, 0}, {0, 1, 1}}), Error);
  EXPECT_THROW(overlap_shape(world, {ConvexHull{}, {}}), Error);
  EXPECT_THROW(overlap_shape(world, {ConvexHull{Dice::hull(0), {1e6f, 1, 1}}, {}}), Error);
  EXPECT_THROW(overlap_shape(world, {ConvexHull{Dice::hull(0), {0, 1, 1}}, {}}), Error);
  EXPECT_THROW(overlap_shape(world, {Sphere{}, {{}, {0, 0, 0, 0}}}), Error);
  const std::vector<Vec3> points(3);
  std::vector<std::optional<NearHit>> hits(2);
  try {
    closest_to_points(world, points, 1.0f, hits, workers);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()), "closest_to_points: hits has room for 2, but there are 3 queries");
  }
  EXPECT_EQ(near_points(world, {}, 1.0f, workers).size(), 0u);
}

}  // namespace
}  // namespace scree
