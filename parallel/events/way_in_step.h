// How shapes have come to where they are at the end of a step, as far as sensors ask: straight ahead. Turns
// are those at the end of the step. Used by list_sensor_events and, where ranks share the world,
// bring_sights.
#pragma once

#include <core/world/world_data.h>
#include <parallel/queries/query_solid.h>

#include <cstdint>

namespace scree::sensing {

inline constexpr float kMostWay = 1e7f;  // m in a step; what moves farther is not cast

inline bool has_moved(const Bodies& bodies, std::int32_t body) {
  return bodies.type[body] != BodyType::fixed && (bodies.flags[body] & kBodyAsleep) == 0;
}

// m, how far a point of the body's shapes' inner balls may have come in the step; an upper bound.
inline float path_of(const Bodies& bodies, std::int32_t body) {
  const DeltaRow& delta = bodies.delta[body];
  const float turn = 2.0f * length(Vec3{delta.rotation[0], delta.rotation[1], delta.rotation[2]});
  return length(to_vec3(delta.position)) + turn * bodies.core[body].reach;
}

// Whether it may have come past something in the step.
inline bool is_fast(const Bodies& bodies, std::int32_t body) {
  const float path = path_of(bodies, body);
  return path > 2.0f * bodies.core[body].radius && path < kMostWay;
}

// From the shape's position before the step to that after it.
inline queries::Vector way_of(const WorldData& data, std::int32_t shape) {
  const std::int32_t body = data.shapes.body[shape];
  if (!has_moved(data.bodies, body) || !(path_of(data.bodies, body) < kMostWay)) return {};
  const DeltaRow& delta = data.bodies.delta[body];
  const PoseRow& pose = data.bodies.pose[body];
  const Vec3 arm = rotate(to_quat(pose.rotation), to_vec3(data.shapes.local_pose[shape].position));
  const Quat turn{delta.rotation[0], delta.rotation[1], delta.rotation[2], delta.rotation[3]};
  const Vec3 arm_before = rotate(Quat{-turn.x, -turn.y, -turn.z, turn.w}, arm);
  return queries::to_vector(to_vec3(delta.position) + (arm - arm_before));
}

}  // namespace scree::sensing
