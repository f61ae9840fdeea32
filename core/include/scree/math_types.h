// Plain vectors, rotations and poses of the public interface.
//
// They carry numbers in and out of a world. Their arithmetic is in <scree/math.h>, which <scree/scree.h>
// includes; users of Eigen find conversions in <scree/eigen.h>.
#pragma once

#include <scree/export.h>

namespace scree {

/// A vector or a point, in meters (or the unit that its owner names).
struct Vec3 {
  float x = 0.0f;  ///< component along the x axis
  float y = 0.0f;  ///< component along the y axis
  float z = 0.0f;  ///< component along the z axis

  /// 0 is x, 1 is y, 2 is z; there are no others.
  SCREE_INLINE constexpr float& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  SCREE_INLINE constexpr float operator[](int axis) const {
    return axis == 0 ? x : axis == 1 ? y : z;
  }  ///< the component, read only

  friend bool operator==(const Vec3&, const Vec3&) = default;
};

/// A rotation as a unit quaternion x i + y j + z k + w. The default is the identity.
struct Quat {
  float x = 0.0f;  ///< factor of i
  float y = 0.0f;  ///< factor of j
  float z = 0.0f;  ///< factor of k
  float w = 1.0f;  ///< the real part

  friend bool operator==(const Quat&, const Quat&) = default;
};

/// A rigid placement: a point p of the local frame lies at `position + rotation * p`.
struct Pose {
  Vec3 position;  ///< m, of the frame's origin
  Quat rotation;  ///< of the frame's axes

  friend bool operator==(const Pose&, const Pose&) = default;
};

/// Velocity of a body. Padded to 32 bytes: it is the very row that the solver works on.
struct alignas(32) Velocity {
  Vec3 linear;                      ///< of the center of mass, m/s
  Vec3 angular;                     ///< rad/s, in world axes
  float padding[2] = {0.0f, 0.0f};  ///< used by the step
};

}  // namespace scree
