// Impacts of contacts with restitution, before a substep moves its bodies; run by
// parallel/solvers/rebound.cpp.
//
// The points of a manifold that come in and meet within the substep, the fastest of them above the threshold,
// leave with e times the speed at which they come (Newton's law), with friction by Coulomb's law under the
// impulses of the impact. Each body has its earliest impacts first: find_impacts() notes when contacts meet,
// and those act that no other of their bodies' contacts precedes. Contacts that act at one moment share their
// bodies' impulses: sweeps go on until all of them leave as they should. So for the impulses P >= 0, with the
// normal speeds u before and v after them,
//   v >= -e u,   P (v + e u) = 0     for all contacts that act, each with u < 0
// and the energy changes by P (u + v) / 2 = -P (1 - e) |u| / 2: it never grows, and with e = 1 it stays. The
// result does not depend on the order of the contacts, and keeps the symmetry of the scene. What then comes
// in acts in the next pass. (For one e these are the generalized reflections of Smith, Kaufman, Vouga,
// Tamstorf and Grinspun, "Reflections on Simultaneous Impact", SIGGRAPH 2012.)
//
// A body goes on its old way until its impact. What rebounds has no impulse for the rest of the step to
// inherit: a kick is no guess for the next substep.
#include <simd/constraints/contact/contact_forces.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// Most sweeps over the points of a manifold in a sweep over the contacts, of a manifold that acts alone, and
// of one among others. After 32, thin plates that landed nearly flat gained 2 % of their energy.
constexpr int kSweepsAlone = 256;
constexpr int kSweepsAmongOthers = 8;

// Impacts of one body are simultaneous within this part of a substep.
constexpr float kSameMoment = 1.0f / 256.0f;

// What an impact sets in motion rebounds at lower speeds, too: below sqrt(1 - e^2) times the threshold it
// loses no more energy by staying than an impact at the threshold does by its rebound. At least this part.
constexpr float kLeastThreshold = 1.0f / 64.0f;

// Gravity speeds bodies up until their impact, by this many times itself at most before an impact above the
// threshold may be missed.
constexpr float kForeseenGravityFactor = 4.0f;

// Speeds are right within this part of that of the impact, and of the speeds of the bodies, whose sums round.
constexpr float kAccuracy = 4e-6f;
constexpr float kRounding = 5e-7f;

// What a body's motion is bound by, and what it falls with.
struct Freedom {
  I flags;
  M jointed;
  V3 gravity;  // m/s^2, as far as it moves the body
};

inline Freedom load_freedom(const ContactArgs& args, const std::int32_t* row, F inverse_mass) {
  F unused[2], gravity_factor, flags;
  load_rows(&args.motion->linear_damping, sizeof(MotionRow) / sizeof(float), row, unused[0], unused[1],
            gravity_factor, flags);
  const M moves = inverse_mass > F(0.0f);
  Freedom freedom{as_int(flags), moves & !((as_int(flags) & I(kMotionJointed)) == I(0)), {}};
  const F factor = select(moves, gravity_factor, F(0.0f));
  freedom.gravity = V3{F(args.gravity[0]), F(args.gravity[1]), F(args.gravity[2])} * factor;
  V3 none = freedom.gravity;
  apply_locks(freedom.flags, freedom.gravity, none);
  return freedom;
}

inline M is_same(const V3& a, const V3& b) { return (a.x == b.x) & (a.y == b.y) & (a.z == b.z); }

struct PairMotion {
  M jointed;
  M flies;       // both without impulses in this step so far: gravity alone changes their speeds
  M was_struck;  // either in this substep
  F pull;        // m/s^2, relative acceleration of gravity along the normal
};

template <bool kStatic, class Block>
inline PairMotion load_motion_of(const ContactArgs& args, const Block& block, const Bodies& now, V3 normal) {
  F inverse_mass_a(0.0f);  // blocks against bodies that cannot be pushed have none
  if constexpr (!kStatic) inverse_mass_a = load(block.inverse_mass_a);
  const F inverse_mass_b = load(block.inverse_mass_b), zero(0.0f);
  const Freedom a = load_freedom(args, block.row_a, inverse_mass_a),
                b = load_freedom(args, block.row_b, inverse_mass_b);
  PairMotion motion{a.jointed | b.jointed, {}, {}, {}};
  const Bodies before = load_bodies(args.velocity_before, block);
  const M moves_a = inverse_mass_a > zero, moves_b = inverse_mass_b > zero;
  const auto some_differ = [&](const Bodies& others, const Bodies& bodies) {
    return (moves_a & !is_same(others.a.linear, bodies.a.linear)) |
           (moves_b & !is_same(others.b.linear, bodies.b.linear));
  };
  motion.was_struck = some_differ(before, now);
  motion.flies = !motion.jointed;
  if (!args.first_substep) {
    motion.flies = motion.flies & !some_differ(before, load_bodies(args.free_velocity, block));
  }
  motion.pull = select(motion.jointed, zero, dot(normal, b.gravity - a.gravity));
  return motion;
}

