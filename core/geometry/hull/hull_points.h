// Points of a hull on the way to its corners: on an integer grid, where sides of planes are decided exactly.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace scree {

// In steps of the hull's grid, each coordinate within +-2^24. Steps differ by axis, so that a flat hull keeps
// its thickness; that changes no side of a plane.
using GridPoint = std::array<std::int32_t, 3>;
using GridSteps = std::array<double, 3>;  // m, each a power of two

// The points that are corners of the convex hull, as ascending indices, found by Qhull; it may count points
// within its rounding of the surface as inner. Points that it can not work with are all handed back. Throws
// std::bad_alloc.
std::vector<std::int32_t> find_extreme_points(std::span<const GridPoint> points);

}  // namespace scree
