// See solid_slots.h.
#include <core/geometry/hull/hull_build.h>
#include <core/geometry/hull/hull_store.h>
#include <core/geometry/mesh/mesh_build.h>
#include <core/geometry/mesh/mesh_store.h>
#include <core/geometry/solid_slots.h>
#include <core/world/content_slots.h>

namespace scree {

SolidSlots acquire_slots(Call call, WorldData& data, const Geometry& geometry) {
  return {acquire_hull(call, data.hulls, geometry), acquire_mesh(data.meshes, geometry)};
}

void release_slots(WorldData& data, const SolidSlots& slots) {
  release_slot(data.hulls, slots.hull);
  release_slot(data.meshes, slots.mesh);
}

void undo_slots(WorldData& data, const SolidSlots& slots, const SolidSlotCounts& before) {
  undo_slot(data.hulls, slots.hull, before.hulls);
  undo_slot(data.meshes, slots.mesh, before.meshes);
}

const double* origin_of_solid(const WorldData& data, std::int32_t shape) {
  const auto [hull, mesh] = slots_of(data.shapes, shape);
  if (hull >= 0) return data.hulls.shared[static_cast<std::size_t>(hull)].solid->origin;
  if (mesh >= 0) return data.meshes.shared[static_cast<std::size_t>(mesh)].solid->origin;
  return nullptr;
}

}  // namespace scree
