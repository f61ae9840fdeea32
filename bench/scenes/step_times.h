// The time of a step itself, without interruptions by other processes on the machine.
#pragma once

#include <vector>

namespace scree::bench {

/// Times of steps, ms. A step's own time is the shortest that any repeat took for it: engines do the same
/// work in the same step of every repeat, and nothing makes it faster than it is.
struct StepTimes {
  double mean = 0.0;  ///< the time per step without interruptions
  double median = 0.0;
  double p999 = 0.0;  ///< 99.9th percentile: 1 step in 1000 takes longer
  double worst = 0.0;
};

/// A row per repeat, each of as many steps; all zero without any.
StepTimes step_times(const std::vector<std::vector<double>>& repeats);

}  // namespace scree::bench
