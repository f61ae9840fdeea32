// Conversions for users of Eigen. The library itself has no Eigen type in its interface; this header needs
// Eigen on the user's include path.
#pragma once

#include <scree/body.h>
#include <scree/math_types.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace scree {

/// The same vector.
inline Eigen::Vector3f to_eigen(const Vec3& v) { return {v.x, v.y, v.z}; }
/// The same rotation.
inline Eigen::Quaternionf to_eigen(const Quat& q) { return {q.w, q.x, q.y, q.z}; }
/// The same placement as a transformation.
inline Eigen::Isometry3f to_eigen(const Pose& pose) {
  Eigen::Isometry3f transform = Eigen::Isometry3f::Identity();
  transform.linear() = to_eigen(pose.rotation).toRotationMatrix();
  transform.translation() = to_eigen(pose.position);
  return transform;
}

/// The same vector.
inline Vec3 from_eigen(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }
/// The same rotation.
inline Quat from_eigen(const Eigen::Quaternionf& q) { return {q.x(), q.y(), q.z(), q.w()}; }
/// The same placement; its rotation is normalized.
inline Pose from_eigen(const Eigen::Isometry3f& transform) {
  const Eigen::Matrix3f rotation = transform.linear();
  return {from_eigen(Eigen::Vector3f(transform.translation())),
          from_eigen(Eigen::Quaternionf(rotation).normalized())};
}

/// The inertia of mass properties as a matrix.
inline Eigen::Matrix3f inertia_matrix(const MassProperties& properties) {
  const float* i = properties.inertia;
  Eigen::Matrix3f matrix;
  matrix << i[0], i[3], i[4], i[3], i[1], i[5], i[4], i[5], i[2];
  return matrix;
}

/// Mass properties from a symmetric inertia matrix about the center of mass.
inline MassProperties mass_properties(float mass, const Eigen::Vector3f& center,
                                      const Eigen::Matrix3f& inertia) {
  return {
      .mass = mass,
      .center = from_eigen(center),
      .inertia = {inertia(0, 0), inertia(1, 1), inertia(2, 2), inertia(0, 1), inertia(0, 2), inertia(1, 2)}};
}

}  // namespace scree
