// Ball joints: hold the anchors together and leave the rotation, with cone and twist limits and a drive to an
// orientation. The limits stand where those of axes 0 (twist) and 1 (cone) do, the drive's velocity as the
// last number of axes 0 to 2. Kernels: simd/constraints/joints/joint_ball.cpp.
#include <core/constraints/joints/joint_field_checks.h>
#include <core/constraints/joints/joint_fields.h>
#include <core/constraints/joints/joint_kinds.h>
#include <core/world/math.h>

namespace scree::joint_kinds {

void write(const BallJoint& ball, JointParameters& parameters) {
  BallParameters& to = parameters.ball;
  to.twist_lower = ball.twist_lower;
  to.twist_upper = ball.twist_upper;
  to.cone_limit = ball.cone_limit;
  to.velocity_x = ball.drive.velocity.x;
  to.velocity_y = ball.drive.velocity.y;
  to.velocity_z = ball.drive.velocity.z;
  to.hertz = ball.drive.hertz;
  to.damping_ratio = ball.drive.damping_ratio;
  to.max_torque = ball.drive.max_torque;
  to.drive = number_of(ball.drive.drive);
  put(to.target, ball.drive.target);
}

void read(const JointParameters& parameters, BallJoint& ball) {
  const BallParameters& from = parameters.ball;
  ball = {.cone_limit = from.cone_limit,
          .twist_lower = from.twist_lower,
          .twist_upper = from.twist_upper,
          .drive = {.drive = drive_of(from.drive),
                    .target = rotation_of(from.target),
                    .velocity = {from.velocity_x, from.velocity_y, from.velocity_z},
                    .hertz = from.hertz,
                    .damping_ratio = from.damping_ratio,
                    .max_torque = from.max_torque}};
}

bool is_rich(const BallJoint& ball) {
  return ball.cone_limit < kNoLimit || ball.twist_lower > -kNoLimit || ball.twist_upper < kNoLimit ||
         ball.drive.drive != Drive::none;
}

void renormalize(BallJoint& ball) { ball.drive.target = normalize(ball.drive.target); }

void check(Call call, const BallJoint& ball) {
  const Part part{call, "ball "};
  part.limit("cone_limit", ball.cone_limit, kNoLimit, 0.0f, kMaxJointAngle);
  part.limits("twist_lower", ball.twist_lower, "twist_upper", ball.twist_upper, -kMaxJointAngle,
              kMaxJointAngle);
  check_rotation_drive({call, "ball drive."}, ball.drive);
}

void check_ends(Call, const BallJoint&, JointBodies) {}

}  // namespace scree::joint_kinds
