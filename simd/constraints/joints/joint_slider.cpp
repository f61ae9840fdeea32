// Slider joints; see simd/constraints/joints/joint_kernels.h.
//
// Five held rows: the rotation, and anchor b's offset along the y and z axes of frame a. They are solved as
// one, with the rotation eliminated: what the offset's rows meet are two bodies that do not turn against each
// other. The slide itself, where it has a limit or a drive, is solved with all five of them held, so that a
// spring has the frequency that it was given wherever the anchors lie.
#include <simd/constraints/joints/joint_linear.h>
#include <simd/constraints/joints/joint_sweeps.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// With d the way from anchor a to anchor b, which is also where forces act on a:
//
//   held   C = y_a . d and z_a . d,   J = [-y_a, -(r_a + d) x y_a, y_a, r_b x y_a]; and measure_rotation()
//   axis   x_a . d as above
//
// as Jolt's DualAxisConstraintPart, RotationEulerConstraintPart and AxisConstraintPart.
struct SliderRows : FramedShape {
  static constexpr int kHeld = 5, kAxes = 1;
  static constexpr bool kKeepsHeld = true;
  static void measure(const Lanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b,
                      RowsNow<SliderRows>& now) {
    const auto [anchors, frames] = move_placed(lanes, delta_a, delta_b);
    const M3 a = to_matrix(frames.a);
    now.arm_b = anchors.arm_b;
    now.held[0] = offset_row(a.y, anchors.arm_a, anchors.arm_b, anchors.offset);
    now.error[0] = dot(a.y, anchors.offset);
    now.held[1] = offset_row(a.z, anchors.arm_a, anchors.arm_b, anchors.offset);
    now.error[1] = dot(a.z, anchors.offset);
    measure_rotation(frames, 2, now);
    now.axis[0] = offset_row(a.x, anchors.arm_a, anchors.arm_b, anchors.offset);
    now.coordinate[0] = dot(a.x, anchors.offset);
  }
  static void impulses(const F (&stored)[kJointImpulses], const RowsNow<SliderRows>&,
                       RowImpulses<SliderRows>& along) {
    for (int i = 0; i < 2; ++i) along.held[i] = stored[i];
    for (int i = 0; i < 3; ++i) along.held[2 + i] = stored[4 + i];
    along.limit[0] = stored[2];
    along.drive[0] = stored[3];
  }
};

struct alignas(64) SliderBlock {
  LaneInts row_a, row_b;
  PlacedLanes first;
  LaneFloats lever_a[3], lever_b[3];  // now; both lead to anchor b
  LaneFloats side[2][3];              // y and z axes of frame a
  LaneFloats side_error[2], turn_error[3];
  LaneFloats turn_mass[6];  // inverse responses: of the rotation
  LaneFloats side_mass[3];  // and of the sides, with the rotation held
  LaneFloats side_impulse[2], torque[3];
  TurnedLanes turned;
  LaneSoftness held, relaxed;
};

struct alignas(64) RichSliderBlock : SliderBlock {
  LaneFloats axis[3];       // x axis of frame a
  LaneFloats slide_way[3];  // of a unit impulse along the axis and those along the sides that hold these
  LaneFloats response_alone, response_held;  // of the slide; alone, and with the held rows held
  LaneFloats slide;
  LaneAxis drive;
};

template <class Block>
inline constexpr bool kIsRich = false;
template <>
inline constexpr bool kIsRich<RichSliderBlock> = true;

inline V3 side_impulse(const SliderBlock& block) {
  return load3(block.side[0]) * load(block.side_impulse[0]) +
         load3(block.side[1]) * load(block.side_impulse[1]);
}

template <class Block>
inline Wrench wrench_of(const Block& block) {
  Wrench wrench{load3(block.lever_a), load3(block.lever_b), side_impulse(block), load3(block.torque)};
  if constexpr (kIsRich<Block>) {
    wrench.impulse = wrench.impulse +
                     load3(block.axis) * (load(block.drive.limit_impulse) + load(block.drive.drive_impulse));
  }
  return wrench;
}

inline void store_held_impulses(F side0, F side1, V3 torque, SliderBlock& block) {
  store(block.side_impulse[0], side0);
  store(block.side_impulse[1], side1);
  store3(block.torque, torque);
}

