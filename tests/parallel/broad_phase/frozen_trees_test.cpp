// Laws of the trees of frozen shapes: their content, that the list of pairs does not depend on their history,
// and that the cost of a change follows its size.
#include "field.h"

#include <gtest/gtest.h>
#include <parallel/broad_phase/broad_phase.h>
#include <scree/scree.h>

#include <algorithm>
#include <set>
#include <vector>

namespace scree {
namespace {

using testing::Field;

constexpr float kTreeStep = 1.0f / 60.0f;

std::size_t at(std::int32_t row) { return static_cast<std::size_t>(row); }

// Every shape is in its body's tree, and the trees hold no other entries. A body that has woken within the
// step has moved out of its box there; its shapes are noted, to leave before the next list of pairs.
void expect_sound_trees(WorldData& data) {
  const BroadPhase& broad_phase = broad_phase_of(data);
  const std::set<std::int32_t> changed(broad_phase.changed.begin(), broad_phase.changed.end());
  std::vector<int> members(kPairTrees);
  for (std::size_t shape = 0; shape < broad_phase.tree_of.size(); ++shape) {
    const std::uint8_t index = broad_phase.tree_of[shape];
    ASSERT_LT(index, kPairTrees) << "shape " << shape;
    ++members[index];
    if (!is_frozen_tree(index)) continue;
    const PairTree& tree = broad_phase.trees[index];
    const std::int32_t slot = broad_phase.slot_of[shape];
    ASSERT_EQ(tree.order[at(slot)], static_cast<std::int32_t>(shape));
    EXPECT_EQ(tree.leaves[at(slot / simd::kBlock)].shape[slot % simd::kBlock],
              static_cast<std::int32_t>(shape));
    if (changed.contains(static_cast<std::int32_t>(shape))) continue;
    const BoundsRow& bounds = data.shapes.fat_bounds[shape];
    for (int level = 0, block = slot / simd::kBlock; level < tree.levels; ++level, block /= simd::kBlock) {
      const simd::NodeBlock& node = tree.nodes[level][at(block / simd::kBlock)];
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_LE(node.bounds[axis][block % simd::kBlock], bounds.lower[axis]);
        EXPECT_GE(node.bounds[axis + 3][block % simd::kBlock], bounds.upper[axis]);
      }
    }
  }
  for (int index = 1; index < kPairTrees; ++index) {
    const PairTree& tree = broad_phase.trees[index];
    EXPECT_EQ(tree.members, members[at(index)]) << "tree " << index;
    if (!is_frozen_tree(static_cast<std::uint8_t>(index))) continue;
    EXPECT_EQ(std::count_if(tree.order.begin(), tree.order.end(), [](std::int32_t row) { return row >= 0; }),
              tree.members);
  }
}

TEST(FrozenTrees, HoldEveryFrozenShapeOnceUnderRandomCalls) {
  Workers workers(2);
  int most_asleep = 0;
  for (const std::uint64_t seed : {3u, 4u, 6u, 8u, 20u}) {
    Field field(seed, 3000);
    for (int i = 0; i < 400; ++i) {
      for (int k = i % 7; k > 0; --k) field.change_something();
      step(field.world, kTreeStep, workers);
      expect_sound_trees(internals(field.world));
      if (HasFailure()) return;
    }
    EXPECT_GT(field.world.body_count(), 2800u);
    most_asleep = std::max(most_asleep, static_cast<int>(internals(field.world).bodies.asleep));
  }
  EXPECT_GT(most_asleep, 10);
}

TEST(FrozenTrees, RebuildingThemChangesNeitherBitsNorPairs) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    Workers workers(1), others(3);
    Field field(seed, 1000);
    Snapshot snapshot;
    World restored;
    bool hulls_rested = false;
    for (int i = 0; i < 300; ++i) {
      for (int k = i % 4; k > 0; --k) field.change_something();
      field.hulls = i > 100;
      save(field.world, snapshot);
      restore(restored, snapshot);
      step(field.world, kTreeStep, workers);
      step(restored, kTreeStep, others);
      ASSERT_EQ(field.world.hash(), restored.hash()) << "step " << i;
      const Contacts &old = internals(field.world).contacts, &fresh = internals(restored).contacts;
      hulls_rested = hulls_rested || !old.resting.axis.empty();
      EXPECT_EQ(old.resting_contacts, std::count_if(old.resting.contact.begin(), old.resting.contact.end(),
                                                    [](std::int32_t contact) { return contact >= 0; }));
      const auto same = [](ShapePair x, ShapePair y) { return x.a == y.a && x.b == y.b; };
      for (const auto rows : {&Contacts::pairs, &Contacts::resting}) {
        const Column<ShapePair>&x = (old.*rows).pair, &y = (fresh.*rows).pair;
        ASSERT_TRUE(std::equal(x.begin(), x.end(), y.begin(), y.end(), same)) << "step " << i;
        const std::size_t axes = (old.*rows).axis.size();
        EXPECT_TRUE(axes == x.size() || axes == 0) << axes << " of " << x.size();
      }
    }
    EXPECT_TRUE(hulls_rested);
  }
}

