// Checks joints from callers; see check.h.
#include <core/world/check.h>
#include <core/world/number_text.h>

namespace scree {

namespace {

constexpr int kDigits = 9;  // all of a float
std::string text_of(double value) { return number_text(value, kDigits); }

// Names fields of one part of a joint, such as "hinge angle.".
struct Part {
  Call call;
  const char* prefix;

  std::string name(const char* field) const { return std::string(prefix) + field; }
  void range(const char* field, float value, float low, float high) const {
    if (!(value >= low && value <= high)) fail_range(call, name(field).c_str(), value, low, high);
  }
  void vector(const char* field, Vec3 v, float limit) const {
    const auto is_in = [limit](float x) { return x >= -limit && x <= limit; };
    if (is_in(v.x) && is_in(v.y) && is_in(v.z)) return;
    check_vector(call, name(field).c_str(), v, limit);
  }
  void drive(const char* field, Drive value) const {
    if (value > Drive::spring) fail_range(call, name(field).c_str(), static_cast<int>(value), 0, 2);
  }
  // Of forces and torques.
  void strength(const char* field, float value) const { range(field, value, 0.0f, kNoLimit); }
  void spring(const char* hertz, float hertz_value, const char* ratio, float ratio_value) const {
    range(hertz, hertz_value, kMinHertz, kMaxHertz);
    range(ratio, ratio_value, 0.0f, kMaxDampingRatio);
  }
  // A limit that may be missing, `none`.
  void limit(const char* field, float value, float none, float low, float high) const {
    if (value == none || (value >= low && value <= high)) return;
    fail(call, name(field) + " is " + text_of(value) + ", must lie in [" + text_of(low) + ", " +
                   text_of(high) + "] or be " + text_of(none));
  }
  void order(const char* lower, float lower_value, const char* upper, float upper_value) const {
    if (lower_value <= upper_value) return;
    fail(call, name(lower) + " is " + text_of(lower_value) + ", must be at most " + name(upper) +
                   ", which is " + text_of(upper_value));
  }
  void limits(const char* lower, float lower_value, const char* upper, float upper_value, float low,
              float high) const {
    limit(lower, lower_value, -kNoLimit, low, high);
    limit(upper, upper_value, kNoLimit, low, high);
    order(lower, lower_value, upper, upper_value);
  }
};

// Limits within [low, high].
void check_axis(const Part& part, const JointAxis& axis, float low, float high) {
  part.limits("lower", axis.lower, "upper", axis.upper, low, high);
  part.drive("drive", axis.drive);
  part.range("target", axis.target, -kMaxJointValue, kMaxJointValue);
  part.range("speed", axis.speed, -kMaxJointValue, kMaxJointValue);
  part.spring("hertz", axis.hertz, "damping_ratio", axis.damping_ratio);
  part.strength("max_force", axis.max_force);
}
void check_offset(const Part& part, const JointAxis& axis) {
  check_axis(part, axis, -kMaxJointValue, kMaxJointValue);
}
void check_angle(const Part& part, const JointAxis& axis, float most = kMaxJointAngle) {
  check_axis(part, axis, -most, most);
}

void check_rotation_drive(const Part& part, const RotationDrive& drive) {
  part.drive("drive", drive.drive);
  if (!is_unit(drive.target)) check_rotation(part.call, part.name("target").c_str(), drive.target);
  part.vector("velocity", drive.velocity, kMaxJointValue);
  part.spring("hertz", drive.hertz, "damping_ratio", drive.damping_ratio);
  part.strength("max_torque", drive.max_torque);
}

// Positive or negative, but not near zero.
void check_factor(const Part& part, const char* field, float value) {
  const float size = std::abs(value);
  if (size >= kMinRatio && size <= kMaxRatio) return;
  fail(part.call, part.name(field) + " is " + text_of(value) + ", its size must lie in [" +
                      text_of(kMinRatio) + ", " + text_of(kMaxRatio) + "]");
}

struct CheckKind {
  Call call;

