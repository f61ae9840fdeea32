// Distance joints: rods, ropes and springs from anchor to anchor. They hold nothing; the distance is axis 0
// of the parameters. Kernels: simd/constraints/joints/joint_distance.cpp.
#include <core/constraints/joints/joint_field_checks.h>
#include <core/constraints/joints/joint_fields.h>
#include <core/constraints/joints/joint_kinds.h>

namespace scree::joint_kinds {

void write(const DistanceJoint& distance, JointParameters& to) {
  to.distance.length = row_of(distance.length);
}

void read(const JointParameters& from, DistanceJoint& distance) {
  distance.length = axis_of(from.distance.length);
}

bool is_rich(const DistanceJoint& distance) { return is_rich_axis(distance.length); }

void renormalize(DistanceJoint&) {}

void check(Call call, const DistanceJoint& distance) {
  const Part part{call, "distance length."};
  check_axis(part, distance.length, 0.0f, kMaxJointValue);
  part.range("target", distance.length.target, 0.0f, kMaxJointValue);
}

void check_ends(Call, const DistanceJoint&, JointBodies) {}

}  // namespace scree::joint_kinds
