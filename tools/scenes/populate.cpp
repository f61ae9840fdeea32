// Scene -> world.
#include <tools/scenes/scene.h>

#include <algorithm>

namespace scree::scenes {
namespace {

constexpr std::size_t kBatch = 1u << 16;  // bodies a bulk call; bounds the copies of their definitions

bool same_surface(const SceneShape& left, const SceneShape& right) {
  return left.material == right.material && left.options == right.options;
}

// How many bodies from `first` on have one shape each and one surface in common.
std::size_t bulk_run(const Scene& scene, std::size_t first) {
  const std::size_t last = std::min(scene.bodies.size(), first + kBatch);
  std::size_t end = first;
  while (end < last && scene.bodies[end].shape_count == 1 &&
         same_surface(scene.shapes[scene.bodies[end].first_shape],
                      scene.shapes[scene.bodies[first].first_shape])) {
    ++end;
  }
  return end - first;
}

}  // namespace

std::vector<BodyId> populate(World& world, const Scene& scene) {
  std::vector<BodyId> ids(scene.bodies.size());
  std::vector<BodyDef> defs;
  std::vector<Geometry> geometries;
  for (std::size_t i = 0; i < scene.bodies.size();) {
    const std::size_t run = bulk_run(scene, i);
    if (run > 1) {
      defs.clear();
      geometries.clear();
      for (std::size_t k = i; k < i + run; ++k) {
        defs.push_back(scene.bodies[k].def);
        geometries.push_back(scene.shapes[scene.bodies[k].first_shape].geometry);
      }
      const SceneShape& first = scene.shapes[scene.bodies[i].first_shape];
      world.create_bodies(defs, geometries, first.material, first.options, std::span(ids).subspan(i, run));
      i += run;
      continue;
    }
    const SceneBody& body = scene.bodies[i];
    ids[i] = world.create_body(body.def);
    for (std::uint32_t k = 0; k < body.shape_count; ++k) {
      const SceneShape& shape = scene.shapes[body.first_shape + k];
      world.add_shape(ids[i], shape.geometry, shape.material, shape.options);
    }
    ++i;
  }
  return ids;
}

}  // namespace scree::scenes
