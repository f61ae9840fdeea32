// Runs a scene under each solver; see compare.h.
#include <tools/compare/compare.h>
#include <tools/scenes/stage.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace scree::comparison {
namespace {

constexpr int kRepeats = 3;         // of timed steps
constexpr int kMeasuredSteps = 10;  // of a run, every so many; they are not timed
constexpr int kMostSubsteps = 64;   // WorldSettings' limit

struct Run {
  Run(const scenes::Scene& of, Solver solver, int iterations) : scene(of) {
    WorldSettings settings = of.settings;
    settings.sleeping = false;
    settings.solver = solver;
    settings.solver_options.iterations = iterations;
    world.set_settings(settings);
    bodies = scenes::populate(world, scene, &joints);
  }
  void step_once(int steps_done, float dt, Workers& workers) {
    scenes::direct(world, scene, bodies, steps_done, dt);
    step(world, dt, workers);
  }

  const scenes::Scene& scene;
  World world;
  std::vector<BodyId> bodies;
  std::vector<JointId> joints;
};

bool is_dynamic(const World& world, BodyId body) {
  return world.is_alive(body) && world.body_type(body) == BodyType::dynamic;
}

double length_of(Vec3 v) {
  return std::hypot(static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z));
}

std::vector<Vec3> places(const Run& run) {
  std::vector<Vec3> list;
  for (const BodyId body : run.bodies) {
    if (is_dynamic(run.world, body)) list.push_back(run.world.center_of_mass(body));
  }
  return list;
}

double mean_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  if (a.size() != b.size()) return -1;  // bodies came or went
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += length_of(a[i] - b[i]);
  return a.empty() ? 0 : sum / static_cast<double>(a.size());
}

double energy(const Run& run) {
  const Vec3 gravity = run.world.settings().gravity;
  double sum = 0;
  for (const BodyId body : run.bodies) {
    if (!is_dynamic(run.world, body)) continue;
    const MassProperties mass = run.world.mass_properties(body);
    const auto m = static_cast<double>(mass.mass);
    const Vec3 at = run.world.center_of_mass(body), v = run.world.linear_velocity(body);
    const Vec3 w = rotate_back(run.world.pose(body).rotation, run.world.angular_velocity(body));
    const auto& i = mass.inertia;
    const Vec3 spin{i[0] * w.x + i[3] * w.y + i[4] * w.z, i[3] * w.x + i[1] * w.y + i[5] * w.z,
                    i[4] * w.x + i[5] * w.y + i[2] * w.z};
    sum += 0.5 * m * static_cast<double>(dot(v, v)) + 0.5 * static_cast<double>(dot(w, spin)) -
           m * static_cast<double>(dot(gravity, at));
  }
  return sum;
}

// Balls, hinges and welds keep two points together.
double joint_error(const Run& run) {
  double largest = 0;
  for (std::size_t i = 0; i < run.joints.size(); ++i) {
    if (!run.world.is_alive(run.joints[i])) continue;
    const Joint& joint = run.scene.joints[i].joint;
    if (!std::holds_alternative<BallJoint>(joint) && !std::holds_alternative<HingeJoint>(joint) &&
        !std::holds_alternative<WeldJoint>(joint)) {
      continue;
    }
    const JointDef def = run.world.joint_def(run.joints[i]);
    const auto anchor = [&](BodyId body, const Pose& frame) {
      return body == kWorld ? frame.position : transform(run.world.pose(body), frame.position);
    };
    largest = std::max(largest, length_of(anchor(def.body_b, def.frame_b) - anchor(def.body_a, def.frame_a)));
  }
  return largest;
}

