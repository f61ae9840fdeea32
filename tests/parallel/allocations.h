// Counts the memory allocations of the test program, and makes them fail; see crew_memory_test.cpp.
#pragma once

namespace scree {

// By all threads, since the program began.
long allocations_so_far();

// While it exists, allocations fail for the thread that made it, or for all other threads.
class FailingAllocations {
 public:
  enum class Of { this_thread, others };
  explicit FailingAllocations(Of of);
  ~FailingAllocations();
  FailingAllocations(const FailingAllocations&) = delete;
  FailingAllocations& operator=(const FailingAllocations&) = delete;
};

}  // namespace scree
