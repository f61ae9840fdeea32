// Wheel joints; see simd/constraints/joints/joint_rows.h.
#include <simd/constraints/joints/joint_rows.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// With d the way from anchor a to anchor b, which is also where forces act on a:
//
//   held    C = y_a . d and z_a . d,   J = [-y_a, -(r_a + d) x y_a, y_a, r_b x y_a]; and x_a . z_b, see
//   square_row() axes    x_a . d as above, the suspension; the angle about x_a, the steering; the speed about
//   z_b, the spin
//
// as ODE's hinge-2 joint, with the suspension of Box2D's wheel joint.
struct WheelRows : FramedShape {
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
  static WideAxis asked(const JointArgs& args, const std::int32_t* joint, int axis, const Row& row,
                        const JointBodyLanes& bodies) {
    WideAxis given = load_axis(args, joint, axis);
    if (axis != 0) return given;
    const Row push = row_push(row, bodies);
    const F of_a = dot(row.linear_a, push.linear_a) + dot(row.angular_a, push.angular_a);
    const F ratio = dot(row, push) * invert_positive(of_a);
    const F scale = sqrt(select(ratio > F(1.0f), ratio, F(1.0f)));
    given.hertz = given.hertz * scale;
    given.damping_ratio = given.damping_ratio * scale;
    return given;
  }
};

}  // namespace

template <>
JointTypeKernels make_joint_type_kernels<JointType::wheel>() {
  return {make_joint_kernels_of<RowJoint<WheelRows, false>>(),
          make_joint_kernels_of<RowJoint<WheelRows, true>>()};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
