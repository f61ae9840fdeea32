// The geometry of the narrow phase as a reference for tests: scalar, in double precision, by different and
// slower methods.
#pragma once

#include <core/world/world_data.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace scree::reference {

using Vector = Eigen::Vector3d;

// A convex core (point, segment or box) and a radius around it.
struct Solid {
  ShapeType type = ShapeType::sphere;
  Vector half = Vector::Zero();
  double radius = 0.0;
  Vector position = Vector::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
};

inline Solid make_solid(ShapeType type, const ExtentRow& extent, const PoseRow& pose) {
  const float* q = pose.rotation;
  Solid solid;
  solid.type = type;
  if (type == ShapeType::capsule) solid.half = Vector(0.0, extent.half[1], 0.0);
  if (type == ShapeType::box) solid.half = Vector(extent.half[0], extent.half[1], extent.half[2]);
  if (type != ShapeType::box) solid.radius = extent.radius;
  solid.position = Vector(pose.position[0], pose.position[1], pose.position[2]);
  solid.rotation = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix();
  return solid;
}

// Signed gap between two solids, and the unit normal from the first to the second along which it is measured.
// `runner_up` is the best gap along an axis of clearly different direction: where it is equally good, the
// normal is not unique. For boxes that are apart the gap is that of the best separating axis, which is at
// most the true distance.
struct Gap {
  double separation = 0.0;
  Vector normal = Vector::UnitY();
  double runner_up = -std::numeric_limits<double>::infinity();
};

// Corners of a solid's core: 1, 2 or 8.
inline std::vector<Vector> corners(const Solid& solid) {
  if (solid.type == ShapeType::sphere) return {solid.position};
  const Vector y = solid.rotation.col(1) * solid.half.y();
  if (solid.type == ShapeType::capsule) return {solid.position - y, solid.position + y};
  std::vector<Vector> result;
  for (int k = 0; k < 8; ++k) {
    const Vector sign((k & 1) != 0 ? 1.0 : -1.0, (k & 2) != 0 ? 1.0 : -1.0, (k & 4) != 0 ? 1.0 : -1.0);
    result.push_back(solid.position + solid.rotation * sign.cwiseProduct(solid.half));
  }
  return result;
}

// Distance of a point from a solid's core, zero inside.
inline double distance_to_core(const Solid& solid, const Vector& point) {
  const Vector local = solid.rotation.transpose() * (point - solid.position);
  return (local - local.cwiseMax(-solid.half).cwiseMin(solid.half)).norm();
}

// Signed distance of a point from a solid's surface, negative inside a box.
inline double distance_to_surface(const Solid& solid, const Vector& point) {
  const Vector local = solid.rotation.transpose() * (point - solid.position);
  const double inside = solid.type == ShapeType::box ? (local.cwiseAbs() - solid.half).maxCoeff() : 0.0;
  return inside < 0.0 ? inside : distance_to_core(solid, point) - solid.radius;
}

// Gap of the cores along an axis, from projections of all corners; the normal has the direction of the larger
// gap.
inline double gap_along(const std::vector<Vector>& a, const std::vector<Vector>& b, Vector& axis) {
  double a_low = 1e300, a_high = -1e300, b_low = 1e300, b_high = -1e300;
  for (const Vector& corner : a) {
    a_low = std::min(a_low, axis.dot(corner));
    a_high = std::max(a_high, axis.dot(corner));
  }
  for (const Vector& corner : b) {
    b_low = std::min(b_low, axis.dot(corner));
    b_high = std::max(b_high, axis.dot(corner));
  }
  if (b_low - a_high >= a_low - b_high) return b_low - a_high;
  axis = -axis;
  return a_low - b_high;
}

// Best separating axis among face normals and cross products of edges. Solids without faces contribute their
// segment only.
inline Gap best_axis(const Solid& a, const Solid& b) {
  std::vector<Vector> edges_a, edges_b, axes;
  const auto collect = [&](const Solid& solid, std::vector<Vector>& edges) {
    for (int k = 0; k < 3; ++k) {
      if (solid.type == ShapeType::box) axes.push_back(solid.rotation.col(k));
      if (solid.type == ShapeType::box || (solid.type == ShapeType::capsule && k == 1)) {
        edges.push_back(solid.rotation.col(k));
      }
    }
  };
  collect(a, edges_a);
  collect(b, edges_b);
  for (const Vector& edge_a : edges_a) {
    for (const Vector& edge_b : edges_b) {
      const Vector axis = edge_a.cross(edge_b);
      if (axis.norm() > 3e-3) axes.push_back(axis.normalized());
    }
  }
  const std::vector<Vector> corners_a = corners(a), corners_b = corners(b);
  Gap best;
  best.separation = -std::numeric_limits<double>::infinity();
  std::vector<std::pair<double, Vector>> gaps;
  for (Vector axis : axes) {
    const double gap = gap_along(corners_a, corners_b, axis);
    gaps.emplace_back(gap, axis);
    if (gap > best.separation) {
      best.separation = gap;
      best.normal = axis;
    }
  }
  for (const auto& [gap, axis] : gaps) {
    if (axis.dot(best.normal) < 0.999) best.runner_up = std::max(best.runner_up, gap);
  }
  best.separation -= a.radius + b.radius;
  best.runner_up -= a.radius + b.radius;
  return best;
}

// Minimizer of a convex function on [-1, 1], by golden-section search.
template <class Function>
double minimize(Function&& function) {
  const double ratio = (std::sqrt(5.0) - 1.0) / 2.0;
  double low = -1.0, high = 1.0;
  for (int k = 0; k < 60; ++k) {
    const double left = high - ratio * (high - low), right = low + ratio * (high - low);
    if (function(left) <= function(right)) {
      high = right;
    } else {
      low = left;
    }
  }
  return 0.5 * (low + high);
}

// A sphere or capsule against any solid: the closest point of its segment, or the best axis where the segment
// passes through a box.
inline Gap gap_of_round(const Solid& a, const Solid& b) {
  const Vector along = a.type == ShapeType::capsule ? Vector(a.rotation.col(1) * a.half.y()) : Vector::Zero();
  const auto distance = [&](double t) { return distance_to_core(b, a.position + t * along); };
  const Vector x = a.position + minimize(distance) * along;
  const Vector local = b.rotation.transpose() * (x - b.position);
  const Vector difference = b.rotation * local.cwiseMax(-b.half).cwiseMin(b.half) + b.position - x;
  if (difference.norm() > 1e-7 * (a.radius + b.radius)) {
    Gap gap;
    gap.separation = difference.norm() - a.radius - b.radius;
    gap.normal = difference.normalized();
    return gap;
  }
  return best_axis(a, b);
}

inline Gap find_gap(const Solid& a, const Solid& b) {
  if (a.type != ShapeType::box) return gap_of_round(a, b);
  if (b.type == ShapeType::box) return best_axis(a, b);
  Gap gap = gap_of_round(b, a);
  gap.normal = -gap.normal;
  return gap;
}

}  // namespace scree::reference
