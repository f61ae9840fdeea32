// See sweep_convex.h.
#include <core/geometry/hull/hull_build.h>
#include <core/world/edit.h>
#include <parallel/continuous/sweep_convex.h>

#include <algorithm>
#include <cmath>

namespace scree::sweeps {

namespace {

const HullData& hull_of(const WorldData& data, std::int32_t shape) {
  return *data.hulls.data[data.shapes.hull[shape]];
}

Distance from_box(Vec3 point, Vec3 velocity, const float (&half)[3]) {
  const auto beyond = [](float x, float limit) {
    return x > limit ? x - limit : x < -limit ? x + limit : 0.0f;
  };
  const Vec3 way{beyond(point.x, half[0]), beyond(point.y, half[1]), beyond(point.z, half[2])};
  if (way != Vec3{}) return from_core(way, velocity, 0.0f);
  const float depth =
      std::min({half[0] - std::abs(point.x), half[1] - std::abs(point.y), half[2] - std::abs(point.z)});
  return {-depth, 0.0f, {}};
}

// The largest of three lower bounds: the planes', and, for sharp corners, those of the box and the sphere
// around the hull.
Distance from_hull(Vec3 point, Vec3 velocity, const HullData& hull, const ExtentRow& extent) {
  Distance best = from_core(point, velocity, hull.outer_radius);
  const auto take = [&best](Distance bound) { best = bound.value > best.value ? bound : best; };
  take(from_box(point, velocity, extent.half));
  for (int face = 0; face < hull.face_count; ++face) {
    const Vec3 normal{hull.normal[0][face], hull.normal[1][face], hull.normal[2][face]};
    take({dot(point, normal) - hull.offset[face], dot(velocity, normal), normal});
  }
  return best;
}

}  // namespace

Distance ConvexObstacle::distance_at(const Path& path, float t) const {
  const Vec3 point = path.start + t * path.motion;
  const ExtentRow& extent = data.shapes.extent[shape];
  switch (data.shapes.type[shape]) {
    case ShapeType::sphere:
      return from_core(point, path.motion, extent.radius);
    case ShapeType::capsule: {
      const float along = std::clamp(point.y, -extent.half[1], extent.half[1]);
      return from_core(point - Vec3{0.0f, along, 0.0f}, path.motion, extent.radius);
    }
    case ShapeType::half_space:
      return {point.y, path.motion.y, {0.0f, 1.0f, 0.0f}};
    case ShapeType::hull:
      return from_hull(point, path.motion, hull_of(data, shape), extent);
    default:
      return from_box(point, path.motion, extent.half);
  }
}

float outer_radius_of(const WorldData& data, std::int32_t shape) {
  const ExtentRow& extent = data.shapes.extent[shape];
  switch (data.shapes.type[shape]) {
    case ShapeType::capsule:
      return std::abs(extent.half[1]) + extent.radius;
    case ShapeType::box:
      return length(to_vec3(extent.half));
    default:
      return extent.radius;
  }
}

}  // namespace scree::sweeps
