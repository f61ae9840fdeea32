// Shapes as triangles, for viewers.
#pragma once

#include <scree/scree.h>

#include <cstdint>
#include <string>
#include <vector>

namespace scree::exports {

// In the shape's frame, m, before `scale` stretches it along the axes.
struct ShapeMesh {
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;           // unit, by position
  std::vector<std::uint32_t> indices;  // three a triangle, counterclockwise seen from outside
};

// Round surfaces have 24 sides. A half-space is a square of 1 km. A rounded box or hull is what 24 x 12
// directions touch of it.
ShapeMesh mesh_of(const Geometry& geometry);

// What stretches mesh_of(unit_of(geometry)) to the geometry: spheres, boxes, cylinders, cones and hulls
// differ by their scale alone, so that viewers keep one mesh for all boxes.
Vec3 scale_of(const Geometry& geometry);
Geometry unit_of(const Geometry& geometry);

// Equal for geometries that have the same mesh_of(unit_of()).
std::string key_of(const Geometry& geometry);

}  // namespace scree::exports
