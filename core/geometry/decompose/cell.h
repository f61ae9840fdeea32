// A convex region of space that cuts have left: corners, each with the planes that meet there. A part is what
// the solid has in it.
//
// The hull of that is the hull of the surface clipped to the cell and of the corners of the cell that lie in
// the solid: an extreme point of it that is not on the surface is inside the solid, and so extreme in the
// cell. So no cross section is ever triangulated, and rounding can break nothing.
#pragma once

#include <core/geometry/decompose/shell.h>
#include <core/geometry/decompose/surface.h>

#include <array>
#include <cstdint>
#include <vector>

namespace scree::decomposition {

struct CellCorner {
  Vector point{};
  std::vector<std::uint32_t> planes;  // ascending
  bool in_solid = false;
};

struct Cell {
  std::vector<Plane> planes;  // looking outward; never taken away, so that numbers stay
  std::vector<CellCorner> corners;
};

// A box whose corners are outside of the solid.
Cell make_cell(const Bounds& bounds);

// What is below a plane and what is above; points within `tolerance` (m) of it are on it.
std::array<Cell, 2> cut(const Cell& cell, const Plane& plane, const WindingBins& solid, double tolerance);

// The part of an edge that is deeper within the cell than `tolerance`; false: there is none.
bool clip(const Cell& cell, Vector& from, Vector& to, double tolerance);

}  // namespace scree::decomposition
