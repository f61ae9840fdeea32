// Universal joints: hold the anchors together and the x axis of frame a square to the y axis of frame b. Axes
// 0 and 1 of the parameters are the angles about these two. Kernels:
// simd/constraints/joints/joint_universal.cpp.
#include <core/constraints/joints/joint_field_checks.h>
#include <core/constraints/joints/joint_fields.h>
#include <core/constraints/joints/joint_kinds.h>

namespace scree::joint_kinds {

void write(const UniversalJoint& universal, JointParameters& to) {
  to.universal.first = row_of(universal.first);
  to.universal.second = row_of(universal.second);
}

void read(const JointParameters& from, UniversalJoint& universal) {
  universal.first = axis_of(from.universal.first);
  universal.second = axis_of(from.universal.second);
}

bool is_rich(const UniversalJoint& universal) {
  return is_rich_axis(universal.first) || is_rich_axis(universal.second);
}

void renormalize(UniversalJoint&) {}

void check(Call call, const UniversalJoint& universal) {
  check_angle({call, "universal first."}, universal.first);
  check_angle({call, "universal second."}, universal.second);
}

void check_ends(Call, const UniversalJoint&, JointBodies) {}

}  // namespace scree::joint_kinds
