// Checks joints from callers; see check.h. What each kind checks stands in joints/joint_<kind>.cpp.
#include <core/constraints/joints/joint_field_checks.h>
#include <core/constraints/joints/joint_kinds.h>
#include <core/world/check.h>

namespace scree {

using joint_kinds::text_of;

namespace {

void check_value(Call call, const Joint& joint) {
  if (joint.valueless_by_exception()) fail(call, "joint holds no value");
}

}  // namespace

void check_joint(Call call, const Joint& joint) {
  check_value(call, joint);
  std::visit([call](const auto& kind) { joint_kinds::check(call, kind); }, joint);
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

void check_event_threshold(Call call, const char* what, float value) {
  if (value >= 0.0f) return;
  fail(call, std::string(what) + " is " + text_of(value) + ", must be at least 0");
}

void check_joint_frames(Call call, bool world_a, const Pose& frame_a, bool world_b, const Pose& frame_b) {
  check_pose(call, "frame_a.position", "frame_a.rotation", frame_a,
             world_a ? kMaxPosition : kMaxLocalPosition);
  check_pose(call, "frame_b.position", "frame_b.rotation", frame_b,
             world_b ? kMaxPosition : kMaxLocalPosition);
}

JointBodies checked_ends(Call call, const WorldData& data, const JointDef& def, const Joint& joint) {
  const auto row_of = [&](const char* end, BodyId body) {
    if (body == kWorld) return kFixedRow;
    if (body.generation == 0) {
      fail(call, std::string(end) + " names no body; kWorld stands for the world", ErrorCode::dead_handle);
    }
    return checked_row(call, data, body);
  };
  const JointBodies ends{row_of("body_a", def.body_a), row_of("body_b", def.body_b)};
  if (ends.a == kFixedRow && ends.b == kFixedRow) {
    fail(call, "body_a and body_b are both the world, one must be a body");
  }
  if (ends.a == ends.b) {
    fail(call, "body_a and body_b are both body " + std::to_string(ends.a) + ", they must be two");
  }
  check_value(call, joint);
  std::visit([&](const auto& kind) { joint_kinds::check_ends(call, kind, ends); }, joint);
  return ends;
}

JointBodies check_joint_def(Call call, const WorldData& data, const JointDef& def, const Joint& joint) {
  const JointBodies ends = checked_ends(call, data, def, joint);
  check_joint_frames(call, ends.a == kFixedRow, def.frame_a, ends.b == kFixedRow, def.frame_b);
  check_stiffness(call, "hertz", def.hertz, "damping_ratio", def.damping_ratio);
  check_strength(call, "break_force", def.break_force);
  check_strength(call, "break_torque", def.break_torque);
  check_event_threshold(call, "event_force", def.event_force);
  check_event_threshold(call, "event_torque", def.event_torque);
  check_joint(call, joint);
  return ends;
}

}  // namespace scree
