#include <simd/pair_kernels.h>
#include <simd/wide_math.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

PairKernels make_pair_kernels() {
  return {};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
