// Ball joints; see simd/constraints/joints/joint_kernels.h.
#include <simd/constraints/joints/joint_angular.h>
#include <simd/constraints/joints/joint_sweeps.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// Where the x axes are opposite, no twist is defined: the least of 1 + their cosine.
constexpr float kLeastTwistAxis = 1e-3f;

// The anchors as measure_point() has them; further
//
//   twist   the angle of b about its x axis, once the shortest turn that brings the x axes together is taken
//           away: J = [0, -t, 0, t] with t = (x_a + x_b) / (1 + x_a . x_b), its rate exactly
//   cone    the angle between the x axes: J = [0, -n, 0, n] with n square to both
//   drive   C = q_a (the rotation vector of q_a* q_b target*), J = [0, -1, 0, 1]
//
// as Jolt's SwingTwistConstraintPart and its motors, which limit a twist and a swing, too.
struct BallRows : FramedShape {
  static constexpr int kHeld = 3, kAxes = 2, kDrives = 1;
  static constexpr bool kKeepsHeld = true, kAxisDrives = false;
  static constexpr int kTwist = 0, kCone = 1;
  static constexpr AxisUnit unit(int axis) { return axis == kTwist ? AxisUnit::angle : AxisUnit::opening; }
  struct Lanes {
    PlacedLanes placed;
    LaneFloats target[4], velocity[3], elapsed;
  };
  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointPlacement& at,
                      const LaneInts&, const LaneInts&, F, Lanes& lanes) {
    store_placed(at, lanes.placed);
    const RotationTarget target = load_rotation_target(args, joint);
    store4(lanes.target, target.rotation);
    store3(lanes.velocity, target.velocity);
    store(lanes.elapsed, F(args.elapsed));
  }
  static void measure(const Lanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b,
                      RowsNow<BallRows>& now) {
    const auto [anchors, frames] = move_placed(lanes.placed, delta_a, delta_b);
    measure_point(anchors, 0, now);
    now.arm_b = anchors.arm_b;
    const V3 x_a = x_axis(frames.a), x_b = x_axis(frames.b);
    const F zero(0.0f), one(1.0f), apart = one + dot(x_a, x_b);
    const M defined = apart > F(kLeastTwistAxis);
    now.axis[kTwist] = turn_row((x_a + x_b) * select(defined, one / select(defined, apart, one), zero));
    now.coordinate[kTwist] = twist_angle(conjugate(frames.a) * frames.b);
    const Swing away = swing(x_a, x_b);
    now.axis[kCone] = turn_row(away.axis);
    now.coordinate[kCone] = away.angle;
    const V3 velocity = load3(lanes.velocity);
    measure_rotation_drive(frames, rotation_by(velocity * load(lanes.elapsed)) * load4(lanes.target),
                           velocity, now.drive[0]);
  }
  static WideAxis asked(const JointArgs& args, const std::int32_t* joint, int axis, const Row&,
                        const JointBodyLanes&) {
    WideAxis asked = load_axis(args, joint, axis);
    if (axis == kCone) asked.lower = F(-kInfinity);
    return asked;
  }
  static WideDrive asked_drive(const JointArgs& args, const std::int32_t* joint, int, const JointBodyLanes&) {
    return load_rotation_drive(args, joint);
  }
  static void impulses(const F (&stored)[kJointImpulses], const RowsNow<BallRows>&,
                       RowImpulses<BallRows>& along) {
    point_impulses(stored, along);
    along.limit[kCone] = stored[3];
    along.limit[kTwist] = stored[7];
    for (int i = 0; i < 3; ++i) along.drive3[0][i] = stored[4 + i];
    for (F& none : along.drive) none = F(0.0f);
  }
};

