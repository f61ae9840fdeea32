// The table of the joint kernels, from the families beside this file.
#include <simd/constraints/joints/joint_sweeps.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

void add_ball_kernels(JointKernels& kernels);
void add_hinge_kernels(JointKernels& kernels);
void add_slider_kernels(JointKernels& kernels);
void add_distance_kernels(JointKernels& kernels);
void add_weld_kernels(JointKernels& kernels);
void add_six_degree_kernels(JointKernels& kernels);
void add_rows_kernels(JointKernels& kernels);

JointKernels make_joint_kernels() {
  JointKernels kernels{};
  add_ball_kernels(kernels);
  add_hinge_kernels(kernels);
  add_slider_kernels(kernels);
  add_distance_kernels(kernels);
  add_weld_kernels(kernels);
  add_six_degree_kernels(kernels);
  add_rows_kernels(kernels);
  return kernels;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
