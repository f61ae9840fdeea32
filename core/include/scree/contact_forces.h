// Forces of contacts: what touching shapes did to each other in the last step.
//
// A world measures them while WorldSettings::contact_forces asks for it; World::contact_forces reads them.
// Everything is an impulse of the whole step, all substeps and rebounds included: divided by the step's dt it
// is the mean force. All that a contact did is one force at each point along the normal, the friction of all
// points together as one force at the friction center and a twist about the normal, and the torque of rolling
// resistance. Of the forces on a body that is all: added up with those of gravity, of joints and of the
// caller, they are what its momentum has changed by.
#pragma once

#include <scree/ids.h>
#include <scree/math.h>

#include <cstdint>

namespace scree {

/// One point of a contact, as the step found it at its beginning, and what it bore.
struct ContactForcePoint {
  Vec3 position;                ///< m, in world coordinates, between the two surfaces
  float separation = 0.0f;      ///< m; negative where the shapes overlap
  float normal_impulse = 0.0f;  ///< N s, at least 0: on body_b along the normal, on body_a against it
};

/// Two shapes in contact and the impulses on body_b; body_a got their opposites. Places are those at the
/// beginning of the step: moments about a body's center of mass balance about where that was then.
struct ContactForces {
  ShapeId shape_a;               ///< the one with the lower index
  ShapeId shape_b;               ///< the one with the higher index
  BodyId body_a;                 ///< the body of shape_a
  BodyId body_b;                 ///< the body of shape_b
  Vec3 normal;                   ///< unit, from a to b
  Vec3 friction_center;          ///< m, in world coordinates: where friction acts
  Vec3 friction_impulse;         ///< N s, square to the normal; in each substep at most the coefficient of
                                 ///< friction times the sum of the points' impulses
  float twist_impulse = 0.0f;    ///< N m s, about the normal: friction against spin
  Vec3 rolling_impulse;          ///< N m s, of rolling resistance
  std::int32_t point_count = 0;  ///< the nearest point, those less than 2 cm apart, and those that bore
  ContactForcePoint points[4];   ///< the first `point_count` count, the others are zero
  /// The batch of independent constraints that it is solved in, from 0; -1 while no step has solved it.
  /// Contacts with what cannot be pushed, and those with bodies of more than 32 contacts, count batches of
  /// their own. 64 and 65: no batch was free, and it is solved with a few others after them.
  std::int32_t color = -1;
};

/// N s, all points together, along the normal.
SCREE_INLINE constexpr float normal_impulse(const ContactForces& contact) {
  return contact.points[0].normal_impulse + contact.points[1].normal_impulse +
         contact.points[2].normal_impulse + contact.points[3].normal_impulse;
}
/// N s, all that acted on body_b; on body_a its opposite.
SCREE_INLINE constexpr Vec3 impulse_on_b(const ContactForces& contact) {
  return normal_impulse(contact) * contact.normal + contact.friction_impulse;
}
/// N m s about a point of the world, all that acted on body_b; on body_a its opposite.
SCREE_INLINE constexpr Vec3 moment_on_b(const ContactForces& contact, Vec3 about) {
  Vec3 moment = cross(contact.friction_center - about, contact.friction_impulse) +
                contact.twist_impulse * contact.normal + contact.rolling_impulse;
  for (const ContactForcePoint& point : contact.points) {
    moment += point.normal_impulse * cross(point.position - about, contact.normal);
  }
  return moment;
}

}  // namespace scree
