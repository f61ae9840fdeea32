// Joints of six degrees of freedom: each coordinate free, limited, held or driven. The offsets are axes 0 to
// 2 of the parameters, the angles axes 3 to 5. Kernels: simd/constraints/joints/joint_six_degree.cpp.
#include <core/constraints/joints/joint_field_checks.h>
#include <core/constraints/joints/joint_fields.h>
#include <core/constraints/joints/joint_kinds.h>

namespace scree::joint_kinds {

void write(const SixDegreeJoint& joint, JointParameters& to) {
  for (int i = 0; i < 3; ++i) {
    to.six_degree.offset[i] = row_of(joint.offset[i]);
    to.six_degree.angle[i] = row_of(joint.angle[i]);
  }
}

void read(const JointParameters& from, SixDegreeJoint& joint) {
  for (int i = 0; i < 3; ++i) {
    joint.offset[i] = axis_of(from.six_degree.offset[i]);
    joint.angle[i] = axis_of(from.six_degree.angle[i]);
  }
}

bool is_rich(const SixDegreeJoint& joint) {
  bool rich = false;
  for (int i = 0; i < 3; ++i) rich = rich || is_rich_axis(joint.offset[i]) || is_rich_axis(joint.angle[i]);
  return rich;
}

void renormalize(SixDegreeJoint&) {}

void check(Call call, const SixDegreeJoint& joint) {
  constexpr const char* kOffsets[] = {"six_degree offset[0].", "six_degree offset[1].",
                                      "six_degree offset[2]."};
  constexpr const char* kAngles[] = {"six_degree angle[0].", "six_degree angle[1].", "six_degree angle[2]."};
  for (int i = 0; i < 3; ++i) {
    check_offset({call, kOffsets[i]}, joint.offset[i]);
    check_angle({call, kAngles[i]}, joint.angle[i]);
  }
}

void check_ends(Call, const SixDegreeJoint&, JointBodies) {}

}  // namespace scree::joint_kinds
