// Islands: sets of bodies that hang together by contacts and joints, and union-find over them.
#pragma once

#include <core/world/wake.h>
#include <parallel/crew/crew.h>

namespace scree {

struct Islands : Part {
  Column<std::int32_t> parent;  // scratch; put_islands_to_sleep; by body: towards the island's smallest body
  Column<std::uint8_t>
      tired;  // scratch; put_islands_to_sleep; by body: may fall asleep; zero between the steps
  Column<std::uint8_t> kept_awake;  // scratch; put_islands_to_sleep; by root: a body that moves touches it
  Column<std::int32_t> candidates;  // scratch; both; bodies that may fall asleep, or that wake, ascending
  Column<std::int32_t> touched;     // scratch; wake_touched_islands; contacts of an awake and a sleeping body
  Column<std::int32_t> pulled;      // scratch; wake_touched_islands; joints of an awake and a sleeping body
  Column<std::int32_t> fallen_asleep;  // scratch; put_islands_to_sleep; bodies of this step, ascending
  Column<std::uint8_t> reached;        // scratch; wake_touched_islands; by body; zero between the steps
  Column<std::int32_t> remaining;      // scratch; both; contacts that still take part
  Column<std::int32_t>
      fixed_ends;  // scratch; refresh_joints; of the active joints, a body as often as it has some
  std::int64_t joints_judged = 0;  // derived; refresh_joints; looked at in this step for who is active
  Column<std::int32_t> places;     // scratch; all of this folder; by chunk: where its part begins

  void report(const Visit& visit) const override;
  void forget() noexcept override;
};

Islands& islands_of(WorldData& data);

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
