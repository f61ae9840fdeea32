// What blocks of constraints have in common, whatever their kind: lanes as arrays, the bodies of a block,
// hubs. Private to the kernels over contacts and joints.
#pragma once

#include <simd/bodies/body_rows.h>
#include <simd/constraints/constraint_chunk.h>
#include <simd/wide/wide_math.h>

#include <cstddef>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

using LaneFloats = float[kLanes];
using LaneInts = std::int32_t[kLanes];

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

// The part of a hub that one constraint has to itself.
inline BodyMass split(const BodyMass& m, F parts) {
  return {m.inverse_inertia * parts, m.inverse_mass * parts};
}

// Share of its diagonal, or of the product of two, below which a pivot or a determinant is rounding: ten
// times the spacing of floats.
constexpr float kLeastPivot = 1e-6f;
inline F invert_positive(F value) { return select(value > F(0.0f), F(1.0f) / value, F(0.0f)); }

// Inverse of a symmetric positive matrix by cofactors; zero where it is singular. It is scaled to a trace of
// 1 first: the determinant of a pebble's inverse inertia has no place in a float.
inline S3 invert(const S3& matrix) {
  const F unit = invert_positive(matrix.xx + matrix.yy + matrix.zz);
  const S3 m = matrix * unit;
  const F c_xx = m.yy * m.zz - m.yz * m.yz;
  const F c_xy = m.xz * m.yz - m.xy * m.zz;
  const F c_xz = m.xy * m.yz - m.xz * m.yy;
  const F scale = unit * invert_positive(m.xx * c_xx + m.xy * c_xy + m.xz * c_xz);
  return {scale * c_xx,
          scale * c_xy,
          scale * c_xz,
          scale * (m.xx * m.zz - m.xz * m.xz),
          scale * (m.xy * m.xz - m.xx * m.yz),
          scale * (m.xx * m.yy - m.xy * m.xy)};
}

// A pivot of the size of its rounding error counts as zero: the body is locked, or the row depends on others.
inline F invert_pivot(F pivot, F diagonal) {
  return select(pivot > F(kLeastPivot) * diagonal, F(1.0f) / pivot, F(0.0f));
}

// Inverse of a symmetric matrix that may be singular, on the directions in which it is not: bodies whose
// rotation is locked about some axes are held about the others.
inline S3 invert_semidefinite(const S3& m) {
  const F ix = invert_pivot(m.xx, m.xx);
  const F xy = m.xy * ix, xz = m.xz * ix;
  const F iy = invert_pivot(m.yy - xy * m.xy, m.yy);
  const F rest = m.yz - xz * m.xy;
  const F yz = rest * iy;
  const F iz = invert_pivot(m.zz - xz * m.xz - yz * rest, m.zz);
  const F x = xy * yz - xz;
  return {
      ix + xy * xy * iy + x * x * iz, -(xy * iy) - x * yz * iz, x * iz, iy + yz * yz * iz, -(yz * iz), iz};
}

inline F trace(const S3& m) { return m.xx + m.yy + m.zz; }

// The impulse of three rows that are bounded together, by length. `free` is what brings their `speed` to zero
// (with the bias and what gives way in it). Where that is too long, the drive or the resistance is at its
// limit, and opposes the speed: so the old impulse goes against it, by 1 / trace of the rows' `response`,
// which overshoots along no axis, and comes to rest only where impulse and speed oppose each other. (Scaled
// down, `free` would come to rest where it opposes inverse response times speed.)
inline V3 bound_length(V3 free, V3 old, V3 speed, F response_trace, F limit) {
  const M above = length(free) > limit;
  if (bits(above) == 0) return free;
  const F one(1.0f);
  const V3 along = old - speed * invert_positive(response_trace);
  const F size = length(along);
  return select(above, along * select(size > limit, limit / size, one), free);
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
template <class Block, class Args, class Body>
inline void for_each_block(const Args& args, const ConstraintChunk& chunk, Body&& body) {
  Block* block = reinterpret_cast<Block*>(args.blocks + chunk.offset);
  for (int b = 0; b < chunk.blocks; ++b, ++block) {
    const int left = chunk.lanes - b * kLanes;
    body(*block, left < kLanes ? left : kLanes, chunk.first_lane + b * kLanes);
  }
}

// Hubs: the constraints of a body of many are solved in groups of kHubGroup. In a group of n each constraint
// has an n-th of the hub to itself: n times the inverse mass and inertia. At the group's end the parts are
// joined again at their mean velocity, which conserves momentum and never adds energy (Tonge, Benevolenski
// and Voroshilov, "Mass Splitting for Jitter-Free Parallel Rigid Body Simulation", 2012). Groups do not
// depend on the width, and sums are taken in the order of the lanes. Joints have parts of their own, see
// joint_shares.h.
inline int hub_group_size(const ConstraintChunk& chunk, int first_lane) {
  const int begin = (first_lane - chunk.first_lane) / kHubGroup * kHubGroup;
  const int left = chunk.lanes - begin;
  return left < kHubGroup ? left : kHubGroup;
}

class HubSum {
 public:
  HubSum(VelocityRow* velocity, const ConstraintChunk& chunk) : rows_(velocity), chunk_(chunk) {}
  BodySide side() const { return chunk_.hub; }

  // Takes in the velocities of a block's parts of the hub; writes the hub when the group is complete. Rare:
  // kept out of the sweeps. `shares`: into how many parts each lane has divided the hub, if not into as many
  // as the group has lanes.
  [[gnu::noinline]] void add(const std::int32_t* index, int count, int first_lane, const BodyVelocity& v,
                             const float* shares = nullptr) {
    const int size = hub_group_size(chunk_, first_lane);
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
      const float weight = shares == nullptr ? 1.0f : static_cast<float>(size) / shares[lane];
      for (int i = 0; i < 6; ++i) change_[i] = change_[i] + (parts[i][lane] - *old[i]) * weight;
    }
    taken_ += count;
    if (taken_ < size) return;
    for (int i = 0; i < 6; ++i) {
      *old[i] = *old[i] + change_[i] / static_cast<float>(size);
      change_[i] = 0.0f;
    }
    taken_ = 0;
  }

 private:
  VelocityRow* rows_;
  const ConstraintChunk& chunk_;
  float change_[6] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
  int taken_ = 0;
};

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
