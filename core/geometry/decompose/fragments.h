// The surface of a part: triangles clipped by planes, each a convex polygon of its own. What is adjacent to
// what does not matter.
#pragma once

#include <core/geometry/decompose/shell.h>
#include <core/geometry/decompose/surface.h>

#include <array>
#include <cstdint>
#include <vector>

namespace scree::decomposition {

struct Fragments {
  std::vector<Vector> points;
  std::vector<std::uint32_t> corners;  // of all polygons, one behind the other
  std::vector<std::uint32_t> begin{0};

  std::size_t size() const { return begin.size() - 1; }
};

Fragments make_fragments(const Surface& surface);

// What is below a plane and what is above. Polygons in the plane, within `tolerance` (m), go to the side
// where the solid is: behind them, or before them where `inside_out`.
std::array<Fragments, 2> divide(const Fragments& all, const Plane& plane, bool inside_out, double tolerance);

// The same surface with fewer points, for trying out cuts: of points in the same of `cells` cubes along the
// largest extent one stays. Small surfaces stay as they are.
Fragments simplify(const Fragments& all, double cells);

}  // namespace scree::decomposition
