// The contract of joints: a kind of joint measures rows, a solver decides. Private to the joint kernels.
//
// What the rows of a kind are it says in one place, by a struct in joint_<kind>.cpp that is derived from
// RowShape and has, all of it static,
//
//   kHeld, kAxes, kDrives   how many rows are held, how many axes may have a limit and a drive, and how many
//                           drives of three rows there are, whose force is bounded by its length
//   unit(axis)              what the axis's coordinate is
//   Lanes                   what it needs to measure, by lane
//   prepare(args, joint, placement, row_a, row_b, remembered, lanes)
//   measure(lanes, delta_a, delta_b, now)   rows, errors and coordinates after that motion, exactly
//
// and, where they differ from RowShape's, asked(), asked_drive(), impulses() and the flags below. `measure`
// is what a solver of any kind may build on: RowJoint of joint_rows.h makes kernels of it; state_rows()
// writes it as ConstraintRows for others; and kernels that are written by hand for a kind are held to it by
// tests/simd/constraints/joints/joint_statement_test.cpp.
#pragma once

#include <simd/constraints/joints/joint_frames.h>
#include <simd/constraints/row_statement.h>

#include <cstddef>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

inline F row_speed(const Row& row, const JointBodyLanes& bodies) {
  return dot(row, {bodies.a.linear, bodies.a.angular, bodies.b.linear, bodies.b.angular});
}
// M^-1 times the row: the velocities that a unit impulse along it makes.
inline Row row_push(const Row& row, const JointBodyLanes& bodies) {
  return {row.linear_a * bodies.mass_a.inverse_mass, bodies.mass_a.inverse_inertia * row.angular_a,
          row.linear_b * bodies.mass_b.inverse_mass, bodies.mass_b.inverse_inertia * row.angular_b};
}
inline void push_row(JointBodyLanes& bodies, const Row& row, F impulse) {
  const Row change = row_push(row, bodies) * impulse;
  bodies.a.linear = bodies.a.linear + change.linear_a;
  bodies.a.angular = bodies.a.angular + change.angular_a;
  bodies.b.linear = bodies.b.linear + change.linear_b;
  bodies.b.angular = bodies.b.angular + change.angular_b;
}

// What the coordinate of an axis is: m; rad in (-pi, pi], on a circle; rad in [0, pi], of two directions; or
// none, as only the speed counts.
enum class AxisUnit { length, angle, opening, speed };

// Three rows that one drive moves, with a force whose length is bounded.
struct DriveNow {
  Row row[3];
  F error[3];         // how far ahead of the target
  F target_speed[3];  // of the rows
};

// Where rows, errors and coordinates of a joint are now.
template <class Shape>
struct RowsNow {
  Row held[Shape::kHeld > 0 ? Shape::kHeld : 1];
  F error[Shape::kHeld > 0 ? Shape::kHeld : 1];
  Row axis[Shape::kAxes > 0 ? Shape::kAxes : 1];
  F coordinate[Shape::kAxes > 0 ? Shape::kAxes : 1];
  DriveNow drive[Shape::kDrives > 0 ? Shape::kDrives : 1];
  V3 arm_b;      // from b's center of mass to its anchor
  M turns_over;  // of kinds with kTurnsOver: the axes point the other way since they were last measured
};

// What a drive of three rows asks for.
struct WideDrive {
  F hertz, damping_ratio, max_force;
  I drive;
  F reference_response;  // see ConstraintRow
};

// A joint's accumulated impulses along the rows of RowsNow.
template <class Shape>
struct RowImpulses {
  F held[Shape::kHeld > 0 ? Shape::kHeld : 1];
  F limit[Shape::kAxes > 0 ? Shape::kAxes : 1];
  F drive[Shape::kAxes > 0 ? Shape::kAxes : 1];
  F drive3[Shape::kDrives > 0 ? Shape::kDrives : 1][3];
};

// JointImpulses of joints made of rows: 0 to 3 of the held rows, then the limit and the drive of each axis,
// last the memory.
constexpr int kFirstAxisImpulse = 4;
constexpr int kMemory = kRememberedCoordinate;

