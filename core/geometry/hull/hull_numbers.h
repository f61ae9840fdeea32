// Shared by the stages of hull building: vectors in double precision, rounding to one side, padding.
#pragma once

#include <core/plain/hull.h>
#include <scree/math_types.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace scree {

using Vector = std::array<double, 3>;

inline Vector to_vector(const Vec3& v) { return {double{v.x}, double{v.y}, double{v.z}}; }
inline Vector to_vector(const float (&v)[3]) { return {double{v[0]}, double{v[1]}, double{v[2]}}; }
inline Vector operator+(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vector operator-(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vector operator*(double s, const Vector& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// The next smaller and the next larger float, for rounding bounds outward.
inline float round_down(double value) {
  const float nearest = static_cast<float>(value);
  return double{nearest} > value ? std::nextafter(nearest, -std::numeric_limits<float>::infinity()) : nearest;
}
inline float round_up(double value) { return -round_down(-value); }

// Row count rounded up to whole blocks.
inline std::size_t padded(std::size_t count) {
  constexpr std::size_t kBlock = kHullPadding;
  return (count + kBlock - 1) / kBlock * kBlock;
}

}  // namespace scree
