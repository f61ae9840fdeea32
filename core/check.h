// Checks of what callers hand in. Used by every World call before it changes anything.
#pragma once

#include <core/world_data.h>
#include <scree/world.h>

#include <cmath>
#include <cstdint>
#include <string>

namespace scree {

// Limits that keep float arithmetic on state finite with room to spare.
inline constexpr float kMaxPosition = 1e7f;       // m; at 1e7 m neighboring floats are 1 m apart
inline constexpr float kMaxLocalPosition = 1e5f;  // m, of a shape in its body
inline constexpr float kMaxSpeed = 1e9f;          // m/s, rad/s; squares and cross products stay finite
inline constexpr float kMinExtent = 1e-4f;        // m
inline constexpr float kMaxExtent = 1e5f;         // m
inline constexpr float kMinDensity = 1e-6f;  // kg/m^3; the smallest sphere keeps a finite inverse inertia
inline constexpr float kMaxDensity = 1e9f;   // kg/m^3; the largest box keeps a finite inertia
inline constexpr float kMinMass = 1e-20f;    // kg
inline constexpr float kMaxMass = 1e30f;     // kg
inline constexpr float kMaxFriction = 1e6f;  // well above any surface, far below overflow
inline constexpr float kMaxRollingResistance = 1e5f;  // m
inline constexpr float kMaxSurfaceSpeed = 1e6f;       // m/s
inline constexpr float kMaxRate = 1e6f;               // 1/s, damping and other rates
inline constexpr float kMaxGravity = 1e6f;            // m/s^2
inline constexpr float kMaxGravityFactor = 1e6f;
inline constexpr float kMaxAcceleration = 1e15f;  // m/s^2, rad/s^2, from the forces on one body
inline constexpr float kUnitTolerance = 1e-3f;    // of a quaternion's length

// Who is asked to check: named in the message. `item` counts the definitions of a bulk call.
struct Call {
  const char* name;
  std::int64_t item = -1;
};

// Throws Error "World::<call>: <problem>".
[[noreturn]] void fail(Call call, const std::string& problem);
[[noreturn]] void fail_range(Call call, const char* what, double value, double low, double high);
[[noreturn]] void fail_handle(Call call, const char* kind, std::uint32_t index, std::uint32_t generation);

// NaN fails every range.
inline void check_range(Call call, const char* what, float value, float low, float high) {
  if (!(value >= low && value <= high)) fail_range(call, what, value, low, high);
}
inline void check_vector(Call call, const char* what, Vec3 v, float limit) {
  check_range(call, what, v.x, -limit, limit);
  check_range(call, what, v.y, -limit, limit);
  check_range(call, what, v.z, -limit, limit);
}
// Unit length within kUnitTolerance.
void check_rotation(Call call, const char* what, Quat rotation);
void check_pose(Call call, const char* position, const char* rotation, const Pose& pose, float limit);
void check_body_type(Call call, BodyType type);
void check_locks(Call call, AxisLocks locks);
void check_body_def(Call call, const BodyDef& def);
void check_geometry(Call call, const Geometry& geometry);
void check_material(Call call, const Material& material);
void check_options(Call call, const ShapeOptions& options);
void check_settings(Call call, const WorldSettings& settings);

// The row of a handle, or an Error.
inline std::int32_t checked_row(Call call, const Bodies& bodies, BodyId id) {
  if (id.index >= bodies.flags.size() || bodies.generation[id.index] != id.generation ||
      (bodies.flags[id.index] & kBodyAlive) == 0) {
    fail_handle(call, "body", id.index, id.generation);
  }
  return static_cast<std::int32_t>(id.index);
}
inline std::int32_t checked_row(Call call, const Shapes& shapes, ShapeId id) {
  if (id.index >= shapes.flags.size() || shapes.generation[id.index] != id.generation ||
      (shapes.flags[id.index] & kShapeAlive) == 0) {
    fail_handle(call, "shape", id.index, id.generation);
  }
  return static_cast<std::int32_t>(id.index);
}

}  // namespace scree
