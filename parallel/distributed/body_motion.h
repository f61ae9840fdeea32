// What moves of a body and of its shapes: the rows that travel when a rank comes to have it. All else is on
// every rank. Used by ghosts.cpp and give_bodies.cpp.
#pragma once

#include <core/world/edit.h>
#include <core/world/wake.h>
#include <parallel/distributed/messages.h>
#include <parallel/islands/islands.h>

#include <span>
#include <vector>

namespace scree {

struct BodyMotion {
  PoseRow pose;
  VelocityRow velocity;
  ForceRow force;
  DriftRow drift;
  Pose transform;
  float sleep_time;
  std::int32_t is_asleep;
};

struct ShapeMotion {
  PoseRow pose;
  BoundsRow fat_bounds;  // what they are depends on where the shape has been
  StepMotion motion;
};

// What is known of a joint where it is solved.
struct SentJoint {
  std::int32_t joint;
  std::uint8_t color;
  JointImpulses impulses;
};

inline SentJoint sent_joint(const Joints& joints, std::int32_t joint) {
  return {joint, joints.color[joint], joints.impulses[joint]};
}

inline void take_joint(Joints& joints, const SentJoint& sent) {
  joints.color[sent.joint] = sent.color;
  joints.impulses[sent.joint] = sent.impulses;
  joints.marks.mark(sent.joint);
}

// Whether calls have destroyed the shape or made another one in its slot, since pairs were listed.
inline bool has_changed(const Shapes& shapes, std::int32_t shape) {
  return (shapes.flags[shape] & (kShapeAlive | kShapeNew)) != kShapeAlive;
}

inline std::vector<std::int32_t> shapes_of(const WorldData& data, std::span<const std::int32_t> bodies) {
  std::vector<std::int32_t> shapes;
  for (const std::int32_t body : bodies) {
    for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape])
      shapes.push_back(shape);
  }
  return shapes;
}

inline void send_bodies(Transport& transport, std::int32_t to, const WorldData& data,
                        std::span<const std::int32_t> sent) {
  const Bodies& bodies = data.bodies;
  const Shapes& shapes = data.shapes;
  send_rows<BodyMotion>(transport, to, sent, [&](std::int32_t body) {
    return BodyMotion{bodies.pose[body],
                      bodies.velocity[body],
                      bodies.force[body],
                      bodies.drift[body],
                      bodies.transform[body],
                      bodies.sleep_time[body],
                      is_asleep(bodies, body) ? 1 : 0};
  });
  send_rows<ShapeMotion>(transport, to, shapes_of(data, sent), [&](std::int32_t shape) {
    return ShapeMotion{shapes.pose[shape], shapes.fat_bounds[shape], shapes.motion[shape]};
  });
}

// Notes for refresh_lists that the body comes or goes; the trees of its shapes follow. A body that is absent
// does not count as asleep.
inline void set_absent(WorldData& data, std::int32_t body, bool absent, bool asleep = false) {
  Bodies& bodies = data.bodies;
  bodies.asleep += (asleep ? 1 : 0) - (is_asleep(bodies, body) ? 1 : 0);
  bodies.flags[body] = static_cast<std::uint8_t>(bodies.flags[body] & ~kBodyAsleep);
  if (asleep) bodies.flags[body] |= std::uint8_t{kBodyAsleep};
  bodies.is_absent[body] = absent ? 1 : 0;
  note_change(bodies, body);
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    data.shapes.tree[shape] = absent ? TreeKind::none : tree_of(data.bodies, body);
    if (absent) data.shapes.motion[shape] = motion_at_rest(data.shapes.pose[shape]);
    note_change(data.shapes, shape);
  }
}

inline void receive_bodies(Transport& transport, std::int32_t from, WorldData& data,
                           std::span<const std::int32_t> received) {
  Bodies& bodies = data.bodies;
  Shapes& shapes = data.shapes;
  receive_rows<BodyMotion>(transport, from, received, [&](std::int32_t body, const BodyMotion& motion) {
    if (bodies.is_absent[body] != 0) {
      set_absent(data, body, false, motion.is_asleep != 0);
    } else if (motion.is_asleep == 0) {
      wake_body(data, body);
    } else if (!is_asleep(bodies, body)) {
      refuse_world_of(from);  // owners do not put bodies to sleep by themselves
    }
    bodies.pose[body] = motion.pose;
    bodies.velocity[body] = motion.velocity;
    bodies.force[body] = motion.force;
    bodies.drift[body] = motion.drift;
    bodies.transform[body] = motion.transform;
    bodies.sleep_time[body] = motion.sleep_time;
    bodies.marks.mark(body);
  });
  receive_rows<ShapeMotion>(transport, from, shapes_of(data, received),
                            [&](std::int32_t shape, const ShapeMotion& motion) {
                              shapes.pose[shape] = motion.pose;
                              shapes.fat_bounds[shape] = motion.fat_bounds;
                              shapes.motion[shape] = motion.motion;
                              shapes.marks.mark(shape);
                            });
}

}  // namespace scree
