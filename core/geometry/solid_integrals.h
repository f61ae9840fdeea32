// Volume integrals of a solid as sums over the tetrahedra between the origin and the triangles of its
// surface, in double precision. Used by hulls (hull/hull_mass.cpp) and by closed meshes (mesh/mesh_mass.cpp).
//
// A tetrahedron with corners 0, a, b, c and d = det(a, b, c) has volume d / 6, first moment d (a + b + c) /
// 24, and second moment d (a a^T + b b^T + c c^T + s s^T) / 120 with s = a + b + c (Tonon, Explicit exact
// formulas for the 3-D tetrahedron inertia tensor, 2004, gives them as barycentric integrals).
#pragma once

#include <array>
#include <cstddef>

namespace scree {

using SolidPoint = std::array<double, 3>;

// Of a product of two coordinates: xx xy xz yy yz zz.
inline constexpr std::size_t kMomentRow[6] = {0, 0, 0, 1, 1, 2};
inline constexpr std::size_t kMomentColumn[6] = {0, 1, 2, 1, 2, 2};

// About the origin of the points.
struct SolidIntegrals {
  double volume = 0.0;  // m^3
  double first[3]{};    // m^4, of x
  double second[6]{};   // m^5, of x x^T: xx xy xz yy yz zz

  // The triangle's corners run counterclockwise seen from outside. Returns the tetrahedron's signed volume.
  double add(const SolidPoint& a, const SolidPoint& b, const SolidPoint& c) {
    const double det = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                       a[2] * (b[0] * c[1] - b[1] * c[0]);
    double s[3];
    for (std::size_t i = 0; i < 3; ++i) s[i] = a[i] + b[i] + c[i];
    volume += det / 6.0;
    for (std::size_t i = 0; i < 3; ++i) first[i] += det * s[i] / 24.0;
    for (int k = 0; k < 6; ++k) {
      const std::size_t i = kMomentRow[k], j = kMomentColumn[k];
      second[k] += det * (a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + s[i] * s[j]) / 120.0;
    }
    return det / 6.0;
  }
};

}  // namespace scree
