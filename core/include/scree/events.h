// Events: what happened in the last step, as sorted lists that are read after it.
//
// Contact events come for the pairs of shapes whose ShapeOptions::contact_events, or the world's
// WorldSettings::contact_events, ask for them; nothing is made and nothing paid for the others.
//
// A pair touches in a step if its surfaces met in it: the solver pressed some contact point, or a point did
// not lie apart when the step began. Candidates at some distance, which the solver watches ahead of time,
// do not touch. A pair that touches goes on doing so until all of its points are more than 5 mm apart and
// none is pressed: what rests and trembles would begin and end all the time otherwise. So every begin is
// followed by one end, and the impact of a ball that leaves in the same step is a begin with its impulse.
// Pairs whose bodies fall asleep do not end.
//
// A pair hits in a step if the solver pressed it and its surfaces came closer at no less than
// WorldSettings::hit_event_speed as the step began. What rests, rolls or slides does not; what leaves within
// the same step does, and so does what touched elsewhere before, as a box that tumbles. A blow that bodies
// pass on to each other within a step is a hit where it came in. A threshold of 0 lists every contact that is
// pressed. Pairs that ask for hits alone have no other events. Solver::soft_step stops an impact within a
// step; others may leave part of it to the next one, which is another hit if that is fast enough.
//
// Sensor events come for all sensors, see ShapeOptions::sensor. A sensor sees the shapes of other bodies of
// any type, awake or asleep, that its filter lets it collide with, but no sensors. It sees what touches or
// overlaps it as the step ends, by exact distances. What moves so fast that it enters and leaves within one
// step begins and ends in that step.
#pragma once

#include <scree/ids.h>
#include <scree/math_types.h>

#include <cstdint>

namespace scree {

/// One point of a contact, as the step found it at its beginning.
struct ContactPoint {
  Vec3 position;            ///< m, in world coordinates, between the two surfaces
  float separation = 0.0f;  ///< m; negative where the shapes overlap
};

/// Two shapes that touch: an entry of World::contact_begins, World::contact_persists or World::contact_hits.
struct ContactEvent {
  ShapeId shape_a;              ///< the one with the lower index
  ShapeId shape_b;              ///< the one with the higher index
  BodyId body_a;                ///< the body of shape_a
  BodyId body_b;                ///< the body of shape_b
  Vec3 normal;                  ///< unit, from a to b
  float normal_impulse = 0.0f;  ///< N s, of all points over the whole step; 0 after a step of no length
  /// m/s when the step began, the largest of the points that are in touch or meet within the step; 0 if none
  /// came closer. Where shapes touch in several places, those places count that were pressed, if any was.
  float approach_speed = 0.0f;
  std::int32_t point_count = 0;  ///< the nearest point, those less than 2 cm apart, and those pressed
  ContactPoint points[4];        ///< the first `point_count` count, the others are zero
};

/// Two shapes that no longer touch. They parted, or their events are no longer asked for, or one of them or
/// its body was destroyed: World::is_alive is false then, and calls refuse the handle.
struct ContactEnd {
  ShapeId shape_a;  ///< the one with the lower index
  ShapeId shape_b;  ///< the one with the higher index
  BodyId body_a;    ///< the body of shape_a
  BodyId body_b;    ///< the body of shape_b

  friend bool operator==(const ContactEnd&, const ContactEnd&) = default;
};

/// A joint that bore more than JointDef::event_force or event_torque: an entry of World::joint_events.
struct JointEvent {
  JointId joint;        ///< dead if a call has destroyed it since
  float force = 0.0f;   ///< N, the largest that acted on body b in a substep, see JointReaction
  float torque = 0.0f;  ///< N m, likewise, about anchor b; maybe of another substep

  friend bool operator==(const JointEvent&, const JointEvent&) = default;
};

/// A shape that entered or left a sensor. Where one of them was destroyed, its handles and those of its body
/// are not alive.
struct SensorEvent {
  ShapeId sensor;       ///< that saw it
  ShapeId visitor;      ///< the shape that entered or left
  BodyId sensor_body;   ///< the body of the sensor
  BodyId visitor_body;  ///< the body of the visitor

  friend bool operator==(const SensorEvent&, const SensorEvent&) = default;
};

}  // namespace scree
