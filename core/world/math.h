// Scalar arithmetic for the library's own sources, in addition to <scree/math.h>. Uses the formulas of
// simd/wide/wide_math.h.
#pragma once

#include <scree/math.h>

#include <cmath>

namespace scree {

// The first of the two tangents that a manifold's points are stored along, the second is n x t1. Duff et al.,
// "Building an Orthonormal Basis, Revisited", JCGT 2017.
inline Vec3 tangent_of(Vec3 n) {
  const float sign = std::copysign(1.0f, n.z);
  const float a = -1.0f / (sign + n.z);
  const float b = n.x * n.y * a;
  return {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x};
}

inline bool is_finite(Vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// The angle of (x, y), both at least 0 and not both 0: in [0, pi / 2], within 1e-10. The same bits
// everywhere.
double arc_of(double y, double x);

}  // namespace scree
