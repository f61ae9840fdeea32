// Welds; see simd/constraints/joints/joint_kernels.h.
#include <simd/constraints/joints/joint_angular.h>
#include <simd/constraints/joints/joint_sweeps.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// The anchors as measure_point() has them, the rotation as measure_rotation(), each with its own softness.
struct WeldRows : FramedShape {
  static constexpr int kHeld = 6;
  static constexpr bool kKeepsHeld = true;
  static constexpr bool is_angular(int held) { return held >= 3; }
  static void measure(const Lanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b,
                      RowsNow<WeldRows>& now) {
    const auto [anchors, frames] = move_placed(lanes, delta_a, delta_b);
    now.arm_b = anchors.arm_b;
    measure_point(anchors, 0, now);
    measure_rotation(frames, 3, now);
  }
  static void impulses(const F (&stored)[kJointImpulses], const RowsNow<WeldRows>&,
                       RowImpulses<WeldRows>& along) {
    point_impulses(stored, along);
    for (int i = 0; i < 3; ++i) along.held[3 + i] = stored[4 + i];
  }
};

// Impulses: 0 to 2 at the anchor, 4 to 6 the torque about it; in world axes.
struct Weld {
  using Rows = WeldRows;
  struct alignas(64) Block {
    LaneInts row_a, row_b;
    PointLanes point;
    FrameLanes frames;
    TurningLanes turning;
    LaneSoftness held, relaxed;  // of the rotation; in solve, in relax
  };

  static void refresh(const JointBodyLanes& bodies, const Frames& frames, Block& block) {
    const HeldTurning turning = held_turning(bodies, load3(block.point.arm_a), load3(block.point.arm_b),
                                             load6(block.point.inverse_response));
    store9(block.turning.share, turning.share);
    store6(block.turning.inertia, turning.inertia);
    store3(block.turning.error, rotation_error(frames));
  }

  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointBodyLanes& bodies,
                      const JointPlacement& at, Block& block) {
    V3 impulse, torque;
    F unused;
    load_impulses(args, joint, 0, impulse.x, impulse.y, impulse.z, unused);
    load_impulses(args, joint, 1, torque.x, torque.y, torque.z, unused);
    prepare_point(args, joint, bodies, at, impulse, block.point);
    store3(block.turning.torque, torque * F(args.warm_start_scale));
    const WideStiffness given = load_stiffness(args, joint);
    const Softness held = soften_held(args, bodies, given.angular_hertz, given.angular_damping_ratio);
    store_softness(block.held, held);
    store_softness(block.relaxed, relax_held(held, given.angular_hertz));
    refresh(bodies, store_frames(at, block.frames), block);
  }
  static void warm_start(const Block& block, JointBodyLanes& bodies) {
    warm_start_held(block.point, block.turning, bodies);
  }
  static void solve(const JointArgs& args, Block& block, JointBodyLanes& bodies) {
    const F keep(args.impulse_keep);
    turn_point(block.point, bodies, keep);
    solve_held(block.point, block.turning, bodies, load_softness(block.point.held), load_softness(block.held),
               keep);
  }
  static F relax(const JointArgs&, Block& block, const WideDelta& delta_a, const WideDelta& delta_b,
                 JointBodyLanes& bodies) {
    move_point(block.point, delta_a, delta_b, bodies);
    refresh(bodies, move_frames(block.frames, delta_a, delta_b), block);
    return solve_held(block.point, block.turning, bodies, load_softness(block.point.relaxed),
                      load_softness(block.relaxed), F(1.0f));
  }
  static JointImpulse acting(const Block& block) {
    return {load3(block.point.impulse), load3(block.turning.torque)};
  }
  static void store(const JointArgs& args, const std::int32_t* joint, int count, const Block& block) {
    store_held(args, joint, count, block.point, block.turning);
  }
};

}  // namespace

template <>
JointTypeKernels make_joint_type_kernels<JointType::weld>() {
  const JointVariantKernels both = make_joint_kernels_of<Weld>();
  return {both, both};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
