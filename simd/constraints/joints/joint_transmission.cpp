// Gears, racks with pinions, and pulleys; see simd/constraints/joints/joint_rows.h.
#include <simd/constraints/joints/joint_rows.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// The turn of a body about an axis of its own since the step began, in (-2 pi, 2 pi]. Sums of turns must stay
// true over thousands of them, so small angles have the series.
inline F turn_about(Q4 rotation, V3 axis) {
  const F sine = dot(V3{rotation.x, rotation.y, rotation.z}, axis), cosine = rotation.w;
  const M small = abs(sine) < F(0.2f) * cosine;
  const F t = sine / select(small, cosine, F(1.0f));
  const F s = t * t;
  F p = F(0.111111111f) - F(0.0909090909f) * s;
  p = F(-0.142857143f) + s * p;
  p = F(0.2f) + s * p;
  p = F(-0.333333333f) + s * p;
  const F series = t + t * (s * p);
  return F(2.0f) * select(small, series, atan2(sine, cosine));
}

// Turns of a rotation are known up to two of them: the ones nearest to the last known.
inline F follow_turn(F turn, F before) {
  return turn + round_to_nearest((before - turn) * F(0.0795774715f)) * F(12.5663706f);
}

// The error of a transmission is the sum of the motion of all steps, each measured as it ends; it stays near
// zero, where floats are fine. `ratio` is a gear's ratio or a pinion's radius.
struct SumLanes {
  LaneFloats first_error, ratio;
};
inline void prepare_sum(const JointArgs& args, const std::int32_t* joint, F remembered, SumLanes& lanes) {
  store(lanes.first_error, remembered);
  store(lanes.ratio, load_axis(args, joint, 0).target);
}

struct GearRows {
  static constexpr int kHeld = 1, kAxes = 0;
  static constexpr bool kRemembers = true;
  struct Lanes {
    SumLanes sum;
    LaneFloats axis_a[3], axis_b[3], arm_b[3];  // when the step began
    LaneFloats turn_a, turn_b;                  // since then
  };
  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointPlacement& at,
                      const LaneInts&, const LaneInts&, F remembered, Lanes& lanes) {
    prepare_sum(args, joint, remembered, lanes.sum);
    store3(lanes.axis_a, to_matrix(at.frame_a).x);
    store3(lanes.axis_b, to_matrix(at.frame_b).x);
    store3(lanes.arm_b, at.arm_b);
    store(lanes.turn_a, F(0.0f));
    store(lanes.turn_b, F(0.0f));
  }
  static void measure(Lanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b,
                      RowsNow<GearRows>& now) {
    const V3 first_a = load3(lanes.axis_a), first_b = load3(lanes.axis_b);
    const V3 none{F(0.0f), F(0.0f), F(0.0f)};
    const F ratio = load(lanes.sum.ratio);
    const F turn_a = follow_turn(turn_about(delta_a.rotation, first_a), load(lanes.turn_a));
    const F turn_b = follow_turn(turn_about(delta_b.rotation, first_b), load(lanes.turn_b));
    store(lanes.turn_a, turn_a);
    store(lanes.turn_b, turn_b);
    now.arm_b = rotate(delta_b.rotation, load3(lanes.arm_b));
    now.held[0] = {none, rotate(delta_a.rotation, first_a), none, rotate(delta_b.rotation, first_b) * ratio};
    now.error[0] = load(lanes.sum.first_error) + (turn_a + ratio * turn_b);
  }
};