// Hubs, and bodies that cannot be pushed, have impacts whenever their contacts do.
template <bool kStatic, class Block, class Visit>
inline void visit_bodies(const Block& block, int lane, BodySide hub, Visit&& visit) {
  if (hub != BodySide::b) visit(block.row_b[lane]);
  if (!kStatic && hub != BodySide::a) visit(block.row_a[lane]);
}

template <bool kStatic, class Block>
inline void note_times(const ContactArgs& args, const Block& block, int count, BodySide hub) {
  for (int lane = 0; lane < count; ++lane) {
    const float time = block.impact_time[lane];
    if (time >= kNoImpact) continue;
    visit_bodies<kStatic>(block, lane, hub, [&](std::int32_t row) {
      ImpactTimes& times = args.impact_times[row];
      const bool is_first = time < times.first;
      const float later = is_first ? times.first : time;
      times.second = later < times.second ? later : times.second;
      times.first = is_first ? time : times.first;
    });
  }
}

// Leaves those contacts that act in this pass, and marks those whose bodies have no other.
template <bool kStatic, class Block>
inline void choose_acting(const ContactArgs& args, Block& block, BodySide hub) {
  const float moment = kSameMoment * args.substep;
  for (int lane = 0; lane < kLanes; ++lane) {
    bool acts = block.impact_time[lane] < kNoImpact, alone = hub == BodySide::none;
    visit_bodies<kStatic>(block, lane, hub, [&](std::int32_t row) {
      const ImpactTimes& times = args.impact_times[row];
      acts = acts && block.impact_time[lane] <= times.first + moment;
      alone = alone && times.second > times.first + moment;
    });
    if (!acts) block.impact_time[lane] = kNoImpact;
    block.impact_alone[lane] = alone ? 1.0f : 0.0f;
  }
}

// The axes of a manifold.
struct Axes {
  V3 normal, tangent1, tangent2, arm_a, arm_b;
};
template <class Block>
inline Axes axes_of(const Block& block) {
  const V3 normal = load3(block.normal), tangent1 = tangent_of(normal);
  return {normal, tangent1, cross(normal, tangent1), load3(block.arm_a), load3(block.arm_b)};
}

template <int kPoints, class Block>
inline void find_speeds(const Block& block, const Axes& axes, const Bodies& bodies, F (&speed)[kPoints]) {
  point_speeds<kPoints>(block, relative_velocity(bodies, axes.arm_a, axes.arm_b),
                        bodies.b.angular - bodies.a.angular, axes.normal, axes.tangent1, axes.tangent2,
                        speed);
}

