// Waking: a call that can change the motion of bodies wakes them.
//
// A call wakes the body that it names at once. For bodies that touched a shape that it moved, changed or
// destroyed it only leaves a request: finding them takes a search of all moving pairs and of the shape's
// resting pairs, which wake_neighbors does once for all calls. wake_touched_islands then wakes the rest of
// each island.
#pragma once

#include <core/world/world_data.h>

#include <cstdint>

namespace scree {

// Notes for refresh_lists that the body may take part in another way now.
inline void note_change(Bodies& bodies, std::int32_t body) {
  bodies.lists_dirty = true;
  bodies.marks.mark(body);
  std::uint8_t& is_changed = bodies.is_changed[body];
  if (is_changed == 0) bodies.changed.push_back(body);
  is_changed = 1;
}
// The same for a shape, which may belong to another tree now or has filters to check from now on.
inline void note_change(Shapes& shapes, std::int32_t shape) {
  shapes.marks.mark(shape);
  std::uint8_t& is_changed = shapes.is_changed[shape];
  if (is_changed == 0) shapes.changed.push_back(shape);
  is_changed = 1;
}
void note_shapes(WorldData& data, std::int32_t body);  // all shapes of the body
// Notes for refresh_joints that the joint may have become active or inactive. refresh_lists notes the joints
// of changed bodies.
inline void note_change(Joints& joints, std::int32_t joint) {
  std::uint8_t& is_changed = joints.is_changed[joint];
  if (is_changed == 0) joints.changed.push_back(joint);
  is_changed = 1;
}

// Wakes a living dynamic body and restarts its timer; does nothing to other rows.
void wake_body(WorldData& data, std::int32_t body);

// The bodies that touch the shape (by the lists of pairs) wake at the next wake_neighbors; where the call
// moves or stops the shape of a fixed or kinematic body, so do those that are merely near it. Works for
// shapes that are about to die: their pairs outlive them until find_pairs.
inline void request_wake(WorldData& data, std::int32_t shape) {
  std::uint8_t& flags = data.shapes.flags[shape];
  if ((flags & kShapeWakes) == 0) data.shapes.wakers.push_back(shape);
  flags |= kShapeWakes;
  data.shapes.marks.mark(shape);
  data.shapes.wake_requested = true;
  data.shapes.waking_made.forget();
}

// Fulfills the requests. The step calls it before refresh_lists (the pairs must still be last step's).
void wake_neighbors(WorldData& data);
// Whether it would wake the body, were it called now. For reading calls.
bool is_about_to_wake(const WorldData& data, std::int32_t body);

inline bool is_awake_dynamic(const Bodies& bodies, std::int32_t body) {
  return bodies.type[body] == BodyType::dynamic && (bodies.flags[body] & kBodyAsleep) == 0;
}

// A kinematic body wakes what it touches unless it is still.
inline bool is_still(const VelocityRow& v) {
  return v.linear[0] == 0.0f && v.linear[1] == 0.0f && v.linear[2] == 0.0f && v.angular[0] == 0.0f &&
         v.angular[1] == 0.0f && v.angular[2] == 0.0f;
}

}  // namespace scree
