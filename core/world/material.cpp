// See material.h.
#include <core/world/material.h>

namespace scree {

MaterialRow material_row(const Material& material) {
  MaterialRow row{};
  row.friction = material.friction;
  row.restitution = material.restitution;
  row.rolling_resistance = material.rolling_resistance;
  row.patch_radius = material.patch_radius.value_or(kAutomaticPatch);
  row.rules = static_cast<std::uint32_t>(material.friction_mix) |
              static_cast<std::uint32_t>(material.restitution_mix) << 8;
  if (material.patch_radius) row.rules |= kMaterialPatch;
  if (material.surface_velocity != Vec3{}) row.rules |= kMaterialMoves;
  for (int axis = 0; axis < 3; ++axis) row.surface_velocity[axis] = material.surface_velocity[axis];
  return row;
}

}  // namespace scree
