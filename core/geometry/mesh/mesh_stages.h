// The stages of mesh building behind its parts; see mesh_build.h.
#pragma once

#include <core/geometry/mesh/mesh_build.h>
#include <core/geometry/mesh/mesh_sort.h>

#include <cstdint>
#include <span>
#include <vector>

namespace scree {

// Vertices relative to the origin, rounded once.
std::vector<Vec3> place_about(const double (&origin)[3], std::span<const Vec3> vertices);

// What lies behind the three edges of each triangle, which have an area.
std::vector<MeshTurns> find_turns(std::span<const Vec3> points, std::span<const Corners> triangles);

// Numbers of triangles in the order of the tree.
std::vector<std::int32_t> order_triangles(std::span<const Vec3> points, std::span<const Corners> triangles);
// Writes nodes and levels, whose leaf blocks hold 16 triangles each.
void make_nodes(std::span<const Vec3> points, std::span<const Corners> ordered, MeshSolid& solid);

}  // namespace scree
