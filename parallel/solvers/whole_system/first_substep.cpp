// See first_substep.h: a clone takes a step up to its rows.
#include <core/world/edit.h>
#include <parallel/solvers/solve_step.h>
#include <parallel/solvers/whole_system/first_substep.h>
#include <parallel/solvers/whole_system/state_system.h>
#include <parallel/stages.h>
#include <scree/error.h>
#include <scree/snapshot.h>
#include <scree/step.h>

#include <string>

namespace scree {

ContactProblem contact_problem_of(const World& world, float dt, Workers& workers) {
  if (!(dt > 0.0f && dt <= 1.0f)) {
    throw Error("contact_problem_of: the time step is " + std::to_string(dt) + " s; it must be in (0, 1]");
  }
  World copy = clone(world);
  WorldSettings settings = copy.settings();
  settings.solver = Solver::direct;
  copy.set_settings(settings);
  step(copy, 0.0f, workers);  // finds contacts, and moves nothing
  WorldData& data = internals(copy);
  Crew crew(workers);
  color_constraints(data, crew);
  pack_blocks(data, crew);
  SolveStep at = prepare_solve(data, dt, crew);
  at.body.first_substep = at.contact.first_substep = true;
  at.body.elapsed = 0.0f;
  at.joint.elapsed = 0.0f;
  at.body.warm_start = false;
  const StatedWorld stated = begin_substep(at, {});
  return contact_problem(stated.bodies, stated.constraints, rigid_policy_of(data, at.joint.substep));
}

}  // namespace scree
