// Laws of the floating-point environment: the caller's settings affect no result, and the step preserves
// them.
#include <gtest/gtest.h>
#include <parallel/crew/crew.h>
#include <tbb/global_control.h>

#include <cfenv>
#include <limits>
#include <vector>

namespace scree {
namespace {

// Results that depend on rounding and on denormals, computed by any number of helpers.
std::vector<float> compute(Workers& workers) {
  std::vector<float> results(1024);
  Crew crew(workers);
  for (int stage = 0; stage < 20; ++stage) {
    crew.run_ranges(1024, 16, [&](int begin, int end, int) {
      for (int i = begin; i < end; ++i) {
        volatile float third = 1.0f / 3.0f;
        volatile float denormal = std::numeric_limits<float>::denorm_min();
        const float rounded = third * static_cast<float>(i + stage) + 0.1f;
        const float kept = denormal * static_cast<float>(i + 1);
        results[static_cast<std::size_t>(i)] = i % 2 == 0 ? rounded : kept;
      }
    });
  }
  return results;
}

TEST(FpEnvironment, ResultsDoNotDependOnTheCallersRounding) {
  tbb::global_control four(tbb::global_control::max_allowed_parallelism, 4);
  Workers workers(4);
  const std::vector<float> expected = compute(workers);
  EXPECT_NE(expected[1], 0.0f) << "denormals are kept";
  for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
    ASSERT_EQ(std::fesetround(mode), 0);
    const std::vector<float> results = compute(workers);
    const int after = std::fegetround();
    std::fesetround(FE_TONEAREST);
    EXPECT_EQ(results, expected);
    EXPECT_EQ(after, mode) << "the caller gets its rounding back";
  }
}

#if defined(__SSE__)
TEST(FpEnvironment, ACallerThatFlushesDenormalsGetsTheSameResultsAndItsStateBack) {
  constexpr unsigned kFlushToZero = 1u << 15, kDenormalsAreZero = 1u << 6, kRoundUp = 2u << 13;
  tbb::global_control four(tbb::global_control::max_allowed_parallelism, 4);
  Workers workers(4);
  const std::vector<float> expected = compute(workers);
  const unsigned before = __builtin_ia32_stmxcsr();
  const unsigned hostile = (before | kFlushToZero | kDenormalsAreZero | kRoundUp) & ~0x3fu;
  __builtin_ia32_ldmxcsr(hostile);
  const std::vector<float> results = compute(workers);
  const unsigned after = __builtin_ia32_stmxcsr();
  __builtin_ia32_ldmxcsr(before);
  EXPECT_EQ(after, hostile);
  EXPECT_EQ(results, expected);
}

TEST(FpEnvironment, ExceptionsThatTheCallerUnmaskedDoNotTrapInsideAStep) {
  constexpr unsigned kInvalidMask = 1u << 7, kDivisionMask = 1u << 9;
  Workers workers(2);
  const unsigned before = __builtin_ia32_stmxcsr();
  __builtin_ia32_ldmxcsr(before & ~(kInvalidMask | kDivisionMask | 0x3fu));
  volatile float zero = 0.0f;
  {
    Crew crew(workers);
    crew.run(8, [&](int, int) { [[maybe_unused]] volatile float quotient = 1.0f / zero + zero / zero; });
  }
  __builtin_ia32_ldmxcsr(before);
}
#endif

}  // namespace
}  // namespace scree
