// Welds: hold the frames together, offset and rotation each with its own stiffness. That of the rotation
// takes the place of JointParameters::angular_hertz, which other kinds have from JointDef. Kernels:
// simd/constraints/joints/joint_weld.cpp.
#include <core/constraints/joints/joint_kinds.h>

namespace scree::joint_kinds {

void write(const WeldJoint& weld, JointParameters& to) {
  to.angular_hertz = weld.angular_hertz;
  to.angular_damping_ratio = weld.angular_damping_ratio;
}

void read(const JointParameters& from, WeldJoint& weld) {
  weld.angular_hertz = from.angular_hertz;
  weld.angular_damping_ratio = from.angular_damping_ratio;
}

bool is_rich(const WeldJoint&) { return false; }

void renormalize(WeldJoint&) {}

void check(Call call, const WeldJoint& weld) {
  check_stiffness(call, "weld angular_hertz", weld.angular_hertz, "weld angular_damping_ratio",
                  weld.angular_damping_ratio);
}

void check_ends(Call, const WeldJoint&, JointBodies) {}

}  // namespace scree::joint_kinds
