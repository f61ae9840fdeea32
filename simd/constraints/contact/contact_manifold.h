// Manifolds by lane, as prepare and state_rows read them. Private to the contact kernels.
#pragma once

#include <simd/constraints/contact/contact_sweep.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// Manifold, see core/plain/manifold.h.
struct WideManifold {
  V3 normal;
  F friction;
  V3 arm_a, arm_b;
  F row_a, row_b;  // bits of integers
  F u[kMaxManifoldPoints], v[kMaxManifoldPoints], separation[kMaxManifoldPoints];
  F impulse[kMaxManifoldPoints], friction_impulse[2], twist;
};

inline WideManifold load_manifold(const ContactArgs& args, const std::int32_t* contact) {
  constexpr int kStride = sizeof(Manifold) / sizeof(float);
  const float* base = args.manifolds->normal;
  WideManifold m;
  F info;
  load_rows(base, kStride, contact, m.normal.x, m.normal.y, m.normal.z, m.friction);
  load_rows(base + 4, kStride, contact, m.arm_a.x, m.arm_a.y, m.arm_a.z, m.row_a);
  load_rows(base + 8, kStride, contact, m.arm_b.x, m.arm_b.y, m.arm_b.z, m.row_b);
  load_rows(base + 12, kStride, contact, m.u[0], m.u[1], m.u[2], m.u[3]);
  load_rows(base + 16, kStride, contact, m.v[0], m.v[1], m.v[2], m.v[3]);
  load_rows(base + 20, kStride, contact, m.separation[0], m.separation[1], m.separation[2], m.separation[3]);
  load_rows(base + 24, kStride, contact, m.impulse[0], m.impulse[1], m.impulse[2], m.impulse[3]);
  load_rows(base + 28, kStride, contact, m.friction_impulse[0], m.friction_impulse[1], m.twist, info);
  return m;
}

// Points that do not exist are far away.
inline M is_present(F separation) { return separation < F(0.5f * kAbsentSeparation); }

// The arm at which a point's friction acts against spin. A manifold of two points at most has room for the
// arm of the patch around a point.
inline F twist_arm(F u, F v, bool has_patch, F patch) {
  const F radius = sqrt(u * u + v * v);
  return has_patch ? max(patch, radius) : radius;
}

// ContactSurface.
struct WideSurface {
  F restitution, rolling_resistance;
  V3 velocity, rolling_impulse;
};
inline WideSurface load_surface(const ContactArgs& args, const std::int32_t* contact) {
  constexpr int kStride = sizeof(ContactSurface) / sizeof(float);
  const float* base = &args.surfaces->restitution;
  WideSurface s;
  load_rows(base, kStride, contact, s.restitution, s.rolling_resistance, s.velocity.x, s.velocity.y);
  load_rows(base + 4, kStride, contact, s.velocity.z, s.rolling_impulse.x, s.rolling_impulse.y,
            s.rolling_impulse.z);
  return s;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
