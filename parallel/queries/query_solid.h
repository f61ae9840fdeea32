// Solids: shapes of the world and shapes that a query brings, as queries compute with them: in double
// precision, each with a frame of its own.
#pragma once

#include <core/plain/mesh.h>
#include <core/world/edit.h>
#include <core/world/world_data.h>
#include <parallel/queries/query_math.h>

#include <cstdint>
#include <vector>

namespace scree::queries {

struct Solid {
  ShapeType type = ShapeType::sphere;
  Vector position;
  Axes axes;
  // m, of a box, and of the box around a hull or a mesh; of a capsule only y. Of rounded ones: of the core.
  // Of cylinders and cones: radius, half height, radius.
  Vector half;
  double radius = 0.0;  // m, around the core: of spheres and capsules, and what rounds boxes and hulls
  const HullData* hull = nullptr;
  // Of a hull: its corners in the solid's frame, as three columns.
  const float* corner[3] = {nullptr, nullptr, nullptr};
  std::int32_t corners = 0;
  const MeshData* mesh = nullptr;  // which is no convex solid: query_mesh.h asks it
};

// A shape that a query brings.
struct QueryShape {
  Solid solid;
  std::vector<float> columns;  // of a hull's corners, with the scale in them

  // The values must have been checked.
  QueryShape(const Geometry& geometry, const Pose& pose);
  QueryShape(const QueryShape&) = delete;  // `solid` points into `columns`
  QueryShape& operator=(const QueryShape&) = delete;
};

// Where the shape is now. Calls may have moved it since the last step; then this is where the next one finds
// it.
PoseRow pose_now(const WorldData& data, std::int32_t shape);
Solid solid_of(const WorldData& data, std::int32_t shape);
// Half of a box around the solid's position that holds the solid, along the world's axes.
Vector reach_of(const Solid& solid);

}  // namespace scree::queries
