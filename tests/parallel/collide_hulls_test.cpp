// Hulls in worlds: what is remembered of a pair follows it, instruction sets and threads agree, piles and
// stacks stand.
#include <core/world_data.h>
#include <gtest/gtest.h>
#include <scree/scree.h>

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

TEST(CollideHulls, WhatIsRememberedFollowsItsPairWhereTheListChanges) {
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
  for (int k = 0; k < 900; ++k) step(world, 1.0f / 60.0f, workers);
  EXPECT_LT(world.stats().awake_bodies, 16);
  EXPECT_EQ(world.stats().restored_bodies, 0);
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
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k) {
    corners.push_back({k & 1 ? 0.5f : -0.5f, k & 2 ? 0.5f : -0.5f, k & 4 ? 0.5f : -0.5f});
  }
  const Vec3 boxes = top_of_stack(Box{.half_extents = {0.5f, 0.5f, 0.5f}});
  const Vec3 hulls = top_of_stack(ConvexHull{.hull = Hull(corners)});
  EXPECT_NEAR(hulls.y, boxes.y, 1e-3f);
  const Vec3 drums = top_of_stack(ConvexHull{.hull = Hull(prism_points(24, 0.6f, 0.5f))});
  EXPECT_GT(drums.y, 29.0f);
  for (const Vec3& top : {hulls, drums}) EXPECT_LT(std::hypot(top.x, top.z), 0.2f);
}

}  // namespace
}  // namespace scree
