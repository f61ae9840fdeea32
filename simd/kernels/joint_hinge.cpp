// hinge
#include <simd/joint_sweeps.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

void add_hinge_kernels(JointKernels&) {}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
