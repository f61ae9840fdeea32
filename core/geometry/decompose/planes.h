// The planes that a part may be cut by.
#pragma once

#include <core/geometry/decompose/cell.h>
#include <core/geometry/decompose/fragments.h>

#include <vector>

namespace scree::decomposition {

// An edge at which the solid is not convex, with planes that would end that: those of its two faces, and the
// one that halves the angle.
struct ReentrantEdge {
  Vector from{}, to{};
  Plane faces[2];
  Plane half;
  double sharpness = 0.0;  // the sine of the angle at most, or 1 beyond a right one
};

// The edges between two triangles, of which many are sharp, sharpest and longest first; at most some
// thousand.
std::vector<ReentrantEdge> find_reentrant_edges(const Surface& surface, bool inside_out);

enum class PlaneKind { face, half, gap, axis, diagonal };

struct CutPlane {
  Plane plane;
  PlaneKind kind = PlaneKind::face;
  double spacing = 0.0;   // m, to the next one of its direction; 0: has none
  double thinness = 0.0;  // of evenly spaced ones: 1 - the extent along the direction over the largest one
};

// Along the faces at reentrant edges within the cell, through the largest gap of each direction, and evenly
// spaced in 13 directions.
std::vector<CutPlane> find_planes(const Cell& cell, const std::vector<ReentrantEdge>& edges,
                                  const Fragments& fragments, double thickness, double tolerance);

// One of each of the 13 directions, through the middle, or through its gap where there is one.
std::vector<CutPlane> find_middle_planes(const Fragments& fragments);

}  // namespace scree::decomposition