// The way of a point to its meeting within the substep: with the separation s, the speed V and the relative
// acceleration a along the normal, s + V t + a t^2 / 2. What does not fly moves at the speed of the substep's
// end. Returns whether the contact has an impact.
template <bool kStatic, int kPoints, class Block>
inline bool find_impact(const ContactArgs& args, Block& block, const Axes& axes) {
  const F zero(0.0f), half(0.5f), one(1.0f), two(2.0f), substep(args.substep),
      restitution = load(block.restitution), threshold(-args.restitution_threshold);
  const bool first_pass = args.velocity_before == args.velocity;
  const Bodies bodies = load_bodies(args.velocity, block);
  F speed[kPoints], separation[kPoints];
  find_speeds<kPoints>(block, axes, bodies, speed);
  F least = speed[0];
  for (int k = 1; k < kPoints; ++k) least = min(least, speed[k]);
  const F chain_threshold =
      first_pass ? threshold
                 : threshold * max(sqrt(max(one - restitution * restitution, zero)), F(kLeastThreshold));
  const F gravity = abs(F(args.gravity[0])) + abs(F(args.gravity[1])) + abs(F(args.gravity[2]));
  const F gain = F(kForeseenGravityFactor) * gravity * substep;  // of speed until an impact
  if (bits((restitution > zero) & (least - gain < chain_threshold)) == 0) return false;
  const PairMotion motion = load_motion_of<kStatic>(args, block, bodies, axes.normal);
  const F acceleration = select(motion.flies, motion.pull, zero);
  const F change = motion.pull * substep * select(motion.flies, half, one);
  // Not those of the last relax sweep: impacts of this substep may have moved the bodies.
  present_separations<kPoints>(block, load_delta(args.delta, block.row_a),
                               load_delta(args.delta, block.row_b), axes.normal, axes.tangent1, axes.tangent2,
                               axes.arm_a, axes.arm_b, separation);
  F fastest(0.0f), time = substep;
  M meets[kPoints];
  for (int k = 0; k < kPoints; ++k) {
    meets[k] = separation[k] + (speed[k] + change) * substep < zero;
    const M comes = meets[k] & (separation[k] > zero) & (speed[k] < zero);
    const F root = sqrt(max(speed[k] * speed[k] - two * (acceleration * separation[k]), zero));
    fastest = select(meets[k], min(select(comes, -root, speed[k]), fastest), fastest);
    const F meeting = select(comes, two * separation[k] / select(comes, root - speed[k], one), zero);
    time = select(meets[k], min(meeting, time), time);
  }
  const M happens = (restitution > zero) & (fastest < select(motion.was_struck, chain_threshold, threshold));
  if (bits(happens) == 0) return false;
  time = select(motion.jointed, zero, time);
  // Gravity until the impact is not in the velocities yet, and will be, for the whole substep. So it is taken
  // off again with the sign that it has after the impact.
  const F fall = acceleration * time;
  store(block.impact_time, select(happens, time, F(kNoImpact)));
  store(block.impact_speed, select(happens, -fastest, zero));
  for (int k = 0; k < kPoints; ++k) {
    // A point that overlaps but parts already takes no part: P (u + v) / 2 with u > 0 would be a gain.
    const F speed_there = speed[k] + fall;
    const M acts = happens & meets[k] & (speed_there <= zero);
    store(block.impact_bias[k], fall + restitution * min(speed_there, zero));
    store(block.impact_mass[k], select(acts, load(block.effective_mass[k]), zero));
    store(block.impact_impulse[k], zero);
  }
  for (int i = 0; i < 2; ++i) store(block.impact_tangent[i], zero);
  store(block.impact_twist, zero);
  for (int axis = 0; axis < 3; ++axis) store(block.impact_rolling[axis], zero);
  return true;
}

template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void find_impacts_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  if constexpr (kRich) {
    using Block = RichBlock<kPoints>;
    bool any = false;
    for_each_block<Block>(args, chunk, [&](Block& block, int count, int) {
      prefetch(&block + 1, 0, offsetof(ContactBlock<kPoints>, impulse));
      store(block.impact_time, F(kNoImpact));
      if (bits(load(block.restitution) > F(0.0f)) == 0) return;  // here for other terms alone
      if (!find_impact<kStatic, kPoints>(args, block, axes_of(block))) return;
      note_times<kStatic>(args, block, count, chunk.hub);
      any = true;
    });
    args.impacts[chunk.number] = any ? kImpactsFound : kNoImpacts;
  }
}

// m/s, by which speeds may be wrong.
template <class Block>
inline F tolerance_of(const Block& block, const Bodies& bodies, const Axes& axes) {
  const auto size = [](V3 v) { return abs(v.x) + abs(v.y) + abs(v.z); };
  const F sizes = size(bodies.a.linear) + size(bodies.b.linear) + size(bodies.a.angular) * size(axes.arm_a) +
                  size(bodies.b.angular) * size(axes.arm_b);
  return F(kAccuracy) * load(block.impact_speed) + F(kRounding) * sizes;
}

inline BodyVelocity select(M which, const BodyVelocity& yes, const BodyVelocity& no) {
  return {select(which, yes.linear, no.linear),
          select(which, yes.angular, no.angular),
          {no.padding[0], no.padding[1]}};
}
inline Bodies select(M which, const Bodies& yes, const Bodies& no) {
  return {select(which, yes.a, no.a), select(which, yes.b, no.b)};
}

// Sweeps over the contacts that act, and over those alone on their bodies once only. Notes whether there were
// any, and whether any impulse has changed that others depend on.
template <int kPoints, bool kRich, bool kStatic, bool kChooses, class Sweep>
inline void sweep_impacts(const ContactArgs& args, const ConstraintChunk& chunk, Sweep&& sweep) {
  if constexpr (kRich) {
    using Block = RichBlock<kPoints>;
    HubSum hub(args.velocity, chunk);
    bool any = false, changes = false;
    for_each_block<Block>(args, chunk, [&](Block& block, int count, int first_lane) {
      if (kChooses && args.first_sweep) choose_acting<kStatic>(args, block, hub.side());
      M acts = load(block.impact_time) < F(kNoImpact);
      any = any || bits(acts) != 0;
      if (!args.first_sweep) acts = acts & !(load(block.impact_alone) > F(0.0f));
      const bool some = bits(acts) != 0;
      // The parts of a hub are added up whatever happens to them.
      if (!some && hub.side() == BodySide::none) return;
      const Bodies before = load_bodies(args.velocity, block);
      Bodies bodies = before;
      if (some) {
        const M moves = sweep(block, axes_of(block), acts, bodies) & !(load(block.impact_alone) > F(0.0f));
        changes = changes || bits(moves) != 0;
      }
      store_bodies<kStatic>(args.velocity, block, count, first_lane, select(acts, bodies, before), hub);
    });
    args.impacts[chunk.number] = !any ? kNoImpacts : changes ? kImpactsChange : kImpactsStay;
  }
}

