// Sequential impulses: the velocity iterations of one step, with Baumgarte's bias; see
// simd/constraints/contact/contact_kernels.h.
//
// Of a point with the separation s and the approach speed v where the step begins, every iteration asks for
// the speed -bias,
//
//   bias = s / h                                  apart: it may come to touch
//        = max(factor / h min(s + slop, 0), -push speed)
//        = e v, if that is less, where it meets within the step and v is above the threshold
//
// (Baumgarte, "Stabilization of Constraints and Integrals of Motion in Dynamical Systems", 1972; Catto,
// "Iterative Dynamics with Temporal Coherence", GDC 2005.) Impulses are accumulated and clamped as sums.
#include <simd/constraints/contact/contact_passes.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// Puts the biases in the place of the separations, which nothing needs while the poses rest.
template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void begin_impulses_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  using Block = typename BlockOf<kPoints, kRich>::Type;
  const F zero(0.0f), rate(args.soft.bias_rate), slop(args.slop), push(-args.push_speed);
  const F inverse_substep(args.inverse_substep), substep(args.substep);
  for_each_block<Block>(args, chunk, [&](Block& block, int, int) {
    F speed[kPoints];
    if constexpr (kRich) {
      const V3 normal = load3(block.normal), tangent1 = tangent_of(normal);
      const Bodies bodies = load_bodies(args.velocity, block);
      point_speeds<kPoints>(block, relative_velocity(bodies, load3(block.arm_a), load3(block.arm_b)),
                            bodies.b.angular - bodies.a.angular, normal, tangent1, cross(normal, tangent1),
                            speed);
    }
    for (int k = 0; k < kPoints; ++k) {
      const F separation = load(block.initial_separation[k]);
      F bias = select(separation > zero, separation * inverse_substep,
                      max(rate * min(separation + slop, zero), push));
      if constexpr (kRich) {
        const M rebounds =
            (speed[k] < F(-args.restitution_threshold)) & (separation + speed[k] * substep < zero);
        bias = select(rebounds, min(load(block.restitution) * speed[k], bias), bias);
      }
      store(block.separation[k], bias);
    }
  });
}

// m/s, by which the speed of a contact's center along its normal rounds. To solve for less would push the
// bodies by errors, which are the same in each iteration and add up where nothing holds a body: 1e-4 m/s in
// 1,000 iterations. (By the largest parts of the velocities a ball that rolls at 50 m/s would sink.)
inline F rounding_of(const Bodies& bodies, V3 arm_a, V3 arm_b, V3 normal) {
  constexpr float kUnits = 8 * 0x1p-24f;
  const auto size = [](V3 v) { return V3{abs(v.x), abs(v.y), abs(v.z)}; };
  const auto largest = [&](const BodyVelocity& v, V3 arm) {
    const V3 w = size(v.angular), r = size(arm);
    return size(v.linear) + V3{w.y * r.z + w.z * r.y, w.z * r.x + w.x * r.z, w.x * r.y + w.y * r.x};
  };
  return F(kUnits) * dot(size(normal), largest(bodies.a, arm_a) + largest(bodies.b, arm_b));
}

template <int kPoints, bool kRich, bool kStatic, bool kTogether>
inline void sweep_impulses_blocks(const ContactArgs& args, const ConstraintChunk& chunk) {
  using Block = typename BlockOf<kPoints, kRich>::Type;
  HubSum hub(args.velocity, chunk);
  for_each_block<Block>(args, chunk, [&](Block& block, int count, int first_lane) {
    prefetch(&block + 1, 0, sizeof(Block));
    const V3 normal = load3(block.normal), tangent1 = tangent_of(normal);
    const V3 tangent2 = cross(normal, tangent1);
    const V3 arm_a = load3(block.arm_a), arm_b = load3(block.arm_b);
    Bodies bodies = load_bodies(args.velocity, block);
    const V3 relative = relative_velocity(bodies, arm_a, arm_b);
    const V3 spin = bodies.b.angular - bodies.a.angular;
    const F rounding = rounding_of(bodies, arm_a, arm_b, normal);
    F speed[kPoints], impulse[kPoints];
    point_speeds<kPoints>(block, relative, spin, normal, tangent1, tangent2, speed);
    for (int k = 0; k < kPoints; ++k) impulse[k] = load(block.impulse[k]);
    const NormalImpulses change = solve_points<kPoints, kTogether>(
        block, speed, impulse, [&](int k, F point_speed, F, F effective_mass) {
          const F error = point_speed + load(block.separation[k]);
          return select(abs(error) > rounding, effective_mass * error, F(0.0f));
        });
    F sum(0.0f), moment(0.0f);
    for (int k = 0; k < kPoints; ++k) {
      store(block.impulse[k], impulse[k]);
      sum = sum + impulse[k];
      moment = moment + load(block.radius[k]) * impulse[k];
    }
    add_impulse_sum(args, first_lane, sum);
    const FrictionImpulses old{{load(block.tangent_impulse[0]), load(block.tangent_impulse[1])},
                               load(block.twist_impulse)};
    rub_block<kRich, kStatic>(block, {normal, tangent1, tangent2, arm_a, arm_b}, change, old, sum, moment,
                              relative, spin, F(1.0f), bodies);
    if (args.force_sum != nullptr) add_forces<kPoints, kRich>(args, first_lane, block);
    store_bodies<kStatic>(args.velocity, block, count, first_lane, bodies, hub);
  });
}

template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void sweep_impulses_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  sweep_impulses_blocks<kPoints, kRich, kStatic, false>(args, chunk);
}
template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void sweep_impulses_together_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  sweep_impulses_blocks<kPoints, kRich, kStatic, true>(args, chunk);
}

template <int kPoints, bool kRich, bool kStatic>
void find_separations_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  using Block = typename BlockOf<kPoints, kRich>::Type;
  for_each_block<Block>(args, chunk, [&](Block& block, int, int) {
    const V3 normal = load3(block.normal), tangent1 = tangent_of(normal);
    F separation[kPoints];
    present_separations<kPoints>(block, load_delta(args.delta, block.row_a),
                                 load_delta(args.delta, block.row_b), normal, tangent1,
                                 cross(normal, tangent1), load3(block.arm_a), load3(block.arm_b), separation);
    for (int k = 0; k < kPoints; ++k) store(block.separation[k], separation[k]);
  });
}

void begin_impulses(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(begin_impulses_chunk, args, chunk)
}
void sweep_impulses(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(sweep_impulses_chunk, args, chunk)
}
void sweep_impulses_together(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(sweep_impulses_together_chunk, args, chunk)
}
void find_separations(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(find_separations_chunk, args, chunk)
}

}  // namespace

void add_contact_sequential_kernels(ContactKernels& kernels);

void add_contact_sequential_kernels(ContactKernels& kernels) {
  kernels.begin_impulses = begin_impulses;
  kernels.sweep_impulses = sweep_impulses;
  kernels.sweep_impulses_together = sweep_impulses_together;
  kernels.find_separations = find_separations;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
