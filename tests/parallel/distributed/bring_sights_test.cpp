// The law of sights that no bounds foresaw: where forces of a step carry sensors, and what they see, into and
// past bodies of other ranks, each rank tells in this very step what one process tells of the rank's bodies.
#include <gtest/gtest.h>
#include <parallel/distributed/border.h>
#include <scree/distributed_world.h>
#include <scree/step.h>
#include <tests/parallel/bodies/overload.h>
#include <tests/parallel/distributed/absent_rows.h>
#include <tests/parallel/distributed/local_ranks.h>
#include <tests/parallel/distributed/step_ranks.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace scree {
namespace {

using distributed_tests::all_of;
using distributed_tests::redraw_owners;
using distributed_tests::run_ranks;
using distributed_tests::scramble_absent_rows;
using physics::kStep;

constexpr int kHeapBodies = 200;
constexpr float kBallRadius = 0.05f,
                kBallMass = 1000 * 4.0f / 3 * 3.1415927f * kBallRadius * kBallRadius * kBallRadius;

// Two heaps without gravity, and a gap between them. Some bodies have sensors, thin or thick, some have two
// balls.
World make_heaps(std::vector<BodyId>& bodies) {
  WorldSettings settings;
  settings.gravity = {};
  World world(settings);
  physics::Random random(12);
  for (int i = 0; i < kHeapBodies; ++i) {
    const float x = i % 2 == 0 ? random.uniform(-2, -0.5f) : random.uniform(0.5f, 2);
    const BodyId body = world.create_body({.position = {x, random.uniform(-1, 1), random.uniform(-1, 1)}});
    world.add_shape(body, Sphere{kBallRadius}, {}, {.filter = {.group = -1}});
    if (i % 11 == 0)
      world.add_shape(body, Sphere{0.5f * kBallRadius}, {},
                      {.local_pose = {{0, 0.3f, 0}, {}}, .filter = {.group = -1}});
    if (i % 7 < 2)
      world.add_shape(body, Box{{i % 7 == 0 ? 0.02f : 0.2f, 0.3f, 0.3f}}, {},
                      {.local_pose = {{0.2f, 0, 0}, {}}, .sensor = true});
    bodies.push_back(body);
  }
  return world;
}

// In the first of eight steps each body leaps across the gap or not, and in the second it goes back. A third
// of them sleeps first. Later on some become non-finite as others leap, and calls come between.
void push(World& world, const std::vector<BodyId>& bodies, int step) {
  constexpr float kChangeOfSpeed[] = {1, -2, 1};
  const int eight = step / 8, phase = step % 8;
  constexpr int kFirstOverload = 8;
  const auto is_overloaded = [&](int i) {  // sooner or later
    return eight >= kFirstOverload && ((i >= 28 && i < 48) || (i > 122 && i <= 142));
  };
  for (std::size_t i = 0; i < bodies.size() && phase < 3; ++i) {
    physics::Random random(1000 * i + static_cast<std::uint64_t>(eight));
    if (random.uniform(0, 1) > 0.3f || (i % 3 == 1 && eight < 6) || is_overloaded(static_cast<int>(i)))
      continue;
    const float side = i % 2 == 0 ? 1.0f : -1.0f, speed = i % 5 == 0 ? 150.0f : 60.0f;  // m/s
    const Vec3 way = {side, random.uniform(-0.3f, 0.3f), random.uniform(-0.3f, 0.3f)};
    world.add_force(bodies[i], way * (kChangeOfSpeed[phase] * speed * kBallMass / kStep));
  }
  const auto body = [&](int i) { return bodies[static_cast<std::size_t>(i)]; };
  if (eight >= kFirstOverload && phase == 0) {
    physics::overload(world, body(20 + eight));
    physics::overload(world, body(150 - eight));
  }
  if (eight >= kFirstOverload && phase == 1) {  // on bodies that have come as ghosts, too
    for (int i = eight; i < kHeapBodies; i += 40) world.wake(body(i));
    world.set_body_type(body(60 + eight), BodyType::kinematic);
  }
}

using Sights = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

struct SightsOfStep {
  std::vector<SensorEvent> begins, ends;
  std::uint64_t hash;
};

// Those that a rank tells of; of all that one process lists.
Sights told_by(const Border& border, const std::vector<SensorEvent>& events) {
  Sights told;
  for (const SensorEvent& event : events) {
    if (tells_of(&border, static_cast<std::int32_t>(event.sensor_body.index),
                 static_cast<std::int32_t>(event.visitor_body.index)))
      told.push_back({event.sensor.index, event.visitor.index});
  }
  return told;
}

Sights all_of_list(std::span<const SensorEvent> events) {
  Sights all;
  for (const SensorEvent& event : events) all.push_back({event.sensor.index, event.visitor.index});
  return all;
}

TEST(BringSights, EachRankTellsInTheStepWhatOneProcessTells) {
  constexpr int kSteps = 160;
  std::vector<BodyId> bodies;
  World one = make_heaps(bodies);
  Workers one_thread(1);
  std::vector<SightsOfStep> expected;
  std::size_t sights = 0, quarantined = 0;
  std::int64_t most_asleep = 0;
  for (int i = 0; i < kSteps; ++i) {
    push(one, bodies, i);
    step(one, kStep, one_thread);
    const auto begins = one.sensor_begins(), ends = one.sensor_ends();
    expected.push_back({{begins.begin(), begins.end()}, {ends.begin(), ends.end()}, one.hash()});
    sights += begins.size();
    quarantined += one.quarantined_bodies().size();
    most_asleep = std::max(most_asleep, kHeapBodies - one.stats().awake_bodies);
  }
  EXPECT_GT(sights, 1000u);
  EXPECT_GT(quarantined, 10u);
  EXPECT_GT(most_asleep, kHeapBodies / 4);
  for (const int ranks : {2, 3, 4}) {
    for (const bool at_random : {false, true}) {
      const auto errors = run_ranks(ranks, [&](int, Transport& transport) {
        std::vector<BodyId> all;
        World whole = make_heaps(all);
        DistributedWorld world(std::move(whole), transport, {.steps_per_look = 0});
        WorldData& data = internals(world.world(), "test");
        Workers workers(1);
        for (int i = 0; i < kSteps; ++i) {
          push(world.world(), all, i);
          if (at_random) redraw_owners(world.world(), i, ranks, 3, workers);
          scramble_absent_rows(data);
          world.step(kStep, workers);
          const SightsOfStep& of_one = expected[static_cast<std::size_t>(i)];
          const Border& border = *border_of(data);
          EXPECT_EQ(all_of_list(world.world().sensor_begins()), told_by(border, of_one.begins))
              << "step " << i;
          EXPECT_EQ(all_of_list(world.world().sensor_ends()), told_by(border, of_one.ends)) << "step " << i;
          EXPECT_EQ(world.hash(), of_one.hash) << "step " << i;
          if (testing::Test::HasFailure()) return;
        }
      });
      EXPECT_EQ(all_of(errors), "") << ranks << " ranks";
      ASSERT_FALSE(HasFailure()) << ranks << " ranks, owners at random: " << at_random;
    }
  }
}

}  // namespace
}  // namespace scree
