// Islands: sets of bodies that contacts and joints connect. Data of the phases of this folder.
#pragma once

#include <core/world/wake.h>
#include <parallel/crew/crew.h>

#include <memory>

namespace scree {

// clang-format off
#define SCREE_ISLAND_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                                   \
  LIST (scratch, std::int32_t, parent)        /* put_islands_to_sleep; by body: towards the island's smallest body */ \
  LIST (scratch, std::uint8_t, tired)         /* put_islands_to_sleep; by body: may fall asleep; zero between the \
                                                 steps */                                                       \
  LIST (scratch, std::uint8_t, kept_awake)    /* put_islands_to_sleep; by root: a body that moves touches it */ \
  LIST (scratch, std::int32_t, candidates)    /* both; bodies that may fall asleep, or that wake, ascending */  \
  LIST (scratch, std::int32_t, waking_contacts) /* wake_touched_islands; contacts of an awake and a sleeping body */ \
  LIST (scratch, std::int32_t, waking_joints) /* wake_touched_islands; joints of an awake and a sleeping body */ \
  LIST (scratch, std::int32_t, fallen_asleep) /* put_islands_to_sleep; bodies of this step, ascending */        \
  LIST (scratch, std::uint8_t, reached)       /* wake_touched_islands; by body; zero between the steps */       \
  LIST (scratch, std::int32_t, remaining)     /* both; contacts that still take part */                         \
  LIST (scratch, std::int32_t, fixed_ends)    /* refresh_joints; of the active joints, a body as often as it has \
                                                 some */                                                        \
  VALUE(derived, std::int64_t, joints_judged, 0) /* refresh_joints; joints that this step examined */           \
  LIST (scratch, std::int32_t, places)        /* of list_where, in all of this folder */
// clang-format on
SCREE_PART(Islands, SCREE_ISLAND_MEMBERS)

inline Islands& islands_of(WorldData& data) {
  if (data.islands == nullptr) data.islands = std::make_unique<Islands>();
  return static_cast<Islands&>(*data.islands);
}

// Bodies::changed -> Joints::changed. Called by refresh_lists, before it forgets them.
void note_joints(WorldData& data);

inline bool is_asleep(const Bodies& bodies, std::int32_t body) {
  return (bodies.flags[body] & kBodyAsleep) != 0;
}

inline bool is_enabled(const Joints& joints, std::int32_t joint) {
  constexpr std::uint8_t kWhole = kJointAlive | kJointEnabled;
  return (joints.flags[joint] & kWhole) == kWhole;
}

// The bodies of a contact, by its row in Contacts::now, and of a joint.
struct Ends {
  std::int32_t a, b;
};
inline Ends contact_ends(const WorldData& data, std::int32_t contact) {
  const ShapePair pair = data.contacts.now.pair[contact];
  return {data.shapes.body[pair.a], data.shapes.body[pair.b]};
}
inline Ends joint_ends(const WorldData& data, std::int32_t joint) {
  const JointBodies bodies = data.joints.bodies[joint];
  return {bodies.a, bodies.b};
}

// Whether a contact or joint of these bodies has something to solve.
inline bool takes_part(const WorldData& data, Ends ends) {
  return is_awake_dynamic(data.bodies, ends.a) || is_awake_dynamic(data.bodies, ends.b);
}

}  // namespace scree