template <class Block>
inline void place(const JointBodyLanes& bodies, const Placed& now, Block& block) {
  const V3 offset = now.anchors.offset, lever_a = now.anchors.arm_a + offset, lever_b = now.anchors.arm_b;
  const M3 axes = to_matrix(now.frames.a);
  store3(block.lever_a, lever_a);
  store3(block.lever_b, lever_b);
  store3(block.side[0], axes.y);
  store3(block.side[1], axes.z);
  store(block.side_error[0], dot(axes.y, offset));
  store(block.side_error[1], dot(axes.z, offset));
  store3(block.turn_error, rotation_error(now.frames));
  const S3 turn_mass = invert_semidefinite(turn_response(bodies));
  store6(block.turn_mass, turn_mass);
  const S3 response = response_of_both(bodies, turn_mass, lever_a - lever_b);
  const V3 by_y = response * axes.y, by_z = response * axes.z;
  const S2 side_mass = invert(S2{dot(axes.y, by_y), dot(axes.y, by_z), dot(axes.z, by_z)});
  store(block.side_mass[0], side_mass.xx);
  store(block.side_mass[1], side_mass.xy);
  store(block.side_mass[2], side_mass.yy);
  if constexpr (kIsRich<Block>) {
    const V3 way = invert(response) * axes.x;
    const F mass = dot(axes.x, way);
    store3(block.axis, axes.x);
    store3(block.slide_way, way * invert_positive(mass));
    store(block.response_held, invert_positive(mass));
    store(block.response_alone, response_along(bodies, lever_a, lever_b, axes.x));
    store(block.slide, dot(axes.x, offset));
  }
}

// Returns the larger of the speeds, of the anchors and of rotation, that were left.
inline F solve_held(SliderBlock& block, JointBodyLanes& bodies, const Softness& soft, F keep) {
  const V3 lever_a = load3(block.lever_a), lever_b = load3(block.lever_b);
  const V3 side0 = load3(block.side[0]), side1 = load3(block.side[1]);
  const S3 turn_mass = load6(block.turn_mass);
  const V3 velocity = anchor_velocity(bodies, lever_a, lever_b);
  const V3 spin = turning_speed(bodies);
  const F speed0 = dot(side0, velocity), speed1 = dot(side1, velocity);

  const V3 turn = (spin + load3(block.turn_error) * soft.bias_rate) * soft.mass_scale;
  // What is left for the sides once the rotation alone has been stopped.
  const V3 moved = move_by_torque(bodies, lever_a, lever_b, turn_mass * turn);
  const F rest0 = (speed0 + load(block.side_error[0]) * soft.bias_rate) * soft.mass_scale - dot(side0, moved);
  const F rest1 = (speed1 + load(block.side_error[1]) * soft.bias_rate) * soft.mass_scale - dot(side1, moved);
  const F mass01 = load(block.side_mass[1]);
  const F stop0 = load(block.side_mass[0]) * rest0 + mass01 * rest1;
  const F stop1 = mass01 * rest0 + load(block.side_mass[2]) * rest1;
  const V3 stop = side0 * stop0 + side1 * stop1;
  const V3 stop_turn = turn_mass * (turn - turn_by_impulse(bodies, lever_a, lever_b, stop));

  const F old0 = load(block.side_impulse[0]) * keep, old1 = load(block.side_impulse[1]) * keep;
  const V3 old_torque = load3(block.torque) * keep;
  const F change0 = stop0 + old0 * soft.impulse_scale, change1 = stop1 + old1 * soft.impulse_scale;
  const V3 torque_change = stop_turn + old_torque * soft.impulse_scale;
  store_held_impulses(old0 - change0, old1 - change1, old_torque - torque_change, block);
  push(bodies, lever_a, lever_b, -(side0 * change0 + side1 * change1));
  twist(bodies, -torque_change);
  return max(sqrt(speed0 * speed0 + speed1 * speed1), length(spin));
}

// An impulse along the axis, and as much of those that keep the held rows as they are as free_response()
// says.
inline void push_slide(RichSliderBlock& block, JointBodyLanes& bodies, const Softness& held, F impulse) {
  const V3 lever_a = load3(block.lever_a), lever_b = load3(block.lever_b), axis = load3(block.axis);
  const V3 whole = load3(block.slide_way) * impulse;
  const V3 torque =
      load6(block.turn_mass) * turn_by_impulse(bodies, lever_a, lever_b, whole) * held.mass_scale;
  const V3 way = whole * held.mass_scale + axis * (impulse * (F(1.0f) - held.mass_scale));
  for (int i = 0; i < 2; ++i) {
    store(block.side_impulse[i], load(block.side_impulse[i]) + dot(load3(block.side[i]), way));
  }
  store3(block.torque, load3(block.torque) - torque);
  push(bodies, lever_a, lever_b, way);
  twist(bodies, -torque);
}

