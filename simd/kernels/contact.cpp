#include <simd/contact_kernels.h>
#include <simd/wide_math.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

ContactKernels make_contact_kernels() { return {}; }

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
