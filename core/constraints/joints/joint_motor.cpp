// Motors: drive frame b to a pose in frame a, the rotation and the anchors' offset each by a drive of its
// own. The rotation's stands where that of BallParameters does, the offset's behind it. Kernels:
// simd/constraints/joints/joint_motor.cpp.
#include <core/constraints/joints/joint_field_checks.h>
#include <core/constraints/joints/joint_fields.h>
#include <core/constraints/joints/joint_kinds.h>
#include <core/world/math.h>

namespace scree::joint_kinds {

void write(const MotorJoint& motor, JointParameters& parameters) {
  MotorParameters& to = parameters.motor;
  to.angular_velocity_x = motor.rotation.velocity.x;
  to.angular_velocity_y = motor.rotation.velocity.y;
  to.angular_velocity_z = motor.rotation.velocity.z;
  to.angular_hertz = motor.rotation.hertz;
  to.angular_damping_ratio = motor.rotation.damping_ratio;
  to.max_torque = motor.rotation.max_torque;
  to.rotation_drive = number_of(motor.rotation.drive);
  put(to.target_rotation, motor.rotation.target);
  put(to.target, motor.target);
  to.hertz = motor.hertz;
  to.damping_ratio = motor.damping_ratio;
  to.max_force = motor.max_force;
  to.drive = number_of(motor.drive);
  put(to.velocity, motor.velocity);
}

void read(const JointParameters& parameters, MotorJoint& motor) {
  const MotorParameters& from = parameters.motor;
  motor = {
      .rotation = {.drive = drive_of(from.rotation_drive),
                   .target = rotation_of(from.target_rotation),
                   .velocity = {from.angular_velocity_x, from.angular_velocity_y, from.angular_velocity_z},
                   .hertz = from.angular_hertz,
                   .damping_ratio = from.angular_damping_ratio,
                   .max_torque = from.max_torque},
      .drive = drive_of(from.drive),
      .target = vector_of(from.target),
      .velocity = vector_of(from.velocity),
      .hertz = from.hertz,
      .damping_ratio = from.damping_ratio,
      .max_force = from.max_force};
}

bool is_rich(const MotorJoint& motor) {
  return motor.drive != Drive::none || motor.rotation.drive != Drive::none;
}

void renormalize(MotorJoint& motor) { motor.rotation.target = normalize(motor.rotation.target); }

void check(Call call, const MotorJoint& motor) {
  check_rotation_drive({call, "motor rotation."}, motor.rotation);
  const Part part{call, "motor "};
  part.drive("drive", motor.drive);
  part.vector("target", motor.target, kMaxJointValue);
  part.vector("velocity", motor.velocity, kMaxJointValue);
  part.spring("hertz", motor.hertz, "damping_ratio", motor.damping_ratio);
  part.strength("max_force", motor.max_force);
}

void check_ends(Call, const MotorJoint&, JointBodies) {}

}  // namespace scree::joint_kinds
