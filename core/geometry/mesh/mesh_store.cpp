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

void check_mesh_place(Call call, const Geometry& geometry, BodyType body, bool sensor) {
  if (!std::holds_alternative<TriangleMesh>(geometry)) return;
  if (body == BodyType::dynamic) {
    fail(call, "a triangle mesh belongs to fixed and kinematic bodies only, but the body is dynamic",
         ErrorCode::wrong_state);
  }
  if (sensor) fail(call, "a triangle mesh is no sensor, but the shape is one");
}

void check_no_mesh(Call call, const WorldData& data, std::int32_t body) {
  const Shapes& shapes = data.shapes;
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = shapes.next[shape]) {
    if (shapes.mesh[shape] < 0) continue;
    fail(call,
         "shape " + std::to_string(shape) +
             " of the body is a triangle mesh, which belongs to fixed and kinematic bodies only",
         ErrorCode::wrong_state);
  }
}

}  // namespace scree
