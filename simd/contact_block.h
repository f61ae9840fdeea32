// The contact block: up to kLanes manifolds of one color, ready to be solved. Array of structures of arrays.
// Written by contact_prepare.cpp, worked on by contact_solve.cpp; private to the contact kernels.
#pragma once

#include <simd/contact_kernels.h>
#include <simd/wide_math.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

using LaneFloats = float[kLanes];
using LaneInts = std::int32_t[kLanes];

template <int kPoints>
inline constexpr int kPairCount = kPoints*(kPoints - 1) / 2;

// Vectors are three arrays, symmetric matrices six (xx xy xz yy yz zz).
template <int kPoints>
struct alignas(64) ContactBlock {
  LaneInts row_a, row_b;
  LaneFloats normal[3], tangent[3];
  LaneFloats arm_a[3], arm_b[3];
  LaneFloats inverse_mass_a, inverse_mass_b;
  LaneFloats inverse_inertia_a[6], inverse_inertia_b[6];
  // Per point: coordinates in the tangent plane, distance from the center, separation now and at the step's
  // beginning, impulse, effective mass.
  LaneFloats u[kPoints], v[kPoints], radius[kPoints];
  LaneFloats separation[kPoints], initial_separation[kPoints];
  LaneFloats impulse[kPoints], effective_mass[kPoints];
  // Effect of a unit impulse at point k on the normal speed at point j > k: pairs 01 02 03 12 13 23.
  LaneFloats coupling[kPairCount<kPoints> > 0 ? kPairCount<kPoints> : 1];
  LaneFloats friction;
  LaneFloats twist_mass, twist_impulse;
  // On the twist speed: of the normal impulse and of the torque impulses about t1 and t2.
  LaneFloats twist_by_normal, twist_by_torque[2];
  // On the two tangent speeds: likewise, and of the twist impulse.
  LaneFloats tangent_by_normal[2], tangent_by_torque1[2], tangent_by_torque2[2], tangent_by_twist[2];
  LaneFloats tangent_mass[3];  // inverse of the 2x2 matrix: 11 12 22
  LaneFloats tangent_impulse[2];
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

struct BodyVelocity {
  V3 linear, angular;
};

inline BodyVelocity load_velocity(const VelocityRow* rows, const std::int32_t* index) {
  BodyVelocity v;
  F pad0, pad1;
  load_rows(rows->linear, 8, index, v.linear.x, v.linear.y, v.linear.z, v.angular.x);
  load_rows(rows->linear + 4, 8, index, v.angular.y, v.angular.z, pad0, pad1);
  return v;
}

inline void store_velocity(VelocityRow* rows, const std::int32_t* index, int count, const BodyVelocity& v) {
  store_rows(rows->linear, 8, index, count, v.linear.x, v.linear.y, v.linear.z, v.angular.x);
  store_row_pairs(rows->linear + 4, 8, index, count, v.angular.y, v.angular.z);
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

  // Takes in the velocities of a block's parts of the hub; writes the hub when the group is complete.
  void add(const std::int32_t* index, int count, int first_lane, const BodyVelocity& v) {
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
