// slider
#include <simd/joint_sweeps.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

void add_slider_kernels(JointKernels&) {}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
