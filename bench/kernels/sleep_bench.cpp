// Cost of sleepers: a step of a hundred balls that never sleep, beside a field of sleeping boxes.
#include <benchmark/benchmark.h>
#include <core/world/math.h>
#include <scree/scree.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace {

constexpr float kStep = 1.0f / 60.0f;  // s
constexpr int kMovers = 100;

// Boxes on a floor, stepped until all are asleep.
void add_sleepers(scree::World& world, scree::Workers& workers, std::int64_t count) {
  const auto side = static_cast<std::int64_t>(std::ceil(std::sqrt(static_cast<double>(count))));
  const float half = static_cast<float>(side) + 10.0f;
  const scree::BodyId floor = world.create_body({.type = scree::BodyType::fixed, .position = {0, -1, 0}});
  world.add_shape(floor, scree::Box{{half, 1.0f, half}});
  std::vector<scree::BodyDef> defs(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i) {
    defs[static_cast<std::size_t>(i)].position = {1.5f * static_cast<float>(i % side - side / 2), 0.5f,
                                                  1.5f * static_cast<float>(i / side - side / 2)};
  }
  const std::vector<scree::Geometry> boxes(defs.size(), scree::Box{});
  std::vector<scree::BodyId> ids(defs.size());
  world.create_bodies(defs, boxes, {}, {}, ids);
  scree::WorldSettings settings = world.settings();
  settings.sleep_time = 0.05f;
  world.set_settings(settings);
  int steps = 0;
  do {
    if (++steps > 120) throw std::runtime_error("the field does not fall asleep");
    scree::step(world, kStep, workers);
  } while (world.stats().awake_bodies > 0);
}

// Balls that bounce in a closed box far above the field: pairs begin and end in every step.
void add_movers(scree::World& world) {
  const scree::Material material{.friction = 0.0f, .restitution = 1.0f};
  const scree::BodyId walls = world.create_body({.type = scree::BodyType::fixed, .position = {0, 500, 0}});
  for (const scree::Vec3 side : {scree::Vec3{1, 0, 0}, scree::Vec3{-1, 0, 0}, scree::Vec3{0, 0, 1},
                                 scree::Vec3{0, 0, -1}, scree::Vec3{0, -1, 0}, scree::Vec3{0, 1, 0}}) {
    world.add_shape(walls, scree::Box{{4, 4, 4}}, material, {.local_pose = {7.0f * side, {}}});
  }
  for (int i = 0; i < kMovers; ++i) {
    const auto at = [i](int divisor) { return 1.1f * static_cast<float>(i / divisor % 5 - 2); };
    const scree::BodyId ball = world.create_body(
        {.position = {at(1), 498.0f + 1.1f * static_cast<float>(i / 25), at(5)}, .can_sleep = false});
    world.add_shape(ball, scree::Sphere{0.4f}, material);
  }
}

// Argument: sleepers.
void step_beside_sleepers(benchmark::State& state) {
  scree::World world;
  scree::Workers workers(1);
  if (state.range(0) > 0) add_sleepers(world, workers, state.range(0));
  add_movers(world);
  for (int i = 0; i < 60; ++i) scree::step(world, kStep, workers);
  for (auto _ : state) scree::step(world, kStep, workers);
  if (world.stats().awake_bodies != kMovers) state.SkipWithError("others than the balls are awake");
  state.counters["sleepers"] = static_cast<double>(world.body_count()) - kMovers;
}
BENCHMARK(step_beside_sleepers)
    ->Arg(0)
    ->Arg(1000)
    ->Arg(100000)
    ->Arg(1000000)
    ->Iterations(20000)
    ->Repetitions(5)
    ->Unit(benchmark::kMicrosecond);

}  // namespace
