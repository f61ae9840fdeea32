// Angles of rotations from polynomials of + - * / and sqrt, not from the platform's functions, so that all
// instruction sets give the same bits.
#pragma once

#include <simd/wide/wide_math.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// Of a number in [0, 1]: the odd polynomial of degree 15 of least greatest error; within 1.4e-7 rad in
// floats.
inline F atan_of_unit(F x) {
  const F s = x * x;
  F p(-0.00405456731f);
  p = p * s + F(0.0218629576f);
  p = p * s + F(-0.055912327f);
  p = p * s + F(0.0964219719f);
  p = p * s + F(-0.139086291f);
  p = p * s + F(0.199465662f);
  p = p * s + F(-0.333298594f);
  p = p * s + F(0.999999344f);
  return x * p;
}

// The angle of (x, y) in [-pi, pi]; 0 of (0, 0).
inline F atan2(F y, F x) {
  const F ax = abs(x), ay = abs(y), zero(0.0f);
  const M steep = ay > ax;
  const F large = select(steep, ay, ax), small = select(steep, ax, ay);
  const M any = large > zero;
  const F ratio = select(any, small / select(any, large, F(1.0f)), zero);
  F angle = atan_of_unit(ratio);
  angle = select(steep, F(1.57079633f) - angle, angle);
  angle = select(x < zero, F(3.14159265f) - angle, angle);
  return select(y < zero, -angle, angle);
}

// To the nearest integer of a number below 2^22 in size.
inline F round_to_nearest(F x) {
  const F large(12582912.0f);  // 3 2^22: the last bit is one
  return (x + large) - large;
}
// The angle, less whole turns, by the shorter way.
inline F shorter_way(F angle) {
  const F turns = round_to_nearest(angle * F(0.159154943f));
  // 2 pi in two parts, so that many turns lose nothing.
  return (angle - turns * F(6.28125f)) - turns * F(1.93530718e-3f);
}

// An angle near limits of a circle: the end that the angle is past is the nearer one.
inline F angle_within(F angle, F lower, F upper) {
  const F middle = F(0.5f) * (lower + upper);
  const M bounded = (lower > F(-1e30f)) & (upper < F(1e30f));
  return select(bounded, middle + shorter_way(angle - middle), angle);
}

// The rotation vector (axis times angle) of a unit quaternion, by the shorter way.
inline V3 rotation_vector(Q4 q) {
  const F sign = select(q.w < F(0.0f), F(-1.0f), F(1.0f));
  const V3 v = V3{q.x, q.y, q.z} * sign;
  const F sine = length(v), cosine = q.w * sign;
  // Below, angle / sine is 2 to the last bit.
  const M small = sine < F(1e-4f);
  const F scale = select(small, F(2.0f), F(2.0f) * atan2(sine, cosine) / select(small, F(1.0f), sine));
  return v * scale;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
