// The list of the engines that CMake found.
#include "bench/engine.h"

namespace scree::bench {

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

}  // namespace scree::bench