inline void solve_slide(const JointArgs& args, const Softness& held, F keep, RichSliderBlock& block,
                        JointBodyLanes& bodies) {
  const V3 lever_a = load3(block.lever_a), lever_b = load3(block.lever_b), axis = load3(block.axis);
  const F slide = load(block.slide);
  const F mass = invert_positive(free_response(load(block.response_alone), load(block.response_held), held));
  F speed = dot(axis, anchor_velocity(bodies, lever_a, lever_b));
  push_slide(block, bodies, held,
             solve_drive(block.drive, slide - target_now(args, block.drive), speed, mass, keep));
  speed = dot(axis, anchor_velocity(bodies, lever_a, lever_b));
  push_slide(block, bodies, held,
             solve_limit(args, Course::line, block.drive, slide, speed, mass, held, keep));
}

// Impulses: 0 and 1 along the y and z axes of frame a, 2 of the limit, 3 of the drive, 4 to 6 the torque in
// world axes.
template <class SomeBlock>
struct Slider {
  using Rows = SliderRows;
  using Block = SomeBlock;

  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointBodyLanes& bodies,
                      const JointPlacement& at, Block& block) {
    const F scale(args.warm_start_scale);
    F side0, side1, limit, drive, unused;
    V3 torque;
    load_impulses(args, joint, 0, side0, side1, limit, drive);
    load_impulses(args, joint, 1, torque.x, torque.y, torque.z, unused);
    store_held_impulses(side0 * scale, side1 * scale, torque * scale, block);
    if constexpr (kIsRich<Block>) {
      prepare_axis(args, bodies, load_axis(args, joint, 0), limit, drive, block.drive);
    }
    place(bodies, store_placed(at, block.first), block);
    clear_turned(block.turned);
    const WideStiffness given = load_stiffness(args, joint);
    const Softness held = soften_held(args, bodies, given.hertz, given.damping_ratio);
    store_softness(block.held, held);
    store_softness(block.relaxed, relax_held(held, given.hertz));
  }
  static void warm_start(const Block& block, JointBodyLanes& bodies) {
    push_wrench(wrench_of(block), bodies);
  }
  static void solve(const JointArgs& args, Block& block, JointBodyLanes& bodies) {
    const F keep(args.impulse_keep);
    const Softness held = load_softness(block.held);
    push_turned(block.turned, bodies, keep);
    solve_held(block, bodies, held, keep);
    if constexpr (kIsRich<Block>) solve_slide(args, held, keep, block, bodies);
  }
  static F relax(const JointArgs& args, Block& block, const WideDelta& delta_a, const WideDelta& delta_b,
                 JointBodyLanes& bodies) {
    const Wrench before = wrench_of(block);
    place(bodies, move_placed(block.first, delta_a, delta_b), block);
    store_turned(before, wrench_of(block), block.turned);
    const Softness relaxed = load_softness(block.relaxed);
    const F error = solve_held(block, bodies, relaxed, F(1.0f));
    if constexpr (kIsRich<Block>) solve_slide(args, relaxed, F(1.0f), block, bodies);
    return error;
  }
  static JointImpulse acting(const Block& block) { return acting_of(wrench_of(block)); }
  static void store(const JointArgs& args, const std::int32_t* joint, int count, const Block& block) {
    const F zero(0.0f);
    const Wrench wrench = wrench_of(block);
    // A non-finite impulse would make its bodies non-finite again.
    const M finite = is_finite(wrench.impulse) & is_finite(wrench.torque);
    const V3 torque = select(finite, wrench.torque, V3{zero, zero, zero});
    F limit = zero, drive = zero;
    if constexpr (kIsRich<Block>) {
      limit = select(finite, load(block.drive.limit_impulse), zero);
      drive = select(finite, load(block.drive.drive_impulse), zero);
    }
    store_impulses(args, joint, count, 0, select(finite, load(block.side_impulse[0]), zero),
                   select(finite, load(block.side_impulse[1]), zero), limit, drive);
    store_impulses(args, joint, count, 1, torque.x, torque.y, torque.z, zero);
  }
};

}  // namespace

template <>
JointTypeKernels make_joint_type_kernels<JointType::slider>() {
  return {make_joint_kernels_of<Slider<SliderBlock>>(), make_joint_kernels_of<Slider<RichSliderBlock>>()};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
