// Hulls in worlds: cached axes follow their pairs, instruction sets and threads agree, piles and stacks
// stand.
#include <core/world/world_data.h>
#include <gtest/gtest.h>
#include <scree/scree.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace scree {
namespace {

std::vector<Vec3> prism_points(int sides, float radius, float half_height) {
  std::vector<Vec3> points;
  for (int k = 0; k < sides; ++k) {
    const float angle = 6.2831853f * float(k) / float(sides);
    const float x = radius * std::cos(angle), z = radius * std::sin(angle);
    points.push_back({x, half_height, z});
    points.push_back({x, -half_height, z});
  }
  return points;
}

void add_ground(World& world) {
  const BodyId ground = world.create_body({.type = BodyType::fixed, .position = {0, -1, 0}});
  world.add_shape(ground, Box{.half_extents = {50, 1, 50}}, {.friction = 0.6f});
}

// Prisms of 3 to 9 sides, with a few boxes among them, above the ground.
World make_pile(int count) {
  World world;
  add_ground(world);
  for (int k = 0; k < count; ++k) {
    const int layer = k / 16, x = k % 4, z = k / 4 % 4;
    const BodyId body = world.create_body({.position = {1.1f * float(x) + 0.1f * float(layer % 3),
                                                        1.0f + 1.3f * float(layer), 1.2f * float(z)}});
    if (k % 7 == 3) {
      world.add_shape(body, Box{.half_extents = {0.4f, 0.3f, 0.5f}});
    } else {
      world.add_shape(body, ConvexHull{.hull = Hull(prism_points(3 + k % 7, 0.5f, 0.4f))});
    }
  }
  return world;
}

TEST(CollideHulls, KeptAxesFollowTheirPairsWhenTheListChanges) {
  World world = make_pile(160);
  Workers workers(2);
  const WorldData& data = internals(world);
  int changes = 0, touching = 0;
  std::size_t pairs = 0;
  for (int k = 0; k < 240; ++k) {
    step(world, 1.0f / 60.0f, workers);
    const PairRows& rows = data.contacts.pairs;
    changes += rows.pair.size() != pairs ? 1 : 0;
    pairs = rows.pair.size();
    for (std::size_t row = 0; row < pairs; ++row) {
      const auto is_hull = [&](std::int32_t shape) {
        return data.shapes.type[static_cast<std::size_t>(shape)] == ShapeType::hull;
      };
      if (!is_hull(rows.pair[row].a) && !is_hull(rows.pair[row].b)) continue;
      const bool touches = rows.contact[row] >= 0;
      ASSERT_EQ(rows.axis[row].feature != 0, touches) << "step " << k << " row " << row;
      touching += touches ? 1 : 0;
    }
  }
  EXPECT_GT(changes, 30);
  EXPECT_GT(touching, 10000);
}

TEST(CollideHulls, PilesComeToRest) {
  World world = make_pile(160);
  Workers workers(2);
  for (int k = 0; k < 1200; ++k) step(world, 1.0f / 60.0f, workers);
  EXPECT_LT(world.stats().awake_bodies, 16);
  EXPECT_EQ(world.stats().restored_bodies, 0);
}

std::vector<Vec3> cube_points(float half) {
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k) {
    corners.push_back({k & 1 ? half : -half, k & 2 ? half : -half, k & 4 ? half : -half});
  }
  return corners;
}

float deepest(const WorldData& data) {
  float least = 0.0f;
  for (const std::int32_t row : data.contacts.active) {
    const Manifold& manifold = data.contacts.now.manifold[static_cast<std::size_t>(row)];
    for (std::uint32_t k = 0; k < (manifold.info & kManifoldPointMask); ++k) {
      least = std::min(least, manifold.separation[k]);
    }
  }
  return least;
}

