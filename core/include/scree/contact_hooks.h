// Hooks: functions of the caller that decide about contacts while a step runs, before its solver.
//
// A step calls the hooks for pairs of shapes of which one asks by ShapeOptions::contact_hooks, and of which a
// body is awake as the step begins: the filter for candidate pairs, before they are collided; the rule for
// what touches or nearly does, before it is solved. Each decides for this step alone and is asked anew in the
// next one. World's set_contact_filter and set_contact_rule set them.
//
// A call gets some of the pairs, as columns, ascending by the indices of their shapes. Several calls run at
// once, on the threads of the step, each for pairs of its own; which pairs come together depends on the scene
// alone. For results that can be repeated the answers must depend on the batch and on what does not change
// meanwhile, and on nothing else. A hook may call those const functions of the world that read bodies,
// shapes, joints and settings: they tell how things stand as the step begins. It may not ask queries, events
// or forces.
//
// If a hook throws, the step ignores all of its answers, goes on to its end, and then throws the same; of
// several exceptions that of the first pairs, and of two hooks that of the filter. A hook had better not
// throw std::bad_alloc: from a step it means that the world is lost.
#pragma once

#include <scree/events.h>
#include <scree/ids.h>
#include <scree/math_types.h>

#include <cstdint>
#include <functional>
#include <span>

namespace scree {

class World;

/// Which hooks are asked about the contacts of a shape; combine with |. A pair is asked about if either shape
/// asks.
enum class ContactHooks : std::uint8_t {
  none = 0,    ///< no hooks
  filter = 1,  ///< the function of World::set_contact_filter
  rule = 2,    ///< the function of World::set_contact_rule
  all = 3,     ///< both
};

/// The hooks of both.
constexpr ContactHooks operator|(ContactHooks left, ContactHooks right) {
  return static_cast<ContactHooks>(static_cast<unsigned>(left) | static_cast<unsigned>(right));
}
/// Whether `hooks` and `kind` have a hook in common.
constexpr bool contains(ContactHooks hooks, ContactHooks kind) {
  return (static_cast<unsigned>(hooks) & static_cast<unsigned>(kind)) != 0;
}

/// Two shapes that a hook is asked about.
struct HookedPair {
  ShapeId shape_a;  ///< the one with the lower index
  ShapeId shape_b;  ///< the one with the higher index
  BodyId body_a;    ///< the body of shape_a
  BodyId body_b;    ///< the body of shape_b

  friend bool operator==(const HookedPair&, const HookedPair&) = default;
};

/// Where two shapes touch, or soon may. A pair with a mesh has several contacts if its surfaces meet at
/// several angles.
struct HookedContact {
  Vec3 normal;                   ///< unit, from a to b
  std::int32_t point_count = 0;  ///< in [1, 4]
  ContactPoint points[4];        ///< the first `point_count` count; some may lie far apart
};

/// How a contact acts.
struct ContactRules {
  bool acts = true;                 ///< false: in this step as if the shapes did not touch there
  float friction = 0.0f;            ///< Coulomb coefficient, in [0, 1e6]
  float restitution = 0.0f;         ///< rebound speed over approach speed, in [0, 1]
  float rolling_resistance = 0.0f;  ///< m: resisting torque over normal force, in [0, 1e5]
  /// m/s, of b's surface against a's, in the axes of the world, each within +-2e6. Only what lies in the
  /// plane of contact acts. A belt at rest, shape a, that carries boxes with v has -v.
  Vec3 surface_velocity{};

  friend bool operator==(const ContactRules&, const ContactRules&) = default;
};

/// Candidate pairs: those that come near each other in this step by the velocities with which it begins.
/// `collide` is 1 for each; a hook writes 0 for those that do not collide in this step, not by the sweep of
/// fast bodies either.
struct ContactFilterBatch {
  const World& world;                 ///< as the step begins; see above for what may be called
  float dt;                           ///< s, of the step
  std::span<const HookedPair> pairs;  ///< that may collide
  std::span<std::uint8_t> collide;    ///< to be written, by pair
};

/// Contacts, one entry each: pairs[i] has contacts[i], which acts by rules[i]. The rules come as the
/// materials of the shapes give them. Rules out of range, or not finite, change nothing;
/// StepStats::unsound_rules counts them.
struct ContactRuleBatch {
  const World& world;                       ///< as the step begins; see above for what may be called
  float dt;                                 ///< s, of the step
  std::span<const HookedPair> pairs;        ///< whose shapes touch, by contact
  std::span<const HookedContact> contacts;  ///< where they do
  std::span<ContactRules> rules;            ///< to be written, by contact
};

/// Decides which pairs collide in a step, see World::set_contact_filter.
using ContactFilter = std::function<void(const ContactFilterBatch& batch)>;
/// Decides how contacts act in a step, see World::set_contact_rule.
using ContactRule = std::function<void(const ContactRuleBatch& batch)>;

/// What a hook has decided about a pair, for World::answer_contact_hooks.
struct ContactAnswer {
  ShapeId shape_a;  ///< the one with the lower index
  ShapeId shape_b;  ///< the one with the higher index
  /// -1: the pair does not collide, and `rules` does not matter; else which of its contacts is meant, in the
  /// order in which the rule gets them. 0 of a pair without meshes.
  std::int32_t contact = -1;
  ContactRules rules{};  ///< how the contact acts

  friend bool operator==(const ContactAnswer&, const ContactAnswer&) = default;
};

}  // namespace scree
