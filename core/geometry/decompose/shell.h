// The convex hull of a part's points while parts are cut and joined: triangles, planes and a volume, without
// what else a Hull has. And the samples of surfaces.
#pragma once

#include <core/geometry/decompose/surface.h>
#include <core/geometry/hull/hull_stages.h>
#include <scree/hull.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace scree::decomposition {

struct Plane {
  Vector normal{};      // unit
  double offset = 0.0;  // m

  double height(const Vector& point) const { return dot(normal, point) - offset; }
};

// Where the points of hulls are rounded to, for exact tests of sides; see hull_stages.h.
struct PointGrid {
  Vector origin{};    // m
  double step = 1.0;  // m, a power of two

  explicit PointGrid(const Bounds& bounds);
};

struct Shell {
  std::vector<Vector> corners;
  std::vector<Triangle> triangles;  // none: the points lie within a plane
  std::vector<Plane> planes;        // of the triangles, looking outward
  Bounds bounds;
  double volume = 0.0;  // m^3

  bool is_solid() const { return volume > 0.0; }
};

// Has at most `max_corners`, and leaves out points that stick out less than `tolerance` (m).
Shell make_shell(const PointGrid& grid, std::span<const Vector> points, int max_corners, double tolerance);
Shell make_shell(const Hull& hull);

// Calls `visit` with points of a triangle, corners included, that lie at most about `spacing` apart.
template <class Visit>
void for_each_sample(const Vector& a, const Vector& b, const Vector& c, double spacing, Visit&& visit) {
  // Rows along the longest edge.
  const Vector* corner[3] = {&a, &b, &c};
  double longest = -1.0;
  std::size_t base = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector edge = *corner[(k + 1) % 3] - *corner[k];
    if (dot(edge, edge) <= longest) continue;
    longest = dot(edge, edge);
    base = k;
  }
  const Vector& from = *corner[base];
  const Vector edge = *corner[(base + 1) % 3] - from, side = *corner[(base + 2) % 3] - from;
  const Vector area = cross(edge, side);
  const double length = std::sqrt(longest);
  const double height = length > 0.0 ? std::sqrt(dot(area, area)) / length : 0.0;
  const double rows = std::ceil(height / spacing), columns = std::ceil(length / spacing);
  for (double row = 0.0; row <= rows; row += 1.0) {
    const double up = rows > 0.0 ? row / rows : 0.0;
    const double steps = std::ceil(columns * (1.0 - up));
    for (double step = 0.0; step <= steps; step += 1.0) {
      const double along = steps > 0.0 ? (1.0 - up) * step / steps : 0.0;
      visit(from + along * edge + up * side);
    }
  }
}

}  // namespace scree::decomposition
