// Engines: the small interface behind which every engine of the comparison stands.
//
// An adapter builds its worlds from scenes, steps them and tells where the bodies are; it judges nothing.
// Each one lives in a file of its own under engines/ and is compiled only if CMake finds its engine.
#pragma once

#include "bench/evaluate.h"
#include "tools/scenes/scene.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace scree::bench {

struct EngineOptions {
  int threads = 1;           ///< that work on a step, the calling one included
  Isa isa = Isa::automatic;  ///< Scree only
  bool continuous = false;   ///< continuous collision on
};

/// One or more worlds in one engine.
class Engine {
 public:
  virtual ~Engine() = default;

  /// Advances every world by `dt`: what the clock measures.
  virtual void step(float dt) = 0;
  /// Before a step of `dt`: has that step move a kinematic body to `target`, so that others feel its motion.
  virtual void move_kinematic(std::size_t world, std::uint32_t body, const Pose& target, float dt) = 0;
  /// Between steps: has bodies of the scene come, or go. The clock measures this, too. Unless the adapter has
  /// EngineInfo::changes it throws.
  virtual void make_change(std::size_t world, const scenes::SceneChange& change);
  /// The bodies of one world in the scene's order.
  virtual void read(std::size_t world, std::vector<BodyState>& states) const = 0;
  /// Contacts as the engine itself counts them, or -1. Definitions differ: comparisons take the evaluator's.
  virtual std::int64_t contacts() const { return -1; }
  /// What the engine calls the parts of its last step, in milliseconds.
  virtual std::vector<std::pair<std::string, double>> phases() const { return {}; }
  /// What the engine used where the request left it a choice, for example the instruction set.
  virtual std::string variant() const { return {}; }
  /// Anything that makes the run unfair or wrong, for example dropped contacts; empty if all is well.
  virtual std::string complaint() const { return {}; }
};

struct EngineInfo {
  std::string name;        ///< as given to --engines
  std::string title;       ///< with its version
  std::string settings;    ///< solver settings and what differs from the engine's defaults
  std::string continuous;  ///< what continuous collision is with this engine; empty if it has none
  bool multithreaded = true;
  bool joints = false;   ///< the adapter knows (some) joints
  bool changes = false;  ///< the adapter lets bodies come and go while a scene runs
  std::unique_ptr<Engine> (*create)(std::span<const scenes::Scene> scenes, const EngineOptions& options);
};

/// The engines that this program was built with, Scree first.
const std::vector<EngineInfo>& engines();

/// Throws scree::Error: the adapter of `engine` cannot build the scene because of `what`.
[[noreturn]] void unsupported(const std::string& engine, const std::string& what);

EngineInfo scree_engine();
EngineInfo box3d_engine();
EngineInfo jolt_engine();
EngineInfo bullet_engine();
EngineInfo ode_engine();

}  // namespace scree::bench
