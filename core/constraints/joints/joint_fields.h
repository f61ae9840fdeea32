// Fields that several kinds of joints have, as they stand in scree/joint.h and in plain/joint.h. Private to
// the sources of the kinds.
#pragma once

#include <core/plain/joint.h>
#include <scree/joint.h>

#include <cstdint>

namespace scree::joint_kinds {

inline std::uint32_t number_of(Drive drive) { return static_cast<std::uint32_t>(drive); }
inline Drive drive_of(std::uint32_t number) { return static_cast<Drive>(number); }

inline JointAxisRow row_of(const JointAxis& axis) {
  return {axis.lower, axis.upper,         axis.target,    axis.speed,
          axis.hertz, axis.damping_ratio, axis.max_force, number_of(axis.drive)};
}
inline JointAxis axis_of(const JointAxisRow& row) {
  return {row.lower, row.upper, drive_of(row.drive), row.target,
          row.speed, row.hertz, row.damping_ratio,   row.max_force};
}

inline void put(float (&to)[3], Vec3 v) { to[0] = v.x, to[1] = v.y, to[2] = v.z; }
inline void put(float (&to)[4], Quat q) { to[0] = q.x, to[1] = q.y, to[2] = q.z, to[3] = q.w; }
inline Vec3 vector_of(const float (&from)[3]) { return {from[0], from[1], from[2]}; }
inline Quat rotation_of(const float (&from)[4]) { return {from[0], from[1], from[2], from[3]}; }

inline bool is_rich_axis(const JointAxis& axis) {
  return axis.lower > -kNoLimit || axis.upper < kNoLimit || axis.drive != Drive::none;
}

}  // namespace scree::joint_kinds