// Impulses: 0 to 2 at the anchor, in world axes. Clears those that limits and the drive had before.
struct PlainBall {
  using Rows = BallRows;
  static constexpr bool kLeavesTurns = true;
  struct alignas(64) Block {
    LaneInts row_a, row_b;
    PointLanes point;
  };

  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointBodyLanes& bodies,
                      const JointPlacement& at, Block& block) {
    V3 impulse;
    F unused;
    load_impulses(args, joint, 0, impulse.x, impulse.y, impulse.z, unused);
    prepare_point(args, joint, bodies, at, impulse, block.point);
  }
  static void warm_start(const Block& block, JointBodyLanes& bodies) {
    warm_start_point(block.point, bodies);
  }
  static void solve(const JointArgs& args, Block& block, JointBodyLanes& bodies) {
    const F keep(args.impulse_keep);
    turn_point(block.point, bodies, keep);
    solve_point(block.point, bodies, load_softness(block.point.held), keep);
  }
  static F relax(const JointArgs&, Block& block, const WideDelta& delta_a, const WideDelta& delta_b,
                 JointBodyLanes& bodies) {
    move_point(block.point, delta_a, delta_b, bodies);
    return relax_point(block.point, bodies);
  }
  static JointImpulse acting(const Block& block) {
    const F zero(0.0f);
    return {load3(block.point.impulse), {zero, zero, zero}};
  }
  static void store(const JointArgs& args, const std::int32_t* joint, int count, const Block& block) {
    const V3 none{F(0.0f), F(0.0f), F(0.0f)};
    const V3 impulse = finite_or_zero(load3(block.point.impulse));
    store_impulses(args, joint, count, 0, impulse.x, impulse.y, impulse.z, none.x);
    store_impulses(args, joint, count, 1, none.x, none.x, none.x, none.x);
  }
};

// A limit of an angle that changes with the bodies' turning against each other along `axis`.
struct BallLimit {
  LaneFloats axis[3];  // in world axes; not of unit length
  LaneFloats defined;  // 0 where the axis is not, else 1
  LaneFloats angle;
  LaneFloats lower, upper, limit_impulse;
};
// A cone's angle is in [0, pi]; where it is pi its axis turns over.
constexpr Course kConeCourse = Course::line, kTwistCourse = Course::circle;

inline V3 torque_of(const BallLimit& limit) { return load3(limit.axis) * load(limit.limit_impulse); }

inline void prepare_limit(BallLimit& limit, F lower, F upper, F impulse) {
  store(limit.lower, lower);
  store(limit.upper, upper);
  store(limit.limit_impulse, impulse);
}

inline void aim_limit(BallLimit& limit, V3 axis, F angle, F defined) {
  store3(limit.axis, axis);
  store(limit.angle, angle);
  store(limit.defined, defined);
}

// As PlainBall; 3 the cone limit's, 7 the twist limit's about its axis, 4 to 6 the drive's torque, in world
// axes.
//
// All torques turn the bodies about the anchor, see HeldTurning, as far as the anchor is held: what is soft
// gives way, and would answer to a rigid hold with more than was taken from it.
struct RichBall {
  using Rows = BallRows;
  static constexpr bool kLeavesTurns = true;
  struct alignas(64) Block {
    LaneInts row_a, row_b;
    PointLanes point;
    FrameLanes frames;
    LaneFloats share[3][3];  // HeldTurning
    LaneFloats
        response_held[6];  // of turning to torques while the anchor is held: HeldTurning::inertia inverted
    BallLimit cone, twist;
    RotationDriveLanes drive;
  };

