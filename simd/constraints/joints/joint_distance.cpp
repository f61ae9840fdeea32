// Distance joints: rods, ropes and springs from anchor to anchor; see
// simd/constraints/joints/joint_kernels.h.
#include <simd/constraints/joints/joint_linear.h>
#include <simd/constraints/joints/joint_sweeps.h>

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
  struct Lanes {
    AnchorLanes anchors;
    LaneFloats direction[3];  // where the anchors coincide
  };
  static void prepare(const JointArgs&, const std::int32_t*, const JointPlacement& at, const LaneInts&,
                      const LaneInts&, F, Lanes& lanes) {
    store_anchors(at, lanes.anchors);
    store3(lanes.direction, rotate(at.frame_a, world_axis(0)));
  }
  static void measure(const Lanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b,
                      RowsNow<DistanceRows>& now) {
    const Anchors anchors = move_anchors(lanes.anchors, delta_a, delta_b);
    const F distance = length(anchors.offset), one(1.0f);
    const M apart = distance > F(kLeastDistance);
    const V3 direction =
        select(apart, anchors.offset * (one / select(apart, distance, one)), load3(lanes.direction));
    now.arm_b = anchors.arm_b;
    now.axis[0] = point_row(direction, anchors.arm_a, anchors.arm_b);
    now.coordinate[0] = distance;
  }
  static WideAxis asked(const JointArgs& args, const std::int32_t* joint, int, const Row&,
                        const JointBodyLanes&) {
    return asked_of_distance(args, joint);
  }
  static void impulses(const F (&stored)[kJointImpulses], const RowsNow<DistanceRows>&,
                       RowImpulses<DistanceRows>& along) {
    along.limit[0] = stored[0];
    along.drive[0] = stored[1];
  }
};

struct alignas(64) DistanceBlock {
  LaneInts row_a, row_b;
  AnchorLanes first;
  LaneFloats arm_a[3], arm_b[3];  // now
  LaneFloats direction[3];        // from anchor a to anchor b; where they coincide, as it was
  LaneFloats length, mass;
  LaneAxis axis;
  TurnedLanes turned;
  LaneSoftness held, relaxed;
};

inline F impulse_of(const DistanceBlock& block) {
  return load(block.axis.limit_impulse) + load(block.axis.drive_impulse);
}
inline Wrench wrench_of(const DistanceBlock& block) {
  const F zero(0.0f);
  return {load3(block.arm_a), load3(block.arm_b), load3(block.direction) * impulse_of(block),
          V3{zero, zero, zero}};
}

inline void place(const JointBodyLanes& bodies, const Anchors& now, DistanceBlock& block) {
  const F distance = length(now.offset), one(1.0f);
  const M apart = distance > F(kLeastDistance);
  const V3 direction =
      select(apart, now.offset * (one / select(apart, distance, one)), load3(block.direction));
  const F response = response_along(bodies, now.arm_a, now.arm_b, direction);
  store3(block.arm_a, now.arm_a);
  store3(block.arm_b, now.arm_b);
  store3(block.direction, direction);
  store(block.length, distance);
  store(block.mass, invert_positive(response));
}

// The anchors have passed each other since the direction was `old`: what pulled them would push them now.
inline void forget_if_passed(V3 old, DistanceBlock& block) {
  const F zero(0.0f);
  const M passed = dot(old, load3(block.direction)) < zero;
  store(block.axis.limit_impulse, select(passed, zero, load(block.axis.limit_impulse)));
  store(block.axis.drive_impulse, select(passed, zero, load(block.axis.drive_impulse)));
}

// Returns the speed that the limit took away.
inline F solve_rows(const JointArgs& args, const Softness& held, F keep, DistanceBlock& block,
                    JointBodyLanes& bodies) {
  const V3 arm_a = load3(block.arm_a), arm_b = load3(block.arm_b), direction = load3(block.direction);
  const F distance = load(block.length), mass = load(block.mass);
  F speed = dot(direction, anchor_velocity(bodies, arm_a, arm_b));
  const F driven = solve_drive(block.axis, distance - target_now(args, block.axis), speed, mass, keep);
  push(bodies, arm_a, arm_b, direction * driven);
  speed = dot(direction, anchor_velocity(bodies, arm_a, arm_b));
  const F limited = solve_limit(args, Course::line, block.axis, distance, speed, mass, held, keep);
  push(bodies, arm_a, arm_b, direction * limited);
  return abs(limited) * invert_positive(mass);
}

// Impulses: 0 of the limit, 1 of the drive, both along the way from anchor a to anchor b.
struct Distance {
  using Rows = DistanceRows;
  static constexpr bool kLeavesTurns = true;
  using Block = DistanceBlock;

  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointBodyLanes& bodies,
                      const JointPlacement& at, Block& block) {
    F limit, drive, unused2, unused3;
    load_impulses(args, joint, 0, limit, drive, unused2, unused3);
    prepare_axis(args, bodies, asked_of_distance(args, joint), limit, drive, block.axis);
    store3(block.direction, rotate(at.frame_a, V3{F(1.0f), F(0.0f), F(0.0f)}));
    place(bodies, store_anchors(at, block.first), block);
    clear_turned(block.turned);
    const WideStiffness given = load_stiffness(args, joint);
    const Softness held = soften_held(args, bodies, given.hertz, given.damping_ratio);
    store_softness(block.held, held);
    store_softness(block.relaxed, relax_held(held, given.hertz));
  }
  static void warm_start(const Block& block, JointBodyLanes& bodies) {
    push(bodies, load3(block.arm_a), load3(block.arm_b), load3(block.direction) * impulse_of(block));
  }
  static void solve(const JointArgs& args, Block& block, JointBodyLanes& bodies) {
    const F keep(args.impulse_keep);
    push_turned(block.turned, bodies, keep);
    solve_rows(args, load_softness(block.held), keep, block, bodies);
  }
  static F relax(const JointArgs& args, Block& block, const WideDelta& delta_a, const WideDelta& delta_b,
                 JointBodyLanes& bodies) {
    const Wrench before = wrench_of(block);
    const V3 old_direction = load3(block.direction);
    place(bodies, move_anchors(block.first, delta_a, delta_b), block);
    forget_if_passed(old_direction, block);
    store_turned(before, wrench_of(block), block.turned);
    return solve_rows(args, load_softness(block.relaxed), F(1.0f), block, bodies);
  }
  static JointImpulse acting(const Block& block) { return acting_of(wrench_of(block)); }
  static void store(const JointArgs& args, const std::int32_t* joint, int count, const Block& block) {
    const F zero(0.0f);
    F limit = load(block.axis.limit_impulse), drive = load(block.axis.drive_impulse);
    const M finite = is_finite(limit) & is_finite(drive) & is_finite(load3(block.direction));
    limit = select(finite, limit, zero);  // a non-finite one would make its bodies so again
    drive = select(finite, drive, zero);
    store_impulses(args, joint, count, 0, limit, drive, zero, zero);
  }
};

}  // namespace

template <>
JointTypeKernels make_joint_type_kernels<JointType::distance>() {
  const JointVariantKernels both = make_joint_kernels_of<Distance>();
  return {both, both};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
