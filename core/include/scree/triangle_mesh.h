// Triangle meshes as shapes: built once, shared by any number of shapes and worlds.
#pragma once

#include <scree/export.h>
#include <scree/math_types.h>
#include <scree/mesh.h>
#include <scree/shapes.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace scree {

struct MeshSolid;  // what is inside a TriangleMesh

/// Surfaces of single triangles.
struct MeshMaterials {
  /// Of each triangle as handed in its place in `materials`, or 255: the material of the shape. Empty: all
  /// triangles have the material of the shape.
  std::span<const std::uint8_t> of_triangle{};
  std::span<const Material> materials{};  ///< at most 255; density and surface_velocity are not used
};

/// What building a mesh did to the triangles that were given.
struct TriangleMeshReport {
  MeshReport given{};                 ///< the mesh as handed in
  std::size_t merged_vertices = 0;    ///< dropped: in the same place as another one, or of no triangle
  std::size_t dropped_triangles = 0;  ///< dropped: without area, or with the corners of an earlier one in the
                                      ///< same order of turning
};

/// A surface of triangles, which collide on their front sides: those from which their corners are seen
/// counterclockwise. Copies share one geometry; it never changes, so that any thread may read it. As a shape
/// it belongs to fixed and kinematic bodies only, and has no mass.
class SCREE_API TriangleMesh {
 public:
  /// No mesh: shapes cannot be made of it.
  TriangleMesh() noexcept;
  /// Throws Error where inspect_mesh does, on bad materials, and where no triangle has an area.
  explicit TriangleMesh(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles,
                        const MeshMaterials& materials = {});
  TriangleMesh(const TriangleMesh&) noexcept;             ///< shares the geometry
  TriangleMesh(TriangleMesh&&) noexcept;                  ///< leaves the other one empty
  TriangleMesh& operator=(const TriangleMesh&) noexcept;  ///< shares the geometry
  TriangleMesh& operator=(TriangleMesh&&) noexcept;       ///< leaves the other one empty
  ~TriangleMesh();

  bool is_empty() const noexcept;  ///< no mesh
  /// Vertices as they were given, but for those that were merged; in the order in which they first appear.
  std::span<const Vec3> vertices() const noexcept;
  std::size_t triangle_count() const noexcept;  ///< that are left
  /// A triangle that is left, by its number as the mesh was handed in; its corners as indices of vertices().
  /// Throws Error on a triangle that was dropped and on an index out of range.
  MeshTriangle triangle(std::size_t given_number) const;
  const TriangleMeshReport& report() const noexcept;  ///< what building it did to the triangles
  std::size_t memory() const noexcept;                ///< bytes of the geometry

  /// Whether both have the same geometry and materials, even if they were built separately.
  friend SCREE_API bool operator==(const TriangleMesh& a, const TriangleMesh& b) noexcept;

 private:
  friend struct MeshAccess;
  std::shared_ptr<const MeshSolid> solid_;
};

}  // namespace scree
