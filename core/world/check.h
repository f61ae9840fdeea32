// Checks arguments of callers. Every World call uses them before it changes anything.
#pragma once

#include <core/world/limits.h>
#include <core/world/world_data.h>
#include <scree/world.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

namespace scree {

// The call whose arguments are checked: named in the message. `item` counts the definitions of a bulk call,
// or its `items`.
struct Call {
  const char* name;
  std::int64_t item = -1;
  const char* owner = "World::";  // before the name
  const char* items = "definition";
};

std::string title(Call call);  // how messages begin
// Throws Error "<owner><call>: <problem>".
[[noreturn]] void fail(Call call, const std::string& problem, ErrorCode code = ErrorCode::invalid_value);
[[noreturn]] void fail_range(Call call, const char* what, double value, double low, double high);
[[noreturn]] void fail_handle(Call call, const char* kind, std::uint32_t index, std::uint32_t generation,
                              bool is_own);

// The `i`th of `count` definitions; a single one is not counted.
inline Call item_of(Call call, std::size_t count, std::size_t i) {
  return {call.name, count > 1 ? static_cast<std::int64_t>(i) : -1, call.owner, call.items};
}
// Every index must fit the rows' int32.
void check_room(Call call, const char* what, std::size_t rows, std::size_t more);

// NaN fails every range.
inline void check_range(Call call, const char* what, float value, float low, float high) {
  if (!(value >= low && value <= high)) fail_range(call, what, value, low, high);
}
inline void check_vector(Call call, const char* what, Vec3 v, float limit) {
  check_range(call, what, v.x, -limit, limit);
  check_range(call, what, v.y, -limit, limit);
  check_range(call, what, v.z, -limit, limit);
}
bool is_unit(Quat rotation);  // in length, within kUnitTolerance
void check_rotation(Call call, const char* what, Quat rotation);
void check_pose(Call call, const char* position, const char* rotation, const Pose& pose, float limit);
void check_body_type(Call call, BodyType type);
void check_locks(Call call, AxisLocks locks);
void check_body_def(Call call, const BodyDef& def);
void check_geometry(Call call, const Geometry& geometry);
// False for meshes and half-spaces.
bool may_be_dynamic(const Geometry& geometry);
// Throws where the geometry may not be dynamic and the shape would be, or would be a sensor.
void check_place(Call call, const Geometry& geometry, BodyType body, bool sensor);
// Throws where a shape of the body may not be dynamic: nor may the body.
void check_may_be_dynamic(Call call, const WorldData& data, std::int32_t body);
void check_material(Call call, const Material& material);
void check_events(Call call, ContactEvents events);
void check_hooks(Call call, ContactHooks hooks);
void check_options(Call call, const ShapeOptions& options);
void check_settings(Call call, const WorldSettings& settings);
void check_joint(Call call, const Joint& joint);
// Of what is held; `hertz` may be 0.
void check_stiffness(Call call, const char* hertz, float hertz_value, const char* ratio, float ratio_value);
void check_strength(Call call, const char* what, float value);
void check_event_threshold(Call call, const char* what, float value);
// Frames of a joint; those in the world may lie farther off.
void check_joint_frames(Call call, bool world_a, const Pose& frame_a, bool world_b, const Pose& frame_b);
// Returns the rows of the joint's bodies, the world's for its handle.
JointBodies check_joint_def(Call call, const WorldData& data, const JointDef& def, const Joint& joint);

// Rejects what is dead, or of another world.
template <class Handle>
[[noreturn]] void fail_handle(Call call, const WorldData& data, const char* kind, const Handle& id) {
  fail_handle(call, kind, id.index, id.generation, is_own(data, id));
}

// The row of a handle, or an Error.
inline std::int32_t checked_row(Call call, const WorldData& data, BodyId id) {
  const Bodies& bodies = data.bodies;
  if (!is_own(data, id) || id.index >= bodies.flags.size() || bodies.generation[id.index] != id.generation ||
      (bodies.flags[id.index] & kBodyAlive) == 0) {
    fail_handle(call, data, "body", id);
  }
  return static_cast<std::int32_t>(id.index);
}
inline std::int32_t checked_row(Call call, const WorldData& data, ShapeId id) {
  const Shapes& shapes = data.shapes;
  if (!is_own(data, id) || id.index >= shapes.flags.size() || shapes.generation[id.index] != id.generation ||
      (shapes.flags[id.index] & kShapeAlive) == 0) {
    fail_handle(call, data, "shape", id);
  }
  return static_cast<std::int32_t>(id.index);
}
inline std::int32_t checked_row(Call call, const WorldData& data, JointId id) {
  const Joints& joints = data.joints;
  if (!is_own(data, id) || id.index >= joints.flags.size() || joints.generation[id.index] != id.generation ||
      (joints.flags[id.index] & kJointAlive) == 0) {
    fail_handle(call, data, "joint", id);
  }
  return static_cast<std::int32_t>(id.index);
}

}  // namespace scree
