// Joints as the solver reads them: rows of plain memory, the same for all kinds, that know nothing of lanes
// or instruction sets. What the entries mean for each kind stands below;
// core/constraints/joint_parameters.cpp fills and reads them.
#pragma once

#include <core/plain/rows.h>

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

// What a joint asks for.
//
//   kind             axis
//   ball             0 lower, upper: twist; 1 upper: cone. Rotation drive, see below
//   hinge, slider,   0
//   distance
//   weld             none
//   six_degree       0 to 2 offsets, 3 to 5 angles
//   wheel            0 suspension, 1 steering, 2 spin
//   universal        0 first, 1 second
//   planar           0 offset_y, 1 offset_z, 2 angle
//   gear             0 target: ratio
//   rack_and_pinion  0 target: radius
//   pulley           0 upper: length, lower: the same if rigid, else -infinity, target: ratio; 1 and 2 lower,
//                    upper, target: point_a and point_b
//   motor            rotation drive, see below; 4 drive of the offset, with lower, upper, target: its target;
//                    5 lower, upper, target: its velocity
//   mouse            0 hertz, damping_ratio, max_force (drive: spring); 1 lower, upper, target: the point
//
// Rotation drive: 2 hertz, damping_ratio, max_force, drive; 0 to 2 speed: the velocity; 3 lower, upper,
// target, speed: the target's x, y, z, w.
struct alignas(16) JointParameters {
  JointAxisRow axis[kJointAxes];
  float hertz, damping_ratio;                  // of what is held; hertz 0: as stiff as the step allows
  float angular_hertz, angular_damping_ratio;  // likewise of the rotation; both alike but for welds
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
  float force_peak_squared;   // N^2, the largest of all substeps; of joints that may break, else 0
  float torque_peak_squared;  // N^2 m^2, likewise
};

}  // namespace scree
