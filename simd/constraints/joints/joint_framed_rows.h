// What joints of rows with a frame in both bodies have in common. Private to the joint kernels.
#pragma once

#include <simd/constraints/joints/joint_frames.h>
#include <simd/constraints/joints/joint_rows.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// The base of their structs, see joint_rows.h.
struct FramedRows {
  using Lanes = PlacedLanes;
  static constexpr bool kRemembers = false;
  static void prepare(const JointArgs&, const std::int32_t*, const JointPlacement& at, const LaneInts&,
                      const LaneInts&, F, Lanes& lanes) {
    store_placed(at, lanes);
  }
  static void tune(const JointArgs&, const std::int32_t*, int, const Row&, const JointBodyLanes&, LaneAxis&) {
  }
};

// Unit axes that are to be square: the row about what both are square to, and the sine by which they are not.
struct SquareRow {
  Row row;
  F error;
};
inline SquareRow square_row(V3 axis_a, V3 axis_b) {
  // Parallel ones are as wrong as can be: any way out will do.
  return {turn_row(-normal_of(axis_a, axis_b, 1e-3f).direction), dot(axis_a, axis_b)};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
