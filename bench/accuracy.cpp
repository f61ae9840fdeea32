// The accuracy suite (tools/accuracy) in every engine that CMake found: each behind the adapter of the
// benchmark, with its own default settings.
#include <tools/command/accuracy.h>
#include <tools/files/output_file.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>
#include <utility>

#include "bench/engine.h"

namespace scree::bench {
namespace {

class EngineSimulation final : public accuracy::Simulation {
 public:
  EngineSimulation(const EngineInfo& info, const scenes::Scene& scene, const accuracy::Backend& backend)
      : scene_(scene) {
    check_scene(info, scene);
    const EngineOptions options{
        .threads = info.multithreaded ? Workers(backend.threads).threads() : 1,
        .isa = backend.isa,
        .continuous = scene.settings.continuous,
    };
    engine_ = info.create({&scene_, 1}, options);
  }

  void step(float dt) override { engine_->step(dt); }
  void move_kinematic(std::uint32_t body, const Pose& target, float dt) override {
    engine_->move_kinematic(0, body, target, dt);
  }
  void push(std::uint32_t body, Vec3 force) override { engine_->push(0, body, force); }
  void read(std::vector<accuracy::BodyMotion>& bodies) const override {
    std::vector<BodyState> states;
    engine_->read(0, states);
    bodies.clear();
    for (const BodyState& state : states) {
      bodies.push_back({state.pose, state.linear_velocity, state.angular_velocity});
    }
  }

 private:
  scenes::Scene scene_;  // the adapter refers to it
  std::unique_ptr<Engine> engine_;
};

// Scree itself runs as in the command, which measures the contact forces, too.
std::vector<accuracy::EngineChoice> choices() {
  std::vector<accuracy::EngineChoice> result{accuracy::scree_engine(SCREE_BENCH_VERSION)};
  for (const EngineInfo& info : engines()) {
    if (info.name == "scree") continue;
    result.push_back({info.name, info.title, info.substeps,
                      [&info](const scenes::Scene& scene,
                              const accuracy::Backend& backend) -> std::unique_ptr<accuracy::Simulation> {
                        return std::make_unique<EngineSimulation>(info, scene, backend);
                      }});
  }
  return result;
}

}  // namespace
}  // namespace scree::bench

int main(int argc, char** argv) {
  scree::files::prepare_process();
  CLI::App app("Measures the errors of physics engines against known truth.", "scree_bench_accuracy");
  scree::command::AccuracyArguments arguments;
  scree::command::declare_accuracy(app, arguments, true);
  CLI11_PARSE(app, argc, argv);
  try {
    scree::command::run_accuracy(arguments, scree::bench::choices(), SCREE_BENCH_VERSION);
  } catch (const scree::Error& error) {
    std::cerr << "scree_bench_accuracy: " << error.what() << "\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "scree_bench_accuracy: " << error.what() << "\n";
    return 1;
  }
}
