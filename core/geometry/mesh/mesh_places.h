// Points in equal places become one. Used by reports on meshes and by building them.
#pragma once

#include <scree/math_types.h>

#include <cstdint>
#include <span>
#include <vector>

namespace scree {

// For each point the number of its place; places are numbered in ascending order of (x, y, z). Zeros of both
// signs are one place.
struct Places {
  std::vector<std::uint32_t> of_point;
  std::uint32_t count = 0;
};

// At most 2^32 - 1 points, whose coordinates are numbers.
Places find_places(std::span<const Vec3> points);

}  // namespace scree
