// Distances of points to a hull; see hull_topology.h.
#include <core/geometry/hull/hull_numbers.h>
#include <core/geometry/hull/hull_topology.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace scree {

namespace {

double squared(const Vector& v) { return dot(v, v); }

double squared_distance_to_segment(const Vector& p, const Vector& a, const Vector& b) {
  const Vector along = b - a;
  const double t = std::clamp(dot(p - a, along) / squared(along), 0.0, 1.0);
  return squared(p - (a + t * along));
}

double squared_distance_to_face(const HullTopology& topology, std::size_t face, const Vector& p) {
  const HullTopology::Plane& plane = topology.planes[face];
  const Vector n = to_vector(plane.normal);
  const std::size_t first = topology.begin[face], count = topology.begin[face + 1] - first;
  const auto corner = [&](std::size_t k) {
    return to_vector(topology.vertices[topology.loops[first + k % count]]);
  };
  bool over_it = true;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < count; ++k) {
    const Vector a = corner(k), b = corner(k + 1);
    over_it &= dot(cross(n, b - a), p - a) >= 0.0;
    nearest = std::min(nearest, squared_distance_to_segment(p, a, b));
  }
  if (!over_it) return nearest;
  const double height = dot(n, p - corner(0));
  return height * height;
}

// The nearest point of the hull lies in a face that the point is above.
double distance_to(const HullTopology& topology, const Vector& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < topology.planes.size(); ++f) {
    const HullTopology::Plane& plane = topology.planes[f];
    const double reach =
        plane.normal[0] * p[0] + plane.normal[1] * p[1] + plane.normal[2] * p[2] - double{plane.offset};
    if (reach > 0.0) nearest = std::min(nearest, squared_distance_to_face(topology, f, p));
  }
  return std::sqrt(nearest);
}

struct Outsider {
  double bound;  // m; a point shrunk toward the origin by this much lies below all planes
  std::size_t point;
};

}  // namespace

double find_deviation(const HullTopology& topology, std::span<const std::array<double, 3>> points) {
  std::vector<Outsider> outsiders;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& p = points[i];
    double factor = 1.0;
    for (const HullTopology::Plane& plane : topology.planes) {
      const double reach = plane.normal[0] * p[0] + plane.normal[1] * p[1] + plane.normal[2] * p[2];
      if (reach > factor * plane.offset) factor = reach / plane.offset;
    }
    if (factor <= 1.0) continue;
    const double size = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    outsiders.push_back({size * (1.0 - 1.0 / factor), i});
  }
  std::sort(outsiders.begin(), outsiders.end(), [](const Outsider& a, const Outsider& b) {
    return a.bound != b.bound ? a.bound > b.bound : a.point < b.point;
  });
  double largest = 0.0;
  for (const Outsider& outsider : outsiders) {
    if (outsider.bound <= largest) break;
    largest = std::max(largest, distance_to(topology, points[outsider.point]));
  }
  return largest;
}

}  // namespace scree
