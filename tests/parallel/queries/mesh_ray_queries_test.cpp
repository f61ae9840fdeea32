// Laws of rays against meshes: against brute force, through edges and vertices, and where numbers are
// extreme.
#include <tests/parallel/queries/mesh_fixture.h>

namespace scree {
namespace {

using testing::Crossing;
using testing::Dice;
using testing::Point;
using testing::to_point;
using testing::Triangle;
using testing::TriangleSoup;

// A mesh on a body that is turned and placed at random.
struct MeshWorld {
  World world;
  TriangleSoup soup;
  BodyId body;
  ShapeId shape;

  MeshWorld(TriangleSoup given, const Pose& pose, BodyType type = BodyType::fixed, const Pose& local = {})
      : soup(std::move(given)) {
    body = world.create_body({.type = type, .position = pose.position, .rotation = pose.rotation});
    shape = world.add_shape(body, soup.mesh(), {}, {.local_pose = local});
  }
  std::vector<Triangle> triangles() const { return testing::triangles_of(world, shape, soup); }
};

// The hit of the first triangle, as brute force finds it; `error` (m): what a place may be off by.
void expect_right_hit(const MeshWorld& made, const std::vector<Triangle>& triangles, const Ray& ray,
                      double error, bool back_sides = false) {
  const std::optional<CastHit> hit = cast_ray(made.world, ray, {.back_sides = back_sides});
  const Point origin = to_point(ray.origin), way = to_point(ray.translation);
  const double size = norm(way);
  double first = 2.0;  // fraction of the first triangle that is met for sure
  for (const Triangle& triangle : triangles) {
    const Crossing crossing = testing::crossing_of(triangle, origin, way);
    if (!(crossing.from_front || back_sides)) continue;
    const double steep = std::abs(dot(triangle.normal(), way)) / size;
    if (crossing.within * steep < error || crossing.fraction * size * steep < error) continue;
    if ((1.0 - crossing.fraction) * size * steep < error) continue;
    first = std::min(first, crossing.fraction);
  }
  EXPECT_EQ(is_blocked(made.world, ray, {.back_sides = back_sides}), hit.has_value());
  if (!hit) {
    EXPECT_GT(first, 1.0) << "misses a triangle";
    return;
  }
  ASSERT_GE(hit->triangle, 0);
  ASSERT_LT(static_cast<std::size_t>(hit->triangle), triangles.size());
  const Triangle& met = triangles[static_cast<std::size_t>(hit->triangle)];
  const Crossing crossing = testing::crossing_of(met, origin, way);
  const double steep = std::abs(dot(met.normal(), way)) / size;
  EXPECT_TRUE(crossing.from_front || back_sides || steep < 1e-3);
  EXPECT_LT(norm(to_point(hit->normal) - met.normal()), 1e-5);
  EXPECT_LT(testing::distance_from(met, to_point(hit->point)), 4 * error);
  EXPECT_NEAR(hit->distance, hit->fraction * size, 1e-5 * size);
  if (steep > 0.01) {
    EXPECT_NEAR(hit->distance, crossing.fraction * size, 4 * error / steep + 1e-6 * size);
  }
  EXPECT_LE(hit->fraction * size, first * size + 200 * error + 1e-6 * size);
  EXPECT_FALSE(hit->starts_inside);
  EXPECT_EQ(hit->face, -1);
  EXPECT_EQ(hit->body, made.body);
  EXPECT_EQ(hit->shape, made.shape);
}

TEST(MeshRays, FindWhatBruteForceFindsInRandomTriangles) {
  Dice dice(1);
  for (int round = 0; round < 12; ++round) {
    const float size = round % 3 == 0 ? 0.05f : round % 3 == 1 ? 1.0f : 6.0f;
    const Pose pose{dice.within({20, 20, 20}), dice.rotation()};
    const Pose local{dice.within({3, 3, 3}), dice.rotation()};
    const BodyType type = round % 2 == 0 ? BodyType::fixed : BodyType::kinematic;
    const MeshWorld made(testing::random_soup(dice, 50 + 211 * round, 5.0f, size), pose, type, local);
    const std::vector<Triangle> triangles = made.triangles();
    for (int i = 0; i < 80; ++i) {
      Ray ray = dice.ray(10.0f);
      ray.origin = ray.origin + pose.position;
      expect_right_hit(made, triangles, ray, 2e-5, i % 4 == 0);
    }
  }
}

TEST(MeshRays, FindWhatBruteForceFindsInOneTriangleAndInSeventeen) {
  Dice dice(2);
  for (const int count : {1, 2, 15, 16, 17, 255, 256, 257}) {
    const MeshWorld made(testing::random_soup(dice, count, 2.0f, 2.0f), {});
    const std::vector<Triangle> triangles = made.triangles();
    for (int i = 0; i < 100; ++i) expect_right_hit(made, triangles, dice.ray(4.0f), 5e-6);
  }
}

TEST(MeshRays, KeepTheirPrecisionForTinyAndHugeTriangles) {
  Dice dice(3);
  for (const float scale : {1e-3f, 1e-1f, 1e2f, 1e4f}) {
    const MeshWorld made(testing::random_soup(dice, 300, 3.0f * scale, 1.5f * scale), {});
    const std::vector<Triangle> triangles = made.triangles();
    for (int i = 0; i < 100; ++i)
      expect_right_hit(made, triangles, dice.ray(5.0f * scale), 2e-6 * double{scale});
  }
}

TEST(MeshRays, FromFarAwayMeetWhatTheyAimAt) {
  Dice dice(4);
  const MeshWorld made(testing::bumpy_ball(dice, 12, 20, 0.9f, 1.1f), {});
  const std::vector<Triangle> triangles = made.triangles();
  for (int i = 0; i < 200; ++i) {
    const Vec3 aim = dice.within({0.5f, 0.5f, 0.5f});
    const Vec3 way = dice.within({1, 1, 1});
    if (length(way) < 0.1f) continue;
    const float far = i % 2 == 0 ? 1000.0f : 1e6f;
    const Ray ray{aim - far * normalize(way), (2.0f * far) * normalize(way)};
    const std::optional<CastHit> hit = cast_ray(made.world, ray);
    // What the rounded ray passes at the ball, exactly.
    const Point origin = to_point(ray.origin), to = to_point(ray.translation);
    const double nearest = -dot(origin, to) / dot(to, to);
    if (norm(origin + nearest * to) > 0.8) continue;
    ASSERT_TRUE(hit.has_value());
    expect_right_hit(made, triangles, ray, 1e-7 * double{far});
  }
}

TEST(MeshRays, AtLargeCoordinatesMeetWhatIsThere) {
  Dice dice(5);
  const Vec3 far{1.5e6f, -2.5e6f, 3e6f};
  const MeshWorld made(testing::random_soup(dice, 300, 300.0f, 100.0f), {far, dice.rotation()});
  const std::vector<Triangle> triangles = made.triangles();
  for (int i = 0; i < 200; ++i) {
    Ray ray = dice.ray(500.0f);
    ray.origin = ray.origin + far;
    expect_right_hit(made, triangles, ray, 1.0);
  }
}

// From outside through a point within a closed surface: it must meet it, wherever its edges are.
TEST(MeshRays, NoRayPassesThroughAClosedSurface) {
  Dice dice(6);
  for (int round = 0; round < 6; ++round) {
    const Pose pose{dice.within({30, 30, 30}), dice.rotation()};
    const MeshWorld made(testing::bumpy_ball(dice, 30, 50, 0.7f, 1.3f), pose);
    const std::vector<Triangle> triangles = made.triangles();
    for (int i = 0; i < 4000; ++i) {
      // Through a vertex, an edge or any place, as far as floats have it.
      const Triangle& triangle = triangles[dice.below(static_cast<std::uint32_t>(triangles.size()))];
      const double part = i % 3 == 0 ? 0.0 : dice.uniform(0.0f, 1.0f);
      const double other = i % 3 == 2 ? dice.uniform(0.0f, 1.0f) : 0.0;
      const Point at = triangle.corner[0] + part * (triangle.corner[1] - triangle.corner[0]) +
                       other * (triangle.corner[2] - triangle.corner[0]);
      const Point center = to_point(pose.position);
      const Point out = center + 4.0 * (at - center);
      const Vec3 origin{static_cast<float>(out.x), static_cast<float>(out.y), static_cast<float>(out.z)};
      const Ray ray{origin, pose.position - origin};
      const std::optional<CastHit> hit = cast_ray(made.world, ray);
      ASSERT_TRUE(hit.has_value()) << i;
      EXPECT_LT(dot(hit->normal, ray.translation), 1e-6f);
      EXPECT_TRUE(is_blocked(made.world, ray));
      // From within, it has no front.
      EXPECT_FALSE(is_blocked(made.world, {pose.position, origin - pose.position}));
      EXPECT_TRUE(is_blocked(made.world, {pose.position, origin - pose.position}, {.back_sides = true}));
    }
  }
}

TEST(MeshRays, ExactlyThroughVerticesAndEdgesMeetTheSurface) {
  Dice dice(7);
  constexpr int kSquares = 12;
  const MeshWorld made(testing::whole_meters(dice, kSquares, 3), {{-3, 5, 7}, {}});
  const Vec3 slants[] = {{0, -1, 0}, {0.5f, -4, 0.25f}, {-0.5f, -4, 0.5f}, {0.125f, -2, 0}, {0, -8, -0.5f}};
  for (const Vec3 way : slants) {
    // Halves of meters: vertices, the middles of edges and of diagonals, well within the ground's rim.
    for (int x = 4; x <= 2 * kSquares - 4; ++x) {
      for (int z = 4; z <= 2 * kSquares - 4; ++z) {
        const Vec3 at{-3 + 0.5f * static_cast<float>(x), 6, 7 + 0.5f * static_cast<float>(z)};
        const Ray ray{at - 2.0f * way * (4.0f / std::abs(way.y)), 4.0f * way * (4.0f / std::abs(way.y))};
        const std::optional<CastHit> hit = cast_ray(made.world, ray);
        ASSERT_TRUE(hit.has_value()) << x << " " << z;
        EXPECT_GT(hit->normal.y, 0.0f);
        EXPECT_TRUE(is_blocked(made.world, ray));
        EXPECT_FALSE(is_blocked(made.world, {ray.origin + ray.translation, -1.0f * ray.translation}));
      }
    }
  }
}

TEST(MeshRays, MeetTheFrontAndNameTheTriangle) {
  TriangleSoup soup;
  soup.vertices = {{0, 0, 0}, {0, 0, 2}, {2, 0, 0}, {2, 0, 2}, {9, 0, 9}};
  soup.triangles = {{0, 1, 2}, {0, 0, 1}, {2, 1, 3}};  // the second one has no area
  const MeshWorld made(soup, {});
  const Ray down{{0.5f, 2, 0.5f}, {0, -4, 0}}, up{{1.5f, -3, 1.5f}, {0, 4, 0}};
  const std::optional<CastHit> hit = cast_ray(made.world, down);
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(hit->triangle, 0);
  EXPECT_EQ(hit->fraction, 0.5f);
  EXPECT_EQ(hit->distance, 2.0f);
  EXPECT_EQ(hit->normal, (Vec3{0, 1, 0}));
  EXPECT_EQ(hit->point, (Vec3{0.5f, 0, 0.5f}));
  EXPECT_FALSE(cast_ray(made.world, up).has_value());
  const std::optional<CastHit> behind = cast_ray(made.world, up, {.back_sides = true});
  ASSERT_TRUE(behind.has_value());
  EXPECT_EQ(behind->triangle, 2);
  EXPECT_EQ(behind->normal, (Vec3{0, 1, 0}));
  // The diagonal belongs to both; the smaller number counts.
  EXPECT_EQ(cast_ray(made.world, {{1, 2, 1}, {0, -4, 0}})->triangle, 0);
  // To the surface, from it and past it.
  EXPECT_EQ(cast_ray(made.world, {{0.5f, 2, 0.5f}, {0, -2, 0}})->fraction, 1.0f);
  EXPECT_EQ(cast_ray(made.world, {{0.5f, 0, 0.5f}, {0, -2, 0}})->fraction, 0.0f);
  EXPECT_FALSE(cast_ray(made.world, {{0.5f, 2, 0.5f}, {0, -1.999f, 0}}).has_value());
  EXPECT_FALSE(cast_ray(made.world, {{0.5f, 0, 0.5f}, {0, 2, 0}}).has_value());
  EXPECT_FALSE(cast_ray(made.world, {{-1, 0, 0.5f}, {5, 0, 0}}).has_value()) << "along the plane";
  EXPECT_FALSE(cast_ray(made.world, {{0.5f, 0, 0.5f}, {}}).has_value()) << "a mesh holds no point";
  EXPECT_TRUE(overlap_point(made.world, {0.5f, 0, 0.5f}).empty());
}

TEST(MeshRays, HitsOfOtherShapesNameNoTriangle) {
  World world;
  world.add_shape(world.create_body({}), Sphere{});
  EXPECT_EQ(cast_ray(world, {{0, 5, 0}, {0, -9, 0}})->triangle, -1);
}

// Two meshes and other shapes, some of which move.
struct Crowd {
  testing::MixedWorld mixed{11, 60, 6.0f};
  std::vector<ShapeId> meshes;

