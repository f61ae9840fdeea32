// The energy of a body, in J. Fixed and kinematic bodies have none.
#pragma once

#include <scree/scree.h>

namespace scree::extract {

// Of translation and rotation.
double kinetic_energy(const World& world, BodyId body);

// Of the world's gravity; 0 at the origin.
double potential_energy(const World& world, BodyId body);

}  // namespace scree::extract
