// Racks with pinions; see simd/constraints/joints/joint_rows.h.
#include <simd/constraints/joints/joint_transmission.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// C = way - radius (turn of a) since the joint was made,
// J = [-x_b, -(r_a x x_b + radius x_a), x_b, r_b x x_b]
//
// as Jolt's RackAndPinionConstraintPart, which has the way of body b alone.
struct RackRows : RowShape {
  static constexpr int kHeld = 1;
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

}  // namespace

template <>
JointTypeKernels make_joint_type_kernels<JointType::rack_and_pinion>() {
  const JointVariantKernels both = make_joint_kernels_of<RowJoint<RackRows, true>>();
  return {both, both};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
