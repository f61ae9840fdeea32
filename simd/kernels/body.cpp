#include <simd/body_kernels.h>
#include <simd/wide_math.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

BodyKernels make_body_kernels() { return {}; }

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
