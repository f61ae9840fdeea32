// Scenes: engine-neutral lists of bodies that tests, benchmarks and the command share.
//
// A scene is data: whoever wants it in an engine walks the lists (populate() does it for Scree, bench/ for
// the peers). A few scenes consist of many independent worlds, hence the vector.
#pragma once

#include <scree/scree.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace scree::scenes {

struct SceneShape {
  Geometry geometry;
  Material material;
  ShapeOptions options;
};

/// A body and its run of shapes. Bodies may share a run: equal bricks need one entry in Scene::shapes.
struct SceneBody {
  BodyDef def;
  std::uint32_t first_shape = 0;  ///< into Scene::shapes
  std::uint32_t shape_count = 0;
};

struct Scene {
  std::string name;
  WorldSettings settings;
  std::vector<SceneShape> shapes;
  std::vector<SceneBody> bodies;
  int steps = 200;  ///< a sensible length, the protocol's where the scene comes from a published benchmark
  float dt = 1.0f / 60.0f;
};

/// Parameters by name, as `--set key=value` gives them. A builder rejects names that it does not know.
using Parameters = std::map<std::string, double>;

struct SceneInfo {
  std::string name;
  std::string summary;    ///< one line
  Parameters parameters;  ///< names and defaults
};

/// The built-in scenes in the order in which they are listed.
const std::vector<SceneInfo>& catalog();

/// Builds a built-in scene; one element, or one per world. Throws scree::Error for an unknown name or
/// parameter and for impossible values.
std::vector<Scene> build(const std::string& name, const Parameters& parameters = {});

/// Creates the scene's bodies in an empty world; returns their handles in the scene's order.
std::vector<BodyId> populate(World& world, const Scene& scene);

}  // namespace scree::scenes
