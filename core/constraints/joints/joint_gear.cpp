// Gears: tie the turns of two bodies about their x axes by a ratio, which stands where the target of axis 0
// does. Kernels: simd/constraints/joints/joint_gear.cpp.
#include <core/constraints/joints/joint_field_checks.h>
#include <core/constraints/joints/joint_kinds.h>

namespace scree::joint_kinds {

void write(const GearJoint& gear, JointParameters& to) { to.gear.ratio = gear.ratio; }

void read(const JointParameters& from, GearJoint& gear) { gear.ratio = from.gear.ratio; }

bool is_rich(const GearJoint&) { return false; }

void renormalize(GearJoint&) {}

void check(Call call, const GearJoint& gear) { check_factor({call, "gear "}, "ratio", gear.ratio); }

void check_ends(Call, const GearJoint&, JointBodies) {}

}  // namespace scree::joint_kinds
