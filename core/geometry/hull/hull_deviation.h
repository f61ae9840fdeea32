// How far points lie outside a hull.
#pragma once

#include <core/geometry/hull/hull_topology.h>

#include <array>
#include <span>

namespace scree {

// The largest distance to the hull of the points that lie above one of its planes; 0 if none does. Points are
// in the topology's frame, whose origin lies within the hull.
double find_deviation(const HullTopology& topology, std::span<const std::array<double, 3>> points);

}  // namespace scree
