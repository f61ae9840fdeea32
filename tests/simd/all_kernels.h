// The kernels of every instruction set that this machine has, the scalar ones first.
#pragma once

#include <simd/dispatch/kernels.h>

#include <vector>

namespace scree::kernel_tests {

inline std::vector<const simd::Kernels*> all_kernels() {
  std::vector<const simd::Kernels*> result;
  for (int set = 0; set < simd::kInstructionSetCount; ++set) {
    if (const simd::Kernels* kernels = simd::find_kernels(static_cast<simd::InstructionSet>(set))) {
      result.push_back(kernels);
    }
  }
  return result;
}
inline const simd::Kernels& scalar_kernels() { return *simd::find_kernels(simd::InstructionSet::scalar); }

}  // namespace scree::kernel_tests
