// The system of a substep where ranks share the world: rank 0 solves it for all.
#pragma once

#include <core/solvers/reference_solvers.h>
#include <parallel/distributed/border.h>
#include <parallel/solvers/whole_system/state_system.h>

namespace scree {

struct SystemAnswer {
  double residual = 0.0;
  std::int32_t iterations = 0;
  std::int32_t is_singular = 0;
};

// Solves the system: velocities of its bodies and ConstraintRow::impulse are those after it.
SystemAnswer solve_stated(StatedWorld& stated, const SystemPolicy& policy, const ReferenceOptions& options);

// The same, of what all ranks state together, which is what a single process states. All ranks call it, each
// for the bodies and constraints that it knows. `contacts`: those of StatedWorld::item.
SystemAnswer solve_across(StatedWorld& stated, const Contacts& contacts, Border& border,
                          const SystemPolicy& policy, const ReferenceOptions& options);

}  // namespace scree
