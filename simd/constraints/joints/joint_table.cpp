// The table of the joint kernels: each kind's come from the source of its name beside this file.
#include <simd/constraints/joints/joint_sweeps.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

#define SCREE_JOINT_TYPE(kind, Struct) \
  template <>                          \
  JointTypeKernels make_joint_type_kernels<JointType::kind>();
SCREE_FOR_EACH_JOINT_TYPE(SCREE_JOINT_TYPE)
#undef SCREE_JOINT_TYPE

JointKernels make_joint_kernels() {
  JointKernels kernels{};
  const auto add = [&](JointType type, const JointTypeKernels& made) {
    kernels.variant[joint_variant(type, false)] = made.plain;
    kernels.variant[joint_variant(type, true)] = made.rich;
  };
#define SCREE_JOINT_TYPE(kind, Struct) add(JointType::kind, make_joint_type_kernels<JointType::kind>());
  SCREE_FOR_EACH_JOINT_TYPE(SCREE_JOINT_TYPE)
#undef SCREE_JOINT_TYPE
  return kernels;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
