// Edits: the building blocks of World's calls; see edit.h.
#include <core/constraints/joint_parameters.h>
#include <core/geometry/balls.h>
#include <core/geometry/hull/hull_build.h>
#include <core/geometry/hull/hull_store.h>
#include <core/geometry/mesh/mesh_build.h>
#include <core/plain/rows.h>
#include <core/world/edit.h>
#include <core/world/fp_environment.h>
#include <core/world/material.h>

namespace scree {

namespace {

template <class Store>
void grow_store(Store& store, std::size_t count) {
  const std::size_t old_count = store.generation.size();
  if (count <= old_count) return;
  try {
    store.free_slots.reserve(count);
    store.resize(count);
  } catch (...) {
    store.resize(old_count);  // shrinking keeps the memory and cannot fail
    throw;
  }
}

void leave(WorldData& data, std::int32_t body, UnplacedFlag what) {
  std::uint8_t& unplaced = data.bodies.unplaced[body];
  if (unplaced == 0) data.bodies.to_place.push_back(body);
  unplaced = static_cast<std::uint8_t>(unplaced | what);
}

void note_for_queries(Shapes& shapes, std::int32_t shape) {
  shapes.queries_made.forget();
  std::uint8_t& noted = shapes.is_noted[shape];
  if (noted == 0) shapes.to_query.push_back(shape);
  noted = 1;
}

// The pose of the center of mass, and of the origin again, which rounding may change.
void write_pose(Bodies& bodies, std::int32_t body, const Pose& transform) {
  store(bodies.pose[body].position, transform.position + rotate(transform.rotation, bodies.center[body]));
  store(bodies.pose[body].rotation, transform.rotation);
  bodies.transform[body] = transform_of(bodies.pose[body], bodies.center[body]);
  bodies.marks.mark(body);
}

// The material points of the body keep their positions and velocities.
void move_center(WorldData& data, std::int32_t body, Vec3 center) {
  Bodies& bodies = data.bodies;
  data.contacts.manifolds_stale = true;  // their arms are relative to the old center

  const Pose transform = bodies.transform[body];
  const Vec3 shift = rotate(transform.rotation, center - bodies.center[body]);
  VelocityRow& velocity = bodies.velocity[body];
  store(velocity.linear,
        free_linear(bodies.motion[body], to_vec3(velocity.linear) + cross(to_vec3(velocity.angular), shift)));
  bodies.center[body] = center;
  write_pose(bodies, body, transform);
  // Manifolds of sleepers with a fixed or kinematic body must be recomputed, too.
  const bool wakes = bodies.type[body] != BodyType::dynamic;
  const bool all_dirty = (bodies.unplaced[body] & kShapesUnplaced) != 0;
  if (!wakes && all_dirty) return;
  for (std::int32_t shape = bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    if (wakes) request_wake(data, shape);
    mark_dirty(data.shapes, shape);
  }
  leave(data, body, kShapesUnplaced);
  leave(data, body, kCoreUnmeasured);
}

}  // namespace

void grow(Bodies& bodies, std::size_t count) {
  bodies.to_place.reserve(count);
  bodies.changed.reserve(count);
  grow_store(bodies, count);
}

void grow(Joints& joints, std::size_t count) {
  joints.changed.reserve(count);
  grow_store(joints, count);
}

void grow(Shapes& shapes, std::size_t count) {
  shapes.dirty.reserve(count);
  shapes.wakers.reserve(count);
  shapes.changed.reserve(count);
  shapes.to_query.reserve(count);
  grow_store(shapes, count);
}

void mark_dirty(Shapes& shapes, std::int32_t shape, std::uint8_t flags) {
  std::uint8_t& row_flags = shapes.flags[shape];
  if ((row_flags & kShapeDirty) == 0) shapes.dirty.push_back(shape);
  row_flags = static_cast<std::uint8_t>(row_flags | flags | kShapeDirty);
  shapes.marks.mark(shape);
  shapes.waking_made.forget();
  if (shapes.is_queried) note_for_queries(shapes, shape);
}

void mark_shapes_dirty(WorldData& data, std::int32_t body) {
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    mark_dirty(data.shapes, shape);
  }
}

