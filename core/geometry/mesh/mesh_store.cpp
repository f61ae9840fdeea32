// See mesh_store.h.
#include <core/geometry/mesh/mesh_build.h>
#include <core/geometry/mesh/mesh_store.h>
#include <core/world/content_slots.h>

namespace scree {

std::int32_t acquire_mesh(Meshes& meshes, const Geometry& geometry) {
  const auto* mesh = std::get_if<TriangleMesh>(&geometry);
  if (mesh == nullptr) return -1;
  const std::shared_ptr<const MeshSolid>& solid = MeshAccess::solid(*mesh);
  const std::uint64_t content = mesh_content(*solid);
  const auto is_same = [&](const SharedMesh& shared) {
    return shared.solid == solid || equal(*shared.solid, *solid);
  };
  if (const std::int32_t slot = find_slot(meshes, content, is_same); slot >= 0) {
    ++meshes.shapes[slot];
    return slot;
  }
  return make_slot(meshes, content, SharedMesh{solid}, &solid->data);
}

std::uint64_t mesh_content(const MeshSolid& solid) { return solid.content_hash | 1; }  // 0 marks a free slot

std::size_t mesh_bytes(const SharedMeshes& meshes) {
  std::size_t bytes = meshes.capacity() * sizeof(SharedMesh);
  for (const SharedMesh& shared : meshes) bytes += shared.solid != nullptr ? shared.solid->bytes() : 0;
  return bytes;
}

}  // namespace scree
