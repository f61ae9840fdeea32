// Joints as the parameters that kernels read; see joint_parameters.h. What each kind writes and reads stands
// in joints/joint_<kind>.cpp.
#include <core/constraints/joint_parameters.h>
#include <core/constraints/joints/joint_kinds.h>
#include <core/world/edit.h>

#include <utility>

namespace scree {

namespace {

constexpr JointAxisRow kNoAxis{-kNoLimit, kNoLimit, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, kDriveNone};

template <class Kind>
Joint read_kind(const JointParameters& from) {
  Joint joint(std::in_place_type<Kind>);
  joint_kinds::read(from, *std::get_if<Kind>(&joint));
  return joint;
}

}  // namespace

JointParameters parameters_of(const Joint& joint, float hertz, float damping_ratio) {
  JointParameters to{
      {{kNoAxis, kNoAxis, kNoAxis, kNoAxis, kNoAxis, kNoAxis}}, hertz, damping_ratio, hertz, damping_ratio};
  std::visit([&to](const auto& kind) { joint_kinds::write(kind, to); }, joint);
  return to;
}

Joint joint_of(JointType type, const JointParameters& parameters) {
  switch (type) {
#define SCREE_JOINT_TYPE(kind, Struct) \
  case JointType::kind:                \
    return read_kind<Struct>(parameters);
    SCREE_FOR_EACH_JOINT_TYPE(SCREE_JOINT_TYPE)
#undef SCREE_JOINT_TYPE
  }
  return {};
}

const char* name_of(JointType type) {
#define SCREE_JOINT_TYPE(kind, Struct) #kind,
  constexpr const char* kNames[kJointTypeCount] = {SCREE_FOR_EACH_JOINT_TYPE(SCREE_JOINT_TYPE)};
#undef SCREE_JOINT_TYPE
  return kNames[static_cast<std::size_t>(type)];
}

Joint normalized(Joint joint) {
  std::visit([](auto& kind) { joint_kinds::renormalize(kind); }, joint);
  return joint;
}

bool is_rich(const Joint& joint) {
  return std::visit([](const auto& kind) { return joint_kinds::is_rich(kind); }, joint);
}

bool breaks(JointStrength strength) { return strength.force < kNoLimit || strength.torque < kNoLimit; }

bool reports(JointThresholds thresholds) {
  return thresholds.force < kNoLimit || thresholds.torque < kNoLimit;
}

std::uint8_t flags_of(const JointDef& def, const Joint& joint) {
  unsigned flags = kJointAlive;
  if (def.enabled) flags |= kJointEnabled;
  if (def.collide_connected) flags |= kJointCollides;
  if (breaks({def.break_force, def.break_torque})) flags |= kJointBreaks;
  if (is_rich(joint)) flags |= kJointRich;
  if (reports({def.event_force, def.event_torque})) flags |= kJointReports;
  return static_cast<std::uint8_t>(flags);
}

JointDef def_of(const WorldData& data, std::int32_t joint) {
  const Joints& joints = data.joints;
  const auto row = static_cast<std::size_t>(joint);
  const auto handle = [&](std::int32_t body) -> BodyId {
    if (!is_listed(body)) return kWorld;
    return body_handle(data, body);
  };
  const unsigned flags = joints.flags[row];
  return {.body_a = handle(joints.bodies[row].a),
          .body_b = handle(joints.bodies[row].b),
          .frame_a = joints.frame_a[row],
          .frame_b = joints.frame_b[row],
          .collide_connected = (flags & kJointCollides) != 0,
          .enabled = (flags & kJointEnabled) != 0,
          .hertz = joints.parameters[row].hertz,
          .damping_ratio = joints.parameters[row].damping_ratio,
          .break_force = joints.strength[row].force,
          .break_torque = joints.strength[row].torque,
          .event_force = joints.thresholds[row].force,
          .event_torque = joints.thresholds[row].torque,
          .user_data = joints.user_data[row]};
}

JointFrames frames_of(const Bodies& bodies, JointBodies ends, const Pose& frame_a, const Pose& frame_b) {
  const auto center = [&](std::int32_t body) { return bodies.center[body]; };
  JointFrames frames{};
  store(frames.anchor_a, frame_a.position - center(ends.a));
  store(frames.anchor_b, frame_b.position - center(ends.b));
  frames.row_a = ends.a;
  frames.row_b = ends.b;
  store(frames.rotation_a, frame_a.rotation);
  store(frames.rotation_b, frame_b.rotation);
  return frames;
}

}  // namespace scree
