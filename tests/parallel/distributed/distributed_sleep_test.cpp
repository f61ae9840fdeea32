// Laws of sleep in a world that is divided among ranks.
#include <scree/distributed_world.h>
#include <scree/snapshot.h>
#include <scree/step.h>
#include <tests/parallel/distributed/local_ranks.h>
#include <tests/parallel/distributed/step_ranks.h>

#include <algorithm>
#include <set>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace scree {
namespace {

using namespace distributed_tests;
using physics::kStep;
using physics::Lab;

// Two heaps fall asleep, a ball that comes late wakes one of them, and a plate on a joint pulls at a row.
void fill_with_sleepers(Lab& lab) {
  lab.add_ground();
  for (int i = 0; i < 48; ++i) {
    const float x = (i % 2 == 0 ? -6.0f : 6.0f) + 0.9f * static_cast<float>(i / 2 % 4);
    lab.add({.position = {x, 0.5f + 1.01f * static_cast<float>(i / 8), 0.1f * static_cast<float>(i % 3)}},
            Box{{0.4f, 0.5f, 0.4f}});
  }
  BodyId last = lab.add({.position = {0, 0.5f, 8}}, Box{{0.4f, 0.5f, 0.4f}});
  for (int i = 1; i < 8; ++i) {
    const BodyId next = lab.add({.position = {static_cast<float>(i), 0.5f, 8}}, Box{{0.4f, 0.5f, 0.4f}});
    lab.world.create_joint(
        {.body_a = last, .body_b = next, .frame_a = {{0.5f, 0, 0}, {}}, .frame_b = {{-0.5f, 0, 0}, {}}},
        BallJoint{});
    last = next;
  }
  for (const float x : {-5.0f, 7.5f})
    lab.add({.position = {x, 90, 0}, .linear_velocity = {0, x, 0}}, Sphere{0.6f});
}

TEST(DistributedSleep, HasTheBitsOfOneProcess) {
  const RunPlan run{.steps = 420, .sleeping = true};
  Lab lab(settings_for_ranks(true));
  fill_with_sleepers(lab);
  std::int32_t most_asleep = 0;
  int wakes = 0;
  for (int i = 0; i < run.steps; ++i) {
    const std::int32_t before = internals(lab.world).bodies.asleep;
    lab.run(1);
    most_asleep = std::max(most_asleep, internals(lab.world).bodies.asleep);
    wakes += internals(lab.world).bodies.asleep < before ? 1 : 0;
  }
  EXPECT_GE(most_asleep, 40);
  EXPECT_GE(wakes, 1);
  for (const int ranks : {2, 5}) {
    for (const int steps_per_draw : {0, 1, 40}) {
      expect_same_bits(
          fill_with_sleepers, random_owner,
          {.ranks = ranks, .steps = run.steps, .sleeping = true, .steps_per_draw = steps_per_draw});
    }
  }
  expect_same_bits(scene("ragdolls", {{"ragdolls", 6}}), random_owner,
                   {.ranks = 3, .steps = 400, .sleeping = true, .steps_per_draw = 9});
}

// Most pairs stay at rest, and most ghosts stay where they are, while some bodies get new owners.
TEST(DistributedSleep, HasTheBitsOfOneProcessWhileSomeOwnersChange) {
  for (const int ranks : {2, 5}) {
    for (const int one_in : {3, 40}) {
      expect_same_bits(
          fill_with_sleepers, random_owner,
          {.ranks = ranks, .steps = 420, .sleeping = true, .steps_per_draw = 1, .one_in = one_in});
    }
  }
  expect_same_bits(scene("ragdolls", {{"ragdolls", 6}}), random_owner,
                   {.ranks = 3, .steps = 400, .sleeping = true, .steps_per_draw = 2, .one_in = 9});
  expect_same_bits(scene("terrain", {{"bodies", 80}, {"triangles", 5000}}), random_owner,
                   {.ranks = 4, .steps = 400, .sleeping = true, .steps_per_draw = 1, .one_in = 20});
}

// A step in which one sleeper gets another owner costs by that one, not by all that sleep: its pairs alone
// leave the list of those at rest, and of ghosts those alone are sent that lie around it.
TEST(DistributedSleep, ANewOwnerOfOneBodyCostsByItsPairs) {
  constexpr int kRanks = 3;
  const auto fill = [](Lab& lab) {
    lab.add_ground();
    for (int i = 0; i < 400; ++i) {
      const Vec3 at = {static_cast<float>(i % 20), 0.5f + 0.99f * static_cast<float>(i / 100),
                       static_cast<float>(i / 20 % 5)};
      lab.add({.position = at}, Box{{0.5f, 0.5f, 0.5f}});
    }
  };
  LocalRanks local(kRanks);
  std::vector<std::string> errors(kRanks);
  std::vector<std::int64_t> resting(kRanks), pulled(kRanks), bytes_before(kRanks), bytes_after(kRanks);
  const auto step_rank = [&](int rank) {
    const auto place = static_cast<std::size_t>(rank);
    try {
      Lab lab(settings_for_ranks(true));
      fill(lab);
      WorldData& data = internals(lab.world);
      std::vector<std::int32_t> owners;
      for (std::size_t body = 0; body < data.bodies.flags.size(); ++body)
        owners.push_back(static_cast<std::int32_t>(body) % 20 / 7);
      divide_world(data, local.at(rank), owners);
      lab.run(200);
      EXPECT_EQ(data.bodies.awake.size(), 0u);
      resting[place] = static_cast<std::int64_t>(data.contacts.resting.pair.size());
      Border& border = *border_of(data);
      border.transport.begin_step();
      lab.run(1);
      bytes_before[place] = border.transport.sent().bytes;
      constexpr std::int32_t kMoved = kFirstBody + 213;
      const std::vector<GivenBody> given = {{kMoved, (border.owner_of(kMoved) + 1) % kRanks}};
      Crew crew(lab.workers);
      give_bodies(data, border.owns(kMoved) ? std::span(given) : std::span<const GivenBody>(), crew);
      pulled[place] = resting[place] - static_cast<std::int64_t>(data.contacts.resting.pair.size());
      border.transport.begin_step();
      lab.run(1);
      bytes_after[place] = border.transport.sent().bytes;
      EXPECT_EQ(data.contacts.pairs.pair.size(), 0u) << "they rest again";
    } catch (const std::exception& error) {
      errors[place] = error.what();
    }
    local.leave(rank);
  };
  std::vector<std::thread> threads;
  for (int rank = 1; rank < kRanks; ++rank) threads.emplace_back(step_rank, rank);
  step_rank(0);
  for (std::thread& thread : threads) thread.join();
  for (std::size_t rank = 0; rank < kRanks; ++rank) {
    EXPECT_EQ(errors[rank], "");
    EXPECT_GT(resting[rank], 500);
    EXPECT_LE(pulled[rank], 40);
    if (pulled[rank] == 0) {
      EXPECT_LE(bytes_after[rank], bytes_before[rank] + 64);
    }
  }
  EXPECT_EQ(std::count(pulled.begin(), pulled.end(), 0), kRanks - 1) << "who gave it alone";
}

// All ranks know all pairs at rest of a world that was just shared out.
TEST(DistributedSleep, OwnersOfSleepersMayChangeBeforeTheFirstStep) {
  World one;
  one.add_shape(one.create_body({.type = BodyType::fixed}), HalfSpace{});
  for (int i = 0; i < 200; ++i) {
    const Vec3 at = {static_cast<float>(i % 10), 0.5f + 0.99f * static_cast<float>(i / 100),
                     static_cast<float>(i / 10 % 10)};
    one.add_shape(one.create_body({.position = at}), Box{{0.5f, 0.5f, 0.5f}});
  }
  Workers workers(1);
  for (int i = 0; i < 200; ++i) step(one, kStep, workers);
  EXPECT_EQ(one.stats().awake_bodies, 0);
  Snapshot sleeping;
  save(one, sleeping);
  const auto create = [](World& world) {
    for (int i = 0; i < 150; ++i) {
      const float x = 12.0f + static_cast<float>(i % 15), y = 1.0f + static_cast<float>(i / 15);
      world.add_shape(world.create_body({.position = {x, y, 0}}), Sphere{0.4f});
    }
  };
  create(one);
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < 20; ++i) {
    step(one, kStep, workers);
    hashes.push_back(one.hash());
  }
  const auto errors = run_ranks(3, [&](int rank, Transport& transport) {
    World restored;
    restore(restored, sleeping);
    DistributedWorld world(std::move(restored), transport);
    Workers of_rank(1);
    world.give(
        [&](World& part) {
          if (rank == 0) create(part);
        },
        of_rank);
    for (int i = 0; i < 20; ++i) {
      world.step(kStep, of_rank);
      ASSERT_EQ(world.hash(), hashes[static_cast<std::size_t>(i)]) << "step " << i;
      const Column<ShapePair>& rest = internals(world.world()).contacts.resting.pair;
      std::set<std::pair<std::int32_t, std::int32_t>> each;
      for (const ShapePair& pair : rest) each.insert({pair.a, pair.b});
      ASSERT_EQ(each.size(), rest.size()) << "step " << i;
    }
  });
  EXPECT_EQ(all_of(errors), "");
}

