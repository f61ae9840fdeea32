// A body that becomes non-finite, for tests of quarantine.
#pragma once

#include <scree/world.h>

namespace scree::physics {

// Makes a body non-finite by public calls alone: sets a force that is small for the heaviest body, then gives
// the body the lightest mass. Reads nothing of the body, which may be absent.
inline void overload(World& world, BodyId body) {
  world.set_mass_properties(body, {.mass = 1e30f});
  world.add_force(body, {1e28f, -1e29f, 1e29f});
  world.set_mass_properties(body, {.mass = 1e-20f});
}

}  // namespace scree::physics
