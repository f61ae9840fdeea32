// Volume integrals of hulls, in double precision.
#pragma once

#include <core/geometry/hull/hull_topology.h>

namespace scree {

// About the origin of the corners, whose scale is exact: stretching multiplies them.
struct HullIntegrals {
  double volume = 0.0;  // m^3
  double center[3]{};   // m, centroid
  double moment[6]{};   // m^5, of x x^T about the centroid: xx xy xz yy yz zz
};

HullIntegrals integrate(const HullTopology& topology);

}  // namespace scree