// A ball that a bullet strikes goes, in the same step, to a wall that sleeps on another rank and that nothing
// of its own rank was near.
TEST(DistributedSleep, WhatIsStruckMeetsSleepersOfOtherRanksInTheSameStep) {
  const auto fill = [](Lab& lab) {
    lab.add_ground();
    for (int i = 0; i < 30; ++i) {
      const float x = 1.01f * static_cast<float>(i % 10);
      lab.add({.position = {x, 0.5f + static_cast<float>(i / 10), 1.3f}}, Box{{0.5f, 0.5f, 0.25f}});
    }
    lab.add({.position = {0, 0.3f, 0}}, Sphere{0.3f});
    // Beside the ball, so that this one does not go where the bullet would have gone.
    lab.add({.position = {-700.7f, 0.35f, -0.42f}, .linear_velocity = {390, 0, 0}, .gravity_factor = 0},
            Sphere{0.3f});
  };
  const auto by_place = [](std::int32_t body, int) { return body < kFirstBody + 31 ? 1 : 0; };
  Lab lab(settings_for_ranks(true));
  fill(lab);
  int woken_at = 0;
  std::int32_t most_asleep = 0;
  for (int i = 0; i < 160; ++i) {
    const std::int32_t before = internals(lab.world).bodies.asleep;
    lab.run(1);
    most_asleep = std::max(most_asleep, internals(lab.world).bodies.asleep);
    if (woken_at == 0 && internals(lab.world).bodies.asleep < before) woken_at = i;
  }
  EXPECT_GE(most_asleep, 30);
  EXPECT_GT(woken_at, 0);
  expect_same_bits(fill, by_place, {.ranks = 2, .steps = 160, .sleeping = true});
}

}  // namespace
}  // namespace scree
