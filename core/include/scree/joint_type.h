// The kinds of joints, a line each: from it come JointType, the alternatives of Joint, their names, and the
// table of their kernels.
#pragma once

#include <cstdint>

/// Calls X(kind, Struct) for each kind of joint, in the order of JointType.
#define SCREE_FOR_EACH_JOINT_TYPE(X)     \
  X(ball, BallJoint)                     \
  X(hinge, HingeJoint)                   \
  X(slider, SliderJoint)                 \
  X(distance, DistanceJoint)             \
  X(weld, WeldJoint)                     \
  X(six_degree, SixDegreeJoint)          \
  X(wheel, WheelJoint)                   \
  X(universal, UniversalJoint)           \
  X(planar, PlanarJoint)                 \
  X(gear, GearJoint)                     \
  X(rack_and_pinion, RackAndPinionJoint) \
  X(pulley, PulleyJoint)                 \
  X(motor, MotorJoint)                   \
  X(mouse, MouseJoint)                   \
  X(user, UserJoint)

namespace scree {

#define SCREE_JOINT_TYPE(kind, Struct) kind,
/// The kind of a joint: ball is that of BallJoint, hinge that of HingeJoint, and so on, as
/// SCREE_FOR_EACH_JOINT_TYPE lists them. It is the index of the alternative in Joint.
enum class JointType : std::uint8_t { SCREE_FOR_EACH_JOINT_TYPE(SCREE_JOINT_TYPE) };
#undef SCREE_JOINT_TYPE

#define SCREE_COUNT_JOINT_TYPE(kind, Struct) +1
/// The number of kinds.
inline constexpr int kJointTypeCount = 0 SCREE_FOR_EACH_JOINT_TYPE(SCREE_COUNT_JOINT_TYPE);
#undef SCREE_COUNT_JOINT_TYPE

}  // namespace scree