void measure_run(const scenes::Scene& scene, const CompareOptions& options, Workers& workers,
                 SolverFigures& figures, std::vector<Vec3>& end) {
  Run run(scene, figures.solver, options.iterations);
  const std::vector<Vec3> start = places(run);
  const double energy_before = energy(run);
  double milliseconds = 0;
  int measured = 0, timed = 0;
  for (int i = 0; i < options.steps; ++i) {
    const bool is_last = i + 1 == options.steps, measures = is_last || i % kMeasuredSteps == 0;
    WorldSettings settings = run.world.settings();
    settings.measure_residual = measures;
    settings.measure_penetration = is_last;
    run.world.set_settings(settings);
    run.step_once(i, options.dt, workers);
    const StepStats& stats = run.world.stats();
    figures.restored_bodies += stats.restored_bodies;
    if (measures) {
      figures.residual += stats.residual;
      ++measured;
    } else {
      milliseconds += stats.step_ms;
      ++timed;
    }
  }
  end = places(run);
  figures.ms_per_step = milliseconds / std::max(timed, 1);
  figures.residual /= measured;
  figures.penetration_mean = run.world.stats().penetration_mean;
  figures.penetration_max = run.world.stats().penetration_max;
  figures.moved = mean_distance(start, end);
  figures.joint_error = joint_error(run);
  figures.energy_change = energy(run) - energy_before;
}

// The soft step has no iterations: its substeps take their place, and keep the stored impulses, as it is
// never run without them.
WorldSettings settings_for(const WorldSettings& of_scene, Solver solver, int count) {
  WorldSettings settings = of_scene;
  settings.solver = solver;
  settings.substeps = solver == Solver::soft_step ? count : 1;
  settings.warm_start = solver == Solver::soft_step;
  settings.solver_options.iterations = count;
  settings.solver_options.tolerance = solver == Solver::direct ? 1e-9f : 0.0f;
  return settings;
}

void measure_convergence(World& world, const Snapshot& state, const CompareOptions& options,
                         const WorldSettings& of_scene, Workers& workers, SolverFigures& figures) {
  for (const int count : options.counts) {
    if (figures.solver == Solver::soft_step && count > kMostSubsteps) break;
    ConvergencePoint point{count, 0, std::numeric_limits<double>::infinity()};
    const auto take = [&](bool measures) {
      restore(world, state);
      WorldSettings settings = settings_for(of_scene, figures.solver, count);
      settings.measure_residual = measures;
      world.set_settings(settings);
      step(world, options.dt, workers);
    };
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
      take(false);
      point.milliseconds =
          std::min(point.milliseconds, world.stats().phase_ms[static_cast<int>(Phase::solve)]);
    }
    take(true);
    point.residual = world.stats().residual;
    if (figures.solver == Solver::direct) point.iterations = world.stats().solver_iterations;
    figures.convergence.push_back(point);
    if (figures.solver == Solver::direct) break;  // takes what it needs
  }
}

}  // namespace

CompareFigures compare(const std::vector<scenes::Scene>& worlds, const CompareOptions& options) {
  if (worlds.size() != 1) {
    throw Error("compare: the scene " + worlds.front().name + " consists of " +
                std::to_string(worlds.size()) + " worlds; say --set worlds=1");
  }
  const scenes::Scene& scene = worlds.front();
  Workers workers(WorkersOptions{.threads = options.threads, .isa = options.isa});
  CompareFigures figures;
  figures.scene = scene.name;
  figures.steps = options.steps;
  figures.at = options.at;
  figures.iterations = options.iterations;
  figures.dt = static_cast<double>(options.dt);
  Run usual(scene, Solver::soft_step, options.iterations);
  for (int i = 0; i < options.at; ++i) usual.step_once(i, options.dt, workers);
  for (const BodyId body : usual.bodies) figures.bodies += is_dynamic(usual.world, body) ? 1 : 0;
  figures.joints = static_cast<std::int64_t>(usual.world.joint_count());
  Snapshot state;
  save(usual.world, state);
  const WorldSettings of_scene = usual.world.settings();
  std::vector<std::vector<Vec3>> ends;
  for (const Solver solver : options.solvers) {
    SolverFigures& of_solver = figures.solvers.emplace_back();
    of_solver.solver = solver;
    measure_convergence(usual.world, state, options, of_scene, workers, of_solver);
    measure_run(scene, options, workers, of_solver, ends.emplace_back());
  }
  const auto exact = std::find(options.solvers.begin(), options.solvers.end(), Solver::direct);
  if (exact != options.solvers.end()) {
    const std::vector<Vec3>& truth = ends[static_cast<std::size_t>(exact - options.solvers.begin())];
    for (std::size_t i = 0; i < ends.size(); ++i)
      figures.solvers[i].off_exact = mean_distance(ends[i], truth);
  }
  return figures;
}

}  // namespace scree::comparison
