// Waking: calls that can change how something moves wake it.
//
// A call wakes the body it names at once. Bodies that touched something that a call moved, changed or
// destroyed are only requested: finding them means looking through all pairs that move, and those at rest of
// such shapes, which is done once however many calls there were, by wake_neighbors. The rest of a woken
// body's island follows in wake_touched_islands.
#pragma once

#include <core/world/world_data.h>

#include <cstdint>

namespace scree {

// Tells refresh_lists that the body may take part otherwise than before.
inline void note_change(Bodies& bodies, std::int32_t body) {
  bodies.lists_dirty = true;
  bodies.marks.mark(body);
  std::uint8_t& is_changed = bodies.is_changed[body];
  if (is_changed == 0) bodies.changed.push_back(body);
  is_changed = 1;
}
// The same of a shape, which may have come into another tree or must be asked for filters from now on.
inline void note_change(Shapes& shapes, std::int32_t shape) {
  shapes.marks.mark(shape);
  std::uint8_t& is_changed = shapes.is_changed[shape];
  if (is_changed == 0) shapes.changed.push_back(shape);
  is_changed = 1;
}
void note_shapes(WorldData& data, std::int32_t body);  // all shapes of the body
// Tells refresh_joints that the joint may have something to solve or no longer. Of those of changed bodies
// refresh_lists does.
inline void note_change(Joints& joints, std::int32_t joint) {
  std::uint8_t& is_changed = joints.is_changed[joint];
  if (is_changed == 0) joints.changed.push_back(joint);
  is_changed = 1;
}

// Clears the sleep of a living dynamic body and restarts its timer; nothing happens to other rows.
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
}

// Fulfills the requests. The step calls it before refresh_lists (the pairs must still be last step's);
// World::is_awake calls it too.
void wake_neighbors(WorldData& data);

inline bool is_awake_dynamic(const Bodies& bodies, std::int32_t body) {
  const auto row = static_cast<std::size_t>(body);
  return bodies.type[row] == BodyType::dynamic && (bodies.flags[row] & kBodyAsleep) == 0;
}

// A kinematic body wakes what it touches unless it is still.
inline bool is_still(const VelocityRow& v) {
  return v.linear[0] == 0.0f && v.linear[1] == 0.0f && v.linear[2] == 0.0f && v.angular[0] == 0.0f &&
         v.angular[1] == 0.0f && v.angular[2] == 0.0f;
}

}  // namespace scree