  void operator()(const BallJoint& ball) const {
    const Part part{call, "ball "};
    part.limit("cone_limit", ball.cone_limit, kNoLimit, 0.0f, kMaxJointAngle);
    part.limits("twist_lower", ball.twist_lower, "twist_upper", ball.twist_upper, -kMaxJointAngle,
                kMaxJointAngle);
    check_rotation_drive({call, "ball drive."}, ball.drive);
  }
  void operator()(const HingeJoint& hinge) const { check_angle({call, "hinge angle."}, hinge.angle); }
  void operator()(const SliderJoint& slider) const { check_offset({call, "slider offset."}, slider.offset); }
  void operator()(const DistanceJoint& distance) const {
    const Part part{call, "distance length."};
    check_axis(part, distance.length, 0.0f, kMaxJointValue);
    part.range("target", distance.length.target, 0.0f, kMaxJointValue);
  }
  void operator()(const WeldJoint& weld) const {
    check_stiffness(call, "weld angular_hertz", weld.angular_hertz, "weld angular_damping_ratio",
                    weld.angular_damping_ratio);
  }
  void operator()(const SixDegreeJoint& joint) const {
    constexpr const char* kOffsets[] = {"six_degree offset[0].", "six_degree offset[1].",
                                        "six_degree offset[2]."};
    constexpr const char* kAngles[] = {"six_degree angle[0].", "six_degree angle[1].",
                                       "six_degree angle[2]."};
    for (int i = 0; i < 3; ++i) {
      check_offset({call, kOffsets[i]}, joint.offset[i]);
      check_angle({call, kAngles[i]}, joint.angle[i]);
    }
  }
  void operator()(const WheelJoint& wheel) const {
    check_offset({call, "wheel suspension."}, wheel.suspension);
    check_angle({call, "wheel steering."}, wheel.steering, kMaxSteering);
    const Part spin{call, "wheel spin."};
    check_offset(spin, wheel.spin);
    if (wheel.spin.lower > -kNoLimit)
      fail(call, spin.name("lower is ") + text_of(wheel.spin.lower) + kNoSpinLimit);
    if (wheel.spin.upper < kNoLimit)
      fail(call, spin.name("upper is ") + text_of(wheel.spin.upper) + kNoSpinLimit);
    if (wheel.spin.drive == Drive::spring)
      fail(call, "wheel spin.drive is a spring, must be a motor or none");
  }
  void operator()(const UniversalJoint& universal) const {
    check_angle({call, "universal first."}, universal.first);
    check_angle({call, "universal second."}, universal.second);
  }
  void operator()(const PlanarJoint& planar) const {
    check_offset({call, "planar offset_y."}, planar.offset_y);
    check_offset({call, "planar offset_z."}, planar.offset_z);
    check_angle({call, "planar angle."}, planar.angle);
  }
  void operator()(const GearJoint& gear) const { check_factor({call, "gear "}, "ratio", gear.ratio); }
  void operator()(const RackAndPinionJoint& rack) const {
    check_factor({call, "rack_and_pinion "}, "radius", rack.radius);
  }
  void operator()(const PulleyJoint& pulley) const {
    const Part part{call, "pulley "};
    part.vector("point_a", pulley.point_a, kMaxPosition);
    part.vector("point_b", pulley.point_b, kMaxPosition);
    part.range("ratio", pulley.ratio, kMinRatio, kMaxRatio);
    part.range("length", pulley.length, 0.0f, kMaxRope);
  }
  void operator()(const MotorJoint& motor) const {
    check_rotation_drive({call, "motor rotation."}, motor.rotation);
    const Part part{call, "motor "};
    part.drive("drive", motor.drive);
    part.vector("target", motor.target, kMaxJointValue);
    part.vector("velocity", motor.velocity, kMaxJointValue);
    part.spring("hertz", motor.hertz, "damping_ratio", motor.damping_ratio);
    part.strength("max_force", motor.max_force);
  }
  void operator()(const MouseJoint& mouse) const {
    const Part part{call, "mouse "};
    part.vector("target", mouse.target, kMaxPosition);
    part.spring("hertz", mouse.hertz, "damping_ratio", mouse.damping_ratio);
    part.strength("max_force", mouse.max_force);
  }

  static constexpr const char* kNoSpinLimit = ", a wheel's spin has no limits";
};

}  // namespace

void check_joint(Call call, const Joint& joint) {
  if (joint.valueless_by_exception()) fail(call, "joint holds no value");
  std::visit(CheckKind{call}, joint);
}

void check_stiffness(Call call, const char* hertz, float hertz_value, const char* ratio, float ratio_value) {
  if (hertz_value != 0.0f && !(hertz_value >= kMinHertz && hertz_value <= kMaxHertz)) {
    fail(call, std::string(hertz) + " is " + text_of(hertz_value) + ", must lie in [" + text_of(kMinHertz) +
                   ", " + text_of(kMaxHertz) + "] or be 0");
  }
  check_range(call, ratio, ratio_value, 0.0f, kMaxDampingRatio);
}

void check_strength(Call call, const char* what, float value) {
  if (value > 0.0f) return;
  fail(call, std::string(what) + " is " + text_of(value) + ", must be above 0");
}

void check_joint_frames(Call call, bool world_a, const Pose& frame_a, bool world_b, const Pose& frame_b) {
  check_pose(call, "frame_a.position", "frame_a.rotation", frame_a,
             world_a ? kMaxPosition : kMaxLocalPosition);
  check_pose(call, "frame_b.position", "frame_b.rotation", frame_b,
             world_b ? kMaxPosition : kMaxLocalPosition);
}

JointBodies checked_ends(Call call, const Bodies& bodies, const JointDef& def, const Joint& joint) {
  const auto row_of = [&](BodyId body) {
    return body == BodyId{} ? kFixedRow : checked_row(call, bodies, body);
  };
  const JointBodies ends{row_of(def.body_a), row_of(def.body_b)};
  if (ends.a == kFixedRow && ends.b == kFixedRow) {
    fail(call, "body_a and body_b are both the world, one must be a body");
  }
  if (ends.a == ends.b) {
    fail(call, "body_a and body_b are both body " + std::to_string(ends.a) + ", they must be two");
  }
  if (std::holds_alternative<MouseJoint>(joint) && ends.a != kFixedRow) {
    fail(call, "body_a of a mouse joint is body " + std::to_string(ends.a) + ", must be the world");
  }
  return ends;
}

JointBodies check_joint_def(Call call, const Bodies& bodies, const JointDef& def, const Joint& joint) {
  const JointBodies ends = checked_ends(call, bodies, def, joint);
  check_joint_frames(call, ends.a == kFixedRow, def.frame_a, ends.b == kFixedRow, def.frame_b);
  check_stiffness(call, "hertz", def.hertz, "damping_ratio", def.damping_ratio);
  check_strength(call, "break_force", def.break_force);
  check_strength(call, "break_torque", def.break_torque);
  check_joint(call, joint);
  return ends;
}

}  // namespace scree