template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void push_impacts_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  sweep_impacts<kPoints, kRich, kStatic, true>(
      args, chunk, [&](auto& block, const Axes& axes, M acts, Bodies& bodies) {
        const F zero(0.0f), tolerance = tolerance_of(block, bodies, axes);
        M changed = F(0.0f) > zero;
        F speed[kPoints], impulse[kPoints];
        for (int k = 0; k < kPoints; ++k) impulse[k] = load(block.impact_impulse[k]);
        const Bodies before = bodies;
        NormalImpulses total{zero, zero, zero};
        const M alone = acts & (load(block.impact_alone) > zero);
        for (int sweep = 0; sweep < (kPoints == 1 ? 1 : kSweepsAlone); ++sweep) {
          const M sweeps = sweep < kSweepsAmongOthers ? acts : alone;
          M goes_on = F(0.0f) > zero;
          find_speeds<kPoints>(block, axes, bodies, speed);
          const NormalImpulses change =
              sweep_points<kPoints>(block, speed, impulse, [&](int k, F point_speed, F, F) {
                const F error = point_speed + load(block.impact_bias[k]);
                const M counts = sweeps & (abs(error) > tolerance);
                goes_on = goes_on | counts;
                return select(counts, load(block.impact_mass[k]) * error, zero);
              });
          total = {total.sum + change.sum, total.torque1 + change.torque1, total.torque2 + change.torque2};
          // All at once from the start: so many small changes would round the velocity as often.
          bodies = before;
          apply<kStatic>(bodies, block, axes.arm_a, axes.arm_b, axes.normal * total.sum,
                         axes.tangent1 * total.torque1 + axes.tangent2 * total.torque2);
          if (bits(goes_on) == 0) break;
        }
        for (int k = 0; k < kPoints; ++k) {
          changed = changed | !(impulse[k] == load(block.impact_impulse[k]));
          store(block.impact_impulse[k], impulse[k]);
        }
        return changed & acts;
      });
}

template <int kPoints, class Block>
inline void impulse_sums(const Block& block, F& sum, F& moment) {
  sum = moment = F(0.0f);
  for (int k = 0; k < kPoints; ++k) {
    const F impulse = load(block.impact_impulse[k]);
    sum = sum + impulse;
    moment = moment + load(block.radius[k]) * impulse;
  }
}

// Friction under the impulses of the impacts: it slows what slides, spins and rolls, and adds no energy. All
// contacts that act have it together, as they have their normal impulses.
template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void rub_impacts_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  sweep_impacts<kPoints, kRich, kStatic, false>(
      args, chunk, [&](auto& block, const Axes& axes, M acts, Bodies& bodies) {
        const F zero(0.0f), tolerance = tolerance_of(block, bodies, axes);
        F sum, moment;
        impulse_sums<kPoints>(block, sum, moment);
        const FrictionImpulses old{{load(block.impact_tangent[0]), load(block.impact_tangent[1])},
                                   load(block.impact_twist)};
        const FrictionImpulses friction = solve_friction<true>(
            block, {zero, zero, zero}, old, sum, moment, relative_velocity(bodies, axes.arm_a, axes.arm_b),
            bodies.b.angular - bodies.a.angular, axes.normal, axes.tangent1, axes.tangent2);
        const F change1 = friction.tangent[0] - old.tangent[0],
                change2 = friction.tangent[1] - old.tangent[1];
        const F twist = friction.twist - old.twist;
        const Bodies before = bodies;
        apply<kStatic>(bodies, block, axes.arm_a, axes.arm_b,
                       axes.tangent1 * change1 + axes.tangent2 * change2, axes.normal * twist);
        const V3 old_rolling = load3(block.impact_rolling);
        const V3 rolling = solve_rolling<kStatic>(block, bodies, old_rolling, sum);
        apply_torque<kStatic>(bodies, block, rolling - old_rolling);
        // What is less than the tolerance is left alone.
        const V3 slip = relative_velocity(bodies, axes.arm_a, axes.arm_b) -
                        relative_velocity(before, axes.arm_a, axes.arm_b);
        const V3 spin = (bodies.b.angular - bodies.a.angular) - (before.b.angular - before.a.angular);
        const auto size = [](V3 v) { return abs(v.x) + abs(v.y) + abs(v.z); };
        const F reach = size(axes.arm_a) + size(axes.arm_b);
        const M changes = acts & (size(slip) + size(spin) * reach > tolerance);
        bodies = select(changes, bodies, before);
        store(block.impact_tangent[0], select(changes, friction.tangent[0], old.tangent[0]));
        store(block.impact_tangent[1], select(changes, friction.tangent[1], old.tangent[1]));
        store(block.impact_twist, select(changes, friction.twist, old.twist));
        const V3 kept = select(changes, rolling, old_rolling);
        store(block.impact_rolling[0], kept.x);
        store(block.impact_rolling[1], kept.y);
        store(block.impact_rolling[2], kept.z);
        return changes;
      });
}

