// From what a kind of joint measures to ConstraintRows. Private to the joint kernels.
//
// Rows are stated at the poses at the step's beginning moved by the deltas, at JointArgs::elapsed, of whole
// bodies: that a solver divides a body among its joints is its own affair, see joint_shares.h.
//
// Two differences from kernels remain within a step. Kernels follow the turns of gears and pinions substep by
// substep; a statement has the deltas only, and takes a turn of more than half a circle since the step's
// beginning for the shorter one. Kernels take the response for which the suspension of a wheel means its
// hertz at the step's beginning, a statement at the present inertia.
#pragma once

#include <simd/constraints/joints/joint_measure.h>
#include <simd/constraints/joints/joint_shares.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

constexpr std::uint32_t kHeldBlock = 0;

struct StatedJoint {
  const JointArgs& args;
  const std::int32_t* joint;
  const JointBodyLanes& bodies;
  WideStiffness stiffness;
  Statement& to;
};

template <class Shape>
inline void state_held(const StatedJoint& of, const RowsNow<Shape>& now, const RowImpulses<Shape>& impulses) {
  if constexpr (Shape::kHeld > 0) {
    for (int i = 0; i < Shape::kHeld; ++i) {
      RowStatement said;
      said.row = now.held[i];
      said.kind = number(kRowHeld);
      said.error = now.error[i];
      said.hertz = Shape::is_angular(i) ? of.stiffness.angular_hertz : of.stiffness.hertz;
      said.damping_ratio =
          Shape::is_angular(i) ? of.stiffness.angular_damping_ratio : of.stiffness.damping_ratio;
      said.impulse = impulses.held[i];
      said.block = number(kHeldBlock);
      of.to.add(said);
    }
  }
}

inline I kind_of_drive(I drive) {
  const M spring = drive == number(kDriveSpring), motor = drive == number(kDriveMotor);
  return select(spring, number(kRowSpring), select(motor, number(kRowMotor), number(kRowNone)));
}

template <class Shape>
inline void state_drives(const StatedJoint& of, const RowsNow<Shape>& now,
                         const RowImpulses<Shape>& impulses) {
  if constexpr (Shape::kDrives > 0) {
    for (int i = 0; i < Shape::kDrives; ++i) {
      const WideDrive asked = Shape::asked_drive(of.args, of.joint, i, of.bodies);
      for (int k = 0; k < 3; ++k) {
        RowStatement said;
        said.row = now.drive[i].row[k];
        said.kind = kind_of_drive(asked.drive);
        said.flags = number(kRowBoundsLength | (Shape::kKeepsHeld ? kRowKeepsHeld : 0u));
        said.error = now.drive[i].error[k];
        said.target_speed = now.drive[i].target_speed[k];
        said.lower = -asked.max_force;
        said.upper = asked.max_force;
        said.hertz = asked.hertz;
        said.damping_ratio = asked.damping_ratio;
        said.reference_response = asked.reference_response;
        said.impulse = impulses.drive3[i][k];
        said.block = number(kHeldBlock + 1 + static_cast<std::uint32_t>(i));
        of.to.add(said);
      }
    }
  }
}

inline F difference_of(AxisUnit unit, F coordinate, F from) {
  if (unit == AxisUnit::speed) return F(0.0f);
  return unit == AxisUnit::angle ? shorter_way(coordinate - from) : coordinate - from;
}

// A motor brings the axis to its speed, a spring pulls it to its target.
inline RowStatement state_axis_drive(const StatedJoint& of, AxisUnit unit, const Row& row, F coordinate,
                                     const WideAxis& asked, F impulse) {
  RowStatement said;
  said.row = row;
  said.kind = kind_of_drive(asked.drive);
  said.error = difference_of(unit, coordinate, asked.target + asked.speed * F(of.args.elapsed));
  said.target_speed = asked.speed;
  said.lower = -asked.max_force;
  said.upper = asked.max_force;
  said.hertz = asked.hertz;
  said.damping_ratio = asked.damping_ratio;
  said.impulse = impulse;
  return said;
}

// Of the nearer end: the way that is left to it, along a row that leads away from it.
inline RowStatement state_limit(const StatedJoint& of, AxisUnit unit, const Row& row, F coordinate,
                                const WideAxis& asked, F impulse) {
  const F zero(0.0f), one(1.0f), none(kInfinity);
  const bool circle = unit == AxisUnit::angle;
  const F within = circle ? angle_within(coordinate, asked.lower, asked.upper) : coordinate;
  const F above = within - asked.lower, below = asked.upper - within;
  const M at_upper = below < above, equal = asked.lower == asked.upper;
  const F sign = select(at_upper, -one, one), separation = select(at_upper, below, above);
  const M any = (separation < F(kNoEnd)) | equal;
  RowStatement said;
  said.row = {row.linear_a * sign, row.angular_a * sign, row.linear_b * sign, row.angular_b * sign};
  said.kind = select(any, number(kRowLimit), number(kRowNone));
  said.error = select(any, separation, zero);
  said.lower = select(equal, -none, zero);
  said.upper = none;
  said.hertz = of.stiffness.hertz;
  said.damping_ratio = of.stiffness.damping_ratio;
  said.impulse = impulse * sign;
  if (circle) {
    const M both = (asked.lower > F(-kNoEnd)) & (asked.upper < F(kNoEnd));
    said.flags = select(both, number(0), number(kRowOneEndOfCircle));
  }
  return said;
}

