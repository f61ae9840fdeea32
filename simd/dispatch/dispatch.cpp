// Chooses one of the instruction sets that were built: the processor must have every feature that the
// compiler flags of its kernels allow.
#include <simd/dispatch/kernels.h>

namespace scree::simd {

namespace scalar {
Kernels make_kernels();
}
#if SCREE_HAS_SSE2
namespace sse2 {
Kernels make_kernels();
}
#endif
#if SCREE_HAS_AVX2
namespace avx2 {
Kernels make_kernels();
}
#endif
#if SCREE_HAS_AVX512
namespace avx512 {
Kernels make_kernels();
}
#endif

namespace {

bool runs_here(InstructionSet set) {
#if SCREE_HAS_SSE2 || SCREE_HAS_AVX2 || SCREE_HAS_AVX512
  // __builtin_cpu_supports also asks whether the operating system saves the registers.
  __builtin_cpu_init();
  switch (set) {
    case InstructionSet::scalar:
      return true;
    case InstructionSet::sse2:
      return __builtin_cpu_supports("sse2") != 0;
    case InstructionSet::avx2:
      return __builtin_cpu_supports("avx2") != 0;
    case InstructionSet::avx512:
      return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("avx512f") != 0 &&
             __builtin_cpu_supports("avx512cd") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
             __builtin_cpu_supports("avx512bw") != 0 && __builtin_cpu_supports("avx512vl") != 0;
  }
  return false;
#else
  return set == InstructionSet::scalar;
#endif
}

}  // namespace

const Kernels* find_kernels(InstructionSet set) {
  if (!runs_here(set)) return nullptr;
  switch (set) {
    case InstructionSet::scalar: {
      static const Kernels kKernels = scalar::make_kernels();
      return &kKernels;
    }
#if SCREE_HAS_SSE2
    case InstructionSet::sse2: {
      static const Kernels kKernels = sse2::make_kernels();
      return &kKernels;
    }
#endif
#if SCREE_HAS_AVX2
    case InstructionSet::avx2: {
      static const Kernels kKernels = avx2::make_kernels();
      return &kKernels;
    }
#endif
#if SCREE_HAS_AVX512
    case InstructionSet::avx512: {
      static const Kernels kKernels = avx512::make_kernels();
      return &kKernels;
    }
#endif
    default:
      return nullptr;
  }
}

const Kernels& widest_kernels() {
  for (int set = kInstructionSetCount - 1; set > 0; --set) {
    if (const Kernels* kernels = find_kernels(static_cast<InstructionSet>(set))) return *kernels;
  }
  return *find_kernels(InstructionSet::scalar);
}

}  // namespace scree::simd
