// The solvers' arguments, and the default among them: soft step with substeps over colored blocks. Its stages
// are the only barriers of the step that repeat, so they are short and many.
//
//   once:           inertia into world axes, blocks from manifolds
//   each substep:   rebounds, velocities from forces (plus, after the first, the impulses so far),
//                   normals with soft bias, poses from velocities, relax without bias: normals,
//                   friction, twist, rolling
//
// The first substep applies the stored impulses color by color; later ones inherit the difference v - u
// between the velocity and the velocity without impulses, which is exactly what those impulses have done.
#include <parallel/constraints/constraints.h>
#include <parallel/distributed/messages.h>
#include <parallel/solvers/over_blocks.h>
#include <parallel/solvers/solve_step.h>
#include <parallel/stages.h>

#include <algorithm>

namespace scree {

namespace {

// What joints hold as stiffly as the step allows: hertz per rate of substeps, and damping ratio. On a net of
// 100 x 100 balls an eighth of the rate gives way by 25 mm in the mean where a fourth gives 1.3 mm, and a
// half breaks loose. The damping hardly matters there, from 0.5 to 10.
constexpr float kJointStiffness = 0.25f;
constexpr float kJointDampingRatio = 2.0f;
// The same at bodies of so many joints that these share them, see simd/constraints/joints/joint_shares.h.
constexpr float kSharedJointStiffness = 0.1875f;

// Contacts: largest hertz per rate of substeps, to which WorldSettings::contact_hertz is cut; a spring of so
// many hertz has eight substeps in a period. This and the two below are as in Box3D.
constexpr float kContactStiffness = 0.125f;
// Against bodies that cannot be pushed: times the hertz and times the damping ratio, so that the damping
// coefficient, a multiple of their product, stays the same.
constexpr float kStaticContactHertz = 2.0f;
constexpr float kStaticContactDamping = 0.5f;

// Largest ratio of two steps' substeps by which stored impulses are scaled. Rounding errors in the impulses
// grow with the ratio; above this they outweigh what a guess is worth.
constexpr float kMaxWarmStartScale = 4.0f;

}  // namespace

float substep_of(const WorldData& data, float dt) {
  if (data.settings.solver == Solver::sequential_impulse) return dt;
  return dt / static_cast<float>(data.settings.substeps);
}

float warm_start_scale(float substep, float last_substep) {
  return last_substep > 0.0f ? std::min(substep / last_substep, kMaxWarmStartScale) : 0.0f;
}

namespace {

// Rigid, with Baumgarte's bias.
simd::SoftConstants stabilized(const WorldSettings& settings, float substep) {
  return {settings.solver_options.baumgarte / substep, 1.0f, 0.0f};
}

// Iterations of a substep keep the impulses of each other. One pass a substep begins without them if the user
// wants no warm start.
bool keeps_impulses(const WorldSettings& settings) {
  return settings.warm_start || settings.solver == Solver::sequential_impulse;
}

}  // namespace

simd::ContactArgs contact_args(WorldData& data, Constraints& constraints, float dt) {
  const WorldSettings& settings = data.settings;
  const float substep = substep_of(data, dt);
  const float hertz = std::min(settings.contact_hertz, kContactStiffness / substep);
  const float ratio = settings.contact_damping_ratio;
  simd::ContactArgs args{};
  args.rows = constraints.contact_lanes.data();
  args.blocks = constraints.blocks.data();
  args.manifolds = data.contacts.now.manifold.data();
  args.surfaces = data.contacts.now.surface.data();
  args.velocity = data.bodies.velocity.data();
  args.free_velocity = data.bodies.free_velocity.data();
  args.delta = data.bodies.delta.data();
  args.motion = data.bodies.motion.data();
  args.inertia = data.bodies.inertia.data();
  args.step_notes = data.bodies.step_notes.data();
  args.soft = simd::soften(hertz, ratio, substep);
  args.soft_static = simd::soften(kStaticContactHertz * hertz, kStaticContactDamping * ratio, substep);
  if (settings.solver == Solver::sequential_impulse)
    args.soft = args.soft_static = stabilized(settings, substep);
  args.slop = settings.solver_options.slop;
  args.gravity[0] = settings.gravity.x;
  args.gravity[1] = settings.gravity.y;
  args.gravity[2] = settings.gravity.z;
  args.substep = substep;
  args.inverse_substep = 1.0f / substep;
  args.push_speed = settings.push_speed;
  args.restitution_threshold = settings.restitution_threshold;
  args.warm_start_scale = settings.warm_start ? warm_start_scale(substep, data.last_substep) : 0.0f;
  args.impulse_keep = keeps_impulses(settings) ? 1.0f : 0.0f;
  args.residual = constraints.residual.data();
  args.velocity_before = data.bodies.velocity.data();
  args.depth = constraints.depth.data();
  args.force_sum = settings.contact_forces ? constraints.force_sum.data() : nullptr;
  args.forces = data.contacts.forces.data();
  args.pose = data.bodies.pose.data();
  args.impulse_sum = asks_for_events(data) ? constraints.impulse_sum.data() : nullptr;
  return args;
}

simd::BodyArgs body_args(WorldData& data, float dt) {
  Bodies& bodies = data.bodies;
  Constraints& constraints = constraints_of(data);
  const WorldSettings& settings = data.settings;
  simd::BodyArgs args{};
  args.list = constraints.moving_bodies.data();
  args.pose = bodies.pose.data();
  args.velocity = bodies.velocity.data();
  args.free_velocity = bodies.free_velocity.data();
  args.velocity_before = bodies.velocity.data();
  args.delta = bodies.delta.data();
  args.inertia = bodies.inertia.data();
  args.local_mass = bodies.local_mass.data();
  args.local_inertia = bodies.local_inertia.data();
  args.motion = bodies.motion.data();
  args.step_notes = bodies.step_notes.data();
  args.flags = bodies.flags.data();
  args.may_sleep = settings.sleeping ? std::uint8_t{kBodyCanSleep} : std::uint8_t{0};
  args.force = bodies.force.data();
  args.center = &bodies.center.data()->x;
  args.transform = &bodies.transform.data()->position.x;
  args.sleep_timer = bodies.sleep_time.data();
  args.drift = bodies.drift.data();
  args.mass = bodies.mass.data();
  args.kinetic_energy = constraints.kinetic_energy.data();
  args.non_finite = constraints.non_finite.data();
  args.gravity[0] = settings.gravity.x;
  args.gravity[1] = settings.gravity.y;
  args.gravity[2] = settings.gravity.z;
  args.substep = substep_of(data, dt);
  args.step = dt;
  args.max_linear_speed = settings.max_linear_speed;
  args.max_angular_speed = settings.max_angular_speed;
  args.sleep_time = std::max(settings.sleep_time, dt);  // at least one step
  args.sleep_linear_speed = settings.sleep_linear_speed;
  args.sleep_angular_speed = settings.sleep_angular_speed;
  args.warm_start = settings.warm_start;
  args.flies_on_parabolas = settings.solver != Solver::sequential_impulse;
  return args;
}

simd::JointArgs joint_args(WorldData& data, Constraints& constraints, float dt) {
  const WorldSettings& settings = data.settings;
  const float substep = substep_of(data, dt);
  simd::JointArgs args{};
  args.rows = constraints.joint_lanes.data();
  args.blocks = constraints.blocks.data();
  args.frames = data.joints.frames.data();
  args.parameters = data.joints.parameters.data();
  args.user = data.joints.user.data();
  args.user_state = data.user_joints.state.data();
  args.user_jacobians = data.user_joints.jacobians.data();
  args.user_targets = data.user_joints.targets.data();
  args.user_bounds = data.user_joints.bounds.data();
  args.impulses = data.joints.impulses.data();
  args.reactions = data.joints.reaction.data();
  args.pose = data.bodies.pose.data();
  args.velocity = data.bodies.velocity.data();
  args.delta = data.bodies.delta.data();
  args.joint_count = constraints.joint_count.data();
  args.inertia = data.bodies.inertia.data();
  args.substep = substep;
  args.inverse_substep = 1.0f / substep;
  args.max_hertz = kJointStiffness / substep;
  args.stiff = simd::soften(args.max_hertz, kJointDampingRatio, substep);
  args.max_hertz_shared = kSharedJointStiffness / substep;
  args.stiff_shared = simd::soften(args.max_hertz_shared, kJointDampingRatio, substep);
  if (settings.solver == Solver::sequential_impulse)
    args.stiff = args.stiff_shared = stabilized(settings, substep);
  args.push_speed = settings.push_speed;
  args.warm_start_scale = settings.warm_start ? warm_start_scale(substep, data.last_substep) : 0.0f;
  args.impulse_keep = keeps_impulses(settings) ? 1.0f : 0.0f;
  args.parts_a = constraints.parts_a.data();
  args.parts_b = constraints.parts_b.data();
  args.shared = constraints.shared.data();
  args.residual = constraints.residual.data();
  return args;
}

namespace {

// Lists the bodies that move, dynamic ones first, and gives the columns that kernels write to their sizes.
void size_columns(const WorldData& data, Constraints& constraints) {
  const Bodies& bodies = data.bodies;
  const std::size_t dynamic_count = bodies.awake.size();
  constraints.moving_bodies.resize_discarding(dynamic_count + bodies.kinematic.size());
  std::copy(bodies.awake.begin(), bodies.awake.end(), constraints.moving_bodies.begin());
  std::copy(bodies.kinematic.begin(), bodies.kinematic.end(),
            constraints.moving_bodies.begin() + dynamic_count);
  const std::size_t chunk_count = constraints.contact_chunks.size() + constraints.joint_chunks.size();
  constraints.residual.resize_discarding(chunk_count);
  constraints.shared.resize_discarding(chunk_count);
  constraints.parts_a.resize_discarding(constraints.joint_lanes.size());
  constraints.parts_b.resize_discarding(constraints.joint_lanes.size());
  if (asks_for_events(data)) constraints.impulse_sum.resize_discarding(constraints.contact_lanes.size());
  if (data.settings.contact_forces)
    constraints.force_sum.resize_discarding(constraints.contact_lanes.size() * simd::kForceFields);
}

}  // namespace

void solve_soft_step(SolveStep& step) {
  using ByContact = simd::ContactKernels;
  using ByJoint = simd::JointVariantKernels;
  const simd::Kernels& kernels = step.crew.kernels();
  const WorldSettings& settings = step.data.settings;
  const bool together = settings.solver_options.points_together;
  const ContactPass solve = together ? &ByContact::solve_together : &ByContact::solve;
  const ContactPass relax = together ? &ByContact::relax_together : &ByContact::relax;
  const ContactPass relax_measured = together ? &ByContact::relax_together : &ByContact::relax_measured;
  for (int substep = 0; substep < settings.substeps; ++substep) {
    step.body.first_substep = step.contact.first_substep = substep == 0;
    step.body.elapsed = static_cast<float>(substep) * step.body.substep;
    step.joint.elapsed = static_cast<float>(substep) * step.joint.substep;
    const bool measured = settings.measure_residual && substep == settings.substeps - 1;
    rebound(step);
    over_bodies(step, step.dynamic_count, kernels.body.integrate_velocities, "integrate_velocities");
    if (substep == 0 && step.contact.warm_start_scale > 0.0f)
      over_colors(step, &ByContact::warm_start, &ByJoint::warm_start, "warm_start");
    over_colors(step, solve, &ByJoint::solve, "solve_softly");
    over_bodies(step, step.moving_count, kernels.body.integrate_poses, "integrate_poses");
    step.joint.elapsed = static_cast<float>(substep + 1) * step.joint.substep;
    if (measured) {
      over_colors(step, relax_measured, &ByJoint::relax_measured, "relax");
    } else {
      over_colors(step, relax, &ByJoint::relax, "relax");
    }
  }
  if (!settings.measure_residual) return;
  for (const float residual : step.constraints.residual)
    step.data.stats.residual = std::max(step.data.stats.residual, static_cast<double>(residual));
}

SolveStep prepare_solve(WorldData& data, float dt, Crew& crew) {
  Constraints& constraints = constraints_of(data);
  const simd::Kernels& kernels = crew.kernels();
  size_columns(data, constraints);
  SolveStep step{data,
                 constraints,
                 crew,
                 static_cast<int>(data.bodies.awake.size()),
                 static_cast<int>(constraints.moving_bodies.size()),
                 body_args(data, dt),
                 contact_args(data, constraints, dt),
                 joint_args(data, constraints, dt)};
  over_bodies(step, step.moving_count, kernels.body.prepare, "prepare_bodies");
  over_blocks(
      constraints, crew,
      [&](const simd::ConstraintChunk& chunk) { kernels.contact.prepare(step.contact, chunk); },
      [&](const simd::ConstraintChunk& chunk) {
        kernels.joint.variant[chunk.variant].prepare(step.joint, chunk);
      });
  if (Border* const border = border_of(data)) {
    share_notes(constraints, *border, static_cast<std::int32_t>(data.contacts.active.size()), data.bodies);
  }
  begin_rebounds(step);
  return step;
}

namespace {

// Each rank has found that of the constraints that it knows.
void share_residual(WorldData& data) {
  Border* const border = border_of(data);
  if (border == nullptr || !data.settings.measure_residual) return;
  for (const double of_rank : gather_rows(border->transport, data.stats.residual))
    data.stats.residual = std::max(data.stats.residual, of_rank);
}

}  // namespace

void solve(WorldData& data, float dt, Crew& crew) {
  SolveStep step = prepare_solve(data, dt, crew);
  switch (data.settings.solver) {
    case Solver::soft_step:
      solve_soft_step(step);
      return share_residual(data);
    case Solver::sequential_impulse:
      solve_sequential_impulses(step);
      return share_residual(data);
    default:
      return solve_whole_system(step);
  }
}

}  // namespace scree
