// How the frames of joints turn against each other, and rows that hold, limit or drive that beside a held
// point. Private to the joint kernels.
//
// Angular errors are rotation vectors that take frame a to frame b, in world axes. They are measured from the
// frames' rotations when the step began and the motion since, and so never drift.
#pragma once

#include <simd/constraints/joints/joint_measure.h>
#include <simd/constraints/joints/joint_point.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

inline M3 load9(const LaneFloats (&from)[3][3]) { return {load3(from[0]), load3(from[1]), load3(from[2])}; }
inline void store9(LaneFloats (&to)[3][3], const M3& m) {
  store3(to[0], m.x);
  store3(to[1], m.y);
  store3(to[2], m.z);
}

inline V3 x_axis(Q4 q) {
  const F one(1.0f), two(2.0f);
  return {one - two * (q.y * q.y + q.z * q.z), two * (q.x * q.y + q.w * q.z), two * (q.x * q.z - q.w * q.y)};
}

// rad: turns below this are linear in the half angle up to rounding.
constexpr float kSmallTurn = 1e-4f;

// The rotation by a rotation vector of any length.
inline Q4 rotation_by(V3 v) {
  const F one(1.0f), two(2.0f), whole = length(v);
  const F turns = round_to_nearest(whole * F(0.5f * 0.159154943f));
  // An eighth of the angle, within pi/4: series, then doubled twice to half the angle.
  const F x = F(0.25f) * ((F(0.5f) * whole - turns * F(6.28125f)) - turns * F(1.93530718e-3f));
  const F s = x * x;
  F sine = x * (one + s * (F(-1.66666667e-1f) +
                           s * (F(8.33333333e-3f) + s * (F(-1.98412698e-4f) + s * F(2.75573192e-6f)))));
  F cosine =
      one + s * (F(-0.5f) + s * (F(4.16666667e-2f) + s * (F(-1.38888889e-3f) + s * F(2.48015873e-5f))));
  for (int doubling = 0; doubling < 2; ++doubling) {
    const F twice = two * sine * cosine;
    cosine = one - two * sine * sine;
    sine = twice;
  }
  const M small = whole < F(kSmallTurn);
  const F scale = select(small, F(0.5f), sine / select(small, one, whole));
  return {v.x * scale, v.y * scale, v.z * scale, cosine};
}

// The angle about x, in (-pi, pi], of what is left of a relative rotation once the shortest turn that brings
// the x axes together is taken away.
inline F twist_angle(Q4 relative) {
  const F zero(0.0f);
  const M flip = (relative.w < zero) | ((relative.w == zero) & (relative.x < zero));
  const F sign = select(flip, F(-1.0f), F(1.0f));
  return F(2.0f) * atan2(relative.x * sign, relative.w * sign);
}

// An impulse at the arms and a torque impulse: on b, their opposites on a.
inline void push_and_twist(JointBodyLanes& bodies, V3 arm_a, V3 arm_b, V3 impulse, V3 torque) {
  bodies.a.linear = bodies.a.linear - impulse * bodies.mass_a.inverse_mass;
  bodies.a.angular = bodies.a.angular - bodies.mass_a.inverse_inertia * (cross(arm_a, impulse) + torque);
  bodies.b.linear = bodies.b.linear + impulse * bodies.mass_b.inverse_mass;
  bodies.b.angular = bodies.b.angular + bodies.mass_b.inverse_inertia * (cross(arm_b, impulse) + torque);
}

// How two bodies turn against each other about a point of both that is held. A torque impulse t about it
// comes with the impulse -share t at the anchors, which keeps these together; so rows that turn the bodies
// this way leave the point's rows alone, and one pass over both is exact.
struct HeldTurning {
  M3 share;    // with the point's response P and the anchors' velocity C by torques: P^-1 C
  S3 inertia;  // about the point: torque by velocity
};

