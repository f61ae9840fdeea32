// The stages of hull building, in their order: points on a grid -> those that can be corners -> triangles ->
// polygons -> topology. Each is a source of its own.
#pragma once

#include <core/geometry/hull/hull_topology.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace scree {

// hull_points.cpp: points on an integer grid, where sides of planes are decided exactly.

// In steps of the hull's grid, each coordinate within +-2^24. Steps differ by axis, so that a flat hull keeps
// its thickness; that changes no side of a plane.
using GridPoint = std::array<std::int32_t, 3>;
using GridSteps = std::array<double, 3>;  // m, each a power of two

// The points that are corners of the convex hull, as ascending indices, found by Qhull; it may count points
// within its rounding of the surface as inner. Points that it cannot work with are all handed back. Throws
// std::bad_alloc.
std::vector<std::int32_t> find_extreme_points(std::span<const GridPoint> points);

// hull_triangles.cpp: the convex hull as triangles, exact: no triangle has a point of the hull above it.

struct HullTriangle {
  std::array<std::int32_t, 3> vertex;    // counterclockwise seen from outside
  std::array<std::int32_t, 3> neighbor;  // [k] lies across the edge from vertex[k] to vertex[k + 1]
};

struct TriangleHull {
  std::vector<HullTriangle> triangles;  // none if all points lie within a plane
  std::vector<std::int32_t> outside;    // points still farther out than the tolerance: the limit cut them off
};

struct TriangleLimits {
  int max_vertices;
  double tolerance;  // m; points that stick out less are left out, at most an eighth of the first height
};

// Adds point after point, each time the one that lies farthest outside, so that a limit of vertices leaves
// the hull as close to the points as such a greedy choice can. Equal distances: the lowest index.
TriangleHull find_triangles(std::span<const GridPoint> points, const GridSteps& steps,
                            const TriangleLimits& limits);

// The plane of three points, with a normal that is exact, in steps and not normalized.
struct GridPlane {
  std::array<std::int64_t, 3> normal;
  GridPoint origin;
  double inverse_length;  // m; the largest one is that of the smallest triangle

  // Distance above the plane in m; its sign is exact.
  double distance(const GridPoint& point) const;
};
GridPlane plane_of(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridSteps& steps);

// hull_faces.cpp: coplanar triangles merged, everything in canonical order.

// The corners of a hull and its polygons.
struct HullPolygons {
  std::vector<std::int32_t> corners;             // ascending indices of points
  std::vector<std::vector<std::int32_t>> loops;  // of indices into `corners`, in canonical order
};

// Merges triangles whose corners lie within `tolerance` (m) of one plane, drops corners that are
// left with fewer than three faces, and says so by making the hull of the others anew. Tries smaller
// tolerances where polygons would not be convex; at zero only what is exactly coplanar is merged. Throws
// Error "<who>: <problem>".
HullPolygons find_polygons(const std::string& who, std::span<const GridPoint> points, const GridSteps& steps,
                           const TriangleHull& hull, double tolerance);

// The topology of polygons whose corners have these coordinates.
HullTopology make_topology(const std::vector<Vec3>& corners,
                           const std::vector<std::vector<std::int32_t>>& loops);

}  // namespace scree
