// Kernels of joints whose rows are solved as they are measured, see joint_measure.h. Private to the joint
// kernels.
//
// A joint has
//
//   held rows   solved as one block, so that none takes away what another one has reached: speed zero, and in
//               `solve` what takes their errors back
//   axes        rows with a limit and a drive each, solved one after the other before the held ones
#pragma once

#include <simd/constraints/joints/joint_sweeps.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

struct RowLanes {
  LaneFloats linear_a[3], angular_a[3], linear_b[3], angular_b[3];
};
inline Row load_row(const RowLanes& from) {
  return {load3(from.linear_a), load3(from.angular_a), load3(from.linear_b), load3(from.angular_b)};
}
inline void store_row(RowLanes& to, const Row& row) {
  store3(to.linear_a, row.linear_a);
  store3(to.angular_a, row.angular_a);
  store3(to.linear_b, row.linear_b);
  store3(to.angular_b, row.angular_b);
}

// Rows that are held as one block. Its matrix K = J M^-1 J^T is kept as L D L^T: elimination row by row stays
// true with rows in m/s beside rows in rad/s.
template <int kRows>
struct HeldLanes {
  RowLanes row[kRows];
  LaneFloats error[kRows];
  LaneFloats impulse[kRows];
  LaneFloats inverse_pivot[kRows];     // of D; 0: the rows before it hold this one too, or nothing moves it
  LaneFloats lower[kRows][kRows - 1];  // L below its diagonal
  LaneSoftness soft, relaxed;
};
template <>
struct HeldLanes<1> {
  RowLanes row[1];
  LaneFloats error[1];
  LaneFloats impulse[1];
  LaneFloats inverse_pivot[1];
  LaneSoftness soft, relaxed;
};
template <>
struct HeldLanes<0> {
  LaneSoftness soft, relaxed;
};

template <int kRows>
inline void factor_held(HeldLanes<kRows>& held, const Row (&row)[kRows], const JointBodyLanes& bodies) {
  F lower[kRows][kRows], pivot[kRows];
  for (int j = 0; j < kRows; ++j) {
    const Row push = row_push(row[j], bodies);
    const F response = dot(row[j], push);
    F left = response;
    for (int m = 0; m < j; ++m) left -= lower[j][m] * lower[j][m] * pivot[m];
    const M any = left > response * F(kLeastPivot);
    pivot[j] = select(any, left, F(0.0f));
    const F inverse = select(any, F(1.0f) / select(any, left, F(1.0f)), F(0.0f));
    store(held.inverse_pivot[j], inverse);
    for (int i = j + 1; i < kRows; ++i) {
      F product = dot(row[i], push);
      for (int m = 0; m < j; ++m) product -= lower[i][m] * lower[j][m] * pivot[m];
      lower[i][j] = product * inverse;
      if constexpr (kRows > 1) store(held.lower[i][j], lower[i][j]);
    }
  }
}

// x = K^-1 x.
template <int kRows>
inline void divide_held(const HeldLanes<kRows>& held, F (&x)[kRows]) {
  if constexpr (kRows > 1) {
    for (int i = 1; i < kRows; ++i) {
      for (int j = 0; j < i; ++j) x[i] -= load(held.lower[i][j]) * x[j];
    }
  }
  for (int i = 0; i < kRows; ++i) x[i] *= load(held.inverse_pivot[i]);
  if constexpr (kRows > 1) {
    for (int i = kRows - 2; i >= 0; --i) {
      for (int j = i + 1; j < kRows; ++j) x[i] -= load(held.lower[j][i]) * x[j];
    }
  }
}

// Returns the largest speed that it met.
template <int kRows>
inline F solve_held(HeldLanes<kRows>& held, JointBodyLanes& bodies, const Softness& soft, F keep) {
  F change[kRows], worst(0.0f);
  for (int i = 0; i < kRows; ++i) {
    const F speed = row_speed(load_row(held.row[i]), bodies);
    worst = max(abs(speed), worst);
    change[i] = (speed + load(held.error[i]) * soft.bias_rate) * soft.mass_scale;
  }
  divide_held(held, change);
  for (int i = 0; i < kRows; ++i) {
    const F old_impulse = load(held.impulse[i]) * keep;
    const F impulse = old_impulse - (change[i] + old_impulse * soft.impulse_scale);
    store(held.impulse[i], impulse);
    push_row(bodies, load_row(held.row[i]), impulse - old_impulse);
  }
  return worst;
}

struct AxisLanes {
  RowLanes row;
  LaneFloats coordinate;
  LaneFloats mass;  // inverse of the row's response
  LaneAxis axis;
};
template <int kAxes>
struct AxisGroup {
  AxisLanes axis[kAxes];
};
template <>
struct AxisGroup<0> {};

