// Planes that hold a displacement, and the nearest one that they allow: a linear complementarity problem of
// three dimensions, small enough to try which planes hold it.
#pragma once

#include <parallel/queries/query_math.h>

#include <span>

namespace scree::mover {

using queries::Vector;

// Displacements x with normal . x >= least are allowed.
struct Plane {
  Vector normal;        // of unit length
  double least = 0.0;   // m, or m/s of velocities; above zero it pushes
  bool yields = false;  // given up first where planes leave no room: of what moves
};

// The allowed displacement that is nearest to the wanted one, within `tolerance`. False if there is none.
bool nearest_allowed(std::span<const Plane> planes, Vector wanted, double tolerance, Vector& nearest);

// The same where there may be none: lets all planes give way by `give` at most, then gives up those that
// yield, then lets the others give way as little as they must.
Vector nearest_possible(std::span<const Plane> planes, Vector wanted, double tolerance, double give);

}  // namespace scree::mover
