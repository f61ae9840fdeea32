// Crew: the threads that work on one step, as the step sees them.
//
// A crew lives for one call of step(). The calling thread runs stages one after the other. Helpers that have
// arrived claim chunks of the current stage; the caller waits only for chunks that a helper has claimed. See
// crew_state.h. Only the thread that made the crew may run stages. A chunk may not run stages of the crew
// that runs it; it may make a crew of its own.
#pragma once

#include <core/world/fp_environment.h>
#include <parallel/crew/zone_scope.h>
#include <scree/workers.h>
#include <simd/dispatch/kernels.h>

#include <algorithm>

namespace scree {

class CrewState;

class Crew {
 public:
  // From here until the crew's end the calling thread computes in our floating-point environment: make the
  // crew before the step's first arithmetic.
  explicit Crew(Workers& workers);
  // One thread alone: for a chunk of `crew` that has stages of its own to run.
  struct Alone {};
  Crew(const Crew& crew, Alone) : width_(1), kernels_(crew.kernels_), zones_(crew.zones_) {}
  ~Crew();
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  // Threads that may take part, as many as the workers have and TBB lends; worker numbers are 0 (the caller)
  // to threads() - 1. The same as long as the crew lives.
  int threads();
  const simd::Kernels& kernels() const { return *kernels_; }
  const ZoneHooks* zones() const { return zones_; }  // null if nobody asks for them

  // Calls work(chunk, worker) once for every chunk in [0, chunks), on any thread, and returns when all are
  // done. What a chunk is must depend on the scene alone, never on the number of threads, and chunks must not
  // care in which order they run. An exception of a chunk is thrown again here, after the stage has ended
  // (the lowest chunk's, if there are several). No two threads use a worker number at the same time. `name`:
  // of the zones of the stage, see scree/zones.h; that of the calling function.
  template <class Work>
  void run(int chunks, Work&& work, const char* name = __builtin_FUNCTION()) {
    run_stage(
        chunks, [](void* context, int chunk, int worker) { (*static_cast<Work*>(context))(chunk, worker); },
        const_cast<void*>(static_cast<const void*>(&work)), name);
  }

  // The same on the calling thread alone, for what is too little to share.
  template <class Work>
  void run_alone(int chunks, Work&& work, const char* name = __builtin_FUNCTION()) {
    const ZoneScope zone(zones_, {ZoneKind::stage, name, 0});
    for (int chunk = 0; chunk < chunks; ++chunk) work(chunk);
  }

  // Cuts [0, count) into chunks of `chunk_size` and calls work(begin, end, worker) for each.
  template <class Work>
  void run_ranges(int count, int chunk_size, Work&& work, const char* name = __builtin_FUNCTION()) {
    const int chunks = (count + chunk_size - 1) / chunk_size;
    run(
        chunks,
        [&](int chunk, int worker) {
          const int begin = chunk * chunk_size;
          work(begin, std::min(begin + chunk_size, count), worker);
        },
        name);
  }

  int stages() const { return stages_; }  // run so far

 private:
  using StageFunction = void (*)(void* context, int chunk, int worker);
  void run_stage(int chunks, StageFunction function, void* context, const char* name);
  void share(int chunks, StageFunction function, void* context);
  FpEnvironment environment_;
  int width_ = 0;  // threads that stages are split for; 0 until first asked
  int stages_ = 0;
  const simd::Kernels* kernels_ = nullptr;
  const ZoneHooks* zones_ = nullptr;
  CrewState* state_ = nullptr;  // null until the first stage that is worth sharing
  Workers::Impl* workers_ = nullptr;
};

}  // namespace scree
