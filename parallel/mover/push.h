// What a mover does to dynamic bodies.
#pragma once

#include <parallel/mover/slide.h>

namespace scree::mover {

// Impulses on what is in the way, each such that the body no longer approaches the mover where they touch,
// and all together no more than the push force gives in the time of the move. `carried` (m/s) is what the
// mover's velocities are relative to.
void push_bodies(World& world, const Task& task, const Course& course, Vector carried);

// The weight of a mover on what it stands on.
void press_on_ground(World& world, const Task& task, const Touch& ground);

}  // namespace scree::mover
