// Pairs that are too far apart to touch before both have moved farther: the narrow phase passes over them,
// and no bit of the world depends on whether it does.
#include <core/world/world_data.h>
#include <gtest/gtest.h>
#include <parallel/narrow_phase/narrow_phase.h>
#include <scree/scree.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace scree {
namespace {

constexpr float kStep = 1.0f / 60.0f;

Hull wedge(float radius, float height, int sides) {
  std::vector<Vec3> points;
  for (int k = 0; k < sides; ++k) {
    const float angle = 6.2831853f * float(k) / float(sides);
    points.push_back({radius * std::cos(angle), height, radius * std::sin(angle)});
    points.push_back({0.6f * radius * std::cos(angle), -height, 0.6f * radius * std::sin(angle)});
  }
  return Hull(points);
}

// Rings of hulls, boxes, and one hull each, that fall on a floor and into one another.
struct Heap {
  World world;
  std::vector<BodyId> bodies;
  std::vector<ShapeId> shapes;
};
Heap make_heap(bool sleeps) {
  Heap heap{.world = World({.sleeping = sleeps}), .bodies = {}, .shapes = {}};
  World& world = heap.world;
  const auto add = [&](BodyId body, const Geometry& geometry, const ShapeOptions& options = {}) {
    heap.shapes.push_back(world.add_shape(body, geometry, {.friction = 0.6f}, options));
  };
  const BodyId ground = world.create_body({.type = BodyType::fixed, .position = {0, -1, 0}});
  add(ground, Box{.half_extents = {50, 1, 50}});
  const Hull part = wedge(0.25f, 0.15f, 5), whole = wedge(0.5f, 0.4f, 9);
  for (int k = 0; k < 40; ++k) {
    const BodyId body = world.create_body(
        {.position = {1.1f * float(k % 3), 1.0f + 0.9f * float(k / 6), 1.2f * float(k / 3 % 2)}});
    heap.bodies.push_back(body);
    if (k % 4 == 3) {
      add(body, ConvexHull{.hull = whole});
    } else if (k % 4 == 2) {
      add(body, Box{.half_extents = {0.3f, 0.2f, 0.5f}});
    } else {
      for (int p = 0; p < 8; ++p) {
        const float angle = 6.2831853f * float(p) / 8.0f;
        add(body, ConvexHull{.hull = part},
            {.local_pose = {.position = {0.5f * std::cos(angle), 0, 0.5f * std::sin(angle)},
                            .rotation = {}}});
      }
    }
  }
  return heap;
}

const NarrowPhase& narrow_phase_of(const World& world) {
  return static_cast<const NarrowPhase&>(*internals(world).narrow_phase);
}

struct Looks {
  int skipped = 0, collided = 0;  // pairs that do not touch
};
Looks looks_of(const World& world) {
  Looks looks;
  const PairRows& pairs = internals(world).contacts.pairs;
  const NarrowPhase& phase = narrow_phase_of(world);
  for (std::size_t row = 0; row < pairs.pair.size(); ++row) {
    if (pairs.contact[row] >= 0) continue;
    ++(phase.kind[row] == kSkipped ? looks.skipped : looks.collided);
  }
  return looks;
}

// A world that was restored knows no clearance, and collides every pair anew.
void expect_same_step(World& world, Workers& workers, const ContactFilter& filter, int number,
                      float dt = kStep) {
  Snapshot before, after, expected;
  save(world, before);
  step(world, dt, workers);
  save(world, after);
  World fresh;
  restore(fresh, before);
  if (filter) fresh.set_contact_filter(filter);
  step(fresh, dt, workers);
  save(fresh, expected);
  ASSERT_EQ(write_snapshot(after), write_snapshot(expected)) << "step " << number;
}

TEST(PairClearance, NoBitDependsOnWhatIsKnownOfPairsThatAreApart) {
  for (const bool sleeps : {false, true}) {
    World world = std::move(make_heap(sleeps).world);
    Workers workers(2);
    int skipped = 0;
    for (int k = 0; k < 300; ++k) {
      expect_same_step(world, workers, {}, k);
      skipped += looks_of(world).skipped;
    }
    EXPECT_GT(skipped, 20000) << sleeps;
  }
}

// Restoring in place keeps the memory, but nothing of what was known.
TEST(PairClearance, IsForgottenWhenAWorldIsRestoredInPlace) {
  World world = std::move(make_heap(false).world);
  Workers workers(2);
  Snapshot early, late, again;
  for (int k = 0; k < 150; ++k) step(world, kStep, workers);
  save(world, early);
  for (int k = 0; k < 5; ++k) step(world, kStep, workers);
  save(world, late);
  EXPECT_GT(looks_of(world).skipped, 0);
  restore(world, early);
  step(world, kStep, workers);
  EXPECT_EQ(looks_of(world).skipped, 0);
  for (int k = 0; k < 4; ++k) step(world, kStep, workers);
  save(world, again);
  EXPECT_EQ(write_snapshot(again), write_snapshot(late));
}

// At 15 Hz, bodies of 0.15 m/s are fast; some fall asleep while they are.
TEST(PairClearance, StepsOfAnyLengthGiveTheSameBits) {
  World world = std::move(make_heap(true).world);
  Workers workers(2);
  const float lengths[] = {kStep, 0.0f, 2.0f * kStep, 4.0f * kStep, 0.0f, 0.0f, 0.25f * kStep};
  for (int k = 0; k < 210; ++k) expect_same_step(world, workers, {}, k, lengths[k % 7]);
}

// A world goes on beside one that was restored from it, which learns its clearances later.
TEST(PairClearance, RestoredWorldsKeepStep) {
  World world = std::move(make_heap(true).world);
  Workers workers(2);
  for (int k = 0; k < 60; ++k) step(world, kStep, workers);
  World other = clone(world);
  for (int k = 0; k < 240; ++k) {
    Snapshot a, b;
    save(world, a);
    save(other, b);
    ASSERT_EQ(write_snapshot(a), write_snapshot(b)) << k;
    step(world, kStep, workers);
    step(other, kStep, workers);
  }
}

// A hull that drifts alone falls asleep. One that comes behind at the same speed must still find it.
TEST(PairClearance, WhatFollowsASleeperMeetsIt) {
  constexpr float kSpeed = 0.04f, kGap = 0.04f;
  World world({.gravity = {}});
  const auto add = [&](BodyType type, float x) {
    const BodyId body =
        world.create_body({.type = type, .position = {x, 0, 0}, .linear_velocity = {kSpeed, 0, 0}});
    std::vector<Vec3> corners;
    for (int k = 0; k < 8; ++k) {
      corners.push_back({k & 1 ? 0.5f : -0.5f, k & 2 ? 0.5f : -0.5f, k & 4 ? 0.5f : -0.5f});
    }
    world.add_shape(body, ConvexHull{.hull = Hull(corners)});
    return body;
  };
  const BodyId sleeper = add(BodyType::dynamic, 0.0f), follower = add(BodyType::kinematic, -1.0f - kGap);
  Workers workers(1);
  bool slept = false;
  for (int k = 0; k < 300; ++k) {
    step(world, kStep, workers);
    slept = slept || !world.is_awake(sleeper);
    const float way = world.pose(sleeper).position.x - world.pose(follower).position.x;
    ASSERT_GT(way, 0.99f) << k;
  }
  EXPECT_TRUE(slept);
}

// A snapshot in which the body rests, into a world in which it moves.
TEST(PairClearance, MotionIsForgottenWhenAWorldIsRestoredInPlace) {
  World world({.gravity = {}});
  const Hull hull = wedge(0.5f, 0.5f, 8);
  const BodyId fixed = world.create_body({.type = BodyType::fixed});
  world.add_shape(fixed, ConvexHull{.hull = hull});
  const BodyId body = world.create_body({.position = {-1.2f, 0, 0}});
  world.add_shape(body, ConvexHull{.hull = hull});
  Snapshot at_rest;
  save(world, at_rest);
  Workers workers(1);
  world.set_body_type(fixed, BodyType::kinematic);
  world.set_linear_velocity(fixed, {0.5f, 0, 0});
  for (int k = 0; k < 5; ++k) step(world, kStep, workers);
  restore(world, at_rest);
  world.set_linear_velocity(body, {0.5f, 0, 0});
  for (int k = 0; k < 60; ++k) expect_same_step(world, workers, {}, k);
  EXPECT_LT(world.pose(body).position.x, -0.8f);
}

// Needles across a grid, and as many between them, which come nearer: all bounds overlap, and one more round
// of pairs is collided where nothing is known.
TEST(PairClearance, RowsOfNewContactsDoNotDependOnRounds) {
  constexpr int kSide = 10;
  constexpr float kSpacing = 0.1f, kHalf = 0.005f;
  World world({.gravity = {}, .sleeping = false});
  const Vec3 along = (1.0f / std::sqrt(3.0f)) * Vec3{1, 1, 1};
  const Vec3 right = (1.0f / std::sqrt(2.0f)) * Vec3{1, -1, 0}, up = cross(along, right);
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k) {
    corners.push_back((k & 1 ? 0.8f : -0.8f) * along + (k & 2 ? kHalf : -kHalf) * right +
                      (k & 4 ? kHalf : -kHalf) * up);
  }
  const Hull needle(corners);
  for (const float side : {0.0f, 1.0f}) {
    const BodyId body = world.create_body({.position = (0.5f * kSpacing * side) * (right + up),
                                           .linear_velocity = (-0.3f * side) * (right + up)});
    for (int k = 0; k < kSide * kSide; ++k) {
      const Vec3 place = (kSpacing * float(k / kSide)) * right + (kSpacing * float(k % kSide)) * up;
      world.add_shape(body, ConvexHull{.hull = needle}, {},
                      {.local_pose = {.position = place, .rotation = {}}});
    }
  }
  Workers workers(2);
  std::int64_t most = 0, contacts = 0;
  for (int k = 0; k < 20; ++k) {
    expect_same_step(world, workers, {}, k);
    most = std::max(most, world.stats().pairs);
    contacts = std::max(contacts, world.stats().contacts);
  }
  EXPECT_GT(most, std::int64_t{kRoundChunks} * simd::kCollideChunk);
  EXPECT_GT(contacts, 50);
}

