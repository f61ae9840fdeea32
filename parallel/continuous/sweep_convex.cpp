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

Distance from_box(Vec3 point, Vec3 velocity, const float (&half)[3], float rounding) {
  const auto beyond = [](float x, float limit) {
    return x > limit ? x - limit : x < -limit ? x + limit : 0.0f;
  };
  const Vec3 way{beyond(point.x, half[0]), beyond(point.y, half[1]), beyond(point.z, half[2])};
  if (way != Vec3{}) return from_core(way, velocity, rounding);
  const float depth =
      std::min({half[0] - std::abs(point.x), half[1] - std::abs(point.y), half[2] - std::abs(point.z)});
  return {-depth - rounding, 0.0f, {}};
}

float across(Vec3 point) { return std::sqrt(point.x * point.x + point.z * point.z); }

Distance from_cylinder(Vec3 point, Vec3 velocity, float radius, float half) {
  const float out = across(point) - radius, up = std::abs(point.y) - half;
  if (!(out > 0.0f || up > 0.0f)) return {std::max(out, up), 0.0f, {}};
  const float share = out > 0.0f ? out / (out + radius) : 0.0f;
  return from_core({share * point.x, up > 0.0f ? std::copysign(up, point.y) : 0.0f, share * point.z},
                   velocity, 0.0f);
}

// From its base, side, rim or apex, whichever the point is in front of.
Distance from_cone(Vec3 point, Vec3 velocity, float radius, float half) {
  const float height = 2.0f * half, out = across(point), below = -half - point.y;
  const float slant = std::sqrt(radius * radius + height * height);
  const float cosine = height / slant, sine = radius / slant;  // of half the apex's angle
  const float down = half - point.y;                           // from the apex
  const float beside = cosine * out - sine * down;             // above the side
  if (!(below > 0.0f || beside > 0.0f)) return {std::max(below, beside), 0.0f, {}};
  if (below > 0.0f && out <= radius) return {below, -velocity.y, {0.0f, -1.0f, 0.0f}};
  const float along = sine * out + cosine * down;  // the side, from the apex
  if (along <= 0.0f) return from_core(point - Vec3{0.0f, half, 0.0f}, velocity, 0.0f);
  const float share = 1.0f / out;
  if (below > 0.0f || along >= slant) {
    const float beyond = share * (out - radius);
    return from_core({beyond * point.x, -below, beyond * point.z}, velocity, 0.0f);
  }
  const Vec3 normal{cosine * share * point.x, sine, cosine * share * point.z};
  return {beside, dot(normal, velocity), normal};
}

// The largest of three lower bounds: the planes', and, for sharp corners, those of the box and the sphere
// around the hull.
Distance from_hull(Vec3 point, Vec3 velocity, const HullData& hull, const ExtentRow& extent) {
  Distance best = from_core(point, velocity, extent.radius);
  const auto take = [&best](Distance bound) { best = bound.value > best.value ? bound : best; };
  const float rounding = hull.rounding;
  const float half[3] = {extent.half[0] - rounding, extent.half[1] - rounding, extent.half[2] - rounding};
  take(from_box(point, velocity, half, rounding));
  for (int face = 0; face < hull.face_count; ++face) {
    const Vec3 normal{hull.normal[0][face], hull.normal[1][face], hull.normal[2][face]};
    take({dot(point, normal) - hull.offset[face] - rounding, dot(velocity, normal), normal});
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
    case ShapeType::cylinder:
      return from_cylinder(point, path.motion, extent.half[0], extent.half[1]);
    case ShapeType::cone:
      return from_cone(point, path.motion, extent.half[0], extent.half[1]);
    case ShapeType::hull:
    case ShapeType::rounded_hull:
      return from_hull(point, path.motion, hull_of(data, shape), extent);
    default:
      return from_box(point, path.motion, extent.half, extent.radius);
  }
}

float outer_radius_of(const WorldData& data, std::int32_t shape) {
  const ExtentRow& extent = data.shapes.extent[shape];
  switch (data.shapes.type[shape]) {
    case ShapeType::capsule:
      return std::abs(extent.half[1]) + extent.radius;
    case ShapeType::box:
    case ShapeType::rounded_box:
      return length(to_vec3(extent.half)) + extent.radius;
    case ShapeType::cylinder:
    case ShapeType::cone:
      return length({extent.half[0], extent.half[1], 0.0f});
    default:
      return extent.radius;
  }
}

}  // namespace scree::sweeps
