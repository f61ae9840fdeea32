// Lists the events of bodies and joints: bodies that fell asleep or woke, joints that were destroyed with
// their bodies, and user joints that were frozen.
#include <parallel/distributed/border.h>
#include <parallel/islands/islands.h>
#include <parallel/stages.h>

#include <algorithm>

namespace scree {

namespace {

// A body that has woken since the last step, by a call or in this step, may have been destroyed since.
bool is_still_there(const WorldData& data, SlotName body) {
  const Bodies& bodies = data.bodies;
  return bodies.generation[body.index] == body.generation && bodies.type[body.index] == BodyType::dynamic &&
         tells_of(border_of(data), static_cast<std::int32_t>(body.index),
                  static_cast<std::int32_t>(body.index));
}

}  // namespace

void list_body_events(WorldData& data) {
  Events& events = data.events;
  for (const std::int32_t body : islands_of(data).fallen_asleep) {
    if (tells_of(border_of(data), body, body)) events.sleep_begins.push_back(body_handle(data, body));
  }
  for (const SlotName& body : events.woken) {
    if (is_still_there(data, body)) events.sleep_ends.push_back(handle_of<BodyId>(data, body));
  }
  std::sort(events.sleep_ends.begin(), events.sleep_ends.end());
  events.woken.clear();
  events.destroyed.clear();
  for (const SlotName& joint : events.lost) events.destroyed.push_back(handle_of<JointId>(data, joint));
  events.lost.clear();
  UserJoints& users = data.user_joints;
  for (std::size_t row = 0; row < users.state.size(); ++row) {
    if (users.state[row] != kUserFreezes) continue;
    users.state[row] = kUserFrozen;
    const JointBodies ends = data.joints.bodies[users.joint[row]];
    if (!tells_of(border_of(data), ends.a, ends.b)) continue;
    events.frozen.push_back(joint_handle(data, users.joint[row]));
  }
  std::sort(events.frozen.begin(), events.frozen.end(),
            [](JointId a, JointId b) { return a.index < b.index; });
}

}  // namespace scree