  // Where the axes are opposite, no twist is defined; near that its axis would grow without bound.
  static void refresh(const JointBodyLanes& bodies, const Frames& frames, Block& block) {
    const HeldTurning turning = held_turning(bodies, load3(block.point.arm_a), load3(block.point.arm_b),
                                             load6(block.point.inverse_response));
    store9(block.share, turning.share);
    store6(block.response_held, invert_semidefinite(turning.inertia));
    const V3 x_a = x_axis(frames.a), x_b = x_axis(frames.b);
    const Swing away = swing(x_a, x_b);
    aim_limit(block.cone, away.axis, away.angle, F(1.0f));
    const F zero(0.0f), one(1.0f), apart = one + dot(x_a, x_b);
    const M defined = apart > F(kLeastTwistAxis);
    const V3 axis = (x_a + x_b) * (one / select(defined, apart, one));
    const F twist = angle_within(twist_angle(conjugate(frames.a) * frames.b), load(block.twist.lower),
                                 load(block.twist.upper));
    aim_limit(block.twist, axis, twist, select(defined, one, zero));
  }

  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointBodyLanes& bodies,
                      const JointPlacement& at, Block& block) {
    V3 impulse, drive;
    F cone, twist;
    load_impulses(args, joint, 0, impulse.x, impulse.y, impulse.z, cone);
    load_impulses(args, joint, 1, drive.x, drive.y, drive.z, twist);
    prepare_point(args, joint, bodies, at, impulse, block.point);
    const Frames frames = store_frames(at, block.frames);
    prepare_rotation_drive(args, joint, bodies, frames, drive, block.drive);
    const WideAxis twist_axis = load_axis(args, joint, 0), cone_axis = load_axis(args, joint, 1);
    const F scale(args.warm_start_scale);
    prepare_limit(block.cone, F(-__builtin_inff()), cone_axis.upper, cone * scale);
    prepare_limit(block.twist, twist_axis.lower, twist_axis.upper, twist * scale);
    refresh(bodies, frames, block);
  }

  static V3 torque(const Block& block) {
    return torque_of(block.cone) + torque_of(block.twist) + load3(block.drive.impulse);
  }

  // A torque impulse, with what keeps the anchors together.
  static void turn(Block& block, JointBodyLanes& bodies, const Softness& held, V3 torque) {
    const V3 impulse = load9(block.share) * (torque * -held.mass_scale);
    push_and_twist(bodies, load3(block.point.arm_a), load3(block.point.arm_b), impulse, torque);
    store3(block.point.impulse, load3(block.point.impulse) + impulse);
  }
  static void solve_limit_of(const JointArgs& args, Course course, BallLimit& limit, Block& block,
                             JointBodyLanes& bodies, const S3& response, const Softness& held, F keep) {
    const V3 axis = load3(limit.axis);
    const F rate = dot(axis, turning_speed(bodies));
    const F inertia = load(limit.defined) * invert_positive(dot(axis, response * axis));
    turn(block, bodies, held,
         axis * solve_limit(args, course, limit, load(limit.angle), rate, inertia, held, keep));
  }
  // `held`: the softness by which the anchor is held in this sweep, and limits are.
  static void solve_turning(const JointArgs& args, Block& block, JointBodyLanes& bodies, const Softness& held,
                            F keep) {
    const S3 response = free_response(turn_response(bodies), load6(block.response_held), held);
    const V3 driven = solve_rotation_drive(block.drive, turning_speed(bodies), response, keep);
    turn(block, bodies, held, driven);
    solve_limit_of(args, kTwistCourse, block.twist, block, bodies, response, held, keep);
    solve_limit_of(args, kConeCourse, block.cone, block, bodies, response, held, keep);
  }

  static void warm_start(const Block& block, JointBodyLanes& bodies) {
    push_and_twist(bodies, load3(block.point.arm_a), load3(block.point.arm_b), load3(block.point.impulse),
                   torque(block));
  }
  static void solve(const JointArgs& args, Block& block, JointBodyLanes& bodies) {
    const F keep(args.impulse_keep);
    const Softness held = load_softness(block.point.held);
    turn_point(block.point, bodies, keep);
    solve_point(block.point, bodies, held, keep);
    solve_turning(args, block, bodies, held, keep);
  }
  static F relax(const JointArgs& args, Block& block, const WideDelta& delta_a, const WideDelta& delta_b,
                 JointBodyLanes& bodies) {
    const Frames frames = move_frames(block.frames, delta_a, delta_b);
    const V3 old_torque = torque(block);
    move_point(block.point, delta_a, delta_b, bodies);
    refresh(bodies, frames, block);
    turn_torque(block.point, torque(block) - old_torque);
    aim_rotation_drive(frames, F(args.elapsed), block.drive);
    const F error = relax_point(block.point, bodies);
    solve_turning(args, block, bodies, load_softness(block.point.relaxed), F(1.0f));
    return error;
  }
  static JointImpulse acting(const Block& block) { return {load3(block.point.impulse), torque(block)}; }
  static void store(const JointArgs& args, const std::int32_t* joint, int count, const Block& block) {
    const V3 impulse = finite_or_zero(load3(block.point.impulse));
    const V3 drive = finite_or_zero(load3(block.drive.impulse));
    store_impulses(args, joint, count, 0, impulse.x, impulse.y, impulse.z,
                   finite_or_zero(load(block.cone.limit_impulse)));
    store_impulses(args, joint, count, 1, drive.x, drive.y, drive.z,
                   finite_or_zero(load(block.twist.limit_impulse)));
  }
};

}  // namespace

template <>
JointTypeKernels make_joint_type_kernels<JointType::ball>() {
  return {make_joint_kernels_of<PlainBall>(), make_joint_kernels_of<RichBall>()};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
