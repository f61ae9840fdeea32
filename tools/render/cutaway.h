// Walls that hide what a picture is about, to be left out of it.
#pragma once

#include <scree/scree.h>
#include <tools/render/camera.h>

#include <vector>

namespace scree::render {

// The shapes of fixed and kinematic bodies that stand between the eye and more than a tenth of the subject's
// shapes, those of their own body apart; ascending by index. What lies under a tenth of them is ground, which
// may hide what it will. Meshes hide only what is behind their fronts, as rays see them.
std::vector<ShapeId> find_walls(const World& world, Vec3 eye, const Subject& subject, Workers& workers);

}  // namespace scree::render
