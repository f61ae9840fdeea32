// What joints with rows along axes have in common: anchors that move, impulses whose axes turn, matrices of
// two rows. Private to the joint kernels.
#pragma once

#include <simd/constraints/joints/joint_frames.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// A joint's impulses, all together: one at the levers, and a torque impulse. The opposite acts on a.
struct Wrench {
  V3 lever_a, lever_b, impulse, torque;
};

inline void push_wrench(const Wrench& wrench, JointBodyLanes& bodies) {
  push(bodies, wrench.lever_a, wrench.lever_b, wrench.impulse);
  twist(bodies, wrench.torque);
}

inline JointImpulse acting_of(const Wrench& wrench) { return {wrench.impulse, wrench.torque}; }

// Of the speed along a direction at the levers to a unit impulse there.
inline F response_along(const JointBodyLanes& bodies, V3 lever_a, V3 lever_b, V3 direction) {
  const V3 turn_a = cross(lever_a, direction), turn_b = cross(lever_b, direction);
  return bodies.mass_a.inverse_mass + bodies.mass_b.inverse_mass +
         dot(turn_a, bodies.mass_a.inverse_inertia * turn_a) +
         dot(turn_b, bodies.mass_b.inverse_inertia * turn_b);
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
inline void push_turned(const TurnedLanes& lanes, JointBodyLanes& bodies, F keep) {
  const V3 impulse = load3(lanes.impulse) * keep;
  bodies.a.linear = bodies.a.linear - impulse * bodies.mass_a.inverse_mass;
  bodies.b.linear = bodies.b.linear + impulse * bodies.mass_b.inverse_mass;
  bodies.a.angular = bodies.a.angular - bodies.mass_a.inverse_inertia * (load3(lanes.torque_a) * keep);
  bodies.b.angular = bodies.b.angular + bodies.mass_b.inverse_inertia * (load3(lanes.torque_b) * keep);
}

// Relative angular velocity by an impulse at the levers.
inline V3 turn_by_impulse(const JointBodyLanes& bodies, V3 lever_a, V3 lever_b, V3 impulse) {
  return bodies.mass_a.inverse_inertia * cross(lever_a, impulse) +
         bodies.mass_b.inverse_inertia * cross(lever_b, impulse);
}
// Relative velocity at the levers by a torque impulse.
inline V3 move_by_torque(const JointBodyLanes& bodies, V3 lever_a, V3 lever_b, V3 torque) {
  return cross(bodies.mass_a.inverse_inertia * torque, lever_a) +
         cross(bodies.mass_b.inverse_inertia * torque, lever_b);
}

// Relative velocity at the levers by a unit impulse there, while a torque keeps the bodies from turning
// against each other: as one body, that is. `turn_mass` is invert_semidefinite(turn_response(bodies)).
//
// With inverse inertias A and B the levers a and b act through A, B and (A + B)^-1; what is left of that is
// their difference, which is the way from center to center, acting through A (A + B)^-1 B.
inline S3 response_of_both(const JointBodyLanes& bodies, const S3& turn_mass, V3 center_offset) {
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
  const F inverse = unit * invert_positive(max(xx * yy - xy * xy, F(kLeastPivot) * (xx * yy)));
  return {inverse * yy, -(inverse * xy), inverse * xx};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
