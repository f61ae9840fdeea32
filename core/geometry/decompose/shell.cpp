// See shell.h.
#include <core/geometry/decompose/shell.h>

namespace scree::decomposition {

namespace {

// Of corners and triangles: planes, bounds and volume.
void complete(Shell& shell) {
  if (shell.triangles.empty()) return;
  const Vector middle = shell.corners[0];
  shell.bounds = {middle, middle};
  for (const Vector& corner : shell.corners) shell.bounds.include(corner);
  for (const auto& [i, j, k] : shell.triangles) {
    const Vector a = shell.corners[i] - middle, b = shell.corners[j] - middle, c = shell.corners[k] - middle;
    const Vector normal = cross(b - a, c - a);
    shell.volume += dot(a, cross(b, c)) / 6.0;
    const double size = std::sqrt(dot(normal, normal));
    if (!(size > 0.0)) continue;
    const Vector unit = (1.0 / size) * normal;
    shell.planes.push_back({unit, dot(unit, shell.corners[i])});
  }
}

}  // namespace

PointGrid::PointGrid(const Bounds& bounds) {
  int exponent = 0;
  std::frexp(0.5 * bounds.extent(), &exponent);
  step = std::ldexp(1.0, exponent - 23);
  for (std::size_t k = 0; k < 3; ++k) {
    origin[k] = std::nearbyint(0.5 * (bounds.lower[k] + bounds.upper[k]) / step) * step;
  }
}

Shell make_shell(const PointGrid& grid, std::span<const Vector> points, int max_corners, double tolerance) {
  std::vector<GridPoint> places;
  places.reserve(points.size());
  for (const Vector& point : points) {
    GridPoint& place = places.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      place[k] = static_cast<std::int32_t>(std::nearbyint((point[k] - grid.origin[k]) / grid.step));
    }
  }
  const TriangleHull hull =
      find_triangles(places, {grid.step, grid.step, grid.step}, {max_corners, tolerance});
  Shell shell;
  constexpr auto kNone = static_cast<std::uint32_t>(-1);
  std::vector<std::uint32_t> corner_of(points.size(), kNone);
  for (const HullTriangle& triangle : hull.triangles) {
    Triangle& corners = shell.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto point = static_cast<std::size_t>(triangle.vertex[k]);
      if (corner_of[point] == kNone) {
        corner_of[point] = static_cast<std::uint32_t>(shell.corners.size());
        shell.corners.push_back(points[point]);
      }
      corners[k] = corner_of[point];
    }
  }
  complete(shell);
  return shell;
}

Shell make_shell(const Hull& hull) {
  Shell shell;
  for (const Vec3& vertex : hull.vertices()) shell.corners.push_back(to_vector(vertex));
  for (std::size_t f = 0; f < hull.face_count(); ++f) {
    const std::span<const std::uint8_t> loop = hull.face(f);
    for (std::size_t k = 2; k < loop.size(); ++k) shell.triangles.push_back({loop[0], loop[k - 1], loop[k]});
  }
  complete(shell);
  return shell;
}

}  // namespace scree::decomposition
