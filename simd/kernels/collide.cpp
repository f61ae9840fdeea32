#include <simd/collide_kernels.h>
#include <simd/wide_math.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

CollideKernels make_collide_kernels() {
  return {};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
