// Solvers of all rows at once, in double precision, on one thread: see core/solvers/README.md.
//
//   each substep   rebounds; velocities from forces; the rows of all constraints at the present poses, with
//                  Baumgarte's bias; their impulses by the method that the settings name; velocities of the
//                  bodies from these; poses from velocities
//
// Blocks are prepared for rebounds alone. Impulses go to manifolds and joints from the rows themselves, and
// a substep begins with those of the last one.
#include <parallel/solvers/over_blocks.h>
#include <parallel/solvers/solve_step.h>
#include <parallel/solvers/whole_system/solve_across.h>

#include <algorithm>
#include <cmath>

namespace scree {

namespace {

constexpr int kMostDirectSteps = 1000;

ReferenceOptions options_of(const WorldSettings& settings) {
  const SolverOptions& given = settings.solver_options;
  ReferenceOptions options;
  options.method =
      static_cast<ReferenceMethod>(static_cast<int>(settings.solver) - static_cast<int>(Solver::jacobi));
  options.max_iterations = settings.solver == Solver::direct ? kMostDirectSteps : given.iterations;
  options.tolerance = double{given.tolerance};
  options.relaxation = double{given.relaxation};
  options.warm_start = settings.warm_start;
  return options;
}
static_assert(static_cast<int>(ReferenceMethod::direct) ==
              static_cast<int>(Solver::direct) - static_cast<int>(Solver::jacobi));

// A point that comes in fast enough to rebound is not braked while it is apart: the next substep has it.
void leave_to_rebound(const SolveStep& step, StatedWorld& stated) {
  const float threshold = step.data.settings.restitution_threshold;
  for (std::size_t i = 0; i < stated.constraints.size(); ++i) {
    if (!stated.is_contact[i]) continue;
    const std::int32_t contact = stated.item[i];
    if ((step.data.contacts.now.manifold[contact].info & kManifoldRich) == 0) continue;
    if (!(step.data.contacts.now.surface[contact].restitution > 0.0f)) continue;
    StatedConstraint& constraint = stated.constraints[i];
    const VelocityRow &a = stated.bodies[static_cast<std::size_t>(constraint.body_a)].velocity,
                      &b = stated.bodies[static_cast<std::size_t>(constraint.body_b)].velocity;
    for (ConstraintRow& row : constraint.rows.row) {
      if (row.kind != kRowContact || !(row.error > 0.0f) || row.impulse > 0.0f) continue;
      float speed = 0.0f;
      for (int k = 0; k < 3; ++k) {
        speed += row.linear_a[k] * a.linear[k] + row.angular_a[k] * a.angular[k] +
                 row.linear_b[k] * b.linear[k] + row.angular_b[k] * b.angular[k];
      }
      if (speed < -threshold) row.kind = kRowNone;
    }
  }
}

bool is_finite(const SystemBody& body) {
  float differences = 0.0f;  // the sum of x - x
  const auto take = [&differences](float x) { differences += x - x; };
  for (int k = 0; k < 3; ++k) take(body.velocity.linear[k]), take(body.velocity.angular[k]);
  for (const float moment : body.inverse.inverse_inertia) take(moment);
  take(body.inverse.inverse_mass);
  return differences == 0.0f;
}

bool is_finite(const ConstraintRow& row) {
  float differences =
      row.error - row.error + (row.target_speed - row.target_speed) + (row.impulse - row.impulse);
  for (int k = 0; k < 3; ++k) {
    for (const float x : {row.linear_a[k], row.angular_a[k], row.linear_b[k], row.angular_b[k]})
      differences += x - x;
  }
  return differences == 0.0f;
}

// One row that is not finite would make all bodies so. Its own are quarantined after the step.
void drop_non_finite(StatedWorld& stated) {
  for (StatedConstraint& constraint : stated.constraints) {
    bool finite = is_finite(stated.bodies[static_cast<std::size_t>(constraint.body_a)]) &&
                  is_finite(stated.bodies[static_cast<std::size_t>(constraint.body_b)]);
    for (const ConstraintRow& row : constraint.rows.row)
      finite = finite && (row.kind == kRowNone || is_finite(row));
    if (finite) continue;
    for (ConstraintRow& row : constraint.rows.row) row.kind = kRowNone;
  }
}

// Kinematic bodies go on as they do.
void take_velocities(const Eigen::VectorXd& v, StatedWorld& stated) {
  for (std::size_t i = 1; i < stated.bodies.size(); ++i) {
    VelocityRow& to = stated.bodies[i].velocity;
    for (int k = 0; k < 3; ++k) {
      const auto first = 6 * static_cast<Eigen::Index>(i) + k;
      to.linear[k] = static_cast<float>(v[first]);
      to.angular[k] = static_cast<float>(v[first + 3]);
    }
  }
}

// In the rows' own field, where the next substep finds its guess and the stores of contacts and joints look.
void take_impulses(const ConstraintSystem& system, const Eigen::VectorXd& p, StatedWorld& stated) {
  for (StatedConstraint& constraint : stated.constraints) {
    for (ConstraintRow& row : constraint.rows.row) row.impulse = 0.0f;
  }
  for (int i = 0; i < system.rows(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    StatedConstraint& constraint = stated.constraints[static_cast<std::size_t>(system.constraint[row])];
    constraint.rows.row[system.slot[row]].impulse = static_cast<float>(p[i]);
  }
}

// The guesses of a substep: the impulses of the last one; in the first, those that are stored, by the ratio
// of the time steps.
void guess(const SolveStep& step, const StatedWorld& last, StatedWorld& stated) {
  const float scale = step.contact.warm_start_scale;
  for (std::size_t i = 0; i < stated.constraints.size(); ++i) {
    for (int slot = 0; slot < kMaxConstraintRows; ++slot) {
      ConstraintRow& row = stated.constraints[i].rows.row[slot];
      row.impulse =
          last.constraints.empty() ? row.impulse * scale : last.constraints[i].rows.row[slot].impulse;
    }
  }
}

}  // namespace

SystemAnswer solve_stated(StatedWorld& stated, const SystemPolicy& policy, const ReferenceOptions& options) {
  const ConstraintSystem system = assemble(stated.bodies, stated.constraints, policy);
  const ReferenceSolution solution = solve(system, options);
  take_velocities(velocities(system, stated.bodies, solution.impulses), stated);
  take_impulses(system, solution.impulses, stated);
  return {solution.residual, solution.iterations, solution.is_singular ? 1 : 0};
}

double residual_of_rows(SolveStep& step) {
  const simd::Kernels& kernels = step.crew.kernels();
  over_blocks(
      step.constraints, step.crew,
      [&](const simd::ConstraintChunk& chunk) { kernels.contact.store(step.contact, chunk); },
      [&](const simd::ConstraintChunk& chunk) {
        kernels.joint.variant[chunk.variant].store(step.joint, chunk);
      });
  StatedWorld stated = state_world(step.data, step.contact, step.joint, step.crew);
  drop_non_finite(stated);
  return residual_of_stored(
      assemble(stated.bodies, stated.constraints, rigid_policy_of(step.data, step.joint.substep)));
}

StatedWorld begin_substep(SolveStep& step, const StatedWorld& last) {
  rebound(step);
  over_bodies(step, step.dynamic_count, step.crew.kernels().body.integrate_velocities,
              "integrate_velocities");
  StatedWorld stated = state_world(step.data, step.contact, step.joint, step.crew);
  guess(step, last, stated);
  if (step.may_rebound) leave_to_rebound(step, stated);
  drop_non_finite(stated);
  return stated;
}

void solve_whole_system(SolveStep& step) {
  WorldData& data = step.data;
  const simd::Kernels& kernels = step.crew.kernels();
  const int substeps = data.settings.substeps;
  const SystemPolicy policy = rigid_policy_of(data, step.joint.substep);
  const ReferenceOptions options = options_of(data.settings);
  step.body.warm_start = false;  // velocities inherit no impulses
  StatedWorld last;
  for (int substep = 0; substep < substeps; ++substep) {
    step.body.first_substep = step.contact.first_substep = substep == 0;
    step.body.elapsed = static_cast<float>(substep) * step.body.substep;
    step.joint.elapsed = static_cast<float>(substep) * step.joint.substep;
    StatedWorld stated = begin_substep(step, last);
    Border* const border = border_of(data);
    const SystemAnswer answer = border == nullptr
                                    ? solve_stated(stated, policy, options)
                                    : solve_across(stated, data.contacts, *border, policy, options);
    for (std::size_t i = 1; i <= static_cast<std::size_t>(step.dynamic_count); ++i)
      data.bodies.velocity[stated.row[i]] = stated.bodies[i].velocity;
    add_stated_impulses(step, stated);
    data.stats.residual = std::max(data.stats.residual, answer.residual);
    data.stats.solver_iterations = std::max(data.stats.solver_iterations, answer.iterations);
    data.stats.solver_singular = data.stats.solver_singular || answer.is_singular != 0;
    if (substep == substeps - 1) store_stated_impulses(step, stated);
    over_bodies(step, step.moving_count, kernels.body.integrate_poses, "integrate_poses");
    last = std::move(stated);
  }
  if (!data.settings.measure_penetration) return;
  over_blocks(
      step.constraints, step.crew,
      [&](const simd::ConstraintChunk& chunk) { kernels.contact.find_separations(step.contact, chunk); },
      [](const simd::ConstraintChunk&) {});
}

}  // namespace scree