// Built from sums of positive matrices alone. As the difference of the response to torques and what the
// point takes away of it, C^T P^-1 C, a small body on a long arm would lose all its digits.
inline HeldTurning held_turning(const JointBodyLanes& bodies, V3 arm_a, V3 arm_b, const S3& inverse_point) {
  const S3 &i_a = bodies.mass_a.inverse_inertia, &i_b = bodies.mass_b.inverse_inertia;
  const S3 moment = invert_semidefinite(turn_response(bodies));
  // Response of the point while the bodies turn as one: 1 / (inertia a + inertia b), at the arm between the
  // centers of mass.
  const M3 shared{moment * V3{i_b.xx, i_b.xy, i_b.xz}, moment * V3{i_b.xy, i_b.yy, i_b.yz},
                  moment * V3{i_b.xz, i_b.yz, i_b.zz}};
  const V3 x = i_a * shared.x, y = i_a * shared.y, z = i_a * shared.z;
  S3 point = lever_response(arm_a - arm_b, {x.x, y.x, z.x, y.y, z.y, z.z});
  const F inverse_mass = bodies.mass_a.inverse_mass + bodies.mass_b.inverse_mass;
  point.xx += inverse_mass;
  point.yy += inverse_mass;
  point.zz += inverse_mass;
  const S3 inverse = invert(point);

  const auto anchors_by = [&](V3 a, V3 b) { return cross(a, arm_a) + cross(b, arm_b); };
  const M3 by_torque{anchors_by({i_a.xx, i_a.xy, i_a.xz}, {i_b.xx, i_b.xy, i_b.xz}),
                     anchors_by({i_a.xy, i_a.yy, i_a.yz}, {i_b.xy, i_b.yy, i_b.yz}),
                     anchors_by({i_a.xz, i_a.yz, i_a.zz}, {i_b.xz, i_b.yz, i_b.zz})};
  const V3 e_x = by_torque * V3{moment.xx, moment.xy, moment.xz};
  const V3 e_y = by_torque * V3{moment.xy, moment.yy, moment.yz};
  const V3 e_z = by_torque * V3{moment.xz, moment.yz, moment.zz};
  const V3 f_x = inverse * e_x, f_y = inverse * e_y, f_z = inverse * e_z;
  const S3 lever{dot(e_x, f_x), dot(e_x, f_y), dot(e_x, f_z), dot(e_y, f_y), dot(e_y, f_z), dot(e_z, f_z)};
  return {{inverse_point * by_torque.x, inverse_point * by_torque.y, inverse_point * by_torque.z},
          moment + lever};
}

// Rows that hold a rotation, or two components of it, together with a held point: both are solved as one.
// With the response [P C; C^T A] of points and rotations, the rows of the rotation less C^T P^-1 times those
// of the point are independent of these; there each may have a softness of its own.
struct TurningLanes {
  LaneFloats share[3][3];  // HeldTurning
  LaneFloats inertia[6];   // the same, without the directions that are free
  LaneFloats error[3];
  LaneFloats torque[3];  // impulse, about the anchor, in world axes
};

inline void warm_start_held(const PointLanes& point, const TurningLanes& turning, JointBodyLanes& bodies) {
  push_and_twist(bodies, load3(point.arm_a), load3(point.arm_b), load3(point.impulse), load3(turning.torque));
}

// After turn_point() or move_point(). Returns the anchors' speed that was left.
inline F solve_held(PointLanes& point, TurningLanes& turning, JointBodyLanes& bodies, const Softness& soft,
                    const Softness& soft_turning, F keep) {
  const V3 arm_a = load3(point.arm_a), arm_b = load3(point.arm_b);
  const M3 share = load9(turning.share);
  const V3 old_impulse = load3(point.impulse) * keep, old_torque = load3(turning.torque) * keep;
  const V3 left = anchor_velocity(bodies, arm_a, arm_b);
  const V3 speed = left + load3(point.error) * soft.bias_rate;
  const V3 rate = turning_speed(bodies) + load3(turning.error) * soft_turning.bias_rate -
                  multiply_transposed(share, speed);
  const V3 torque =
      load6(turning.inertia) * (rate * -soft_turning.mass_scale) - old_torque * soft_turning.impulse_scale;
  const V3 impulse = load6(point.inverse_response) * (speed * -soft.mass_scale) -
                     (old_impulse + share * old_torque) * soft.impulse_scale - share * torque;
  store3(point.impulse, old_impulse + impulse);
  store3(turning.torque, old_torque + torque);
  push_and_twist(bodies, arm_a, arm_b, impulse, torque);
  return length(left);
}

