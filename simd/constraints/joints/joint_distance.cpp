// Distance joints: rods, ropes and springs from anchor to anchor; see
// simd/constraints/joints/joint_rows.h.
#include <simd/constraints/joints/joint_linear.h>
#include <simd/constraints/joints/joint_rows.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// Where the anchors coincide the way between them has no direction: the least distance.
constexpr float kLeastDistance = 1e-9f;

// No distance is below 0, and a limit there would keep the anchors from passing each other.
inline WideAxis asked_of_distance(const JointArgs& args, const std::int32_t* joint) {
  WideAxis asked = load_axis(args, joint, 0);
  const M none = (asked.lower <= F(0.0f)) & (asked.lower < asked.upper);
  asked.lower = select(none, F(-kInfinity), asked.lower);
  return asked;
}

// With d the way from anchor a to anchor b and u its direction, the coordinate is |d| and its row
// J = [-u, -r_a x u, u, r_b x u]; as Jolt's AxisConstraintPart, and Box2D's distance joint.
struct DistanceRows : RowShape {
  static constexpr int kAxes = 1;
  // Anchors that have passed each other have turned the way between them over.
  static constexpr bool kTurnsOver = true, kLeavesTurns = true;
  struct Lanes {
    AnchorLanes anchors;
    LaneFloats direction[3];  // as last measured; kept where the anchors coincide
  };
  static void prepare(const JointArgs&, const std::int32_t*, const JointPlacement& at, const LaneInts&,
                      const LaneInts&, F, Lanes& lanes) {
    store_anchors(at, lanes.anchors);
    store3(lanes.direction, rotate(at.frame_a, world_axis(0)));
  }
  static void measure(Lanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b,
                      RowsNow<DistanceRows>& now) {
    const Anchors anchors = move_anchors(lanes.anchors, delta_a, delta_b);
    const F distance = length(anchors.offset), one(1.0f);
    const M apart = distance > F(kLeastDistance);
    const V3 before = load3(lanes.direction);
    const V3 direction = select(apart, anchors.offset * (one / select(apart, distance, one)), before);
    store3(lanes.direction, direction);
    now.turns_over = dot(before, direction) < F(0.0f);
    now.arm_b = anchors.arm_b;
    now.axis[0] = point_row(direction, anchors.arm_a, anchors.arm_b);
    now.coordinate[0] = distance;
  }
  static WideAxis asked(const JointArgs& args, const std::int32_t* joint, int, const Row&,
                        const JointBodyLanes&) {
    return asked_of_distance(args, joint);
  }
};

}  // namespace

template <>
JointTypeKernels make_joint_type_kernels<JointType::distance>() {
  const JointVariantKernels both = make_joint_kernels_of<RowJoint<DistanceRows, true>>();
  return {both, both};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
