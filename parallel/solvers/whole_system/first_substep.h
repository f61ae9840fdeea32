// The contact problem of a world, for what looks at it from outside: tools and tests.
#pragma once

#include <core/solvers/contact_problem.h>
#include <scree/workers.h>
#include <scree/world.h>

namespace scree {

// What the first substep of step(world, dt) has to solve, with the policy of the methods over the whole
// system (WorldSettings::solver_options: Baumgarte's bias, slop), whatever solver the world has; with
// friction at each point. The world stays as it is. Sleeping bodies take no part. Throws Error for a time
// step that is not in (0, 1] and for what contact_problem() refuses.
ContactProblem contact_problem_of(const World& world, float dt, Workers& workers);

}  // namespace scree
