// The contact block: up to kLanes manifolds of one color, ready to be solved. Array of structures of arrays.
// Written by contact_prepare.cpp, worked on by contact_solve.cpp; private to the contact kernels.
#pragma once

#include <simd/body_rows.h>
#include <simd/contact_kernels.h>
#include <simd/wide_math.h>

#include <cstddef>

// In front of a sweep over blocks: leaves no call in it. GCC 12 makes functions of the helpers below and
// hands them vectors through memory, which costs relax a third of its time. Sanitizers would take minutes
// over it.
#ifdef SCREE_SANITIZED
#define SCREE_SWEEP
#else
#define SCREE_SWEEP [[gnu::flatten]]
#endif

namespace scree::simd::SCREE_SIMD_NAMESPACE {

using LaneFloats = float[kLanes];
using LaneInts = std::int32_t[kLanes];

template <int kPoints>
inline constexpr int kPairCount = kPoints*(kPoints - 1) / 2;

// Vectors are three arrays, symmetric matrices six (xx xy xz yy yz zz). In the order in which passes need the
// fields, as whoever needs a part only also fetches that part only: solve reads up to `impulse`, store the
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
  LaneFloats friction;
  LaneFloats twist_mass;
  // On the twist speed: of the normal impulse and of the torque impulses about t1 and t2.
  LaneFloats twist_by_normal, twist_by_torque[2];
  // On the two tangent speeds: likewise, and of the twist impulse.
  LaneFloats tangent_by_normal[2], tangent_by_torque1[2], tangent_by_torque2[2], tangent_by_twist[2];
  LaneFloats tangent_mass[3];  // inverse of the 2x2 matrix: 11 12 22
};

// The rare surface terms.
template <int kPoints>
struct RichBlock : ContactBlock<kPoints> {
  LaneFloats restitution;
  LaneFloats approach_speed[kPoints];  // normal speed before the impact; prepare, solve
  LaneFloats pressed[kPoints];         // largest impulse of the step so far; prepare, solve
  LaneFloats surface_speed[2];         // along t1 and t2
  LaneFloats rolling_resistance;
  LaneFloats rolling_mass[6];  // inverse of the sum of the inverse inertias
  LaneFloats rolling_impulse[3];
};

template <int kPoints, bool kRich>
struct BlockOf {
  using Type = ContactBlock<kPoints>;
};
template <int kPoints>
struct BlockOf<kPoints, true> {
  using Type = RichBlock<kPoints>;
};

inline V3 load3(const LaneFloats (&from)[3]) { return {load(from[0]), load(from[1]), load(from[2])}; }
inline void store3(LaneFloats (&to)[3], V3 v) {
  store(to[0], v.x);
  store(to[1], v.y);
  store(to[2], v.z);
}
inline S3 load6(const LaneFloats (&from)[6]) {
  return {load(from[0]), load(from[1]), load(from[2]), load(from[3]), load(from[4]), load(from[5])};
}
inline void store6(LaneFloats (&to)[6], const S3& m) {
  store(to[0], m.xx);
  store(to[1], m.xy);
  store(to[2], m.xz);
  store(to[3], m.yy);
  store(to[4], m.yz);
  store(to[5], m.zz);
}

// With the row's padding, so that whole rows can be written.
struct BodyVelocity {
  V3 linear, angular;
  F padding[2];
};

inline BodyVelocity load_velocity(const VelocityRow* rows, const std::int32_t* index) {
  F column[8];
  load_rows8(rows->linear, index, column);
  return {{column[0], column[1], column[2]}, {column[3], column[4], column[5]}, {column[6], column[7]}};
}

inline void store_velocity(VelocityRow* rows, const std::int32_t* index, int count, const BodyVelocity& v) {
  const F column[8] = {v.linear.x,  v.linear.y,  v.linear.z,   v.angular.x,
                       v.angular.y, v.angular.z, v.padding[0], v.padding[1]};
  if (count == kLanes) {  // no questions lane by lane
    store_rows8(rows->linear, index, kLanes, column);
  } else {
    store_rows8(rows->linear, index, count, column);
  }
}

// Fetches bytes [begin, end) of what stands at `base` into the first cache. Each kernel does so with its next
// block while it works on one: processors do not foresee the order in which a pass reads a block's lines, and
// wait for each. Without it, piles whose blocks leave the second cache take twice the time. Reaching past the
// last block is harmless. Found useless: fetching two blocks ahead, every other line, into the second cache
// only, and the rows of the next block's bodies.
enum class Access { read, write };
template <Access kAccess = Access::read>
inline void prefetch(const void* base, std::size_t begin, std::size_t end) {
  constexpr std::size_t kLine = 64;
  for (std::size_t at = begin; at < end; at += kLine) {
    __builtin_prefetch(static_cast<const char*>(base) + at, kAccess == Access::write ? 1 : 0, 3);
  }
}

// Calls body(block, used lanes, first lane) for each block of the chunk.
template <class Block, class Body>
inline void for_each_block(const ContactArgs& args, const ContactChunk& chunk, Body&& body) {
  Block* block = reinterpret_cast<Block*>(args.blocks + chunk.offset);
  for (int b = 0; b < chunk.blocks; ++b, ++block) {
    const int left = chunk.lanes - b * kLanes;
    body(*block, left < kLanes ? left : kLanes, chunk.first_lane + b * kLanes);
  }
}

// Hubs: the contacts of a body of many are solved in groups of kHubGroup. In a group of n each contact has an
// n-th of the hub to itself: n times the inverse mass and inertia. At the group's end the parts are joined
// again at their mean velocity, which conserves momentum and never adds energy (Tonge, Benevolenski and
// Voroshilov, "Mass Splitting for Jitter-Free Parallel Rigid Body Simulation", 2012). Groups do not depend on
// the width, and sums are taken in the order of the lanes.
inline int hub_group_size(const ContactChunk& chunk, int first_lane) {
  const int begin = (first_lane - chunk.first_lane) / kHubGroup * kHubGroup;
  const int left = chunk.lanes - begin;
  return left < kHubGroup ? left : kHubGroup;
}

class HubSum {
 public:
  HubSum(const ContactArgs& args, const ContactChunk& chunk) : rows_(args.velocity), chunk_(chunk) {}
  HubSide side() const { return chunk_.hub; }

  // Takes in the velocities of a block's parts of the hub; writes the hub when the group is complete. Rare:
  // kept out of the sweeps.
  [[gnu::noinline]] void add(const std::int32_t* index, int count, int first_lane, const BodyVelocity& v) {
    alignas(64) LaneFloats parts[6];
    store(parts[0], v.linear.x);
    store(parts[1], v.linear.y);
    store(parts[2], v.linear.z);
    store(parts[3], v.angular.x);
    store(parts[4], v.angular.y);
    store(parts[5], v.angular.z);
    float* old[6];
    for (int i = 0; i < 3; ++i) old[i] = &rows_[index[0]].linear[i];
    for (int i = 0; i < 3; ++i) old[3 + i] = &rows_[index[0]].angular[i];
    for (int lane = 0; lane < count; ++lane) {
      for (int i = 0; i < 6; ++i) change_[i] = change_[i] + (parts[i][lane] - *old[i]);
    }
    taken_ += count;
    const int size = hub_group_size(chunk_, first_lane);
    if (taken_ < size) return;
    for (int i = 0; i < 6; ++i) {
      *old[i] = *old[i] + change_[i] / static_cast<float>(size);
      change_[i] = 0.0f;
    }
    taken_ = 0;
  }

 private:
  VelocityRow* rows_;
  const ContactChunk& chunk_;
  float change_[6] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
  int taken_ = 0;
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