struct RackRows {
  static constexpr int kHeld = 1, kAxes = 0;
  static constexpr bool kRemembers = true;
  struct Lanes {
    SumLanes sum;
    LaneFloats axis_a[3], axis_b[3], arm_a[3], arm_b[3];  // when the step began
    LaneFloats turn_a;                                    // since then
  };
  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointPlacement& at,
                      const LaneInts&, const LaneInts&, F remembered, Lanes& lanes) {
    prepare_sum(args, joint, remembered, lanes.sum);
    store3(lanes.axis_a, to_matrix(at.frame_a).x);
    store3(lanes.axis_b, to_matrix(at.frame_b).x);
    store3(lanes.arm_a, at.arm_a);
    store3(lanes.arm_b, at.arm_b);
    store(lanes.turn_a, F(0.0f));
  }
  // The way is that of anchor b against anchor a: so the transmission works within a car that drives, and its
  // forces on the two bodies are opposite.
  static void measure(Lanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b,
                      RowsNow<RackRows>& now) {
    const V3 first_a = load3(lanes.axis_a), first_b = load3(lanes.axis_b);
    const V3 first_arm_a = load3(lanes.arm_a), first_arm_b = load3(lanes.arm_b);
    const V3 arm_a = rotate(delta_a.rotation, first_arm_a), arm_b = rotate(delta_b.rotation, first_arm_b);
    const V3 axis_a = rotate(delta_a.rotation, first_a), axis_b = rotate(delta_b.rotation, first_b);
    const F radius = load(lanes.sum.ratio);
    const F turn = follow_turn(turn_about(delta_a.rotation, first_a), load(lanes.turn_a));
    store(lanes.turn_a, turn);
    const V3 moved = (delta_b.position - delta_a.position) + (arm_b - first_arm_b) - (arm_a - first_arm_a);
    const F way = dot((first_b + axis_b) * F(0.5f), moved);
    now.arm_b = arm_b;
    now.held[0] = {-axis_b, -(cross(arm_a, axis_b) + axis_a * radius), axis_b, cross(arm_b, axis_b)};
    now.error[0] = load(lanes.sum.first_error) + (way - radius * turn);
  }
};

struct PulleyRows {
  static constexpr int kHeld = 0, kAxes = 1;
  static constexpr bool kRemembers = false;
  static constexpr AxisUnit unit(int) { return AxisUnit::length; }
  struct Lanes {
    LaneFloats arm_a[3], arm_b[3];    // when the step began
    LaneFloats rope_a[3], rope_b[3];  // likewise, from the point to the anchor
    LaneFloats ratio;
  };
  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointPlacement& at,
                      const LaneInts& row_a, const LaneInts& row_b, F, Lanes& lanes) {
    V3 center_a, center_b;
    F pad;
    const float* pose = args.pose->position;
    load_rows(pose, 8, row_a, center_a.x, center_a.y, center_a.z, pad);
    load_rows(pose, 8, row_b, center_b.x, center_b.y, center_b.z, pad);
    const WideAxis point_a = load_axis(args, joint, 1), point_b = load_axis(args, joint, 2);
    store3(lanes.arm_a, at.arm_a);
    store3(lanes.arm_b, at.arm_b);
    store3(lanes.rope_a, (center_a - V3{point_a.lower, point_a.upper, point_a.target}) + at.arm_a);
    store3(lanes.rope_b, (center_b - V3{point_b.lower, point_b.upper, point_b.target}) + at.arm_b);
    store(lanes.ratio, load_axis(args, joint, 0).target);
  }
  static void measure(const Lanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b,
                      RowsNow<PulleyRows>& now) {
    const V3 first_a = load3(lanes.arm_a), first_b = load3(lanes.arm_b);
    const V3 arm_a = rotate(delta_a.rotation, first_a), arm_b = rotate(delta_b.rotation, first_b);
    const V3 rope_a = load3(lanes.rope_a) + delta_a.position + (arm_a - first_a);
    const V3 rope_b = load3(lanes.rope_b) + delta_b.position + (arm_b - first_b);
    const F length_a = length(rope_a), length_b = length(rope_b), ratio = load(lanes.ratio);
    // An anchor at its point is pulled nowhere.
    const V3 pull_a = rope_a * invert_positive(length_a),
             pull_b = rope_b * (ratio * invert_positive(length_b));
    now.arm_b = arm_b;
    now.axis[0] = {pull_a, cross(arm_a, pull_a), pull_b, cross(arm_b, pull_b)};
    now.coordinate[0] = length_a + ratio * length_b;
  }
  static void tune(const JointArgs&, const std::int32_t*, int, const Row&, const JointBodies&, LaneAxis&) {}
};

}  // namespace

void add_transmission_kernels(JointKernels& kernels) {
  for (int rich = 0; rich < 2; ++rich) {
    kernels.variant[joint_variant(9, rich != 0)] = make_joint_kernels_of<RowJoint<GearRows, true>>();
    kernels.variant[joint_variant(10, rich != 0)] = make_joint_kernels_of<RowJoint<RackRows, true>>();
    kernels.variant[joint_variant(11, rich != 0)] = make_joint_kernels_of<RowJoint<PulleyRows, true>>();
  }
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
