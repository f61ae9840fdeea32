// The inside of Workers. Private to workers.cpp and crew.cpp.
#pragma once

#include <parallel/crew/crew_state.h>
#include <parallel/crew/helper_arena.h>
#include <scree/export.h>
#include <scree/workers.h>
#include <simd/dispatch/kernels.h>

namespace scree {

// Crews, and the arena that brings their helpers. A helper's task that TBB has not run yet holds the pool,
// and may do so for as long as the cores are busy with something else. So what a Workers leaves behind is
// kept for the next one of as many threads: there are never more than have lived at a time.
struct SCREE_HIDDEN HelperSet {
  explicit HelperSet(int thread_count);
  ~HelperSet() { pool->release(); }
  HelperSet(const HelperSet&) = delete;
  HelperSet& operator=(const HelperSet&) = delete;

  const int threads;
  HelperPool* const pool;  // shared with every helper's task
  HelperArena arena;
  HelperSet* next = nullptr;  // that is left
};

// Returns a kept one or a new one.
HelperSet* take_helper_set(int threads);
// Keeps it for the next Workers if helpers have not returned; else deletes it, and all others whose helpers
// have returned.
void leave_helper_set(HelperSet* set) noexcept;
// The number of pools, with those in use. For tests.
int helper_sets();

struct SCREE_HIDDEN Workers::Impl {
  Impl(int thread_count, const simd::Kernels& chosen, const ZoneHooks& hooks);
  ~Impl() { leave_helper_set(helpers); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // Threads that a step can count on now. Shares for threads that TBB does not lend would only be stolen
  // chunk by chunk.
  int available_threads() const;
  // Asks TBB for helpers until there are `count`, those included that have not started yet.
  void send_helpers(int count);

  const int threads;
  const simd::Kernels* const kernels;
  HelperSet* const helpers;
  HelperPool* const pool;  // of `helpers`
  const ZoneHooks zones;
};

}  // namespace scree
