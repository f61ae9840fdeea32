// For programs whose laws must hold with more threads than the machine has cores: TBB lends one thread per
// core unless told otherwise.
#pragma once

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scree::determinism {

class ManyThreads : public ::testing::Test {
 private:
  tbb::global_control more_threads_{tbb::global_control::max_allowed_parallelism, 8};
};

}  // namespace scree::determinism
