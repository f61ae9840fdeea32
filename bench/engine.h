// Engines: the small interface that every engine of the comparison implements.
//
// An adapter builds its worlds from scenes, steps them and reports the bodies' states; it evaluates nothing.
// Each adapter has a file of its own under engines/ and is compiled only if CMake finds its engine.
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
  int threads = 1;           ///< that work on a step, including the calling one
  Isa isa = Isa::automatic;  ///< Scree only
  bool continuous = false;   ///< continuous collision on
};

/// One or more worlds in one engine.
class Engine {
 public:
  virtual ~Engine() = default;

  /// Advances every world by `dt`: the timed call.
  virtual void step(float dt) = 0;
  /// Call before a step of `dt`: that step moves a kinematic body to `target`, so that other bodies feel its
  /// motion.
  virtual void move_kinematic(std::size_t world, std::uint32_t body, const Pose& target, float dt) = 0;
  /// Call before a step: a force (N) on the body's center of mass during that step. Throws where the adapter
  /// has no such call.
  virtual void push(std::size_t world, std::uint32_t body, Vec3 force);
  /// Call between steps: creates or destroys bodies of the scene. The clock includes this call. Throws unless
  /// the adapter has EngineInfo::changes.
  virtual void make_change(std::size_t world, const scenes::SceneChange& change);
  /// The bodies of one world in the scene's order.
  virtual void read(std::size_t world, std::vector<BodyState>& states) const = 0;
  /// Dynamic bodies that are not asleep, as the engine has it.
  virtual std::int64_t awake() const = 0;
  /// Contacts as the engine itself counts them, or -1. Definitions differ: comparisons use the evaluator's
  /// count.
  virtual std::int64_t contacts() const { return -1; }
  /// The parts of the engine's last step by its own names, in milliseconds.
  virtual std::vector<std::pair<std::string, double>> phases() const { return {}; }
  /// Choices that the engine made itself, for example the instruction set.
  virtual std::string variant() const { return {}; }
  /// Any condition that makes the run unfair or wrong, for example dropped contacts; empty if there is none.
  virtual std::string complaint() const { return {}; }
};

struct EngineInfo {
  std::string name;        ///< as given to --engines
  std::string title;       ///< with its version
  std::string settings;    ///< solver settings and what differs from the engine's defaults
  std::string continuous;  ///< what continuous collision is with this engine; empty if it has none
  bool multithreaded = true;
  bool substeps = false;  ///< the scene's substeps count
  bool joints = false;    ///< the adapter supports (some) joints
  bool changes = false;   ///< the adapter can create and destroy bodies while a scene runs
  std::unique_ptr<Engine> (*create)(std::span<const scenes::Scene> scenes, const EngineOptions& options);
};

/// The engines that this program was built with, Scree first.
const std::vector<EngineInfo>& engines();

/// Throws scree::Error: `what` stops the adapter of `engine` from building the scene.
[[noreturn]] void unsupported(const std::string& engine, const std::string& what);

/// Throws if triangles of the mesh have materials of their own: that they count is not in any adapter but
/// Scree's.
void refuse_mesh_materials(const std::string& engine, const TriangleMesh& mesh);

/// Throws scree::Error if the scene has joints or changes that the engine has not, or cylinders, cones or
/// roundings, which neither the adapters nor the evaluator have.
void check_scene(const EngineInfo& info, const scenes::Scene& scene);

/// A material's rules of mixing as a number that engines keep with their bodies or shapes.
std::uint32_t mix_code(const Material& material);
/// That of a material that asks for no other rules than those that the engines have as well.
std::uint32_t default_mix_code();
/// Whether any shape of the scene asks for other rules.
bool mixes_otherwise(const scenes::Scene& scene);
/// The values of two surfaces made one as their codes say.
float mixed_friction(float a, std::uint32_t code_a, float b, std::uint32_t code_b);
float mixed_restitution(float a, std::uint32_t code_a, float b, std::uint32_t code_b);

EngineInfo scree_engine();
EngineInfo box3d_engine();
EngineInfo jolt_engine();
EngineInfo bullet_engine();
EngineInfo ode_engine();

}  // namespace scree::bench
