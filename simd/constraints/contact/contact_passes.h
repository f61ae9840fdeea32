// The passes of the soft step over the blocks of a chunk, for contact_solve.cpp and contact_together.cpp;
// private to the contact kernels.
#pragma once

#include <simd/constraints/contact/contact_forces.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

inline float largest_lane(F values) {
  alignas(64) float lanes[kLanes];
  store(lanes, values);
  float largest = 0.0f;
  for (int lane = 0; lane < kLanes; ++lane) largest = lanes[lane] > largest ? lanes[lane] : largest;
  return largest;
}

// Gauss-Seidel over the points of a block until they are solved together. 16 sweeps leave less than 1e-4 of
// the speed in bodies from cubes to plates and sticks, see tests/simd/constraints/contact.
constexpr int kTogetherSweeps = 16;

template <int kPoints, class Block, class Target>
inline NormalImpulses sweep_points_together(const Block& block, F (&speed)[kPoints], F (&impulse)[kPoints],
                                            Target&& target) {
  F start[kPoints], response[kPoints], mass[kPoints];
  for (int k = 0; k < kPoints; ++k) {
    start[k] = impulse[k];
    mass[k] = load(block.effective_mass[k]);
    response[k] = invert_positive(mass[k]);
  }
  for (int sweep = 0; sweep < kTogetherSweeps; ++sweep) {
    for (int k = 0; k < kPoints; ++k) {
      const F old_impulse = impulse[k];
      impulse[k] = max(old_impulse - target(k, speed[k], old_impulse, mass[k]), F(0.0f));
      const F delta = impulse[k] - old_impulse;
      int pair = 0;
      for (int i = 0; i < kPoints; ++i) {
        for (int j = i + 1; j < kPoints; ++j, ++pair) {
          if (i == k) speed[j] = speed[j] + load(block.coupling[pair]) * delta;
          if (j == k) speed[i] = speed[i] + load(block.coupling[pair]) * delta;
        }
      }
      speed[k] = speed[k] + response[k] * delta;
    }
  }
  NormalImpulses total{F(0.0f), F(0.0f), F(0.0f)};
  for (int k = 0; k < kPoints; ++k) {
    const F delta = impulse[k] - start[k];
    total.sum = total.sum + delta;
    total.torque1 = total.torque1 + load(block.v[k]) * delta;
    total.torque2 = total.torque2 - load(block.u[k]) * delta;
  }
  return total;
}

template <int kPoints, bool kTogether, class Block, class Target>
inline NormalImpulses solve_points(Block& block, F (&speed)[kPoints], F (&impulse)[kPoints],
                                   Target&& target) {
  if constexpr (kTogether && kPoints > 1) {
    return sweep_points_together<kPoints>(block, speed, impulse, target);
  } else {
    return sweep_points<kPoints>(block, speed, impulse, target);
  }
}

// A free point that comes in fast enough to rebound is not braked while it is apart: rebound() has it, by the
// speed V with which it meets, V^2 = v^2 - 2 a s for the speed v at the separation s. `pull`: the
// acceleration a, along the normal and of gravity; `speed` is that without gravity in this substep.
template <class Block>
inline M is_left_to_rebound(const ContactArgs& args, const Block& block, F speed, F pull, F separation,
                            F impulse) {
  const F zero(0.0f), threshold(args.restitution_threshold);
  const F square = speed * speed - F(2.0f) * (pull * max(separation, zero));
  return (load(block.restitution) > zero) & (speed < zero) & (square > threshold * threshold) &
         !(impulse > zero);
}

// Of what falls freely onto a body that cannot be pushed, by all of gravity. That of other pairs, of joined
// and locked bodies and under other gravity factors is not known here: those within the threshold by it are
// braked.
template <bool kStatic>
inline F pull_of(const ContactArgs& args, V3 normal) {
  if constexpr (!kStatic) return F(0.0f);
  return dot(normal, V3{F(args.gravity[0]), F(args.gravity[1]), F(args.gravity[2])});
}

