// Rebounds: impacts of contacts with restitution, before a substep moves its bodies; see
// simd/constraints/contact/contact_kernels.h.
//
// The points of a manifold that meet within the substep, the fastest of them above the threshold, leave with
// e times the speed at which they come (Newton's law), with friction by Coulomb's law under the impulse of
// the impact. Contacts are taken one after the other, and each impact by itself never adds energy; so none do
// together, whatever their order. An impact that comes later in the substep leaves the bodies on their old
// way until then. (Guendelman, Bridson and Fedkiw, "Nonconvex Rigid Bodies with Stacking", SIGGRAPH 2003,
// take collisions before contacts for the same reason.) What rebounds has no impulse for the rest of the step
// to inherit: a kick is no guess for the next substep.
#include <simd/constraints/contact/contact_forces.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// Sweeps over the points of a manifold: after one, a box that lands flat rebounds with half its speed.
constexpr int kSweeps = 8;

template <int kPoints>
struct Impact {
  F speed[kPoints];  // before it; negative where a point comes in
  M meets[kPoints];  // within the substep
  M happens;         // whether there is any
  F time;            // s, from the substep's beginning to the first meeting
};

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

// The way of a point to its meeting within the substep, with the separation s, the speed V on the parabola
// and the relative acceleration a along the normal: s + V t + a t^2 / 2. `acceleration`: 0 of bodies that do
// not fly freely.
template <int kPoints, class Block>
inline Impact<kPoints> find_impact(const ContactArgs& args, const Block& block, const Bodies& bodies,
                                   const WideDelta& delta_a, const WideDelta& delta_b, V3 normal, V3 tangent1,
                                   V3 tangent2, V3 arm_a, V3 arm_b, F acceleration) {
  const F zero(0.0f), one(1.0f), two(2.0f), substep(args.substep), threshold(-args.restitution_threshold);
  Impact<kPoints> impact;
  point_speeds<kPoints>(block, relative_velocity(bodies, arm_a, arm_b), bodies.b.angular - bodies.a.angular,
                        normal, tangent1, tangent2, impact.speed);
  // Not those of the last relax sweep: impacts of this substep may have moved the bodies.
  F separation[kPoints];
  present_separations<kPoints>(block, delta_a, delta_b, normal, tangent1, tangent2, arm_a, arm_b, separation);
  F fastest(0.0f);
  impact.time = substep;
  for (int k = 0; k < kPoints; ++k) {
    const F speed = impact.speed[k], on_parabola = speed + acceleration * (F(0.5f) * substep);
    impact.meets[k] = separation[k] + (speed + acceleration * substep) * substep < zero;
    fastest = select(impact.meets[k], min(speed, fastest), fastest);
    const M comes = impact.meets[k] & (separation[k] > zero) & (on_parabola < zero);
    const F root = sqrt(max(on_parabola * on_parabola - two * (acceleration * separation[k]), zero));
    const F time = select(comes, two * separation[k] / select(comes, root - on_parabola, one), zero);
    impact.time = select(impact.meets[k], min(time, impact.time), impact.time);
  }
  impact.happens = (load(block.restitution) > zero) & (fastest < threshold);
  return impact;
}

// The normal impulses of an impact, acted out on the bodies.
template <int kPoints>
struct Rebound {
  F impulse[kPoints];
  F sum, moment;  // of the impulses, and times the points' radii, for friction
};

