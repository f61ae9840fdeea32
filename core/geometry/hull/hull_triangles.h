// The convex hull of points on a grid as triangles, exact: no triangle has a point of the hull above it.
#pragma once

#include <core/geometry/hull/hull_points.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace scree {

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

}  // namespace scree
