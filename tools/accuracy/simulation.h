// What the accuracy suite needs of an engine, and a scene that runs in one.
//
// Scree's own adapter is here; bench/accuracy.cpp adds the engines that the benchmark knows. All see the same
// scenes.
#pragma once

#include <tools/scenes/scene.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace scree::accuracy {

/// A body as an engine reports it.
struct BodyMotion {
  Pose pose;              ///< of the body's origin
  Vec3 linear_velocity;   ///< of the center of mass, m/s
  Vec3 angular_velocity;  ///< rad/s, world axes
};

/// A scene in an engine.
class Simulation {
 public:
  virtual ~Simulation() = default;
  virtual void step(float dt) = 0;  ///< the timed call
  /// Call before a step: it moves a kinematic body to the target.
  virtual void move_kinematic(std::uint32_t body, const Pose& target, float dt) = 0;
  /// Call before a step: a force (N) on the body's center of mass in that step.
  virtual void push(std::uint32_t body, Vec3 force) = 0;
  /// The bodies in the scene's order.
  virtual void read(std::vector<BodyMotion>& bodies) const = 0;
  /// N, the mean contact force of one body on another in the last step of `dt`, while the scene's settings
  /// ask for contact forces; empty where the engine does not give it.
  virtual std::optional<Vec3> contact_force(std::uint32_t from, std::uint32_t on, float dt) const;
};

struct Backend {
  int threads = 1;
  Isa isa = Isa::automatic;              ///< Scree only
  std::optional<float> contact_hertz{};  ///< Hz, Scree only; else the default of WorldSettings
  std::optional<Solver> solver{};        ///< Scree only; else the default of WorldSettings
  std::optional<int> iterations{};       ///< SolverOptions::iterations, Scree only; else the default
};

/// An engine that can run the suite.
struct EngineChoice {
  std::string name;       ///< as given to --engines
  std::string title;      ///< with its version
  bool substeps = false;  ///< it has substeps; else they are ignored, and each time step runs once
  std::function<std::unique_ptr<Simulation>(const scenes::Scene& scene, const Backend& backend)> create;
};

/// Scree itself. `version` as the program knows it.
EngineChoice scree_engine(const std::string& version);

/// One run of a case: the engine and its steps, and the time that all its trials took.
struct Run {
  const EngineChoice* engine = nullptr;
  Backend backend;
  double dt = 1.0 / 60.0;  ///< s
  int substeps = 4;
  double step_seconds = 0.0;       ///< real time within the step calls, all trials
  double simulated_seconds = 0.0;  ///< all trials
};

/// A scene that runs in the engine of a run. Bodies do not sleep: the suite measures motion. The substeps are
/// the run's.
class Trial {
 public:
  Trial(Run& run, scenes::Scene scene);
  ~Trial();
  Trial(const Trial&) = delete;
  Trial& operator=(const Trial&) = delete;

  /// Moves the scene's driven bodies, steps and reads the bodies.
  void step();
  void push(std::uint32_t body, Vec3 force) { simulation_->push(body, force); }
  const BodyMotion& body(std::uint32_t index) const { return bodies_[index]; }
  const scenes::Scene& scene() const { return scene_; }
  std::optional<Vec3> contact_force(std::uint32_t from, std::uint32_t on) const;
  /// s, simulated so far.
  double time() const { return static_cast<double>(steps_) * static_cast<double>(dt_); }
  int steps() const { return steps_; }
  /// The number of steps nearest to that many seconds, at least 1.
  int steps_in(double seconds) const;

 private:
  Run& run_;
  scenes::Scene scene_;
  float dt_;
  std::unique_ptr<Simulation> simulation_;
  std::vector<BodyMotion> bodies_;
  int steps_ = 0;
};

}  // namespace scree::accuracy
