// A step in the steady state allocates nothing. Counts every malloc and aligned_alloc of the program,
// including those of TBB. Sanitizers replace the allocator, so these tests do not exist under them.
#include <tests/physics/lab.h>

#include <atomic>
#include <cstdlib>

#if defined(__GLIBC__) && !defined(SCREE_SANITIZED)
namespace {
std::atomic<long> allocations{0};
}

#define SCREE_COUNTED extern "C" __attribute__((visibility("default")))
extern "C" void* __libc_malloc(std::size_t);
extern "C" void* __libc_calloc(std::size_t, std::size_t);
extern "C" void* __libc_realloc(void*, std::size_t);
extern "C" void* __libc_memalign(std::size_t, std::size_t);
SCREE_COUNTED void* malloc(std::size_t size) noexcept {
  allocations.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(size);
}
SCREE_COUNTED void* calloc(std::size_t count, std::size_t size) noexcept {
  allocations.fetch_add(1, std::memory_order_relaxed);
  return __libc_calloc(count, size);
}
SCREE_COUNTED void* realloc(void* memory, std::size_t size) noexcept {
  allocations.fetch_add(1, std::memory_order_relaxed);
  return __libc_realloc(memory, size);
}
SCREE_COUNTED void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  allocations.fetch_add(1, std::memory_order_relaxed);
  return __libc_memalign(alignment, size);
}

