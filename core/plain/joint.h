// Joints as the solver reads them: rows of plain memory, of the same size for all kinds, that know nothing of
// lanes or instruction sets. core/constraints/joints/joint_<kind>.cpp fills and reads those of a kind.
#pragma once

#include <core/plain/rows.h>
#include <scree/joint_type.h>

#include <cstdint>

namespace scree {

inline constexpr int kJointAxes = 6;
inline constexpr int kJointImpulses = 16;

enum JointDrive : std::uint32_t { kDriveNone, kDriveMotor, kDriveSpring };  // scree::Drive

// Where a joint's frames lie in its bodies: from the center of mass, in the body's axes.
struct alignas(64) JointFrames {
  float anchor_a[3];
  std::int32_t row_a;
  float anchor_b[3];
  std::int32_t row_b;
  float rotation_a[4];  // of the frame in the body's axes, x y z w
  float rotation_b[4];
};

// scree::JointAxis. In groups of 16 bytes, as kernels load them.
struct alignas(16) JointAxisRow {
  float lower, upper;
  float target, speed;
  float hertz, damping_ratio;
  float max_force;
  std::uint32_t drive;  // JointDrive
};

// What the kinds of joints ask for, a struct each, of which scree/joint.h says what the fields mean. All are
// as long as kJointAxes rows of axes. Fields stand in groups of 16 bytes, where kernels load them together; a
// row of one drive, with its hertz, damping_ratio, largest force and JointDrive, is one. The gaps hold a free
// axis's numbers.
struct alignas(16) BallParameters {
  float twist_lower, twist_upper, gap_0, velocity_x;  // the velocity is that of the drive
  float gap_1[5], cone_limit, gap_2, velocity_y;
  float gap_3[7], velocity_z;
  float hertz, damping_ratio, max_torque;
  std::uint32_t drive;
  float target[4];  // x y z w
  float gap_4[20];
};
struct HingeParameters {
  JointAxisRow angle, gap[5];
};
struct SliderParameters {
  JointAxisRow offset, gap[5];
};
struct DistanceParameters {
  JointAxisRow length, gap[5];
};
struct WeldParameters {
  JointAxisRow gap[6];  // what it asks for is JointParameters' own
};
struct SixDegreeParameters {
  JointAxisRow offset[3], angle[3];
};
struct WheelParameters {
  JointAxisRow suspension, steering, spin, gap[3];
};
struct UniversalParameters {
  JointAxisRow first, second, gap[4];
};
struct PlanarParameters {
  JointAxisRow offset_y, offset_z, angle, gap[3];
};
struct alignas(16) GearParameters {
  float gap_0[2], ratio, gap_1[45];
};
struct alignas(16) RackAndPinionParameters {
  float gap_0[2], radius, gap_1[45];
};
struct alignas(16) PulleyParameters {
  float least_length, length, ratio, gap_0[5];  // the least is the length itself if rigid, else -infinity
  float point_a[3], gap_1[5];
  float point_b[3], gap_2[29];
};
struct alignas(16) MotorParameters {
  float gap_0[3], angular_velocity_x;
  float gap_1[7], angular_velocity_y;
  float gap_2[7], angular_velocity_z;
  float angular_hertz, angular_damping_ratio, max_torque;
  std::uint32_t rotation_drive;
  float target_rotation[4], gap_3[4];  // x y z w
  float target[3], gap_4;
  float hertz, damping_ratio, max_force;
  std::uint32_t drive;
  float velocity[3], gap_5[5];
};
struct alignas(16) MouseParameters {
  float gap_0[4], hertz, damping_ratio, max_force;
  std::uint32_t drive;  // a spring
  float target[3], gap_1[37];
};

enum UserRowKind : std::uint32_t {
  kUserNone,
  kUserHeld,
  kUserLimit,
  kUserMotor,
  kUserSpring
};  // scree::RowKind
// A user joint of more rows, or of others than held ones, is a rich one.
inline constexpr int kPlainUserRows = 3;

// Kinds of rows, whose numbers stand in WorldData::user_joints.
struct alignas(16) UserParameters {
  std::uint32_t row[6];  // UserRowKind
  float gap[42];
};

struct alignas(16) JointParameters {
  union {
    JointAxisRow axis[kJointAxes];  // of kinds that have nothing but axes, in the order of their structs
    BallParameters ball;
    HingeParameters hinge;
    SliderParameters slider;
    DistanceParameters distance;
    WeldParameters weld;
    SixDegreeParameters six_degree;
    WheelParameters wheel;
    UniversalParameters universal;
    PlanarParameters planar;
    GearParameters gear;
    RackAndPinionParameters rack_and_pinion;
    PulleyParameters pulley;
    MotorParameters motor;
    MouseParameters mouse;
    UserParameters user;
  };
  float hertz, damping_ratio;                  // of what is held; hertz 0: as stiff as the step allows
  float angular_hertz, angular_damping_ratio;  // of the held rotation; both alike in all kinds but welds
};
#define SCREE_JOINT_TYPE(kind, Struct)                                          \
  static_assert(sizeof(JointParameters::kind) == sizeof(JointParameters::axis), \
                "the parameters of a " #kind " are not as long as those of others");
SCREE_FOR_EACH_JOINT_TYPE(SCREE_JOINT_TYPE)
#undef SCREE_JOINT_TYPE

// The numbers of a user joint, see scree/user_joint.h: the layout of arrays of RowJacobian, RowTarget and
// RowBounds. In groups of 16 bytes, as kernels load them.
inline constexpr int kUserRows = 6;
struct alignas(16) UserJacobians {
  float row[kUserRows][12];  // linear_a, angular_a, linear_b, angular_b
};
struct alignas(16) UserTargets {
  float row[kUserRows][4];  // error, speed, hertz, damping_ratio
};
struct alignas(16) UserBounds {
  float row[kUserRows][2];  // lower, upper
};

// Whether a user joint acts.
enum UserState : std::uint32_t {
  kUserActs,
  kUserFreezes,  // frozen since the last step; events have not been told
  kUserFrozen,
};

// What a joint has accumulated, N s and N m s, in an order that only its kernel knows; a coordinate that it
// must remember across steps, such as a gear's, may stand here, too. All zero in a new joint.
struct alignas(64) JointImpulses {
  float impulse[kJointImpulses];
};

// On body b, of the last substep.
struct alignas(32) JointReactionRow {
  float force[3];             // N, at anchor b
  float torque[3];            // N m, about anchor b
  float force_peak_squared;   // N^2, the largest of all substeps; where ConstraintChunk::peaks, else 0
  float torque_peak_squared;  // N^2 m^2, as above
};

}  // namespace scree
