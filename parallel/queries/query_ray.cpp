// A ray against one solid; see query_ray.h. Works in the solid's frame.
//
// Rays may be far longer than solids are large, and begin far away. So roots are found about the point of the
// ray that is nearest to the middle, where the numbers are as small as the solid, instead of from a
// discriminant of large ones.
#include <parallel/queries/query_distance.h>
#include <parallel/queries/query_ray.h>
#include <parallel/queries/query_ray_smooth.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace scree::queries {

double enter_ball(Vector origin, Vector way, double radius) {
  const double size = dot(way, way), slope = dot(origin, way);
  if (!(slope < 0.0)) return kNever;
  const double nearest = -slope / size;
  const Vector middle = origin + nearest * way;
  const double inside = radius * radius - dot(middle, middle);
  if (!(inside >= 0.0)) return kNever;
  return std::max(nearest - std::sqrt(inside / size), 0.0);
}

namespace {

bool meet_sphere(double radius, const Line& line, Entry& entry) {
  if (dot(line.origin, line.origin) <= radius * radius) {
    entry.inside = true;
    return true;
  }
  entry.fraction = enter_ball(line.origin, line.translation, radius);
  if (!(entry.fraction <= 1.0)) return false;
  entry.normal = normalize(line.origin + entry.fraction * line.translation);
  return true;
}

}  // namespace

bool meet_capsule(double half, double radius, const Line& line, Entry& entry) {
  const Vector origin = line.origin, way = line.translation;
  const Vector from_axis{origin.x, origin.y - std::clamp(origin.y, -half, half), origin.z};
  if (dot(from_axis, from_axis) <= radius * radius) {
    entry.inside = true;
    return true;
  }
  // A ball about each end, and a cylinder between them.
  double first = kNever;
  for (const double end : {-half, half}) {
    first = std::min(first, enter_ball({origin.x, origin.y - end, origin.z}, way, radius));
  }
  const Vector across{origin.x, 0.0, origin.z};
  if (dot(across, across) > radius * radius) {
    const double side = enter_ball(across, {way.x, 0.0, way.z}, radius);
    if (side <= 1.0 && std::abs(origin.y + side * way.y) <= half) first = std::min(first, side);
  }
  if (!(first <= 1.0)) return false;
  entry.fraction = first;
  const Vector at = origin + first * way;
  entry.normal = normalize({at.x, at.y - std::clamp(at.y, -half, half), at.z});
  return true;
}

bool meet_box(Vector half, const Line& line, Entry& entry) {
  double enters = -kNever, leaves = 1.0;
  int axis_entered = 0;
  bool inside = true;
  for (int axis = 0; axis < 3; ++axis) {
    const double at = line.origin[axis], speed = line.translation[axis], limit = half[axis];
    const bool within = std::abs(at) <= limit;
    inside = inside && within;
    if (speed == 0.0) {
      if (!within) return false;
      continue;
    }
    const double side = speed > 0.0 ? -limit : limit;
    const double in = (side - at) / speed, out = (-side - at) / speed;
    if (in > enters) {
      enters = in;
      axis_entered = axis;
    }
    leaves = std::min(leaves, out);
  }
  if (inside) {
    entry.inside = true;
    return true;
  }
  if (!(enters <= leaves) || enters < 0.0) return false;
  const bool upper = line.translation[axis_entered] < 0.0;
  const double sign = upper ? 1.0 : -1.0;
  entry.fraction = enters;
  entry.normal = {axis_entered == 0 ? sign : 0.0, axis_entered == 1 ? sign : 0.0,
                  axis_entered == 2 ? sign : 0.0};
  entry.face = 2 * axis_entered + (upper ? 1 : 0);
  return true;
}

namespace {

struct Plane {
  Vector normal;
  double offset;
};

Vector corner_of(const HullData& hull, int corner) {
  return {hull.vertex[0][corner], hull.vertex[1][corner], hull.vertex[2][corner]};
}

// The plane of a face from its corners (M. E. Newell's normal): the columns' plane is a rounded one, and
// where faces meet at a small angle, their rounded planes meet far from the edge.
Plane plane_of(const HullData& hull, int face) {
  const int begin = hull.loop_begin[face], end = hull.loop_begin[face + 1];
  const Vector first = corner_of(hull, hull.loop[begin]);
  Vector normal;
  Vector before = corner_of(hull, hull.loop[end - 1]) - first;
  for (int i = begin; i < end; ++i) {
    const Vector corner = corner_of(hull, hull.loop[i]) - first;
    normal = normal + cross(before, corner);
    before = corner;
  }
  Plane plane{normalize(normal), -kNever};
  for (int i = begin; i < end; ++i) {
    plane.offset = std::max(plane.offset, dot(plane.normal, corner_of(hull, hull.loop[i])));
  }
  return plane;
}

// A stretch of a ray that lies behind all planes so far, and the plane by which it begins.
struct Stretch {
  double begin, end;
  int face = -1;
  Vector normal;

