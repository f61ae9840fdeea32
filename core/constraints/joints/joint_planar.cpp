// Planar joints: hold anchor b in the plane of the y and z axes of frame a, and the x axes together. Axes 0
// and 1 of the parameters are the offsets in that plane, 2 the angle about x. Kernels:
// simd/constraints/joints/joint_planar.cpp.
#include <core/constraints/joints/joint_field_checks.h>
#include <core/constraints/joints/joint_fields.h>
#include <core/constraints/joints/joint_kinds.h>

namespace scree::joint_kinds {

void write(const PlanarJoint& planar, JointParameters& to) {
  to.planar.offset_y = row_of(planar.offset_y);
  to.planar.offset_z = row_of(planar.offset_z);
  to.planar.angle = row_of(planar.angle);
}

void read(const JointParameters& from, PlanarJoint& planar) {
  planar.offset_y = axis_of(from.planar.offset_y);
  planar.offset_z = axis_of(from.planar.offset_z);
  planar.angle = axis_of(from.planar.angle);
}

bool is_rich(const PlanarJoint& planar) {
  return is_rich_axis(planar.offset_y) || is_rich_axis(planar.offset_z) || is_rich_axis(planar.angle);
}

void renormalize(PlanarJoint&) {}

void check(Call call, const PlanarJoint& planar) {
  check_offset({call, "planar offset_y."}, planar.offset_y);
  check_offset({call, "planar offset_z."}, planar.offset_z);
  check_angle({call, "planar angle."}, planar.angle);
}

void check_ends(Call, const PlanarJoint&, JointBodies) {}

}  // namespace scree::joint_kinds
