// What a page does to a world: drags, shots, changed settings.
#pragma once

#include <scree/scree.h>
#include <tools/view/pieces.h>

namespace scree::view {

// Makes a change that a page asks for; `what` is its JSON, by "kind":
//
//   drag      body, point: takes hold of the body at a point of the world
//   move      to: where the held point shall go
//   release   lets go
//   shoot     from, toward: a ball, 0.25 m and 500 kg/m^3 unless radius and density say otherwise, at `speed`
//   delete    body
//   settings  gravity, substeps, solver, iterations, and friction and restitution of all shapes: those of
//             them that are there
//   nudge     body: moves it by one unit in the last place along x
//
// Bodies are named by BodyId::index. `held` is the joint of the drag, which lasts from call to call. Throws
// Error for what cannot be done, and has changed nothing then.
void touch(World& world, const Json& what, JointId& held);

// Lets go of what any page holds: a world that branches off shall not hang on.
void release_all(World& world);

}  // namespace scree::view
