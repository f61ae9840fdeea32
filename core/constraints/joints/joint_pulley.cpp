// Pulleys: a rope over two points of the world. Its length is limited as axis 0 of the parameters is: both
// ends are the length where the rope is rigid, the upper one alone elsewhere. Kernels:
// simd/constraints/joints/joint_pulley.cpp.
#include <core/constraints/joints/joint_field_checks.h>
#include <core/constraints/joints/joint_fields.h>
#include <core/constraints/joints/joint_kinds.h>

namespace scree::joint_kinds {

void write(const PulleyJoint& pulley, JointParameters& to) {
  to.pulley.least_length = pulley.rigid ? pulley.length : -kNoLimit;
  to.pulley.length = pulley.length;
  to.pulley.ratio = pulley.ratio;
  put(to.pulley.point_a, pulley.point_a);
  put(to.pulley.point_b, pulley.point_b);
}

void read(const JointParameters& from, PulleyJoint& pulley) {
  pulley = {.point_a = vector_of(from.pulley.point_a),
            .point_b = vector_of(from.pulley.point_b),
            .ratio = from.pulley.ratio,
            .length = from.pulley.length,
            .rigid = from.pulley.least_length == from.pulley.length};
}

bool is_rich(const PulleyJoint&) { return true; }

void renormalize(PulleyJoint&) {}

void check(Call call, const PulleyJoint& pulley) {
  const Part part{call, "pulley "};
  part.vector("point_a", pulley.point_a, kMaxPosition);
  part.vector("point_b", pulley.point_b, kMaxPosition);
  part.range("ratio", pulley.ratio, kMinRatio, kMaxRatio);
  part.range("length", pulley.length, 0.0f, kMaxRope);
}

void check_ends(Call, const PulleyJoint&, JointBodies) {}

}  // namespace scree::joint_kinds