// The body keeps the velocity before the impact for a time; then it goes on with that after it. `change`: of
// the velocity, by this contact's impulses.
inline void keep_way(const ContactArgs& args, const std::int32_t* row, int count, M which, F inverse_mass,
                     const BodyVelocity& change, F time) {
  const I flags = load_freedom(args, row, inverse_mass).flags;
  WideDelta delta = load_delta(args.delta, row);
  V3 linear = change.linear, angular = change.angular;
  apply_locks(flags, linear, angular);
  const V3 position = select(which, delta.position - linear * time, delta.position);
  const Q4 rotation = select(which, advance(delta.rotation, -angular, time), delta.rotation);
  const F column[8] = {position.x, position.y, position.z, rotation.x,
                       rotation.y, rotation.z, rotation.w, F(0.0f)};
  store_rows8(args.delta->position, row, count, column);
}

template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void finish_impacts_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  if constexpr (kRich) {
    using Block = RichBlock<kPoints>;
    const F zero(0.0f);
    for_each_block<Block>(args, chunk, [&](Block& block, int count, int first_lane) {
      const M acts = load(block.impact_time) < F(kNoImpact);
      if (bits(acts) == 0) return;
      const Axes axes = axes_of(block);
      NormalImpulses total{zero, zero, zero};
      F impulse[kPoints];
      for (int k = 0; k < kPoints; ++k) {
        impulse[k] = select(acts, load(block.impact_impulse[k]), zero);
        total.sum = total.sum + impulse[k];
        total.torque1 = total.torque1 + load(block.v[k]) * impulse[k];
        total.torque2 = total.torque2 - load(block.u[k]) * impulse[k];
      }
      const FrictionImpulses friction{{load(block.impact_tangent[0]), load(block.impact_tangent[1])},
                                      load(block.impact_twist)};
      const V3 rolling = load3(block.impact_rolling);
      add_impulse_sum(args, first_lane, total.sum);
      if (args.force_sum != nullptr)
        add_rebound_forces<kPoints>(args, first_lane, acts, impulse, friction, rolling);
      const V3 none{zero, zero, zero};
      Bodies change{{none, none, {zero, zero}}, {none, none, {zero, zero}}};
      apply<kStatic>(
          change, block, axes.arm_a, axes.arm_b,
          axes.normal * total.sum + axes.tangent1 * friction.tangent[0] + axes.tangent2 * friction.tangent[1],
          axes.tangent1 * total.torque1 + axes.tangent2 * total.torque2 + axes.normal * friction.twist +
              rolling);
      // A hub hardly changes its way by one of its many contacts.
      const F time = load(block.impact_time);
      if constexpr (!kStatic) {
        if (chunk.hub != BodySide::a)
          keep_way(args, block.row_a, count, acts, load(block.inverse_mass_a), change.a, time);
      }
      if (chunk.hub != BodySide::b)
        keep_way(args, block.row_b, count, acts, load(block.inverse_mass_b), change.b, time);
    });
  }
}

void find_impacts(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(find_impacts_chunk, args, chunk)
}
void push_impacts(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(push_impacts_chunk, args, chunk)
}
void rub_impacts(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(rub_impacts_chunk, args, chunk)
}
void finish_impacts(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(finish_impacts_chunk, args, chunk)
}

}  // namespace

void add_contact_rebound_kernels(ContactKernels& kernels) {
  kernels.find_impacts = find_impacts;
  kernels.push_impacts = push_impacts;
  kernels.rub_impacts = rub_impacts;
  kernels.finish_impacts = finish_impacts;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
