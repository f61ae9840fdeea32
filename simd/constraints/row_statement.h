// Rows of constraints by lane, and how they are written as core/plain/constraint_row.h says. Private to the
// kernels over contacts and joints.
#pragma once

#include <core/plain/constraint_row.h>
#include <simd/constraints/constraint_block.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// A row of a Jacobian: makes one number of both bodies' velocities.
struct Row {
  V3 linear_a, angular_a, linear_b, angular_b;
};

inline Row zero_row() {
  const V3 none{F(0.0f), F(0.0f), F(0.0f)};
  return {none, none, none, none};
}

inline Row operator+(const Row& x, const Row& y) {
  return {x.linear_a + y.linear_a, x.angular_a + y.angular_a, x.linear_b + y.linear_b,
          x.angular_b + y.angular_b};
}
inline Row operator-(const Row& x, const Row& y) {
  return {x.linear_a - y.linear_a, x.angular_a - y.angular_a, x.linear_b - y.linear_b,
          x.angular_b - y.angular_b};
}
inline Row operator*(const Row& row, F scale) {
  return {row.linear_a * scale, row.angular_a * scale, row.linear_b * scale, row.angular_b * scale};
}
inline F dot(const Row& x, const Row& y) {
  return (dot(x.linear_a, y.linear_a) + dot(x.angular_a, y.angular_a)) +
         (dot(x.linear_b, y.linear_b) + dot(x.angular_b, y.angular_b));
}

// About an axis: b turns against a.
inline Row turn_row(V3 axis) {
  const V3 none{F(0.0f), F(0.0f), F(0.0f)};
  return {none, -axis, none, axis};
}
// Along an axis that is fixed in the world: the anchors' offset, by what acts on each body at its own anchor.
inline Row point_row(V3 axis, V3 arm_a, V3 arm_b) {
  return {-axis, -cross(arm_a, axis), axis, cross(arm_b, axis)};
}
// Along an axis that turns with a: the offset of the anchors. It acts on a where b's anchor is, or an offset
// would make a couple of the two forces.
inline Row offset_row(V3 axis, V3 arm_a, V3 arm_b, V3 offset) {
  return point_row(axis, arm_a + offset, arm_b);
}

inline V3 world_axis(int i) {
  const F zero(0.0f), one(1.0f);
  return {i == 0 ? one : zero, i == 1 ? one : zero, i == 2 ? one : zero};
}

constexpr float kInfinity = __builtin_inff();

inline I number(std::uint32_t value) { return I(static_cast<std::int32_t>(value)); }

// A ConstraintRow of each lane.
struct RowStatement {
  Row row = zero_row();
  I kind = number(kRowNone), block = number(0), flags = number(0);
  F error = F(0.0f), target_speed = F(0.0f);
  F lower = F(-kInfinity), upper = F(kInfinity);
  F hertz = F(0.0f), damping_ratio = F(0.0f), reference_response = F(0.0f);
  F impulse = F(0.0f);
  F bound_by[4] = {F(0.0f), F(0.0f), F(0.0f), F(0.0f)};
};

// Writes the rows of a block of lanes, slot by slot.
class Statement {
 public:
  Statement(ConstraintRows* rows, int first_lane, int count) : rows_(rows), count_(count) {
    for (int lane = 0; lane < kLanes; ++lane) lane_[lane] = first_lane + lane;
  }
  void add(const RowStatement& said) {
    constexpr int kStride = sizeof(ConstraintRows) / sizeof(float);
    float* base = rows_->row[slot_++].linear_a;
    const auto put = [&](F x, F y, F z, F w) {
      store_rows(base, kStride, lane_, count_, x, y, z, w);
      base += 4;
    };
    const auto& [linear_a, angular_a, linear_b, angular_b] = said.row;
    put(linear_a.x, linear_a.y, linear_a.z, said.error);
    put(angular_a.x, angular_a.y, angular_a.z, said.target_speed);
    put(linear_b.x, linear_b.y, linear_b.z, said.lower);
    put(angular_b.x, angular_b.y, angular_b.z, said.upper);
    put(said.hertz, said.damping_ratio, said.reference_response, said.impulse);
    put(said.bound_by[0], said.bound_by[1], said.bound_by[2], said.bound_by[3]);
    put(as_float(said.kind), as_float(said.block), as_float(said.flags), F(0.0f));
  }
  void leave_rest_empty() {
    while (slot_ < kMaxConstraintRows) add(RowStatement{});
  }

 private:
  ConstraintRows* rows_;
  int count_, slot_ = 0;
  alignas(64) LaneInts lane_;
};

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
