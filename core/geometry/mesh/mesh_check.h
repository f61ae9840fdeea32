// Checks of meshes as callers hand them in. Used by every call that takes one, before it does anything.
#pragma once

#include <scree/mesh.h>

#include <cstddef>
#include <span>

namespace scree {

// So that an edge and its direction fit into 64 bits.
inline constexpr std::size_t kMaxMeshCount = std::size_t{1} << 30;

// Throws Error "<call>: <problem>" as inspect_mesh says.
void check_mesh(const char* call, std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles);

// Whether the corners do not lie on one line.
bool has_area(const Vec3& a, const Vec3& b, const Vec3& c);

// What inspect_mesh finds in a mesh that has been checked.
MeshReport report_mesh(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles);

}  // namespace scree
