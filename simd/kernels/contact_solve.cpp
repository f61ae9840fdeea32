// Sweeps over contact blocks; see simd/contact_kernels.h. In the sweeps, with C the friction center, impulses
// on a manifold add up to
//   S along the normal, T1 and T2 as torques about t1 and t2   (from the points: S += d, T1 += v d, T2 -= u
//   d) two tangent impulses at C and a twist impulse about the normal,
// and act on the bodies once, at the end.
#include <simd/contact_forces.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// Both bodies of a block, as one sweep reads and writes them.
struct Bodies {
  BodyVelocity a, b;
};

template <class Block>
inline Bodies load_bodies(const ContactArgs& args, const Block& block) {
  return {load_velocity(args.velocity, block.row_a), load_velocity(args.velocity, block.row_b)};
}

template <bool kStatic, class Block>
inline void store_bodies(const ContactArgs& args, const Block& block, int count, int first_lane,
                         const Bodies& bodies, HubSum& hub) {
  if constexpr (!kStatic) {
    if (hub.side() == BodySide::a) {
      hub.add(block.row_a, count, first_lane, bodies.a);
    } else {
      store_velocity(args.velocity, block.row_a, count, bodies.a);
    }
  }
  if (hub.side() == BodySide::b) {
    hub.add(block.row_b, count, first_lane, bodies.b);
  } else {
    store_velocity(args.velocity, block.row_b, count, bodies.b);
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

template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void warm_start_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  using Block = typename BlockOf<kPoints, kRich>::Type;
  HubSum hub(args.velocity, chunk);
  for_each_block<Block>(args, chunk, [&](Block& block, int count, int first_lane) {
    prefetch(&block + 1, 0, sizeof(Block));
    const V3 normal = load3(block.normal), tangent1 = tangent_of(normal);
    const V3 tangent2 = cross(normal, tangent1);
    F sum(0.0f), torque1(0.0f), torque2(0.0f);
    for (int k = 0; k < kPoints; ++k) {
      const F impulse = load(block.impulse[k]);
      sum = sum + impulse;
      torque1 = torque1 + load(block.v[k]) * impulse;
      torque2 = torque2 - load(block.u[k]) * impulse;
    }
    const V3 impulse =
        normal * sum + tangent1 * load(block.tangent_impulse[0]) + tangent2 * load(block.tangent_impulse[1]);
    V3 torque = normal * load(block.twist_impulse) + tangent1 * torque1 + tangent2 * torque2;
    if constexpr (kRich) torque = torque + load3(block.rolling_impulse);
    Bodies bodies = load_bodies(args, block);
    apply<kStatic>(bodies, block, load3(block.arm_a), load3(block.arm_b), impulse, torque);
    store_bodies<kStatic>(args, block, count, first_lane, bodies, hub);
  });
}

// Normals only, with soft bias. The separations are those of the last relax sweep: no pose has moved since.
template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void solve_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
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
    Bodies bodies = load_bodies(args, block);
    F speed[kPoints], impulse[kPoints];
    point_speeds<kPoints>(block, relative_velocity(bodies, arm_a, arm_b), bodies.b.angular - bodies.a.angular,
                          normal, tangent1, tangent2, speed);
    for (int k = 0; k < kPoints; ++k) impulse[k] = load(block.impulse[k]) * keep;
    if constexpr (kRich) {
      // A free point comes in as fast as it is now: gravity has worked since the step began.
      for (int k = 0; k < kPoints; ++k) {
        const F approach = load(block.approach_speed[k]);
        store(block.approach_speed[k], select(impulse[k] > zero, approach, min(speed[k], approach)));
      }
    }
    const NormalImpulses change = sweep_points<kPoints>(
        block, speed, impulse, [&](int k, F point_speed, F old_impulse, F effective_mass) {
          const F separation = load(block.separation[k]);
          const M apart = separation > zero;
          const F bias = select(apart, separation * inverse_substep,
                                mass_scale * max(bias_rate * separation, -push_speed));
          return effective_mass * (select(apart, one, mass_scale) * point_speed + bias) +
                 select(apart, zero, impulse_scale) * old_impulse;
        });
    for (int k = 0; k < kPoints; ++k) {
      store(block.impulse[k], impulse[k]);
      if constexpr (kRich) store(block.pressed[k], max(load(block.pressed[k]), impulse[k]));
    }
    apply<kStatic>(bodies, block, arm_a, arm_b, normal * change.sum,
                   tangent1 * change.torque1 + tangent2 * change.torque2);
    store_bodies<kStatic>(args, block, count, first_lane, bodies, hub);
  });
}

