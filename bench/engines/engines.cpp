// The list of the engines that CMake found, and what their adapters share.
#include "bench/engine.h"

#include <core/geometry/mesh/mesh_build.h>

#include <algorithm>
#include <cmath>
#include <variant>

namespace scree::bench {
namespace {

constexpr std::uint32_t kRules = 8;  // room for them in a code

float mixed(MixRule rule, float a, float b) {
  switch (rule) {
    case MixRule::minimum:
      return std::min(a, b);
    case MixRule::average:
      return 0.5f * (a + b);
    case MixRule::product:
      return a * b;
    case MixRule::geometric_mean:
      return std::sqrt(a * b);
    case MixRule::maximum:
      break;
  }
  return std::max(a, b);
}

}  // namespace

const std::vector<EngineInfo>& engines() {
  static const std::vector<EngineInfo> kEngines = {
      scree_engine(),
#ifdef SCREE_BENCH_BOX3D
      box3d_engine(),
#endif
#ifdef SCREE_BENCH_JOLT
      jolt_engine(),
#endif
#ifdef SCREE_BENCH_BULLET
      bullet_engine(),
#endif
#ifdef SCREE_BENCH_ODE
      ode_engine(),
#endif
  };
  return kEngines;
}

void Engine::make_change(std::size_t, const scenes::SceneChange&) {
  unsupported("this engine", "bodies that come and go");
}

void Engine::push(std::size_t, std::uint32_t, Vec3) { unsupported("this engine", "forces"); }

void unsupported(const std::string& engine, const std::string& what) {
  throw Error("the adapter of " + engine + " does not support " + what);
}

void refuse_mesh_materials(const std::string& engine, const TriangleMesh& mesh) {
  if (!MeshAccess::solid(mesh)->columns.material.empty())
    unsupported(engine, "triangles with materials of their own");
}

void check_scene(const EngineInfo& info, const scenes::Scene& scene) {
  if (!info.joints && !scene.joints.empty()) unsupported(info.title, "joints");
  if (!info.changes && !scene.changes.empty()) unsupported(info.title, "bodies that come and go");
  for (const scenes::SceneShape& shape : scene.shapes) {
    const auto* const box = std::get_if<Box>(&shape.geometry);
    const auto* const convex = std::get_if<ConvexHull>(&shape.geometry);
    if (std::holds_alternative<Cylinder>(shape.geometry) || std::holds_alternative<Cone>(shape.geometry) ||
        (box != nullptr && box->rounding > 0.0f) || (convex != nullptr && convex->rounding > 0.0f))
      unsupported(info.title, "cylinders, cones and roundings");
  }
}

std::uint32_t mix_code(const Material& material) {
  return kRules * static_cast<std::uint32_t>(material.friction_mix) +
         static_cast<std::uint32_t>(material.restitution_mix);
}

std::uint32_t default_mix_code() { return mix_code({}); }

bool mixes_otherwise(const scenes::Scene& scene) {
  return std::any_of(scene.shapes.begin(), scene.shapes.end(), [](const scenes::SceneShape& shape) {
    return mix_code(shape.material) != default_mix_code();
  });
}

// Of two rules the later one counts.
float mixed_friction(float a, std::uint32_t code_a, float b, std::uint32_t code_b) {
  return mixed(static_cast<MixRule>(std::max(code_a / kRules, code_b / kRules)), a, b);
}

float mixed_restitution(float a, std::uint32_t code_a, float b, std::uint32_t code_b) {
  return mixed(static_cast<MixRule>(std::max(code_a % kRules, code_b % kRules)), a, b);
}

}  // namespace scree::bench