// Normals only, with soft bias. The separations are those of the last relax sweep: no pose has moved since.
template <int kPoints, bool kRich, bool kStatic, bool kTogether>
inline void solve_blocks(const ContactArgs& args, const ConstraintChunk& chunk) {
  using Block = typename BlockOf<kPoints, kRich>::Type;
  const SoftConstants& soft = kStatic ? args.soft_static : args.soft;
  const F bias_rate(soft.bias_rate), mass_scale(soft.mass_scale), impulse_scale(soft.impulse_scale);
  const F inverse_substep(args.inverse_substep), push_speed(args.push_speed), keep(args.impulse_keep);
  const F zero(0.0f), one(1.0f);
  HubSum hub(args.velocity, chunk);
  for_each_block<Block>(args, chunk, [&](Block& block, int count, int first_lane) {
    prefetch(&block + 1, 0, kRich ? sizeof(Block) : offsetof(ContactBlock<kPoints>, tangent_impulse));
    const V3 normal = load3(block.normal), tangent1 = tangent_of(normal);
    const V3 tangent2 = cross(normal, tangent1);
    const V3 arm_a = load3(block.arm_a), arm_b = load3(block.arm_b);
    Bodies bodies = load_bodies(args.velocity, block);
    F speed[kPoints], impulse[kPoints];
    point_speeds<kPoints>(block, relative_velocity(bodies, arm_a, arm_b), bodies.b.angular - bodies.a.angular,
                          normal, tangent1, tangent2, speed);
    for (int k = 0; k < kPoints; ++k) impulse[k] = load(block.impulse[k]) * keep;
    const NormalImpulses change = solve_points<kPoints, kTogether>(
        block, speed, impulse, [&](int k, F point_speed, F old_impulse, F effective_mass) {
          const F separation = load(block.separation[k]);
          const M apart = separation > zero;
          const F bias = select(apart, separation * inverse_substep,
                                mass_scale * max(bias_rate * separation, -push_speed));
          const F target = effective_mass * (select(apart, one, mass_scale) * point_speed + bias) +
                           select(apart, zero, impulse_scale) * old_impulse;
          if constexpr (kRich) {
            const F pull = pull_of<kStatic>(args, normal), before = point_speed - pull * F(args.substep);
            const M is_left = is_left_to_rebound(args, block, before, pull, separation, old_impulse);
            return select(apart & is_left, zero, target);
          }
          return target;
        });
    for (int k = 0; k < kPoints; ++k) store(block.impulse[k], impulse[k]);
    apply<kStatic>(bodies, block, arm_a, arm_b, normal * change.sum,
                   tangent1 * change.torque1 + tangent2 * change.torque2);
    store_bodies<kStatic>(args.velocity, block, count, first_lane, bodies, hub);
  });
}

struct ContactAxes {
  V3 normal, tangent1, tangent2, arm_a, arm_b;
};

// Acts the normal impulses' `change` out, and then what rubs. `sum` and `moment`: of the normal impulses, the
// latter times their radii. `relative`, `spin`: velocities before the change. `keep`: times the old rolling
// impulse.
template <bool kRich, bool kStatic, class Block>
inline void rub_block(Block& block, const ContactAxes& axes, const NormalImpulses& change,
                      const FrictionImpulses& old, F sum, F moment, V3 relative, V3 spin, F keep,
                      Bodies& bodies) {
  const auto& [normal, tangent1, tangent2, arm_a, arm_b] = axes;
  const FrictionImpulses friction =
      solve_friction<kRich>(block, change, old, sum, moment, relative, spin, normal, tangent1, tangent2);
  store(block.tangent_impulse[0], friction.tangent[0]);
  store(block.tangent_impulse[1], friction.tangent[1]);
  store(block.twist_impulse, friction.twist);
  const V3 friction_change =
      tangent1 * (friction.tangent[0] - old.tangent[0]) + tangent2 * (friction.tangent[1] - old.tangent[1]);
  apply<kStatic>(
      bodies, block, arm_a, arm_b, normal * change.sum + friction_change,
      tangent1 * change.torque1 + tangent2 * change.torque2 + normal * (friction.twist - old.twist));
  if constexpr (kRich) {
    const V3 old_rolling = load3(block.rolling_impulse) * keep;
    const V3 rolling = solve_rolling<kStatic>(block, bodies, old_rolling, sum);
    store3(block.rolling_impulse, rolling);
    apply_torque<kStatic>(bodies, block, rolling - old_rolling);
  }
}

// By how much more slowly B slips over A than by the levers of the step's beginning, because the contact has
// moved since: what rests or rolls on a turntable comes to places of other speeds within the step. A round
// body B carries the contact over A; another contact turns with both bodies. The way is that to the middle of
// the substep just done: the substep has moved B by velocities with the friction of the one before, and so
// the speed on a turntable stays the same to second order. (By the way to its end a ball slows down, by none
// it gains 5 % in two circles at 1/60 s, and a box at rest goes outward by 0.8 % a second at 1 rad/s.) Bodies
// A that are pushed keep their levers, as impulses on them do.
template <int kPoints, class Block>
inline V3 carried_over(const ContactArgs& args, const Block& block, const Bodies& bodies, const WideDelta& a,
                       const WideDelta& b, V3 normal, V3 arm_a, V3 arm_b) {
  const V3 turn_a = bodies.a.angular, turn_b = bodies.b.angular;
  const M turns = length_squared(turn_a) > F(0.0f);
  const V3 zero{F(0.0f), F(0.0f), F(0.0f)};
  if (bits(turns) == 0) return zero;
  const F half(0.5f * args.substep);
  TurningArms arms{arm_a, arm_b};
  if constexpr (kMayBeRound<kPoints>) {
    arms = turning_arms(normal, arm_a, arm_b, load(block.cores.core_a), load(block.cores.core_b));
  }
  V3 way_a = rotate(a.rotation, arms.a) - arms.a - half * cross(turn_a, arms.a);
  V3 way_b = rotate(b.rotation, arms.b) - arms.b - half * cross(turn_b, arms.b);
  if constexpr (kMayBeRound<kPoints>) {
    // Round is only B: between two round shapes the contact stays with the sharper one.
    constexpr float kFlat = 0.1f;
    const M follows_b = abs(load(block.cores.core_a)) < F(kFlat) * load(block.cores.core_b);
    const V3 over = b.position - a.position - half * (bodies.b.linear - bodies.a.linear) + way_b;
    way_a = select(follows_b, over, way_a);
  }
  return select(turns, cross(turn_a, way_a) - cross(turn_b, way_b), zero);
}

