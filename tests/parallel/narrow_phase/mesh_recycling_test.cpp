// Contacts with meshes of shapes that hardly move: they keep their points, and their separations follow.
#include <core/world/edit.h>
#include <gtest/gtest.h>
#include <scree/scree.h>

#include <array>
#include <vector>

namespace scree {
namespace {

// A gutter along z of two slopes of 45 degrees, and what lies in it. Steps of no time only collide.
struct Gutter {
  World world;
  Workers workers{1};
  BodyId body;

  explicit Gutter(const Geometry& shape, Quat rotation = {}) {
    const std::vector<Vec3> vertices = {{-4, 4, -5}, {0, 0, -5}, {4, 4, -5},
                                        {-4, 4, 5},  {0, 0, 5},  {4, 4, 5}};
    const std::vector<MeshTriangle> triangles = {{0, 3, 4}, {0, 4, 1}, {1, 4, 5}, {1, 5, 2}};
    world.add_shape(world.create_body({.type = BodyType::fixed}), TriangleMesh(vertices, triangles));
    body = world.create_body({.rotation = rotation});
    world.add_shape(body, shape);
  }

  struct Contact {
    Manifold manifold;
    ContactAnchor anchor;
  };
  std::vector<Contact> collide_at(Vec3 position) {
    world.set_pose(body, {position, world.pose(body).rotation});
    step(world, 0.0f, workers);
    const Contacts& contacts = internals(world).contacts;
    std::vector<Contact> all;
    for (const std::int32_t row : contacts.active) {
      all.push_back({contacts.now.manifold[row], contacts.now.anchor[row]});
    }
    return all;
  }
};

struct Lying {
  const char* name;
  Geometry shape;
  Quat rotation;
  float height;  // at which it touches both slopes, m
};
std::vector<Lying> lying() {
  constexpr float kHalfRoot = 0.70710678f, kSine = 0.38268343f, kCosine = 0.92387953f;
  return {{"box", Box{{0.5f, 0.5f, 0.5f}}, {0, 0, kSine, kCosine}, kHalfRoot},
          {"capsule", Capsule{0.5f, 0.5f}, {kHalfRoot, 0, 0, kHalfRoot}, kHalfRoot}};
}

TEST(MeshRecycling, WhatHardlyMovesKeepsItsPointsAndSeparationsFollow) {
  for (const Lying& each : lying()) {
    Gutter gutter(each.shape, each.rotation);
    const auto before = gutter.collide_at({0, each.height, 0});
    ASSERT_EQ(before.size(), 2u) << each.name;
    const auto after = gutter.collide_at({0, each.height + 0.004f, 0.003f});
    ASSERT_EQ(after.size(), 2u) << each.name;
    for (std::size_t i = 0; i < after.size(); ++i) {
      const Manifold &was = before[i].manifold, &is = after[i].manifold;
      EXPECT_EQ(after[i].anchor.offset[2], before[i].anchor.offset[2]) << each.name;
      ASSERT_EQ(is.info & kManifoldPointMask, each.name == std::string("box") ? 4u : 2u) << each.name;
      for (std::size_t k = 0; k < (is.info & kManifoldPointMask); ++k) {
        EXPECT_EQ(is.point_u[k], was.point_u[k]) << each.name;
        EXPECT_NEAR(is.separation[k] - was.separation[k], 0.004f * 0.70710678f, 1e-6f) << each.name;
      }
    }
  }
}

// One slope gets out of reach, and what the shape touches of the other is found anew.
TEST(MeshRecycling, APairIsRecycledWithAllItsContactsOrWithNone) {
  for (const Lying& each : lying()) {
    Gutter gutter(each.shape, each.rotation);
    constexpr float kNear = 0.015f * 0.70710678f, kFar = 0.021f * 0.70710678f;
    ASSERT_EQ(gutter.collide_at({kNear, each.height + kNear, 0}).size(), 2u) << each.name;
    const auto apart = gutter.collide_at({kFar, each.height + kFar, 0});
    ASSERT_EQ(apart.size(), 1u) << each.name;
    EXPECT_EQ(apart[0].anchor.offset[0], kFar) << each.name;
  }
}

TEST(MeshRecycling, NothingIsRecycledThatHasMovedByACentimeter) {
  for (const Lying& each : lying()) {
    Gutter gutter(each.shape, each.rotation);
    ASSERT_EQ(gutter.collide_at({0, each.height, 0}).size(), 2u) << each.name;
    for (const float way : {0.0101f, 0.5f}) {
      const auto moved = gutter.collide_at({0, each.height, way});
      ASSERT_EQ(moved.size(), 2u) << each.name;
      for (const auto& contact : moved) EXPECT_EQ(contact.anchor.offset[2], way) << each.name;
    }
  }
}

TEST(MeshRecycling, AThinShapeMayMoveByLess) {
  Gutter gutter(Capsule{0.5f, 0.02f}, {0.70710678f, 0, 0, 0.70710678f});
  const float height = 0.02f * 1.41421356f;
  ASSERT_FALSE(gutter.collide_at({0, height, 0}).empty());
  for (const auto& contact : gutter.collide_at({0, height, 0.001f}))
    EXPECT_EQ(contact.anchor.offset[2], 0.0f);
  for (const auto& contact : gutter.collide_at({0, height, 0.003f}))
    EXPECT_EQ(contact.anchor.offset[2], 0.003f);
}

// It must look ahead, for other parts of the mesh, too.
TEST(MeshRecycling, NothingIsRecycledThatIsFast) {
  for (const Lying& each : lying()) {
    Gutter gutter(each.shape, each.rotation);
    step(gutter.world, 1.0f / 60.0f, gutter.workers);  // so that steps have a length to look ahead
    ASSERT_FALSE(gutter.collide_at({0, each.height, 0}).empty()) << each.name;
    gutter.world.set_linear_velocity(gutter.body, {0, 0, 10});
    const auto moved = gutter.collide_at({0, each.height, 0.003f});
    ASSERT_FALSE(moved.empty()) << each.name;
    for (const auto& contact : moved) EXPECT_EQ(contact.anchor.offset[2], 0.003f) << each.name;
  }
}

}  // namespace
}  // namespace scree
