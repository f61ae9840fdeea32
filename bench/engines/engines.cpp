// The list of the engines that CMake found, and what their adapters share.
#include "bench/engine.h"

#include <algorithm>
#include <cmath>

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
  if (has_materials(mesh)) unsupported(engine, "triangles with materials of their own");
}

void refuse_smooth_shapes(const Geometry& geometry) {
  const auto* const box = std::get_if<Box>(&geometry);
  const auto* const convex = std::get_if<ConvexHull>(&geometry);
  if (std::holds_alternative<Cylinder>(geometry) || std::holds_alternative<Cone>(geometry) ||
      (box != nullptr && box->rounding > 0.0f) || (convex != nullptr && convex->rounding > 0.0f)) {
    throw Error("the evaluation supports no cylinders, cones and roundings");
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
