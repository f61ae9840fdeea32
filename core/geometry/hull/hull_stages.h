// The stages of hull building, in order: points on a grid -> candidates for corners -> triangles -> polygons
// -> topology. Each stage has its own source file.
#pragma once

#include <core/geometry/hull/hull_topology.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace scree {

// hull_points.cpp: points on an integer grid, which makes side-of-plane tests exact.

// In steps of the hull's grid, each coordinate within +-2^24. Steps differ by axis, so that a flat hull keeps
// its thickness. This does not change which side of a plane a point lies on.
using GridPoint = std::array<std::int32_t, 3>;
using GridSteps = std::array<double, 3>;  // m, each a power of two

// Finds the corners of the convex hull with Qhull; returns ascending indices. May drop points within Qhull's
// rounding of the surface. Returns all points if Qhull cannot work with them. Throws std::bad_alloc.
std::vector<std::int32_t> find_extreme_points(std::span<const GridPoint> points);

// hull_triangles.cpp: the exact convex hull as triangles; no point of the hull lies above a triangle.

struct HullTriangle {
  std::array<std::int32_t, 3> vertex;    // counterclockwise seen from outside
  std::array<std::int32_t, 3> neighbor;  // [k] lies across the edge from vertex[k] to vertex[k + 1]
};

struct TriangleHull {
  std::vector<HullTriangle> triangles;  // none if all points lie within a plane
  std::vector<std::int32_t> outside;    // points above the tolerance that max_vertices cut off
};

struct TriangleLimits {
  int max_vertices;
  double tolerance;  // m; points that stick out less are dropped; at most an eighth of the first height
};

// Adds points one by one, always the one that lies farthest outside. So a limit of vertices leaves the hull
// as close to the points as a greedy choice can. At equal distances the lowest index wins.
TriangleHull find_triangles(std::span<const GridPoint> points, const GridSteps& steps,
                            const TriangleLimits& limits);

// The plane of three points, with an exact normal, in steps and not normalized.
struct GridPlane {
  std::array<std::int64_t, 3> normal;
  GridPoint origin;
  double inverse_length;  // m; largest for the smallest triangle

  // Distance above the plane in m; its sign is exact.
  double distance(const GridPoint& point) const;
};
GridPlane plane_of(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridSteps& steps);

// hull_faces.cpp: merges coplanar triangles and puts everything in canonical order.

// The corners of a hull and its polygons.
struct HullPolygons {
  std::vector<std::int32_t> corners;             // ascending indices of points
  std::vector<std::vector<std::int32_t>> loops;  // of indices into `corners`, in canonical order
};

// Merges triangles whose corners lie within `tolerance` (m) of one plane. Drops corners that then have fewer
// than three faces, reports them, and builds the hull of the others again. Tries smaller tolerances where
// polygons would not be convex; at zero it merges only exactly coplanar triangles. Throws Error "<who>:
// <problem>".
HullPolygons find_polygons(const std::string& who, std::span<const GridPoint> points, const GridSteps& steps,
                           const TriangleHull& hull, double tolerance);

// The topology of polygons with these corner coordinates.
HullTopology make_topology(const std::vector<Vec3>& corners,
                           const std::vector<std::vector<std::int32_t>>& loops);

}  // namespace scree
