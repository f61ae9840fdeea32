// Sweeps over contact blocks that bring their points to rest; see simd/constraints/contact/contact_kernels.h.
#include <simd/constraints/contact/contact_passes.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

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
    Bodies bodies = load_bodies(args.velocity, block);
    apply<kStatic>(bodies, block, load3(block.arm_a), load3(block.arm_b), impulse, torque);
    store_bodies<kStatic>(args.velocity, block, count, first_lane, bodies, hub);
  });
}

template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void solve_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  solve_blocks<kPoints, kRich, kStatic, false>(args, chunk);
}

template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void relax_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  relax_blocks<kPoints, kRich, kStatic, false, false>(args, chunk);
}

template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void relax_measured_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  relax_blocks<kPoints, kRich, kStatic, true, false>(args, chunk);
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

}  // namespace

void add_contact_solve_kernels(ContactKernels& kernels) {
  kernels.warm_start = warm_start;
  kernels.solve = solve;
  kernels.relax = relax;
  kernels.relax_measured = relax_measured;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
