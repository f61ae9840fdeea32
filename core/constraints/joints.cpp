// Calls that create, change, read and destroy joints.
#include <core/constraints/joint_parameters.h>
#include <core/constraints/user_rows.h>
#include <core/state/recording_format/recorded_calls.h>
#include <core/world/check.h>
#include <core/world/edit.h>
#include <core/world/fp_environment.h>
#include <scree/world.h>

#include <algorithm>
#include <cstring>
#include <string>

namespace scree {

namespace {

struct JointRow {
  WorldData& data;
  Joints& joints;
  std::int32_t joint;
  std::size_t row;
  FpEnvironment environment{};  // not the caller's rounding

  bool has(JointFlag flag) const { return (joints.flags[row] & flag) != 0; }
  void set(JointFlag flag, bool on) const {
    const unsigned flags = joints.flags[row];
    joints.flags[row] = static_cast<std::uint8_t>(on ? flags | flag : flags & ~static_cast<unsigned>(flag));
  }
};

JointRow at(Call call, const std::unique_ptr<WorldData>& owner, JointId id) {
  WorldData& data = opened(call, owner);
  const std::int32_t joint = checked_row(call, data, id);
  return {data, data.joints, joint, static_cast<std::size_t>(joint)};
}

Pose unit_pose(const Pose& pose) { return {pose.position, normalize(pose.rotation)}; }

std::int32_t row_of(BodyId body) { return static_cast<std::int32_t>(body.index); }

// All of a new joint, of checked values.
JointId make(WorldData& data, std::int32_t joint, const JointDef& def, const Joint& given) {
  Joints& joints = data.joints;
  const auto row = static_cast<std::size_t>(joint);
  joints.marks.mark(joint);
  if (joints.generation[row] == 0) joints.generation[row] = 1;
  joints.type[row] = type_of(given);
  joints.flags[row] = flags_of(def, given);
  joints.bodies[row] = {row_of(def.body_a), row_of(def.body_b)};
  joints.frame_a[row] = unit_pose(def.frame_a);
  joints.frame_b[row] = unit_pose(def.frame_b);
  joints.parameters[row] = parameters_of(normalized(given), def.hertz, def.damping_ratio);
  joints.impulses[row] = {};
  joints.strength[row] = {def.break_force, def.break_torque};
  joints.thresholds[row] = {def.event_force, def.event_torque};
  joints.color[row] = kNoColor;
  joints.user_data[row] = def.user_data;
  joints.reaction[row] = {};
  if (joints.type[row] == JointType::user) enter_user_joint(data, joint);
  link_joint(data, joint);
  place_joint(data, joint);
  ++joints.alive;
  if ((joints.flags[row] & kJointReports) != 0) ++joints.reporting;
  wake_ends(data, joint);
  joints_changed(data, joint, !def.collide_connected);
  return joint_handle(data, joint);
}

void create(Call call, WorldData& data, std::span<const JointDef> defs, std::span<const Joint> joints,
            std::span<JointId> ids) {
  const std::size_t count = defs.size(), rows = data.joints.flags.size();
  check_room(call, "joints", rows, count);
  for (std::size_t i = 0; i < count; ++i) {
    check_joint_def(item_of(call, count, i), data, defs[i], joints[i]);
  }
  const SlotPlan plan(data.joints.free_slots, rows, count);
  reserve_user_joints(
      data, static_cast<std::size_t>(std::count_if(joints.begin(), joints.end(), [](const Joint& joint) {
        return type_of(joint) == JointType::user;
      })));
  grow(data.joints, rows + count - plan.from_free);
  // Nothing can fail from here on.
  for (std::size_t i = 0; i < count; ++i)
    ids[i] = make(data, plan.slot(data.joints.free_slots, i), defs[i], joints[i]);
  take_slots(data.joints, plan);
}

}  // namespace

JointId World::create_joint(const JointDef& def, const Joint& joint) {
  constexpr Call call{"create_joint"};
  const FpEnvironment environment;
  WorldData& data = opened(call, data_);
  const CallRecord<RecordedCall::create_joint> call_record(data, def, joint);
  JointId id;
  create(call, data, {&def, 1}, {&joint, 1}, {&id, 1});
  return id;
}

void World::create_joints(std::span<const JointDef> defs, std::span<const Joint> joints,
                          std::span<JointId> ids) {
  constexpr Call call{"create_joints"};
  const FpEnvironment environment;
  if (joints.size() != defs.size() || ids.size() != defs.size()) {
    fail(call, std::to_string(defs.size()) + " definitions, but " + std::to_string(joints.size()) +
                   " joints and room for " + std::to_string(ids.size()) + " ids");
  }
  WorldData& data = opened(call, data_);
  const CallRecord<RecordedCall::create_joints> call_record(data, defs, joints);
  create(call, data, defs, joints, ids);
}

void World::destroy_joint(JointId joint) {
  const JointRow j = at({"destroy_joint"}, data_, joint);
  const CallRecord<RecordedCall::destroy_joint> call_record(j.data, joint);
  remove_joint(j.data, j.joint);
}

bool World::is_alive(JointId joint) const noexcept {
  if (data_ == nullptr) return false;
  const Joints& joints = data_->joints;
  return is_own(*data_, joint) && joint.index < joints.flags.size() &&
         joints.generation[joint.index] == joint.generation && (joints.flags[joint.index] & kJointAlive) != 0;
}

std::size_t World::joint_count() const noexcept { return data_ != nullptr ? data_->joints.alive : 0; }

JointType World::joint_type(JointId joint) const {
  const JointRow j = at({"joint_type"}, data_, joint);
  return j.joints.type[j.row];
}

Joint World::joint(JointId joint) const {
  const JointRow j = at({"joint"}, data_, joint);
  return joint_of(j.joints.type[j.row], j.joints.parameters[j.row]);
}

JointDef World::joint_def(JointId joint) const {
  const JointRow j = at({"joint_def"}, data_, joint);
  return def_of(j.data, j.joint);
}

void World::set_joint(JointId joint, const Joint& to) {
  constexpr Call call{"set_joint"};
  const JointRow j = at(call, data_, joint);
  const CallRecord<RecordedCall::set_joint> call_record(j.data, joint, to);
  check_joint(call, to);
  const JointType type = j.joints.type[j.row];
  if (type_of(to) != type) {
    fail(call, std::string("the value is of a ") + name_of(type_of(to)) + " joint, must be of a " +
                   name_of(type) + " joint as this one");
  }
  JointParameters& parameters = j.joints.parameters[j.row];
  if (to == joint_of(type, parameters)) return;  // of unit length it may have other bits
  const JointParameters wanted = parameters_of(normalized(to), parameters.hertz, parameters.damping_ratio);
  if (std::memcmp(&wanted, &parameters, sizeof wanted) == 0) return;
  parameters = wanted;
  j.set(kJointRich, is_rich(to));
  if (type == JointType::user) drop_user_rows(j.data, j.joint);
  wake_ends(j.data, j.joint);
}

void World::set_joint_frames(JointId joint, const Pose& frame_a, const Pose& frame_b) {
  constexpr Call call{"set_joint_frames"};
  const JointRow j = at(call, data_, joint);
  const Pose a = frame_a, b = frame_b;  // which may be entries of poses()
  const CallRecord<RecordedCall::set_joint_frames> call_record(j.data, joint, a, b);
  const JointBodies ends = j.joints.bodies[j.row];
  check_joint_frames(call, !is_listed(ends.a), a, !is_listed(ends.b), b);
  j.joints.frame_a[j.row] = unit_pose(a);
  j.joints.frame_b[j.row] = unit_pose(b);
  place_joint(j.data, j.joint);
  wake_ends(j.data, j.joint);
}

void World::set_joint_stiffness(JointId joint, float hertz, float damping_ratio) {
  constexpr Call call{"set_joint_stiffness"};
  const JointRow j = at(call, data_, joint);
  const CallRecord<RecordedCall::set_joint_stiffness> call_record(j.data, joint, hertz, damping_ratio);
  check_stiffness(call, "hertz", hertz, "damping_ratio", damping_ratio);
  JointParameters& parameters = j.joints.parameters[j.row];
  parameters = parameters_of(joint_of(j.joints.type[j.row], parameters), hertz, damping_ratio);
  wake_ends(j.data, j.joint);
}

void World::set_joint_strength(JointId joint, float break_force, float break_torque) {
  constexpr Call call{"set_joint_strength"};
  const JointRow j = at(call, data_, joint);
  const CallRecord<RecordedCall::set_joint_strength> call_record(j.data, joint, break_force, break_torque);
  check_strength(call, "break_force", break_force);
  check_strength(call, "break_torque", break_torque);
  j.joints.strength[j.row] = {break_force, break_torque};
  j.set(kJointBreaks, breaks({break_force, break_torque}));
}

void World::set_joint_event_thresholds(JointId joint, float event_force, float event_torque) {
  constexpr Call call{"set_joint_event_thresholds"};
  const JointRow j = at(call, data_, joint);
  const CallRecord<RecordedCall::set_joint_event_thresholds> call_record(j.data, joint, event_force,
                                                                         event_torque);
  check_event_threshold(call, "event_force", event_force);
  check_event_threshold(call, "event_torque", event_torque);
  j.joints.thresholds[j.row] = {event_force, event_torque};
  const bool reported = j.has(kJointReports), reports_now = reports({event_force, event_torque});
  j.joints.reporting += (reports_now ? 1 : 0) - (reported ? 1 : 0);
  j.set(kJointReports, reports_now);
}

bool World::is_enabled(JointId joint) const { return at({"is_enabled"}, data_, joint).has(kJointEnabled); }

void World::set_joint_enabled(JointId joint, bool enabled) {
  const JointRow j = at({"set_joint_enabled"}, data_, joint);
  const CallRecord<RecordedCall::set_joint_enabled> call_record(j.data, joint, enabled);
  if (j.has(kJointEnabled) != enabled) {
    j.set(kJointEnabled, enabled);
    j.joints.impulses[j.row] = {};
    j.joints.reaction[j.row] = {};
    j.joints.color[j.row] = kNoColor;
    joints_changed(j.data, j.joint, !j.has(kJointCollides));
  }
  wake_ends(j.data, j.joint);
}

bool World::collides_connected(JointId joint) const {
  return at({"collides_connected"}, data_, joint).has(kJointCollides);
}

void World::set_collide_connected(JointId joint, bool collide) {
  const JointRow j = at({"set_collide_connected"}, data_, joint);
  const CallRecord<RecordedCall::set_collide_connected> call_record(j.data, joint, collide);
  if (j.has(kJointCollides) == collide) return;
  j.set(kJointCollides, collide);
  joints_changed(j.data, j.joint, true);
  wake_ends(j.data, j.joint);
}

std::uint64_t World::user_data(JointId joint) const {
  const JointRow j = at({"user_data"}, data_, joint);
  return j.joints.user_data[j.row];
}

void World::set_user_data(JointId joint, std::uint64_t user_data) {
  const JointRow j = at({"set_user_data"}, data_, joint);
  const CallRecord<RecordedCall::set_joint_user_data> call_record(j.data, joint, user_data);
  j.joints.user_data[j.row] = user_data;
}

Pose World::joint_pose(JointId joint) const {
  const JointRow j = at({"joint_pose"}, data_, joint);
  // Made here: those of the row may wait for place_matter().
  const JointFrames frames =
      frames_of(j.data.bodies, j.joints.bodies[j.row], j.joints.frame_a[j.row], j.joints.frame_b[j.row]);
  const PoseRow& a = j.data.bodies.pose[frames.row_a];
  const PoseRow& b = j.data.bodies.pose[frames.row_b];
  const Quat rotation_a = to_quat(a.rotation), rotation_b = to_quat(b.rotation);
  const Quat frame_a = rotation_a * to_quat(frames.rotation_a);
  const Quat frame_b = rotation_b * to_quat(frames.rotation_b);
  // Differences of centers first: far from the origin they are all that is exact.
  const Vec3 offset = (to_vec3(b.position) - to_vec3(a.position)) +
                      rotate(rotation_b, to_vec3(frames.anchor_b)) -
                      rotate(rotation_a, to_vec3(frames.anchor_a));
  return {rotate_back(frame_a, offset), normalize(conjugate(frame_a) * frame_b)};
}

JointReaction World::joint_reaction(JointId joint) const {
  const JointRow j = at({"joint_reaction"}, data_, joint);
  const JointReactionRow& row = j.joints.reaction[j.row];
  return {to_vec3(row.force), to_vec3(row.torque)};
}

std::size_t World::joints_of(BodyId body, std::span<JointId> out) const {
  constexpr Call call{"joints_of"};
  const WorldData& data = opened(call, data_);
  const std::int32_t row = checked_row(call, data, body);
  std::size_t count = 0;
  for (std::int32_t joint = data.bodies.first_joint[body.index]; joint >= 0;
       joint = next_joint(data.joints, joint, row)) {
    if (count < out.size()) out[count] = joint_handle(data, joint);
    ++count;
  }
  return count;
}

}  // namespace scree
