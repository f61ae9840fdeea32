// Wheels, universal and planar joints; see simd/constraints/joints/joint_rows.h.
#include <simd/constraints/joints/joint_frames.h>
#include <simd/constraints/joints/joint_rows.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// What kinds with frames in both bodies have in common.
struct FramedRows {
  using Lanes = PlacedLanes;
  static constexpr bool kRemembers = false;
  static void prepare(const JointArgs&, const std::int32_t*, const JointPlacement& at, const LaneInts&,
                      const LaneInts&, F, Lanes& lanes) {
    store_placed(at, lanes);
  }
  static void tune(const JointArgs&, const std::int32_t*, int, const Row&, const JointBodies&, LaneAxis&) {}
};

// Unit axes that are to be square: the row about what both are square to, and the sine by which they are not.
struct SquareRow {
  Row row;
  F error;
};
inline SquareRow square_row(V3 axis_a, V3 axis_b) {
  // Parallel ones are as wrong as can be: any way out will do.
  return {turn_row(-normal_of(axis_a, axis_b, 1e-3f).direction), dot(axis_a, axis_b)};
}

struct WheelRows : FramedRows {
  static constexpr int kHeld = 3, kAxes = 3;
  static constexpr AxisUnit unit(int axis) {
    return axis == 0 ? AxisUnit::length : (axis == 1 ? AxisUnit::angle : AxisUnit::speed);
  }
  static void measure(const Lanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b,
                      RowsNow<WheelRows>& now) {
    const auto [anchors, frames] = move_placed(lanes, delta_a, delta_b);
    const M3 a = to_matrix(frames.a);
    const V3 spin = to_matrix(frames.b).z;
    now.arm_b = anchors.arm_b;
    now.held[0] = offset_row(a.y, anchors.arm_a, anchors.arm_b, anchors.offset);
    now.error[0] = dot(a.y, anchors.offset);
    now.held[1] = offset_row(a.z, anchors.arm_a, anchors.arm_b, anchors.offset);
    now.error[1] = dot(a.z, anchors.offset);
    const SquareRow square = square_row(a.x, spin);
    now.held[2] = square.row;
    now.error[2] = square.error;
    now.axis[0] = offset_row(a.x, anchors.arm_a, anchors.arm_b, anchors.offset);
    now.coordinate[0] = dot(a.x, anchors.offset);
    now.axis[1] = turn_row(a.x);
    now.coordinate[1] = atan2(-dot(spin, a.y), dot(spin, a.z));
    now.axis[2] = turn_row(spin);
    now.coordinate[2] = F(0.0f);
  }
  // The hertz of a suspension are those of a chassis that bounces on wheels that stand: of the mass of body a
  // at the wheel. By that of both bodies, as elsewhere, a light wheel would make a weak spring.
  static void tune(const JointArgs& args, const std::int32_t* joint, int number, const Row& row,
                   const JointBodies& bodies, LaneAxis& lanes) {
    if (number != 0) return;
    const Row push = row_push(row, bodies);
    const F of_a = dot(row.linear_a, push.linear_a) + dot(row.angular_a, push.angular_a);
    const F ratio = dot(row, push) * invert_positive(of_a);
    const F scale = sqrt(select(ratio > F(1.0f), ratio, F(1.0f)));
    const WideAxis given = load_axis(args, joint, number);
    const M spring = given.drive == I(static_cast<std::int32_t>(kDriveSpring));
    const Softness soft =
        soften(args, bodies, select(spring, given.hertz * scale, F(1.0f)), given.damping_ratio * scale);
    const Softness other = load_softness(lanes.drive);
    store_softness(lanes.drive, {select(spring, soft.bias_rate, other.bias_rate),
                                 select(spring, soft.mass_scale, other.mass_scale),
                                 select(spring, soft.impulse_scale, other.impulse_scale)});
  }
};

struct UniversalRows : FramedRows {
  static constexpr int kHeld = 4, kAxes = 2;
  static constexpr AxisUnit unit(int) { return AxisUnit::angle; }
  static void measure(const Lanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b,
                      RowsNow<UniversalRows>& now) {
    const auto [anchors, frames] = move_placed(lanes, delta_a, delta_b);
    const M3 a = to_matrix(frames.a), b = to_matrix(frames.b);
    const F zero(0.0f), one(1.0f);
    now.arm_b = anchors.arm_b;
    const V3 axes[3] = {{one, zero, zero}, {zero, one, zero}, {zero, zero, one}};
    for (int i = 0; i < 3; ++i)
      now.held[i] = offset_row(axes[i], anchors.arm_a, anchors.arm_b, anchors.offset);
    now.error[0] = anchors.offset.x;
    now.error[1] = anchors.offset.y;
    now.error[2] = anchors.offset.z;
    const SquareRow square = square_row(a.x, b.y);
    now.held[3] = square.row;
    now.error[3] = square.error;
    now.axis[0] = turn_row(a.x);
    now.coordinate[0] = atan2(dot(b.y, a.z), dot(b.y, a.y));
    now.axis[1] = turn_row(b.y);
    now.coordinate[1] = atan2(dot(b.z, a.x), dot(b.x, a.x));
  }
};

struct PlanarRows : FramedRows {
  static constexpr int kHeld = 3, kAxes = 3;
  static constexpr AxisUnit unit(int axis) { return axis == 2 ? AxisUnit::angle : AxisUnit::length; }
  static void measure(const Lanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b,
                      RowsNow<PlanarRows>& now) {
    const auto [anchors, frames] = move_placed(lanes, delta_a, delta_b);
    const M3 a = to_matrix(frames.a), b = to_matrix(frames.b);
    now.arm_b = anchors.arm_b;
    now.held[0] = offset_row(a.x, anchors.arm_a, anchors.arm_b, anchors.offset);
    now.error[0] = dot(a.x, anchors.offset);
    const Swing away = swing(a.x, b.x);
    now.held[1] = turn_row(a.y);
    now.error[1] = dot(away.axis, a.y) * away.angle;
    now.held[2] = turn_row(a.z);
    now.error[2] = dot(away.axis, a.z) * away.angle;
    now.axis[0] = offset_row(a.y, anchors.arm_a, anchors.arm_b, anchors.offset);
    now.coordinate[0] = dot(a.y, anchors.offset);
    now.axis[1] = offset_row(a.z, anchors.arm_a, anchors.arm_b, anchors.offset);
    now.coordinate[1] = dot(a.z, anchors.offset);
    now.axis[2] = turn_row(a.x);
    now.coordinate[2] = atan2(dot(b.y, a.z), dot(b.y, a.y));
  }
};

}  // namespace

void add_transmission_kernels(JointKernels& kernels);
void add_drive_kernels(JointKernels& kernels);

void add_rows_kernels(JointKernels& kernels) {
  kernels.variant[joint_variant(6, false)] = make_joint_kernels_of<RowJoint<WheelRows, false>>();
  kernels.variant[joint_variant(6, true)] = make_joint_kernels_of<RowJoint<WheelRows, true>>();
  kernels.variant[joint_variant(7, false)] = make_joint_kernels_of<RowJoint<UniversalRows, false>>();
  kernels.variant[joint_variant(7, true)] = make_joint_kernels_of<RowJoint<UniversalRows, true>>();
  kernels.variant[joint_variant(8, false)] = make_joint_kernels_of<RowJoint<PlanarRows, false>>();
  kernels.variant[joint_variant(8, true)] = make_joint_kernels_of<RowJoint<PlanarRows, true>>();
  add_transmission_kernels(kernels);
  add_drive_kernels(kernels);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
