// Mice: drag the anchor of body b to a point of the world by a spring, which alone has a drive's fields in
// the parameters. Kernels: simd/constraints/joints/joint_mouse.cpp.
#include <core/constraints/joints/joint_field_checks.h>
#include <core/constraints/joints/joint_fields.h>
#include <core/constraints/joints/joint_kinds.h>

#include <string>

namespace scree::joint_kinds {

void write(const MouseJoint& mouse, JointParameters& to) {
  to.mouse.hertz = mouse.hertz;
  to.mouse.damping_ratio = mouse.damping_ratio;
  to.mouse.max_force = mouse.max_force;
  to.mouse.drive = number_of(Drive::spring);
  put(to.mouse.target, mouse.target);
}

void read(const JointParameters& from, MouseJoint& mouse) {
  mouse = {.target = vector_of(from.mouse.target),
           .hertz = from.mouse.hertz,
           .damping_ratio = from.mouse.damping_ratio,
           .max_force = from.mouse.max_force};
}

bool is_rich(const MouseJoint&) { return true; }

void renormalize(MouseJoint&) {}

void check(Call call, const MouseJoint& mouse) {
  const Part part{call, "mouse "};
  part.vector("target", mouse.target, kMaxPosition);
  part.spring("hertz", mouse.hertz, "damping_ratio", mouse.damping_ratio);
  part.strength("max_force", mouse.max_force);
}

void check_ends(Call call, const MouseJoint&, JointBodies ends) {
  if (ends.a == kFixedRow) return;
  fail(call, "body_a of a mouse joint is body " + std::to_string(ends.a) + ", must be the world");
}

}  // namespace scree::joint_kinds
