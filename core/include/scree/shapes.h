// Shapes, their surface, and which of them collide.
#pragma once

#include <scree/contact_hooks.h>
#include <scree/math_types.h>

#include <cstdint>
#include <optional>

namespace scree {

/// A ball around the shape's origin.
struct Sphere {
  float radius = 0.5f;  ///< m, in [1e-4, 1e5]
};

/// All points within `radius` of the segment from (0, -half_height, 0) to (0, half_height, 0).
struct Capsule {
  float half_height = 0.5f;  ///< m, half the length of the inner segment, in [1e-4, 1e5]
  float radius = 0.25f;      ///< m, in [1e-4, 1e5]
};

/// A box centered on the shape's origin, its edges along the shape's axes. With a rounding: all points within
/// that distance of the box of `half_extents`, so that its edges and corners are round and its faces lie
/// farther out.
struct Box {
  Vec3 half_extents{0.5f, 0.5f, 0.5f};  ///< m, each in [1e-4, 1e5]
  float rounding = 0.0f;                ///< m, in [0, 1e5]
};

/// A cylinder about the y axis, from y = -half_height to y = half_height.
struct Cylinder {
  float half_height = 0.5f;  ///< m, in [1e-4, 1e5]
  float radius = 0.5f;       ///< m, in [1e-4, 1e5]
};

/// A cone about the y axis: its apex is (0, half_height, 0), its base the disk of `radius` about
/// (0, -half_height, 0). Its center of mass lies at y = -half_height / 2.
struct Cone {
  float half_height = 0.5f;  ///< m, half the distance from base to apex, in [1e-4, 1e5]
  float radius = 0.5f;       ///< m, of the base, in [1e-4, 1e5]
};

/// All that lies below the plane y = 0 of the shape's frame, without end: a ground, or a wall, that nothing
/// gets to the other side of. A plane that is tilted against the axes of the world is as exact as float
/// numbers: within 3e-7 of the distance from the shape's origin. It ends 1e8 m from there.
struct HalfSpace {};

/// How the values of two touching surfaces become one. Where the two surfaces ask for different rules, the
/// one that stands later in this list is taken.
enum class MixRule : std::uint8_t {
  minimum,         ///< the smaller value
  average,         ///< half of the sum
  product,         ///< the product
  geometric_mean,  ///< the square root of the product
  maximum,         ///< the larger value
};

/// The surface and the filling of a shape.
struct Material {
  float friction = 0.6f;  ///< Coulomb coefficient, in [0, 1e6]; acts against spin as well: between the points
                          ///< of a contact, and where a sphere or capsule touches in a patch around each
  float restitution = 0.0f;         ///< rebound speed over approach speed, in [0, 1]
  float rolling_resistance = 0.0f;  ///< m: resisting torque over normal force, in [0, 1e5]; of two
                                    ///< surfaces the maximum counts
  float density = 1000.0f;          ///< kg/m^3, in [1e-6, 1e9]; ignored where the body's mass is given
  /// m, in [0, 1e5], of the disk in which spheres and capsules touch. There friction resists spin about the
  /// normal with a torque of at most 3 pi / 16 radius x friction x normal force, which is that of Hertz's
  /// pressure; with 0 a ball spins in place for ever. Of two surfaces the larger one counts. Where neither
  /// gives one: as if what touches gave way by 5 mm or, if that is less, a fiftieth of the radius of its
  /// curvature r, so that the disk's is sqrt(5 mm r) or 0.14 r. Has no effect between boxes and hulls.
  std::optional<float> patch_radius{};
  Vec3 surface_velocity{};  ///< m/s in the shape's frame: a conveyor belt's speed, each within +-1e6
  MixRule friction_mix = MixRule::geometric_mean;  ///< how two coefficients of friction become one
  MixRule restitution_mix = MixRule::maximum;      ///< how two restitutions become one

  friend bool operator==(const Material&, const Material&) = default;
};

/// Two shapes collide if each one's `mask` has a bit of the other's `category`; equal nonzero groups
/// overrule that: positive ones always collide, negative ones never.
struct Filter {
  std::uint32_t category = 1;        ///< bits: what the shape is
  std::uint32_t mask = 0xffffffffu;  ///< bits: the categories that it collides with
  std::int32_t group = 0;            ///< 0: none; see above

  friend bool operator==(const Filter&, const Filter&) = default;
};

/// Which events of a shape's contacts the world lists after each step; combine with |. A contact is listed if
/// either shape or WorldSettings::contact_events asks.
enum class ContactEvents : std::uint8_t {
  none = 0,       ///< no events
  begin_end = 1,  ///< World::contact_begins, World::contact_ends
  persist = 2,    ///< World::contact_persists: in every step that goes on with a contact
  /// World::contact_hits: in every step in which the shapes meet at WorldSettings::hit_event_speed or faster.
  hit = 4,
  all = 7,  ///< all of these
};

/// The events of both.
constexpr ContactEvents operator|(ContactEvents left, ContactEvents right) {
  return static_cast<ContactEvents>(static_cast<unsigned>(left) | static_cast<unsigned>(right));
}
/// Whether `events` and `kind` have an event in common.
constexpr bool contains(ContactEvents events, ContactEvents kind) {
  return (static_cast<unsigned>(events) & static_cast<unsigned>(kind)) != 0;
}

/// What a shape has besides its geometry and its material.
struct ShapeOptions {
  Pose local_pose{};  ///< of the shape in its body's frame: each within +-1e5 m, unit rotation within 1e-3
  Filter filter{};    ///< which shapes it collides with
  std::uint64_t user_data = 0;  ///< any number of the caller's; the library never reads it
  ContactEvents contact_events = ContactEvents::none;  ///< the events that this shape asks for
  /// Whether the shape is a sensor: it has no mass and no contacts, and the world lists which shapes enter
  /// and leave it, see events.h. Stays as it is for the life of the shape.
  bool sensor = false;
  ContactHooks contact_hooks = ContactHooks::none;  ///< the hooks that are asked about its contacts

  friend bool operator==(const ShapeOptions&, const ShapeOptions&) = default;
};

}  // namespace scree
