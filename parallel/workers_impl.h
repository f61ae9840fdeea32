// The inside of Workers. Private to workers.cpp and crew.cpp.
#pragma once

#include <parallel/crew_state.h>
#include <scree/workers.h>
#include <simd/kernels.h>
#include <tbb/task_arena.h>

namespace scree {

struct Workers::Impl {
  Impl(int thread_count, const simd::Kernels& chosen);

  // Threads that a step can count on now: TBB lends no more than tbb::global_control allows, one per core
  // unless somebody raised it. More shares than threads would only be stolen chunk by chunk.
  int available_threads() const;
  // Asks TBB for helpers until there are `count`, those included that have not started yet.
  void send_helpers(int count);

  const int threads;
  const simd::Kernels* const kernels;
  std::shared_ptr<HelperPool> pool;  // with every helper's task
  // The calling thread never enters it: that can block while its slots are taken. Helpers run nothing but
  // chunks, and chunks spawn nothing, so no foreign task ever runs inside a step and no isolation is needed.
  tbb::task_arena arena;
};

}  // namespace scree