// Returns the speed that the limit took away.
inline F solve_axis(const JointArgs& args, AxisUnit unit, AxisLanes& lanes, JointBodyLanes& bodies,
                    const Softness& held, F keep) {
  const Row row = load_row(lanes.row);
  const F coordinate = load(lanes.coordinate), mass = load(lanes.mass);
  F error(0.0f);
  if (unit != AxisUnit::speed) error = coordinate - target_now(args, lanes.axis);
  if (unit == AxisUnit::angle) error = shorter_way(error);
  push_row(bodies, row, solve_drive(lanes.axis, error, row_speed(row, bodies), mass, keep));
  if (unit == AxisUnit::speed) return F(0.0f);
  const Course course = unit == AxisUnit::angle ? Course::circle : Course::line;
  F within = coordinate;
  if (unit == AxisUnit::angle) {
    within = angle_within(coordinate, load(lanes.axis.lower), load(lanes.axis.upper));
  }
  const F limited = solve_limit(args, course, lanes.axis, within, row_speed(row, bodies), mass, held, keep);
  push_row(bodies, row, limited);
  return abs(limited) * invert_positive(mass);
}

template <class Shape, int kUsedAxes>
struct alignas(64) RowBlock {
  static constexpr int kHeld = Shape::kHeld, kAxes = kUsedAxes;
  LaneInts row_a, row_b;
  typename Shape::Lanes shape;
  LaneFloats arm_b[3];
  RowLanes turned;  // impulses by which the rows' turning changes what the velocities inherit
  HeldLanes<kHeld> held;
  AxisGroup<kAxes> axes;
};

// Takes the rows of the present poses into the block.
template <class Shape, class Block>
inline void place_rows(const RowsNow<Shape>& now, const JointBodyLanes& bodies, Block& block) {
  store3(block.arm_b, now.arm_b);
  if constexpr (Block::kHeld > 0) {
    for (int i = 0; i < Block::kHeld; ++i) {
      store_row(block.held.row[i], now.held[i]);
      store(block.held.error[i], now.error[i]);
    }
    factor_held(block.held, now.held, bodies);
  }
  if constexpr (Block::kAxes > 0) {
    for (int i = 0; i < Block::kAxes; ++i) {
      AxisLanes& lanes = block.axes.axis[i];
      store_row(lanes.row, now.axis[i]);
      store(lanes.coordinate, now.coordinate[i]);
      store(lanes.mass, invert_positive(dot(now.axis[i], row_push(now.axis[i], bodies))));
    }
  }
}

template <class Shape, class Block>
inline void prepare_rows(const JointArgs& args, const std::int32_t* joint, const JointBodyLanes& bodies,
                         const JointPlacement& at, Block& block) {
  F impulse[kJointImpulses];
  for (int i = 0; i < kJointImpulses; i += 4) {
    load_impulses(args, joint, i / 4, impulse[i], impulse[i + 1], impulse[i + 2], impulse[i + 3]);
  }
  Shape::prepare(args, joint, at, block.row_a, block.row_b, impulse[kMemory], block.shape);
  const F zero(0.0f), one(1.0f);
  const WideDelta still{{zero, zero, zero}, {zero, zero, zero, one}};
  RowsNow<Shape> now;
  Shape::measure(block.shape, still, still, now);
  place_rows(now, bodies, block);
  store_row(block.turned, zero_row());
  const WideStiffness given = load_stiffness(args, joint);
  const Softness soft = soften_held(args, bodies, given.hertz, given.damping_ratio);
  store_softness(block.held.soft, soft);
  store_softness(block.held.relaxed, relax_held(soft, given.hertz));
  if constexpr (Block::kHeld > 0) {
    for (int i = 0; i < Block::kHeld; ++i)
      store(block.held.impulse[i], impulse[i] * F(args.warm_start_scale));
  }
  if constexpr (Block::kAxes > 0) {
    for (int i = 0; i < Block::kAxes; ++i) {
      const int first = kFirstAxisImpulse + 2 * i;
      prepare_axis(args, bodies, Shape::asked(args, joint, i, now.axis[i], bodies), impulse[first],
                   impulse[first + 1], block.axes.axis[i].axis);
    }
  }
}

// All impulses along the block's rows.
template <class Block>
inline Row sum_impulses(const Block& block) {
  Row sum = zero_row();
  if constexpr (Block::kHeld > 0) {
    for (int i = 0; i < Block::kHeld; ++i) {
      sum = sum + load_row(block.held.row[i]) * load(block.held.impulse[i]);
    }
  }
  if constexpr (Block::kAxes > 0) {
    for (int i = 0; i < Block::kAxes; ++i) {
      const AxisLanes& lanes = block.axes.axis[i];
      sum = sum + load_row(lanes.row) * (load(lanes.axis.limit_impulse) + load(lanes.axis.drive_impulse));
    }
  }
  return sum;
}