namespace scree::physics {
namespace {

long allocations_of(Lab& lab, int steps) {
  const long before = allocations.load();
  lab.run(steps);
  return allocations.load() - before;
}

TEST(Allocation, IsCounted) {
  const long before = allocations.load();
  Lab lab;
  lab.add_ground();
  EXPECT_GT(allocations.load(), before);
}

TEST(Allocation, NeverHappensInAStepOfARestingHeap) {
  for (const int threads : {1, 2}) {
    Lab lab;
    lab.workers = Workers(threads);
    add_heap(lab, 150, 6, {.friction = 0.7f, .restitution = 0.1f, .rolling_resistance = 0.01f});
    lab.run(500);
    EXPECT_EQ(allocations_of(lab, 100), 0) << threads << " threads";
  }
}

TEST(Allocation, NeverHappensInAStepOfAPyramid) {
  SceneLab pyramid("large_pyramid", {{"base", 40}});
  pyramid.lab.run(150);
  EXPECT_EQ(allocations_of(pyramid.lab, 60), 0);
}

TEST(Allocation, NeverHappensWhenSnapshotsAndWorldsAreUsedAgain) {
  SceneLab zoo("hull_zoo", {{"bodies", 100}});
  zoo.lab.run(150);
  Snapshot before, after;
  save(zoo.lab.world, before);
  zoo.lab.run(30);
  save(zoo.lab.world, after);
  for (int i = 0; i < 3; ++i) {
    const long so_far = allocations.load();
    restore(zoo.lab.world, before);
    save(zoo.lab.world, after);
    if (i > 0) {  // both snapshots have held the larger state
      EXPECT_EQ(allocations.load() - so_far, 0) << i;
    }
    zoo.lab.run(30);
  }
}

TEST(Allocation, NeverHappensWhenSleepersWake) {
  // Calls wake bodies after they have changed the world: by then they must not run out of memory.
  Lab lab(WorldSettings{});
  lab.add_ground();
  std::vector<BodyId> boxes;
  for (int i = 0; i < 200; ++i) {
    boxes.push_back(lab.add({.position = {2.0f * static_cast<float>(i), 0.5f, 0}}, Box{}));
  }
  lab.run(120);
  Snapshot asleep;
  save(lab.world, asleep);
  World other;
  restore(other, asleep);
  for (World* world : {&lab.world, &other}) {
    ASSERT_FALSE(world->is_awake(boxes.front()));
    const long before = allocations.load();
    for (const BodyId box : boxes) world->wake(box);
    EXPECT_EQ(allocations.load() - before, 0);
    EXPECT_TRUE(world->is_awake(boxes.back()));
  }
}

TEST(Allocation, NeverHappensInAStepOfBodiesOnTheMove) {
  // Balls on a belt that runs against a wall: contacts keep beginning and ending.
  Lab lab;
  lab.add_ground({.friction = 0.8f, .surface_velocity = {3, 0, 0}});
  lab.add({.type = BodyType::fixed, .position = {6, 5, 0}}, Box{{1, 6, 30}});
  Random random(8);
  for (int i = 0; i < 60; ++i) {
    lab.add({.position = {random.uniform(-5, 4), 0.5f + 0.1f * static_cast<float>(i), random.uniform(-3, 3)}},
            Sphere{0.3f});
  }
  lab.run(2000);  // until each list has been as long as it will be
  EXPECT_EQ(allocations_of(lab, 100), 0);
}

TEST(Allocation, NeverHappensInAStepOfManyWorlds) {
  Lab labs[4];
  World* worlds[4];
  for (int i = 0; i < 4; ++i) {
    labs[i].add_ground();
    for (int k = 0; k < 40; ++k) {
      labs[i].add({.position = {2.0f * static_cast<float>(k / 4), 0.5f + static_cast<float>(k % 4), 0}},
                  Box{});
    }
    worlds[i] = &labs[i].world;
  }
  Workers workers(2);
  for (int i = 0; i < 300; ++i) step(worlds, kStep, workers);
  const long before = allocations.load();
  for (int i = 0; i < 50; ++i) step(worlds, kStep, workers);
  EXPECT_EQ(allocations.load() - before, 0);
}

TEST(Allocation, NeverHappensInAStepThatListsItsEvents) {
  WorldSettings settings = without_sleep();
  settings.contact_events = ContactEvents::all;
  for (const int threads : {1, 2}) {
    Lab lab(settings);
    lab.workers = Workers(threads);
    add_heap(lab, 150, 6, {.friction = 0.7f, .restitution = 0.1f, .rolling_resistance = 0.01f});
    lab.run(500);
    EXPECT_EQ(allocations_of(lab, 100), 0) << threads << " threads";
    EXPECT_GT(lab.world.contact_persists().size(), 100u);
  }
}

TEST(Allocation, NeverHappensInAStepThatSweepsBodies) {
  for (const int threads : {1, 2}) {
    Lab lab(without_gravity());
    lab.workers = Workers(threads);
    const BodyId room = lab.world.create_body({.type = BodyType::fixed});
    for (const float side : {-5.0f, 5.0f}) {
      for (const Vec3 offset : {Vec3{side, 0, 0}, Vec3{0, side, 0}, Vec3{0, 0, side}}) {
        const Vec3 size{offset.x != 0 ? 0.1f : 5.0f, offset.y != 0 ? 0.1f : 5.0f,
                        offset.z != 0 ? 0.1f : 5.0f};
        lab.world.add_shape(room, Box{size}, {.friction = 0, .restitution = 1}, {.local_pose = {offset, {}}});
      }
    }
    Random random(8);
    for (int i = 0; i < 40; ++i) {
      lab.add({.position = random.vector(4), .linear_velocity = random.vector(200)}, Sphere{0.1f},
              {.friction = 0, .restitution = 1});
    }
    lab.run(1500);  // few balls touch at once: it takes long until the most have
    EXPECT_EQ(allocations_of(lab, 100), 0) << threads << " threads";
    EXPECT_GT(lab.world.stats().swept_bodies, 20);
  }
}

TEST(Allocation, NeverHappensInAStepWhoseCallbackMakesTheRowsOfUserJoints) {
  for (const int threads : {1, 2}) {
    Lab lab;
    lab.workers = Workers(threads);
    for (int i = 0; i < 300; ++i) {
      const BodyId body = lab.add({.position = {3.0f * static_cast<float>(i), 0, 0}}, Sphere{0.5f});
      lab.world.create_joint({.body_a = kWorld, .body_b = body}, UserJoint{});
    }
    lab.world.set_user_row_callback([](const UserRowBatch& batch) {
      for (std::size_t i = 0; i < batch.joints.size(); ++i) {
        batch.jacobians[kMaxUserRows * i].linear_b = {0, 1, 0};
        batch.targets[kMaxUserRows * i].speed += 1e-4f;
      }
    });
    lab.run(60);
    EXPECT_EQ(allocations_of(lab, 60), 0) << threads << " threads";
  }
}

TEST(Allocation, NeverHappensInAStepWithHooksOfContacts) {
  for (const int threads : {1, 2}) {
    Lab lab;
    lab.workers = Workers(threads);
    const BodyId ground = lab.add_ground();
    ShapeId shape;
    lab.world.shapes_of(ground, {&shape, 1});
    lab.world.set_contact_hooks(shape, ContactHooks::all);
    for (int i = 0; i < 300; ++i) lab.add({.position = {1.1f * static_cast<float>(i), 0.5f, 0}}, Box{});
    lab.world.set_contact_filter([](const ContactFilterBatch& batch) {
      for (std::size_t i = 0; i < batch.pairs.size(); ++i)
        batch.collide[i] = batch.pairs[i].shape_b.index % 7 != 0;
    });
    lab.world.set_contact_rule([](const ContactRuleBatch& batch) {
      for (ContactRules& rules : batch.rules) rules.friction = 0.3f;
    });
    lab.run(240);  // until those that fall are fast
    EXPECT_EQ(allocations_of(lab, 60), 0) << threads << " threads";
  }
}

TEST(Allocation, NeverHappensInAStepOfSleepers) {
  Lab lab{WorldSettings{}};
  lab.add_ground();
  for (int i = 0; i < 20; ++i) lab.add({.position = {2.0f * static_cast<float>(i), 0.5f, 0}}, Box{});
  lab.run(200);
  EXPECT_EQ(allocations_of(lab, 50), 0);
}

}  // namespace
}  // namespace scree::physics

#endif
