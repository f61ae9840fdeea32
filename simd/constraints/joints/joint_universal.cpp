// Universal joints; see simd/constraints/joints/joint_rows.h.
#include <simd/constraints/joints/joint_rows.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// With d the way from anchor a to anchor b:
//
//   held    C = d,   J = [-1, [r_a + d], 1, -[r_b]]; and x_a . y_b, see square_row()
//   axes    the angles about x_a and about y_b, J = [0, -axis, 0, axis]
//
// as ODE's universal joint.
struct UniversalRows : FramedShape {
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

}  // namespace

template <>
JointTypeKernels make_joint_type_kernels<JointType::universal>() {
  return {make_joint_kernels_of<RowJoint<UniversalRows, false>>(),
          make_joint_kernels_of<RowJoint<UniversalRows, true>>()};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