// `fall`: m/s, by which gravity changes the normal speed until the impact. It is not in the velocities yet,
// and will be, for the whole substep: so it is taken off again with the sign that it has after the impact.
// The places of a body that flies freely by semi-implicit Euler lie on a parabola, on which the velocity is
// that of the body and half a substep's gravity. That is the velocity that rebounds: on the parabola energy
// is exact, and an elastic ball rises as high as it fell.
template <bool kStatic, int kPoints, class Block>
inline Rebound<kPoints> solve_rebound(const Block& block, const Impact<kPoints>& impact, F fall,
                                      Bodies& bodies, V3 normal, V3 tangent1, V3 tangent2, V3 arm_a,
                                      V3 arm_b) {
  const F zero(0.0f), one(1.0f), restitution = load(block.restitution);
  const auto speeds_now = [&](F(&speed)[kPoints]) {
    point_speeds<kPoints>(block, relative_velocity(bodies, arm_a, arm_b), bodies.b.angular - bodies.a.angular,
                          normal, tangent1, tangent2, speed);
  };
  F impulse[kPoints], speed[kPoints];
  for (int k = 0; k < kPoints; ++k) impulse[k] = zero;
  NormalImpulses total{zero, zero, zero};
  const Bodies before = bodies;
  for (int sweep = 0; sweep < (kPoints == 1 ? 1 : kSweeps); ++sweep) {
    speeds_now(speed);
    const NormalImpulses change =
        sweep_points<kPoints>(block, speed, impulse, [&](int k, F point_speed, F, F effective_mass) {
          const F error = point_speed + fall + restitution * min(impact.speed[k] + fall, zero);
          return select(impact.meets[k] & impact.happens, effective_mass * error, zero);
        });
    total = {total.sum + change.sum, total.torque1 + change.torque1, total.torque2 + change.torque2};
    apply<kStatic>(bodies, block, arm_a, arm_b, normal * change.sum,
                   tangent1 * change.torque1 + tangent2 * change.torque2);
  }
  // Of the impulses P and the speeds u before and v after them, the energy changes by P (u + v) / 2; of a
  // share s of them, by s P u + s^2 P (v - u) / 2. Sweeps that are not done, and rounding, may have added
  // some.
  speeds_now(speed);
  F incoming(0.0f), response(0.0f);
  for (int k = 0; k < kPoints; ++k) {
    incoming = incoming + impulse[k] * (impact.speed[k] + fall);
    response = response + impulse[k] * (speed[k] - impact.speed[k]);
  }
  const M gains = F(2.0f) * incoming + response > zero;
  const F share = select(gains, max(F(-2.0f) * incoming, zero) / select(gains, response, one), one);
  bodies = before;
  apply<kStatic>(bodies, block, arm_a, arm_b, normal * (total.sum * share),
                 (tangent1 * total.torque1 + tangent2 * total.torque2) * share);
  Rebound<kPoints> rebound{{}, total.sum * share, zero};
  for (int k = 0; k < kPoints; ++k) {
    rebound.impulse[k] = impulse[k] * share;
    rebound.moment += load(block.radius[k]) * rebound.impulse[k];
  }
  return rebound;
}

// Friction under the impulses of an impact: it slows what slides, spins and rolls, and adds no energy either.
struct Rubbing {
  FrictionImpulses friction;
  V3 rolling;
};

template <bool kStatic, int kPoints, class Block>
inline Rubbing rub(const Block& block, const Rebound<kPoints>& rebound, Bodies& bodies, V3 normal,
                   V3 tangent1, V3 tangent2, V3 arm_a, V3 arm_b) {
  const F zero(0.0f);
  Rubbing rubbing;
  rubbing.friction = solve_friction<true>(block, {zero, zero, zero}, {{zero, zero}, zero}, rebound.sum,
                                          rebound.moment, relative_velocity(bodies, arm_a, arm_b),
                                          bodies.b.angular - bodies.a.angular, normal, tangent1, tangent2);
  const FrictionImpulses& friction = rubbing.friction;
  apply<kStatic>(bodies, block, arm_a, arm_b, tangent1 * friction.tangent[0] + tangent2 * friction.tangent[1],
                 normal * friction.twist);
  rubbing.rolling = solve_rolling<kStatic>(block, bodies, {zero, zero, zero}, rebound.sum);
  apply_torque<kStatic>(bodies, block, rubbing.rolling);
  return rubbing;
}

inline BodyVelocity select(M which, const BodyVelocity& yes, const BodyVelocity& no) {
  return {select(which, yes.linear, no.linear),
          select(which, yes.angular, no.angular),
          {no.padding[0], no.padding[1]}};
}

// What has changed in a velocity, added to another one where it has.
inline BodyVelocity add_change(M which, const BodyVelocity& to, const BodyVelocity& after,
                               const BodyVelocity& before) {
  const BodyVelocity sum{to.linear + (after.linear - before.linear),
                         to.angular + (after.angular - before.angular),
                         {to.padding[0], to.padding[1]}};
  return select(which, sum, to);
}