template <class Block>
inline void drop_impulses(M which, Block& block) {
  const F zero(0.0f);
  for (int i = 0; i < Block::kAxes; ++i) {
    LaneAxis& axis = block.axes.axis[i].axis;
    store(axis.limit_impulse, select(which, zero, load(axis.limit_impulse)));
    store(axis.drive_impulse, select(which, zero, load(axis.drive_impulse)));
  }
}

template <class Shape, bool kRich>
struct RowJoint {
  using Rows = Shape;
  static constexpr bool kLeavesTurns = Shape::kLeavesTurns;
  using Block = RowBlock<Shape, kRich ? Shape::kAxes : 0>;
  static_assert(Block::kHeld <= kFirstAxisImpulse && kFirstAxisImpulse + 2 * Block::kAxes <= kMemory);

  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointBodyLanes& bodies,
                      const JointPlacement& at, Block& block) {
    prepare_rows<Shape>(args, joint, bodies, at, block);
  }
  static void warm_start(const Block& block, JointBodyLanes& bodies) {
    push_row(bodies, sum_impulses(block), F(1.0f));
  }
  static void solve(const JointArgs& args, Block& block, JointBodyLanes& bodies) {
    const F keep(args.impulse_keep);
    push_row(bodies, load_row(block.turned), keep);
    const Softness soft = load_softness(block.held.soft);
    solve_axes(args, block, bodies, soft, keep);
    if constexpr (Block::kHeld > 0) solve_held(block.held, bodies, soft, keep);
  }
  static F relax(const JointArgs& args, Block& block, const WideDelta& delta_a, const WideDelta& delta_b,
                 JointBodyLanes& bodies) {
    const Row inherited = sum_impulses(block);
    RowsNow<Shape> now;
    Shape::measure(block.shape, delta_a, delta_b, now);
    place_rows(now, bodies, block);
    if constexpr (Shape::kTurnsOver && Block::kAxes > 0) drop_impulses(now.turns_over, block);
    store_row(block.turned, sum_impulses(block) - inherited);
    const Softness relaxed = load_softness(block.held.relaxed);
    const F limited = solve_axes(args, block, bodies, relaxed, F(1.0f));
    if constexpr (Block::kHeld > 0) return solve_held(block.held, bodies, relaxed, F(1.0f));
    return limited;
  }
  static JointImpulse acting(const Block& block) {
    const Row sum = sum_impulses(block);
    return {sum.linear_b, sum.angular_b - cross(load3(block.arm_b), sum.linear_b)};
  }
  static void store(const JointArgs& args, const std::int32_t* joint, int count, const Block& block) {
    const F zero(0.0f);
    F impulse[kJointImpulses];
    for (F& each : impulse) each = zero;
    if constexpr (Block::kHeld > 0) {
      for (int i = 0; i < Block::kHeld; ++i) impulse[i] = load(block.held.impulse[i]);
    }
    if constexpr (Shape::kRemembers) impulse[kMemory] = load(block.held.error[0]);
    if constexpr (Block::kAxes > 0) {
      for (int i = 0; i < Block::kAxes; ++i) {
        impulse[kFirstAxisImpulse + 2 * i] = load(block.axes.axis[i].axis.limit_impulse);
        impulse[kFirstAxisImpulse + 2 * i + 1] = load(block.axes.axis[i].axis.drive_impulse);
      }
    }
    const JointImpulse sum = acting(block);
    F differences(0.0f);  // as in is_finite; non-finite impulses would make their bodies so again
    for (const F each : impulse) differences += each - each;
    const M finite = (differences == zero) & is_finite(sum.linear) & is_finite(sum.angular);
    for (F& each : impulse) each = select(finite, each, zero);
    for (int i = 0; i < kJointImpulses; i += 4) {
      store_impulses(args, joint, count, i / 4, impulse[i], impulse[i + 1], impulse[i + 2], impulse[i + 3]);
    }
  }

 private:
  // Returns the largest speed that a limit took away.
  static F solve_axes(const JointArgs& args, Block& block, JointBodyLanes& bodies, const Softness& held,
                      F keep) {
    F limited(0.0f);
    if constexpr (Block::kAxes > 0) {
      for (int i = 0; i < Block::kAxes; ++i) {
        limited = max(solve_axis(args, Shape::unit(i), block.axes.axis[i], bodies, held, keep), limited);
      }
    }
    return limited;
  }
};

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
