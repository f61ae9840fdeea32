// Edits joints: updates the lists of their bodies and their frames, and notes changes; see edit.h.
//
// Results depend on the forward links only. The links back are derived: without them, removing thousands of
// joints from a body, the oldest first, would take time that grows with the square of their number.
#include <core/constraints/joint_parameters.h>
#include <core/constraints/user_rows.h>
#include <core/world/edit.h>

namespace scree {

namespace {

void note_jointed(Bodies& bodies, std::int32_t body) {
  const auto row = static_cast<std::size_t>(body);
  constexpr auto kJointed = static_cast<std::uint32_t>(kMotionJointed);
  bodies.marks.mark(body);  // of its first joint, too
  std::uint32_t& flags = bodies.motion[row].flags;
  flags = bodies.first_joint[row] >= 0 ? flags | kJointed : flags & ~kJointed;
}

// Puts the joint at the front of the body's list.
void enter_list(WorldData& data, std::int32_t joint, std::int32_t body) {
  if (!is_listed(body)) return;
  Joints& joints = data.joints;
  std::int32_t& first = data.bodies.first_joint[body];
  if (first >= 0) {
    const auto old = static_cast<std::size_t>(first);
    SCREE_ASSERT(link_of(joints.previous[old], joints.bodies[old], body) == -1);
    link_of(joints.previous[old], joints.bodies[old], body) = joint;
  }
  const auto row = static_cast<std::size_t>(joint);
  link_of(joints.next[row], joints.bodies[row], body) = first;
  first = joint;
  note_jointed(data.bodies, body);
}

// Their shapes must be checked for joints, and their pairs found again.
void note_ends(WorldData& data, const JointBodies& ends) {
  if (is_listed(ends.a)) note_shapes(data, ends.a);
  if (is_listed(ends.b)) note_shapes(data, ends.b);
}

void leave_list(WorldData& data, std::int32_t joint, std::int32_t body) {
  if (!is_listed(body)) return;
  Joints& joints = data.joints;
  const auto row = static_cast<std::size_t>(joint);
  const std::int32_t before = link_of(joints.previous[row], joints.bodies[row], body);
  const std::int32_t behind = link_of(joints.next[row], joints.bodies[row], body);
  if (before >= 0) {
    const auto other = static_cast<std::size_t>(before);
    SCREE_ASSERT(link_of(joints.next[other], joints.bodies[other], body) == joint);
    link_of(joints.next[other], joints.bodies[other], body) = behind;
    joints.marks.mark(before);
  } else {
    SCREE_ASSERT(data.bodies.first_joint[body] == joint);
    data.bodies.first_joint[body] = behind;
  }
  if (behind >= 0) {
    const auto other = static_cast<std::size_t>(behind);
    link_of(joints.previous[other], joints.bodies[other], body) = before;
  }
  note_jointed(data.bodies, body);
}

}  // namespace

void link_joint(WorldData& data, std::int32_t joint) {
  const auto row = static_cast<std::size_t>(joint);
  const JointBodies ends = data.joints.bodies[row];
  data.joints.marks.mark(joint);
  data.joints.next[row] = {-1, -1};
  data.joints.previous[row] = {-1, -1};
  enter_list(data, joint, ends.a);
  enter_list(data, joint, ends.b);
  note_ends(data, ends);
}

void link_back(WorldData& data, std::int32_t joint) {
  Joints& joints = data.joints;
  const auto row = static_cast<std::size_t>(joint);
  const JointBodies ends = joints.bodies[row];
  for (const std::int32_t body : {ends.a, ends.b}) {
    const std::int32_t behind = next_joint(joints, joint, body);
    if (!is_listed(body) || behind < 0) continue;
    const auto other = static_cast<std::size_t>(behind);
    link_of(joints.previous[other], joints.bodies[other], body) = joint;
  }
}

void remove_joint(WorldData& data, std::int32_t joint) {
  Joints& joints = data.joints;
  const auto row = static_cast<std::size_t>(joint);
  const JointBodies ends = joints.bodies[row];
  SCREE_ASSERT((joints.flags[row] & kJointAlive) != 0);
  wake_ends(data, joint);
  joints_changed(data, joint, (joints.flags[row] & kJointCollides) == 0);
  leave_list(data, joint, ends.a);
  leave_list(data, joint, ends.b);
  joints.marks.mark(joint);
  if (joints.type[row] == JointType::user) leave_user_joint(data, joint);
  if ((joints.flags[row] & kJointReports) != 0) --joints.reporting;
  joints.flags[row] = 0;
  joints.next[row] = {-1, -1};
  joints.previous[row] = {-1, -1};
  joints.impulses[row] = {};
  joints.reaction[row] = {};
  // A slot whose generations are used up stays empty for good.
  if (++joints.generation[row] != 0) joints.free_slots.push_back(joint);
  --joints.alive;
}

std::size_t count_joints(const WorldData& data, std::int32_t body) {
  std::size_t count = 0;
  for (std::int32_t joint = data.bodies.first_joint[body]; joint >= 0;
       joint = next_joint(data.joints, joint, body)) {
    ++count;
  }
  return count;
}

void place_joint(WorldData& data, std::int32_t joint) {
  Joints& joints = data.joints;
  const auto row = static_cast<std::size_t>(joint);
  joints.frames[row] = frames_of(data.bodies, joints.bodies[row], joints.frame_a[row], joints.frame_b[row]);
}

void place_joints_of(WorldData& data, std::int32_t body) {
  for (std::int32_t joint = data.bodies.first_joint[body]; joint >= 0;
       joint = next_joint(data.joints, joint, body)) {
    place_joint(data, joint);
  }
}

void joints_changed(WorldData& data, std::int32_t joint, bool keeps_apart) {
  note_change(data.joints, joint);
  const JointBodies ends = data.joints.bodies[joint];
  if (!keeps_apart || !is_listed(ends.a) || !is_listed(ends.b)) return;
  note_ends(data, ends);
  data.contacts.pairs_stale = true;
}

void wake_ends(WorldData& data, std::int32_t joint) {
  const JointBodies ends = data.joints.bodies[joint];
  wake_body(data, ends.a);
  wake_body(data, ends.b);
}

}  // namespace scree
