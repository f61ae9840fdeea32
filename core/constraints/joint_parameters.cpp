// Joints as the parameters that kernels read; see joint_parameters.h.
#include <core/constraints/joint_parameters.h>
#include <core/world/edit.h>

#include <type_traits>

namespace scree {

namespace {

constexpr JointAxisRow kNoAxis{-kNoLimit, kNoLimit, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, kDriveNone};

std::uint32_t number_of(Drive drive) { return static_cast<std::uint32_t>(drive); }
Drive drive_of(const JointAxisRow& row) { return static_cast<Drive>(row.drive); }

JointAxisRow row_of(const JointAxis& axis) {
  return {axis.lower, axis.upper,         axis.target,    axis.speed,
          axis.hertz, axis.damping_ratio, axis.max_force, number_of(axis.drive)};
}
JointAxis axis_of(const JointAxisRow& row) {
  return {row.lower, row.upper, drive_of(row),     row.target,
          row.speed, row.hertz, row.damping_ratio, row.max_force};
}

void put(float (&to)[3], Vec3 v) { to[0] = v.x, to[1] = v.y, to[2] = v.z; }
void put(float (&to)[4], Quat q) { to[0] = q.x, to[1] = q.y, to[2] = q.z, to[3] = q.w; }
Vec3 vector_of(const float (&from)[3]) { return {from[0], from[1], from[2]}; }
Quat rotation_of(const float (&from)[4]) { return {from[0], from[1], from[2], from[3]}; }

// --- what each kind writes ---

void write(const BallJoint& from, JointParameters& parameters) {
  BallParameters& to = parameters.ball;
  to.twist_lower = from.twist_lower;
  to.twist_upper = from.twist_upper;
  to.cone_limit = from.cone_limit;
  to.velocity_x = from.drive.velocity.x;
  to.velocity_y = from.drive.velocity.y;
  to.velocity_z = from.drive.velocity.z;
  to.hertz = from.drive.hertz;
  to.damping_ratio = from.drive.damping_ratio;
  to.max_torque = from.drive.max_torque;
  to.drive = number_of(from.drive.drive);
  put(to.target, from.drive.target);
}
void write(const HingeJoint& hinge, JointParameters& to) { to.hinge.angle = row_of(hinge.angle); }
void write(const SliderJoint& slider, JointParameters& to) { to.slider.offset = row_of(slider.offset); }
void write(const DistanceJoint& distance, JointParameters& to) {
  to.distance.length = row_of(distance.length);
}
void write(const WeldJoint& weld, JointParameters& to) {
  to.angular_hertz = weld.angular_hertz;
  to.angular_damping_ratio = weld.angular_damping_ratio;
}
void write(const SixDegreeJoint& joint, JointParameters& to) {
  for (int i = 0; i < 3; ++i) {
    to.six_degree.offset[i] = row_of(joint.offset[i]);
    to.six_degree.angle[i] = row_of(joint.angle[i]);
  }
}
void write(const WheelJoint& wheel, JointParameters& to) {
  to.wheel.suspension = row_of(wheel.suspension);
  to.wheel.steering = row_of(wheel.steering);
  to.wheel.spin = row_of(wheel.spin);
}
void write(const UniversalJoint& universal, JointParameters& to) {
  to.universal.first = row_of(universal.first);
  to.universal.second = row_of(universal.second);
}
void write(const PlanarJoint& planar, JointParameters& to) {
  to.planar.offset_y = row_of(planar.offset_y);
  to.planar.offset_z = row_of(planar.offset_z);
  to.planar.angle = row_of(planar.angle);
}
void write(const GearJoint& gear, JointParameters& to) { to.gear.ratio = gear.ratio; }
void write(const RackAndPinionJoint& rack, JointParameters& to) { to.rack_and_pinion.radius = rack.radius; }
void write(const PulleyJoint& pulley, JointParameters& to) {
  to.pulley.least_length = pulley.rigid ? pulley.length : -kNoLimit;
  to.pulley.length = pulley.length;
  to.pulley.ratio = pulley.ratio;
  put(to.pulley.point_a, pulley.point_a);
  put(to.pulley.point_b, pulley.point_b);
}
void write(const MotorJoint& from, JointParameters& parameters) {
  MotorParameters& to = parameters.motor;
  to.angular_velocity_x = from.rotation.velocity.x;
  to.angular_velocity_y = from.rotation.velocity.y;
  to.angular_velocity_z = from.rotation.velocity.z;
  to.angular_hertz = from.rotation.hertz;
  to.angular_damping_ratio = from.rotation.damping_ratio;
  to.max_torque = from.rotation.max_torque;
  to.rotation_drive = number_of(from.rotation.drive);
  put(to.target_rotation, from.rotation.target);
  put(to.target, from.target);
  to.hertz = from.hertz;
  to.damping_ratio = from.damping_ratio;
  to.max_force = from.max_force;
  to.drive = number_of(from.drive);
  put(to.velocity, from.velocity);
}
void write(const MouseJoint& mouse, JointParameters& to) {
  to.mouse.hertz = mouse.hertz;
  to.mouse.damping_ratio = mouse.damping_ratio;
  to.mouse.max_force = mouse.max_force;
  to.mouse.drive = number_of(Drive::spring);
  put(to.mouse.target, mouse.target);
}

// --- and reads ---

BallJoint read(const JointParameters& parameters, std::type_identity<BallJoint>) {
  const BallParameters& from = parameters.ball;
  return {.cone_limit = from.cone_limit,
          .twist_lower = from.twist_lower,
          .twist_upper = from.twist_upper,
          .drive = {.drive = static_cast<Drive>(from.drive),
                    .target = rotation_of(from.target),
                    .velocity = {from.velocity_x, from.velocity_y, from.velocity_z},
                    .hertz = from.hertz,
                    .damping_ratio = from.damping_ratio,
                    .max_torque = from.max_torque}};
}
HingeJoint read(const JointParameters& from, std::type_identity<HingeJoint>) {
  return {axis_of(from.hinge.angle)};
}
SliderJoint read(const JointParameters& from, std::type_identity<SliderJoint>) {
  return {axis_of(from.slider.offset)};
}
DistanceJoint read(const JointParameters& from, std::type_identity<DistanceJoint>) {
  return {axis_of(from.distance.length)};
}
WeldJoint read(const JointParameters& from, std::type_identity<WeldJoint>) {
  return {from.angular_hertz, from.angular_damping_ratio};
}
SixDegreeJoint read(const JointParameters& from, std::type_identity<SixDegreeJoint>) {
  const auto& [offset, angle] = from.six_degree;
  return {{axis_of(offset[0]), axis_of(offset[1]), axis_of(offset[2])},
          {axis_of(angle[0]), axis_of(angle[1]), axis_of(angle[2])}};
}
WheelJoint read(const JointParameters& from, std::type_identity<WheelJoint>) {
  return {axis_of(from.wheel.suspension), axis_of(from.wheel.steering), axis_of(from.wheel.spin)};
}
UniversalJoint read(const JointParameters& from, std::type_identity<UniversalJoint>) {
  return {axis_of(from.universal.first), axis_of(from.universal.second)};
}
PlanarJoint read(const JointParameters& from, std::type_identity<PlanarJoint>) {
  return {axis_of(from.planar.offset_y), axis_of(from.planar.offset_z), axis_of(from.planar.angle)};
}
GearJoint read(const JointParameters& from, std::type_identity<GearJoint>) { return {from.gear.ratio}; }
RackAndPinionJoint read(const JointParameters& from, std::type_identity<RackAndPinionJoint>) {
  return {from.rack_and_pinion.radius};
}
PulleyJoint read(const JointParameters& from, std::type_identity<PulleyJoint>) {
  return {.point_a = vector_of(from.pulley.point_a),
          .point_b = vector_of(from.pulley.point_b),
          .ratio = from.pulley.ratio,
          .length = from.pulley.length,
          .rigid = from.pulley.least_length == from.pulley.length};
}
MotorJoint read(const JointParameters& parameters, std::type_identity<MotorJoint>) {
  const MotorParameters& from = parameters.motor;
  return {
      .rotation = {.drive = static_cast<Drive>(from.rotation_drive),
                   .target = rotation_of(from.target_rotation),
                   .velocity = {from.angular_velocity_x, from.angular_velocity_y, from.angular_velocity_z},
                   .hertz = from.angular_hertz,
                   .damping_ratio = from.angular_damping_ratio,
                   .max_torque = from.max_torque},
      .drive = static_cast<Drive>(from.drive),
      .target = vector_of(from.target),
      .velocity = vector_of(from.velocity),
      .hertz = from.hertz,
      .damping_ratio = from.damping_ratio,
      .max_force = from.max_force};
}
MouseJoint read(const JointParameters& from, std::type_identity<MouseJoint>) {
  return {.target = vector_of(from.mouse.target),
          .hertz = from.mouse.hertz,
          .damping_ratio = from.mouse.damping_ratio,
          .max_force = from.mouse.max_force};
}

template <std::size_t... kIndex>
Joint read_kind(std::size_t kind, const JointParameters& from, std::index_sequence<kIndex...>) {
  Joint joint;
  ((kind == kIndex ? void(joint.emplace<kIndex>(
                         read(from, std::type_identity<std::variant_alternative_t<kIndex, Joint>>{})))
                   : void()),
   ...);
  return joint;
}

// --- limits and drives ---

bool is_rich_axis(const JointAxis& axis) {
  return axis.lower > -kNoLimit || axis.upper < kNoLimit || axis.drive != Drive::none;
}

struct FindRich {
  bool operator()(const BallJoint& ball) const {
    return ball.cone_limit < kNoLimit || ball.twist_lower > -kNoLimit || ball.twist_upper < kNoLimit ||
           ball.drive.drive != Drive::none;
  }
  bool operator()(const HingeJoint& hinge) const { return is_rich_axis(hinge.angle); }
  bool operator()(const SliderJoint& slider) const { return is_rich_axis(slider.offset); }
  bool operator()(const DistanceJoint& distance) const { return is_rich_axis(distance.length); }
  bool operator()(const WeldJoint&) const { return false; }
  bool operator()(const SixDegreeJoint& joint) const {
    bool rich = false;
    for (int i = 0; i < 3; ++i) rich = rich || is_rich_axis(joint.offset[i]) || is_rich_axis(joint.angle[i]);
    return rich;
  }
  bool operator()(const WheelJoint& wheel) const {
    return is_rich_axis(wheel.suspension) || is_rich_axis(wheel.steering) || is_rich_axis(wheel.spin);
  }
  bool operator()(const UniversalJoint& universal) const {
    return is_rich_axis(universal.first) || is_rich_axis(universal.second);
  }
  bool operator()(const PlanarJoint& planar) const {
    return is_rich_axis(planar.offset_y) || is_rich_axis(planar.offset_z) || is_rich_axis(planar.angle);
  }
  bool operator()(const GearJoint&) const { return false; }
  bool operator()(const RackAndPinionJoint&) const { return false; }
  bool operator()(const PulleyJoint&) const { return true; }
  bool operator()(const MotorJoint& motor) const {
    return motor.drive != Drive::none || motor.rotation.drive != Drive::none;
  }
  bool operator()(const MouseJoint&) const { return true; }
};

}  // namespace

JointParameters parameters_of(const Joint& joint, float hertz, float damping_ratio) {
  JointParameters to{
      {{kNoAxis, kNoAxis, kNoAxis, kNoAxis, kNoAxis, kNoAxis}}, hertz, damping_ratio, hertz, damping_ratio};
  std::visit([&to](const auto& kind) { write(kind, to); }, joint);
  return to;
}

Joint joint_of(JointType type, const JointParameters& parameters) {
  return read_kind(static_cast<std::size_t>(type), parameters, std::make_index_sequence<kJointTypeCount>());
}

const char* name_of(JointType type) {
#define SCREE_JOINT_TYPE(kind, Struct) #kind,
  constexpr const char* kNames[kJointTypeCount] = {SCREE_FOR_EACH_JOINT_TYPE(SCREE_JOINT_TYPE)};
#undef SCREE_JOINT_TYPE
  return kNames[static_cast<std::size_t>(type)];
}

Joint normalized(Joint joint) {
  if (auto* ball = std::get_if<BallJoint>(&joint)) ball->drive.target = normalize(ball->drive.target);
  if (auto* motor = std::get_if<MotorJoint>(&joint)) {
    motor->rotation.target = normalize(motor->rotation.target);
  }
  return joint;
}

bool is_rich(const Joint& joint) { return std::visit(FindRich{}, joint); }

bool breaks(JointStrength strength) { return strength.force < kNoLimit || strength.torque < kNoLimit; }

std::uint8_t flags_of(const JointDef& def, const Joint& joint) {
  unsigned flags = kJointAlive;
  if (def.enabled) flags |= kJointEnabled;
  if (def.collide_connected) flags |= kJointCollides;
  if (breaks({def.break_force, def.break_torque})) flags |= kJointBreaks;
  if (is_rich(joint)) flags |= kJointRich;
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
