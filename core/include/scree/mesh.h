// Triangle meshes as users hand them in: what is wrong with one, and the mass of what it encloses.
#pragma once

#include <scree/body.h>
#include <scree/export.h>
#include <scree/math_types.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace scree {

/// A triangle of a mesh: its corners as indices of vertices, counterclockwise seen from outside.
struct MeshTriangle {
  std::uint32_t a = 0;  ///< first corner
  std::uint32_t b = 0;  ///< second corner
  std::uint32_t c = 0;  ///< third corner

  friend bool operator==(const MeshTriangle&, const MeshTriangle&) = default;
};

/// What was found in a mesh. Vertices in the same place count as one, as files often repeat them. Edges are
/// those of triangles that have three different corners.
struct MeshReport {
  std::size_t vertices = 0;          ///< different places among the vertices, unused ones included
  std::size_t triangles = 0;         ///< as handed in
  std::size_t repeated_corners = 0;  ///< triangles that have fewer than three different corners
  std::size_t no_area = 0;           ///< other triangles whose corners lie on one line
  std::size_t duplicates = 0;     ///< triangles with the same three corners as an earlier one, in any order
  std::size_t edges = 0;          ///< between two different places, each counted once
  std::size_t open_edges = 0;     ///< of an odd number of triangles: the surface has a hole or a rim there
  std::size_t crowded_edges = 0;  ///< of more than two triangles
  /// Of an even number of triangles, of which more pass it one way than the other: neighbors look to
  /// different sides.
  std::size_t flipped_edges = 0;
  std::size_t parts = 0;  ///< pieces that share no vertex
  Vec3 lower{};           ///< m, least coordinates of the vertices
  Vec3 upper{};           ///< m, largest coordinates

  /// Whether the triangles enclose a volume: every edge is passed as often one way as the other.
  bool is_closed() const { return triangles > 0 && open_edges == 0 && flipped_edges == 0; }
};

/// Examines a mesh. Throws Error on coordinates that are not finite or beyond 1e5 m, on indices out of range,
/// with the number of the triangle, and on more than 2^30 vertices or triangles.
SCREE_API MeshReport inspect_mesh(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles);

/// Mass, center of mass and inertia of the solid that a mesh encloses, filled with `density` (kg/m^3, in
/// [1e-6, 1e9]). Of several parts the masses are added, and those of hollows, whose triangles look inward,
/// are taken off. Parts that overlap count twice. A mesh whose triangles all look inward has the mass of the
/// same mesh turned outward. Computes in double precision (Tonon 2004).
///
/// Throws Error where inspect_mesh does, where the mesh is not closed (MeshReport::is_closed), encloses
/// nothing, or its mass is beyond the limits of MassProperties.
SCREE_API MassProperties mesh_mass(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles,
                                   float density = 1000.0f);

/// The axes about which a body turns without wobble.
struct PrincipalAxes {
  Quat rotation;  ///< of the axes, in the body's frame: rotate(rotation, {1, 0, 0}) is the first
  Vec3 moments;   ///< kg m^2 about the three axes, ascending
};

/// The principal axes of an inertia. Axes of equal moments are not unique; of those, and of an inertia that
/// is diagonal, the body's own axes are taken where they fit. Each axis but the last, which completes a
/// right-handed system, points to the side where its largest component is positive. Throws Error on numbers
/// that are not finite. (Jacobi's method, 1846.)
SCREE_API PrincipalAxes principal_axes(const MassProperties& properties);

}  // namespace scree
