// Motors, which drive a pose; see simd/constraints/joints/joint_kernels.h.
#include <simd/constraints/joints/joint_vector_drive.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// The rotation by the rotation vector v, by Cayley's formula, as bodies turn.
inline Q4 small_rotation(V3 v) {
  const F half(0.5f);
  return normalize({v.x * half, v.y * half, v.z * half, F(1.0f)});
}

// scree::MotorJoint's drive of the offset.
struct OffsetTarget {
  V3 offset, velocity;  // in the axes of frame a
};
inline OffsetTarget load_offset_target(const JointArgs& args, const std::int32_t* joint) {
  const MotorParameters& from = args.parameters->motor;
  return {load_vector(from.target, joint), load_vector(from.velocity, joint)};
}

// With d the way from anchor a to anchor b, which is also where forces act on a:
//
//   rotation   see measure_rotation_drive()
//   offset     C = d - q_a target,   J = [-1, [r_a + d], 1, -[r_b]]
//
// as Box2D's motor joint; the hertz of the offset are those of the masses alone.
struct MotorRows : RowShape {
  static constexpr int kDrives = 2, kRotation = 0, kOffset = 1;
  struct Lanes {
    PlacedLanes placed;
    LaneFloats target[3], velocity[3];  // of the offset, in the axes of frame a
    LaneFloats target_rotation[4], angular_velocity[3];
    LaneFloats elapsed;
  };
  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointPlacement& at,
                      const LaneInts&, const LaneInts&, F, Lanes& lanes) {
    store_placed(at, lanes.placed);
    const OffsetTarget offset = load_offset_target(args, joint);
    const RotationTarget rotation = load_rotation_target(args, joint);
    store3(lanes.target, offset.offset);
    store3(lanes.velocity, offset.velocity);
    store4(lanes.target_rotation, rotation.rotation);
    store3(lanes.angular_velocity, rotation.velocity);
    store(lanes.elapsed, F(args.elapsed));
  }
  static void measure(const Lanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b,
                      RowsNow<MotorRows>& now) {
    const auto [anchors, frames] = move_placed(lanes.placed, delta_a, delta_b);
    const F elapsed = load(lanes.elapsed);
    const V3 velocity = load3(lanes.velocity), angular = load3(lanes.angular_velocity);
    now.arm_b = anchors.arm_b;
    measure_rotation_drive(frames, small_rotation(angular * elapsed) * load4(lanes.target_rotation), angular,
                           now.drive[kRotation]);
    measure_offset_drive(anchors, anchors.offset - rotate(frames.a, load3(lanes.target) + velocity * elapsed),
                         rotate(frames.a, velocity), now.drive[kOffset]);
  }
  static WideDrive asked_drive(const JointArgs& args, const std::int32_t* joint, int number,
                               const JointBodyLanes& bodies) {
    if (number == kRotation) return load_rotation_drive(args, joint);
    return load_drive(args.parameters->motor.hertz, joint,
                      bodies.mass_a.inverse_mass + bodies.mass_b.inverse_mass);
  }
  static void impulses(const F (&stored)[kJointImpulses], const RowsNow<MotorRows>&,
                       RowImpulses<MotorRows>& along) {
    for (int i = 0; i < 3; ++i) {
      along.drive3[kOffset][i] = stored[i];
      along.drive3[kRotation][i] = stored[4 + i];
    }
  }
};

// Of the rotation; the reference is the response itself. About locked axes nothing turns.
inline void place_turn_response(const S3& response, VectorDriveLanes& lanes) {
  const S3 yield = response * load(lanes.yield_rate);
  store6(lanes.yield, yield);
  store(lanes.response_trace, trace(response + yield));
  store6(lanes.inverse_response, invert_semidefinite(response + yield));
}

// Impulses: 0 to 2 of the force, 4 to 6 of the torque, in world axes.
struct Motor {
  using Rows = MotorRows;
  struct alignas(64) Block {
    LaneInts row_a, row_b;
    PlacedLanes first;
    LaneFloats target[3], velocity[3];  // of the offset, in the axes of frame a
    LaneFloats target_rotation[4], angular_velocity[3];
    LaneFloats arm_a[3], arm_b[3];  // now, both to anchor b: the force makes no couple
    LaneFloats turned_a[3], turned_b[3];
    VectorDriveLanes offset, rotation;
  };

