// Wide vectors, rotations and symmetric matrices: a lane is one body, contact or pair.
#pragma once

#include <simd/wide/wide.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

struct V3 {
  F x, y, z;
};
struct Q4 {
  F x, y, z, w;
};
// Symmetric 3x3.
struct S3 {
  F xx, xy, xz, yy, yz, zz;
};

inline V3 operator+(V3 a, V3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline V3 operator-(V3 a, V3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline V3 operator-(V3 a) { return {-a.x, -a.y, -a.z}; }
inline V3 operator*(V3 a, F s) { return {a.x * s, a.y * s, a.z * s}; }
inline V3 operator*(F s, V3 a) { return {a.x * s, a.y * s, a.z * s}; }
inline F dot(V3 a, V3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline V3 cross(V3 a, V3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline V3 select(M m, V3 yes, V3 no) {
  return {select(m, yes.x, no.x), select(m, yes.y, no.y), select(m, yes.z, no.z)};
}
inline Q4 select(M m, Q4 yes, Q4 no) {
  return {select(m, yes.x, no.x), select(m, yes.y, no.y), select(m, yes.z, no.z), select(m, yes.w, no.w)};
}
// True where all components are finite: x - x is 0 for finite numbers and NaN for the others.
inline M is_finite(F a) { return (a - a) == F(0.0f); }
inline M is_finite(V3 a) {
  const V3 difference = a - a;
  return (difference.x + difference.y + difference.z) == F(0.0f);
}
inline F length_squared(V3 a) { return dot(a, a); }
inline F length(V3 a) { return sqrt(dot(a, a)); }

inline S3 operator*(const S3& m, F s) { return {m.xx * s, m.xy * s, m.xz * s, m.yy * s, m.yz * s, m.zz * s}; }
inline V3 operator*(const S3& m, V3 v) {
  return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
          m.xz * v.x + m.yz * v.y + m.zz * v.z};
}

inline Q4 operator*(Q4 a, Q4 b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
inline Q4 conjugate(Q4 q) { return {-q.x, -q.y, -q.z, q.w}; }
inline Q4 normalize(Q4 q) {
  const F scale = F(1.0f) / sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {q.x * scale, q.y * scale, q.z * scale, q.w * scale};
}
// v + 2 r x (r x v + w v), for unit q = (r, w).
inline V3 rotate(Q4 q, V3 v) {
  const V3 r{q.x, q.y, q.z};
  const V3 t = F(2.0f) * cross(r, v);
  return v + q.w * t + cross(r, t);
}
inline V3 rotate_back(Q4 q, V3 v) { return rotate(conjugate(q), v); }

// Columns of the rotation matrix.
struct M3 {
  V3 x, y, z;
};
inline M3 to_matrix(Q4 q) {
  const F one(1.0f), two(2.0f);
  const F xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
  const F xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const F wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {{one - two * (yy + zz), two * (xy + wz), two * (xz - wy)},
          {two * (xy - wz), one - two * (xx + zz), two * (yz + wx)},
          {two * (xz + wy), two * (yz - wx), one - two * (xx + yy)}};
}
inline V3 operator*(const M3& m, V3 v) { return m.x * v.x + m.y * v.y + m.z * v.z; }
inline V3 multiply_transposed(const M3& m, V3 v) { return {dot(m.x, v), dot(m.y, v), dot(m.z, v)}; }

// R S R^T for a symmetric S.
inline S3 rotate(const M3& r, const S3& s) {
  const V3 row_x{s.xx, s.xy, s.xz}, row_y{s.xy, s.yy, s.yz}, row_z{s.xz, s.yz, s.zz};
  // T = R S, by columns of S (= rows, by symmetry)
  const V3 t_x = r * row_x, t_y = r * row_y, t_z = r * row_z;
  return {t_x.x * r.x.x + t_y.x * r.y.x + t_z.x * r.z.x, t_x.x * r.x.y + t_y.x * r.y.y + t_z.x * r.z.y,
          t_x.x * r.x.z + t_y.x * r.y.z + t_z.x * r.z.z, t_x.y * r.x.y + t_y.y * r.y.y + t_z.y * r.z.y,
          t_x.y * r.x.z + t_y.y * r.y.z + t_z.y * r.z.z, t_x.z * r.x.z + t_y.z * r.y.z + t_z.z * r.z.z};
}

// A unit vector perpendicular to the unit vector n, continuous except at n = -z. Duff et al., "Building an
// Orthonormal Basis, Revisited", JCGT 6(1), 2017.
inline V3 tangent_of(V3 n) {
  const F sign = copy_sign(F(1.0f), n.z);
  const F a = F(-1.0f) / (sign + n.z);
  const F b = n.x * n.y * a;
  return {F(1.0f) + sign * n.x * n.x * a, sign * b, -sign * n.x};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
