// Poses of scenes, computed in double precision, each rounded once: bodies of a machine and the frames of its
// joints.
#pragma once

#include <scree/math.h>

#include <cmath>
#include <numbers>

namespace scree::scenes {

constexpr float radians(double degrees) { return static_cast<float>(degrees * (std::numbers::pi / 180.0)); }

/// The rotation by `second` after `first`, both of unit length; so is the result.
inline Quat turned(Quat second, Quat first) {
  const double ax = second.x, ay = second.y, az = second.z, aw = second.w;
  const double bx = first.x, by = first.y, bz = first.z, bw = first.w;
  const double x = aw * bx + ax * bw + ay * bz - az * by;
  const double y = aw * by - ax * bz + ay * bw + az * bx;
  const double z = aw * bz + ax * by - ay * bx + az * bw;
  const double w = aw * bw - ax * bx - ay * by - az * bz;
  const double scale = 1.0 / std::sqrt(x * x + y * y + z * z + w * w);
  return {static_cast<float>(x * scale), static_cast<float>(y * scale), static_cast<float>(z * scale),
          static_cast<float>(w * scale)};
}

/// A vector, turned.
inline Vec3 turned(Quat q, Vec3 v) {
  const double qx = q.x, qy = q.y, qz = q.z, w = q.w, x = v.x, y = v.y, z = v.z;
  // v + 2 w (q x v) + 2 q x (q x v)
  const double cx = qy * z - qz * y, cy = qz * x - qx * z, cz = qx * y - qy * x;
  return {static_cast<float>(x + 2.0 * (w * cx + qy * cz - qz * cy)),
          static_cast<float>(y + 2.0 * (w * cy + qz * cx - qx * cz)),
          static_cast<float>(z + 2.0 * (w * cz + qx * cy - qy * cx))};
}

/// The shortest turn that takes one direction to another, of any lengths but zero; not for opposite ones.
inline Quat turn_between(Vec3 from, Vec3 to) {
  const double ax = from.x, ay = from.y, az = from.z, bx = to.x, by = to.y, bz = to.z;
  const double x = ay * bz - az * by, y = az * bx - ax * bz, z = ax * by - ay * bx;
  const double w = std::sqrt((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz)) +
                   (ax * bx + ay * by + az * bz);
  const double scale = 1.0 / std::sqrt(x * x + y * y + z * z + w * w);
  return {static_cast<float>(x * scale), static_cast<float>(y * scale), static_cast<float>(z * scale),
          static_cast<float>(w * scale)};
}

/// The rotation of a joint's frame whose x axis, the main one, has that direction; not for -x.
inline Quat along(Vec3 direction) { return turn_between({1.0f, 0.0f, 0.0f}, direction); }

/// A pose that is given in `frame`, in the coordinates that `frame` is given in.
inline Pose placed(const Pose& frame, const Pose& local) {
  const Vec3 arm = turned(frame.rotation, local.position);
  return {{frame.position.x + arm.x, frame.position.y + arm.y, frame.position.z + arm.z},
          turned(frame.rotation, local.rotation)};
}

/// A pose as seen from `frame`, both given in the same coordinates.
inline Pose seen_from(const Pose& frame, const Pose& pose) {
  const Quat back = conjugate(frame.rotation);
  const Vec3 arm{pose.position.x - frame.position.x, pose.position.y - frame.position.y,
                 pose.position.z - frame.position.z};
  return {turned(back, arm), turned(back, pose.rotation)};
}

}  // namespace scree::scenes