  Crowd() {
    for (int i = 0; i < 6; ++i) {
      const Vec3 position = mixed.dice.within({5, 5, 5});
      const BodyId body = mixed.world.create_body({.type = i % 2 == 0 ? BodyType::fixed : BodyType::kinematic,
                                                   .position = position,
                                                   .rotation = mixed.dice.rotation(),
                                                   .linear_velocity = {1, 0, 0},
                                                   .angular_velocity = {0, 1, 0}});
      const TriangleSoup soup = i < 3 ? testing::bumpy_ball(mixed.dice, 8, 12, 0.8f, 1.2f)
                                      : testing::random_soup(mixed.dice, 200, 2.0f, 0.5f);
      meshes.push_back(mixed.world.add_shape(body, soup.mesh(), {}, {.filter = {.category = 1u << (i % 3)}}));
    }
  }
};

TEST(MeshRays, FirstHitIsTheFirstOfAllHits) {
  Crowd crowd;
  crowd.mixed.step(5);
  int of_meshes = 0;
  for (int i = 0; i < 600; ++i) {
    const Ray ray = crowd.mixed.dice.ray(8.0f);
    const std::vector<CastHit> all = cast_ray_all(crowd.mixed.world, ray);
    const std::optional<CastHit> first = cast_ray(crowd.mixed.world, ray);
    ASSERT_EQ(first.has_value(), !all.empty());
    EXPECT_EQ(is_blocked(crowd.mixed.world, ray), !all.empty());
    if (first) {
      EXPECT_EQ(*first, all[0]);
      of_meshes += first->triangle >= 0 ? 1 : 0;
    }
  }
  EXPECT_GT(of_meshes, 50);
}

TEST(MeshRays, BatchedOnesEqualSingleOnesForEveryInstructionSetAndThreadCount) {
  Crowd crowd;
  crowd.mixed.step(3);
  const World& world = crowd.mixed.world;
  std::vector<Ray> rays;
  for (int i = 0; i < 800; ++i) rays.push_back(crowd.mixed.dice.ray(8.0f));
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    for (const int threads : {1, 3}) {
      Workers workers({.threads = threads, .isa = isa});
      std::vector<std::optional<CastHit>> hits(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      cast_rays(world, rays, hits, workers);
      are_blocked(world, rays, blocked, workers);
      const AnswerLists<CastHit> all = cast_rays_all(world, rays, workers);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        EXPECT_EQ(hits[i], cast_ray(world, rays[i]));
        EXPECT_EQ(blocked[i] != 0, is_blocked(world, rays[i]));
        EXPECT_EQ(std::vector<CastHit>(all[i].begin(), all[i].end()), cast_ray_all(world, rays[i]));
      }
    }
  }
}

TEST(MeshRays, LookOnlyAtWhatTheOptionsLet) {
  Crowd crowd;
  crowd.mixed.step(2);
  const World& world = crowd.mixed.world;
  for (int i = 0; i < 300; ++i) {
    const Ray ray = crowd.mixed.dice.ray(8.0f);
    const std::vector<CastHit> all = cast_ray_all(world, ray);
    const auto expect_those = [&](const QueryOptions& options, auto&& counts) {
      std::vector<CastHit> left;
      for (const CastHit& hit : all) {
        if (counts(hit)) left.push_back(hit);
      }
      EXPECT_EQ(cast_ray_all(world, ray, options), left);
    };
    expect_those({.filter = Filter{.category = 1, .mask = 2}},
                 [&](const CastHit& hit) { return (world.filter(hit.shape).category & 2u) != 0; });
    expect_those({.types = BodyTypes::kinematic},
                 [&](const CastHit& hit) { return world.body_type(hit.body) == BodyType::kinematic; });
    expect_those({.ignored = world.body_of(crowd.meshes[0])},
                 [&](const CastHit& hit) { return hit.shape != crowd.meshes[0]; });
    expect_those({.predicate = [&](ShapeId shape, BodyId) { return shape != crowd.meshes[4]; }},
                 [&](const CastHit& hit) { return hit.shape != crowd.meshes[4]; });
  }
}

TEST(MeshRays, FindMeshesThatHaveMoved) {
  Dice dice(12);
  MeshWorld made(testing::bumpy_ball(dice, 10, 16, 0.8f, 1.2f), {}, BodyType::kinematic);
  Workers workers(1);
  for (int round = 0; round < 10; ++round) {
    const Pose pose{dice.within({9, 9, 9}), dice.rotation()};
    if (round % 2 == 0) {
      made.world.set_pose(made.body, pose);
    } else {
      made.world.set_kinematic_target(made.body, pose, 0.1f);
      step(made.world, 0.1f, workers);
    }
    const std::vector<Triangle> triangles = made.triangles();
    const Vec3 middle = made.world.pose(made.body).position;
    for (int i = 0; i < 50; ++i) {
      Ray ray = dice.ray(3.0f);
      ray.origin = ray.origin + middle;
      expect_right_hit(made, triangles, ray, 1e-5);
    }
  }
}

}  // namespace
}  // namespace scree
