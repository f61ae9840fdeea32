// Turns a body that no torque acts on. Used by body.cpp.
//
// Solves Euler's equations I w' = (I w) x w in the body's axes by the implicit midpoint rule, which keeps the
// energy and the magnitude of the momentum up to rounding, also of slender bodies. The pose turns by the same
// midpoint velocity m (Cayley's formula with the half-angle vector h m / 2), which keeps the momentum's
// direction. All three hold only if the midpoint equation is solved, not approximated: an inexact turn lays
// the momentum of a needle along its axis of far smaller inertia.
#pragma once

#include <simd/bodies/body_rows.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// rad; what Newton's method is given at once. Two iterations are then exact to the rounding, for any inertia
// that a solid can have: neither a third one nor less of a turn keeps more at 390 rad/s.
constexpr float kTurnAtOnce = 0.3f;
// A body that turns farther than so many of these at once, which is by two turns, keeps its velocity in its
// own axes, and with it energy and magnitude of the momentum.
constexpr float kMostParts = 42.0f;

// What the rotation by Cayley's formula with half-angle vector t adds to v:
// 2 / (1 + t^2) (t x v + t x (t x v)).
inline V3 rotation_change(V3 t, V3 v) {
  const V3 once = cross(t, v);
  const F scale = F(2.0f) / (F(1.0f) + length_squared(t));
  return (once + cross(t, once)) * scale;
}

// The x for which the matrix of these columns times x is b.
inline V3 solve(V3 x, V3 y, V3 z, V3 b) {
  const V3 yz = cross(y, z);
  const F scale = F(1.0f) / dot(x, yz);
  return V3{dot(b, yz), dot(b, cross(z, x)), dot(b, cross(x, y))} * scale;
}

// A step of Newton's method for I (m - w) + h/2 m x I m = 0, from where it is `residual`; `momentum` is I m.
inline V3 newton_step(V3 m, V3 momentum, const S3& inertia, F half_h, V3 residual) {
  const V3 x{inertia.xx, inertia.xy, inertia.xz}, y{inertia.xy, inertia.yy, inertia.yz},
      z{inertia.xz, inertia.yz, inertia.zz};
  // m x I e - I m x e, by axes e
  const V3 p = momentum, cx = cross(m, x), cy = cross(m, y), cz = cross(m, z);
  return -solve(x + V3{cx.x, cx.y - p.z, cx.z + p.y} * half_h, y + V3{cy.x + p.z, cy.y, cy.z - p.x} * half_h,
                z + V3{cz.x - p.y, cz.y + p.x, cz.z} * half_h, residual);
}

// By what the midpoint velocity m differs from w, the velocity before: the small change, not m, carries the
// rounding. Of the inertia only the ratios count, which should be about 1: it goes in by its third power.
inline V3 midpoint_change(V3 w, const S3& inertia, F half_h) {
  V3 momentum = inertia * w;
  const V3 first = newton_step(w, momentum, inertia, half_h, cross(w, momentum) * half_h);
  const V3 m = w + first;
  momentum = inertia * m;
  return first + newton_step(m, momentum, inertia, half_h, inertia * first + cross(m, momentum) * half_h);
}

// How a body turns through a time of `whole`: by parts that the midpoint rule follows.
struct Parts {
  F part;  // s
  M follows;
};
inline Parts parts_of(V3 w, F whole) {
  const F angle = whole * length(w);
  const M follows = angle < F(kTurnAtOnce * kMostParts);
  return {select(follows, whole * (F(kTurnAtOnce) / angle), whole), follows};
}

// As its ratios count only, and they go in by the third power.
inline S3 without_unit(const S3& inertia) {
  return inertia * (F(1.0f) / (inertia.xx + inertia.yy + inertia.zz));
}

// Turns a body freely for a time of h by `delta` since the step began; it began at `start`.
inline void turn_freely(Q4 start, const S3& inertia, F h, M which, Q4& delta, V3& w) {
  const F zero(0.0f);
  const S3 ratios = without_unit(inertia);
  const Parts parts = parts_of(w, h);
  F left = select(which, h, zero);
  do {
    const F part = min(left, parts.part), half = F(0.5f) * part;
    const M3 r = to_matrix(delta * start);
    const V3 local = multiply_transposed(r, w);
    const V3 d = select(parts.follows, midpoint_change(local, ratios, half), {zero, zero, zero});
    const V3 twice = d + d;
    const M turns = left > zero;
    delta = select(turns, advance(delta, w + r * d, part), delta);
    w = select(turns, w + r * (twice + rotation_change((local + d) * half, local + twice)), w);
    left = left - part;
  } while (bits(left > zero) != 0);
}

// What the velocity `local`, in the body's axes, changes by in a time of h, and has changed by if h is
// negative.
inline V3 precession(V3 local, const S3& inertia, F h) {
  const F zero(0.0f), duration = abs(h);
  const S3 ratios = without_unit(inertia);
  const Parts parts = parts_of(local, duration);
  V3 change{zero, zero, zero};
  F left = select(parts.follows, duration, zero);
  do {
    const F part = min(left, parts.part);
    const V3 d = midpoint_change(local + change, ratios, copy_sign(F(0.5f) * part, h));
    change = select(left > zero, change + (d + d), change);
    left = left - part;
  } while (bits(left > zero) != 0);
  return change;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
