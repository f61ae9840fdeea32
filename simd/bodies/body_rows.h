// Loads rows of bodies into lanes, for the kernels over bodies and over constraints.
#pragma once

#include <core/plain/rows.h>
#include <simd/wide/wide_math.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

struct BodyMass {
  S3 inverse_inertia;
  F inverse_mass;
};

inline BodyMass load_mass(const InertiaRow* rows, const std::int32_t* index) {
  F column[8];
  load_rows8(rows->inverse_inertia, index, column);
  return {{column[0], column[1], column[2], column[3], column[4], column[5]}, column[6]};
}

// Motion since the step began.
struct WideDelta {
  V3 position;
  Q4 rotation;
};

inline WideDelta load_delta(const DeltaRow* rows, const std::int32_t* index) {
  F column[8];
  load_rows8(rows->position, index, column);
  return {{column[0], column[1], column[2]}, {column[3], column[4], column[5], column[6]}};
}

// q advanced by the rotation vector h w: the Cayley map (1 + h w / 2) q, normalized.
inline Q4 advance(Q4 q, V3 w, F h) {
  const F half = F(0.5f) * h;
  const Q4 spin = Q4{w.x * half, w.y * half, w.z * half, F(0.0f)} * q;
  return normalize({q.x + spin.x, q.y + spin.y, q.z + spin.z, q.w + spin.w});
}

inline M is_locked(I flags, int axis) { return !((flags & I(1 << axis)) == I(0)); }

// Axis locks take the locked components of a velocity away.
inline void apply_locks(I flags, V3& linear, V3& angular) {
  const F zero(0.0f);
  linear = {select(is_locked(flags, 0), zero, linear.x), select(is_locked(flags, 1), zero, linear.y),
            select(is_locked(flags, 2), zero, linear.z)};
  angular = {select(is_locked(flags, 3), zero, angular.x), select(is_locked(flags, 4), zero, angular.y),
             select(is_locked(flags, 5), zero, angular.z)};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