// Inherited torque impulses act about new axes: `change` is by how much that differs. After move_point().
inline void turn_torque(PointLanes& point, V3 change) {
  store3(point.turned_a, load3(point.turned_a) + change);
  store3(point.turned_b, load3(point.turned_b) + change);
}

// Impulses 0 to 2 and 4 to 6.
inline void store_held(const JointArgs& args, const std::int32_t* joint, int count, const PointLanes& point,
                       const TurningLanes& turning) {
  const V3 impulse = finite_or_zero(load3(point.impulse)), torque = finite_or_zero(load3(turning.torque));
  store_impulses(args, joint, count, 0, impulse.x, impulse.y, impulse.z, F(0.0f));
  store_impulses(args, joint, count, 1, torque.x, torque.y, torque.z, F(0.0f));
}

// scree::RotationDrive.
struct RotationDriveLanes {
  LaneFloats target[4];             // of frame b in frame a, where the step begins
  LaneFloats velocity[3];           // in the axes of frame a
  LaneFloats max_impulse;           // of the torque, in a substep
  LaneSoftness drive;               // as in LaneAxis
  LaneFloats error[3], turning[3];  // how far ahead of the target, and the target's velocity; in world axes
  LaneFloats impulse[3];            // of the torque, in world axes
};

inline void aim_rotation_drive(const Frames& frames, F elapsed, RotationDriveLanes& lanes) {
  const V3 velocity = load3(lanes.velocity);
  const Q4 target = rotation_by(velocity * elapsed) * load4(lanes.target);
  const V3 ahead = rotation_vector(conjugate(frames.a) * frames.b * conjugate(target));
  store3(lanes.error, rotate(frames.a, ahead));
  store3(lanes.turning, rotate(frames.a, velocity));
}

inline void prepare_rotation_drive(const JointArgs& args, const std::int32_t* joint,
                                   const JointBodyLanes& bodies, const Frames& frames, V3 impulse,
                                   RotationDriveLanes& lanes) {
  const RotationTarget target = load_rotation_target(args, joint);
  const WideDrive given = load_rotation_drive(args, joint);
  const M spring = given.drive == I(static_cast<std::int32_t>(kDriveSpring));
  const M idle = given.drive == I(static_cast<std::int32_t>(kDriveNone));
  const F zero(0.0f), one(1.0f);
  const V3 none{zero, zero, zero};
  const Softness soft = soften(args, bodies, select(spring, given.hertz, one), given.damping_ratio);
  store4(lanes.target, target.rotation);
  store3(lanes.velocity, target.velocity);
  store(lanes.max_impulse, select(idle, zero, given.max_force * F(args.substep)));
  store_softness(lanes.drive, {select(spring, soft.bias_rate, zero), select(spring, soft.mass_scale, one),
                               select(spring, soft.impulse_scale, zero)});
  store3(lanes.impulse, select(idle, none, impulse * F(args.warm_start_scale)));
  aim_rotation_drive(frames, zero, lanes);
}

// Returns the change of the torque impulse. `response`: of turning to torques, of what the bodies turn about.
inline V3 solve_rotation_drive(RotationDriveLanes& lanes, V3 turning, const S3& response, F keep) {
  const Softness soft = load_softness(lanes.drive);
  const V3 old_impulse = load3(lanes.impulse) * keep;
  const V3 error = turning - load3(lanes.turning) + load3(lanes.error) * soft.bias_rate;
  const V3 free = old_impulse - invert_semidefinite(response) * (error * soft.mass_scale) -
                  old_impulse * soft.impulse_scale;
  // What the spring gives way by is impulse_scale / mass_scale of the response.
  const V3 speed = error * soft.mass_scale + (response * old_impulse) * soft.impulse_scale;
  const V3 impulse = bound_length(free, old_impulse, speed, trace(response), load(lanes.max_impulse));
  store3(lanes.impulse, impulse);
  return impulse - old_impulse;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
