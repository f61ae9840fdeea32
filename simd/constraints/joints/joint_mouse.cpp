// Mice, which drag a point; see simd/constraints/joints/joint_kernels.h.
#include <simd/constraints/joints/joint_vector_drive.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// From the target, a point of the world, to the center of mass of body b.
inline V3 center_from_target(const JointArgs& args, const std::int32_t* joint, const LaneInts& row_b) {
  V3 center;
  F pad;
  load_rows(args.pose->position, 8, row_b, center.x, center.y, center.z, pad);
  return center - load_vector(args.parameters->mouse.target, joint);
}

// C = x_b + r_b - target,   J = [0, 0, 1, -[r_b]] with [r] w = r x w; as Box2D's mouse joint, with the hertz
// of the mass alone.
struct MouseRows : RowShape {
  static constexpr int kDrives = 1;
  struct Lanes {
    LaneFloats first_arm[3], first_error[3];  // when the step began
  };
  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointPlacement& at,
                      const LaneInts&, const LaneInts& row_b, F, Lanes& lanes) {
    store3(lanes.first_arm, at.arm_b);
    store3(lanes.first_error, center_from_target(args, joint, row_b) + at.arm_b);
  }
  static void measure(const Lanes& lanes, const WideDelta&, const WideDelta& delta_b,
                      RowsNow<MouseRows>& now) {
    const V3 first_arm = load3(lanes.first_arm), arm = rotate(delta_b.rotation, first_arm);
    const V3 ahead = load3(lanes.first_error) + delta_b.position + (arm - first_arm);
    const F error[3] = {ahead.x, ahead.y, ahead.z};
    now.arm_b = arm;
    for (int i = 0; i < 3; ++i) {
      Row& row = now.drive[0].row[i];
      row = zero_row();
      row.linear_b = world_axis(i);
      row.angular_b = cross(arm, world_axis(i));
      now.drive[0].error[i] = error[i];
      now.drive[0].target_speed[i] = F(0.0f);
    }
  }
  static WideDrive asked_drive(const JointArgs& args, const std::int32_t* joint, int,
                               const JointBodyLanes& bodies) {
    return load_drive(args.parameters->mouse.hertz, joint, bodies.mass_b.inverse_mass);
  }
  static void impulses(const F (&stored)[kJointImpulses], const RowsNow<MouseRows>&,
                       RowImpulses<MouseRows>& along) {
    for (int i = 0; i < 3; ++i) along.drive3[0][i] = stored[i];
  }
};

// Impulses: 0 to 2 of the force, in world axes. Body a is the world, and its anchor is of no consequence.
struct Mouse {
  using Rows = MouseRows;
  struct alignas(64) Block {
    LaneInts row_a, row_b;
    LaneFloats first_arm[3], first_error[3];  // when the step began
    LaneFloats arm[3];                        // now
    LaneFloats turned[3];
    VectorDriveLanes offset;
  };

  static void place(V3 arm, V3 error, const JointBodyLanes& bodies, Block& block) {
    S3 response = lever_response(arm, bodies.mass_b.inverse_inertia);
    response.xx += bodies.mass_b.inverse_mass;
    response.yy += bodies.mass_b.inverse_mass;
    response.zz += bodies.mass_b.inverse_mass;
    store3(block.arm, arm);
    store3(block.offset.error, error);
    place_offset_response(response, bodies.mass_b.inverse_mass, block.offset);
  }
  static void pull(JointBodyLanes& bodies, V3 arm, V3 impulse) {
    bodies.b.linear = bodies.b.linear + impulse * bodies.mass_b.inverse_mass;
    bodies.b.angular = bodies.b.angular + bodies.mass_b.inverse_inertia * cross(arm, impulse);
  }

  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointBodyLanes& bodies,
                      const JointPlacement& at, Block& block) {
    const V3 none{F(0.0f), F(0.0f), F(0.0f)};
    V3 impulse;
    F pad;
    load_impulses(args, joint, 0, impulse.x, impulse.y, impulse.z, pad);
    const V3 error = center_from_target(args, joint, block.row_b) + at.arm_b;
    prepare_drive(args, bodies, MouseRows::asked_drive(args, joint, 0, bodies), impulse, block.offset);
    store3(block.offset.target_speed, none);
    store3(block.first_arm, at.arm_b);
    store3(block.first_error, error);
    store3(block.turned, none);
    place(at.arm_b, error, bodies, block);
  }
  static void warm_start(const Block& block, JointBodyLanes& bodies) {
    pull(bodies, load3(block.arm), load3(block.offset.impulse));
  }
  static void drag(Block& block, JointBodyLanes& bodies, F keep) {
    const V3 arm = load3(block.arm);
    const V3 speed = bodies.b.linear + cross(bodies.b.angular, arm);
    pull(bodies, arm, solve_vector_drive(block.offset, speed, keep));
  }
  static void solve(const JointArgs& args, Block& block, JointBodyLanes& bodies) {
    const F keep(args.impulse_keep);
    bodies.b.angular = bodies.b.angular + bodies.mass_b.inverse_inertia * (load3(block.turned) * keep);
    drag(block, bodies, keep);
  }
  static F relax(const JointArgs&, Block& block, const WideDelta&, const WideDelta& delta_b,
                 JointBodyLanes& bodies) {
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

template <>
JointTypeKernels make_joint_type_kernels<JointType::mouse>() {
  const JointVariantKernels both = make_joint_kernels_of<Mouse>();
  return {both, both};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
