// Convex hulls: built once from points, shared by any number of shapes and worlds.
#pragma once

#include <scree/export.h>
#include <scree/math_types.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace scree {

struct HullSolid;  // what is inside a Hull

/// How a hull is built.
struct HullOptions {
  int max_vertices = 256;  ///< in [4, 256]; a hull with more is simplified, and its report says so
};

/// What building a hull did to the points that were given.
struct HullReport {
  std::size_t given_points = 0;   ///< as handed in
  std::size_t merged_points = 0;  ///< dropped: equal to another one, or closer than the hull's resolution,
                                  ///< which by axis is 2^-24 to 2^-23 of half the extent
  std::size_t inner_points = 0;   ///< dropped: within the hull or in the middle of a face
  std::size_t cut_vertices = 0;   ///< vertices of the exact hull that simplification left out; where more
                                  ///< than 100,000 points lie outside a hull of 256 vertices, all of these
  float deviation = 0.0f;         ///< m: how far a given point lies outside the hull at most

  bool simplified() const { return cut_vertices > 0; }  ///< whether vertices of the exact hull were left out
};

/// A convex polyhedron. Copies share one geometry; it never changes, so that any thread may read it. Equal
/// points in any order give a hull of the same bits.
class SCREE_API Hull {
 public:
  /// No hull: shapes cannot be made of it.
  Hull() noexcept;
  /// The convex hull of points, with coplanar triangles merged to faces. Throws Error on fewer than 4 points,
  /// on coordinates that are not finite or beyond 1e5 m, and on points that lie within a plane or a line or
  /// whose hull is thinner than 1e-4 m or two millionths of its extent. Points that stick out of the hull of
  /// the others by less than single precision resolves (5e-7 of the extent, or 4 units in the last place of
  /// the largest coordinate) are left out; the report's deviation includes them.
  explicit Hull(std::span<const Vec3> points, const HullOptions& options = {});
  Hull(const Hull&) noexcept;             ///< shares the geometry
  Hull(Hull&&) noexcept;                  ///< leaves the other one empty
  Hull& operator=(const Hull&) noexcept;  ///< shares the geometry
  Hull& operator=(Hull&&) noexcept;       ///< leaves the other one empty
  ~Hull();

  bool is_empty() const noexcept;  ///< no hull
  /// Corners in the frame of the points, in canonical order.
  std::span<const Vec3> vertices() const noexcept;
  std::size_t edge_count() const noexcept;  ///< edges between faces, each counted once
  std::size_t face_count() const noexcept;  ///< faces, coplanar triangles merged into one
  /// Indices of a face's corners, counterclockwise seen from outside. Throws on an index out of range.
  std::span<const std::uint8_t> face(std::size_t index) const;
  float volume() const noexcept;              ///< m^3
  Vec3 centroid() const noexcept;             ///< center of the volume, in the frame of the points
  const HullReport& report() const noexcept;  ///< what building it did to the points

  /// Whether both have the same geometry, even if they were built separately.
  friend SCREE_API bool operator==(const Hull& a, const Hull& b) noexcept;

 private:
  friend struct HullAccess;
  std::shared_ptr<const HullSolid> solid_;
};

/// A hull as a shape, stretched along the hull's own axes about the origin of its points. With a rounding:
/// all points within that distance of the stretched hull.
struct ConvexHull {
  Hull hull;                     ///< the geometry; must not be empty
  Vec3 scale{1.0f, 1.0f, 1.0f};  ///< each above zero; the scaled hull keeps the limits of Hull
  float rounding = 0.0f;         ///< m, in [0, 1e5]; not scaled

  friend bool operator==(const ConvexHull&, const ConvexHull&) = default;
};

}  // namespace scree