// Separations at the present poses: to first order in the rotation since the step began, from the normal as
// each body would see it.
template <int kPoints, class Block>
inline void update_separations(const ContactArgs& args, Block& block, V3 normal, V3 tangent1, V3 tangent2,
                               V3 arm_a, V3 arm_b, F (&separation)[kPoints]) {
  const WideDelta a = load_delta(args.delta, block.row_a), b = load_delta(args.delta, block.row_b);
  const V3 change_a = rotate_back(a.rotation, normal) - normal;
  const V3 change_b = rotate_back(b.rotation, normal) - normal;
  const F center = dot(normal, b.position - a.position) + dot(arm_b, change_b) - dot(arm_a, change_a);
  const V3 tilt = change_b - change_a;
  const F tilt1 = dot(tangent1, tilt), tilt2 = dot(tangent2, tilt);
  for (int k = 0; k < kPoints; ++k) {
    separation[k] =
        load(block.initial_separation[k]) + center + load(block.u[k]) * tilt1 + load(block.v[k]) * tilt2;
    store(block.separation[k], separation[k]);
  }
}

// Twist about the normal, then the pair of tangent speeds in the friction disk. Returns the change as an
// impulse at the center and a torque impulse.
struct FrictionChange {
  V3 impulse, torque;
};

template <bool kRich, class Block>
inline FrictionChange solve_friction(Block& block, const NormalImpulses& change, F keep, F impulse_sum,
                                     F impulse_moment, V3 relative, V3 spin, V3 normal, V3 tangent1,
                                     V3 tangent2) {
  const F friction = load(block.friction);
  const F twist_speed = dot(spin, normal) + load(block.twist_by_normal) * change.sum +
                        load(block.twist_by_torque[0]) * change.torque1 +
                        load(block.twist_by_torque[1]) * change.torque2;
  const F twist_limit = friction * impulse_moment;
  const F old_twist = load(block.twist_impulse) * keep;
  const F twist = clamp(old_twist - load(block.twist_mass) * twist_speed, -twist_limit, twist_limit);
  const F twist_change = twist - old_twist;
  store(block.twist_impulse, twist);

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
  const F old1 = load(block.tangent_impulse[0]) * keep, old2 = load(block.tangent_impulse[1]) * keep;
  const F free1 = old1 - (m11 * slip[0] + m12 * slip[1]);
  const F free2 = old2 - (m12 * slip[0] + m22 * slip[1]);
  const F limit = friction * impulse_sum;
  const F size = sqrt(free1 * free1 + free2 * free2);
  const F scale = select(size > limit, limit / size, F(1.0f));
  const F new1 = free1 * scale, new2 = free2 * scale;
  store(block.tangent_impulse[0], new1);
  store(block.tangent_impulse[1], new2);
  return {tangent1 * (new1 - old1) + tangent2 * (new2 - old2), normal * twist_change};
}

// Rolling resistance: stops the relative spin with a torque of at most resistance times normal impulse.
template <bool kStatic, class Block>
inline void solve_rolling(Block& block, Bodies& bodies, F keep, F impulse_sum) {
  const V3 old_impulse = load3(block.rolling_impulse) * keep;
  const V3 free = old_impulse - load6(block.rolling_mass) * (bodies.b.angular - bodies.a.angular);
  const F limit = load(block.rolling_resistance) * impulse_sum;
  const F size = length(free);
  const V3 impulse = free * select(size > limit, limit / size, F(1.0f));
  store3(block.rolling_impulse, impulse);
  const V3 change = impulse - old_impulse;
  if constexpr (!kStatic) bodies.a.angular = bodies.a.angular - load6(block.inverse_inertia_a) * change;
  bodies.b.angular = bodies.b.angular + load6(block.inverse_inertia_b) * change;
}

// What acted in a substep is what its relax sweep ends with.
inline void add_impulse_sum(const ContactArgs& args, int first_lane, F sum) {
  float* const lanes = args.impulse_sum + first_lane;
  store_unaligned(lanes, args.first_substep ? sum : load_unaligned(lanes) + sum);
}

