// How far a point that moves along a line is from a convex shape: an obstacle of sweeps; see sweep_path.h.
#pragma once

#include <core/world/world_data.h>
#include <parallel/continuous/sweep_path.h>

namespace scree::sweeps {

// A shape that is no mesh.
struct ConvexObstacle {
  const WorldData& data;
  std::int32_t shape;

  Distance distance_at(const Path& path, float t) const;
};

// m, of a ball about the shape's origin that holds the shape.
float outer_radius_of(const WorldData& data, std::int32_t shape);

}  // namespace scree::sweeps
