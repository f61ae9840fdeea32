// Hinges; see simd/constraints/joints/joint_kernels.h.
#include <simd/constraints/joints/joint_angular.h>
#include <simd/constraints/joints/joint_sweeps.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// The anchors as measure_point() has them, the x axes as measure_alignment(). The axis is the angle about
// x_a, J = [0, -x_a, 0, x_a]; as Jolt's PointConstraintPart, HingeRotationConstraintPart and
// AngleConstraintPart.
struct HingeRows : FramedShape {
  static constexpr int kHeld = 5, kAxes = 1;
  static constexpr bool kKeepsHeld = true;
  static constexpr AxisUnit unit(int) { return AxisUnit::angle; }
  static void measure(const Lanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b,
                      RowsNow<HingeRows>& now) {
    const auto [anchors, frames] = move_placed(lanes, delta_a, delta_b);
    const M3 a = to_matrix(frames.a);
    now.arm_b = anchors.arm_b;
    measure_point(anchors, 0, now);
    measure_alignment(a, x_axis(frames.b), 3, now);
    now.axis[0] = turn_row(a.x);
    now.coordinate[0] = twist_angle(conjugate(frames.a) * frames.b);
  }
  static void impulses(const F (&stored)[kJointImpulses], const RowsNow<HingeRows>& now,
                       RowImpulses<HingeRows>& along) {
    point_impulses(stored, along);
    const V3 torque{stored[4], stored[5], stored[6]};
    for (int i = 3; i < kHeld; ++i) along.held[i] = dot(now.held[i].angular_b, torque);
    along.limit[0] = stored[8];
    along.drive[0] = stored[9];
  }
};

struct HingeLanes {
  PointLanes point;
  FrameLanes frames;
  TurningLanes turning;  // square to the x axis of frame a
  LaneFloats x[3];       // that axis
};

// How the bodies turn about the axis alone, with all that is held kept as it is: by a torque impulse of 1
// about x comes the rest of `torque`, and the impulse at the anchors of HeldTurning.
struct AxisTurning {
  F inertia;
  V3 torque;
};

inline V3 square_to(V3 axis, V3 v) { return v - axis * dot(axis, v); }

inline AxisTurning refresh(const JointBodyLanes& bodies, const Frames& frames, V3 x, HingeLanes& hinge) {
  const HeldTurning turning = held_turning(bodies, load3(hinge.point.arm_a), load3(hinge.point.arm_b),
                                           load6(hinge.point.inverse_response));
  // Inertia without the free direction: the inverse of the response to torques square to it.
  const S3& full = turning.inertia;
  const V3 along = full * x;
  const F about_x = dot(along, x);
  const V3 free = along * invert_positive(about_x);
  store9(hinge.turning.share, turning.share);
  store6(hinge.turning.inertia,
         {full.xx - along.x * free.x, full.xy - along.x * free.y, full.xz - along.x * free.z,
          full.yy - along.y * free.y, full.yz - along.y * free.z, full.zz - along.z * free.z});
  const Swing away = swing(x, x_axis(frames.b));
  store3(hinge.turning.error, away.axis * away.angle);
  store3(hinge.x, x);
  return {about_x, free};
}

inline AxisTurning prepare_hinge(const JointArgs& args, const std::int32_t* joint,
                                 const JointBodyLanes& bodies, const JointPlacement& at, HingeLanes& hinge) {
  V3 impulse, torque;
  F unused;
  load_impulses(args, joint, 0, impulse.x, impulse.y, impulse.z, unused);
  load_impulses(args, joint, 1, torque.x, torque.y, torque.z, unused);
  prepare_point(args, joint, bodies, at, impulse, hinge.point);
  const Frames frames = store_frames(at, hinge.frames);
  const V3 x = x_axis(frames.a);
  store3(hinge.turning.torque, square_to(x, torque * F(args.warm_start_scale)));
  return refresh(bodies, frames, x, hinge);
}