// Turns a limit with equal ends into a row that is held like others.
inline void hold_equal_ends(AxisUnit unit, const Row& row, F coordinate, const WideAxis& asked, F impulse,
                            RowStatement& drive, RowStatement& limit) {
  const M equal = asked.lower == asked.upper;
  const auto either = [&](V3 yes, V3 no) { return select(equal, yes, no); };
  limit.row = {either(row.linear_a, limit.row.linear_a), either(row.angular_a, limit.row.angular_a),
               either(row.linear_b, limit.row.linear_b), either(row.angular_b, limit.row.angular_b)};
  limit.kind = select(equal, number(kRowHeld), limit.kind);
  limit.block = select(equal, number(kHeldBlock), limit.block);
  limit.flags = select(equal, number(0), limit.flags);
  limit.error = select(equal, difference_of(unit, coordinate, asked.lower), limit.error);
  limit.impulse = select(equal, impulse, limit.impulse);
  drive.kind = select(equal, number(kRowNone), drive.kind);
}

// `first`: the rows where the step began, from which softness is taken, once a step.
template <class Shape>
inline void state_axes(const StatedJoint& of, const RowsNow<Shape>& first, const RowsNow<Shape>& now,
                       const RowImpulses<Shape>& impulses) {
  if constexpr (Shape::kAxes > 0) {
    const I keeps = number(Shape::kKeepsHeld ? kRowKeepsHeld : 0u);
    for (int i = 0; i < Shape::kAxes; ++i) {
      const AxisUnit unit = Shape::unit(i);
      const WideAxis asked = Shape::asked(of.args, of.joint, i, first.axis[i], of.bodies);
      // A row of no length, where an axis is not defined, moves nothing.
      const M defined = dot(now.axis[i], now.axis[i]) > F(0.0f);
      const auto block = kHeldBlock + 1 + static_cast<std::uint32_t>(Shape::kDrives + 2 * i);
      RowStatement drive =
          state_axis_drive(of, unit, now.axis[i], now.coordinate[i], asked, impulses.drive[i]);
      RowStatement limit = state_limit(of, unit, now.axis[i], now.coordinate[i], asked, impulses.limit[i]);
      drive.block = number(block);
      limit.block = number(block + 1);
      drive.flags = keeps;
      limit.flags = limit.flags | keeps;
      if constexpr (Shape::kHoldsEqualEnds) {
        hold_equal_ends(unit, now.axis[i], now.coordinate[i], asked, impulses.limit[i], drive, limit);
      }
      drive.kind = select(defined, drive.kind, number(kRowNone));
      limit.kind = select(defined, limit.kind, number(kRowNone));
      if constexpr (Shape::kAxisDrives) of.to.add(drive);
      if (unit != AxisUnit::speed) of.to.add(limit);
    }
  }
}

template <class Shape>
void state_rows(const JointArgs& args, const ConstraintChunk& chunk, ConstraintRows* rows) {
  // A rotation drive states a row an axis, an axis its drive and its limit.
  static_assert(Shape::kHeld + 3 * Shape::kDrives + 2 * Shape::kAxes <= kMaxConstraintRows);
  for (int lane = 0; lane < chunk.lanes; lane += kLanes) {
    const int count = chunk.lanes - lane < kLanes ? chunk.lanes - lane : kLanes;
    const std::int32_t* joint = args.rows + chunk.first_lane + lane;
    alignas(64) LaneInts row_a, row_b;
    const JointPlacement placement = load_placement(args, joint, row_a, row_b);
    const JointBodyLanes bodies = load_bodies(args, row_a, row_b);
    F stored[kJointImpulses];
    for (int i = 0; i < kJointImpulses; i += 4) {
      load_impulses(args, joint, i / 4, stored[i], stored[i + 1], stored[i + 2], stored[i + 3]);
    }
    alignas(64) typename Shape::Lanes lanes;
    Shape::prepare(args, joint, placement, row_a, row_b, stored[kMemory], lanes);
    const F zero(0.0f), one(1.0f);
    const WideDelta still{{zero, zero, zero}, {zero, zero, zero, one}};
    RowsNow<Shape> first, now;
    Shape::measure(lanes, still, still, first);
    Shape::measure(lanes, load_delta(args.delta, row_a), load_delta(args.delta, row_b), now);
    RowImpulses<Shape> along;
    Shape::impulses(stored, now, along);
    Statement to(rows, chunk.first_lane + lane, count);
    const StatedJoint of{args, joint, bodies, load_stiffness(args, joint), to};
    if constexpr (Shape::kKeepsHeld) state_held(of, now, along);
    state_drives(of, now, along);
    state_axes(of, first, now, along);
    if constexpr (!Shape::kKeepsHeld) state_held(of, now, along);
    to.leave_rest_empty();
  }
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
