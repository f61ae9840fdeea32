// Laws of pictures: things are where the camera's geometry puts them, in the colors asked for, in the same
// bytes on every backend.
#include <gtest/gtest.h>
#include <png.h>
#include <scree/scree.h>
#include <tools/render/cutaway.h>
#include <tools/render/draw.h>

#include <cmath>
#include <cstring>
#include <initializer_list>
#include <numbers>
#include <string>
#include <vector>

namespace scree::render {
namespace {

constexpr int kWidth = 320, kHeight = 240;

BodyId add(World& world, BodyType type, Vec3 position, const Geometry& geometry) {
  const BodyId body = world.create_body({.type = type, .position = position});
  world.add_shape(body, geometry);
  return body;
}

Picture draw_at(const World& world, const Camera& camera, ColorBy color_by = ColorBy::type) {
  Workers workers(1);
  const DrawOptions options{.width = kWidth, .height = kHeight, .color_by = color_by, .smooth = false};
  return draw(world, camera, options, workers).picture;
}

int brightness(const Picture& picture, int x, int y) {
  const std::uint8_t* pixel = picture.pixel(x, y);
  return pixel[0] + pixel[1] + pixel[2];
}

int count_different(const Picture& a, const Picture& b) {
  int count = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) count += std::memcmp(a.pixel(x, y), b.pixel(x, y), 3) != 0 ? 1 : 0;
  }
  return count;
}

// Where a point is in the picture, in pixels.
struct Spot {
  int x, y;
};

Spot spot_of(const Camera& camera, Vec3 point) {
  const Axes axes = axes_of(camera);
  const Vec3 offset = point - camera.eye;
  const double depth = -double{dot(offset, axes.backward)};
  const double scale = 0.5 * kHeight / std::tan(camera.view * std::numbers::pi / 360.0) / depth;
  return {static_cast<int>(0.5 * kWidth + scale * double{dot(offset, axes.right)}),
          static_cast<int>(0.5 * kHeight - scale * double{dot(offset, axes.up)})};
}

TEST(Draw, ABallFillsTheDiskThatItsTangentsEnclose) {
  for (const float radius : {1e-3f, 1.0f, 1e4f}) {
    for (const float distance : {1.5f, 3.0f, 10.0f}) {
      World world;
      add(world, BodyType::dynamic, {}, Sphere{radius});
      const Camera camera{{0.0f, 0.0f, distance * radius}, {}, {0.0f, 1.0f, 0.0f}, 120.0};
      const int pixels = count_different(draw_at(world, camera), draw_at(World(), camera));
      const double half = 0.5 * kHeight / std::tan(60.0 * std::numbers::pi / 180.0);
      const double disk = half * std::tan(std::asin(1.0 / double{distance}));
      const double area = std::numbers::pi * disk * disk;
      EXPECT_NEAR(pixels, area, 4.0 * disk + 1.0) << radius << " " << distance;
    }
  }
}

TEST(Draw, ABodyIsWhereTheCameraSeesIt) {
  const Camera camera{{3.0f, 4.0f, 12.0f}, {1.0f, 1.0f, 0.0f}};
  for (const Vec3 place : {Vec3{1.0f, 1.0f, 0.0f}, Vec3{-2.0f, 0.5f, 1.0f}, Vec3{3.0f, 3.0f, -4.0f}}) {
    World world;
    add(world, BodyType::dynamic, place, Sphere{0.3f});
    const Picture with = draw_at(world, camera), without = draw_at(World(), camera);
    double x = 0.0, y = 0.0, count = 0.0;
    for (int row = 0; row < kHeight; ++row) {
      for (int column = 0; column < kWidth; ++column) {
        if (std::memcmp(with.pixel(column, row), without.pixel(column, row), 3) == 0) continue;
        x += column;
        y += row;
        count += 1.0;
      }
    }
    const Spot spot = spot_of(camera, place);
    EXPECT_NEAR(x / count, spot.x, 1.0);
    EXPECT_NEAR(y / count, spot.y, 1.0);
  }
}

TEST(Draw, ABallThrowsItsShadowAwayFromTheSun) {
  World world, bare;
  for (World* each : {&world, &bare}) add(*each, BodyType::fixed, {}, HalfSpace{});
  const Vec3 ball{0.0f, 3.0f, 0.0f};
  add(world, BodyType::dynamic, ball, Sphere{0.5f});
  const Camera camera{{0.0f, 8.0f, 14.0f}, {0.0f, 1.0f, 0.0f}};
  const Picture with = draw_at(world, camera), without = draw_at(bare, camera);
  const Vec3 sun = sun_of(camera);
  const Spot shadow = spot_of(camera, ball - ball.y / sun.y * sun);
  EXPECT_LT(brightness(with, shadow.x, shadow.y), 0.8 * brightness(without, shadow.x, shadow.y));
  const Spot opposite = spot_of(camera, {(ball.y / sun.y * sun).x, 0.0f, (ball.y / sun.y * sun).z});
  EXPECT_EQ(brightness(with, opposite.x, opposite.y), brightness(without, opposite.x, opposite.y));
}

