// What core knows of each kind of joint: joint_<kind>.cpp beside this file defines these functions for one
// kind, and simd/constraints/joints/joint_<kind>.cpp has its kernels. joint_parameters.cpp and
// check_joint.cpp call them by kind.
//
//   write         fills the kind's fields of the parameters that kernels read, exactly; all axes of `to` are
//                 free before
//   read          the opposite: what was written, exactly
//   is_rich       whether the joint has limits or drives, which kernels of plain joints leave out
//   renormalize   makes its rotations of unit length
//   check         throws Error where a field is out of the range that scree/joint.h gives
//   check_ends    throws Error where it cannot join these bodies
//
// They are declared for every kind of the list: the linker names what a new kind lacks.
#pragma once

#include <core/plain/joint.h>
#include <core/world/check.h>
#include <scree/joint.h>

namespace scree::joint_kinds {

#define SCREE_JOINT_TYPE(kind, Struct)                 \
  void write(const Struct& from, JointParameters& to); \
  void read(const JointParameters& from, Struct& to);  \
  bool is_rich(const Struct& joint);                   \
  void renormalize(Struct& joint);                     \
  void check(Call call, const Struct& joint);          \
  void check_ends(Call call, const Struct& joint, JointBodies ends);
SCREE_FOR_EACH_JOINT_TYPE(SCREE_JOINT_TYPE)
#undef SCREE_JOINT_TYPE

}  // namespace scree::joint_kinds