TEST(PairClearance, CallsBetweenStepsAreSeen) {
  Heap heap = make_heap(true);
  World& world = heap.world;
  Workers workers(1);
  std::mt19937 random(5);
  const auto pick = [&](int count) { return std::uniform_int_distribution<int>(0, count - 1)(random); };
  const auto some = [&] { return std::uniform_real_distribution<float>(-0.04f, 0.04f)(random); };
  for (int k = 0; k < 240; ++k) {
    const BodyId body = heap.bodies[static_cast<std::size_t>(pick(40))];
    const Pose pose = world.pose(body);
    const int call = pick(7);
    if (call == 0) world.set_pose(body, {pose.position + Vec3{some(), some(), some()}, pose.rotation});
    if (call == 1) world.set_linear_velocity(body, 50.0f * Vec3{some(), some(), some()});
    if (call == 2) world.set_body_type(body, pick(2) == 0 ? BodyType::dynamic : BodyType::kinematic);
    if (call == 3) world.set_body_type(body, BodyType::fixed);
    if (call == 4) world.wake(body);
    if (call == 5) world.set_angular_velocity(body, 100.0f * Vec3{some(), some(), some()});
    if (call == 6) world.set_geometry(heap.shapes.back(), ConvexHull{.hull = wedge(0.4f, 0.2f, 4 + pick(4))});
    expect_same_step(world, workers, {}, k);
  }
}