TEST(Draw, ColorsSayTypeAndSleepAndSpeed) {
  World world({.gravity = {}});
  const BodyId fixed = add(world, BodyType::fixed, {-3.0f, 0.0f, 0.0f}, Sphere{0.5f});
  const BodyId kinematic = add(world, BodyType::kinematic, {-1.0f, 0.0f, 0.0f}, Sphere{0.5f});
  const BodyId still = add(world, BodyType::dynamic, {1.0f, 0.0f, 0.0f}, Sphere{0.5f});
  const BodyId fast = add(world, BodyType::dynamic, {3.0f, 0.0f, 0.0f}, Sphere{0.5f});
  Workers workers(1);
  world.set_linear_velocity(fast, {0.0f, 0.0f, 1.0f});
  for (int i = 0; i < 120; ++i) step(world, 1.0f / 60.0f, workers);
  ASSERT_FALSE(world.is_awake(still));
  ASSERT_TRUE(world.is_awake(fast));
  world.set_linear_velocity(fast, {0.0f, 0.0f, 100.0f});
  const std::vector<Color> types = color_bodies(world, ColorBy::type),
                           sleep = color_bodies(world, ColorBy::sleep),
                           speeds = color_bodies(world, ColorBy::speed);
  EXPECT_NE(types[fixed.index], types[kinematic.index]);
  EXPECT_NE(types[kinematic.index], types[still.index]);
  EXPECT_EQ(types[still.index], types[fast.index]);
  EXPECT_NE(sleep[still.index], sleep[fast.index]);
  EXPECT_EQ(byte_of(speeds[still.index].z), 84);  // the ends of viridis
  EXPECT_EQ(byte_of(speeds[fast.index].z), 37);
  const Camera camera{{0.0f, 0.0f, 12.0f}, {}};
  const Picture picture = draw_at(world, camera, ColorBy::sleep);
  const Spot spot = spot_of(camera, world.pose(still).position);
  const std::uint8_t* pixel = picture.pixel(spot.x, spot.y);
  EXPECT_GT(pixel[2], pixel[0] + 40);  // blue
}

TEST(Draw, MeshesAreSeenFromTheirFronts) {
  const std::vector<Vec3> vertices = {{-1.0f, -1.0f, 0.0f}, {1.0f, -1.0f, 0.0f}, {0.0f, 1.0f, 0.0f}};
  const std::vector<MeshTriangle> triangles = {{0, 1, 2}};
  World world;
  add(world, BodyType::fixed, {}, TriangleMesh(vertices, triangles));
  const Camera front{{0.0f, 0.0f, 5.0f}, {}}, back{{0.0f, 0.0f, -5.0f}, {}};
  EXPECT_GT(count_different(draw_at(world, front), draw_at(World(), front)), 1000);
  EXPECT_EQ(count_different(draw_at(world, back), draw_at(World(), back)), 0);
}

TEST(Draw, SensorsAreNotDrawn) {
  World world;
  world.add_shape(world.create_body({}), Sphere{}, {}, {.sensor = true});
  const Camera camera{{0.0f, 0.0f, 3.0f}, {}};
  EXPECT_EQ(count_different(draw_at(world, camera), draw_at(World(), camera)), 0);
}

World heap() {
  World world;
  add(world, BodyType::fixed, {0.0f, -0.5f, 0.0f}, Box{{20.0f, 0.5f, 20.0f}});
  for (int i = 0; i < 60; ++i) {
    const Vec3 place{0.9f * static_cast<float>(i % 4), 0.6f + 1.1f * static_cast<float>(i / 8),
                     0.8f * static_cast<float>(i / 4 % 2)};
    const Geometry shapes[] = {Sphere{0.4f}, Box{{0.4f, 0.3f, 0.2f}, 0.05f}, Capsule{0.3f, 0.2f},
                               Cylinder{0.3f, 0.3f}, Cone{0.4f, 0.3f}};
    add(world, BodyType::dynamic, place, shapes[i % 5]);
  }
  return world;
}

