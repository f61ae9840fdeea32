// Solids; see query_solid.h.
#include <core/geometry/hull/hull_build.h>
#include <core/world/math.h>
#include <parallel/queries/query_solid.h>

#include <algorithm>
#include <cmath>

namespace scree::queries {

PoseRow pose_now(const WorldData& data, std::int32_t shape) {
  const Shapes& shapes = data.shapes;
  if ((shapes.flags[shape] & kShapeDirty) == 0) return shapes.pose[shape];
  // As update_bounds will write it. Not from the row of the local pose: reading calls of other threads may be
  // writing that (place_matter).
  const PoseRow local = placed_in_body(data, shape);
  const PoseRow& body = data.bodies.pose[shapes.body[shape]];
  const Quat rotation = to_quat(body.rotation);
  PoseRow pose{};
  store(pose.position, scree::to_vec3(body.position) + rotate(rotation, scree::to_vec3(local.position)));
  store(pose.rotation, rotation * to_quat(local.rotation));
  return pose;
}

Solid solid_of(const WorldData& data, std::int32_t shape) {
  const Shapes& shapes = data.shapes;
  const PoseRow pose = pose_now(data, shape);
  const ExtentRow& extent = shapes.extent[shape];
  Solid solid;
  solid.type = shapes.type[shape];
  solid.position = to_vector(pose.position);
  solid.axes = to_axes(to_quat(pose.rotation));
  switch (solid.type) {
    case ShapeType::sphere:
      solid.radius = extent.radius;
      break;
    case ShapeType::capsule:
      solid.half.y = extent.half[1];
      solid.radius = extent.radius;
      break;
    case ShapeType::box:
    case ShapeType::cylinder:
    case ShapeType::cone:
      solid.half = to_vector(extent.half);
      break;
    case ShapeType::rounded_box:
      solid.half = to_vector(extent.half);
      solid.radius = extent.radius;
      break;
    case ShapeType::hull:
    case ShapeType::rounded_hull:
      solid.half = to_vector(extent.half);
      solid.hull = data.hulls.data[shapes.hull[shape]];
      for (int axis = 0; axis < 3; ++axis) solid.corner[axis] = solid.hull->vertex[axis];
      solid.corners = solid.hull->vertex_count;
      solid.radius = solid.hull->rounding;
      if (solid.radius > 0.0) {
        const double rounding = solid.radius;
        solid.half = {solid.half.x - rounding, solid.half.y - rounding, solid.half.z - rounding};
      }
      break;
    case ShapeType::half_space:  // has no size
      break;
    case ShapeType::mesh:
      solid.half = to_vector(extent.half);
      solid.mesh = data.meshes.data[shapes.mesh[shape]];
      break;
  }
  return solid;
}

QueryShape::QueryShape(const Geometry& geometry, const Pose& pose) {
  solid.position = to_vector(pose.position);
  solid.axes = to_axes(pose.rotation);
  if (const auto* sphere = std::get_if<Sphere>(&geometry)) {
    solid.type = ShapeType::sphere;
    solid.radius = sphere->radius;
  } else if (const auto* capsule = std::get_if<Capsule>(&geometry)) {
    solid.type = ShapeType::capsule;
    solid.half.y = capsule->half_height;
    solid.radius = capsule->radius;
  } else if (const auto* box = std::get_if<Box>(&geometry)) {
    solid.type = box->rounding > 0.0f ? ShapeType::rounded_box : ShapeType::box;
    solid.half = to_vector(box->half_extents);
    solid.radius = box->rounding;
  } else if (const auto* cylinder = std::get_if<Cylinder>(&geometry)) {
    solid.type = ShapeType::cylinder;
    solid.half = {cylinder->radius, cylinder->half_height, cylinder->radius};
  } else if (const auto* cone = std::get_if<Cone>(&geometry)) {
    solid.type = ShapeType::cone;
    solid.half = {cone->radius, cone->half_height, cone->radius};
  } else {
    const auto& convex = std::get<ConvexHull>(geometry);
    const HullSolid& hull = *HullAccess::solid(convex.hull);
    const std::size_t count = hull.topology.vertices.size();
    solid.type = convex.rounding > 0.0f ? ShapeType::rounded_hull : ShapeType::hull;
    solid.radius = convex.rounding;
    solid.corners = static_cast<std::int32_t>(count);
    columns.resize(3 * count);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 corner = hull.topology.vertices[i];
      columns[i] = corner.x * convex.scale.x;
      columns[count + i] = corner.y * convex.scale.y;
      columns[2 * count + i] = corner.z * convex.scale.z;
      const auto widen = [](double& half, float at) { half = std::max(half, std::abs(double{at})); };
      widen(solid.half.x, columns[i]);
      widen(solid.half.y, columns[count + i]);
      widen(solid.half.z, columns[2 * count + i]);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) solid.corner[axis] = columns.data() + axis * count;
    solid.position =
        solid.position + solid.axes * Vector{hull.origin[0] * convex.scale.x, hull.origin[1] * convex.scale.y,
                                             hull.origin[2] * convex.scale.z};
  }
}

Vector reach_of(const Solid& solid) {
  if (solid.type == ShapeType::half_space) return {kHalfSpaceReach, kHalfSpaceReach, kHalfSpaceReach};
  if (solid.type == ShapeType::cylinder || solid.type == ShapeType::cone) {
    const auto reach = [&solid](int axis) {
      const double x = solid.axes.x[axis], z = solid.axes.z[axis];
      return std::abs(solid.axes.y[axis]) * solid.half.y + std::sqrt(x * x + z * z) * solid.half.x;
    };
    return {reach(0), reach(1), reach(2)};
  }
  const auto along = [&solid](int axis) {
    return std::abs(solid.axes.x[axis]) * solid.half.x + std::abs(solid.axes.y[axis]) * solid.half.y +
           std::abs(solid.axes.z[axis]) * solid.half.z + solid.radius;
  };
  return {along(0), along(1), along(2)};
}

}  // namespace scree::queries
