// Laws of the bounds of cylinders, cones and rounded shapes: they hold every point, are as tight as boxes
// along the world's axes can be, and have the same bits on every backend.
#include <core/geometry/hull/hull_build.h>
#include <core/world/math.h>
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <tests/parallel/hand_made_world.h>
#include <tests/parallel/queries/query_fixture.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace scree::testing {
namespace {

constexpr float kBoundsStep = 1.0f / 60.0f;  // s

Geometry round_geometry(Dice& dice, float size) { return dice.geometry(size, 4 + dice.below(4)); }

// Slow, fast and spinning shapes of all sizes.
World make_round_world(float spin) {
  Dice dice(41);
  World world({.gravity = {}});
  for (int i = 0; i < 400; ++i) {
    const float speed = i % 3 == 0 ? 20.0f : 0.01f, size = i % 5 == 0 ? 30.0f : i % 5 == 1 ? 0.01f : 1.0f;
    const Vec3 place = dice.within({100, 100, 100}), linear = dice.within({speed, speed, speed});
    const BodyId body = world.create_body({.position = place,
                                           .rotation = i % 7 == 0 ? Quat{} : dice.rotation(),
                                           .linear_velocity = linear,
                                           .angular_velocity = dice.within({spin, spin, spin})});
    const Geometry geometry = round_geometry(dice, size);
    const Vec3 local = i % 2 == 0 ? Vec3{} : dice.within({1, 1, 1});
    const Quat turn = i % 7 == 0 ? Quat{} : dice.rotation();
    world.add_shape(body, geometry, {}, {.local_pose = {local, turn}, .filter = {.mask = 0}});
  }
  return world;
}

// The ball about the box's middle holds the points that are the farthest along random directions.
void expect_in_ball(const Placed& placed, const BoundsRow& bounds, std::uint64_t seed) {
  const Point middle = 0.5 * (Point{bounds.lower[0], bounds.lower[1], bounds.lower[2]} +
                              Point{bounds.upper[0], bounds.upper[1], bounds.upper[2]});
  Dice dice(seed);
  for (int i = 0; i < 60; ++i) {
    const Point random = to_point(dice.within({1, 1, 1}));
    if (!(norm(random) > 0.1)) continue;
    const Point along = (1.0 / norm(random)) * random;
    EXPECT_GE(bounds.sphere_radius,
              reach_along(placed, along) - dot(middle, along) + 0.4 * double{kSpeculativeDistance})
        << seed;
  }
}

constexpr Point kAxes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

void expect_held(const World& world, ShapeId shape) {
  const Placed placed = placed_of(world, shape);
  const BoundsRow& bounds = internals(world).shapes.fat_bounds[shape.index];
  for (int k = 0; k < 3; ++k) {
    const double upper = reach_along(placed, kAxes[k]), lower = -reach_along(placed, -1.0 * kAxes[k]);
    EXPECT_GE(bounds.upper[k], upper + 0.4 * double{kSpeculativeDistance}) << shape.index;
    EXPECT_LE(bounds.lower[k], lower - 0.4 * double{kSpeculativeDistance}) << shape.index;
  }
  expect_in_ball(placed, bounds, shape.index);
}

TEST(RoundBounds, HoldEveryPointAndHaveTheSameBitsEverywhere) {
  for (const float spin : {0.01f, 20.0f, 300.0f}) {
    std::vector<BoundsRow> expected;
    for (const WorkersOptions& options : all_workers()) {
      World world = make_round_world(spin);
      Workers workers(options);
      for (int k = 0; k < 3; ++k) step(world, kBoundsStep, workers);
      const Shapes& shapes = internals(world).shapes;
      const auto rows = shapes.fat_bounds.span();
      if (expected.empty()) {
        expected.assign(rows.begin(), rows.end());
        for (std::size_t s = 0; s < shapes.flags.size(); ++s)
          expect_held(world, shape_handle(internals(world), static_cast<std::int32_t>(s)));
      }
      EXPECT_EQ(std::memcmp(expected.data(), rows.data(), rows.size_bytes()), 0);
    }
  }
}

// What does not move has no margin but half of the speculative distance and rounding.
TEST(RoundBounds, OfFixedShapesAreAsTightAsCanBe) {
  Dice dice(42);
  World world;
  std::vector<ShapeId> shapes;
  for (int i = 0; i < 300; ++i) {
    const float size = i % 3 == 0 ? 30.0f : i % 3 == 1 ? 0.01f : 1.0f;
    const Vec3 place = dice.within({100, 100, 100});
    const BodyId body = world.create_body(
        {.type = BodyType::fixed, .position = place, .rotation = i % 7 == 0 ? Quat{} : dice.rotation()});
    shapes.push_back(world.add_shape(body, dice.geometry(size, 4 + dice.below(3))));
  }
  Workers workers(1);
  step(world, kBoundsStep, workers);
  for (const ShapeId shape : shapes) {
    const Placed placed = placed_of(world, shape);
    const BoundsRow& bounds = internals(world).shapes.fat_bounds[shape.index];
    constexpr double kPad = 0.5 * double{kSpeculativeDistance}, kRoom = 3e-4;
    double diagonal = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double upper = reach_along(placed, kAxes[k]), lower = -reach_along(placed, -1.0 * kAxes[k]);
      EXPECT_NEAR(bounds.upper[k], upper + kPad, kRoom) << shape.index;
      EXPECT_NEAR(bounds.lower[k], lower - kPad, kRoom) << shape.index;
      diagonal += 0.25 * (upper - lower) * (upper - lower);
    }
    expect_in_ball(placed, bounds, shape.index);
    if (std::holds_alternative<Cone>(placed.geometry)) {
      EXPECT_LE(bounds.sphere_radius, std::sqrt(diagonal) + kPad + kRoom);
    }
  }
}

// The disk of an upright cone's base does not count at its apex.
TEST(RoundBounds, OfAConeAreThoseOfApexAndBase) {
  World world({.gravity = {}});
  const BodyId body =
      world.create_body({.type = BodyType::fixed, .rotation = from_axis_angle({0, 0, 1}, -0.5f)});
  const ShapeId shape = world.add_shape(body, Cone{2.0f, 0.5f});
  Workers workers(1);
  step(world, kBoundsStep, workers);
  const BoundsRow& bounds = internals(world).shapes.fat_bounds[shape.index];
  const double sine = std::sin(0.5), cosine = std::cos(0.5), pad = 0.5 * double{kSpeculativeDistance};
  EXPECT_NEAR(bounds.upper[0], 2.0 * sine + pad, 1e-5);
  EXPECT_NEAR(bounds.lower[0], -2.0 * sine - 0.5 * cosine - pad, 1e-5);
  EXPECT_NEAR(bounds.upper[1], 2.0 * cosine + pad, 1e-5);
  EXPECT_NEAR(bounds.lower[1], -2.0 * cosine - 0.5 * sine - pad, 1e-5);
  EXPECT_NEAR(bounds.upper[2], 0.5 + pad, 1e-5);
}

}  // namespace
}  // namespace scree::testing
