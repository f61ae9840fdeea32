// Planar joints; see simd/constraints/joints/joint_rows.h.
#include <simd/constraints/joints/joint_rows.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// With d the way from anchor a to anchor b, lever r_a + d to anchor b, and the rotation as
// measure_alignment() has it:
//
//   held    C = x_a . d,   J = [-x_a, -(r_a + d) x x_a, x_a, r_b x x_a]; and the alignment of the x axes
//   axes    y_a . d and z_a . d as above; the angle of b about x_a, J = [0, -x_a, 0, x_a]
//
// as PhysX's D6 joint with two offsets and the twist free.
struct PlanarRows : FramedShape {
  static constexpr int kHeld = 3, kAxes = 3;
  static constexpr AxisUnit unit(int axis) { return axis == 2 ? AxisUnit::angle : AxisUnit::length; }
  static void measure(const Lanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b,
                      RowsNow<PlanarRows>& now) {
    const auto [anchors, frames] = move_placed(lanes, delta_a, delta_b);
    const M3 a = to_matrix(frames.a), b = to_matrix(frames.b);
    now.arm_b = anchors.arm_b;
    now.held[0] = offset_row(a.x, anchors.arm_a, anchors.arm_b, anchors.offset);
    now.error[0] = dot(a.x, anchors.offset);
    measure_alignment(a, b.x, 1, now);
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
