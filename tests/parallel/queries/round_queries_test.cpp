// Queries of cylinders, cones and rounded shapes where geometry says what they meet, where they are extreme,
// and against meshes. What random ones meet is compared with brute force by the tests of each kind of query.
#include <tests/parallel/mover/mover_fixture.h>
#include <tests/parallel/queries/query_fixture.h>

#include <cmath>
#include <limits>
#include <optional>

namespace scree {
namespace {

using testing::Dice;
using testing::Placed;
using testing::RayAnswer;
using testing::to_point;

// One shape in a world of its own.
struct LoneShape {
  explicit LoneShape(const Geometry& geometry, const Pose& pose = {}) {
    body = world.create_body({.type = BodyType::fixed, .position = pose.position, .rotation = pose.rotation});
    shape = world.add_shape(body, geometry);
  }
  std::optional<CastHit> cast(Vec3 origin, Vec3 translation) const {
    return cast_ray(world, {origin, translation});
  }
  World world;
  BodyId body;
  ShapeId shape;
};

Hull cube_hull(float half) {
  std::vector<Vec3> points;
  for (int i = 0; i < 8; ++i)
    points.push_back({(i & 1) != 0 ? half : -half, (i & 2) != 0 ? half : -half, (i & 4) != 0 ? half : -half});
  return Hull(points);
}

void expect_entry(const std::optional<CastHit>& hit, float distance, Vec3 normal) {
  ASSERT_TRUE(hit);
  EXPECT_FALSE(hit->starts_inside);
  EXPECT_NEAR(hit->distance, distance, 2e-6f * (1.0f + distance));
  EXPECT_NEAR(length(hit->normal - normal), 0.0f, 2e-6f);
}

TEST(RoundQueries, RaysMeetACylindersEndsAndSide) {
  const LoneShape lone(Cylinder{2.0f, 0.5f});
  expect_entry(lone.cast({0.3f, 10, 0.2f}, {0, -20, 0}), 8, {0, 1, 0});
  expect_entry(lone.cast({0.3f, -10, 0.2f}, {0, 20, 0}), 8, {0, -1, 0});
  expect_entry(lone.cast({5, 1.9f, 0}, {-9, 0, 0}), 4.5f, {1, 0, 0});
  expect_entry(lone.cast({-0.3f, 0, -5}, {0, 0, 20}), 4.6f, {-0.6f, 0, -0.8f});
  expect_entry(lone.cast({3, 4, 0}, {-6, -6, 0}), std::sqrt(2.0f) * 2.5f, {1, 0, 0});
  expect_entry(lone.cast({2.3f, 4, 0}, {-6, -6, 0}), std::sqrt(2.0f) * 2.0f, {0, 1, 0});
  EXPECT_EQ(lone.cast({0, 10, 0}, {0, -20, 0})->face, -1);
  EXPECT_FALSE(lone.cast({0.51f, 10, 0}, {0, -20, 0}));
  EXPECT_FALSE(lone.cast({0.4f, 10, 0.4f}, {0, -20, 0}));  // within the box around it
  EXPECT_FALSE(lone.cast({5, 2.01f, 0}, {-10, 0, 0}));
  EXPECT_FALSE(lone.cast({0, 10, 0}, {0, -7.9f, 0}));
  EXPECT_FALSE(lone.cast({0, 10, 0}, {}));
  // Along its side and over its rim it is met: the surface belongs to it.
  EXPECT_TRUE(lone.cast({0.5f, 10, 0}, {0, -20, 0}));
  EXPECT_TRUE(lone.cast({5, 2, 0}, {-10, 0, 0}));
  EXPECT_TRUE(lone.cast({0.25f, 1, 0}, {})->starts_inside);
  EXPECT_TRUE(lone.cast({0.5f, 1, 0}, {1, 0, 0})->starts_inside);
}

TEST(RoundQueries, RaysMeetAConesBaseAndSide) {
  // Its side falls 4 m over 3 m.
  const LoneShape lone(Cone{2.0f, 3.0f});
  expect_entry(lone.cast({1, -10, 1}, {0, 20, 0}), 8, {0, -1, 0});
  expect_entry(lone.cast({10, 0, 0}, {-20, 0, 0}), 8.5f, {0.8f, 0.6f, 0});
  expect_entry(lone.cast({0, 0, -10}, {0, 0, 20}), 8.5f, {0, 0.6f, -0.8f});
  expect_entry(lone.cast({1.5f, 10, 0}, {0, -20, 0}), 10, {0.8f, 0.6f, 0});
  expect_entry(lone.cast({0, 10, 0}, {0, -20, 0}), 8, {0, 1, 0});
  EXPECT_FALSE(lone.cast({3.01f, 10, 0}, {0, -20, 0}));
  EXPECT_FALSE(lone.cast({1, 2.5f, 0}, {-20, 0, 0}));
  EXPECT_FALSE(lone.cast({10, 1, 1.0f}, {-20, 0, 0}));  // beside it: at this height its radius is 0.75
  EXPECT_FALSE(lone.cast({0, 3, 1}, {0, 4, 2}));        // would meet the other half of the double cone
  EXPECT_FALSE(lone.cast({1, 5, 0}, {0, 20, 0}));
  EXPECT_TRUE(lone.cast({0, 0, 1.4f}, {})->starts_inside);
  EXPECT_FALSE(lone.cast({0, 0, 1.6f}, {}));
  EXPECT_TRUE(lone.cast({0, 0, 1.4f}, {5, 5, 5})->starts_inside);
}

TEST(RoundQueries, RaysMeetARoundedBoxsFacesEdgesAndCorners) {
  for (const Geometry& geometry :
       {Geometry{Box{{1, 1, 1}, 0.5f}}, Geometry{ConvexHull{cube_hull(1.0f), {1, 1, 1}, 0.5f}}}) {
    const LoneShape lone(geometry);
    expect_entry(lone.cast({0.9f, 10, -0.9f}, {0, -20, 0}), 8.5f, {0, 1, 0});
    expect_entry(lone.cast({1.3f, 10, 0}, {0, -20, 0}), 8.6f, {0.6f, 0.8f, 0});
    expect_entry(lone.cast({0, -1.3f, 10}, {0, 0, -20}), 8.6f, {0, -0.6f, 0.8f});
    const float third = std::sqrt(1.0f / 3.0f);
    expect_entry(lone.cast({11, 11, 11}, {-20, -20, -20}), (10.0f - 0.5f * third) / third,
                 {third, third, third});
    EXPECT_FALSE(lone.cast({1.4f, 10, 1.4f}, {0, -20, 0}));  // past the corner
    EXPECT_FALSE(lone.cast({1.45f, 1.45f, 10}, {0, 0, -20}));
    EXPECT_TRUE(lone.cast({1.3f, 1.3f, 0}, {})->starts_inside);
    EXPECT_FALSE(lone.cast({1.4f, 1.4f, 0}, {}));
  }
  EXPECT_EQ(LoneShape(Box{{1, 1, 1}, 0.5f}).cast({0, 10, 0}, {0, -20, 0})->face, 3);
  EXPECT_EQ(LoneShape(Box{{1, 1, 1}, 0.5f}).cast({1.2f, 10, 0}, {0, -20, 0})->face, -1);
}

// From up to 1e6 m away, onto shapes of all proportions, aimed at their middle.
TEST(RoundQueries, RaysKeepTheirPrecisionForSlenderFlatTinyAndHugeShapes) {
  Dice dice(61);
  int hits = 0;
  for (const Geometry& geometry :
       {Geometry{Cylinder{1e-4f, 1e3f}}, Geometry{Cylinder{1e3f, 1e-4f}}, Geometry{Cone{1e-4f, 1e3f}},
        Geometry{Cone{1e3f, 1e-4f}}, Geometry{Cylinder{1e-4f, 1e-4f}}, Geometry{Cone{1e-4f, 1e-4f}},
        Geometry{Cylinder{1e5f, 1e5f}}, Geometry{Cone{1e5f, 1e5f}},
        Geometry{Box{{1e-4f, 1e-4f, 1e-4f}, 1e-4f}}, Geometry{Box{{1e5f, 1e-4f, 1.0f}, 1e-3f}},
        Geometry{ConvexHull{cube_hull(0.5f), {1, 1, 1}, 1e-4f}},
        Geometry{ConvexHull{cube_hull(0.5f), {1, 1, 1}, 1e5f}}}) {
    const LoneShape lone(geometry);
    const Placed placed = testing::placed_of(lone.world, lone.shape);
    for (const float far : {1.0f, 1e3f, 1e6f}) {
      for (int i = 0; i < 40; ++i) {
        const Vec3 origin = dice.within({far, far, far});
        const Ray ray{origin, -2.0f * origin};
        const std::optional<CastHit> hit = cast_ray(lone.world, ray);
        if (testing::beyond(placed, to_point(origin)) <= 0.0) {
          EXPECT_TRUE(hit && hit->starts_inside);
          continue;
        }
        // Through its origin, which the middle of a cone's axis is.
        ASSERT_TRUE(hit) << geometry.index() << " " << far;
        ++hits;
        // Single precision of the point, and double precision of a long ray.
        const double error = 2e-7 * static_cast<double>(length(hit->point)) + 1e-15 * double{far} + 3e-9;
        EXPECT_LE(std::abs(testing::beyond(placed, to_point(hit->point))), 4.0 * error)
            << geometry.index() << " " << far;
        EXPECT_LE(dot(hit->normal, ray.translation), 0.0f);
      }
    }
  }
  EXPECT_GT(hits, 700);
}

TEST(RoundQueries, PointsAreAsFarAsGeometrySays) {
  const auto distance = [](const LoneShape& lone, Vec3 point) {
    return closest_to_point(lone.world, point, 1e3f)->distance;
  };
  const LoneShape cylinder(Cylinder{2.0f, 0.5f});
  EXPECT_FLOAT_EQ(distance(cylinder, {0.3f, 5, 0.3f}), 3.0f);
  EXPECT_FLOAT_EQ(distance(cylinder, {3, 1, 4}), 4.5f);
  EXPECT_FLOAT_EQ(distance(cylinder, {3.5f, 6, 0}), 5.0f);
  EXPECT_EQ(distance(cylinder, {0.3f, 1.9f, 0.3f}), 0.0f);
  EXPECT_EQ(overlap_point(cylinder.world, {0.5f, 2, 0}).size(), 1u);
  EXPECT_EQ(overlap_point(cylinder.world, {0.4f, 2, 0.4f}).size(), 0u);
  const LoneShape cone(Cone{2.0f, 3.0f});
  EXPECT_FLOAT_EQ(distance(cone, {0, 5, 0}), 3.0f);
  EXPECT_FLOAT_EQ(distance(cone, {1, -6, 1}), 4.0f);
  EXPECT_FLOAT_EQ(distance(cone, {6, -6, 0}), 5.0f);
  EXPECT_FLOAT_EQ(distance(cone, {1.5f + 0.8f, 0.6f, 0}), 1.0f);
  EXPECT_EQ(distance(cone, {0, 0, 1.49f}), 0.0f);
  const LoneShape box(Box{{1, 1, 1}, 0.5f});
  EXPECT_FLOAT_EQ(distance(box, {4, 0, 0}), 2.5f);
  EXPECT_FLOAT_EQ(distance(box, {4, 5, 1}), 4.5f);
  EXPECT_FLOAT_EQ(distance(box, {3, 3, 2}), 2.5f);
}

TEST(RoundQueries, CastsMeetDisksFlatAndOnTheirRims) {
  const LoneShape lone(Cylinder{1.0f, 2.0f});
  const auto cast = [&](const Geometry& geometry, const Pose& pose, Vec3 way) {
    return cast_shape(lone.world, {geometry, pose, way});
  };
  expect_entry(cast(Cylinder{0.5f, 1.0f}, {{1, 10, 0}, {}}, {0, -20, 0}), 8.5f, {0, 1, 0});
  expect_entry(cast(Cone{0.5f, 1.0f}, {{1, 10, 0}, {}}, {0, -20, 0}), 8.5f, {0, 1, 0});
  expect_entry(cast(Cone{0.5f, 1.0f}, {{1, 10, 0}, from_axis_angle({1, 0, 0}, 3.14159265f)}, {0, -20, 0}),
               8.5f, {0, 1, 0});
  expect_entry(cast(Cylinder{0.5f, 1.0f}, {{-10, 0, 0}, {}}, {20, 0, 0}), 7.0f, {-1, 0, 0});
  expect_entry(cast(Box{{1, 1, 1}, 0.25f}, {{-10, 0.5f, 0}, {}}, {20, 0, 0}), 6.75f, {-1, 0, 0});
  // On its edge, standing on end.
  const float root = std::sqrt(0.5f);
  expect_entry(cast(Cylinder{0.5f, 0.5f}, {{0, 10, 0}, from_axis_angle({0, 0, 1}, 0.78539816f)}, {0, -20, 0}),
               9.0f - root, {0, 1, 0});
  EXPECT_FALSE(cast(Cylinder{0.5f, 1.0f}, {{3.01f, 10, 0}, {}}, {0, -20, 0}));
  EXPECT_FALSE(cast(Cylinder{0.5f, 1.0f}, {{2.2f, 10, 2.2f}, {}}, {0, -20, 0}));
  EXPECT_TRUE(cast(Cylinder{0.5f, 1.0f}, {{2.1f, 10, 2.1f}, {}}, {0, -20, 0}));
}

// A mesh of a box's surface is as far as the box, and is met where the box is.
TEST(RoundQueries, MeshesAreMetWhereTheirBoxIs) {
  const std::vector<Vec3> corners{{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                  {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
  const std::vector<MeshTriangle> triangles{{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                                            {3, 7, 6}, {3, 6, 2}, {0, 4, 7}, {0, 7, 3}, {1, 2, 6}, {1, 6, 5}};
  const LoneShape box(Box{{1, 1, 1}}), mesh(TriangleMesh(corners, triangles));
  Dice dice(62);
  int met = 0, apart = 0;
  for (int i = 0; i < 400; ++i) {
    const PlacedShape placed{dice.geometry(0.6f, 4 + dice.below(4)),
                             {dice.within({4, 4, 4}), dice.rotation()}};
    const std::optional<NearHit> to_box = closest_to_shape(box.world, placed, 10.0f);
    const std::optional<NearHit> to_mesh = closest_to_shape(mesh.world, placed, 10.0f);
    ASSERT_TRUE(to_box && to_mesh);
    if (!(to_box->distance > 1e-3f)) continue;
    ++apart;
    EXPECT_NEAR(to_mesh->distance, to_box->distance, 1e-5f);
    EXPECT_TRUE(overlap_shape(mesh.world, placed).empty());
    const ShapeCast cast{placed.geometry, placed.pose, -2.0f * placed.pose.position};
    const std::optional<CastHit> on_box = cast_shape(box.world, cast), on_mesh = cast_shape(mesh.world, cast);
    ASSERT_EQ(on_box.has_value(), on_mesh.has_value());
    if (!on_box) continue;
    ++met;
    EXPECT_NEAR(on_mesh->distance, on_box->distance, 1e-5f);
  }
  EXPECT_GT(met, 100);
  EXPECT_GT(apart, 200);
}

TEST(RoundQueries, SensorsSeeAndAreSeenByRoundShapes) {
  for (const Geometry& geometry :
       {Geometry{Cylinder{0.5f, 0.5f}}, Geometry{Cone{0.5f, 0.5f}}, Geometry{Box{{0.4f, 0.4f, 0.4f}, 0.1f}},
        Geometry{ConvexHull{cube_hull(0.4f), {1, 1, 1}, 0.1f}}}) {
    for (const bool is_sensor : {true, false}) {
      World world({.gravity = {}});
      Workers workers(1);
      const Geometry ball = Sphere{0.5f};
      const ShapeId sensor = world.add_shape(world.create_body({.type = BodyType::fixed}),
                                             is_sensor ? geometry : ball, {}, {.sensor = true});
      const BodyId visitor = world.create_body({.position = {3, 0, 0}, .linear_velocity = {-60, 0, 0}});
      world.add_shape(visitor, is_sensor ? ball : geometry);
      step(world, 1.0f / 60.0f, workers);
      EXPECT_EQ(world.visitors_of(sensor, {}), 0u);
      step(world, 1.0f / 60.0f, workers);
      step(world, 1.0f / 60.0f, workers);
      EXPECT_EQ(world.visitors_of(sensor, {}), 1u) << geometry.index();
      for (int i = 0; i < 4; ++i) step(world, 1.0f / 60.0f, workers);
      EXPECT_EQ(world.visitors_of(sensor, {}), 0u);
    }
  }
}

TEST(RoundQueries, MoversWalkOverACylinderAndAroundIt) {
  testing::MoverLab lab;
  lab.add_floor();
  const BodyId table = lab.world.create_body({.type = BodyType::fixed, .position = {0, 0.5f, 0}});
  lab.world.add_shape(table, Cylinder{0.5f, 3.0f});
  const BodyId pillar = lab.world.create_body({.type = BodyType::fixed, .position = {10, 5, 0.1f}});
  lab.world.add_shape(pillar, Cylinder{5.0f, 1.0f});
  lab.place({-2, lab.standing(1.0f) + 0.1f, 0});
  lab.walk({2, 0, 0}, 60);
  EXPECT_EQ(lab.mover.ground, MoverGround::firm);
  EXPECT_NEAR(lab.mover.position.y, lab.standing(1.0f), 0.02f);
  lab.walk({4, 0, 0}, 90);  // down, and to the pillar
  EXPECT_NEAR(lab.mover.position.y, lab.standing(0.0f), 0.02f);
  lab.walk({4, 0, 0}, 240);  // which it slides around
  EXPECT_GT(lab.mover.position.x, 11.0f);
  EXPECT_LT(lab.mover.position.z, 0.0f);
}

}  // namespace
}  // namespace scree
