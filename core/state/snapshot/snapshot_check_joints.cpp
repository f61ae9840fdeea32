// Checks of joints from outside: values within the limits of check.h, lists that hold each joint once.
#include <core/constraints/joint_parameters.h>
#include <core/constraints/user_rows.h>
#include <core/state/snapshot/snapshot_refusal.h>
#include <core/world/check.h>

#include <cstring>

namespace scree {

namespace {

// What a call could have made. What a joint has accumulated may be any numbers, as of contacts.
void check_living_joint(const WorldData& data, std::size_t row, const Refusal& refusal) {
  const Joints& joints = data.joints;
  const auto require = [&](bool holds, const char* name, const char* problem) {
    refusal.require(holds, "joints", name, row, problem);
  };
  const JointParameters& parameters = joints.parameters[row];
  const Joint joint = joint_of(joints.type[row], parameters);
  const JointDef def = def_of(data, static_cast<std::int32_t>(row));
  try {
    check_joint_def({"create_joint"}, data, def, joint);
  } catch (const Error& error) {
    require(false, "parameters", error.what());
  }
  const JointParameters right = parameters_of(joint, parameters.hertz, parameters.damping_ratio);
  require(std::memcmp(&right, &parameters, sizeof right) == 0, "parameters", "is not that of such a joint");
  const unsigned derived = kJointBreaks | kJointRich | kJointReports;
  require((joints.flags[row] & derived) == (flags_of(def, joint) & derived), "flags",
          "are not those of the joint");
}

// Every living joint stands once in the list of each of its bodies but the world.
void check_joint_lists(const WorldData& data, const Refusal& refusal) {
  const Joints& joints = data.joints;
  std::vector<std::uint8_t> listed(joints.flags.size());
  for (std::size_t body = 0; body < data.bodies.flags.size(); ++body) {
    const auto number = static_cast<std::int32_t>(body);
    std::int32_t from = -1;
    for (std::int32_t joint = data.bodies.first_joint[body]; joint != -1;) {
      bool fits = joint >= 0 && at(joint) < listed.size() && (joints.flags[joint] & kJointAlive) != 0;
      const JointBodies ends = fits ? joints.bodies[joint] : JointBodies{-1, -1};
      const unsigned side = ends.a == number ? 1 : 2;
      fits = fits && (ends.a == number || ends.b == number) && (listed[at(joint)] & side) == 0;
      refusal.require(fits, from < 0 ? "bodies" : "joints", from < 0 ? "first_joint" : "next",
                      from < 0 ? body : at(from), "is no joint of the body, or stands in its list twice");
      listed[at(joint)] = static_cast<std::uint8_t>(listed[at(joint)] | side);
      from = joint;
      joint = next_joint(joints, joint, number);
    }
  }
  for (std::size_t row = 0; row < listed.size(); ++row) {
    if ((joints.flags[row] & kJointAlive) == 0) continue;
    const JointBodies ends = joints.bodies[row];
    const unsigned wanted = (is_listed(ends.a) ? 1u : 0u) | (is_listed(ends.b) ? 2u : 0u);
    refusal.require(listed[row] == wanted, "joints", "bodies", row, "do not list the joint");
    const JointBodies next = joints.next[row];
    const bool none = (is_listed(ends.a) || next.a == -1) && (is_listed(ends.b) || next.b == -1);
    refusal.require(none, "joints", "next", row, "the world has no list");
  }
}

// Every living user joint has its numbers once, which calls could have given.
void check_user_joints(const WorldData& data, const Refusal& refusal) {
  const UserJoints& users = data.user_joints;
  std::vector<std::uint8_t> has_numbers(data.joints.flags.size());
  for (std::size_t row = 0; row < users.joint.size(); ++row) {
    const auto require = [&](bool holds, const char* name, const char* problem) {
      refusal.require(holds, "user_joints", name, row, problem);
    };
    const std::size_t joint = at(users.joint[row]);
    const bool is_user =
        (data.joints.flags[joint] & kJointAlive) != 0 && data.joints.type[joint] == JointType::user;
    require(is_user && has_numbers[joint] == 0, "joint", "is no user joint, or stands there twice");
    has_numbers[joint] = 1;
    const int count = user_row_count(data.joints.parameters[joint]);
    for (int i = 0; i < kUserRows; ++i) {
      const UserRow given = user_row(users, static_cast<std::int32_t>(row), i);
      if (i < count) {
        require(is_user_row(given), "jacobians", "have numbers out of range");
      } else {
        require(given == UserRow{}, "jacobians", "have numbers of rows that the joint lacks");
      }
    }
  }
  for (std::size_t joint = 0; joint < has_numbers.size(); ++joint) {
    const bool is_user =
        (data.joints.flags[joint] & kJointAlive) != 0 && data.joints.type[joint] == JointType::user;
    refusal.require(!is_user || has_numbers[joint] != 0, "joints", "type", joint,
                    "is that of a user joint, which has no numbers");
  }
}

}  // namespace

void check_joints(const WorldData& data, const Refusal& refusal) {
  const Joints& joints = data.joints;
  const auto is_alive = [&](std::size_t row) { return (joints.flags[row] & kJointAlive) != 0; };
  for (std::size_t row = 0; row < joints.flags.size(); ++row) {
    if (is_alive(row)) check_living_joint(data, row, refusal);
  }
  check_user_joints(data, refusal);
  check_joint_lists(data, refusal);
  check_free_slots(joints, 0, "joints", refusal, is_alive);
}

}  // namespace scree