// `about_x`: the torque impulse that acts about the axis.
inline AxisTurning move_hinge(const Frames& frames, const WideDelta& delta_a, const WideDelta& delta_b,
                              const JointBodyLanes& bodies, F about_x, HingeLanes& hinge) {
  move_point(hinge.point, delta_a, delta_b, bodies);
  const V3 old_x = load3(hinge.x), x = x_axis(frames.a);
  const V3 old_torque = load3(hinge.turning.torque), torque = square_to(x, old_torque);
  turn_torque(hinge.point, (torque - old_torque) + (x - old_x) * about_x);
  store3(hinge.turning.torque, torque);
  return refresh(bodies, frames, x, hinge);
}

inline F relax_hinge(HingeLanes& hinge, JointBodyLanes& bodies) {
  const Softness relaxed = load_softness(hinge.point.relaxed);
  return solve_held(hinge.point, hinge.turning, bodies, relaxed, relaxed, F(1.0f));
}

inline void solve_hinge(HingeLanes& hinge, JointBodyLanes& bodies, F keep) {
  turn_point(hinge.point, bodies, keep);
  const Softness held = load_softness(hinge.point.held);
  solve_held(hinge.point, hinge.turning, bodies, held, held, keep);
}

inline JointImpulse acting_of(const HingeLanes& hinge) {
  return {load3(hinge.point.impulse), load3(hinge.turning.torque)};
}

// Impulses: 0 to 2 at the anchor, 4 to 6 the torque square to the axis; in world axes.
struct PlainHinge {
  using Rows = HingeRows;
  struct alignas(64) Block {
    LaneInts row_a, row_b;
    HingeLanes hinge;
  };

  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointBodyLanes& bodies,
                      const JointPlacement& at, Block& block) {
    prepare_hinge(args, joint, bodies, at, block.hinge);
  }
  static void warm_start(const Block& block, JointBodyLanes& bodies) {
    warm_start_held(block.hinge.point, block.hinge.turning, bodies);
  }
  static void solve(const JointArgs& args, Block& block, JointBodyLanes& bodies) {
    solve_hinge(block.hinge, bodies, F(args.impulse_keep));
  }
  static F relax(const JointArgs&, Block& block, const WideDelta& delta_a, const WideDelta& delta_b,
                 JointBodyLanes& bodies) {
    const Frames frames = move_frames(block.hinge.frames, delta_a, delta_b);
    move_hinge(frames, delta_a, delta_b, bodies, F(0.0f), block.hinge);
    return relax_hinge(block.hinge, bodies);
  }
  static JointImpulse acting(const Block& block) { return acting_of(block.hinge); }
  static void store(const JointArgs& args, const std::int32_t* joint, int count, const Block& block) {
    const F zero(0.0f);
    store_held(args, joint, count, block.hinge.point, block.hinge.turning);
    store_impulses(args, joint, count, 2, zero, zero, zero, zero);  // of a limit that the joint had before
  }
};

// What limits and drives the angle.
struct HingeAxis {
  LaneFloats angle;
  LaneFloats response_alone, response_held;  // of the speed about the axis; alone, and with the rest held
  LaneFloats impulse_by[3], torque_by[3];    // what holds the rest against a unit about the axis
  LaneAxis axis;
};

inline void refresh_axis(const JointBodyLanes& bodies, const AxisTurning& turning, const Frames& frames,
                         const HingeLanes& hinge, HingeAxis& axis) {
  const V3 x = load3(hinge.x);
  store(axis.angle, twist_angle(conjugate(frames.a) * frames.b));
  store(axis.response_alone, dot(x, turn_response(bodies) * x));
  store(axis.response_held, invert_positive(turning.inertia));
  store3(axis.torque_by, turning.torque - x);
  store3(axis.impulse_by, -(load9(hinge.turning.share) * turning.torque));
}

inline F impulse_about(const HingeAxis& axis) {
  return load(axis.axis.limit_impulse) + load(axis.axis.drive_impulse);
}

// Changes the impulse about the axis, and as much of those that hold the rest as free_response() says.
inline void turn_about(HingeLanes& hinge, const HingeAxis& axis, JointBodyLanes& bodies, const Softness& held,
                       F change) {
  const F by = change * held.mass_scale;
  const V3 impulse = load3(axis.impulse_by) * by, torque = load3(axis.torque_by) * by;
  push_and_twist(bodies, load3(hinge.point.arm_a), load3(hinge.point.arm_b), impulse,
                 torque + load3(hinge.x) * change);
  store3(hinge.point.impulse, load3(hinge.point.impulse) + impulse);
  store3(hinge.turning.torque, load3(hinge.turning.torque) + torque);
}