TreeKind tree_of(const Bodies& bodies, std::int32_t body) {
  switch (bodies.type[body]) {
    case BodyType::fixed:
      return TreeKind::frozen;
    case BodyType::kinematic:
      return TreeKind::kinematic;
    case BodyType::dynamic:
      break;
  }
  return (bodies.flags[body] & kBodyAsleep) != 0 ? TreeKind::frozen : TreeKind::awake;
}

void write_extent(WorldData& data, std::int32_t shape, const Geometry& geometry, const SolidSlots& slots) {
  Shapes& shapes = data.shapes;
  ExtentRow extent{};
  if (const auto* sphere = std::get_if<Sphere>(&geometry)) {
    shapes.type[shape] = ShapeType::sphere;
    extent.radius = sphere->radius;
  } else if (const auto* capsule = std::get_if<Capsule>(&geometry)) {
    shapes.type[shape] = ShapeType::capsule;
    extent.half[1] = capsule->half_height;
    extent.radius = capsule->radius;
  } else if (const auto* box = std::get_if<Box>(&geometry)) {
    shapes.type[shape] = box->rounding > 0.0f ? ShapeType::rounded_box : ShapeType::box;
    store(extent.half, box->half_extents);
    extent.radius = box->rounding + 0.0f;  // of one sign where it is zero
  } else if (const auto* cylinder = std::get_if<Cylinder>(&geometry)) {
    shapes.type[shape] = ShapeType::cylinder;
    store(extent.half, {cylinder->radius, cylinder->half_height, cylinder->radius});
  } else if (const auto* cone = std::get_if<Cone>(&geometry)) {
    shapes.type[shape] = ShapeType::cone;
    store(extent.half, {cone->radius, cone->half_height, cone->radius});
  } else if (std::holds_alternative<HalfSpace>(geometry)) {
    shapes.type[shape] = ShapeType::half_space;
    extent = kHalfSpaceExtent;
  } else if (slots.hull >= 0) {
    const SharedHull& hull = data.hulls.shared[static_cast<std::size_t>(slots.hull)];
    shapes.type[shape] = hull.data->rounding > 0.0f ? ShapeType::rounded_hull : ShapeType::hull;
    extent = extent_of(hull);
  } else if (slots.mesh >= 0) {
    shapes.type[shape] = ShapeType::mesh;
    extent = data.meshes.shared[static_cast<std::size_t>(slots.mesh)].solid->extent;
  }
  shapes.extent[shape] = extent;
  shapes.hull[shape] = slots.hull;
  shapes.mesh[shape] = slots.mesh;
  shapes.marks.mark(shape);
}

void write_material(Shapes& shapes, std::int32_t shape, const Material& material) {
  shapes.material[shape] = material_row(material);
  shapes.density[shape] = material.density;
  shapes.marks.mark(shape);
}

void write_shape(WorldData& data, std::int32_t shape, const Geometry& geometry, const SolidSlots& slots,
                 const Material& material, const ShapeOptions& options) {
  Shapes& shapes = data.shapes;
  write_extent(data, shape, geometry, slots);
  write_material(shapes, shape, material);
  shapes.next[shape] = -1;
  shapes.previous[shape] = -1;
  shapes.given_pose[shape] = options.local_pose;
  shapes.local_pose[shape] = {};
  shapes.filter[shape] = options.filter;
  shapes.fat_bounds[shape] = {};
  shapes.tree[shape] = TreeKind::none;
  put(shapes.user_data, shape, options.user_data);
  put(shapes.events, shape, options.contact_events);
  put(shapes.hooks, shape, options.contact_hooks);
  shapes.pose[shape] = {};
}

ShapeId commit_shape(WorldData& data, std::int32_t shape, bool sensor) {
  Shapes& shapes = data.shapes;
  SCREE_ASSERT((shapes.flags[shape] & kShapeAlive) == 0);
  if (shapes.generation[shape] == 0) shapes.generation[shape] = 1;
  mark_dirty(shapes, shape, static_cast<std::uint8_t>(kShapeAlive | kShapeNew | (sensor ? kShapeSensor : 0)));
  ++shapes.alive;
  if (sensor) ++shapes.sensors;
  if (shapes.events[shape] != ContactEvents::none) ++shapes.asking;
  if (shapes.hooks[shape] != ContactHooks::none) ++shapes.hooked;
  return shape_handle(data, shape);
}

