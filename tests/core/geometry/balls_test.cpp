// Laws of the balls that stand for shapes in sweeps: they lie within, and the first is the largest.
#include <core/geometry/balls.h>
#include <core/world/world_data.h>
#include <tests/core/world/world_fixture.h>

#include <cmath>
#include <vector>

namespace scree::test {
namespace {

// How far a ball about (across, y) sticks out of the profile of a cylinder or a cone.
double beyond(const Geometry& geometry, double x, double y, double z, double radius) {
  const double across = std::sqrt(x * x + z * z);
  if (const auto* cylinder = std::get_if<Cylinder>(&geometry)) {
    return std::max(across + radius - double{cylinder->radius},
                    std::abs(y) + radius - double{cylinder->half_height});
  }
  if (const auto* cone = std::get_if<Cone>(&geometry)) {
    const double half = cone->half_height, height = 2.0 * half, size = cone->radius;
    const double side = (height * across - size * (half - y)) / std::hypot(height, size);
    return std::max(side, -half - y) + radius;
  }
  const Box& box = std::get<Box>(geometry);
  const Vec3 half = box.half_extents;
  // A ball within the box within, made larger by the rounding; or one of the rounding about a point of it.
  const double least = radius - double{box.rounding};
  return std::max(
             {std::abs(x) - double{half.x}, std::abs(y) - double{half.y}, std::abs(z) - double{half.z}}) +
         std::max(least, 0.0);
}

TEST(Balls, LieWithinCylindersConesAndRoundedBoxes) {
  for (const float a : {1e-4f, 0.1f, 1.0f, 30.0f, 1e5f}) {
    for (const float b : {1e-4f, 0.1f, 1.0f, 30.0f, 1e5f}) {
      for (const Geometry& geometry : {Geometry{Cylinder{a, b}}, Geometry{Cone{a, b}},
                                       Geometry{Box{{a, b, b}, 0.25f}}, Geometry{Box{{a, b, 1.0f}, a}}}) {
        World world;
        const ShapeId shape = world.add_shape(world.create_body({.type = BodyType::fixed}), geometry);
        const Balls balls = balls_of(internals(world), static_cast<std::int32_t>(shape.index));
        ASSERT_GE(balls.count, 1);
        ASSERT_LE(balls.count, kMostBalls);
        const double size = std::max(double{a}, double{b});
        for (int i = 0; i < balls.count; ++i) {
          const Ball& ball = balls.ball[i];
          EXPECT_GT(ball.radius, 0.0f);
          EXPECT_LE(ball.radius, balls.ball[0].radius);
          EXPECT_LE(beyond(geometry, double{ball.center.x}, double{ball.center.y}, double{ball.center.z},
                           double{ball.radius}),
                    2e-7 * size)
              << geometry.index() << " " << a << " " << b << ", ball " << i;
        }
        // It is the largest that fits.
        if (const auto* cylinder = std::get_if<Cylinder>(&geometry)) {
          EXPECT_EQ(balls.ball[0].radius, std::min(cylinder->radius, cylinder->half_height));
        } else if (std::holds_alternative<Cone>(geometry)) {
          const double height = 2.0 * double{a}, radius = b;
          EXPECT_NEAR(balls.ball[0].radius, height * radius / (radius + std::hypot(radius, height)),
                      1e-6 * double{balls.ball[0].radius});
        }
      }
    }
  }
}

TEST(Balls, TheInnerRadiusIsThatOfTheFirst) {
  const Hull hull(std::vector<Vec3>{{-3, 0, -1}, {3, 0, -1}, {3, 0, 1}, {-3, 0, 1}, {0, 0.5f, 0}});
  World world;
  const BodyId body = world.create_body({.type = BodyType::fixed});
  for (const Geometry& geometry :
       {Geometry{Sphere{0.3f}}, Geometry{Capsule{2.0f, 0.2f}}, Geometry{Box{{3, 0.1f, 2}}},
        Geometry{Box{{3, 1, 0.5f}, 0.25f}}, Geometry{Cylinder{1, 0.2f}}, Geometry{Cone{1, 2}},
        Geometry{ConvexHull{hull}}, Geometry{ConvexHull{hull, {2, 1, 1}, 0.5f}}}) {
    const auto shape = static_cast<std::int32_t>(world.add_shape(body, geometry).index);
    EXPECT_EQ(inner_radius_of(internals(world), shape), balls_of(internals(world), shape).ball[0].radius)
        << geometry.index();
  }
  const auto plane = static_cast<std::int32_t>(world.add_shape(body, HalfSpace{}).index);
  EXPECT_EQ(inner_radius_of(internals(world), plane), 0.0f);
}

TEST(Balls, OfARoundedHullAreThoseOfTheHullMadeLarger) {
  const std::vector<Vec3> points{{-3, 0, -1}, {3, 0, -1}, {3, 0, 1}, {-3, 0, 1}, {0, 0.5f, 0}};
  const Hull hull(points);
  World world;
  const BodyId body = world.create_body({});
  const ShapeId sharp = world.add_shape(body, ConvexHull{hull});
  const ShapeId round = world.add_shape(body, ConvexHull{hull, {1, 1, 1}, 0.75f});
  const Balls a = balls_of(internals(world), static_cast<std::int32_t>(sharp.index));
  const Balls b = balls_of(internals(world), static_cast<std::int32_t>(round.index));
  ASSERT_EQ(a.count, b.count);
  ASSERT_GT(a.count, 1);
  for (int i = 0; i < a.count; ++i) {
    EXPECT_EQ(a.ball[i].center, b.ball[i].center);
    EXPECT_FLOAT_EQ(b.ball[i].radius, a.ball[i].radius + 0.75f);
  }
}

}  // namespace
}  // namespace scree::test
