// Recording: its cost for the step, and the cost of playing.
//
// Two worlds in the same state take turns of 300 steps each. One of them is recorded with a keyframe in the
// middle of every turn, so that the figures include the time that the recorder's thread takes from the step.
// `ratio` is the median over the turns of time recorded to time not recorded. With 2 threads the recorder's
// is the third on the machine's cores. large_pyramid (5,051 bodies, 14,950 contacts) is kept awake.
#include <benchmark/benchmark.h>
#include <scree/scree.h>
#include <tools/scenes/scene.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

namespace scree {
namespace {

constexpr int kSpacing = 300;  // steps

double now(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// Seconds of a turn, by the wall, of the calling thread, and of all threads.
struct Turn {
  double wall, caller, process;
};

Turn run(World& world, float dt, Workers& workers, int steps) {
  const Turn begin{now(CLOCK_MONOTONIC), now(CLOCK_THREAD_CPUTIME_ID), now(CLOCK_PROCESS_CPUTIME_ID)};
  for (int i = 0; i < steps; ++i) step(world, dt, workers);
  return {now(CLOCK_MONOTONIC) - begin.wall, now(CLOCK_THREAD_CPUTIME_ID) - begin.caller,
          now(CLOCK_PROCESS_CPUTIME_ID) - begin.process};
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

struct Settled {
  scenes::Scene scene;
  World world;

  explicit Settled(const std::string& name) : scene(scenes::build(name).front()), world(awake(scene)) {
    scenes::populate(world, scene);
    Workers workers(2);
    run(world, scene.dt, workers, scene.steps);
  }
  static WorldSettings awake(const scenes::Scene& scene) {
    WorldSettings settings = scene.settings;
    settings.sleeping = false;
    return settings;
  }
};

void record(benchmark::State& state, const std::string& name, int threads) {
  Settled settled(name);
  World plain = clone(settled.world), recorded = clone(settled.world);  // both laid out anew
  const float dt = settled.scene.dt;
  const std::string file =
      (std::filesystem::temp_directory_path() / ("scree_recording_bench_" + std::to_string(getpid())))
          .string();
  Workers workers(threads);
  Recorder recorder(recorded, file, {.keyframe_spacing = kSpacing});
  run(plain, dt, workers, kSpacing / 2);
  run(recorded, dt, workers, kSpacing / 2);
  std::vector<double> without, with, wall, caller, process;
  for (auto _ : state) {
    const Turn left = run(plain, dt, workers, kSpacing), right = run(recorded, dt, workers, kSpacing);
    without.push_back(left.wall);
    with.push_back(right.wall);
    wall.push_back(right.wall / left.wall);
    caller.push_back(right.caller / left.caller);
    process.push_back(right.process / left.process);
  }
  recorder.finish();
  constexpr double kToMs = 1e3 / kSpacing;
  state.counters["plain_ms"] = median(without) * kToMs;
  state.counters["recorded_ms"] = median(with) * kToMs;
  state.counters["ratio"] = median(wall);
  state.counters["ratio_of_minima"] =
      *std::min_element(with.begin(), with.end()) / *std::min_element(without.begin(), without.end());
  state.counters["caller_ratio"] = median(caller);
  state.counters["process_ratio"] = median(process);
  state.counters["bytes_per_step"] =
      static_cast<double>(recorder.bytes_written()) / static_cast<double>(recorder.steps());
  std::filesystem::remove(file);
}

void hash(benchmark::State& state, const std::string& name) {
  const Settled settled(name);
  for (auto _ : state) benchmark::DoNotOptimize(settled.world.hash());
}

const bool kRegistered = [] {
  for (const int threads : {1, 2}) {
    benchmark::RegisterBenchmark(
        ("large_pyramid/record/" + std::to_string(threads) + "_threads").c_str(),
        [threads](benchmark::State& state) { record(state, "large_pyramid", threads); })
        ->Iterations(9)
        ->Unit(benchmark::kMillisecond);
  }
  benchmark::RegisterBenchmark("large_pyramid/hash", [](benchmark::State& state) {
    hash(state, "large_pyramid");
  })->Unit(benchmark::kMicrosecond);
  return true;
}();

}  // namespace
}  // namespace scree
