// Impulses of a whole step, by lane: what acted in a substep is what its relax sweep ends with. Private to
// the contact kernels.
//
// A block has kForceFields arrays of lanes, which stand one behind the other: of normal impulses by point, of
// the two of friction, of twist, and three of rolling. Prepare clears them, rebounds and relax sweeps add.
#pragma once

#include <simd/constraints/contact/contact_sweep.h>

#include <cstddef>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

inline float* force_lanes(const ContactArgs& args, int first_lane) {
  return args.force_sum + static_cast<std::ptrdiff_t>(first_lane) * kForceFields;
}

inline void add_to_lanes(float* lanes, F more) { store_unaligned(lanes, load_unaligned(lanes) + more); }

inline void clear_forces(const ContactArgs& args, int first_lane) {
  float* const lanes = force_lanes(args, first_lane);
  for (int field = 0; field < kForceFields; ++field) store_unaligned(lanes + field * kLanes, F(0.0f));
}

// Those that the block has.
template <int kPoints, bool kRich, class Block>
inline void add_forces(const ContactArgs& args, int first_lane, const Block& block) {
  float* const lanes = force_lanes(args, first_lane);
  const auto add = [&](int field, const LaneFloats& impulse) {
    add_to_lanes(lanes + field * kLanes, load(impulse));
  };
  for (int k = 0; k < kPoints; ++k) add(k, block.impulse[k]);
  add(kFrictionField, block.tangent_impulse[0]);
  add(kFrictionField + 1, block.tangent_impulse[1]);
  add(kTwistField, block.twist_impulse);
  if constexpr (kRich) {
    for (int axis = 0; axis < 3; ++axis) add(kRollingField + axis, block.rolling_impulse[axis]);
  }
}

// Those of a rebound, which the block does not keep, where it `happens`.
template <int kPoints>
inline void add_rebound_forces(const ContactArgs& args, int first_lane, M happens, const F (&normal)[kPoints],
                               const FrictionImpulses& friction, V3 rolling) {
  float* const lanes = force_lanes(args, first_lane);
  const auto add = [&](int field, F impulse) {
    add_to_lanes(lanes + field * kLanes, select(happens, impulse, F(0.0f)));
  };
  for (int k = 0; k < kPoints; ++k) add(k, normal[k]);
  add(kFrictionField, friction.tangent[0]);
  add(kFrictionField + 1, friction.tangent[1]);
  add(kTwistField, friction.twist);
  add(kRollingField, rolling.x);
  add(kRollingField + 1, rolling.y);
  add(kRollingField + 2, rolling.z);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
