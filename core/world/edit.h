// Edits: the building blocks of World's calls. They assume checked values.
#pragma once

#include <core/geometry/solid_slots.h>
#include <core/world/check.h>
#include <core/world/mass.h>
#include <core/world/math.h>
#include <core/world/wake.h>
#include <core/world/world_data.h>

#include <concepts>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

namespace scree {

// Makes room for `count` rows of bodies, shapes or joints and for every list of their slots, so that nothing
// later in the call can run out of memory. If it throws, nothing has changed.
void grow(Bodies& bodies, std::size_t count);
void grow(Shapes& shapes, std::size_t count);
void grow(Joints& joints, std::size_t count);

// Slots for new objects: free ones first, the most recently freed at the front, then rows at the end.
struct SlotPlan {
  std::size_t free_count;   // in the free list
  std::size_t from_free;    // to be taken from it
  std::size_t first_fresh;  // old number of rows

  SlotPlan(const Column<std::int32_t>& free_slots, std::size_t rows, std::size_t count)
      : free_count(free_slots.size()),
        from_free(count < free_count ? count : free_count),
        first_fresh(rows) {}
  std::int32_t slot(const Column<std::int32_t>& free_slots, std::size_t i) const {
    return i < from_free ? free_slots[free_count - 1 - i]
                         : static_cast<std::int32_t>(first_fresh + i - from_free);
  }
};

// Takes the slots of a plan out of the store's free ones.
template <class Store>
void take_slots(Store& store, const SlotPlan& plan) {
  SCREE_ASSERT(store.free_slots.size() == plan.free_count);
  store.free_slots.drop_back(plan.from_free);
  store.free_mark.cut(store.free_slots.size());
}

// Writes only if the value differs: unwritten rows of zeros take no memory, and fixed bodies have many.
template <class Row>
void put(Column<Row>& column, std::integral auto row, const std::type_identity_t<Row>& value) {
  if (std::memcmp(static_cast<const void*>(&column[row]), static_cast<const void*>(&value), sizeof value) !=
      0)
    column[row] = value;
}

// Adds the shape to the list of shapes whose bounds and pairs must be updated.
void mark_dirty(Shapes& shapes, std::int32_t shape, std::uint8_t flags = kShapeDirty);
void mark_shapes_dirty(WorldData& data, std::int32_t body);  // all shapes of the body

TreeKind tree_of(const Bodies& bodies, std::int32_t body);

// Writes all columns of a new shape except generation, flags and body: pairs may still name the shape that
// had the slot before, and the call may still fail. The local rotation must be normalized; `slots` already
// count the shape.
void write_shape(WorldData& data, std::int32_t shape, const Geometry& geometry, const SolidSlots& slots,
                 const Material& material, const ShapeOptions& options);
void write_extent(WorldData& data, std::int32_t shape, const Geometry& geometry, const SolidSlots& slots);
void write_material(Shapes& shapes, std::int32_t shape, const Material& material);
// Makes the slot live: generation, flags, dirty list, counts.
ShapeId commit_shape(WorldData& data, std::int32_t shape, bool sensor);
void link_shape(WorldData& data, std::int32_t shape, std::int32_t body);
void unlink_shape(WorldData& data, std::int32_t shape);  // out of its body's list
// Removes the shape from the world, but not from its body's list.
void remove_shape(WorldData& data, std::int32_t shape);

// Places the body's origin; shapes become dirty.
void place_body(WorldData& data, std::int32_t body, const Pose& transform);
// Ends every call that changes a body's mass or shapes: writes the mass rows and moves the center of mass in
// the body, whose material points keep their velocity. Leaves the local poses of shapes and joints to
// place_matter(): every added shape moves the center, and a body may have 100,000 shapes.
void apply_mass(WorldData& data, std::int32_t body, const BodyMass& mass);
void apply_locks(Bodies& bodies, std::int32_t body);  // motion's locks and velocity from locks and type
// local_pose from given_pose, center, and hull or mesh.
PoseRow placed_in_body(const WorldData& data, std::int32_t shape);
void place_shape_in_body(WorldData& data, std::int32_t shape);
// Requests that the body's core is measured again.
void leave_core(WorldData& data, std::int32_t body);
// Does what calls have left to do, see UnplacedFlag. The result depends on the state alone, so that it may
// come at any time. The step begins with it; other code that reads these rows must call it first.
void place_matter(WorldData& data);
void place_matter_of(WorldData& data, std::int32_t body);  // whose flags stay

// Wakes the body, all that joints join it with and, when next asked, all that touch it.
void disturb(WorldData& data, std::int32_t body);

// Makes the body take part as one of this type. Its rows must already be those of such a body: at rest if
// fixed. The pairs of its shapes will be found again.
void take_part_as(WorldData& data, std::int32_t body, BodyType type);
// Stops a dynamic or kinematic body where it is: it takes part as a fixed one, but keeps its given type and
// properties.
void quarantine(WorldData& data, std::int32_t body);
// Gives a quarantined body back the type that it was given; does nothing to others.
void end_quarantine(WorldData& data, std::int32_t body);

// Adds the joint to the lists of its bodies. The world, which may have many joints, has no list.
void link_joint(WorldData& data, std::int32_t joint);
// Writes the links back from the joints behind this one in these lists.
void link_back(WorldData& data, std::int32_t joint);
// Removes the joint from the world and from its bodies' lists, and wakes the bodies.
void remove_joint(WorldData& data, std::int32_t joint);
// How many joints the body has.
std::size_t count_joints(const WorldData& data, std::int32_t body);
// The joint's frames from the given ones and the centers of mass.
void place_joint(WorldData& data, std::int32_t joint);
void place_joints_of(WorldData& data, std::int32_t body);
// Marks the lists of joints and pairs that must be rebuilt. `keeps_apart`: the joint keeps its bodies from
// colliding, or did so, so that their pairs change.
void joints_changed(WorldData& data, std::int32_t joint, bool keeps_apart);
void wake_ends(WorldData& data, std::int32_t joint);

// Linear or angular part of the locks: 1 where motion is free.
inline Vec3 free_axes(std::uint32_t locks) {
  return {(locks & 1) != 0 ? 0.0f : 1.0f, (locks & 2) != 0 ? 0.0f : 1.0f, (locks & 4) != 0 ? 0.0f : 1.0f};
}
inline Vec3 masked(Vec3 v, Vec3 mask) {
  return {mask.x != 0.0f ? v.x : 0.0f, mask.y != 0.0f ? v.y : 0.0f, mask.z != 0.0f ? v.z : 0.0f};
}
inline Vec3 free_linear(const MotionRow& motion, Vec3 v) { return masked(v, free_axes(motion.flags)); }
inline Vec3 free_angular(const MotionRow& motion, Vec3 v) { return masked(v, free_axes(motion.flags >> 3)); }

// Of a shape that stays where it is. The narrow phase looks far ahead of one that was fast when its pose was
// written, so that nothing keeps its pairs from being looked at.
inline StepMotion motion_at_rest(const PoseRow& pose) {
  return {{0.0f, 0.0f, 0.0f}, pose.padding > 0.0f ? std::numeric_limits<float>::infinity() : 0.0f};
}

inline Vec3 to_vec3(const float (&v)[3]) { return {v[0], v[1], v[2]}; }
inline Quat to_quat(const float (&q)[4]) { return {q[0], q[1], q[2], q[3]}; }
inline void store(float (&row)[3], Vec3 v) { row[0] = v.x, row[1] = v.y, row[2] = v.z; }
inline void store(float (&row)[4], Quat q) { row[0] = q.x, row[1] = q.y, row[2] = q.z, row[3] = q.w; }

// What finish_step does for moving bodies: the origin's pose from that of the center of mass.
inline Pose transform_of(const PoseRow& pose, Vec3 center) {
  const Quat rotation = to_quat(pose.rotation);
  return {to_vec3(pose.position) - rotate(rotation, center), rotation};
}

// The data of a world that has not been moved from.
inline WorldData& opened(Call call, const std::unique_ptr<WorldData>& data) {
  if (data == nullptr) fail(call, "the world has been moved from", ErrorCode::moved_from);
  return *data;
}

}  // namespace scree