  // Takes the present poses into the block.
  static void place(const Placed& now, F elapsed, const JointBodyLanes& bodies, Block& block) {
    const V3 velocity = load3(block.velocity), angular = load3(block.angular_velocity);
    const auto& [anchors, frames] = now;
    const V3 arm_a = anchors.arm_a + anchors.offset;
    store3(block.arm_a, arm_a);
    store3(block.arm_b, anchors.arm_b);
    const V3 target = rotate(frames.a, load3(block.target) + velocity * elapsed);
    store3(block.offset.error, anchors.offset - target);
    store3(block.offset.target_speed, rotate(frames.a, velocity));
    place_offset_response(anchor_response(bodies, arm_a, anchors.arm_b),
                          bodies.mass_a.inverse_mass + bodies.mass_b.inverse_mass, block.offset);
    const Q4 wanted = small_rotation(angular * elapsed) * load4(block.target_rotation);
    const Q4 ahead = conjugate(frames.a) * frames.b * conjugate(wanted);
    store3(block.rotation.error, rotate(frames.a, rotation_vector(ahead)));
    store3(block.rotation.target_speed, rotate(frames.a, angular));
    place_turn_response(turn_response(bodies), block.rotation);
  }

  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointBodyLanes& bodies,
                      const JointPlacement& at, Block& block) {
    const F zero(0.0f);
    const OffsetTarget offset_target = load_offset_target(args, joint);
    const RotationTarget rotation_target = load_rotation_target(args, joint);
    store3(block.target, offset_target.offset);
    store3(block.velocity, offset_target.velocity);
    store4(block.target_rotation, rotation_target.rotation);
    store3(block.angular_velocity, rotation_target.velocity);
    V3 force, torque;
    F pad;
    load_impulses(args, joint, 0, force.x, force.y, force.z, pad);
    load_impulses(args, joint, 1, torque.x, torque.y, torque.z, pad);
    prepare_drive(args, bodies, MotorRows::asked_drive(args, joint, MotorRows::kOffset, bodies), force,
                  block.offset);
    prepare_drive(args, bodies, MotorRows::asked_drive(args, joint, MotorRows::kRotation, bodies), torque,
                  block.rotation);
    place(store_placed(at, block.first), zero, bodies, block);
    store3(block.turned_a, {zero, zero, zero});
    store3(block.turned_b, {zero, zero, zero});
  }
  static void warm_start(const Block& block, JointBodyLanes& bodies) {
    push(bodies, load3(block.arm_a), load3(block.arm_b), load3(block.offset.impulse));
    twist(bodies, load3(block.rotation.impulse));
  }
  static void drive(Block& block, JointBodyLanes& bodies, F keep) {
    twist(bodies, solve_vector_drive(block.rotation, turning_speed(bodies), keep));
    const V3 arm_a = load3(block.arm_a), arm_b = load3(block.arm_b);
    push(bodies, arm_a, arm_b, solve_vector_drive(block.offset, anchor_velocity(bodies, arm_a, arm_b), keep));
  }
  static void solve(const JointArgs& args, Block& block, JointBodyLanes& bodies) {
    const F keep(args.impulse_keep);
    bodies.a.angular = bodies.a.angular - bodies.mass_a.inverse_inertia * (load3(block.turned_a) * keep);
    bodies.b.angular = bodies.b.angular + bodies.mass_b.inverse_inertia * (load3(block.turned_b) * keep);
    drive(block, bodies, keep);
  }
  static F relax(const JointArgs& args, Block& block, const WideDelta& delta_a, const WideDelta& delta_b,
                 JointBodyLanes& bodies) {
    const Placed now = move_placed(block.first, delta_a, delta_b);
    const V3 impulse = load3(block.offset.impulse);
    store3(block.turned_a, cross(now.anchors.arm_a + now.anchors.offset - load3(block.arm_a), impulse));
    store3(block.turned_b, cross(now.anchors.arm_b - load3(block.arm_b), impulse));
    place(now, F(args.elapsed), bodies, block);
    drive(block, bodies, F(1.0f));
    return F(0.0f);
  }
  static JointImpulse acting(const Block& block) {
    return {load3(block.offset.impulse), load3(block.rotation.impulse)};
  }
  static void store(const JointArgs& args, const std::int32_t* joint, int count, const Block& block) {
    const V3 none{F(0.0f), F(0.0f), F(0.0f)};
    V3 force = load3(block.offset.impulse), torque = load3(block.rotation.impulse);
    const M finite =
        is_finite(force) & is_finite(torque);  // non-finite ones would make their bodies so again
    force = select(finite, force, none);
    torque = select(finite, torque, none);
    store_impulses(args, joint, count, 0, force.x, force.y, force.z, F(0.0f));
    store_impulses(args, joint, count, 1, torque.x, torque.y, torque.z, F(0.0f));
  }
};

}  // namespace

template <>
JointTypeKernels make_joint_type_kernels<JointType::motor>() {
  const JointVariantKernels both = make_joint_kernels_of<Motor>();
  return {both, both};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