TEST(FrozenTrees, ListsOfMovingBodiesAndShapesEqualThoseOfARestoredWorld) {
  Workers workers(1);
  Field field(9, 4000);
  Snapshot snapshot;
  World restored;
  for (int i = 0; i < 200; ++i) {
    for (int k = i % 4; k > 0; --k) field.change_something();
    step(field.world, kTreeStep, workers);
    save(field.world, snapshot);
    restore(restored, snapshot);
    WorldData &old = internals(field.world), &fresh = internals(restored);
    Crew crew(workers);
    refresh_lists(old, crew);
    refresh_lists(fresh, crew);
    const auto same = [](const Column<std::int32_t>& x, const Column<std::int32_t>& y) {
      return std::equal(x.begin(), x.end(), y.begin(), y.end());
    };
    ASSERT_TRUE(same(old.bodies.awake, fresh.bodies.awake)) << "step " << i;
    ASSERT_TRUE(same(old.bodies.kinematic, fresh.bodies.kinematic)) << "step " << i;
    ASSERT_TRUE(same(old.shapes.moving, fresh.shapes.moving)) << "step " << i;
    ASSERT_EQ(old.bodies.asleep, fresh.bodies.asleep) << "step " << i;
  }
}

std::vector<std::int32_t> members_of(const PairTree& tree) {
  std::vector<std::int32_t> members;
  for (const std::int32_t shape : tree.order) {
    if (shape >= 0) members.push_back(shape);
  }
  return members;
}

TEST(FrozenTrees, ShapesThatFallAsleepTogetherKeepTheirOrder) {
  constexpr int kSide = 40, kBoxes = kSide * kSide;
  Workers workers(2);
  WorldSettings settings;
  settings.sleep_time = 0.05f;
  World world(settings);
  world.add_shape(world.create_body({.type = BodyType::fixed, .position = {0, -1, 0}}), Box{{200, 1, 200}});
  for (int i = 0; i < kBoxes; ++i) {
    const float x = 1.5f * static_cast<float>(i % kSide), z = 1.5f * static_cast<float>(i / kSide);
    world.add_shape(world.create_body({.position = {x, 0.5f, z}}), Box{});
  }
  WorldData& data = internals(world);
  for (int i = 0; i < 120 && world.sleep_begins().empty(); ++i) step(world, kTreeStep, workers);
  ASSERT_EQ(world.sleep_begins().size(), static_cast<std::size_t>(kBoxes));
  const std::vector<std::int32_t> awake = members_of(broad_phase_of(data).trees[kAwakeTree]);
  ASSERT_EQ(awake.size(), static_cast<std::size_t>(kBoxes));
  step(world, kTreeStep, workers);
  const auto trees = frozen_trees(broad_phase_of(data));
  const auto largest = std::max_element(
      trees.begin(), trees.end(), [](const PairTree& x, const PairTree& y) { return x.members < y.members; });
  EXPECT_EQ(members_of(*largest), awake);
  expect_sound_trees(data);
}

// Number of leaf blocks of frozen trees that a step rebuilds.
std::int64_t refitted(World& world, Workers& workers) {
  step(world, kTreeStep, workers);
  return broad_phase_of(internals(world)).refitted;
}

TEST(FrozenTrees, AChangeRebuildsAsFewBlocksInALargeWorldAsInASmallOne) {
  constexpr int kSteps = 1500;
  for (const int size : {2000, 20000}) {
    Workers workers(1);
    Field field(4, size);
    while (refitted(field.world, workers) > 0) {
    }
    std::int64_t total = 0, most = 0;
    for (int i = 0; i < kSteps; ++i) {
      field.add_box();
      const std::int64_t blocks = refitted(field.world, workers);
      most = std::max(most, blocks);
      total += blocks;
    }
    EXPECT_LT(total, 8 * kSteps) << size;
    EXPECT_LT(most, 300) << size << ": the trees of 4096 shapes, and no larger one";
  }
}

TEST(FrozenTrees, AHoleRebuildsItsLeafAndATreeOfMostlyHolesIsRebuilt) {
  Workers workers(1);
  World world;
  std::vector<BodyDef> defs(10000, {.type = BodyType::fixed});
  for (std::size_t i = 0; i < defs.size(); ++i) defs[i].position.x = 2.0f * static_cast<float>(i);
  std::vector<BodyId> bodies(defs.size());
  world.create_bodies(defs, std::vector<Geometry>(defs.size(), Box{}), {}, {}, bodies);
  while (refitted(world, workers) > 0) {
  }
  std::int64_t total = 0, most = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    world.destroy_body(bodies[i * 7919 % bodies.size()]);
    const std::int64_t blocks = refitted(world, workers);
    most = std::max(most, blocks);
    total += blocks;
    if (i == 4900) {
      EXPECT_EQ(most, 1) << "while most places are taken";
    }
  }
  EXPECT_LT(total, 2 * static_cast<std::int64_t>(bodies.size()));
  EXPECT_LE(most, 5000 / simd::kBlock + 1);
  for (const PairTree& tree : frozen_trees(broad_phase_of(internals(world)))) EXPECT_EQ(tree.levels, 0);
}

TEST(FrozenTrees, AStepThatFreezesAndReleasesNoShapeDoesNotChangeThem) {
  Workers workers(1);
  Field field(4, 2000);
  for (int i = 0; i < 20; ++i) field.add_ball();
  for (int i = 0; i < 600; ++i) step(field.world, kTreeStep, workers);
  ASSERT_EQ(field.world.stats().awake_bodies, 0);
  EXPECT_EQ(refitted(field.world, workers), 0);
  const BodyId ball = field.world.create_body({.position = {0, 1000, 0}});
  field.world.add_shape(ball, Sphere{});
  for (int i = 0; i < 50; ++i) EXPECT_EQ(refitted(field.world, workers), 0);
}

}  // namespace
}  // namespace scree
