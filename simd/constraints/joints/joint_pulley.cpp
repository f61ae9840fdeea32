// Pulleys; see simd/constraints/joints/joint_rows.h.
#include <simd/constraints/joints/joint_rows.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// With the ropes l_a and l_b from the points to the anchors and their directions u_a and u_b, the length is
// |l_a| + ratio |l_b| and its row J = [u_a, r_a x u_a, ratio u_b, ratio r_b x u_b]; as Jolt's
// IndependentAxisConstraintPart.
struct PulleyRows : RowShape {
  static constexpr int kAxes = 1;  // the length, which is limited as axis 0 of JointParameters is
  struct Lanes {
    LaneFloats arm_a[3], arm_b[3];    // when the step began
    LaneFloats rope_a[3], rope_b[3];  // as above, from the point to the anchor
    LaneFloats ratio;
  };
  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointPlacement& at,
                      const LaneInts& row_a, const LaneInts& row_b, F, Lanes& lanes) {
    V3 center_a, center_b;
    F pad;
    const float* pose = args.pose->position;
    load_rows(pose, 8, row_a, center_a.x, center_a.y, center_a.z, pad);
    load_rows(pose, 8, row_b, center_b.x, center_b.y, center_b.z, pad);
    const PulleyParameters& given = args.parameters->pulley;
    store3(lanes.arm_a, at.arm_a);
    store3(lanes.arm_b, at.arm_b);
    store3(lanes.rope_a, (center_a - load_vector(given.point_a, joint)) + at.arm_a);
    store3(lanes.rope_b, (center_b - load_vector(given.point_b, joint)) + at.arm_b);
    F least, most, ratio, gap;
    load_four(given.least_length, joint, least, most, ratio, gap);
    store(lanes.ratio, ratio);
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
};

}  // namespace

template <>
JointTypeKernels make_joint_type_kernels<JointType::pulley>() {
  const JointVariantKernels both = make_joint_kernels_of<RowJoint<PulleyRows, true>>();
  return {both, both};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
