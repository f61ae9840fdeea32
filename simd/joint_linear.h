// What joints with rows along axes have in common: anchors that move, impulses whose axes turn, matrices of
// two rows. Private to the joint kernels.
#pragma once

#include <simd/joint_block.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// Where the anchors lie: arms from the centers of mass, and the way from anchor a to anchor b.
struct Anchors {
  V3 arm_a, arm_b, offset;
};
struct AnchorLanes {
  LaneFloats arm_a[3], arm_b[3], offset[3];  // when the step began
};

inline Anchors store_anchors(const JointPlacement& at, AnchorLanes& lanes) {
  const Anchors now{at.arm_a, at.arm_b, at.center_offset + at.arm_b - at.arm_a};
  store3(lanes.arm_a, now.arm_a);
  store3(lanes.arm_b, now.arm_b);
  store3(lanes.offset, now.offset);
  return now;
}

// At the present poses.
inline Anchors move_anchors(const AnchorLanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b) {
  const V3 first_a = load3(lanes.arm_a), first_b = load3(lanes.arm_b);
  const V3 arm_a = rotate(delta_a.rotation, first_a), arm_b = rotate(delta_b.rotation, first_b);
  return {
      arm_a, arm_b,
      load3(lanes.offset) + (delta_b.position - delta_a.position) + (arm_b - first_b) - (arm_a - first_a)};
}

// Both frames' rotations in world axes, measured from where the step began.
struct FramePair {
  Q4 a, b;
};
struct FramePairLanes {
  LaneFloats a[4], b[4];
};

inline void store4(LaneFloats (&to)[4], Q4 q) {
  store(to[0], q.x);
  store(to[1], q.y);
  store(to[2], q.z);
  store(to[3], q.w);
}
inline Q4 load4(const LaneFloats (&from)[4]) {
  return {load(from[0]), load(from[1]), load(from[2]), load(from[3])};
}
inline FramePair store_frames(const JointPlacement& at, FramePairLanes& lanes) {
  store4(lanes.a, at.frame_a);
  store4(lanes.b, at.frame_b);
  return {at.frame_a, at.frame_b};
}
inline FramePair move_frames(const FramePairLanes& lanes, const WideDelta& delta_a,
                             const WideDelta& delta_b) {
  return {delta_a.rotation * load4(lanes.a), delta_b.rotation * load4(lanes.b)};
}

// A joint's impulses, all together: one at the levers, and a torque impulse. The opposite acts on a.
struct Wrench {
  V3 lever_a, lever_b, impulse, torque;
};

inline void push_wrench(const Wrench& wrench, JointBodies& bodies) {
  push(bodies, wrench.lever_a, wrench.lever_b, wrench.impulse);
  twist(bodies, wrench.torque);
}

// By what a relax has turned the impulses that the velocities hold; see joint_kernels.h.
struct TurnedLanes {
  LaneFloats impulse[3], torque_a[3], torque_b[3];
};

inline void clear_turned(TurnedLanes& lanes) {
  const V3 none{F(0.0f), F(0.0f), F(0.0f)};
  store3(lanes.impulse, none);
  store3(lanes.torque_a, none);
  store3(lanes.torque_b, none);
}
inline void store_turned(const Wrench& before, const Wrench& now, TurnedLanes& lanes) {
  const V3 torque = now.torque - before.torque;
  store3(lanes.impulse, now.impulse - before.impulse);
  store3(lanes.torque_a, cross(now.lever_a, now.impulse) - cross(before.lever_a, before.impulse) + torque);
  store3(lanes.torque_b, cross(now.lever_b, now.impulse) - cross(before.lever_b, before.impulse) + torque);
}
// First in a solve.
inline void push_turned(const TurnedLanes& lanes, JointBodies& bodies, F keep) {
  const V3 impulse = load3(lanes.impulse) * keep;
  bodies.a.linear = bodies.a.linear - impulse * bodies.mass_a.inverse_mass;
  bodies.b.linear = bodies.b.linear + impulse * bodies.mass_b.inverse_mass;
  bodies.a.angular = bodies.a.angular - bodies.mass_a.inverse_inertia * (load3(lanes.torque_a) * keep);
  bodies.b.angular = bodies.b.angular + bodies.mass_b.inverse_inertia * (load3(lanes.torque_b) * keep);
}

// Relative angular velocity by a unit torque impulse.
inline S3 turn_response(const JointBodies& bodies) {
  return bodies.mass_a.inverse_inertia + bodies.mass_b.inverse_inertia;
}
// Relative angular velocity by an impulse at the levers.
inline V3 turn_by_impulse(const JointBodies& bodies, V3 lever_a, V3 lever_b, V3 impulse) {
  return bodies.mass_a.inverse_inertia * cross(lever_a, impulse) +
         bodies.mass_b.inverse_inertia * cross(lever_b, impulse);
}
// Relative velocity at the levers by a torque impulse.
inline V3 move_by_torque(const JointBodies& bodies, V3 lever_a, V3 lever_b, V3 torque) {
  return cross(bodies.mass_a.inverse_inertia * torque, lever_a) +
         cross(bodies.mass_b.inverse_inertia * torque, lever_b);
}

// Inverse of an angular response in world axes. Locks of axes leave rows of zeros: these do not take part.
inline S3 invert_turn_response(S3 m) {
  const F zero(0.0f), trace = m.xx + m.yy + m.zz;
  const M has_x = m.xx > zero, has_y = m.yy > zero, has_z = m.zz > zero;
  m.xx = select(has_x, m.xx, trace);
  m.yy = select(has_y, m.yy, trace);
  m.zz = select(has_z, m.zz, trace);
  S3 inverse = invert(m);
  inverse.xx = select(has_x, inverse.xx, zero);
  inverse.yy = select(has_y, inverse.yy, zero);
  inverse.zz = select(has_z, inverse.zz, zero);
  return inverse;
}

// Relative velocity at the levers by a unit impulse there, while a torque keeps the bodies from turning
// against each other: as one body, that is. `turn_mass` is invert_turn_response(turn_response(bodies)).
//
// With inverse inertias A and B the levers a and b act through A, B and (A + B)^-1; what is left of that is
// their difference, which is the way from center to center, acting through A (A + B)^-1 B.
inline S3 response_of_both(const JointBodies& bodies, const S3& turn_mass, V3 center_offset) {
  const S3 &a = bodies.mass_a.inverse_inertia, &b = bodies.mass_b.inverse_inertia;
  const V3 x = a * (turn_mass * V3{b.xx, b.xy, b.xz});
  const V3 y = a * (turn_mass * V3{b.xy, b.yy, b.yz});
  const V3 z = a * (turn_mass * V3{b.xz, b.yz, b.zz});
  S3 k = lever_response(center_offset, {x.x, y.x, z.x, y.y, z.y, z.z});
  const F inverse_mass = bodies.mass_a.inverse_mass + bodies.mass_b.inverse_mass;
  k.xx += inverse_mass;
  k.yy += inverse_mass;
  k.zz += inverse_mass;
  return k;
}

// Symmetric 2x2.
struct S2 {
  F xx, xy, yy;
};
// Scaled to a trace of 1, as in invert(S3). Rounding can spoil the determinant; its true value is positive.
inline S2 invert(const S2& m) {
  const F unit = invert_positive(m.xx + m.yy);
  const F xx = unit * m.xx, xy = unit * m.xy, yy = unit * m.yy;
  const F inverse = unit * invert_positive(max(xx * yy - xy * xy, F(1e-6f) * (xx * yy)));
  return {inverse * yy, -(inverse * xy), inverse * xx};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
