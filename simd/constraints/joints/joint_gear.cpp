// Gears; see simd/constraints/joints/joint_rows.h.
#include <simd/constraints/joints/joint_transmission.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// C = (turn of a) + ratio (turn of b) since the joint was made,   J = [0, x_a, 0, ratio x_b]
//
// as Jolt's GearConstraintPart.
struct GearRows : RowShape {
  static constexpr int kHeld = 1;
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

}  // namespace

template <>
JointTypeKernels make_joint_type_kernels<JointType::gear>() {
  const JointVariantKernels both = make_joint_kernels_of<RowJoint<GearRows, true>>();
  return {both, both};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
