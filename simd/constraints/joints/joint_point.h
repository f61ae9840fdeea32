// Three held rows: two anchors that are one point. What ball joints, hinges and welds have in common.
// Private to the joint kernels.
#pragma once

#include <simd/constraints/joints/joint_frames.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

struct PointLanes {
  AnchorLanes first;
  LaneFloats arm_a[3], arm_b[3];  // now
  LaneFloats error[3];            // from anchor a to anchor b
  LaneFloats inverse_response[6];
  LaneFloats impulse[3];
  LaneFloats turned_a[3],
      turned_b[3];             // torque impulses by which the arms' turning changes those of `impulse`
  LaneSoftness held, relaxed;  // in solve, in relax
};

inline void place_point(const Anchors& now, const JointBodyLanes& bodies, PointLanes& point) {
  store3(point.arm_a, now.arm_a);
  store3(point.arm_b, now.arm_b);
  store3(point.error, now.offset);
  store6(point.inverse_response, invert(anchor_response(bodies, now.arm_a, now.arm_b)));
}

inline void prepare_point(const JointArgs& args, const std::int32_t* joint, const JointBodyLanes& bodies,
                          const JointPlacement& at, V3 impulse, PointLanes& point) {
  const V3 none{F(0.0f), F(0.0f), F(0.0f)};
  place_point(store_anchors(at, point.first), bodies, point);
  store3(point.impulse, impulse * F(args.warm_start_scale));
  store3(point.turned_a, none);
  store3(point.turned_b, none);
  const WideStiffness given = load_stiffness(args, joint);
  const Softness held = soften_held(args, bodies, given.hertz, given.damping_ratio);
  store_softness(point.held, held);
  store_softness(point.relaxed, relax_held(held, given.hertz));
}

inline void warm_start_point(const PointLanes& point, JointBodyLanes& bodies) {
  push(bodies, load3(point.arm_a), load3(point.arm_b), load3(point.impulse));
}

// First in a solve: inherited impulses act along the arms as they are now.
inline void turn_point(const PointLanes& point, JointBodyLanes& bodies, F keep) {
  bodies.a.angular = bodies.a.angular - bodies.mass_a.inverse_inertia * (load3(point.turned_a) * keep);
  bodies.b.angular = bodies.b.angular + bodies.mass_b.inverse_inertia * (load3(point.turned_b) * keep);
}

inline void solve_point(PointLanes& point, JointBodyLanes& bodies, const Softness& soft, F keep) {
  const V3 arm_a = load3(point.arm_a), arm_b = load3(point.arm_b);
  const V3 old_impulse = load3(point.impulse) * keep;
  const V3 speed = anchor_velocity(bodies, arm_a, arm_b) + load3(point.error) * soft.bias_rate;
  const V3 change =
      load6(point.inverse_response) * (speed * soft.mass_scale) + old_impulse * soft.impulse_scale;
  store3(point.impulse, old_impulse - change);
  push(bodies, arm_a, arm_b, -change);
}

// First in a relax: arms and errors at the present poses.
inline void move_point(PointLanes& point, const WideDelta& delta_a, const WideDelta& delta_b,
                       const JointBodyLanes& bodies) {
  const Anchors now = move_anchors(point.first, delta_a, delta_b);
  const V3 impulse = load3(point.impulse);
  store3(point.turned_a, cross(now.arm_a - load3(point.arm_a), impulse));
  store3(point.turned_b, cross(now.arm_b - load3(point.arm_b), impulse));
  place_point(now, bodies, point);
}

// Returns the speed that was left.
inline F relax_point(PointLanes& point, JointBodyLanes& bodies) {
  const V3 arm_a = load3(point.arm_a), arm_b = load3(point.arm_b), impulse = load3(point.impulse);
  const Softness soft = load_softness(point.relaxed);
  const V3 speed = anchor_velocity(bodies, arm_a, arm_b);
  const V3 change =
      load6(point.inverse_response) * ((speed + load3(point.error) * soft.bias_rate) * soft.mass_scale) +
      impulse * soft.impulse_scale;
  store3(point.impulse, impulse - change);
  push(bodies, arm_a, arm_b, -change);
  return length(speed);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
