// Faces of a hull: coplanar triangles merged, everything in canonical order.
#pragma once

#include <core/geometry/hull/hull_topology.h>
#include <core/geometry/hull/hull_triangles.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace scree {

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
