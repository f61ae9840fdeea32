// Laws of the times of steps that the benchmark reports.
#include "bench/scenes/step_times.h"

#include <gtest/gtest.h>

#include <vector>

namespace {

using scree::bench::step_times;
using scree::bench::StepTimes;

TEST(StepTimes, AnInterruptionOfOneRepeatDoesNotCount) {
  const StepTimes times = step_times({{1.0, 90.0, 3.0}, {1.5, 2.0, 3.5}, {70.0, 2.5, 80.0}});
  EXPECT_EQ(times.mean, 2.0);
  EXPECT_EQ(times.median, 2.0);
  EXPECT_EQ(times.worst, 3.0);
}

TEST(StepTimes, AStepThatIsSlowInAllRepeatsCounts) {
  const StepTimes times = step_times({{1.0, 9.0, 1.0}, {1.0, 8.0, 1.0}});
  EXPECT_EQ(times.mean, 10.0 / 3.0);
  EXPECT_EQ(times.median, 1.0);
  EXPECT_EQ(times.worst, 8.0);
}

TEST(StepTimes, OneStepInAThousandIsBeyondTheLastPercentile) {
  std::vector<double> steps(1001, 1.0);
  steps[500] = 5.0;
  EXPECT_EQ(step_times({steps}).p999, 1.0);
  EXPECT_EQ(step_times({steps}).worst, 5.0);
  steps[700] = 4.0;
  EXPECT_EQ(step_times({steps}).p999, 4.0);
}

TEST(StepTimes, AreZeroWithoutAnyRun) {
  const StepTimes times = step_times({});
  EXPECT_EQ(times.mean, 0.0);
  EXPECT_EQ(times.median, 0.0);
  EXPECT_EQ(times.worst, 0.0);
}

}  // namespace