TEST(Draw, PicturesHaveTheSameBytesOnEveryBackend) {
  World world = heap();
  Workers one({.threads = 1, .isa = Isa::scalar});
  for (int i = 0; i < 40; ++i) step(world, 1.0f / 60.0f, one);
  const Subject subject = subject_of(world);
  const Camera camera = look_from(Side::corner, subject, kDefaultView, 16.0 / 9.0);
  const DrawOptions options{.width = 320, .height = 180, .reach = subject.reach};
  const Drawing expected = draw(world, camera, options, one);
  EXPECT_GT(expected.rays, 320u * 180u);
  for (const Isa isa : {Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    for (const int threads : {1, 2, 3}) {
      Workers workers({.threads = threads, .isa = isa});
      const Drawing drawing = draw(world, camera, options, workers);
      EXPECT_EQ(drawing.picture.bytes, expected.picture.bytes) << isa_name(isa) << " " << threads;
      EXPECT_EQ(drawing.rays, expected.rays);
    }
  }
}

TEST(Draw, SmoothEdgesLieBetweenWhatTheySeparate) {
  World world;
  add(world, BodyType::dynamic, {}, Sphere{1.0f});
  const Camera camera{{0.0f, 0.0f, 4.0f}, {}};
  Workers workers(1);
  DrawOptions options{.width = kWidth, .height = kHeight};
  const Drawing smooth = draw(world, camera, options, workers);
  options.smooth = false;
  const Drawing rough = draw(world, camera, options, workers);
  EXPECT_GT(smooth.rays, rough.rays);
  const int changed = count_different(smooth.picture, rough.picture);
  EXPECT_GT(changed, 100);
  EXPECT_LT(changed, kWidth * kHeight / 10);
}

TEST(Draw, WorldsOfNothingAndOfAnySizeAreDrawn) {
  EXPECT_NO_THROW(draw_at(World(), {}));
  for (const float size : {1e-4f, 1e-2f, 1e2f, 1e5f}) {
    World world;
    add(world, BodyType::dynamic, {}, Box{{size, size, size}});
    const Subject subject = subject_of(world);
    const Camera camera = look_from(Side::corner, subject, kDefaultView, 4.0 / 3.0);
    EXPECT_GT(count_different(draw_at(world, camera), draw_at(World(), camera)), kWidth * kHeight / 8)
        << size;
  }
}

TEST(Draw, WorldsAtTheirEndsAreDrawn) {
  for (const Vec3 place : {Vec3{9e6f, 0.0f, 0.0f}, Vec3{-9e6f, 9e6f, -9e6f}}) {
    for (const float size : {10.0f, 1e5f}) {
      World world;
      add(world, BodyType::dynamic, place, Box{{size, size, size}});
      const Subject subject = subject_of(world);
      for (const Side side : {Side::corner, Side::front, Side::side, Side::top}) {
        const Camera camera = look_from(side, subject, kDefaultView, 4.0 / 3.0);
        const int pixels = count_different(draw_at(world, camera), draw_at(World(), camera));
        EXPECT_GT(pixels, kWidth * kHeight / 60) << place.x << " " << size;
      }
    }
  }
  World wide;
  for (const float x : {-3e6f, 0.0f, 3e6f}) add(wide, BodyType::dynamic, {x, 0.0f, 0.0f}, Sphere{1e5f});
  const Camera camera = look_from(Side::front, subject_of(wide), kDefaultView, 4.0 / 3.0);
  EXPECT_GT(count_different(draw_at(wide, camera), draw_at(World(), camera)), 60);
}

TEST(Walls, AreWhatHidesTheSubjectAndNothingElse) {
  World world;
  add(world, BodyType::fixed, {0.0f, -0.5f, 0.0f}, Box{{20.0f, 0.5f, 20.0f}});
  ShapeId walls[4];
  const Vec3 places[4] = {{0.0f, 4.0f, 6.0f}, {6.0f, 4.0f, 0.0f}, {0.0f, 4.0f, -6.0f}, {-6.0f, 4.0f, 0.0f}};
  for (int i = 0; i < 4; ++i) {
    const Vec3 half = i % 2 == 0 ? Vec3{6.0f, 4.0f, 0.2f} : Vec3{0.2f, 4.0f, 6.0f};
    const BodyId wall = world.create_body({.type = BodyType::fixed, .position = places[i]});
    walls[i] = world.add_shape(wall, Box{half});
  }
  add(world, BodyType::fixed, {2.9f, 0.5f, 4.0f}, Box{{0.05f, 0.5f, 0.05f}});  // a post hides little
  for (int i = 0; i < 100; ++i)
    add(world, BodyType::dynamic,
        {static_cast<float>(i % 10) - 4.5f, 0.3f, static_cast<float>(i / 10) - 4.5f}, Sphere{0.3f});
  Workers workers(2);
  const Subject subject = subject_of(world);
  const auto hidden_from = [&](Side side) {
    const Camera camera = look_from(side, subject, kDefaultView, 1.5);
    return find_walls(world, camera.eye, subject, workers);
  };
  EXPECT_EQ(hidden_from(Side::front), (std::vector<ShapeId>{walls[0]}));
  EXPECT_EQ(hidden_from(Side::side), (std::vector<ShapeId>{walls[1]}));
  for (const ShapeId wall : hidden_from(Side::corner)) EXPECT_TRUE(wall == walls[0] || wall == walls[1]);
  EXPECT_TRUE(hidden_from(Side::top).empty());
}

TEST(Walls, BehindEachOtherAreAllFound) {
  World world;
  std::vector<ShapeId> walls;
  for (int i = 0; i < 3; ++i) {
    const BodyId wall =
        world.create_body({.type = BodyType::fixed, .position = {0.0f, 0.0f, 2.0f + static_cast<float>(i)}});
    walls.push_back(world.add_shape(wall, Box{{5.0f, 5.0f, 0.1f}}));
  }
  add(world, BodyType::dynamic, {}, Sphere{});
  Workers workers(1);
  EXPECT_EQ(find_walls(world, {0.0f, 0.0f, 10.0f}, subject_of(world), workers), walls);
}

TEST(Walls, AreNotTheGroundThatHidesWhatLiesInIt) {
  World world;
  std::vector<Vec3> vertices;
  std::vector<MeshTriangle> triangles;
  for (int i = 0; i < 8; ++i) {  // ridges along x, 2 m high and 4 m apart
    for (const float x : {-10.0f, 10.0f})
      vertices.push_back({x, i % 2 == 0 ? 0.0f : 2.0f, 7.0f - 2.0f * static_cast<float>(i)});
  }
  for (std::uint32_t i = 0; i < 14; i += 2) {
    triangles.push_back({i, i + 1, i + 2});
    triangles.push_back({i + 1, i + 3, i + 2});
  }
  const BodyId ground = world.create_body({.type = BodyType::fixed});
  world.add_shape(ground, TriangleMesh(vertices, triangles));
  for (int i = 0; i < 50; ++i)
    add(world, BodyType::dynamic, {0.3f * static_cast<float>(i % 25) - 3.0f, 0.3f, i < 25 ? 3.0f : -1.0f},
        Sphere{0.1f});
  Workers workers(1);
  const Subject subject = subject_of(world);
  const Vec3 eye{0.0f, 2.0f, 30.0f};
  EXPECT_TRUE(is_blocked(world, {eye, subject.middle - eye}));
  EXPECT_TRUE(find_walls(world, eye, subject, workers).empty());
}

TEST(Walls, MayBeOfADrumThatTurns) {
  World world;
  const BodyId drum = world.create_body({.type = BodyType::kinematic});
  ShapeId plates[2];
  for (int i = 0; i < 2; ++i)
    plates[i] = world.add_shape(drum, Box{{3.0f, 3.0f, 0.1f}}, {},
                                {.local_pose = {{0.0f, 0.0f, i == 0 ? 2.0f : -2.0f}, {}}});
  for (int i = 0; i < 30; ++i)
    add(world, BodyType::dynamic, {0.1f * static_cast<float>(i), 0.0f, 0.0f}, Sphere{0.1f});
  Workers workers(1);
  EXPECT_EQ(find_walls(world, {0.0f, 0.0f, 10.0f}, subject_of(world), workers),
            (std::vector<ShapeId>{plates[0]}));
}

TEST(Png, HoldsThePixels) {
  Picture picture{37, 21, {}};
  for (int i = 0; i < 3 * 37 * 21; ++i) picture.bytes.push_back(static_cast<std::uint8_t>(i * i + 7 * i));
  const std::string bytes = to_png(picture);
  png_image image;
  std::memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()), 0);
  image.format = PNG_FORMAT_RGB;
  ASSERT_EQ(image.width, 37u);
  ASSERT_EQ(image.height, 21u);
  std::vector<std::uint8_t> read(PNG_IMAGE_SIZE(image));
  ASSERT_NE(png_image_finish_read(&image, nullptr, read.data(), 0, nullptr), 0);
  EXPECT_EQ(read, picture.bytes);
}

}  // namespace
}  // namespace scree::render
