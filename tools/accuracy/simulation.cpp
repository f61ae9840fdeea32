// Scree behind the suite's interface, and the trial that drives and times any engine.
#include <tools/accuracy/simulation.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace scree::accuracy {
namespace {

class ScreeSimulation final : public Simulation {
 public:
  ScreeSimulation(const scenes::Scene& scene, const Backend& backend)
      : workers_(WorkersOptions{.threads = backend.threads, .isa = backend.isa}), world_(scene.settings) {
    bodies_ = scenes::populate(world_, scene);
  }

  void step(float dt) override { scree::step(world_, dt, workers_); }
  void move_kinematic(std::uint32_t body, const Pose& target, float dt) override {
    world_.set_kinematic_target(bodies_[body], target, dt);
  }
  void push(std::uint32_t body, Vec3 force) override { world_.add_force(bodies_[body], force); }

  void read(std::vector<BodyMotion>& bodies) const override {
    bodies.clear();
    const std::span<const Pose> poses = world_.poses();
    const std::span<const Velocity> velocities = world_.velocities();
    for (const BodyId body : bodies_) {
      const Velocity& velocity = velocities[body.index];
      bodies.push_back({poses[body.index], velocity.linear, velocity.angular});
    }
  }

  std::optional<Vec3> contact_force(std::uint32_t from, std::uint32_t on, float dt) const override {
    if (!world_.settings().contact_forces) return std::nullopt;
    const BodyId receiver = bodies_[on];
    std::vector<ContactForces> contacts(world_.contact_forces_of(receiver, {}));
    world_.contact_forces_of(receiver, contacts);
    Vec3 impulse;
    for (const ContactForces& contact : contacts) {
      if (contact.body_a == bodies_[from]) impulse += impulse_on_b(contact);
      if (contact.body_b == bodies_[from]) impulse -= impulse_on_b(contact);
    }
    return impulse / dt;
  }

 private:
  Workers workers_;
  World world_;
  std::vector<BodyId> bodies_;
};

}  // namespace

std::optional<Vec3> Simulation::contact_force(std::uint32_t, std::uint32_t, float) const {
  return std::nullopt;
}

EngineChoice scree_engine(const std::string& version) {
  return {"scree", "Scree " + version, true,
          [](const scenes::Scene& scene, const Backend& backend) -> std::unique_ptr<Simulation> {
            return std::make_unique<ScreeSimulation>(scene, backend);
          }};
}

Trial::Trial(Run& run, scenes::Scene scene)
    : run_(run), scene_(std::move(scene)), dt_(static_cast<float>(run.dt)) {
  scene_.settings.substeps = run.substeps;
  scene_.settings.sleeping = false;
  if (run.backend.contact_hertz) scene_.settings.contact_hertz = *run.backend.contact_hertz;
  if (run.backend.solver) scene_.settings.solver = *run.backend.solver;
  if (run.backend.iterations) scene_.settings.solver_options.iterations = *run.backend.iterations;
  simulation_ = run.engine->create(scene_, run.backend);
  simulation_->read(bodies_);
}

Trial::~Trial() { run_.simulated_seconds += time(); }

void Trial::step() {
  const double end = static_cast<double>(steps_ + 1) * static_cast<double>(dt_);
  for (const scenes::SceneDrive& drive : scene_.drives) {
    simulation_->move_kinematic(drive.body, scenes::drive_target(drive, end), dt_);
  }
  const auto start = std::chrono::steady_clock::now();
  simulation_->step(dt_);
  run_.step_seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  ++steps_;
  simulation_->read(bodies_);
}

std::optional<Vec3> Trial::contact_force(std::uint32_t from, std::uint32_t on) const {
  return simulation_->contact_force(from, on, dt_);
}

int Trial::steps_in(double seconds) const {
  return std::max(1, static_cast<int>(std::lround(seconds / static_cast<double>(dt_))));
}

}  // namespace scree::accuracy