void link_shape(WorldData& data, std::int32_t shape, std::int32_t body) {
  const std::int32_t sibling = data.bodies.first_shape[body];
  data.shapes.body[shape] = body;
  data.shapes.next[shape] = sibling;
  data.shapes.previous[shape] = -1;
  if (sibling >= 0) data.shapes.previous[sibling] = shape;
  data.bodies.first_shape[body] = shape;
  data.bodies.marks.mark(body);
  data.shapes.marks.mark(shape);
  data.shapes.tree[shape] = tree_of(data.bodies, body);
  if (data.shapes.tree[shape] != TreeKind::frozen) note_change(data.shapes, shape);
  place_shape_in_body(data, shape);
}

void unlink_shape(WorldData& data, std::int32_t shape) {
  Shapes& shapes = data.shapes;
  const std::int32_t before = shapes.previous[shape], behind = shapes.next[shape];
  const std::int32_t body = shapes.body[shape];
  SCREE_ASSERT((before >= 0 ? shapes.next[before] : data.bodies.first_shape[body]) == shape);
  SCREE_ASSERT(behind < 0 || shapes.previous[behind] == shape);
  if (before >= 0) {
    shapes.next[before] = behind;
    shapes.marks.mark(before);
  } else {
    data.bodies.first_shape[body] = behind;
    data.bodies.marks.mark(body);
  }
  if (behind >= 0) shapes.previous[behind] = before;
}

void remove_shape(WorldData& data, std::int32_t shape) {
  Shapes& shapes = data.shapes;
  SCREE_ASSERT((shapes.flags[shape] & kShapeAlive) != 0);
  request_wake(data, shape);
  mark_dirty(shapes, shape);
  release_slots(data, slots_of(shapes, shape));
  shapes.hull[shape] = shapes.mesh[shape] = -1;
  if (is_sensor(shapes, shape)) --shapes.sensors;
  shapes.flags[shape] =
      static_cast<std::uint8_t>(shapes.flags[shape] & ~(kShapeAlive | kShapeNew | kShapeSensor));
  if (shapes.tree[shape] != TreeKind::frozen) note_change(shapes, shape);
  shapes.tree[shape] = TreeKind::none;
  // A slot whose generations are used up stays empty for good.
  if (++shapes.generation[shape] != 0) shapes.free_slots.push_back(shape);
  --shapes.alive;
  if (shapes.events[shape] != ContactEvents::none) --shapes.asking;
  if (shapes.hooks[shape] != ContactHooks::none) --shapes.hooked;
  data.contacts.pairs_stale = true;
}

PoseRow placed_in_body(const WorldData& data, std::int32_t shape) {
  const Pose& given = data.shapes.given_pose[shape];
  const Vec3 center = data.bodies.center[data.shapes.body[shape]];
  PoseRow local{};
  store(local.position, given.position - center);
  if (const double* const origin = origin_of_solid(data, shape); origin != nullptr) {
    // In double precision: a hull may lie far from the origin of its points.
    double offset[3];
    rotate(given.rotation, origin, offset);
    store(local.position, {static_cast<float>(offset[0] + given.position.x - center.x),
                           static_cast<float>(offset[1] + given.position.y - center.y),
                           static_cast<float>(offset[2] + given.position.z - center.z)});
  }
  store(local.rotation, given.rotation);
  return local;
}

void place_shape_in_body(WorldData& data, std::int32_t shape) {
  data.shapes.local_pose[shape] = placed_in_body(data, shape);
}

void leave_core(WorldData& data, std::int32_t body) { leave(data, body, kCoreUnmeasured); }

void place_matter_of(WorldData& data, std::int32_t body) {
  const FpEnvironment environment;
  data.bodies.marks.mark(body);
  if ((data.bodies.unplaced[body] & kShapesUnplaced) != 0) {
    for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
      place_shape_in_body(data, shape);
    }
    place_joints_of(data, body);
  }
  measure_core(data, body);
}

