// Floating-point environment: every thread that runs our code rounds to nearest, keeps denormals and masks
// exceptions, and gets its own settings back afterwards (a host built with fast-math flushes denormals to
// zero). Flushing denormals would be faster (a hanging chain of hinges takes 3 to 9 times as long on
// processors that handle them in microcode), but then it depends on the instruction set whether minima,
// maxima and moves flush denormals from outside. Held by World's calls that compute, by Crew for the thread
// that calls step(), and by each helper while it helps.
#pragma once

#if defined(__SSE__)

namespace scree {

class FpEnvironment {
 public:
  // The compilers' builtins, because intrinsics headers stay in simd/.
  FpEnvironment() : saved_(__builtin_ia32_stmxcsr()) { __builtin_ia32_ldmxcsr(kDefault); }
  ~FpEnvironment() { __builtin_ia32_ldmxcsr(saved_); }
  FpEnvironment(const FpEnvironment&) = delete;
  FpEnvironment& operator=(const FpEnvironment&) = delete;

 private:
  // MXCSR after reset (Intel SDM 1, 10.2.3): all exceptions masked, none raised, round to nearest, FTZ and
  // DAZ off.
  static constexpr unsigned kDefault = 0x1f80;
  unsigned saved_;
};

}  // namespace scree

#else

#include <cfenv>

namespace scree {

class FpEnvironment {
 public:
  FpEnvironment() {
    std::fegetenv(&saved_);
    std::fesetenv(FE_DFL_ENV);
  }
  ~FpEnvironment() { std::fesetenv(&saved_); }
  FpEnvironment(const FpEnvironment&) = delete;
  FpEnvironment& operator=(const FpEnvironment&) = delete;

 private:
  std::fenv_t saved_;
};

}  // namespace scree

#endif
