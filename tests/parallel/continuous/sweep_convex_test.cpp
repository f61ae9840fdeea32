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
      const float size = round % 3 == 0 ? 0.01f : round % 3 == 1 ? 1.0f : 100.0f;
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

}  // namespace
}  // namespace scree::testing
