// Makes the table of this instruction set from the kernel families.
#include <simd/dispatch/kernels.h>

#define SCREE_STRINGIZE_AGAIN(text) #text
#define SCREE_STRINGIZE(text) SCREE_STRINGIZE_AGAIN(text)

namespace scree::simd::SCREE_SIMD_NAMESPACE {

BodyKernels make_body_kernels();
PairKernels make_pair_kernels();
CollideKernels make_collide_kernels();
ContactKernels make_contact_kernels();
JointKernels make_joint_kernels();
QueryKernels make_query_kernels();

Kernels make_kernels() {
  return {InstructionSet::SCREE_SIMD_NAMESPACE,
          SCREE_STRINGIZE(SCREE_SIMD_NAMESPACE),
          SCREE_SIMD_LANES,
          make_body_kernels(),
          make_pair_kernels(),
          make_collide_kernels(),
          make_contact_kernels(),
          make_joint_kernels(),
          make_query_kernels()};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
