// Checks of fields that several kinds of joints have; see joint_field_checks.h.
#include <core/constraints/joints/joint_field_checks.h>
#include <core/world/number_text.h>

#include <cmath>

namespace scree::joint_kinds {

std::string text_of(double value) {
  constexpr int kDigits = 9;  // all of a float
  return number_text(value, kDigits);
}

void Part::fail_limit(const char* field, float value, float none, float low, float high) const {
  fail(call, name(field) + " is " + text_of(value) + ", must lie in [" + text_of(low) + ", " + text_of(high) +
                 "] or be " + text_of(none));
}

void Part::fail_order(const char* lower, float lower_value, const char* upper, float upper_value) const {
  fail(call, name(lower) + " is " + text_of(lower_value) + ", must be at most " + name(upper) +
                 ", which is " + text_of(upper_value));
}

void check_rotation_drive(const Part& part, const RotationDrive& drive) {
  part.drive("drive", drive.drive);
  if (!is_unit(drive.target)) check_rotation(part.call, part.name("target").c_str(), drive.target);
  part.vector("velocity", drive.velocity, kMaxJointValue);
  part.spring("hertz", drive.hertz, "damping_ratio", drive.damping_ratio);
  part.strength("max_torque", drive.max_torque);
}

void check_factor(const Part& part, const char* field, float value) {
  const float size = std::abs(value);
  if (size >= kMinRatio && size <= kMaxRatio) return;
  fail(part.call, part.name(field) + " is " + text_of(value) + ", its size must lie in [" +
                      text_of(kMinRatio) + ", " + text_of(kMaxRatio) + "]");
}

}  // namespace scree::joint_kinds