// `held`: the softness by which the rest is held in this sweep, and the limit.
inline void solve_axis(const JointArgs& args, HingeLanes& hinge, HingeAxis& lanes, JointBodyLanes& bodies,
                       const Softness& held, F keep) {
  LaneAxis& axis = lanes.axis;
  const V3 x = load3(hinge.x);
  const F angle = load(lanes.angle);
  const F inertia =
      invert_positive(free_response(load(lanes.response_alone), load(lanes.response_held), held));
  const F ahead = shorter_way(angle - target_now(args, axis));
  const F driven = solve_drive(axis, ahead, dot(x, turning_speed(bodies)), inertia, keep);
  turn_about(hinge, lanes, bodies, held, driven);
  const F within = angle_within(angle, load(axis.lower), load(axis.upper));
  const F speed = dot(x, turning_speed(bodies));
  turn_about(hinge, lanes, bodies, held,
             solve_limit(args, Course::circle, axis, within, speed, inertia, held, keep));
}

// As PlainHinge; 8 the limit's, 9 the drive's torque about the axis.
struct RichHinge {
  using Rows = HingeRows;
  struct alignas(64) Block {
    LaneInts row_a, row_b;
    HingeLanes hinge;
    HingeAxis axis;
  };

  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointBodyLanes& bodies,
                      const JointPlacement& at, Block& block) {
    F limit, drive, unused, more;
    load_impulses(args, joint, 2, limit, drive, unused, more);
    prepare_axis(args, bodies, load_axis(args, joint, 0), limit, drive, block.axis.axis);
    const AxisTurning turning = prepare_hinge(args, joint, bodies, at, block.hinge);
    refresh_axis(bodies, turning, {at.frame_a, at.frame_b}, block.hinge, block.axis);
  }
  static void warm_start(const Block& block, JointBodyLanes& bodies) {
    warm_start_held(block.hinge.point, block.hinge.turning, bodies);
    twist(bodies, load3(block.hinge.x) * impulse_about(block.axis));
  }
  static void solve(const JointArgs& args, Block& block, JointBodyLanes& bodies) {
    const F keep(args.impulse_keep);
    solve_hinge(block.hinge, bodies, keep);
    const Softness held = load_softness(block.hinge.point.held);
    solve_axis(args, block.hinge, block.axis, bodies, held, keep);
  }
  static F relax(const JointArgs& args, Block& block, const WideDelta& delta_a, const WideDelta& delta_b,
                 JointBodyLanes& bodies) {
    const Frames frames = move_frames(block.hinge.frames, delta_a, delta_b);
    const AxisTurning turning =
        move_hinge(frames, delta_a, delta_b, bodies, impulse_about(block.axis), block.hinge);
    refresh_axis(bodies, turning, frames, block.hinge, block.axis);
    const F error = relax_hinge(block.hinge, bodies);
    const Softness relaxed = load_softness(block.hinge.point.relaxed);
    solve_axis(args, block.hinge, block.axis, bodies, relaxed, F(1.0f));
    return error;
  }
  static JointImpulse acting(const Block& block) {
    const JointImpulse held = acting_of(block.hinge);
    return {held.linear, held.angular + load3(block.hinge.x) * impulse_about(block.axis)};
  }
  static void store(const JointArgs& args, const std::int32_t* joint, int count, const Block& block) {
    const F zero(0.0f), limit = finite_or_zero(load(block.axis.axis.limit_impulse)),
                        drive = finite_or_zero(load(block.axis.axis.drive_impulse));
    store_held(args, joint, count, block.hinge.point, block.hinge.turning);
    store_impulses(args, joint, count, 2, limit, drive, zero, zero);
  }
};

}  // namespace

template <>
JointTypeKernels make_joint_type_kernels<JointType::hinge>() {
  return {make_joint_kernels_of<PlainHinge>(), make_joint_kernels_of<RichHinge>()};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
