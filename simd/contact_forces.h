// Impulses of a whole step, by lane: what acted in a substep is what its relax sweep ends with. Private to
// the contact kernels.
//
// A block has kForceFields arrays of lanes, which stand one behind the other: of normal impulses by point, of
// the two of friction, of twist, and three of rolling. What its variant does not have is not written.
#pragma once

#include <simd/contact_block.h>

#include <cstddef>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

inline float* force_lanes(const ContactArgs& args, int first_lane) {
  return args.force_sum + static_cast<std::ptrdiff_t>(first_lane) * kForceFields;
}

template <int kPoints, bool kRich, class Block>
inline void add_forces(const ContactArgs& args, int first_lane, const Block& block) {
  float* const lanes = force_lanes(args, first_lane);
  const auto add = [&](int field, const LaneFloats& impulse) {
    float* const to = lanes + field * kLanes;
    const F acted = load(impulse);
    store_unaligned(to, args.first_substep ? acted : load_unaligned(to) + acted);
  };
  for (int k = 0; k < kPoints; ++k) add(k, block.impulse[k]);
  add(kFrictionField, block.tangent_impulse[0]);
  add(kFrictionField + 1, block.tangent_impulse[1]);
  add(kTwistField, block.twist_impulse);
  if constexpr (kRich) {
    for (int axis = 0; axis < 3; ++axis) add(kRollingField + axis, block.rolling_impulse[axis]);
  }
}

// `impulse` holds those of the block and what restitution has added to them.
template <int kPoints, class Block>
inline void add_rebound_forces(const ContactArgs& args, int first_lane, const Block& block,
                               const F (&impulse)[kPoints]) {
  float* const lanes = force_lanes(args, first_lane);
  for (int k = 0; k < kPoints; ++k) {
    float* const to = lanes + k * kLanes;
    store_unaligned(to, load_unaligned(to) + (impulse[k] - load(block.impulse[k])));
  }
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
