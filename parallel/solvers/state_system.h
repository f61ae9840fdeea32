// From a packed world to the rows of all its constraints, for solvers that look at all of them; see
// core/solvers/.
#pragma once

#include <core/solvers/constraint_system.h>
#include <parallel/constraints/constraints.h>
#include <parallel/crew/crew.h>

#include <vector>

namespace scree {

// The constraints that a step solves, at the present poses and velocities.
struct StatedWorld {
  std::vector<SystemBody> bodies;  // the first one is the fixed world, and every body that is not moving
  std::vector<std::int32_t> row;   // of each of them among the world's bodies
  std::vector<StatedConstraint> constraints;  // in lane order, joints first
  std::vector<bool> is_contact;               // each of them
  std::vector<std::int32_t> item;             // its joint, or its row in Contacts::now
};

// After pack_blocks() and the preparing kernels of solve(). The arguments' `elapsed` says when it is.
StatedWorld state_world(WorldData& data, const simd::ContactArgs& contact, const simd::JointArgs& joint,
                        Crew& crew);

// The policy of the soft step in one of its passes.
SystemPolicy policy_of(const WorldData& data, float dt, SystemPolicy::Pass pass);

}  // namespace scree
