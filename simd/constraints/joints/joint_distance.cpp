// Distance joints: rods, ropes and springs from anchor to anchor; see
// simd/constraints/joints/joint_kernels.h.
#include <simd/constraints/joints/joint_linear.h>
#include <simd/constraints/joints/joint_sweeps.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

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

inline void place(const JointBodies& bodies, const Anchors& now, DistanceBlock& block) {
  const F distance = length(now.offset), one(1.0f);
  const M apart = distance > F(1e-9f);
  const V3 direction =
      select(apart, now.offset * (one / select(apart, distance, one)), load3(block.direction));
  const F response = response_along(bodies, now.arm_a, now.arm_b, direction);
  store3(block.arm_a, now.arm_a);
  store3(block.arm_b, now.arm_b);
  store3(block.direction, direction);
  store(block.length, distance);
  store(block.mass, invert_positive(response));
}

// No distance is below 0, and a limit there would keep the anchors from passing each other.
inline void drop_lower_limit_of_zero(LaneAxis& axis) {
  const F lower = load(axis.lower);
  const M none = (lower <= F(0.0f)) & (lower < load(axis.upper));
  store(axis.lower, select(none, F(-__builtin_inff()), lower));
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
                    JointBodies& bodies) {
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
  static constexpr bool kLeavesTurns = true;
  using Block = DistanceBlock;

  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointBodies& bodies,
                      const JointPlacement& at, Block& block) {
    F limit, drive, unused2, unused3;
    load_impulses(args, joint, 0, limit, drive, unused2, unused3);
    prepare_axis(args, joint, bodies, 0, limit, drive, block.axis);
    drop_lower_limit_of_zero(block.axis);
    store3(block.direction, rotate(at.frame_a, V3{F(1.0f), F(0.0f), F(0.0f)}));
    place(bodies, store_anchors(at, block.first), block);
    clear_turned(block.turned);
    const WideStiffness given = load_stiffness(args, joint);
    const Softness held = soften_held(args, bodies, given.hertz, given.damping_ratio);
    store_softness(block.held, held);
    store_softness(block.relaxed, relax_held(held, given.hertz));
  }
  static void warm_start(const Block& block, JointBodies& bodies) {
    push(bodies, load3(block.arm_a), load3(block.arm_b), load3(block.direction) * impulse_of(block));
  }
  static void solve(const JointArgs& args, Block& block, JointBodies& bodies) {
    const F keep(args.impulse_keep);
    push_turned(block.turned, bodies, keep);
    solve_rows(args, load_softness(block.held), keep, block, bodies);
  }
  static F relax(const JointArgs& args, Block& block, const WideDelta& delta_a, const WideDelta& delta_b,
                 JointBodies& bodies) {
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
