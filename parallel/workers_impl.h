// The inside of Workers. Private to workers.cpp and crew.cpp.
#pragma once

#include <parallel/crew_state.h>
#include <parallel/helper_arena.h>
#include <scree/export.h>
#include <scree/workers.h>
#include <simd/kernels.h>

namespace scree {

struct SCREE_HIDDEN Workers::Impl {
  Impl(int thread_count, const simd::Kernels& chosen);
  ~Impl() { pool->release(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // Threads that a step can count on now. Shares for threads that TBB does not lend would only be stolen
  // chunk by chunk.
  int available_threads() const;
  // Asks TBB for helpers until there are `count`, those included that have not started yet.
  void send_helpers(int count);

  const int threads;
  const simd::Kernels* const kernels;
  HelperPool* const pool;  // shared with every helper's task
  HelperArena arena;
};

}  // namespace scree
