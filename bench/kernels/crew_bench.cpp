// Cost of a stage boundary: empty chunks, so that only publishing, claiming and joining remain.
#include <benchmark/benchmark.h>
#include <parallel/crew/crew.h>
#include <tbb/global_control.h>

namespace {

constexpr int kStages = 200;  // of a step, as in a solver with 4 substeps and a dozen colors

// Arguments: threads of the Workers, chunks of a stage, loops of work in a chunk.
void stage_boundary(benchmark::State& state) {
  scree::Workers workers(static_cast<int>(state.range(0)));
  const int chunks = static_cast<int>(state.range(1));
  const int loops = static_cast<int>(state.range(2));
  for (auto _ : state) {
    scree::Crew crew(workers);
    for (int stage = 0; stage < kStages; ++stage) {
      crew.run(chunks, [loops](int, int) {
        for (int i = 0; i < loops; ++i) benchmark::DoNotOptimize(i);
      });
    }
  }
  state.counters["per_stage"] = benchmark::Counter(  // seconds
      static_cast<double>(state.iterations()) * kStages,
      benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(stage_boundary)
    ->ArgNames({"threads", "chunks", "loops"})
    ->ArgsProduct({{1, 2, 8}, {1, 2, 16}, {0, 10000}})
    ->UseRealTime();

// The same with the requested number of real threads, which may exceed the number of cores.
void stage_boundary_oversubscribed(benchmark::State& state) {
  tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                              static_cast<std::size_t>(state.range(0)));
  stage_boundary(state);
}
BENCHMARK(stage_boundary_oversubscribed)
    ->ArgNames({"threads", "chunks", "loops"})
    ->ArgsProduct({{2, 8}, {2, 16}, {0, 10000}})
    ->UseRealTime();

}  // namespace
