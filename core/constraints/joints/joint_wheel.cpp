// Wheels: hold the spin axis of a wheel square to its suspension. Axis 0 of the parameters is the suspension,
// 1 the steering, 2 the spin, a speed alone. Kernels: simd/constraints/joints/joint_wheel.cpp.
#include <core/constraints/joints/joint_field_checks.h>
#include <core/constraints/joints/joint_fields.h>
#include <core/constraints/joints/joint_kinds.h>

namespace scree::joint_kinds {

namespace {

constexpr const char* kNoSpinLimit = ", a wheel's spin has no limits";

}  // namespace

void write(const WheelJoint& wheel, JointParameters& to) {
  to.wheel.suspension = row_of(wheel.suspension);
  to.wheel.steering = row_of(wheel.steering);
  to.wheel.spin = row_of(wheel.spin);
}

void read(const JointParameters& from, WheelJoint& wheel) {
  wheel.suspension = axis_of(from.wheel.suspension);
  wheel.steering = axis_of(from.wheel.steering);
  wheel.spin = axis_of(from.wheel.spin);
}

bool is_rich(const WheelJoint& wheel) {
  return is_rich_axis(wheel.suspension) || is_rich_axis(wheel.steering) || is_rich_axis(wheel.spin);
}

void renormalize(WheelJoint&) {}

void check(Call call, const WheelJoint& wheel) {
  check_offset({call, "wheel suspension."}, wheel.suspension);
  check_angle({call, "wheel steering."}, wheel.steering, kMaxSteering);
  const Part spin{call, "wheel spin."};
  check_offset(spin, wheel.spin);
  if (wheel.spin.lower > -kNoLimit)
    fail(call, spin.name("lower is ") + text_of(wheel.spin.lower) + kNoSpinLimit);
  if (wheel.spin.upper < kNoLimit)
    fail(call, spin.name("upper is ") + text_of(wheel.spin.upper) + kNoSpinLimit);
  if (wheel.spin.drive == Drive::spring) fail(call, "wheel spin.drive is a spring, must be a motor or none");
}

void check_ends(Call, const WheelJoint&, JointBodies) {}

}  // namespace scree::joint_kinds