TEST(PairClearance, HooksThatRefusePairsAreHeard) {
  Heap heap = make_heap(false);
  World& world = heap.world;
  for (const ShapeId shape : heap.shapes) world.set_contact_hooks(shape, ContactHooks::filter);
  // What it refuses changes as bodies move.
  const ContactFilter filter = [](const ContactFilterBatch& batch) {
    for (std::size_t i = 0; i < batch.pairs.size(); ++i) {
      const HookedPair& pair = batch.pairs[i];
      const float height = 20.0f * batch.world.pose(pair.body_b).position.y;
      batch.collide[i] = (static_cast<int>(height) + static_cast<int>(pair.shape_a.index)) % 5 != 0 ? 1 : 0;
    }
  };
  world.set_contact_filter(filter);
  Workers workers(2);
  for (int k = 0; k < 150; ++k) expect_same_step(world, workers, filter, k);
}

TEST(PairClearance, MostPairsOfAPileAtRestThatDoNotTouchAreSkipped) {
  World world = std::move(make_heap(false).world);
  Workers workers(2);
  for (int k = 0; k < 400; ++k) step(world, kStep, workers);
  Looks all;
  for (int k = 0; k < 60; ++k) {
    step(world, kStep, workers);
    const Looks looks = looks_of(world);
    all.skipped += looks.skipped;
    all.collided += looks.collided;
  }
  EXPECT_GT(all.skipped, 6000);
  EXPECT_GT(all.skipped, 9 * all.collided);
}

}  // namespace
}  // namespace scree
