// From a packed world to the rows of all its constraints, for solvers that look at all of them; see
// core/solvers/.
#pragma once

#include <core/solvers/constraint_system.h>
#include <parallel/solvers/solve_step.h>

#include <vector>

namespace scree {

// Where the block of a constraint has it.
struct StatedLane {
  std::int32_t lane, first_lane;  // its own, and the first one of its block
  std::int32_t lanes;             // of a block
  bool peaks;                     // the largest of the joint's reactions counts
  bool remembers;                 // see simd::JointVariantKernels
};

// The constraints that a step solves, at the present poses and velocities.
struct StatedWorld {
  std::vector<SystemBody> bodies;  // the first one is the fixed world, and every body that is not moving
  std::vector<std::int32_t> row;   // of each of them among the world's bodies; the awake ones come first
  std::vector<StatedConstraint> constraints;  // joints first; both by ascending item
  std::vector<bool> is_contact;               // each of them
  std::vector<std::int32_t> item;             // its joint, or its row in Contacts::now
  std::vector<StatedLane> lane;
};

// After pack_blocks() and the preparing kernels of solve(). The arguments' `elapsed` says when it is.
StatedWorld state_world(WorldData& data, const simd::ContactArgs& contact, const simd::JointArgs& joint,
                        Crew& crew);

// The rows of its joints alone, in the same order.
std::vector<ConstraintRows> state_joints(SolveStep& step, const simd::JointArgs& joint);

// A substep up to its rows: rebounds, velocities from forces, and the rows that are left to solve. `last`:
// those of the substep before, whose impulses are the guess; empty in the first one.
StatedWorld begin_substep(SolveStep& step, const StatedWorld& last);

// The policy of the soft step in one of its passes.
SystemPolicy policy_of(const WorldData& data, float dt, SystemPolicy::Pass pass);

// That of other solvers: what has no hertz is rigid, with Baumgarte's bias.
SystemPolicy rigid_policy_of(const WorldData& data, float substep);

// ConstraintRow::impulse of stated rows, after a substep: to the sums of the step that events and
// World::contact_forces want, and to the peaks of joints that may break.
void add_stated_impulses(SolveStep& step, const StatedWorld& stated);

// The same after the last substep, to manifolds, joints and their reactions.
void store_stated_impulses(SolveStep& step, const StatedWorld& stated);

}  // namespace scree
