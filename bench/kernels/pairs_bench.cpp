// Broad phase: the whole job "new bounds in, canonical list out", and its parts, per instruction set.
//
// A pile of mixed boxes, spheres and capsules of 0.4 to 1.0 m at random places and turns, so dense that every
// body has about ten candidate pairs. `moving`: every body leaves its bounds in every step. `resting`: nobody
// does.
#include <benchmark/benchmark.h>
#include <parallel/broad_phase.h>
#include <tests/parallel/hand_made_world.h>

#include <cmath>
#include <memory>
#include <string>

namespace scree {
namespace {

using testing::HandMadeWorld;
using testing::Random;

constexpr float kDt = 1.0f / 60.0f;

std::unique_ptr<HandMadeWorld> make_pile(int bodies, float speed) {
  auto world = std::make_unique<HandMadeWorld>();
  Random random(1);
  const float half = 0.5f * std::cbrt(static_cast<float>(bodies) * 0.55f);
  world->add_box(BodyType::fixed, {0, -half - 1, 0}, {400, 1, 400});
  for (int i = 0; i < bodies; ++i) {
    const std::int32_t body =
        world->add_body(BodyType::dynamic, random.point({half, half, half}), random.rotation());
    VelocityRow& velocity = world->data.bodies.velocity[static_cast<std::size_t>(body)];
    for (float& speed_along : velocity.linear) speed_along = random.uniform(-speed, speed);
    world->add_random_shape(body, random);
  }
  world->refresh();
  return world;
}

// Velocities change sign, so that bodies swing about their places.
void swing(HandMadeWorld& world) {
  world.integrate(kDt);
  for (VelocityRow& velocity : world.data.bodies.velocity) {
    for (float& speed : velocity.linear) speed = -speed;
  }
}

void run_find_pairs(benchmark::State& state, Isa isa, float speed) {
  const auto world = make_pile(static_cast<int>(state.range(0)), speed);
  Workers workers(WorkersOptions{.threads = 1, .isa = isa});
  Crew crew(workers);
  find_pairs(world->data, crew);
  for (auto _ : state) {
    state.PauseTiming();
    swing(*world);
    state.ResumeTiming();
    update_bounds(world->data, kDt, crew);
    find_pairs(world->data, crew);
  }
  state.counters["pairs"] = static_cast<double>(world->data.stats.pairs);
}

// One stage at a time, the others untimed.
void run_part(benchmark::State& state, Isa isa, int part) {
  const auto world = make_pile(static_cast<int>(state.range(0)), 1.0f);
  WorldData& data = world->data;
  Workers workers(WorkersOptions{.threads = 1, .isa = isa});
  Crew crew(workers);
  find_pairs(data, crew);
  BroadPhase& broad_phase = broad_phase_of(data);
  const auto timed = [&](int which, auto&& work) {
    if (which == part) state.ResumeTiming();
    work();
    if (which == part) state.PauseTiming();
  };
  for (auto _ : state) {
    state.PauseTiming();
    swing(*world);
    std::int64_t pairs = 0;
    timed(0, [&] { update_bounds(data, kDt, crew); });
    timed(1, [&] { update_members(data, broad_phase, crew); });
    timed(2, [&] { refit_trees(data, broad_phase, crew); });
    timed(3, [&] { pairs = join_trees(data, broad_phase, crew); });
    timed(4, [&] { sort_pairs(broad_phase, data.shapes.flags.size(), pairs, crew); });
    state.ResumeTiming();
  }
}

const bool kRegistered = [] {
  const char* const parts[] = {"update_bounds", "update_members", "refit_trees", "join_trees", "sort_pairs"};
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    const std::string name = isa_name(isa);
    for (const std::int64_t bodies : {5000, 100000, 1000000}) {
      benchmark::RegisterBenchmark(("find_pairs/moving/" + name).c_str(),
                                   [isa](benchmark::State& state) { run_find_pairs(state, isa, 1.0f); })
          ->Arg(bodies)
          ->Unit(benchmark::kMillisecond);
      benchmark::RegisterBenchmark(("find_pairs/resting/" + name).c_str(),
                                   [isa](benchmark::State& state) { run_find_pairs(state, isa, 0.0f); })
          ->Arg(bodies)
          ->Unit(benchmark::kMillisecond);
    }
    for (int part = 0; part < 5; ++part) {
      benchmark::RegisterBenchmark((std::string(parts[part]) + "/" + name).c_str(),
                                   [isa, part](benchmark::State& state) { run_part(state, isa, part); })
          ->Arg(100000)
          ->Unit(benchmark::kMillisecond);
    }
  }
  return true;
}();

}  // namespace
}  // namespace scree
