// How far a mesh reaches out of hulls.
#pragma once

#include <core/geometry/decompose/shell.h>
#include <core/geometry/decompose/surface.h>

#include <span>

namespace scree::decomposition {

// m: the largest distance of a sample of the surface from the nearest of the shells, 0 within one. Samples
// lie at most about `spacing` (m) apart.
double distance_from(std::span<const Shell> shells, const Surface& surface, double spacing);

}  // namespace scree::decomposition
