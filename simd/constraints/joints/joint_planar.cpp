// Planar joints; see simd/constraints/joints/joint_rows.h.
#include <simd/constraints/joints/joint_framed_rows.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

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

template <>
JointTypeKernels make_joint_type_kernels<JointType::planar>() {
  return {make_joint_kernels_of<RowJoint<PlanarRows, false>>(),
          make_joint_kernels_of<RowJoint<PlanarRows, true>>()};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
