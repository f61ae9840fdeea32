// Plain vectors, rotations and poses of the public interface.
//
// They carry numbers in and out of a world and nothing else: no arithmetic lives here, because whatever
// reaches simulation state is computed by sources whose compiler flags the library controls. Users of Eigen
// find conversions in <scree/eigen.h>.
#pragma once

namespace scree {

/// A vector or a point, in meters (or the unit that its owner names).
struct Vec3 {
  float x = 0.0f;
  float y = 0.0f;
  float z = 0.0f;

  friend bool operator==(const Vec3&, const Vec3&) = default;
};

/// A rotation as a unit quaternion x i + y j + z k + w. The default is the identity.
struct Quat {
  float x = 0.0f;
  float y = 0.0f;
  float z = 0.0f;
  float w = 1.0f;

  friend bool operator==(const Quat&, const Quat&) = default;
};

/// A rigid placement: a point p of the local frame lies at `position + rotation * p`.
struct Pose {
  Vec3 position;
  Quat rotation;

  friend bool operator==(const Pose&, const Pose&) = default;
};

/// Velocity of a body. Padded to 32 bytes: it is the very row that the solver works on.
struct alignas(32) Velocity {
  Vec3 linear;   ///< of the center of mass, m/s
  Vec3 angular;  ///< rad/s, in world axes
  float padding[2] = {0.0f, 0.0f};
};

}  // namespace scree
