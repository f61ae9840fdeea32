// What a shape shares with others, whatever it is: the slot of its hull or of its mesh.
#pragma once

#include <core/world/check.h>
#include <core/world/world_data.h>

#include <cstddef>
#include <cstdint>

namespace scree {

struct SolidSlots {
  std::int32_t hull = -1, mesh = -1;  // -1: none
};
// How many slots there were before a call.
struct SolidSlotCounts {
  std::size_t hulls, meshes;

  explicit SolidSlotCounts(const WorldData& data)
      : hulls(data.hulls.shared.size()), meshes(data.meshes.shared.size()) {}
};

inline bool has_slot(const Geometry& geometry) {
  return std::holds_alternative<ConvexHull>(geometry) || std::holds_alternative<TriangleMesh>(geometry);
}

// Counts one more shape for the slot of the geometry, and makes the slot if there is none. Throws if a scaled
// hull exceeds a limit, and then changes nothing. The geometry must have been checked.
SolidSlots acquire_slots(Call call, WorldData& data, const Geometry& geometry);
void release_slots(WorldData& data, const SolidSlots& slots);
// Undoes acquire_slots, the latest call first.
void undo_slots(WorldData& data, const SolidSlots& slots, const SolidSlotCounts& before);

inline SolidSlots slots_of(const Shapes& shapes, std::int32_t shape) {
  return {shapes.hull[shape], shapes.mesh[shape]};
}
// The origin of the shape's frame in that of its hull or mesh as it was given; null for other shapes.
const double* origin_of_solid(const WorldData& data, std::int32_t shape);

}  // namespace scree
