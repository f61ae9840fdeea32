// Worlds of cylinders, cones and rounded shapes: the same hash at every step on every backend, and after
// going back to a snapshot.
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <tests/determinism/backends.h>
#include <tests/determinism/many_threads.h>

#include <vector>

namespace scree::determinism::smooth {
namespace {

constexpr int kSteps = 150;

TriangleMesh hills() {
  constexpr std::uint32_t kSide = 12;
  std::vector<float> heights;
  for (std::uint32_t k = 0; k < kSide * kSide; ++k) {
    heights.push_back(0.2f * static_cast<float>(k * 7 % 5));
  }
  return height_field_mesh({.columns = kSide, .rows = kSide, .heights = heights});
}

Geometry shape_of(int kind, const Hull& rock) {
  switch (kind % 8) {
    case 0:
      return Cylinder{.half_height = 0.3f, .radius = 0.2f};
    case 1:
      return Cone{.half_height = 0.25f, .radius = 0.25f};
    case 2:
      return Box{{0.2f, 0.15f, 0.1f}, 0.08f};
    case 3:
      return ConvexHull{.hull = rock, .rounding = 0.05f};
    case 4:
      return Cylinder{.half_height = 0.03f, .radius = 0.3f};
    case 5:
      return Sphere{0.2f};
    case 6:
      return Capsule{0.2f, 0.15f};
    default:
      return kind % 16 == 7 ? Geometry{Box{{0.2f, 0.25f, 0.15f}}} : Geometry{ConvexHull{.hull = rock}};
  }
}

World heap() {
  World world;
  world.add_shape(world.create_body({.type = BodyType::fixed}), HalfSpace{});
  world.add_shape(world.create_body({.type = BodyType::fixed, .position = {-5.5f, 0.1f, -5.5f}}), hills());
  const Hull rock(std::vector<Vec3>{
      {0.3f, 0, 0}, {-0.3f, 0.05f, 0}, {0, 0.25f, 0}, {0, -0.25f, 0.05f}, {0, 0, 0.3f}, {0.05f, 0, -0.3f}});
  for (int k = 0; k < 96; ++k) {
    const float x = 0.8f * static_cast<float>(k % 4) - 1.2f, z = 0.8f * static_cast<float>(k / 4 % 4) - 1.2f;
    const Vec3 axis{1.0f, static_cast<float>(k % 3), static_cast<float>(k % 5)};
    const BodyId body =
        world.create_body({.position = {x, 1.5f + 0.8f * static_cast<float>(k / 16), z},
                           .rotation = from_axis_angle(normalize(axis), 0.7f * static_cast<float>(k))});
    world.add_shape(body, shape_of(k, rock), {.friction = 0.5f, .restitution = k % 9 == 0 ? 0.4f : 0.0f});
  }
  return world;
}

std::vector<std::uint64_t> play(World& world, const Schedule& schedule, int steps) {
  Shift shift(schedule);
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < steps; ++i) {
    step(world, 1.0f / 60.0f, shift.at(i));
    hashes.push_back(world.hash());
  }
  return hashes;
}

class SmoothShapes : public ManyThreads {};

TEST_F(SmoothShapes, EveryBackendGivesTheSameHashAtEveryStep) {
  World reference = heap();
  const std::vector<std::uint64_t> expected = play(reference, {kReference}, kSteps);
  EXPECT_GT(reference.stats().contacts, 100);
  for (const Schedule& schedule : schedules(wants_full_matrix())) {
    World world = heap();
    EXPECT_EQ(play(world, schedule, kSteps), expected) << name_of(schedule);
  }
}

TEST_F(SmoothShapes, AWorldThatGoesBackRepeatsItself) {
  World world = heap();
  play(world, {kReference}, 60);
  Snapshot snapshot;
  save(world, snapshot);
  const std::vector<std::uint64_t> expected = play(world, {kReference}, 60);
  restore(world, snapshot);
  EXPECT_EQ(play(world, {kReference}, 60), expected);
}

}  // namespace
}  // namespace scree::determinism::smooth
