// What sweeps over contact blocks have in common; private to the contact kernels. With C the friction center,
// impulses on a manifold add up to
//   S along the normal, T1 and T2 as torques about t1 and t2   (from the points: S += d, T1 += v d, T2 -= u
//   d) two tangent impulses at C and a twist impulse about the normal,
// and act on the bodies once, at the end.
#pragma once

#include <simd/constraints/contact/contact_block.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// Both bodies of a block, as one sweep reads and writes them.
struct Bodies {
  BodyVelocity a, b;
};

template <class Block>
inline Bodies load_bodies(const VelocityRow* velocity, const Block& block) {
  return {load_velocity(velocity, block.row_a), load_velocity(velocity, block.row_b)};
}

template <bool kStatic, class Block>
inline void store_bodies(VelocityRow* velocity, const Block& block, int count, int first_lane,
                         const Bodies& bodies, HubSum& hub) {
  if constexpr (!kStatic) {
    if (hub.side() == BodySide::a) {
      hub.add(block.row_a, count, first_lane, bodies.a);
    } else {
      store_velocity(velocity, block.row_a, count, bodies.a);
    }
  }
  if (hub.side() == BodySide::b) {
    hub.add(block.row_b, count, first_lane, bodies.b);
  } else {
    store_velocity(velocity, block.row_b, count, bodies.b);
  }
}

// Applies impulse P at the friction center and torque impulse T to B, their opposites to A.
template <bool kStatic, class Block>
inline void apply(Bodies& bodies, const Block& block, V3 arm_a, V3 arm_b, V3 impulse, V3 torque) {
  if constexpr (!kStatic) {
    bodies.a.linear = bodies.a.linear - impulse * load(block.inverse_mass_a);
    bodies.a.angular = bodies.a.angular - load6(block.inverse_inertia_a) * (cross(arm_a, impulse) + torque);
  }
  bodies.b.linear = bodies.b.linear + impulse * load(block.inverse_mass_b);
  bodies.b.angular = bodies.b.angular + load6(block.inverse_inertia_b) * (cross(arm_b, impulse) + torque);
}

// What a sweep over the points has added.
struct NormalImpulses {
  F sum;  // of the changes
  F torque1, torque2;
};

// Gauss-Seidel over the points on speeds kept up to date through the couplings. `target` gives for point k
// the speed to reach as a bias, and the scales of speed and impulse.
template <int kPoints, class Block, class Target>
inline NormalImpulses sweep_points(Block& block, F (&speed)[kPoints], F (&impulse)[kPoints],
                                   Target&& target) {
  NormalImpulses total{F(0.0f), F(0.0f), F(0.0f)};
  int pair = 0;
  for (int k = 0; k < kPoints; ++k) {
    const F old_impulse = impulse[k];
    const F change = target(k, speed[k], old_impulse, load(block.effective_mass[k]));
    impulse[k] = max(old_impulse - change, F(0.0f));
    const F delta = impulse[k] - old_impulse;
    for (int j = k + 1; j < kPoints; ++j) speed[j] = speed[j] + load(block.coupling[pair++]) * delta;
    total.sum = total.sum + delta;
    total.torque1 = total.torque1 + load(block.v[k]) * delta;
    total.torque2 = total.torque2 - load(block.u[k]) * delta;
  }
  return total;
}

template <int kPoints, class Block>
inline void point_speeds(const Block& block, V3 relative, V3 spin, V3 normal, V3 tangent1, V3 tangent2,
                         F (&speed)[kPoints]) {
  const F center_speed = dot(relative, normal);
  const F spin1 = dot(spin, tangent1), spin2 = dot(spin, tangent2);
  for (int k = 0; k < kPoints; ++k) {
    speed[k] = center_speed + load(block.v[k]) * spin1 - load(block.u[k]) * spin2;
  }
}

inline V3 relative_velocity(const Bodies& bodies, V3 arm_a, V3 arm_b) {
  return bodies.b.linear + cross(bodies.b.angular, arm_b) - bodies.a.linear - cross(bodies.a.angular, arm_a);
}

// The arms at which a contact's bodies turn: to the cores of round shapes, whose surface does not turn with
// them. With the arm of its contact point a rolling ball would leave the ground by r (1 - cos a) within a
// step in which it turns by the angle a, and be let down by as much.
struct TurningArms {
  V3 a, b;
};
inline TurningArms turning_arms(V3 normal, V3 arm_a, V3 arm_b, F core_a, F core_b) {
  return {arm_a - normal * core_a, arm_b + normal * core_b};
}

// By how much separations have changed since the step began, to first order in the rotation since then: at
// the friction center, and by distance from it along the tangents. From the normal as each body would see it.
struct SeparationChange {
  F center, tilt1, tilt2;
};
inline SeparationChange separation_change(const WideDelta& a, const WideDelta& b, V3 normal, V3 tangent1,
                                          V3 tangent2, const TurningArms& arms) {
  const V3 change_a = rotate_back(a.rotation, normal) - normal;
  const V3 change_b = rotate_back(b.rotation, normal) - normal;
  const F center = dot(normal, b.position - a.position) + dot(arms.b, change_b) - dot(arms.a, change_a);
  const V3 tilt = change_b - change_a;
  return {center, dot(tangent1, tilt), dot(tangent2, tilt)};
}

