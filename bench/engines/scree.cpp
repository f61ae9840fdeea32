// Scree behind the engine interface: all worlds of a scene share one Workers.
#include "bench/engine.h"

namespace scree::bench {
namespace {

class ScreeEngine final : public Engine {
 public:
  ScreeEngine(std::span<const scenes::Scene> scenes, const EngineOptions& options)
      : workers_(WorkersOptions{.threads = options.threads, .isa = options.isa}) {
    for (const scenes::Scene& scene : scenes) {
      WorldSettings settings = scene.settings;
      settings.continuous = options.continuous;
      worlds_.emplace_back(settings);
      bodies_.push_back(scenes::populate(worlds_.back(), scene));
    }
    scenes_ = scenes;
    for (World& world : worlds_) pointers_.push_back(&world);
  }

  void step(float dt) override { scree::step(pointers_, dt, workers_); }

  void move_kinematic(std::size_t world, std::uint32_t body, const Pose& target, float dt) override {
    worlds_[world].set_kinematic_target(bodies_[world][body], target, dt);
  }

  void push(std::size_t world, std::uint32_t body, Vec3 force) override {
    worlds_[world].add_force(bodies_[world][body], force);
  }

  void make_change(std::size_t world, const scenes::SceneChange& change) override {
    scenes::make_change(worlds_[world], scenes_[world], change, bodies_[world]);
  }

  void read(std::size_t world, std::vector<BodyState>& states) const override {
    const std::span<const Pose> poses = worlds_[world].poses();
    const std::span<const Velocity> velocities = worlds_[world].velocities();
    states.clear();
    for (const BodyId body : bodies_[world]) {
      if (!worlds_[world].is_alive(body)) {
        states.push_back({{}, {}, {}, false});
        continue;
      }
      const Velocity& velocity = velocities[body.index];
      states.push_back({poses[body.index], velocity.linear, velocity.angular});
    }
  }

  std::int64_t awake() const override {
    std::int64_t sum = 0;
    for (const World& world : worlds_) sum += world.stats().awake_bodies;
    return sum;
  }

  std::int64_t contacts() const override {
    std::int64_t sum = 0;
    for (const World& world : worlds_) sum += world.stats().contacts;
    return sum;
  }

  std::vector<std::pair<std::string, double>> phases() const override {
    std::vector<std::pair<std::string, double>> result;
    for (int phase = 0; phase < kPhaseCount; ++phase) {
      double sum = 0.0;
      for (const World& world : worlds_) sum += world.stats().phase_ms[phase];
      result.emplace_back(phase_name(static_cast<Phase>(phase)), sum);
    }
    return result;
  }

  std::string variant() const override { return isa_name(workers_.isa()); }

 private:
  Workers workers_;
  std::vector<World> worlds_;
  std::vector<World*> pointers_;  // to them
  std::span<const scenes::Scene> scenes_;
  std::vector<std::vector<BodyId>> bodies_;
};

}  // namespace

EngineInfo scree_engine() {
  return {.name = "scree",
          .title = "Scree " SCREE_BENCH_VERSION,
          .settings = "soft step, the scene's substeps (4 unless it says otherwise)",
          .continuous = "the cores of fast bodies are swept against fixed and sleeping ones",
          .multithreaded = true,
          .substeps = true,
          .joints = true,
          .changes = true,
          .create = [](std::span<const scenes::Scene> scenes, const EngineOptions& options)
              -> std::unique_ptr<Engine> { return std::make_unique<ScreeEngine>(scenes, options); }};
}

}  // namespace scree::bench