// The body keeps the velocity before the impact for a time; then it goes on with that after it.
inline void keep_way(const ContactArgs& args, const std::int32_t* row, int count, M which,
                     const Freedom& freedom, WideDelta delta, const BodyVelocity& after,
                     const BodyVelocity& before, F time) {
  V3 linear = before.linear - after.linear, angular = before.angular - after.angular;
  apply_locks(freedom.flags, linear, angular);
  const V3 position = select(which, delta.position + linear * time, delta.position);
  const Q4 rotation = select(which, advance(delta.rotation, angular, time), delta.rotation);
  const F column[8] = {position.x, position.y, position.z, rotation.x,
                       rotation.y, rotation.z, rotation.w, F(0.0f)};
  store_rows8(args.delta->position, row, count, column);
}

template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void rebound_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  if constexpr (kRich) {
    using Block = RichBlock<kPoints>;
    HubSum hub(args.velocity, chunk), free_hub(args.free_velocity, chunk);
    bool any = false;
    for_each_block<Block>(args, chunk, [&](Block& block, int count, int first_lane) {
      prefetch(&block + 1, 0, offsetof(ContactBlock<kPoints>, impulse));
      // What is here for rolling or a moving surface alone never rebounds.
      const bool may_rebound = bits(load(block.restitution) > F(0.0f)) != 0;
      if (!may_rebound && hub.side() == BodySide::none) return;
      const V3 normal = load3(block.normal), tangent1 = tangent_of(normal);
      const V3 tangent2 = cross(normal, tangent1);
      const V3 arm_a = load3(block.arm_a), arm_b = load3(block.arm_b);
      const Bodies before = load_bodies(args.velocity, block);
      const WideDelta delta_a = load_delta(args.delta, block.row_a),
                      delta_b = load_delta(args.delta, block.row_b);
      F inverse_mass_a(0.0f);  // blocks against bodies that cannot be pushed have none
      if constexpr (!kStatic) inverse_mass_a = load(block.inverse_mass_a);
      const Freedom freedom_a = load_freedom(args, block.row_a, inverse_mass_a),
                    freedom_b = load_freedom(args, block.row_b, load(block.inverse_mass_b));
      // Joints would bring a body back that goes on its own way.
      const M jointed = freedom_a.jointed | freedom_b.jointed;
      const F acceleration = select(jointed, F(0.0f), dot(normal, freedom_b.gravity - freedom_a.gravity));
      const Impact<kPoints> impact = find_impact<kPoints>(args, block, before, delta_a, delta_b, normal,
                                                          tangent1, tangent2, arm_a, arm_b, acceleration);
      const bool happens = bits(impact.happens) != 0;
      any = any || happens;
      // The parts of a hub are added up whatever happens to them.
      if (!happens && hub.side() == BodySide::none) return;
      const F time = select(jointed, F(0.0f), impact.time);
      const F fall = acceleration * (time + F(0.5f * args.substep));
      Bodies bodies = before;
      const Rebound<kPoints> rebound = solve_rebound<kStatic, kPoints>(block, impact, fall, bodies, normal,
                                                                       tangent1, tangent2, arm_a, arm_b);
      const Rubbing rubbing =
          rub<kStatic, kPoints>(block, rebound, bodies, normal, tangent1, tangent2, arm_a, arm_b);
      bodies = {select(impact.happens, bodies.a, before.a), select(impact.happens, bodies.b, before.b)};
      add_impulse_sum(args, first_lane, rebound.sum);
      if (args.force_sum != nullptr) {
        add_rebound_forces<kPoints>(args, first_lane, impact.happens, rebound.impulse, rubbing.friction,
                                    rubbing.rolling);
      }
      const Bodies free = load_bodies(args.free_velocity, block);
      store_bodies<kStatic>(args.velocity, block, count, first_lane, bodies, hub);
      store_bodies<kStatic>(args.free_velocity, block, count, first_lane,
                            {add_change(impact.happens, free.a, bodies.a, before.a),
                             add_change(impact.happens, free.b, bodies.b, before.b)},
                            free_hub);
      // A hub hardly changes its way by one of its many contacts.
      if (!kStatic && hub.side() != BodySide::a)
        keep_way(args, block.row_a, count, impact.happens, freedom_a, delta_a, bodies.a, before.a, time);
      if (hub.side() != BodySide::b)
        keep_way(args, block.row_b, count, impact.happens, freedom_b, delta_b, bodies.b, before.b, time);
    });
    args.rebounded[chunk.number] = any ? 1 : 0;
  }
}

void rebound(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(rebound_chunk, args, chunk)
}

}  // namespace

void add_contact_rebound_kernel(ContactKernels& kernels) { kernels.rebound = rebound; }

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