// What kinds have unless they say otherwise.
struct RowShape {
  static constexpr int kHeld = 0, kAxes = 0, kDrives = 0;
  // Whether the error of the first held row is the sum of all motion since the joint was made, which impulse
  // number kMemory keeps across steps.
  static constexpr bool kRemembers = false;
  // Whether what is held is solved first, and the rest with it held: see kRowKeepsHeld. Else it is solved
  // last.
  static constexpr bool kKeepsHeld = false;
  // Whether an axis whose ends are equal is held like the others that are.
  static constexpr bool kHoldsEqualEnds = false;
  // Whether an axis may have a drive of its own.
  static constexpr bool kAxisDrives = true;
  // Whether the axes can turn over from one substep to the next: then their impulses, which would push where
  // they pulled, are dropped.
  static constexpr bool kTurnsOver = false;
  // Whether it holds no rotation, see joint_shares.h.
  static constexpr bool kLeavesTurns = false;
  // Whether a held row has JointParameters::angular_hertz.
  static constexpr bool is_angular(int) { return false; }
  static constexpr AxisUnit unit(int) { return AxisUnit::length; }

  // What an axis asks for: its entry in JointParameters, with what only the joint's own rows can tell.
  static WideAxis asked(const JointArgs& args, const std::int32_t* joint, int axis, const Row&,
                        const JointBodyLanes&) {
    return load_axis(args, joint, axis);
  }
  template <class Shape>
  static void impulses(const F (&stored)[kJointImpulses], const RowsNow<Shape>&, RowImpulses<Shape>& along) {
    for (int i = 0; i < Shape::kHeld; ++i) along.held[i] = stored[i];
    for (int i = 0; i < Shape::kAxes; ++i) {
      along.limit[i] = stored[kFirstAxisImpulse + 2 * i];
      along.drive[i] = stored[kFirstAxisImpulse + 2 * i + 1];
    }
  }
};

// Of a kind that is measured from the frames of both bodies alone.
struct FramedShape : RowShape {
  using Lanes = PlacedLanes;
  static void prepare(const JointArgs&, const std::int32_t*, const JointPlacement& at, const LaneInts&,
                      const LaneInts&, F, Lanes& lanes) {
    store_placed(at, lanes);
  }
};

// Anchors that are one point, measured along the axes of the world:
//
//   C = (x_b + r_b) - (x_a + r_a),   J = [-1, [r_a], 1, -[r_b]]   with [r] w = r x w
//
// as Jolt's PointConstraintPart. Rows `first` to `first` + 2.
template <class Shape>
inline void measure_point(const Anchors& anchors, int first, RowsNow<Shape>& now) {
  const F error[3] = {anchors.offset.x, anchors.offset.y, anchors.offset.z};
  for (int i = 0; i < 3; ++i) {
    now.held[first + i] = point_row(world_axis(i), anchors.arm_a, anchors.arm_b);
    now.error[first + i] = error[i];
  }
}
template <class Shape>
inline void point_impulses(const F (&stored)[kJointImpulses], RowImpulses<Shape>& along) {
  for (int i = 0; i < 3; ++i) along.held[i] = stored[i];
}

// A rotation that is held, measured along the axes of the world: C = the rotation vector that takes frame a
// to frame b, J = [0, -1, 0, 1], which is its rate to first order of C; as Jolt's
// RotationEulerConstraintPart.
template <class Shape>
inline void measure_rotation(const Frames& frames, int first, RowsNow<Shape>& now) {
  const V3 ahead = rotation_error(frames);
  const F error[3] = {ahead.x, ahead.y, ahead.z};
  for (int i = 0; i < 3; ++i) {
    now.held[first + i] = turn_row(world_axis(i));
    now.error[first + i] = error[i];
  }
}

// The x axis of frame b that is to lie along that of frame a: with the vector s of the shortest turn from the
// one to the other, C = s . y_a and s . z_a, J = [0, -y_a, 0, y_a] and the same of z_a; as Jolt's
// HingeRotationConstraintPart, which has the sines of s.
template <class Shape>
inline void measure_alignment(const M3& a, V3 x_b, int first, RowsNow<Shape>& now) {
  const Swing away = swing(a.x, x_b);
  now.held[first] = turn_row(a.y);
  now.error[first] = dot(away.axis, a.y) * away.angle;
  now.held[first + 1] = turn_row(a.z);
  now.error[first + 1] = dot(away.axis, a.z) * away.angle;
}

