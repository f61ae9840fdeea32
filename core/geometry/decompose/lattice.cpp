// See lattice.h.
#include <core/geometry/decompose/lattice.h>

#include <algorithm>
#include <cmath>

namespace scree::decomposition {

Lattice::Lattice(const Surface& surface, int cells) : winding_(surface), nearest_(surface) {
  const Bounds bounds = surface.bounds();
  lower_ = bounds.lower;
  spacing_ = bounds.extent() / cells;
  for (std::size_t k = 0; k < 3; ++k) {
    const double count = std::ceil((bounds.upper[k] - bounds.lower[k]) / spacing_ - 1e-9);
    counts_[k] = static_cast<std::size_t>(std::clamp(count, 1.0, static_cast<double>(cells)));
  }
  distances_.assign(counts_[0] * counts_[1] * counts_[2], -1.0);
}

double Lattice::distance(const Vector& point, double enough) const {
  if (winding_.winding(point) != 0) return 0.0;
  return std::sqrt(nearest_.distance_squared(point, enough * enough));
}

double& Lattice::cached(const std::size_t (&cell)[3]) {
  return distances_[(cell[2] * counts_[1] + cell[1]) * counts_[0] + cell[0]];
}

double Lattice::at_center(const std::size_t (&cell)[3]) {
  double& known = cached(cell);
  if (known < 0.0) known = distance(center(cell), 0.0);
  return known;
}

Vector Lattice::center(const std::size_t (&cell)[3]) const {
  Vector point;
  for (std::size_t k = 0; k < 3; ++k) point[k] = lower_[k] + (static_cast<double>(cell[k]) + 0.5) * spacing_;
  return point;
}

std::size_t Lattice::cell_of(double coordinate, std::size_t axis) const {
  const double place = std::floor((coordinate - lower_[axis]) / spacing_);
  return static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(counts_[axis] - 1)));
}

// Row by row along x: between which planes of the shell it runs.
double Lattice::at_centers(const Shell& shell) {
  double most = 0.0;
  std::size_t first[3], last[3];
  for (std::size_t k = 0; k < 3; ++k) {
    first[k] = cell_of(shell.bounds.lower[k], k);
    last[k] = cell_of(shell.bounds.upper[k], k);
  }
  std::size_t cell[3];
  for (cell[2] = first[2]; cell[2] <= last[2]; ++cell[2]) {
    for (cell[1] = first[1]; cell[1] <= last[1]; ++cell[1]) {
      cell[0] = first[0];
      Vector row = center(cell);
      double from = shell.bounds.lower[0], to = shell.bounds.upper[0];
      row[0] = 0.0;
      for (const Plane& plane : shell.planes) {
        const double height = plane.height(row);
        if (plane.normal[0] > 0.0) {
          to = std::min(to, -height / plane.normal[0]);
        } else if (plane.normal[0] < 0.0) {
          from = std::max(from, -height / plane.normal[0]);
        } else if (height > 0.0) {
          to = from - 1.0;
        }
        if (to < from) break;
      }
      if (to < from) continue;
      for (; cell[0] <= last[0]; ++cell[0]) {
        const double x = center(cell)[0];
        if (x >= from && x <= to) most = std::max(most, at_center(cell));
      }
    }
  }
  return most;
}

// The distance at a point, but no more than it takes to see that it is not above `most`.
double Lattice::at_sample(const Vector& point, double most) {
  const std::size_t cell[3] = {cell_of(point[0], 0), cell_of(point[1], 1), cell_of(point[2], 2)};
  // Distances of two points from the solid differ no more than the points are apart.
  const double known = cached(cell);
  if (known >= 0.0) {
    const Vector way = point - center(cell);
    if (known + std::sqrt(dot(way, way)) <= most) return 0.0;
  }
  return distance(point, most);
}

double Lattice::concavity(const Shell& shell, double limit) {
  double most = at_centers(shell);
  if (most > limit) return most;
  for (const auto& [a, b, c] : shell.triangles) {
    for_each_sample(shell.corners[a], shell.corners[b], shell.corners[c], spacing_,
                    [&](const Vector& point) { most = std::max(most, at_sample(point, most)); });
  }
  return most;
}

}  // namespace scree::decomposition