void place_matter(WorldData& data) {
  Bodies& bodies = data.bodies;
  for (const std::int32_t body : bodies.to_place) {
    if ((bodies.flags[body] & kBodyAlive) != 0 && !is_absent(bodies, body)) place_matter_of(data, body);
    bodies.unplaced[body] = 0;
  }
  bodies.to_place.clear();
}

void place_body(WorldData& data, std::int32_t body, const Pose& transform) {
  mark_shapes_dirty(data, body);
  if (is_absent(data.bodies, body)) return;
  data.bodies.velocity[body].lag = 0.0f;
  write_pose(data.bodies, body, transform);
}

void apply_locks(Bodies& bodies, std::int32_t body) {
  MotionRow& motion = bodies.motion[body];
  bodies.marks.mark(body);
  motion.flags &= ~static_cast<std::uint32_t>(kMotionLocksMask);
  if (given_type(bodies, body) != BodyType::dynamic) return;
  motion.flags |= static_cast<std::uint32_t>(bodies.locks[body]);
  VelocityRow& velocity = bodies.velocity[body];
  store(velocity.linear, free_linear(motion, to_vec3(velocity.linear)));
  store(velocity.angular, free_angular(motion, to_vec3(velocity.angular)));
}

void apply_mass(WorldData& data, std::int32_t body, const BodyMass& mass) {
  Bodies& bodies = data.bodies;
  if (is_absent(bodies, body)) return;
  bodies.marks.mark(body);
  put(bodies.mass, body, mass.mass);
  put(bodies.local_inertia, body, mass.inertia);
  put(bodies.local_mass, body, mass.inverse);
  put(bodies.inertia, body, {});
  bodies.motion[body].flags = (bodies.motion[body].flags & ~static_cast<std::uint32_t>(kMotionGyroscopic)) |
                              (mass.gyroscopic ? static_cast<std::uint32_t>(kMotionGyroscopic) : 0u);
  if (bodies.center[body] != mass.center) move_center(data, body, mass.center);
}

void disturb(WorldData& data, std::int32_t body) {
  wake_body(data, body);
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    request_wake(data, shape);
  }
  const Joints& joints = data.joints;
  for (std::int32_t joint = data.bodies.first_joint[body]; joint >= 0;
       joint = next_joint(joints, joint, body)) {
    if ((joints.flags[joint] & kJointEnabled) != 0) wake_body(data, other_end(joints.bodies[joint], body));
  }
}

void take_part_as(WorldData& data, std::int32_t body, BodyType type) {
  Bodies& bodies = data.bodies;
  bodies.type[body] = type;
  if (type == BodyType::fixed) bodies.velocity[body] = {};
  bodies.velocity[body].lag = 0.0f;
  if (type != BodyType::dynamic) bodies.force[body] = {};
  bodies.sleep_time[body] = 0.0f;
  if ((bodies.flags[body] & kBodyAsleep) != 0) --bodies.asleep;
  bodies.flags[body] = static_cast<std::uint8_t>(bodies.flags[body] & ~kBodyAsleep);
  note_change(bodies, body);
  const TreeKind tree = tree_of(bodies, body);
  for (std::int32_t shape = bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    data.shapes.tree[shape] = tree;
    note_change(data.shapes, shape);
    mark_dirty(data.shapes, shape, kShapeNew);
    data.contacts.pairs_stale = true;
  }
}

void quarantine(WorldData& data, std::int32_t body) {
  disturb(data, body);
  data.bodies.flags[body] |=
      data.bodies.type[body] == BodyType::dynamic ? kBodyQuarantinedDynamic : kBodyQuarantinedKinematic;
  take_part_as(data, body, BodyType::fixed);
}

void end_quarantine(WorldData& data, std::int32_t body) {
  if (!is_quarantined(data.bodies, body)) return;
  const BodyType type = given_type(data.bodies, body);
  disturb(data, body);
  std::uint8_t& flags = data.bodies.flags[body];
  flags = static_cast<std::uint8_t>(flags & ~kBodyQuarantined);
  take_part_as(data, body, type);
}

}  // namespace scree
