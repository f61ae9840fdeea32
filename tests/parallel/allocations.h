// Counts the memory allocations of the test program; see crew_memory_test.cpp.
#pragma once

namespace scree {

// By all threads, since the program began.
long allocations_so_far();

}  // namespace scree
