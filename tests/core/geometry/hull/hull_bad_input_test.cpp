// No points break the builder: it either reports their defect or makes a sound hull.
#include <core/geometry/hull/hull_stages.h>
#include <tests/core/geometry/hull/hull_clouds.h>

#include <cfenv>
#include <cstring>
#include <limits>

namespace scree::test {
namespace {

std::string error_of_points(const Cloud& cloud, const HullOptions& options = {}) {
  return error_of([&] { Hull(cloud, options); });
}
const Cloud& box() {
  static const Cloud cloud = lattice(2, {1, 1, 1});
  return cloud;
}
const std::string kThick = ": a hull must be at least 0.0001 m thick";

TEST(HullBadInput, TooFewPointsAreRefusedWithTheirNumber) {
  EXPECT_EQ(error_of_points({}), "Hull: 0 points, must be in [4, 2147483647]");
  EXPECT_EQ(error_of_points({box()[0], box()[1], box()[2]}), "Hull: 3 points, must be in [4, 2147483647]");
}

TEST(HullBadInput, MaxVerticesHasItsRange) {
  for (const int wrong : {3, 0, -1, 257, std::numeric_limits<int>::max()}) {
    EXPECT_EQ(error_of_points(box(), {.max_vertices = wrong}),
              "Hull: max_vertices is " + std::to_string(wrong) + ", must lie in [4, 256]");
  }
  EXPECT_EQ(Hull(box(), {.max_vertices = 4}).vertices().size(), 4u);
}

TEST(HullBadInput, ErrorsNameWrongCoordinates) {
  const std::pair<float, const char*> mistakes[] = {{std::numeric_limits<float>::quiet_NaN(), "nan"},
                                                    {std::numeric_limits<float>::infinity(), "inf"},
                                                    {-std::numeric_limits<float>::infinity(), "-inf"},
                                                    {100001.0f, "100001"},
                                                    {-3e38f, "-3e+38"}};
  for (const auto& [value, text] : mistakes) {
    Cloud cloud = box();
    cloud[5].y = value;
    EXPECT_EQ(error_of_points(cloud),
              std::string("Hull: point 5: y is ") + text + ", must lie in [-100000, 100000]");
  }
}

TEST(HullBadInput, PointsWithoutVolumeAreRefused) {
  const Cloud same(10, {1, 2, 3});
  EXPECT_EQ(error_of_points(same), "Hull: the points' extent is 0 m, must be at least 0.0001 m");
  Cloud line, plane;
  for (int i = 0; i < 200; ++i) {
    const float t = 0.1f * static_cast<float>(i);
    line.push_back({t, 2 * t, -t});
    plane.push_back({t, static_cast<float>(i * i % 17), 3.0f});
  }
  EXPECT_EQ(error_of_points(line), "Hull: the points lie within a line" + kThick);
  EXPECT_EQ(error_of_points(plane), "Hull: the points lie within a plane" + kThick);
  // Turned, so that rounding lifts the points from their plane.
  const std::string turned_plane = error_of_points(turned(plane, kTurn, {1, 2, 3}));
  EXPECT_NE(turned_plane.find(" m thick"), std::string::npos) << turned_plane;
  const std::string turned_line = error_of_points(turned(line, kTurn, {1, 2, 3}));
  EXPECT_NE(turned_line.find(" m thick"), std::string::npos) << turned_line;
}

TEST(HullBadInput, TrianglesWithoutFacesAreRefusedInTheNameOfTheCall) {
  const std::vector<GridPoint> points{{0, 0, 0}, {8, 0, 0}, {0, 8, 0}};
  TriangleHull sheet;  // two triangles back to back
  sheet.triangles = {{{0, 1, 2}, {1, 1, 1}}, {{0, 2, 1}, {0, 0, 0}}};
  const std::string who = "World::add_shape: the scaled hull";
  EXPECT_EQ(error_of([&] {
              find_polygons(who, points, {1, 1, 1}, sheet, 0.0);
            }),
            who + ": the points' hull is too degenerate to make faces of");
}

TEST(HullBadInput, TheThicknessOfHullsHasItsLimit) {
  EXPECT_EQ(error_of_points(lattice(3, {1.0f, 0.9e-4f, 1.0f})),
            "Hull: the points' hull is 9e-05 m thick" + kThick);
  EXPECT_NO_THROW(Hull(lattice(3, {1.0f, 1.1e-4f, 1.0f})));
  EXPECT_NO_THROW(Hull(lattice(3, {1.01e-4f, 1.01e-4f, 1.01e-4f})));
  // Floats cannot hold both sides of a sheet that is thinner than two millionths of its width.
  EXPECT_NO_THROW(Hull(lattice(3, {1e5f, 1.0f, 1e5f})));
  const std::string sheet = error_of_points(lattice(3, {1e5f, 0.1f, 1e5f}));
  EXPECT_NE(sheet.find(": a hull must be at least 0.2 m thick"), std::string::npos) << sheet;
}

TEST(HullBadInput, TheLargestAndTheSmallestHullsAreSound) {
  const Hull large(stretched(box(), {2e5f, 2e5f, 2e5f})), small(stretched(box(), {1e-4f, 1e-4f, 1e-4f}));
  EXPECT_EQ(large.face_count(), 6u);
  EXPECT_EQ(small.face_count(), 6u);
  EXPECT_NEAR(large.volume(), 8e15, 1e10);
  EXPECT_NEAR(small.volume(), 1e-12, 1e-18);
  World world;
  const BodyId body = world.create_body({});
  world.add_shape(body, ConvexHull{large}, {.density = 1e9f});
  world.add_shape(world.create_body({}), ConvexHull{small}, {.density = 1e-6f});
  EXPECT_NEAR(world.mass_properties(body).mass, 8e24, 1e19);
}

TEST(HullBadInput, ManyEqualPointsAreOne) {
  Cloud cloud = box();
  for (int i = 0; i < 10; ++i) cloud.insert(cloud.end(), box().begin(), box().end());
  const Hull hull(cloud);
  EXPECT_EQ(hull, Hull(box()));
  EXPECT_EQ(hull.report().merged_points, 80u);
  EXPECT_EQ(hull.report().inner_points, 0u);
}

TEST(HullBadInput, AlmostEqualPointsAreMergedOrLeftOut) {
  Random random(3);
  Cloud cloud;
  for (int i = 0; i < 2000; ++i) {
    const Vec3& corner = box()[static_cast<std::size_t>(i) % 8];
    cloud.push_back(corner + 2e-7f * random_point(random));
  }
  const Hull hull(cloud);
  EXPECT_EQ(hull.vertices().size(), 8u);
  EXPECT_EQ(hull.face_count(), 6u);
  EXPECT_LE(hull.report().deviation, 2e-6f);
}

TEST(HullBadInput, MillionsOfPointsMakeAHull) {
  constexpr std::size_t kMillion = 1'000'000;
  const Hull cube(lattice(100, {1, 1, 1}));
  EXPECT_EQ(cube.vertices().size(), 8u);
  EXPECT_EQ(cube.report().inner_points + cube.report().merged_points, kMillion - 8);
  // The worst case: all points are corners, so that the limit cuts off all but 256.
  const Hull ball(sphere_cloud(static_cast<int>(kMillion), 1));
  EXPECT_EQ(ball.vertices().size(), 256u);
  EXPECT_TRUE(ball.report().simplified());
  EXPECT_GT(ball.report().cut_vertices, kMillion * 9 / 10);
  EXPECT_LT(ball.report().deviation, 0.02f);
}

// Points on few planes, on lines, in clusters: degenerate, but not flat.
TEST(HullBadInput, DegenerateCloudsMakeSoundHulls) {
  Random random(8);
  for (int round = 0; round < 400; ++round) {
    Cloud cloud;
    const int values = 2 + static_cast<int>(random.below(5));
    const std::size_t count = 8 + random.below(200);
    const float noise = round % 4 == 0 ? 0.0f : std::pow(10.0f, random.between(-8.0f, -3.0f));
    for (std::size_t i = 0; i < count; ++i) {
      const auto pick = [&] { return static_cast<float>(random.below(static_cast<std::size_t>(values))); };
      const float x = pick(), y = pick(), z = pick();
      cloud.push_back(Vec3{x, y, z} + noise * random_point(random));
    }
    if (round % 3 == 0) cloud = turned(cloud, kTurn, {10, 0, 0});
    Hull hull;
    const std::string error = error_of([&] { hull = Hull(cloud); });
    if (!error.empty()) {
      EXPECT_NE(error.find("thick"), std::string::npos) << error;  // eight points of few values may be flat
      continue;
    }
    const HullTopology& topology = solid_of(hull).topology;
    EXPECT_EQ(hull.vertices().size() + hull.face_count(), hull.edge_count() + 2);
    EXPECT_LE(hull.report().deviation, 1e-4) << round;
    for (const auto& [n, offset] : topology.planes) {
      for (const Vec3& v : topology.vertices) {
        ASSERT_LE(double{n[0]} * v.x + double{n[1]} * v.y + double{n[2]} * v.z, double{offset});
      }
    }
  }
}

TEST(HullBadInput, TheCallersRoundingModeDoesNotChangeTheHull) {
  const Cloud cloud = sphere_cloud(300, 2);
  const Hull expected(cloud);
  for (const int rounding : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
    std::fesetround(rounding);
    const Hull hull(cloud);
    EXPECT_EQ(std::fegetround(), rounding);
    std::fesetround(FE_TONEAREST);
    EXPECT_EQ(hull, expected);
    EXPECT_EQ(std::memcmp(&solid_of(hull).integrals, &solid_of(expected).integrals, sizeof(HullIntegrals)),
              0);
  }
}

TEST(HullBadInput, NothingIsWrittenToStandardError) {
  ::testing::internal::CaptureStderr();
  (void)error_of_points(lattice(10, {1, 0, 1}));
  (void)error_of_points(turned(lattice(30, {1, 1e-7f, 1}), kTurn));
  const Hull hull(turned(lattice(10, {1, 1e-3f, 1}), kTurn));
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace scree::test
