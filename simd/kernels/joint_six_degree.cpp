// six_degree
#include <simd/joint_sweeps.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

void add_six_degree_kernels(JointKernels&) {}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
