// Sums over the tetrahedra between the origin and the triangles of the faces; see hull_topology.h. A
// tetrahedron with corners 0, a, b, c and d = det(a, b, c) has volume d / 6, first moment d (a + b + c) / 24,
// and second moment d (a a^T + b b^T + c c^T + s s^T) / 120 with s = a + b + c (Tonon, Explicit exact
// formulas for the 3-D tetrahedron inertia tensor, 2004, gives them as barycentric integrals).
#include <core/geometry/hull/hull_topology.h>

#include <cstddef>

namespace scree {

namespace {

struct Sums {
  double volume = 0.0;
  double first[3]{};
  double second[6]{};
};

constexpr int kRow[6] = {0, 0, 0, 1, 1, 2};
constexpr int kColumn[6] = {0, 1, 2, 1, 2, 2};

void add_tetrahedron(Sums& sums, const Vec3& va, const Vec3& vb, const Vec3& vc) {
  const double a[3] = {va.x, va.y, va.z}, b[3] = {vb.x, vb.y, vb.z}, c[3] = {vc.x, vc.y, vc.z};
  const double det = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                     a[2] * (b[0] * c[1] - b[1] * c[0]);
  double s[3];
  for (int i = 0; i < 3; ++i) s[i] = a[i] + b[i] + c[i];
  sums.volume += det / 6.0;
  for (int i = 0; i < 3; ++i) sums.first[i] += det * s[i] / 24.0;
  for (int k = 0; k < 6; ++k) {
    const int i = kRow[k], j = kColumn[k];
    sums.second[k] += det * (a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + s[i] * s[j]) / 120.0;
  }
}

}  // namespace

HullIntegrals integrate(const HullTopology& topology) {
  Sums sums;
  const auto corner = [&](std::size_t place) -> const Vec3& {
    return topology.vertices[topology.loops[place]];
  };
  for (std::size_t f = 0; f + 1 < topology.begin.size(); ++f) {
    const std::size_t first = topology.begin[f], end = topology.begin[f + 1];
    for (std::size_t k = first + 1; k + 1 < end; ++k) {
      add_tetrahedron(sums, corner(first), corner(k), corner(k + 1));
    }
  }
  HullIntegrals integrals;
  integrals.volume = sums.volume;
  for (int i = 0; i < 3; ++i) integrals.center[i] = sums.first[i] / sums.volume;
  for (int k = 0; k < 6; ++k) {
    const double shift = sums.volume * integrals.center[kRow[k]] * integrals.center[kColumn[k]];
    integrals.moment[k] = sums.second[k] - shift;
  }
  return integrals;
}

}  // namespace scree