template <int kPoints, bool kRich, bool kStatic, bool kMeasured, bool kTogether>
inline void relax_blocks(const ContactArgs& args, const ConstraintChunk& chunk) {
  using Block = typename BlockOf<kPoints, kRich>::Type;
  // Without warm start the friction of the last substep is history, as the normal impulses are in solve.
  const F inverse_substep(args.inverse_substep), keep(args.impulse_keep), zero(0.0f);
  F worst(0.0f);
  HubSum hub(args.velocity, chunk);
  for_each_block<Block>(args, chunk, [&](Block& block, int count, int first_lane) {
    prefetch(&block + 1, 0, sizeof(Block));
    const V3 normal = load3(block.normal), tangent1 = tangent_of(normal);
    const V3 tangent2 = cross(normal, tangent1);
    const V3 arm_a = load3(block.arm_a), arm_b = load3(block.arm_b);
    F separation[kPoints];
    const WideDelta delta_a = load_delta(args.delta, block.row_a),
                    delta_b = load_delta(args.delta, block.row_b);
    present_separations<kPoints>(block, delta_a, delta_b, normal, tangent1, tangent2, arm_a, arm_b,
                                 separation);
    for (int k = 0; k < kPoints; ++k) store(block.separation[k], separation[k]);
    Bodies bodies = load_bodies(args.velocity, block);
    V3 relative = relative_velocity(bodies, arm_a, arm_b);
    const V3 spin = bodies.b.angular - bodies.a.angular;
    F speed[kPoints], impulse[kPoints];
    point_speeds<kPoints>(block, relative, spin, normal, tangent1, tangent2, speed);
    if constexpr (kStatic) {
      relative =
          relative - carried_over<kPoints>(args, block, bodies, delta_a, delta_b, normal, arm_a, arm_b);
    }
    for (int k = 0; k < kPoints; ++k) impulse[k] = load(block.impulse[k]);
    const NormalImpulses change = solve_points<kPoints, kTogether>(
        block, speed, impulse, [&](int k, F point_speed, F old_impulse, F effective_mass) {
          F error = point_speed + max(separation[k], zero) * inverse_substep;
          if constexpr (kRich) {
            // Nor where it has touched just now: the next substep begins with rebounds.
            // What is fast enough already is left even where gravity slows it, which may not act on it.
            const F pull = min(pull_of<kStatic>(args, normal), zero);
            error = select(is_left_to_rebound(args, block, point_speed, pull, separation[k], old_impulse),
                           zero, error);
          }
          if constexpr (kMeasured) {
            // A pressed point should not move, a free one not approach.
            const F violation = select(old_impulse > zero, abs(error), max(-error, zero));
            worst = max(select(effective_mass > zero, violation, zero), worst);
          }
          return effective_mass * error;
        });
    F sum(0.0f), moment(0.0f);
    for (int k = 0; k < kPoints; ++k) {
      store(block.impulse[k], impulse[k]);
      sum = sum + impulse[k];
      moment = moment + load(block.radius[k]) * impulse[k];
    }
    add_impulse_sum(args, first_lane, sum);
    const FrictionImpulses old{{load(block.tangent_impulse[0]) * keep, load(block.tangent_impulse[1]) * keep},
                               load(block.twist_impulse) * keep};
    rub_block<kRich, kStatic>(block, {normal, tangent1, tangent2, arm_a, arm_b}, change, old, sum, moment,
                              relative, spin, keep, bodies);
    if (args.force_sum != nullptr) add_forces<kPoints, kRich>(args, first_lane, block);
    store_bodies<kStatic>(args.velocity, block, count, first_lane, bodies, hub);
  });
  if constexpr (kMeasured) {
    args.residual[chunk.number] = largest_lane(worst);
  }
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
