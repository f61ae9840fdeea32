// Volume integrals of a hull; see hull_topology.h.
#include <core/geometry/hull/hull_topology.h>
#include <core/geometry/solid_integrals.h>

#include <cstddef>

namespace scree {

HullIntegrals integrate(const HullTopology& topology) {
  SolidIntegrals sums;
  const auto corner = [&](std::size_t place) -> SolidPoint {
    const Vec3& vertex = topology.vertices[topology.loops[place]];
    return {vertex.x, vertex.y, vertex.z};
  };
  for (std::size_t f = 0; f + 1 < topology.begin.size(); ++f) {
    const std::size_t first = topology.begin[f], end = topology.begin[f + 1];
    for (std::size_t k = first + 1; k + 1 < end; ++k) sums.add(corner(first), corner(k), corner(k + 1));
  }
  HullIntegrals integrals;
  integrals.volume = sums.volume;
  for (int i = 0; i < 3; ++i) integrals.center[i] = sums.first[i] / sums.volume;
  for (int k = 0; k < 6; ++k) {
    const double shift = sums.volume * integrals.center[kMomentRow[k]] * integrals.center[kMomentColumn[k]];
    integrals.moment[k] = sums.second[k] - shift;
  }
  return integrals;
}

}  // namespace scree
