// The kernels of one instruction set as a table of functions, and the choice of a table.
//
// Each family has a header of its own. The sources beside it, compiled once per instruction set, implement
// it. Nothing here depends on the compiler's flags.
#pragma once

#include <simd/bodies/body_kernels.h>
#include <simd/broad_phase/pair_kernels.h>
#include <simd/collide/collide_kernels.h>
#include <simd/constraints/contact/contact_kernels.h>
#include <simd/constraints/joints/joint_kernels.h>
#include <simd/queries/query_kernels.h>

namespace scree::simd {

enum class InstructionSet : int { scalar, sse2, avx2, avx512 };
inline constexpr int kInstructionSetCount = 4;

struct Kernels {
  InstructionSet instruction_set;
  const char* name;
  int lanes;
  BodyKernels body;
  PairKernels pair;
  CollideKernels collide;
  ContactKernels contact;
  JointKernels joint;
  QueryKernels query;
};

// Null where this build lacks the set or the processor lacks one of the features that its flags allow.
const Kernels* find_kernels(InstructionSet set);
// The widest set that runs here.
const Kernels& widest_kernels();

}  // namespace scree::simd
