// Floating-point environment: every thread that runs our code rounds to nearest, flushes denormals to zero
// and masks exceptions, whatever its owner has set, and gets its own settings back. Held by those of World's
// calls that compute, by Crew for the thread that calls step(), and by each helper while it helps.
//
// Denormals are flushed, as operands and as results, because they come by themselves and stay: motion out of
// the plane of a hanging chain of hinges dies away by a share in every substep, down to numbers whose squares
// are denormal, and processors that handle these in microcode take 100 cycles for each. On one of Intel's a
// step of 9,900 hinges took 8 to 22 ms where it takes 2.5. Every instruction set of a processor flushes
// alike.
#pragma once

#if defined(__SSE__)

namespace scree {

class FpEnvironment {
 public:
  // The compilers' builtins, because intrinsics headers stay in simd/.
  FpEnvironment() : saved_(__builtin_ia32_stmxcsr()) { __builtin_ia32_ldmxcsr(kOurs); }
  ~FpEnvironment() { __builtin_ia32_ldmxcsr(saved_); }
  FpEnvironment(const FpEnvironment&) = delete;
  FpEnvironment& operator=(const FpEnvironment&) = delete;

 private:
  // MXCSR (Intel SDM 1, 10.2.3): all exceptions masked, none raised, round to nearest, FTZ and DAZ on.
  static constexpr unsigned kOurs = 0x9fc0;
  unsigned saved_;
};

}  // namespace scree

#elif defined(__aarch64__)

#include <cstdint>

namespace scree {

class FpEnvironment {
 public:
  FpEnvironment() {
    asm volatile("mrs %0, fpcr" : "=r"(saved_));
    set(kOurs);
  }
  ~FpEnvironment() { set(saved_); }
  FpEnvironment(const FpEnvironment&) = delete;
  FpEnvironment& operator=(const FpEnvironment&) = delete;

 private:
  // FPCR (Arm ARM, C5.2.8): no traps, round to nearest, FZ on.
  static constexpr std::uint64_t kOurs = std::uint64_t{1} << 24;
  static void set(std::uint64_t value) { asm volatile("msr fpcr, %0" : : "r"(value)); }
  std::uint64_t saved_;
};

}  // namespace scree

#else

#include <cfenv>

namespace scree {

// The standard has no way to flush: denormals stay here, and with them results may differ from those above.
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
