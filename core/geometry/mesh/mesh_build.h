// Mesh building: vertices and triangles -> what is left of them -> what kernels read.
//
// The stages, a file each: mesh_parts (checks, merges vertices, drops what is no triangle), mesh_tree (the
// order of triangles and the boxes around them), mesh_turns (what lies behind each edge), mesh_columns.
// Nothing depends on how a sort orders equal keys, so that the same input gives the same mesh everywhere.
#pragma once

#include <core/plain/mesh.h>
#include <core/plain/rows.h>
#include <core/world/column.h>
#include <scree/triangle_mesh.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace scree {

// What a mesh is made of; all else follows from it.
struct MeshParts {
  std::vector<Vec3> vertices;  // as given, without those in the place of an earlier one
  double origin[3]{};          // m, the center of their box when the mesh was first built
  // Triangles in the order in which they were handed in.
  std::vector<MeshTriangle> triangles;
  std::vector<std::int32_t> given;    // their numbers as handed in, ascending
  std::vector<std::uint8_t> surface;  // rows of `materials`, or kShapeMaterial; empty: all have this
  std::vector<Material> materials;    // without density and surface velocity
  TriangleMeshReport report;
};

// Throws Error "<who>: <problem>" as TriangleMesh's constructor says.
MeshParts make_parts(const char* who, std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles,
                     const MeshMaterials& materials);
// Throws on materials that are out of range, too many, or not those of so many triangles.
void check_mesh_materials(const char* who, std::size_t triangles, const MeshMaterials& materials);
// Whether the parts are such as make_parts returns, so that a mesh can be made of them. If not, says why.
std::string find_defect(const MeshParts& parts);

// The columns that MeshData points into. May be moved, not copied.
struct MeshColumns {
  Column<float> vertex;
  Column<MeshCorners> corners;
  Column<MeshTurns> turns;
  Column<std::int32_t> given;
  Column<std::uint8_t> material;
  Column<MaterialRow> materials;
  Column<NodeBlock> nodes;             // level after level
  Column<std::int32_t> row_of_number;  // rows of triangles by ascending `given`
  Column<std::int32_t> given_vertex;   // by row of `vertex`: its place in MeshSolid::vertices
};

// The data of a TriangleMesh. Never changes.
struct MeshSolid {
  std::vector<Vec3> vertices;  // as given
  double origin[3]{};          // m, of the kernels' frame in that of the vertices: the center of the box
  ExtentRow extent{};          // about the origin: half the box, and the radius of the ball
  TriangleMeshReport report;
  std::vector<Material> materials;
  MeshColumns columns;
  MeshData data{};
  std::uint64_t content_hash = 0;  // of the parts without the report

  std::size_t bytes() const;  // of memory
};

// Throws as make_parts and std::bad_alloc.
std::shared_ptr<const MeshSolid> build_mesh(const char* who, std::span<const Vec3> vertices,
                                            std::span<const MeshTriangle> triangles,
                                            const MeshMaterials& materials);
// Of parts without defect.
std::shared_ptr<const MeshSolid> complete_mesh(MeshParts parts);
// The vertices of the triangle in a row, as handed in.
MeshTriangle given_corners(const MeshColumns& columns, std::int32_t row);
// The parts of a mesh that complete_mesh made.
MeshParts parts_of(const MeshSolid& solid);

bool equal(const MeshSolid& a, const MeshSolid& b);

// The row of a triangle in MeshData from its number as handed in; -1: it was dropped, or never was.
std::int32_t row_of_given(const MeshSolid& solid, std::size_t number);

// The data of a mesh; null for an empty one.
struct MeshAccess {
  static const std::shared_ptr<const MeshSolid>& solid(const TriangleMesh& mesh) { return mesh.solid_; }
  static TriangleMesh mesh(std::shared_ptr<const MeshSolid> solid) {
    TriangleMesh mesh;
    mesh.solid_ = std::move(solid);
    return mesh;
  }
};

}  // namespace scree
