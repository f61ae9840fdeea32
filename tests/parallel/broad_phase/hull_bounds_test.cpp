// Laws of the bounds of hulls: they contain every corner, are no larger than box and ball require, and have
// the same bits on every backend.
#include <core/geometry/hull/hull_build.h>
#include <core/world/math.h>
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <tests/parallel/hand_made_world.h>
#include <tools/scenes/random.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace scree::testing {
namespace {

using scenes::Random;

constexpr float kStep = 1.0f / 60.0f;  // s

Vec3 random_point(Random& random, float size) {
  const float x = random.between(-size, size), y = random.between(-size, size);
  return {x, y, random.between(-size, size)};
}

// Hulls of all shapes and places, slow and fast.
World make_world() {
  Random random(4);
  World world({.gravity = {}});
  for (int i = 0; i < 300; ++i) {
    std::vector<Vec3> points(4 + random.below(40));
    const Vec3 shift = random_point(random, 3.0f);
    for (Vec3& p : points) p = random_point(random, 1.0f) + shift;
    const float speed = i % 3 == 0 ? 20.0f : 0.01f;
    const BodyId body = world.create_body({.position = random_point(random, 100.0f),
                                           .rotation = random.rotation(),
                                           .linear_velocity = random_point(random, speed),
                                           .angular_velocity = random_point(random, speed)});
    const float x = random.between(0.5f, 2.0f), y = random.between(0.5f, 2.0f);
    world.add_shape(body, ConvexHull{Hull(points), {x, y, 0.3f}}, {},
                    {.local_pose = {random_point(random, 1.0f), random.rotation()}, .filter = {.mask = 0}});
  }
  return world;
}

TEST(HullBounds, HoldEveryCornerAndHaveTheSameBitsEverywhere) {
  std::vector<BoundsRow> expected;
  for (const WorkersOptions& options : all_workers()) {
    World world = make_world();
    Workers workers(options);
    for (int k = 0; k < 3; ++k) step(world, kStep, workers);
    const WorldData& data = internals(world);
    const Shapes& shapes = data.shapes;
    for (std::size_t s = 0; s < shapes.flags.size(); ++s) {
      const HullData& hull = *data.hulls.data[static_cast<std::size_t>(shapes.hull[s])];
      const PoseRow& pose = shapes.pose[s];
      const Quat rotation{pose.rotation[0], pose.rotation[1], pose.rotation[2], pose.rotation[3]};
      const BoundsRow& bounds = shapes.fat_bounds[s];
      const Vec3 place{pose.position[0], pose.position[1], pose.position[2]};
      float extent = 0.0f;
      for (int i = 0; i < hull.vertex_count; ++i) {
        const Vec3 corner =
            place + rotate(rotation, {hull.vertex[0][i], hull.vertex[1][i], hull.vertex[2][i]});
        const float c[3] = {corner.x, corner.y, corner.z};
        for (int k = 0; k < 3; ++k) {
          ASSERT_GE(c[k], bounds.lower[k] + 0.4f * kSpeculativeDistance) << s;
          ASSERT_LE(c[k], bounds.upper[k] - 0.4f * kSpeculativeDistance) << s;
        }
      }
      for (int k = 0; k < 3; ++k) extent = std::max(extent, 0.5f * (bounds.upper[k] - bounds.lower[k]));
      // Slow hulls have a margin of 5 cm; fast hulls half their path on both sides.
      const float* v = data.bodies.velocity[static_cast<std::size_t>(shapes.body[s])].linear;
      const float way = length(Vec3{v[0], v[1], v[2]}) * kStep;
      const float most =
          hull.outer_radius + 0.5f * kSpeculativeDistance + std::max(0.05f, 0.5f * way) + 1e-3f;
      EXPECT_LE(extent, most) << s;
      EXPECT_LE(bounds.sphere_radius, most) << s;
    }
    const auto rows = shapes.fat_bounds.span();
    if (expected.empty()) expected.assign(rows.begin(), rows.end());
    EXPECT_EQ(std::memcmp(expected.data(), rows.data(), rows.size_bytes()), 0);
  }
}

}  // namespace
}  // namespace scree::testing
