// Motors, which drive a pose; see simd/constraints/joints/joint_kernels.h.
#include <simd/constraints/joints/joint_vector_drive.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// Of the rotation; the reference is the response itself. About locked axes nothing turns.
inline void place_turn_response(const S3& response, VectorDriveLanes& lanes) {
  const S3 yield = response * load(lanes.yield_rate);
  store6(lanes.yield, yield);
  store6(lanes.inverse_response, invert_semidefinite(response + yield));
}

// The rotation by the rotation vector v, by Cayley's formula, as bodies turn.
inline Q4 small_rotation(V3 v) {
  const F half(0.5f);
  return normalize({v.x * half, v.y * half, v.z * half, F(1.0f)});
}

// Impulses: 0 to 2 of the force, 4 to 6 of the torque, in world axes.
struct Motor {
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
  static void place(const Placed& now, F elapsed, const JointBodies& bodies, Block& block) {
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

  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointBodies& bodies,
                      const JointPlacement& at, Block& block) {
    const F zero(0.0f);
    const WideAxis x = load_axis(args, joint, 0), y = load_axis(args, joint, 1);
    const WideAxis rotation = load_axis(args, joint, 2), target_rotation = load_axis(args, joint, 3);
    const WideAxis offset = load_axis(args, joint, 4), velocity = load_axis(args, joint, 5);
    store3(block.target, {offset.lower, offset.upper, offset.target});
    store3(block.velocity, {velocity.lower, velocity.upper, velocity.target});
    store4(block.target_rotation,
           {target_rotation.lower, target_rotation.upper, target_rotation.target, target_rotation.speed});
    store3(block.angular_velocity, {x.speed, y.speed, rotation.speed});
    V3 force, torque;
    F pad;
    load_impulses(args, joint, 0, force.x, force.y, force.z, pad);
    load_impulses(args, joint, 1, torque.x, torque.y, torque.z, pad);
    prepare_drive(args, bodies, {offset.hertz, offset.damping_ratio, offset.max_force, offset.drive}, force,
                  block.offset);
    prepare_drive(args, bodies, {rotation.hertz, rotation.damping_ratio, rotation.max_force, rotation.drive},
                  torque, block.rotation);
    place(store_placed(at, block.first), zero, bodies, block);
    store3(block.turned_a, {zero, zero, zero});
    store3(block.turned_b, {zero, zero, zero});
  }
  static void warm_start(const Block& block, JointBodies& bodies) {
    push(bodies, load3(block.arm_a), load3(block.arm_b), load3(block.offset.impulse));
    twist(bodies, load3(block.rotation.impulse));
  }
  static void drive(Block& block, JointBodies& bodies, F keep) {
    twist(bodies, solve_vector_drive(block.rotation, turning_speed(bodies), keep));
    const V3 arm_a = load3(block.arm_a), arm_b = load3(block.arm_b);
    push(bodies, arm_a, arm_b, solve_vector_drive(block.offset, anchor_velocity(bodies, arm_a, arm_b), keep));
  }
  static void solve(const JointArgs& args, Block& block, JointBodies& bodies) {
    const F keep(args.impulse_keep);
    bodies.a.angular = bodies.a.angular - bodies.mass_a.inverse_inertia * (load3(block.turned_a) * keep);
    bodies.b.angular = bodies.b.angular + bodies.mass_b.inverse_inertia * (load3(block.turned_b) * keep);
    drive(block, bodies, keep);
  }
  static F relax(const JointArgs& args, Block& block, const WideDelta& delta_a, const WideDelta& delta_b,
                 JointBodies& bodies) {
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
