// Rows of bodies in lanes, as the kernels over bodies and those over contacts read them.
#pragma once

#include <core/plain/rows.h>
#include <simd/wide_math.h>

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

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
