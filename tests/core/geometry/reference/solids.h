// Solids of the reference geometry at known and at random places, and an independent measure of gaps.
#pragma once

#include <core/geometry/reference/collide.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <vector>

namespace scree::reference_tests {

using reference::Gap;
using reference::Solid;
using reference::Vector;

inline Solid sphere(double radius, const Vector& position) {
  Solid solid;
  solid.radius = radius;
  solid.position = position;
  return solid;
}
inline Solid capsule(double half_height, double radius, const Vector& position,
                     const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity()) {
  return {ShapeType::capsule, {0.0, half_height, 0.0}, radius, position, rotation};
}
inline Solid box(const Vector& half, const Vector& position,
                 const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity()) {
  return {ShapeType::box, half, 0.0, position, rotation};
}
inline Eigen::Matrix3d turn_about(const Vector& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

struct Random {
  std::mt19937_64 engine;
  explicit Random(unsigned seed) : engine(seed) {}
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  Vector vector(double size) {
    const double x = between(-size, size), y = between(-size, size);
    return {x, y, between(-size, size)};
  }
  Eigen::Matrix3d turn() {
    const Vector axis = vector(1.0);
    return turn_about(axis, between(-3.0, 3.0));
  }
  // Near the origin: two of them overlap about as often as not.
  Solid solid(ShapeType type) {
    const Vector position = vector(1.2);
    if (type == ShapeType::sphere) return sphere(between(0.2, 1.0), position);
    if (type == ShapeType::capsule) return capsule(between(0.3, 1.5), between(0.1, 0.6), position, turn());
    const Vector half(between(0.3, 1.2), between(0.3, 1.2), between(0.3, 1.2));
    return box(half, position, turn());
  }
};

inline constexpr ShapeType kTypes[] = {ShapeType::sphere, ShapeType::capsule, ShapeType::box};

// The gap along a direction from a to b, from support functions.
inline double reach(const Solid& solid, const Vector& direction) {
  const Vector local = solid.rotation.transpose() * direction;
  return direction.dot(solid.position) + local.cwiseAbs().dot(solid.half) + solid.radius;
}
inline double gap_of(const Solid& a, const Solid& b, const Vector& direction) {
  return -reach(b, -direction) - reach(a, direction);
}

// Spread evenly over the sphere, on a spiral.
inline std::vector<Vector> directions(std::size_t count) {
  std::vector<Vector> result;
  const double turn = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (std::size_t i = 0; i < count; ++i) {
    const double y = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count);
    const double angle = turn * static_cast<double>(i), radius = std::sqrt(1.0 - y * y);
    result.emplace_back(radius * std::cos(angle), y, radius * std::sin(angle));
  }
  return result;
}

}  // namespace scree::reference_tests
