// Laws of saving without memory: the snapshot is then empty, and snapshots saved before or afterwards are
// correct.
#include <core/state/snapshot/snapshot.h>
#include <core/world/edit.h>
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <tests/parallel/allocations.h>

#include <new>
#include <utility>
#include <vector>

namespace scree {
namespace {

std::vector<std::byte> bytes_of_all(World& world) {
  WorldData& data = internals(world);
  LastSave last = std::exchange(data.last_save, {});
  place_matter(data);
  Snapshot whole;
  SnapshotAccess::data(whole) = std::make_unique<SnapshotData>();
  save_world(data, *SnapshotAccess::data(whole), false);
  data.last_save = std::move(last);
  return write_snapshot(whole);
}

bool saves(const World& world, Snapshot& snapshot) {
  const FailingAllocations failing(FailingAllocations::Of::this_thread);
  try {
    save(world, snapshot);
  } catch (const std::bad_alloc&) {
    return false;
  }
  return true;
}

TEST(SavingMemory, ThatRunsOutLeavesTheSnapshotEmptyAndTheNextOneWhole) {
  World world;
  std::vector<BodyId> bodies(1000);
  world.create_bodies(std::vector<BodyDef>(1000, BodyDef{.type = BodyType::fixed}),
                      std::vector<Geometry>(1000), {}, {}, bodies);
  Snapshot kept, again;
  save(world, kept);
  save(world, again);
  const std::vector<std::byte> before = write_snapshot(kept);
  // Pages that are shared with another snapshot need memory when they change: some sheets are done by then.
  world.destroy_body(bodies[500]);
  ASSERT_FALSE(saves(world, again));
  EXPECT_TRUE(again.is_empty());
  EXPECT_EQ(write_snapshot(kept), before);
  world.destroy_body(bodies[700]);
  save(world, again);
  EXPECT_EQ(write_snapshot(again), bytes_of_all(world));
  EXPECT_EQ(write_snapshot(kept), before);

  // In place, so that the pages of the last save are lost with it.
  kept = Snapshot();
  world.create_bodies(std::vector<BodyDef>(900), std::span(bodies).first(900));
  ASSERT_FALSE(saves(world, again));
  EXPECT_TRUE(again.is_empty());
  save(world, kept);
  EXPECT_EQ(write_snapshot(kept), bytes_of_all(world));
}

TEST(SavingMemory, IsUsedAgainInAWindowOfSnapshots) {
  World world;
  world.add_shape(world.create_body({.type = BodyType::fixed, .position = {0, -1, 0}}), Box{{50, 1, 50}});
  for (int i = 0; i < 150; ++i) {
    const BodyId body = world.create_body(
        {.position = {static_cast<float>(i % 15) * 1.5f, 2.0f, static_cast<float>(i / 15) * 1.5f},
         .can_sleep = false});
    world.add_shape(body, Box{{0.4f, 0.3f, 0.5f}});
  }
  Workers workers(1);
  std::vector<Snapshot> window(4);
  const auto go_on = [&](std::size_t steps) {
    for (std::size_t i = 0; i < steps; ++i) {
      step(world, 1.0f / 60.0f, workers);
      save(world, window[i % window.size()]);
    }
  };
  go_on(400);
  const long before = allocations_so_far();
  go_on(100);
  EXPECT_EQ(allocations_so_far() - before, 0);
}

}  // namespace
}  // namespace scree
