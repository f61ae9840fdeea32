// Racks with pinions: tie the way of body b to the turn of body a by the pinion's radius, which stands where
// the target of axis 0 does, as the ratio of gears. Kernels:
// simd/constraints/joints/joint_rack_and_pinion.cpp.
#include <core/constraints/joints/joint_field_checks.h>
#include <core/constraints/joints/joint_kinds.h>

namespace scree::joint_kinds {

void write(const RackAndPinionJoint& rack, JointParameters& to) { to.rack_and_pinion.radius = rack.radius; }

void read(const JointParameters& from, RackAndPinionJoint& rack) {
  rack.radius = from.rack_and_pinion.radius;
}

bool is_rich(const RackAndPinionJoint&) { return false; }

void renormalize(RackAndPinionJoint&) {}

void check(Call call, const RackAndPinionJoint& rack) {
  check_factor({call, "rack_and_pinion "}, "radius", rack.radius);
}

void check_ends(Call, const RackAndPinionJoint&, JointBodies) {}

}  // namespace scree::joint_kinds