// A drive whose hertz stand at `first`, with its damping ratio, largest force and JointDrive behind them.
inline WideDrive load_drive(const float& first, const std::int32_t* joint, F reference_response) {
  WideDrive d;
  F drive;
  load_four(first, joint, d.hertz, d.damping_ratio, d.max_force, drive);
  d.drive = as_int(drive);
  d.reference_response = reference_response;
  return d;
}

// scree::RotationDrive, which stands in the parameters of balls and of motors alike.
static_assert(offsetof(BallParameters, velocity_x) == offsetof(MotorParameters, angular_velocity_x) &&
              offsetof(BallParameters, velocity_y) == offsetof(MotorParameters, angular_velocity_y) &&
              offsetof(BallParameters, velocity_z) == offsetof(MotorParameters, angular_velocity_z) &&
              offsetof(BallParameters, hertz) == offsetof(MotorParameters, angular_hertz) &&
              offsetof(BallParameters, target) == offsetof(MotorParameters, target_rotation));
struct RotationTarget {
  Q4 rotation;  // of frame b in frame a, where the step begins
  V3 velocity;  // in the axes of frame a
};
inline RotationTarget load_rotation_target(const JointArgs& args, const std::int32_t* joint) {
  const BallParameters& from = args.parameters->ball;
  RotationTarget target;
  F before[3];
  // The velocity's numbers are the last ones of their groups of four.
  load_four(from.twist_lower, joint, before[0], before[1], before[2], target.velocity.x);
  load_four(from.gap_1[4], joint, before[0], before[1], before[2], target.velocity.y);
  load_four(from.gap_3[4], joint, before[0], before[1], before[2], target.velocity.z);
  load_four(from.target[0], joint, target.rotation.x, target.rotation.y, target.rotation.z,
            target.rotation.w);
  return target;
}
inline WideDrive load_rotation_drive(const JointArgs& args, const std::int32_t* joint) {
  return load_drive(args.parameters->ball.hertz, joint, F(0.0f));
}

// C = the rotation vector by which frame b is ahead of its target in frame a, along the axes of the world;
// J = [0, -1, 0, 1], which is its rate to first order of C.
inline void measure_rotation_drive(const Frames& frames, Q4 target, V3 velocity, DriveNow& drive) {
  const V3 ahead = rotate(frames.a, rotation_vector(conjugate(frames.a) * frames.b * conjugate(target)));
  const V3 turning = rotate(frames.a, velocity);
  const F error[3] = {ahead.x, ahead.y, ahead.z}, speed[3] = {turning.x, turning.y, turning.z};
  for (int i = 0; i < 3; ++i) {
    drive.row[i] = turn_row(world_axis(i));
    drive.error[i] = error[i];
    drive.target_speed[i] = speed[i];
  }
}

// The anchors' offset less its target, along the axes of the world; forces act on a where b's anchor is.
inline void measure_offset_drive(const Anchors& anchors, V3 ahead, V3 velocity, DriveNow& drive) {
  const F error[3] = {ahead.x, ahead.y, ahead.z}, speed[3] = {velocity.x, velocity.y, velocity.z};
  for (int i = 0; i < 3; ++i) {
    drive.row[i] = offset_row(world_axis(i), anchors.arm_a, anchors.arm_b, anchors.offset);
    drive.error[i] = error[i];
    drive.target_speed[i] = speed[i];
  }
}

// Sine of the angle of two axes that count as parallel.
constexpr float kLeastSine = 1e-3f;

// Unit axes that are to be square: C = their cosine, J = [0, -n, 0, n] about the direction n square to both;
// as one of the rows of Jolt's and ODE's universal and hinge joints.
struct SquareRow {
  Row row;
  F error;
};
inline SquareRow square_row(V3 axis_a, V3 axis_b) {
  // Parallel ones are as wrong as can be: any way out will do.
  return {turn_row(-normal_of(axis_a, axis_b, kLeastSine).direction), dot(axis_a, axis_b)};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
