// How far hulls reach out of the solid: distances from it at the centers of a lattice of cubes, each computed
// when it is first asked for.
#pragma once

#include <core/geometry/decompose/shell.h>
#include <core/geometry/decompose/surface.h>

#include <cstddef>
#include <vector>

namespace scree::decomposition {

class Lattice {
 public:
  // `cells`: along the largest extent of the surface.
  Lattice(const Surface& surface, int cells);

  double spacing() const { return spacing_; }  // m

  // m: how far the shell reaches out of the solid, at the centers within it and at samples of its surface.
  // Returns at once, with a smaller number, where the centers alone exceed the limit.
  double concavity(const Shell& shell, double limit);

 private:
  // m, of a point from the solid, 0 within it. Where it is at most `enough`, it is any such distance.
  double distance(const Vector& point, double enough) const;
  double& cached(const std::size_t (&cell)[3]);
  double at_center(const std::size_t (&cell)[3]);
  Vector center(const std::size_t (&cell)[3]) const;
  std::size_t cell_of(double coordinate, std::size_t axis) const;
  double at_centers(const Shell& shell);
  double at_sample(const Vector& point, double most);

  WindingBins winding_;
  NearestTriangles nearest_;
  Vector lower_{};
  double spacing_ = 0.0;
  std::size_t counts_[3]{};
  std::vector<double> distances_;  // below 0: not asked for yet
};

}  // namespace scree::decomposition
