// Arithmetic of vectors, rotations and poses, for users and for the library itself.
//
// Right-handed, angles in radians, no units of its own. Rotations are unit quaternions: `a * b` turns by b
// first and then by a, and q and -q are the same rotation. What takes a rotation takes its unit length for
// granted; products drift away from it by rounding, which normalize() mends.
//
// The functions in this header are compiled into the program that calls them, with its flags: what a
// world computes depends on the library's flags alone. Those that are only declared here have the same bits
// on every machine and with every compiler, unlike std::sin and the like.
#pragma once

#include <scree/export.h>
#include <scree/math_types.h>

#include <cmath>

namespace scree {

// --- vectors ---

/// The sum.
SCREE_INLINE constexpr Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
/// The difference.
SCREE_INLINE constexpr Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
/// The opposite vector.
SCREE_INLINE constexpr Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
/// The vector scaled by s.
SCREE_INLINE constexpr Vec3 operator*(Vec3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }
/// The vector scaled by s.
SCREE_INLINE constexpr Vec3 operator*(float s, Vec3 a) { return {a.x * s, a.y * s, a.z * s}; }
/// The vector divided by s; infinite or not a number where s is 0.
SCREE_INLINE constexpr Vec3 operator/(Vec3 a, float s) { return {a.x / s, a.y / s, a.z / s}; }
/// Adds b to a.
SCREE_INLINE constexpr Vec3& operator+=(Vec3& a, Vec3 b) { return a = a + b; }
/// Subtracts b from a.
SCREE_INLINE constexpr Vec3& operator-=(Vec3& a, Vec3 b) { return a = a - b; }
/// Scales a by s.
SCREE_INLINE constexpr Vec3& operator*=(Vec3& a, float s) { return a = a * s; }
/// Divides a by s.
SCREE_INLINE constexpr Vec3& operator/=(Vec3& a, float s) { return a = a / s; }

/// The scalar product.
SCREE_INLINE constexpr float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
/// The vector product, right-handed.
SCREE_INLINE constexpr Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// The square of the length; infinite for components beyond 1e19.
SCREE_INLINE constexpr float length_squared(Vec3 a) { return dot(a, a); }
/// Of components below 1e19: squares of larger ones are infinite.
SCREE_INLINE float length(Vec3 a) { return std::sqrt(dot(a, a)); }
/// The length of b - a, with the limits of length().
SCREE_INLINE float distance(Vec3 a, Vec3 b) { return length(b - a); }
/// The unit vector of the same direction; zero of a vector whose length() is zero.
SCREE_INLINE Vec3 normalize(Vec3 a) {
  const float size = length(a);
  return size > 0.0f ? a / size : Vec3{};
}
/// From a (t = 0) to b (t = 1) along a straight line, and beyond.
SCREE_INLINE constexpr Vec3 lerp(Vec3 a, Vec3 b, float t) { return a + t * (b - a); }

// --- rotations ---

/// The rotation by b and then by a.
SCREE_INLINE constexpr Quat operator*(Quat a, Quat b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
/// Makes a the rotation by b and then by a.
SCREE_INLINE constexpr Quat& operator*=(Quat& a, Quat b) { return a = a * b; }
/// The opposite rotation.
SCREE_INLINE constexpr Quat conjugate(Quat q) { return {-q.x, -q.y, -q.z, q.w}; }
/// The scalar product of all four components: 1 or -1 for equal rotations.
SCREE_INLINE constexpr float dot(Quat a, Quat b) { return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w; }
/// To unit length; the length must not be zero.
SCREE_INLINE Quat normalize(Quat q) {
  const float scale = 1.0f / std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {q.x * scale, q.y * scale, q.z * scale, q.w * scale};
}
/// The vector turned by the rotation: from a body's axes to those of the world, where q is the body's.
SCREE_INLINE constexpr Vec3 rotate(Quat q, Vec3 v) {
  const Vec3 r{q.x, q.y, q.z};  // v + 2 r x (r x v + w v)
  const Vec3 t = 2.0f * cross(r, v);
  return v + q.w * t + cross(r, t);
}
/// The vector turned by the opposite rotation: from the world's axes to those of a body.
SCREE_INLINE constexpr Vec3 rotate_back(Quat q, Vec3 v) { return rotate(conjugate(q), v); }

/// A turn about a direction, counterclockwise seen from its tip.
struct AxisAngle {
  Vec3 axis{1.0f, 0.0f, 0.0f};  ///< unit
  float angle = 0.0f;           ///< rad

  friend bool operator==(const AxisAngle&, const AxisAngle&) = default;
};

/// The turn by `angle` (rad, within +-1e6) about an axis of any length. Without a length: no turn.
SCREE_API Quat from_axis_angle(Vec3 axis, float angle);
/// The turn by the shorter way, with an angle in [0, pi]. Where nothing is turned the axis is x.
SCREE_API AxisAngle to_axis_angle(Quat q);
/// How far the rotation turns by the shorter way, rad in [0, pi].
SCREE_API float angle_of(Quat q);
/// From a (t = 0) to b (t = 1) by the shorter way at an even pace; t in [0, 1].
SCREE_API Quat slerp(Quat a, Quat b, float t);

// --- poses ---

/// A point of the pose's frame, seen from outside of it.
SCREE_INLINE constexpr Vec3 transform(const Pose& pose, Vec3 point) {
  return pose.position + rotate(pose.rotation, point);
}
/// A point outside, seen from the pose's frame.
SCREE_INLINE constexpr Vec3 transform_back(const Pose& pose, Vec3 point) {
  return rotate_back(pose.rotation, point - pose.position);
}
/// The pose b of a frame that is itself at the pose a: transform(a * b, p) is transform(a, transform(b, p)).
SCREE_INLINE constexpr Pose operator*(const Pose& a, const Pose& b) {
  return {transform(a, b.position), a.rotation * b.rotation};
}
/// The outside as the pose's frame sees it: inverse(pose) * pose is no motion.
SCREE_INLINE constexpr Pose inverse(const Pose& pose) {
  const Quat back = conjugate(pose.rotation);
  return {rotate(back, -pose.position), back};
}

}  // namespace scree
