// Distances of solids, and when a moving solid comes to touch another one, in double precision.
//
// A solid is a core (a point, a segment, a polytope, a cylinder or a cone) and a radius about it. Distances
// of cores come from the algorithm of E. G. Gilbert, D. W. Johnson and S. S. Keerthi, "A fast procedure for
// computing the distance between complex objects in three-dimensional space", 1988. On polytopes it ends
// after finitely many steps; on disks each step divides what is left by 4, until rounding lets it come no
// nearer.
#pragma once

#include <parallel/queries/query_solid.h>

namespace scree::queries {

// Of two solids that are apart.
struct Gap {
  double distance = 0.0;  // m; not above zero where they overlap, and nothing else is set then
  Vector on_a, on_b;  // the points of the surfaces that are nearest to each other, relative to b's position
  Vector normal;      // of unit length, from a to b
  std::int32_t triangle = -1;  // of b, if that is a mesh: see NearHit
};

// With `a` moved by `shift`. Neither is a mesh; those are in query_mesh.h. `a` is no half-space.
Gap gap_between(const Solid& a, const Solid& b, Vector shift = {});

// m, how far a solid reaches from its position along a unit direction. It is no mesh; a half-space is asked
// along its normal.
double reach_along(const Solid& solid, Vector along);

// Where a solid on its way meets another one.
struct Contact {
  double fraction = 0.0;
  Vector point, normal;        // on b's surface, in the world; outward. Not where `inside`
  std::int32_t triangle = -1;  // of b, if that is a mesh: see CastHit
  bool inside = false;         // they overlap at first
};

// Whether `a`, moved along `way`, meets `b` at a fraction of at most `most`. Neither is a mesh, and
// `a` is no half-space.
bool meet(const Solid& a, Vector way, const Solid& b, double most, Contact& contact);

}  // namespace scree::queries
