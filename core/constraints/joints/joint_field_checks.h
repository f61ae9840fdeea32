// Checks of fields that several kinds of joints have: axes, drives, springs, limits. Private to the sources
// of the kinds and to check_joint.cpp. Comparisons are inline: behind calls they made create_joints 4 to 6 %
// slower.
#pragma once

#include <core/world/check.h>

#include <string>

namespace scree::joint_kinds {

std::string text_of(double value);  // all digits of a float

// Names fields of one part of a joint, such as "hinge angle.".
struct Part {
  Call call;
  const char* prefix;

  std::string name(const char* field) const { return std::string(prefix) + field; }
  void range(const char* field, float value, float low, float high) const {
    if (!(value >= low && value <= high)) fail_range(call, name(field).c_str(), value, low, high);
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
  void vector(const char* field, Vec3 v, float limit) const {
    const auto is_in = [limit](float x) { return x >= -limit && x <= limit; };
    if (is_in(v.x) && is_in(v.y) && is_in(v.z)) return;
    check_vector(call, name(field).c_str(), v, limit);
  }
  // A limit that may be missing, `none`.
  void limit(const char* field, float value, float none, float low, float high) const {
    if (value == none || (value >= low && value <= high)) return;
    fail_limit(field, value, none, low, high);
  }
  void limits(const char* lower, float lower_value, const char* upper, float upper_value, float low,
              float high) const {
    limit(lower, lower_value, -kNoLimit, low, high);
    limit(upper, upper_value, kNoLimit, low, high);
    if (!(lower_value <= upper_value)) fail_order(lower, lower_value, upper, upper_value);
  }

 private:
  [[noreturn]] void fail_limit(const char* field, float value, float none, float low, float high) const;
  [[noreturn]] void fail_order(const char* lower, float lower_value, const char* upper,
                               float upper_value) const;
};

// Limits within [low, high].
inline void check_axis(const Part& part, const JointAxis& axis, float low, float high) {
  part.limits("lower", axis.lower, "upper", axis.upper, low, high);
  part.drive("drive", axis.drive);
  part.range("target", axis.target, -kMaxJointValue, kMaxJointValue);
  part.range("speed", axis.speed, -kMaxJointValue, kMaxJointValue);
  part.spring("hertz", axis.hertz, "damping_ratio", axis.damping_ratio);
  part.strength("max_force", axis.max_force);
}
// m
inline void check_offset(const Part& part, const JointAxis& axis) {
  check_axis(part, axis, -kMaxJointValue, kMaxJointValue);
}
// rad
inline void check_angle(const Part& part, const JointAxis& axis, float most = kMaxJointAngle) {
  check_axis(part, axis, -most, most);
}
void check_rotation_drive(const Part& part, const RotationDrive& drive);
// Positive or negative, but not near zero.
void check_factor(const Part& part, const char* field, float value);

}  // namespace scree::joint_kinds
