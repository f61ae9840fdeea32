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

/// Two shapes that touch: an entry of World::contact_begins or World::contact_persists.
struct ContactEvent {
  ShapeId shape_a;              ///< the one with the lower index
  ShapeId shape_b;              ///< the one with the higher index
  BodyId body_a;                ///< the body of shape_a
  BodyId body_b;                ///< the body of shape_b
  Vec3 normal;                  ///< unit, from a to b
  float normal_impulse = 0.0f;  ///< N s, of all points over the whole step; 0 after a step of no length
  float approach_speed = 0.0f;  ///< m/s, the largest of the points when the step began; 0 if none came closer
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