// Separations at the present poses.
template <int kPoints, class Block>
inline void present_separations(const Block& block, const WideDelta& a, const WideDelta& b, V3 normal,
                                V3 tangent1, V3 tangent2, V3 arm_a, V3 arm_b, F (&separation)[kPoints]) {
  TurningArms arms{arm_a, arm_b};
  if constexpr (kMayBeRound<kPoints>) {
    arms = turning_arms(normal, arm_a, arm_b, load(block.cores.core_a), load(block.cores.core_b));
  }
  const SeparationChange change = separation_change(a, b, normal, tangent1, tangent2, arms);
  for (int k = 0; k < kPoints; ++k) {
    separation[k] = load(block.initial_separation[k]) + change.center + load(block.u[k]) * change.tilt1 +
                    load(block.v[k]) * change.tilt2;
  }
}

// What friction holds at the center: along the tangents, and about the normal.
struct FrictionImpulses {
  F tangent[2], twist;
};

struct S2 {
  F xx, xy, yy;
};

// Impulses of friction, where those that would stop the slip w leave the disk: the contact slides. Coulomb's
// law puts them on the edge, against the slip. So the old impulses go against w, by the least eigenvalue of
// M, the inverse of the response: that stops w along no axis too far, and comes to rest only where impulse
// and slip oppose each other. (Scaling p - M w down to the disk comes to rest where M w opposes p: a bar of
// 2 m x 20 cm that slid at 45 degrees turned to 68 within 0.7 s. Solving for the exact impulse on the edge,
// by two steps of Newton's method, makes the same path and costs large_pyramid 8 %.)
inline void slide(const S2& mass, F limit, const F (&old)[2], const F (&slip)[2], F (&impulse)[2]) {
  const M slides = sqrt(impulse[0] * impulse[0] + impulse[1] * impulse[1]) > limit;
  if (bits(slides) == 0) return;
  // In units of the mean, so that squares of tiny masses are not denormal.
  constexpr float kMostUnits = 1e38f;  // 1/kg
  const F half(0.5f), one(1.0f), mean = (mass.xx + mass.yy) * half,
                                 unit = min(invert_positive(mean), F(kMostUnits));
  const F away = (mass.xx - mass.yy) * half * unit, across = mass.xy * unit;
  const F least = mean * max(one - sqrt(away * away + across * across), F(0.0f));
  const F x = old[0] - least * slip[0], y = old[1] - least * slip[1];
  const F size = sqrt(x * x + y * y);
  const F scale = select(size > limit, limit / size, one);
  impulse[0] = select(slides, x * scale, impulse[0]);
  impulse[1] = select(slides, y * scale, impulse[1]);
}

// Twist about the normal, then the pair of tangent speeds in the friction disk. The speeds are those before
// the normal impulses `change`. Returns the new impulses.
template <bool kRich, class Block>
inline FrictionImpulses solve_friction(const Block& block, const NormalImpulses& change,
                                       const FrictionImpulses& old, F impulse_sum, F impulse_moment,
                                       V3 relative, V3 spin, V3 normal, V3 tangent1, V3 tangent2) {
  FrictionImpulses result;
  const F friction = load(block.friction);
  const F twist_speed = dot(spin, normal) + load(block.twist_by_normal) * change.sum +
                        load(block.twist_by_torque[0]) * change.torque1 +
                        load(block.twist_by_torque[1]) * change.torque2;
  const F twist_limit = friction * impulse_moment;
  result.twist = clamp(old.twist - load(block.twist_mass) * twist_speed, -twist_limit, twist_limit);
  const F twist_change = result.twist - old.twist;

  F slip[2] = {dot(relative, tangent1), dot(relative, tangent2)};
  for (int i = 0; i < 2; ++i) {
    slip[i] = slip[i] + load(block.tangent_by_normal[i]) * change.sum +
              load(block.tangent_by_torque1[i]) * change.torque1 +
              load(block.tangent_by_torque2[i]) * change.torque2 +
              load(block.tangent_by_twist[i]) * twist_change;
    if constexpr (kRich) slip[i] = slip[i] + load(block.surface_speed[i]);
  }
  const F m11 = load(block.tangent_mass[0]), m12 = load(block.tangent_mass[1]),
          m22 = load(block.tangent_mass[2]);
  result.tangent[0] = old.tangent[0] - (m11 * slip[0] + m12 * slip[1]);
  result.tangent[1] = old.tangent[1] - (m12 * slip[0] + m22 * slip[1]);
  slide({m11, m12, m22}, friction * impulse_sum, old.tangent, slip, result.tangent);
  return result;
}

// Rolling resistance: stops the relative spin with a torque of at most resistance times normal impulse.
// Returns the new impulse.
template <bool kStatic, class Block>
inline V3 solve_rolling(const Block& block, const Bodies& bodies, V3 old_impulse, F impulse_sum) {
  const V3 spin = bodies.b.angular - bodies.a.angular;
  const V3 free = old_impulse - load6(block.rolling_mass) * spin;
  F response =
      load(block.inverse_inertia_b[0]) + load(block.inverse_inertia_b[3]) + load(block.inverse_inertia_b[5]);
  if constexpr (!kStatic) {
    response = response + (load(block.inverse_inertia_a[0]) + load(block.inverse_inertia_a[3]) +
                           load(block.inverse_inertia_a[5]));
  }
  return bound_length(free, old_impulse, spin, response, load(block.rolling_resistance) * impulse_sum);
}

template <bool kStatic, class Block>
inline void apply_torque(Bodies& bodies, const Block& block, V3 torque) {
  if constexpr (!kStatic) bodies.a.angular = bodies.a.angular - load6(block.inverse_inertia_a) * torque;
  bodies.b.angular = bodies.b.angular + load6(block.inverse_inertia_b) * torque;
}

// Normal impulses of all substeps and points, where they are asked for.
inline void add_impulse_sum(const ContactArgs& args, int first_lane, F sum) {
  if (args.impulse_sum == nullptr) return;
  float* const lanes = args.impulse_sum + first_lane;
  store_unaligned(lanes, load_unaligned(lanes) + sum);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
