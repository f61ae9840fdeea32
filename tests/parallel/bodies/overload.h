// A body that becomes non-finite, for tests of quarantine.
#pragma once

#include <scree/world.h>

namespace scree::physics {

// Makes a body non-finite by public calls alone: sets a force that is small for the heaviest body, then gives
// the body the lightest mass.
inline void overload(World& world, BodyId body) {
  const MassProperties before = world.mass_properties(body);
  MassProperties heavy = before, light = before;
  heavy.mass = 1e30f;
  light.mass = 1e-20f;
  world.set_mass_properties(body, heavy);
  world.add_force(body, {1e28f, -1e29f, 1e29f});
  world.set_mass_properties(body, light);
}

}  // namespace scree::physics
