// Hinges: hold the anchors and the x axes together and leave the angle about x, which is axis 0 of the
// parameters. Kernels: simd/constraints/joints/joint_hinge.cpp.
#include <core/constraints/joints/joint_field_checks.h>
#include <core/constraints/joints/joint_fields.h>
#include <core/constraints/joints/joint_kinds.h>

namespace scree::joint_kinds {

void write(const HingeJoint& hinge, JointParameters& to) { to.hinge.angle = row_of(hinge.angle); }

void read(const JointParameters& from, HingeJoint& hinge) { hinge.angle = axis_of(from.hinge.angle); }

bool is_rich(const HingeJoint& hinge) { return is_rich_axis(hinge.angle); }

void renormalize(HingeJoint&) {}

void check(Call call, const HingeJoint& hinge) { check_angle({call, "hinge angle."}, hinge.angle); }

void check_ends(Call, const HingeJoint&, JointBodies) {}

}  // namespace scree::joint_kinds
