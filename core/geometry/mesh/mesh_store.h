// The meshes of a world: one slot for all shapes of the same mesh.
#pragma once

#include <core/world/check.h>
#include <core/world/world_data.h>

#include <cstddef>
#include <cstdint>

namespace scree {

// Counts one more shape for the slot of a mesh, and makes the slot if there is none. Returns the slot, or -1
// for other geometries. content_slots.h releases slots. The geometry must have been checked.
std::int32_t acquire_mesh(Meshes& meshes, const Geometry& geometry);

std::uint64_t mesh_content(const MeshSolid& solid);  // its hash, never 0
std::size_t mesh_bytes(const SharedMeshes& meshes);  // of the geometry in the slots

}  // namespace scree
