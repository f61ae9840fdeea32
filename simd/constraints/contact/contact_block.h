// The contact block: up to kLanes manifolds of one color, ready to be solved. Array of structures of arrays.
// Written by contact_prepare.cpp, worked on by contact_solve.cpp and contact_rebound.cpp; private to the
// contact kernels.
#pragma once

#include <simd/constraints/constraint_block.h>
#include <simd/constraints/contact/contact_kernels.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

template <int kPoints>
inline constexpr int kPairCount = kPoints*(kPoints - 1) / 2;

// Only manifolds of two points at most may be those of round shapes.
template <int kPoints>
inline constexpr bool kMayBeRound = kPoints < kMaxManifoldPoints;

// The manifold's kCoreA and kCoreB.
template <bool kRound>
struct Cores {
  LaneFloats core_a, core_b;
};
template <>
struct Cores<false> {};

// Vectors are three arrays, symmetric matrices six (xx xy xz yy yz zz). In the order in which passes need the
// fields, as code that needs a part only fetches that part only: solve reads up to `impulse`, store the
// impulses. The tangents are made from the normal.
template <int kPoints>
struct alignas(64) ContactBlock {
  LaneInts row_a, row_b;
  LaneFloats normal[3];
  LaneFloats arm_a[3], arm_b[3];
  LaneFloats inverse_mass_a, inverse_mass_b;
  LaneFloats inverse_inertia_a[6], inverse_inertia_b[6];
  // Per point: coordinates in the tangent plane, effective mass.
  LaneFloats u[kPoints], v[kPoints], effective_mass[kPoints];
  // Effect of a unit impulse at point k on the normal speed at point j > k: pairs 01 02 03 12 13 23.
  LaneFloats coupling[kPairCount<kPoints> > 0 ? kPairCount<kPoints> : 1];
  LaneFloats separation[kPoints];  // now
  LaneFloats impulse[kPoints];
  LaneFloats tangent_impulse[2], twist_impulse;

  LaneFloats initial_separation[kPoints];  // at the step's beginning
  LaneFloats radius[kPoints];              // distance from the center, at least the arm of the patch
  [[no_unique_address]] Cores<kMayBeRound<kPoints>> cores;
  LaneFloats friction;
  LaneFloats twist_mass;
  // On the twist speed: of the normal impulse and of the torque impulses about t1 and t2.
  LaneFloats twist_by_normal, twist_by_torque[2];
  // On the two tangent speeds: the same, and of the twist impulse.
  LaneFloats tangent_by_normal[2], tangent_by_torque1[2], tangent_by_torque2[2], tangent_by_twist[2];
  LaneFloats tangent_mass[3];  // inverse of the 2x2 matrix: 11 12 22
};

// The rare surface terms.
template <int kPoints>
struct RichBlock : ContactBlock<kPoints> {
  LaneFloats restitution;
  LaneFloats surface_speed[2];  // along t1 and t2
  LaneFloats rolling_resistance;
  LaneFloats rolling_mass[6];  // inverse of the sum of the inverse inertias
  LaneFloats rolling_impulse[3];
  // Of a rebound, see contact_rebound.cpp.
  LaneFloats impact_time;           // s, from the substep's beginning, or kNoImpact
  LaneFloats impact_alone;          // 1: the bodies have no other impact at that time
  LaneFloats impact_speed;          // m/s, of the fastest point
  LaneFloats impact_bias[kPoints];  // m/s, the negative of the speed to leave with
  LaneFloats impact_mass[kPoints];  // kg, of points that meet, else 0
  LaneFloats impact_impulse[kPoints];
  LaneFloats impact_tangent[2], impact_twist, impact_rolling[3];
};

template <int kPoints, bool kRich>
struct BlockOf {
  using Type = ContactBlock<kPoints>;
};
template <int kPoints>
struct BlockOf<kPoints, true> {
  using Type = RichBlock<kPoints>;
};

// Calls the instance of a kernel template for a chunk's variant.
#define SCREE_CONTACT_VARIANTS(KERNEL, args, chunk) \
  switch ((chunk).variant) {                        \
    case contact_variant(0, false, false):          \
      return KERNEL<1, false, false>(args, chunk);  \
    case contact_variant(0, false, true):           \
      return KERNEL<1, false, true>(args, chunk);   \
    case contact_variant(0, true, false):           \
      return KERNEL<1, true, false>(args, chunk);   \
    case contact_variant(0, true, true):            \
      return KERNEL<1, true, true>(args, chunk);    \
    case contact_variant(1, false, false):          \
      return KERNEL<2, false, false>(args, chunk);  \
    case contact_variant(1, false, true):           \
      return KERNEL<2, false, true>(args, chunk);   \
    case contact_variant(1, true, false):           \
      return KERNEL<2, true, false>(args, chunk);   \
    case contact_variant(1, true, true):            \
      return KERNEL<2, true, true>(args, chunk);    \
    case contact_variant(2, false, false):          \
      return KERNEL<4, false, false>(args, chunk);  \
    case contact_variant(2, false, true):           \
      return KERNEL<4, false, true>(args, chunk);   \
    case contact_variant(2, true, false):           \
      return KERNEL<4, true, false>(args, chunk);   \
    case contact_variant(2, true, true):            \
      return KERNEL<4, true, true>(args, chunk);    \
    default:                                        \
      return;                                       \
  }

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
