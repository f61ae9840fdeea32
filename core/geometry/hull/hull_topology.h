// A hull's corners, faces and edges in canonical order: what hull building hands to the columns of the
// kernels (core/plain/hull.h).
#pragma once

#include <scree/math_types.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace scree {

// Corners are relative to the hull's centroid, in ascending order of (x, y, z). A face's loop runs
// counterclockwise seen from outside and starts at its lowest corner; faces ascend by their loops. Edges have
// vertex[0] < vertex[1] and ascend by (vertex[0], vertex[1]).
struct HullTopology {
  struct Plane {
    float normal[3];  // unit, outward
    float offset;     // m: normal . x for the corners x of the face; the largest of them
  };
  struct Edge {
    std::uint8_t vertex[2];
    std::uint16_t face[2];  // [0] has the edge from vertex[0] to vertex[1] in its loop, [1] the other way
  };

  std::vector<Vec3> vertices;        // 4 to 256
  std::vector<std::uint8_t> loops;   // corners of all faces, face after face
  std::vector<std::uint16_t> begin;  // face f is loops[begin[f]] to loops[begin[f + 1] - 1]
  std::vector<Plane> planes;         // of each face
  std::vector<Edge> edges;
};

// Volume integrals (hull_mass.cpp), in double precision.

// About the origin of the corners. Exact under scaling: stretching multiplies the integrals.
struct HullIntegrals {
  double volume = 0.0;  // m^3
  double center[3]{};   // m, centroid
  double moment[6]{};   // m^5, of x x^T about the centroid: xx xy xz yy yz zz
};

HullIntegrals integrate(const HullTopology& topology);
// Of all points within `rounding` (hull_rounding.cpp; m, above zero) of the hull stretched by `scale`. Exact,
// too. `within`: integrate(topology).
HullIntegrals integrate_rounded(const HullTopology& topology, const HullIntegrals& within,
                                const double (&scale)[3], double rounding);

// Largest distance to the hull of the points that lie above one of its planes; 0 if no point does. Points are
// in the topology's frame, whose origin lies within the hull.
double find_deviation(const HullTopology& topology, std::span<const std::array<double, 3>> points);

}  // namespace scree
