// Meshes in files, read by the library Assimp.
#pragma once

#include <scree/hull.h>
#include <scree/mesh.h>

#include <span>
#include <string>
#include <vector>

namespace scree::meshes {

struct Mesh {
  std::vector<Vec3> vertices;
  std::vector<MeshTriangle> triangles;
};

/// Reads an OBJ or an STL file, text or binary; the name's ending says which. Faces of more corners become
/// triangles, and points and lines are left out. Coordinates are multiplied by `scale`. Throws Error, which
/// names the file, where it cannot be read, has another ending, or holds no points.
Mesh read_mesh(const std::string& path, float scale = 1.0f);

/// Corners and faces of a hull as the text of an OBJ file.
std::string to_obj(const Hull& hull);
/// The same for several hulls: one object each, part_0 and so on.
std::string to_obj(std::span<const Hull> hulls);

}  // namespace scree::meshes