  // Cuts off what lies before the plane; distance + t * speed is the distance from it.
  void cut(double distance, double speed, int by) {
    if (speed < 0.0) {
      if (-distance / speed > begin) {
        begin = -distance / speed;
        face = by;
      }
    } else if (speed > 0.0) {
      end = std::min(end, -distance / speed);
    } else if (distance > 0.0) {
      end = -kNever;
    }
  }
};

// Of the ray, what lies within the ball around the hull; the rounded planes are true there within a margin.
// Returns whether there is any.
bool clip_to_ball(const Line& line, double radius, double& begin, double& end) {
  const double size = dot(line.translation, line.translation);
  begin = 0.0;
  end = 1.0;
  const bool inside = dot(line.origin, line.origin) <= radius * radius;
  if (!inside) begin = enter_ball(line.origin, line.translation, radius);
  if (!(begin <= 1.0)) return false;
  if (size > 0.0) {
    const Vector last = line.origin + line.translation;
    const double back = enter_ball(last, -line.translation, radius);
    if (dot(last, last) > radius * radius && back <= 1.0) end = std::max(begin, 1.0 - back);
  }
  return true;
}

bool meet_half_space(const Line& line, Entry& entry) {
  const double height = line.origin.y, fall = -line.translation.y;
  entry.inside = !(height > 0.0);
  if (entry.inside) return true;
  if (!(fall >= height)) return false;
  entry.fraction = height / fall;
  entry.normal = {0.0, 1.0, 0.0};
  return true;
}

// By the distance along the way, as casts do. What lies within the hull but for its rounding is rare.
bool meet_rounded_hull(const Solid& solid, const Line& local, const Line& line, Entry& entry) {
  constexpr double kBallRoom = 1.0 + 1e-5;
  double from = 0.0, to = 1.0;
  const double radius = (double{solid.hull->outer_radius} + solid.radius) * kBallRoom;
  if (!clip_to_ball(local, radius, from, to)) return false;
  Solid point;
  point.position = line.origin + from * line.translation;
  Contact contact;
  if (!meet(point, (to - from) * line.translation, solid, 1.0, contact)) return false;
  entry.inside = contact.inside;
  entry.fraction = contact.inside ? 0.0 : from + contact.fraction * (to - from);
  entry.normal = turn_back(solid.axes, contact.normal);
  return true;
}

bool meet_hull(const simd::QueryKernels& kernels, const HullData& hull, const Line& line, Entry& entry) {
  constexpr double kBallRoom = 1.0 + 1e-5;
  // Of the ball's radius: more than what normals are rounded by, 1e-6, what the kernel's arithmetic takes,
  // 3e-6, and by how much planes lie beyond the corners of their own faces: 1.2e-7 over 36,000 hulls of faces
  // that are nearly flat.
  constexpr float kPlaneError = 6e-6f;
  double from = 0.0, to = 1.0;
  if (!clip_to_ball(line, hull.outer_radius * kBallRoom, from, to)) return false;
  const Vector base = line.origin + from * line.translation, way = line.translation;
  simd::HullStretch stretch{};
  for (int axis = 0; axis < 3; ++axis) {
    stretch.base[axis] = static_cast<float>(base[axis]);
    stretch.way[axis] = static_cast<float>((to - from) * way[axis]);
  }
  stretch.margin = kPlaneError * hull.outer_radius;
  std::int32_t faces[kMaxHullFaces + kHullPadding];
  const int count = kernels.cut_hull(hull, stretch, faces);
  if (count < 0) return false;
  Stretch exact{-kNever, to - from, -1, {}};
  for (int i = 0; i < count; ++i) {
    const Plane plane = plane_of(hull, faces[i]);
    exact.cut(dot(plane.normal, base) - plane.offset, dot(plane.normal, way), faces[i]);
    if (exact.face == faces[i]) exact.normal = plane.normal;
  }
  if (!(exact.begin <= exact.end) || exact.end < 0.0) return false;
  if (!(exact.begin > 0.0)) {
    entry.inside = true;
    return true;
  }
  entry.fraction = from + exact.begin;
  entry.normal = exact.normal;
  entry.face = exact.face;
  return entry.fraction <= 1.0;
}

}  // namespace

bool meet(const simd::QueryKernels& kernels, const Solid& solid, const Line& line, Entry& entry) {
  const Line local{turn_back(solid.axes, line.origin - solid.position),
                   turn_back(solid.axes, line.translation)};
  entry = {};
  bool meets = false;
  switch (solid.type) {
    case ShapeType::sphere:
      meets = meet_sphere(solid.radius, local, entry);
      break;
    case ShapeType::capsule:
      meets = meet_capsule(solid.half.y, solid.radius, local, entry);
      break;
    case ShapeType::box:
      meets = meet_box(solid.half, local, entry);
      break;
    case ShapeType::hull:
      meets = meet_hull(kernels, *solid.hull, local, entry);
      break;
    case ShapeType::rounded_box:
      meets = meet_rounded_box(solid.half, solid.radius, local, entry);
      break;
    case ShapeType::rounded_hull:
      meets = meet_rounded_hull(solid, local, line, entry);
      break;
    case ShapeType::cylinder:
      meets = meet_cylinder(solid.half.y, solid.half.x, local, entry);
      break;
    case ShapeType::cone:
      meets = meet_cone(solid.half.y, solid.half.x, local, entry);
      break;
    case ShapeType::half_space:
      meets = meet_half_space(local, entry);
      break;
    case ShapeType::mesh:  // query_mesh.h
      break;
  }
  entry.normal = solid.axes * entry.normal;
  return meets;
}

}  // namespace scree::queries
