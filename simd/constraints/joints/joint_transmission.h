// What gears and racks have in common: turns that are followed, and errors that are summed up. Private to the
// joint kernels.
#pragma once

#include <simd/constraints/joints/joint_rows.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// The turn of a body about an axis of its own since the step began, in (-2 pi, 2 pi]. Sums of turns must stay
// true over thousands of them, so small angles have the series.
inline F turn_about(Q4 rotation, V3 axis) {
  const F sine = dot(V3{rotation.x, rotation.y, rotation.z}, axis), cosine = rotation.w;
  const M small = abs(sine) < F(0.2f) * cosine;
  const F t = sine / select(small, cosine, F(1.0f));
  const F s = t * t;
  F p = F(0.111111111f) - F(0.0909090909f) * s;
  p = F(-0.142857143f) + s * p;
  p = F(0.2f) + s * p;
  p = F(-0.333333333f) + s * p;
  const F series = t + t * (s * p);
  return F(2.0f) * select(small, series, atan2(sine, cosine));
}

// Turns of a rotation are known up to two of them: the ones nearest to the last known.
inline F follow_turn(F turn, F before) {
  return turn + round_to_nearest((before - turn) * F(0.0795774715f)) * F(12.5663706f);
}

// The error of a transmission is the sum of the motion of all steps, each measured as it ends; it stays near
// zero, where floats are fine. `ratio` is a gear's ratio or a pinion's radius.
struct SumLanes {
  LaneFloats first_error, ratio;
};
static_assert(offsetof(GearParameters, ratio) == offsetof(RackAndPinionParameters, radius));
inline void prepare_sum(const JointArgs& args, const std::int32_t* joint, F remembered, SumLanes& lanes) {
  const GearParameters& from = args.parameters->gear;
  F gap[3], ratio;
  load_four(from.gap_0[0], joint, gap[0], gap[1], ratio, gap[2]);
  store(lanes.first_error, remembered);
  store(lanes.ratio, ratio);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
