// Broad phase: the whole job "new bounds in, canonical list out", and its parts, per instruction set.
//
// A pile of mixed boxes, spheres and capsules of 0.4 to 1.0 m at random places and turns, so dense that every
// body has about ten candidate pairs. `moving`: every body leaves its bounds in every step. `resting`: no
// body does.
//
// Best of a few on an AMD EPYC at 2.6 GHz, one thread, cores shared with other work, ms, November 2026:
//   moving    5,000 bodies,  21,700 pairs: scalar 3.2, AVX2 0.59, AVX-512 0.52
//   moving  100,000 bodies, 469,000 pairs: scalar 100 (first form), AVX2 19.2, AVX-512 18.5
//   resting   5,000 bodies: 0.020; 100,000 bodies: 0.46 (AVX-512)
//   parts at 100,000 with AVX-512: update_bounds 0.7, members 0.02, refit 1.1, join 7.9, sort 5.0
#include <benchmark/benchmark.h>
#include <parallel/broad_phase/broad_phase.h>
#include <tests/parallel/hand_made_world.h>

#include <algorithm>
#include <chrono>
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

// Velocities change sign, so that bodies swing about their initial positions.
void swing(HandMadeWorld& world) {
  world.integrate(kDt);
  for (VelocityRow& velocity : world.data.bodies.velocity) {
    for (float& speed : velocity.linear) speed = -speed;
  }
}

class Watch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

void run_find_pairs(benchmark::State& state, Isa isa, float speed) {
  const auto world = make_pile(static_cast<int>(state.range(0)), speed);
  Workers workers(WorkersOptions{.threads = static_cast<int>(state.range(1)), .isa = isa});
  Crew crew(workers);
  for (int i = 0; i < 3; ++i) {
    update_bounds(world->data, kDt, crew);
    find_pairs(world->data, crew);
  }
  double best = 1e9;
  for (auto _ : state) {
    swing(*world);
    const Watch watch;
    update_bounds(world->data, kDt, crew);
    find_pairs(world->data, crew);
    best = std::min(best, watch.seconds());
    state.SetIterationTime(watch.seconds());
  }
  state.counters["pairs"] = static_cast<double>(world->data.stats.pairs);
  state.counters["best_ms"] = 1e3 * best;
}

// One stage at a time.
void run_part(benchmark::State& state, Isa isa, int timed_part) {
  const auto world = make_pile(static_cast<int>(state.range(0)), 4.0f);
  WorldData& data = world->data;
  Workers workers(WorkersOptions{.threads = 1, .isa = isa});
  Crew crew(workers);
  find_pairs(data, crew);
  BroadPhase& broad_phase = broad_phase_of(data);
  double best = 1e9;
  for (auto _ : state) {
    swing(*world);
    std::int64_t pairs = 0;
    int part = 0;
    const auto timed = [&](auto&& work) {
      const Watch watch;
      work();
      if (part++ != timed_part) return;
      best = std::min(best, watch.seconds());
      state.SetIterationTime(watch.seconds());
    };
    timed([&] { update_bounds(data, kDt, crew); });
    timed([&] { update_members(data, broad_phase, crew); });
    timed([&] { refit_trees(data, broad_phase, crew); });
    timed([&] { pairs = join_trees(data, broad_phase, JoinScope::all, crew); });
    timed([&] { sort_pairs(broad_phase, data.shapes.flags.size(), pairs, crew); });
  }
  state.counters["best_ms"] = 1e3 * best;
}

void register_for(Isa isa) {
  const std::string name = isa_name(isa);
  for (const std::int64_t bodies : {5000, 100000, 1000000}) {
    for (const bool moving : {true, false}) {
      benchmark::RegisterBenchmark(
          ((moving ? "find_pairs/moving/" : "find_pairs/resting/") + name).c_str(),
          [=](benchmark::State& state) { run_find_pairs(state, isa, moving ? 4.0f : 0.0f); })
          ->ArgNames({"bodies", "threads"})
          ->Args({bodies, 1})
          ->Args({bodies, 2})
          ->Iterations(bodies < 10000    ? 100
                       : bodies < 200000 ? 12
                                         : 3)
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond);
    }
  }
  const char* const parts[] = {"update_bounds", "update_members", "refit_trees", "join_trees", "sort_pairs"};
  for (int part = 0; part < 5; ++part) {
    benchmark::RegisterBenchmark((std::string(parts[part]) + "/" + name).c_str(),
                                 [=](benchmark::State& state) { run_part(state, isa, part); })
        ->Arg(100000)
        ->Iterations(10)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
  }
}

const bool kRegistered = [] {
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (is_supported(isa)) register_for(isa);
  }
  return true;
}();

}  // namespace
}  // namespace scree
