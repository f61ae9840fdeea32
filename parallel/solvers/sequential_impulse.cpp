// Sequential impulses: a step is one substep, whose velocities several iterations over all colors improve.
//
//   once             velocities from forces; biases from separations and approach speeds; stored impulses
//   each iteration   joints, normals, friction, twist and rolling of each color
//   once             poses from velocities
//
// (Catto, "Iterative Dynamics with Temporal Coherence", GDC 2005; what Bullet, Box2D 2 and ODE do.) Colors
// keep their order through all iterations; with a seed pack_blocks shuffles it each step.
#include <parallel/solvers/over_blocks.h>
#include <parallel/solvers/solve_step.h>

#include <utility>

namespace scree {

void solve_sequential_impulses(SolveStep& step) {
  using ByContact = simd::ContactKernels;
  using ByJoint = simd::JointVariantKernels;
  const simd::Kernels& kernels = step.crew.kernels();
  const WorldSettings& settings = step.data.settings;
  const SolverOptions& options = settings.solver_options;
  step.body.first_substep = true;
  over_bodies(step, step.dynamic_count, kernels.body.integrate_velocities, "integrate_velocities");
  const auto nothing = [](const simd::ConstraintChunk&) {};
  over_blocks(
      step.constraints, step.crew,
      [&](const simd::ConstraintChunk& chunk) { kernels.contact.begin_impulses(step.contact, chunk); },
      nothing);
  if (step.contact.warm_start_scale > 0.0f)
    over_colors(step, &ByContact::warm_start, &ByJoint::warm_start, "warm_start");
  const ContactPass sweep =
      options.points_together ? &ByContact::sweep_impulses_together : &ByContact::sweep_impulses;
  // Impulses of the step are those after the last iteration.
  float* const impulse_sum = std::exchange(step.contact.impulse_sum, nullptr);
  float* const force_sum = std::exchange(step.contact.force_sum, nullptr);
  for (int iteration = 1; iteration <= options.iterations; ++iteration) {
    if (iteration == options.iterations)
      step.contact.impulse_sum = impulse_sum, step.contact.force_sum = force_sum;
    over_colors(step, sweep, &ByJoint::solve, "sweep");
  }
  over_blocks(step.constraints, step.crew, nothing, [&](const simd::ConstraintChunk& chunk) {
    if (chunk.peaks) kernels.joint.variant[chunk.variant].note_peaks(step.joint, chunk);
  });
  if (settings.measure_residual) step.data.stats.residual = residual_of_rows(step);
  over_bodies(step, step.moving_count, kernels.body.integrate_poses, "integrate_poses");
  if (!settings.measure_penetration) return;
  over_blocks(
      step.constraints, step.crew,
      [&](const simd::ConstraintChunk& chunk) { kernels.contact.find_separations(step.contact, chunk); },
      nothing);
}

}  // namespace scree
