// A plain solver for the same manifolds: scalar, one contact point at a time, no constraint-space shortcuts.
// The oracle of the wide solver.
#pragma once

#include <core/world/world_data.h>
#include <parallel/crew/crew.h>

namespace scree::testing {

// Computes the results of solve() and store_impulses(), in the same order of contacts: soft step with
// substeps, normals per point with anchors rotated by each body's full motion, stored impulses applied anew
// in every substep, friction and twist at the friction center, rolling resistance, restitution.
void solve_plainly(WorldData& data, float dt);

// step() with solve_plainly in place of the wide solver.
void step_plainly(World& world, float dt, Workers& workers);

}  // namespace scree::testing
