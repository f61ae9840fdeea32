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

// Three numbers in lower, upper and target.
void put(JointAxisRow& row, Vec3 v) { row.lower = v.x, row.upper = v.y, row.target = v.z; }
Vec3 vector_of(const JointAxisRow& row) { return {row.lower, row.upper, row.target}; }

void put_drive(JointAxisRow& row, Drive drive, float hertz, float damping_ratio, float most) {
  row.hertz = hertz;
  row.damping_ratio = damping_ratio;
  row.max_force = most;
  row.drive = number_of(drive);
}

void put(JointAxisRow (&axis)[kJointAxes], const RotationDrive& drive) {
  put_drive(axis[2], drive.drive, drive.hertz, drive.damping_ratio, drive.max_torque);
  axis[0].speed = drive.velocity.x;
  axis[1].speed = drive.velocity.y;
  axis[2].speed = drive.velocity.z;
  put(axis[3], {drive.target.x, drive.target.y, drive.target.z});
  axis[3].speed = drive.target.w;
}
RotationDrive rotation_drive_of(const JointAxisRow (&axis)[kJointAxes]) {
  const Vec3 target = vector_of(axis[3]);
  return {.drive = drive_of(axis[2]),
          .target = {target.x, target.y, target.z, axis[3].speed},
          .velocity = {axis[0].speed, axis[1].speed, axis[2].speed},
          .hertz = axis[2].hertz,
          .damping_ratio = axis[2].damping_ratio,
          .max_torque = axis[2].max_force};
}

// --- what each kind writes ---

void write(const BallJoint& ball, JointParameters& to) {
  to.axis[0].lower = ball.twist_lower;
  to.axis[0].upper = ball.twist_upper;
  to.axis[1].upper = ball.cone_limit;
  put(to.axis, ball.drive);
}
void write(const HingeJoint& hinge, JointParameters& to) { to.axis[0] = row_of(hinge.angle); }
void write(const SliderJoint& slider, JointParameters& to) { to.axis[0] = row_of(slider.offset); }
void write(const DistanceJoint& distance, JointParameters& to) { to.axis[0] = row_of(distance.length); }
void write(const WeldJoint& weld, JointParameters& to) {
  to.angular_hertz = weld.angular_hertz;
  to.angular_damping_ratio = weld.angular_damping_ratio;
}
void write(const SixDegreeJoint& joint, JointParameters& to) {
  for (int i = 0; i < 3; ++i) {
    to.axis[i] = row_of(joint.offset[i]);
    to.axis[3 + i] = row_of(joint.angle[i]);
  }
}
void write(const WheelJoint& wheel, JointParameters& to) {
  to.axis[0] = row_of(wheel.suspension);
  to.axis[1] = row_of(wheel.steering);
  to.axis[2] = row_of(wheel.spin);
}
void write(const UniversalJoint& universal, JointParameters& to) {
  to.axis[0] = row_of(universal.first);
  to.axis[1] = row_of(universal.second);
}
void write(const PlanarJoint& planar, JointParameters& to) {
  to.axis[0] = row_of(planar.offset_y);
  to.axis[1] = row_of(planar.offset_z);
  to.axis[2] = row_of(planar.angle);
}
void write(const GearJoint& gear, JointParameters& to) { to.axis[0].target = gear.ratio; }
void write(const RackAndPinionJoint& rack, JointParameters& to) { to.axis[0].target = rack.radius; }
void write(const PulleyJoint& pulley, JointParameters& to) {
  if (pulley.rigid) to.axis[0].lower = pulley.length;
  to.axis[0].upper = pulley.length;
  to.axis[0].target = pulley.ratio;
  put(to.axis[1], pulley.point_a);
  put(to.axis[2], pulley.point_b);
}
void write(const MotorJoint& motor, JointParameters& to) {
  put(to.axis, motor.rotation);
  put_drive(to.axis[4], motor.drive, motor.hertz, motor.damping_ratio, motor.max_force);
  put(to.axis[4], motor.target);
  put(to.axis[5], motor.velocity);
}
void write(const MouseJoint& mouse, JointParameters& to) {
  put_drive(to.axis[0], Drive::spring, mouse.hertz, mouse.damping_ratio, mouse.max_force);
  put(to.axis[1], mouse.target);
}

// --- and reads ---

BallJoint read(const JointParameters& from, std::type_identity<BallJoint>) {
  return {.cone_limit = from.axis[1].upper,
          .twist_lower = from.axis[0].lower,
          .twist_upper = from.axis[0].upper,
          .drive = rotation_drive_of(from.axis)};
}
HingeJoint read(const JointParameters& from, std::type_identity<HingeJoint>) {
  return {axis_of(from.axis[0])};
}
SliderJoint read(const JointParameters& from, std::type_identity<SliderJoint>) {
  return {axis_of(from.axis[0])};
}
DistanceJoint read(const JointParameters& from, std::type_identity<DistanceJoint>) {
  return {axis_of(from.axis[0])};
}
WeldJoint read(const JointParameters& from, std::type_identity<WeldJoint>) {
  return {from.angular_hertz, from.angular_damping_ratio};
}
SixDegreeJoint read(const JointParameters& from, std::type_identity<SixDegreeJoint>) {
  return {{axis_of(from.axis[0]), axis_of(from.axis[1]), axis_of(from.axis[2])},
          {axis_of(from.axis[3]), axis_of(from.axis[4]), axis_of(from.axis[5])}};
}
WheelJoint read(const JointParameters& from, std::type_identity<WheelJoint>) {
  return {axis_of(from.axis[0]), axis_of(from.axis[1]), axis_of(from.axis[2])};
}
UniversalJoint read(const JointParameters& from, std::type_identity<UniversalJoint>) {
  return {axis_of(from.axis[0]), axis_of(from.axis[1])};
}
PlanarJoint read(const JointParameters& from, std::type_identity<PlanarJoint>) {
  return {axis_of(from.axis[0]), axis_of(from.axis[1]), axis_of(from.axis[2])};
}
GearJoint read(const JointParameters& from, std::type_identity<GearJoint>) { return {from.axis[0].target}; }
RackAndPinionJoint read(const JointParameters& from, std::type_identity<RackAndPinionJoint>) {
  return {from.axis[0].target};
}
PulleyJoint read(const JointParameters& from, std::type_identity<PulleyJoint>) {
  return {.point_a = vector_of(from.axis[1]),
          .point_b = vector_of(from.axis[2]),
          .ratio = from.axis[0].target,
          .length = from.axis[0].upper,
          .rigid = from.axis[0].lower == from.axis[0].upper};
}
MotorJoint read(const JointParameters& from, std::type_identity<MotorJoint>) {
  return {.rotation = rotation_drive_of(from.axis),
          .drive = drive_of(from.axis[4]),
          .target = vector_of(from.axis[4]),
          .velocity = vector_of(from.axis[5]),
          .hertz = from.axis[4].hertz,
          .damping_ratio = from.axis[4].damping_ratio,
          .max_force = from.axis[4].max_force};
}
MouseJoint read(const JointParameters& from, std::type_identity<MouseJoint>) {
  return {.target = vector_of(from.axis[1]),
          .hertz = from.axis[0].hertz,
          .damping_ratio = from.axis[0].damping_ratio,
          .max_force = from.axis[0].max_force};
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
      {kNoAxis, kNoAxis, kNoAxis, kNoAxis, kNoAxis, kNoAxis}, hertz, damping_ratio, hertz, damping_ratio};
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
    if (!is_listed(body)) return {};
    return {static_cast<std::uint32_t>(body), data.bodies.generation[body]};
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
