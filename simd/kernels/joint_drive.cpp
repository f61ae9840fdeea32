// Motors, which drive a pose, and mice, which drag a point; see simd/joint_kernels.h.
#include <simd/joint_frames.h>
#include <simd/joint_sweeps.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// A drive of three rows at once, whose impulse is bounded by its length. The spring is implicit with
// K + yield for its response: `yield`, zero for a motor, is what the spring itself gives way by, as the hertz
// say for the response of a reference. So springs are stable whatever the levers, and as stiff as one
// expects.
struct VectorDriveLanes {
  LaneFloats error[3];  // how far ahead of the target
  LaneFloats target_speed[3];
  LaneFloats yield[6], inverse_response[6];  // of K + yield
  LaneFloats bias_rate, yield_rate;          // yield_rate: times the reference's response
  LaneFloats max_impulse;                    // in a substep
  LaneFloats impulse[3];
};

struct DriveParameters {
  F hertz, damping_ratio, max_force;
  I drive;
};

inline void prepare_drive(const JointArgs& args, const JointBodies& bodies, const DriveParameters& given,
                          V3 impulse, VectorDriveLanes& lanes) {
  const F zero(0.0f), one(1.0f);
  const M spring = given.drive == I(static_cast<std::int32_t>(kDriveSpring));
  const M idle = given.drive == I(static_cast<std::int32_t>(kDriveNone));
  const Softness soft = soften(args, bodies, select(spring, given.hertz, one), given.damping_ratio);
  store(lanes.bias_rate, select(spring, soft.bias_rate, zero));
  store(lanes.yield_rate, select(spring, soft.impulse_scale / soft.mass_scale, zero));
  store(lanes.max_impulse, select(idle, zero, given.max_force * F(args.substep)));
  store3(lanes.impulse, select(idle, V3{zero, zero, zero}, impulse * F(args.warm_start_scale)));
}

// Returns the change of the impulse.
inline V3 solve_vector_drive(VectorDriveLanes& lanes, V3 speed, F keep) {
  const V3 old_impulse = load3(lanes.impulse) * keep;
  const V3 error = (speed - load3(lanes.target_speed)) + load3(lanes.error) * load(lanes.bias_rate) +
                   load6(lanes.yield) * old_impulse;
  const V3 free = old_impulse - load6(lanes.inverse_response) * error;
  const F limit = load(lanes.max_impulse), size = length(free);
  const M above = size > limit;
  const V3 impulse = free * select(above, limit / select(above, size, F(1.0f)), F(1.0f));
  store3(lanes.impulse, impulse);
  return impulse - old_impulse;
}

// Of the offset of anchors. The reference are the masses alone, wherever the anchors are.
inline void place_offset_response(S3 response, F inverse_mass, VectorDriveLanes& lanes) {
  const F zero(0.0f), yield = inverse_mass * load(lanes.yield_rate);
  store6(lanes.yield, {yield, zero, zero, yield, zero, yield});
  response.xx += yield;
  response.yy += yield;
  response.zz += yield;
  store6(lanes.inverse_response, invert(response));
}

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
    const M finite = is_finite(force) & is_finite(torque);  // broken ones would break their bodies again
    force = select(finite, force, none);
    torque = select(finite, torque, none);
    store_impulses(args, joint, count, 0, force.x, force.y, force.z, F(0.0f));
    store_impulses(args, joint, count, 1, torque.x, torque.y, torque.z, F(0.0f));
  }
};

// Impulses: 0 to 2 of the force, in world axes. Body a is the world, and its anchor is of no consequence.
struct Mouse {
  struct alignas(64) Block {
    LaneInts row_a, row_b;
    LaneFloats first_arm[3], first_error[3];  // when the step began
    LaneFloats arm[3];                        // now
    LaneFloats turned[3];
    VectorDriveLanes offset;
  };

  static void place(V3 arm, V3 error, const JointBodies& bodies, Block& block) {
    S3 response = lever_response(arm, bodies.mass_b.inverse_inertia);
    response.xx += bodies.mass_b.inverse_mass;
    response.yy += bodies.mass_b.inverse_mass;
    response.zz += bodies.mass_b.inverse_mass;
    store3(block.arm, arm);
    store3(block.offset.error, error);
    place_offset_response(response, bodies.mass_b.inverse_mass, block.offset);
  }
  static void pull(JointBodies& bodies, V3 arm, V3 impulse) {
    bodies.b.linear = bodies.b.linear + impulse * bodies.mass_b.inverse_mass;
    bodies.b.angular = bodies.b.angular + bodies.mass_b.inverse_inertia * cross(arm, impulse);
  }

  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointBodies& bodies,
                      const JointPlacement& at, Block& block) {
    const V3 none{F(0.0f), F(0.0f), F(0.0f)};
    const WideAxis given = load_axis(args, joint, 0), target = load_axis(args, joint, 1);
    V3 impulse, center;
    F pad;
    load_impulses(args, joint, 0, impulse.x, impulse.y, impulse.z, pad);
    load_rows(args.pose->position, 8, block.row_b, center.x, center.y, center.z, pad);
    const V3 error = (center - V3{target.lower, target.upper, target.target}) + at.arm_b;
    prepare_drive(args, bodies, {given.hertz, given.damping_ratio, given.max_force, given.drive}, impulse,
                  block.offset);
    store3(block.offset.target_speed, none);
    store3(block.first_arm, at.arm_b);
    store3(block.first_error, error);
    store3(block.turned, none);
    place(at.arm_b, error, bodies, block);
  }
  static void warm_start(const Block& block, JointBodies& bodies) {
    pull(bodies, load3(block.arm), load3(block.offset.impulse));
  }
  static void drag(Block& block, JointBodies& bodies, F keep) {
    const V3 arm = load3(block.arm);
    const V3 speed = bodies.b.linear + cross(bodies.b.angular, arm);
    pull(bodies, arm, solve_vector_drive(block.offset, speed, keep));
  }
  static void solve(const JointArgs& args, Block& block, JointBodies& bodies) {
    const F keep(args.impulse_keep);
    bodies.b.angular = bodies.b.angular + bodies.mass_b.inverse_inertia * (load3(block.turned) * keep);
    drag(block, bodies, keep);
  }
  static F relax(const JointArgs&, Block& block, const WideDelta&, const WideDelta& delta_b,
                 JointBodies& bodies) {
    const V3 first_arm = load3(block.first_arm), arm = rotate(delta_b.rotation, first_arm);
    store3(block.turned, cross(arm - load3(block.arm), load3(block.offset.impulse)));
    place(arm, load3(block.first_error) + delta_b.position + (arm - first_arm), bodies, block);
    drag(block, bodies, F(1.0f));
    return F(0.0f);
  }
  static JointImpulse acting(const Block& block) {
    const F zero(0.0f);
    return {load3(block.offset.impulse), {zero, zero, zero}};
  }
  static void store(const JointArgs& args, const std::int32_t* joint, int count, const Block& block) {
    const V3 force = finite_or_zero(load3(block.offset.impulse));
    store_impulses(args, joint, count, 0, force.x, force.y, force.z, F(0.0f));
  }
};

}  // namespace

void add_drive_kernels(JointKernels& kernels) {
  for (int rich = 0; rich < 2; ++rich) {
    kernels.variant[joint_variant(12, rich != 0)] = make_joint_kernels_of<Motor>();
    kernels.variant[joint_variant(13, rich != 0)] = make_joint_kernels_of<Mouse>();
  }
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
