// Laws of the distances that sweeps use: never above the true one, exact for all but hulls, and with the
// slope along the path.
#include <parallel/continuous/sweep_convex.h>
#include <parallel/queries/query_distance.h>
#include <tests/parallel/queries/query_fixture.h>

#include <cmath>

namespace scree::testing {
namespace {

using queries::Gap;

// What queries find, in double precision.
double distance_in_world(const WorldData& data, std::int32_t shape, Vec3 point) {
  queries::Solid asking;
  asking.position = queries::to_vector(point);
  return queries::gap_between(asking, queries::solid_of(data, shape)).distance;
}

// In the shape's frame.
double true_distance(const WorldData& data, std::int32_t shape, Vec3 point) {
  queries::Solid other = queries::solid_of(data, shape), asking;
  other.position = {};
  other.axes = {};
  asking.position = queries::to_vector(point);
  return queries::gap_between(asking, other).distance;
}

struct Obstacle {
  World world;
  std::int32_t shape = 0;
  explicit Obstacle(const Geometry& geometry)
      : shape(static_cast<std::int32_t>(
            world.add_shape(world.create_body({.type = BodyType::fixed}), geometry).index)) {
    Workers workers(1);
    step(world, 0.01f, workers);
  }
  const WorldData& data() const { return internals(world); }
  sweeps::Distance at(Vec3 start, Vec3 motion, float t = 0.0f) const {
    return sweeps::ConvexObstacle{data(), shape}.distance_at({start, motion}, t);
  }
};

TEST(SweepConvex, DistancesAreTrueOrLowerBounds) {
  Dice dice(51);
  for (std::uint32_t kind = 0; kind < 8; ++kind) {
    for (int round = 0; round < 25; ++round) {
      const bool is_needle = kind % 4 == 3;  // perhaps, and thinner than hulls may be if it is small
      const float size = round % 3 == 0 ? (is_needle ? 0.5f : 0.01f) : round % 3 == 1 ? 1.0f : 100.0f;
      const Obstacle obstacle(dice.geometry(size, kind));
      const bool is_hull = has_hull(obstacle.data().shapes.type[obstacle.shape]);
      const float outer = sweeps::outer_radius_of(obstacle.data(), obstacle.shape);
      for (int i = 0; i < 80; ++i) {
        const Vec3 point = dice.within({2.5f * size, 2.5f * size, 2.5f * size});
        const Vec3 motion = dice.within({size, size, size});
        const sweeps::Distance found = obstacle.at(point, motion);
        const double expected = true_distance(obstacle.data(), obstacle.shape, point);
        const double rounding = 2e-6 * double{size};
        if (!(expected > 0.0)) {
          EXPECT_LE(found.value, rounding) << kind;
          continue;
        }
        EXPECT_LE(found.value, expected + rounding) << kind;
        EXPECT_GE(found.value, length(point) - outer - 4e-6f * size) << kind;
        if (!is_hull) {
          EXPECT_NEAR(found.value, expected, 2.0 * rounding) << kind;
        }
        if (!(found.value > 0.01f * size)) continue;
        EXPECT_NEAR(length(found.normal), 1.0f, 1e-5f);
        EXPECT_NEAR(found.slope, dot(found.normal, motion), 1e-5f * size);
        // A convex function: no value along the path lies below a tangent.
        for (const float t : {-0.5f, 0.25f, 1.0f}) {
          EXPECT_GE(obstacle.at(point, motion, t).value, found.value + t * found.slope - 1e-5f * size)
              << kind << " " << t;
        }
      }
    }
  }
}

TEST(SweepConvex, SlenderAndFlatShapesKeepTheirDistances) {
  for (const Geometry& geometry : {Geometry{Cylinder{1e-4f, 1e3f}}, Geometry{Cylinder{1e3f, 1e-4f}},
                                   Geometry{Cone{1e-4f, 1e3f}}, Geometry{Cone{1e3f, 1e-4f}}}) {
    const Obstacle obstacle(geometry);
    Dice dice(52);
    for (int i = 0; i < 300; ++i) {
      const Vec3 point = dice.within({1500, 1500, 1500});
      const double expected = true_distance(obstacle.data(), obstacle.shape, point);
      EXPECT_NEAR(obstacle.at(point, {}).value, expected, 1e-6 * 1500);
    }
    // On the axis, above and below.
    const double half = std::visit(
        [](const auto& shape) {
          if constexpr (requires { shape.half_height; }) return double{shape.half_height};
          return 0.0;
        },
        geometry);
    EXPECT_NEAR(obstacle.at({0, 1500, 0}, {}).value, 1500 - half, 1e-3);
    EXPECT_NEAR(obstacle.at({0, -1500, 0}, {}).value, 1500 - half, 1e-3);
  }
}

// In one step, from outside: there its contact takes over.
TEST(SweepConvex, AFastBallStopsAtTheSurfaceOfEveryShape) {
  Dice dice(53);
  for (std::uint32_t kind = 0; kind < 8; ++kind) {
    for (int shot = 0; shot < 20; ++shot) {
      World world({.gravity = {}});
      Workers workers(1);
      const BodyId fixed = world.create_body({.type = BodyType::fixed, .rotation = dice.rotation()});
      const ShapeId obstacle = world.add_shape(fixed, dice.geometry(1.0f, kind));
      step(world, 0.01f, workers);
      // Aimed at a point within the shape.
      const Vec3 middle = to_vec3(internals(world).shapes.pose[obstacle.index].position);
      const Vec3 from = 4.0f * normalize(dice.within({1, 1, 1}) + Vec3{0, 1.2f, 0});
      const BodyId ball = world.create_body({.position = middle + from, .linear_velocity = -100.0f * from});
      world.add_shape(ball, Sphere{0.05f});
      step(world, 1.0f / 60.0f, workers);
      EXPECT_EQ(world.stats().sweep_hits, 1) << kind;
      const double gap = distance_in_world(internals(world), static_cast<std::int32_t>(obstacle.index),
                                           world.pose(ball).position);
      EXPECT_GT(gap, 0.049) << kind;
      // At sharp corners of hulls the bound is not the distance.
      if (kind != 3) {
        EXPECT_LT(gap, kind == 7 ? 0.3 : 0.052) << kind;
      }
    }
  }
}

TEST(SweepConvex, FastShapesOfEveryKindStopAtAThinWall) {
  Dice dice(54);
  for (std::uint32_t kind = 4; kind < 8; ++kind) {
    for (int shot = 0; shot < 20; ++shot) {
      World world({.gravity = {}});
      Workers workers(1);
      world.add_shape(world.create_body({.type = BodyType::fixed, .position = {5, 0, 0}}),
                      Box{{0.005f, 50, 50}});
      const BodyId bullet = world.create_body({.position = {0, static_cast<float>(shot % 5), 0},
                                               .rotation = dice.rotation(),
                                               .linear_velocity = {400, 0, 0},
                                               .angular_velocity = dice.within({20, 20, 20})});
      world.add_shape(bullet, dice.geometry(0.2f, kind));
      step(world, 1.0f / 60.0f, workers);
      EXPECT_EQ(world.stats().sweep_hits, 1) << kind;
      EXPECT_LT(world.center_of_mass(bullet).x, 5.0f) << kind;
    }
  }
}

}  // namespace
}  // namespace scree::testing
