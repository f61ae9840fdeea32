// Times of the steps of several repeats -> the shortest of each step -> the figures over the steps.
#include "bench/scenes/step_times.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace scree::bench {

StepTimes step_times(const std::vector<std::vector<double>>& repeats) {
  std::vector<double> least;
  for (const std::vector<double>& repeat : repeats) {
    if (least.empty()) least = repeat;
    for (std::size_t step = 0; step < least.size(); ++step) least[step] = std::min(least[step], repeat[step]);
  }
  if (least.empty()) return {};
  std::sort(least.begin(), least.end());
  const double sum = std::accumulate(least.begin(), least.end(), 0.0);
  const double last = static_cast<double>(least.size() - 1);
  return {sum / static_cast<double>(least.size()), least[least.size() / 2],
          least[static_cast<std::size_t>(std::floor(0.999 * last))], least.back()};
}

}  // namespace scree::bench