TEST(CollideHulls, AFastFallingBodyIsMetAtItsSurface) {
  for (const bool is_hull : {false, true}) {
    for (int height = 0; height < 16; ++height) {
      World world;
      add_ground(world);
      for (int layer = 0; layer < 2; ++layer) {
        // The upper hull meets a body that yields, the lower hull the ground.
        const float y = 0.5f + (layer == 0 ? 0.0f : 1.1f + 0.01f * float(height));
        const BodyId body =
            world.create_body({.position = {0, y, 0}, .linear_velocity = {0, -4.0f * float(layer), 0}});
        const Geometry cube = is_hull ? Geometry{ConvexHull{.hull = Hull(cube_points(0.5f))}}
                                      : Geometry{Box{.half_extents = {0.5f, 0.5f, 0.5f}}};
        world.add_shape(body, cube, {.friction = 0.6f});
      }
      Workers workers(1);
      for (int k = 0; k < 12; ++k) {
        step(world, 1.0f / 60.0f, workers);
        // 67 mm a step; a soft contact yields by a millimeter and a half.
        EXPECT_GT(deepest(internals(world)), -0.01f) << "height " << height << " step " << k;
      }
    }
  }
}

TEST(CollideHulls, PointsFollowAShapeFarFromItsCenterOfMass) {
  for (const bool is_hull : {false, true}) {
    WorldSettings settings;
    settings.gravity = {0, 0, 0};
    settings.sleeping = false;
    World world(settings);
    add_ground(world);
    const BodyId body = world.create_body({.position = {0, 5.2f, 0}, .angular_velocity = {0, 0, 0.3f}});
    for (const float y : {-5.0f, 5.0f}) {
      const Geometry foot = is_hull ? Geometry{ConvexHull{.hull = Hull(cube_points(0.2f))}}
                                    : Geometry{Box{.half_extents = {0.2f, 0.2f, 0.2f}}};
      ShapeOptions options;
      options.local_pose.position = {0, y, 0};
      world.add_shape(body, foot, {.friction = 0.0f}, options);
    }
    Workers workers(1);
    int touching = 0;
    for (int k = 0; k < 8; ++k) {
      const float foot = 5.0f * 2.0f * world.pose(body).rotation.z;
      step(world, 1.0f / 60.0f, workers);
      const Contacts& contacts = internals(world).contacts;
      for (const std::int32_t row : contacts.active) {
        const Manifold& manifold = contacts.now.manifold[static_cast<std::size_t>(row)];
        ++touching;
        EXPECT_NEAR(manifold.arm_b[0], foot, 0.21f + 0.03f) << "step " << k;
      }
    }
    EXPECT_GT(touching, 3);
  }
}

TEST(CollideHulls, StacksOfHullsStandAsThoseOfBoxesDo) {
  const auto top_of_stack = [](const Geometry& geometry) {
    WorldSettings settings;
    settings.sleeping = false;
    World world(settings);
    add_ground(world);
    BodyId top{};
    for (int k = 0; k < 30; ++k) {
      top = world.create_body({.position = {0, 0.5f + float(k), 0}});
      world.add_shape(top, geometry, {.friction = 0.6f});
    }
    Workers workers(1);
    for (int k = 0; k < 400; ++k) step(world, 1.0f / 60.0f, workers);
    return world.pose(top).position;
  };
  const Vec3 boxes = top_of_stack(Box{.half_extents = {0.5f, 0.5f, 0.5f}});
  const Vec3 hulls = top_of_stack(ConvexHull{.hull = Hull(cube_points(0.5f))});
  EXPECT_NEAR(hulls.y, boxes.y, 1e-3f);
  const Vec3 drums = top_of_stack(ConvexHull{.hull = Hull(prism_points(24, 0.6f, 0.5f))});
  EXPECT_GT(drums.y, 29.0f);
  for (const Vec3& top : {hulls, drums}) EXPECT_LT(std::hypot(top.x, top.z), 0.2f);
}

}  // namespace
}  // namespace scree
