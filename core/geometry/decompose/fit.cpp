// See fit.h.
#include <core/geometry/decompose/fit.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace scree::decomposition {

namespace {

// m; below 0 within the shell. The distance from it is at least this.
double height_above(const Shell& shell, const Vector& point) {
  double height = -std::numeric_limits<double>::infinity();
  for (const Plane& plane : shell.planes) height = std::max(height, plane.height(point));
  return height;
}

double distance_squared(const Shell& shell, const Vector& point) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [a, b, c] : shell.triangles) {
    nearest = std::min(nearest, decomposition::distance_squared(point, shell.corners[a], shell.corners[b],
                                                                shell.corners[c]));
  }
  return nearest;
}

double distance_to_box(const Bounds& box, const Vector& point) {
  double sum = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double out = std::max({box.lower[k] - point[k], point[k] - box.upper[k], 0.0});
    sum += out * out;
  }
  return std::sqrt(sum);
}

class Fit {
 public:
  explicit Fit(std::span<const Shell> shells) : shells_(shells) {}

  double most() const { return most_; }

  void include(const Vector& point) {
    if (height_above(shells_[last_], point) <= 0.0) return;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < shells_.size(); ++i) {
      if (distance_to_box(shells_[i].bounds, point) >= nearest) continue;
      const double height = height_above(shells_[i], point);
      if (height <= 0.0) {
        last_ = i;
        return;
      }
      if (height >= nearest) continue;
      nearest = std::min(nearest, std::sqrt(distance_squared(shells_[i], point)));
      if (nearest <= most_) return;
    }
    most_ = std::max(most_, nearest);
  }

 private:
  std::span<const Shell> shells_;
  std::size_t last_ = 0;  // the shell that held a point: neighbors often lie in the same
  double most_ = 0.0;
};

}  // namespace

double distance_from(std::span<const Shell> shells, const Surface& surface, double spacing) {
  Fit fit(shells);
  for (const auto& [a, b, c] : surface.triangles) {
    for_each_sample(surface.points[a], surface.points[b], surface.points[c], spacing,
                    [&](const Vector& point) { fit.include(point); });
  }
  return fit.most();
}

}  // namespace scree::decomposition
