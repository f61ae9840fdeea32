// The sweeps over blocks of joints, for any kind of them. Private to the joint kernels.
//
// A kind of joint is a struct with
//
//   Rows           what the kind measures, see joint_measure.h
//   Block          row_a, row_b and what else it needs, as arrays of lanes
//   prepare(args, joint, bodies, placement, block)   rows -> block; `joint`: the rows of the lanes
//   warm_start(block, bodies)                        the impulses that the block begins with
//   solve(args, block, bodies)                       see joint_kernels.h
//   relax(args, block, delta_a, delta_b, bodies)     the same; returns the largest velocity error that it met
//   acting(block)                                    JointImpulse of the substep
//   store(args, joint, count, block)                 block -> impulses
//
// all of them static, and kLeavesTurns if it holds no rotation. `bodies` come loaded and are written by the
// sweep.
#pragma once

#include <simd/constraints/joints/joint_shares.h>
#include <simd/constraints/joints/joint_statement.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

template <class Kind>
SCREE_SWEEP void prepare_joints(const JointArgs& args, const ConstraintChunk& chunk) {
  using Block = typename Kind::Block;
  bool shared = false;
  for_each_block<Block>(args, chunk, [&](Block& block, int count, int first_lane) {
    const std::int32_t* joint = args.rows + first_lane;
    const JointPlacement placement = load_placement(args, joint, block.row_a, block.row_b);
    JointBodyLanes bodies = load_bodies(args, block.row_a, block.row_b);
    if (divide_bodies<Kind>(args, chunk, block.row_a, block.row_b, first_lane, placement, bodies))
      shared = true;
    Kind::prepare(args, joint, bodies, placement, block);
    if (chunk.peaks) clear_peaks(args, joint, count);
  });
  args.shared[chunk.number] = shared ? 1 : 0;
}

template <class Kind>
SCREE_SWEEP void warm_start_joints(const JointArgs& args, const ConstraintChunk& chunk) {
  using Block = typename Kind::Block;
  const bool shared = args.shared[chunk.number] != 0;
  HubSum hub(args.velocity, chunk);
  for_each_block<Block>(args, chunk, [&](Block& block, int count, int first_lane) {
    prefetch(&block + 1, 0, sizeof(Block));
    JointBodyLanes bodies = load_parts(args, shared, block.row_a, block.row_b, first_lane);
    Kind::warm_start(block, bodies);
    store_bodies(args, chunk, shared, block.row_a, block.row_b, count, first_lane, bodies, hub);
  });
}

template <class Kind>
SCREE_SWEEP void solve_joints(const JointArgs& args, const ConstraintChunk& chunk) {
  using Block = typename Kind::Block;
  const bool shared = args.shared[chunk.number] != 0;
  HubSum hub(args.velocity, chunk);
  for_each_block<Block>(args, chunk, [&](Block& block, int count, int first_lane) {
    prefetch(&block + 1, 0, sizeof(Block));
    JointBodyLanes bodies = load_parts(args, shared, block.row_a, block.row_b, first_lane);
    Kind::solve(args, block, bodies);
    store_bodies(args, chunk, shared, block.row_a, block.row_b, count, first_lane, bodies, hub);
  });
}

template <class Kind, bool kMeasured>
inline void relax_blocks(const JointArgs& args, const ConstraintChunk& chunk) {
  using Block = typename Kind::Block;
  const bool shared = args.shared[chunk.number] != 0;
  HubSum hub(args.velocity, chunk);
  F worst(0.0f);
  for_each_block<Block>(args, chunk, [&](Block& block, int count, int first_lane) {
    prefetch(&block + 1, 0, sizeof(Block));
    const WideDelta delta_a = load_delta(args.delta, block.row_a);
    const WideDelta delta_b = load_delta(args.delta, block.row_b);
    JointBodyLanes bodies = load_parts(args, shared, block.row_a, block.row_b, first_lane);
    const F error = Kind::relax(args, block, delta_a, delta_b, bodies);
    if constexpr (kMeasured) worst = max(error, worst);
    if (chunk.peaks) note_peak(args, args.rows + first_lane, count, Kind::acting(block));
    store_bodies(args, chunk, shared, block.row_a, block.row_b, count, first_lane, bodies, hub);
  });
  if constexpr (kMeasured) args.residual[chunk.number] = reduce_max(worst);
}

template <class Kind>
SCREE_SWEEP void relax_joints(const JointArgs& args, const ConstraintChunk& chunk) {
  relax_blocks<Kind, false>(args, chunk);
}

template <class Kind>
SCREE_SWEEP void relax_measured_joints(const JointArgs& args, const ConstraintChunk& chunk) {
  relax_blocks<Kind, true>(args, chunk);
}

// Of joints whose largest reactions count: what acts now is one of them. relax() does it by itself.
template <class Kind>
void note_peaks_joints(const JointArgs& args, const ConstraintChunk& chunk) {
  using Block = typename Kind::Block;
  for_each_block<Block>(args, chunk, [&](Block& block, int count, int first_lane) {
    note_peak(args, args.rows + first_lane, count, Kind::acting(block));
  });
}

template <class Kind>
void store_joints(const JointArgs& args, const ConstraintChunk& chunk) {
  using Block = typename Kind::Block;
  for_each_block<Block>(args, chunk, [&](Block& block, int count, int first_lane) {
    const std::int32_t* joint = args.rows + first_lane;
    Kind::store(args, joint, count, block);
    JointImpulse impulse = Kind::acting(block);
    impulse = {finite_or_zero(impulse.linear), finite_or_zero(impulse.angular)};
    store_reaction(args, chunk, joint, count, impulse);
  });
}

template <class Kind>
JointVariantKernels make_joint_kernels_of() {
  return {sizeof(typename Kind::Block),   Kind::Rows::kRemembers, prepare_joints<Kind>,
          warm_start_joints<Kind>,        solve_joints<Kind>,     relax_joints<Kind>,
          relax_measured_joints<Kind>,    store_joints<Kind>,     note_peaks_joints<Kind>,
          state_rows<typename Kind::Rows>};
}

// Both variants of a kind. Each kind's source defines its own, so that one that is forgotten does not link.
struct JointTypeKernels {
  JointVariantKernels plain, rich;
};
template <JointType type>
JointTypeKernels make_joint_type_kernels();

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