template <int kPoints, bool kRich, bool kStatic, bool kMeasured>
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
    update_separations<kPoints>(args, block, normal, tangent1, tangent2, arm_a, arm_b, separation);
    Bodies bodies = load_bodies(args, block);
    const V3 relative = relative_velocity(bodies, arm_a, arm_b);
    const V3 spin = bodies.b.angular - bodies.a.angular;
    F speed[kPoints], impulse[kPoints];
    point_speeds<kPoints>(block, relative, spin, normal, tangent1, tangent2, speed);
    for (int k = 0; k < kPoints; ++k) impulse[k] = load(block.impulse[k]);
    const NormalImpulses change = sweep_points<kPoints>(
        block, speed, impulse, [&](int k, F point_speed, F old_impulse, F effective_mass) {
          const F error = point_speed + max(separation[k], zero) * inverse_substep;
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
    if (args.impulse_sum != nullptr) add_impulse_sum(args, first_lane, sum);
    const FrictionChange friction =
        solve_friction<kRich>(block, change, keep, sum, moment, relative, spin, normal, tangent1, tangent2);
    apply<kStatic>(bodies, block, arm_a, arm_b, normal * change.sum + friction.impulse,
                   tangent1 * change.torque1 + tangent2 * change.torque2 + friction.torque);
    if constexpr (kRich) solve_rolling<kStatic>(block, bodies, keep, sum);
    if (args.force_sum != nullptr) add_forces<kPoints, kRich>(args, first_lane, block);
    store_bodies<kStatic>(args, block, count, first_lane, bodies, hub);
  });
  if constexpr (kMeasured) {
    alignas(64) float lanes[kLanes];
    store(lanes, worst);
    float largest = 0.0f;
    for (int lane = 0; lane < kLanes; ++lane) largest = lanes[lane] > largest ? lanes[lane] : largest;
    args.residual[chunk.number] = largest;
  }
}

template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void relax_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  relax_blocks<kPoints, kRich, kStatic, false>(args, chunk);
}

template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void relax_measured_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  relax_blocks<kPoints, kRich, kStatic, true>(args, chunk);
}

// Sweeps over the points of a manifold: after one, a box that lands flat rebounds with half its speed.
constexpr int kRestitutionSweeps = 8;

// Rebound of the points that came in fast and were pressed during the step. The impulses are not stored: the
// next step shall not begin with a kick.
template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void restitution_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  if constexpr (kRich) {
    using Block = RichBlock<kPoints>;
    const F threshold(-args.restitution_threshold), zero(0.0f);
    HubSum hub(args.velocity, chunk);
    for_each_block<Block>(args, chunk, [&](Block& block, int count, int first_lane) {
      prefetch(&block + 1, 0, sizeof(Block));
      const V3 normal = load3(block.normal), tangent1 = tangent_of(normal);
      const V3 tangent2 = cross(normal, tangent1);
      const V3 arm_a = load3(block.arm_a), arm_b = load3(block.arm_b);
      Bodies bodies = load_bodies(args, block);
      F impulse[kPoints];
      M rebounds[kPoints];
      for (int k = 0; k < kPoints; ++k) {
        impulse[k] = load(block.impulse[k]);
        // The last relax sweep may have been the first to press: it brakes what would meet in the next
        // substep.
        const F pressed = max(load(block.pressed[k]), impulse[k]);
        rebounds[k] = (load(block.approach_speed[k]) < threshold) & (pressed > zero);
      }
      const F restitution = load(block.restitution);
      F added(0.0f);
      for (int sweep = 0; sweep < (kPoints == 1 ? 1 : kRestitutionSweeps); ++sweep) {
        F speed[kPoints];
        point_speeds<kPoints>(block, relative_velocity(bodies, arm_a, arm_b),
                              bodies.b.angular - bodies.a.angular, normal, tangent1, tangent2, speed);
        const NormalImpulses change =
            sweep_points<kPoints>(block, speed, impulse, [&](int k, F point_speed, F, F effective_mass) {
              const F error = point_speed + restitution * load(block.approach_speed[k]);
              return select(rebounds[k], effective_mass * error, zero);
            });
        added = added + change.sum;
        apply<kStatic>(bodies, block, arm_a, arm_b, normal * change.sum,
                       tangent1 * change.torque1 + tangent2 * change.torque2);
      }
      if (args.impulse_sum != nullptr) add_impulse_sum(args, first_lane, added);
      if (args.force_sum != nullptr) add_rebound_forces<kPoints>(args, first_lane, block, impulse);
      store_bodies<kStatic>(args, block, count, first_lane, bodies, hub);
    });
  }
}

void warm_start(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(warm_start_chunk, args, chunk)
}
void solve(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(solve_chunk, args, chunk)
}
void relax(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(relax_chunk, args, chunk)
}
void relax_measured(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(relax_measured_chunk, args, chunk)
}
void restitution(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(restitution_chunk, args, chunk)
}

}  // namespace

void add_contact_solve_kernels(ContactKernels& kernels) {
  kernels.warm_start = warm_start;
  kernels.solve = solve;
  kernels.relax = relax;
  kernels.relax_measured = relax_measured;
  kernels.restitution = restitution;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
