// Spheres and capsules against hulls as a reference for tests: scalar, in double precision, by testing all
// features.
//
// Reads a hull's corners and the loops of its faces, not the planes and columns that the kernels read.
#pragma once

#include <core/geometry/reference/collide.h>

#include <algorithm>

namespace scree::reference {

// In world axes.
struct FacedHull {
  std::vector<Vector> corners;
  std::vector<std::vector<int>> faces;  // counterclockwise seen from outside
  std::vector<Vector> normals;          // of the faces, unit, outward
};

inline Vector normal_of(const std::vector<Vector>& corners, const std::vector<int>& loop) {
  // Newell's sum, about the first corner.
  Vector sum = Vector::Zero();
  const auto corner = [&](std::size_t k) -> const Vector& {
    return corners[static_cast<std::size_t>(loop[k])];
  };
  for (std::size_t k = 1; k + 1 < loop.size(); ++k) {
    sum += (corner(k) - corner(0)).cross(corner(k + 1) - corner(0));
  }
  return sum.normalized();
}

// `corners` about the hull's centroid, placed by a shape's pose.
inline FacedHull make_faced_hull(const std::vector<Vector>& corners,
                                 const std::vector<std::vector<int>>& faces, const PoseRow& pose) {
  const float* q = pose.rotation;
  const Eigen::Matrix3d rotation = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix();
  const Vector position(pose.position[0], pose.position[1], pose.position[2]);
  FacedHull hull;
  for (const Vector& corner : corners) hull.corners.push_back(position + rotation * corner);
  hull.faces = faces;
  for (const std::vector<int>& face : faces) hull.normals.push_back(normal_of(hull.corners, face));
  return hull;
}

// Closest point of a triangle to x: the projection of x where it lies within, else the closest point of a
// side.
inline Vector closest_on_triangle(const Vector (&corner)[3], const Vector& x) {
  const Vector normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  bool within = normal.squaredNorm() > 0.0;
  Vector best = corner[0];
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Vector& begin = corner[k];
    const Vector side = corner[(k + 1) % 3] - begin;
    within = within && side.cross(x - begin).dot(normal) >= 0.0;
    const double length_2 = side.squaredNorm();
    const double t = length_2 > 0.0 ? std::clamp(side.dot(x - begin) / length_2, 0.0, 1.0) : 0.0;
    const Vector point = begin + t * side;
    if ((x - point).squaredNorm() >= least) continue;
    least = (x - point).squaredNorm();
    best = point;
  }
  return within ? Vector(x - normal * ((x - corner[0]).dot(normal) / normal.squaredNorm())) : best;
}

// Largest height of a point above the face planes; below zero in the hull.
inline double height_over_faces(const FacedHull& hull, const Vector& x) {
  double height = -std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < hull.faces.size(); ++f) {
    const Vector& corner = hull.corners[static_cast<std::size_t>(hull.faces[f][0])];
    height = std::max(height, hull.normals[f].dot(x - corner));
  }
  return height;
}

// Closest point of a hull to x; x itself in the hull.
inline Vector closest_on_hull(const FacedHull& hull, const Vector& x) {
  if (height_over_faces(hull, x) <= 0.0) return x;
  Vector best = hull.corners[0];
  for (const std::vector<int>& face : hull.faces) {
    const auto corner = [&](std::size_t k) { return hull.corners[static_cast<std::size_t>(face[k])]; };
    for (std::size_t k = 1; k + 1 < face.size(); ++k) {
      const Vector triangle[3] = {corner(0), corner(k), corner(k + 1)};
      const Vector point = closest_on_triangle(triangle, x);
      if ((point - x).squaredNorm() < (best - x).squaredNorm()) best = point;
    }
  }
  return best;
}
inline double distance_to_surface(const FacedHull& hull, const Vector& x) {
  const double height = height_over_faces(hull, x);
  return height <= 0.0 ? height : (closest_on_hull(hull, x) - x).norm();
}

// Shortest way out of a hull for a segment that passes through it: the best of all face normals and of all
// cross products of edges with the segment, each measured with all corners.
inline Gap leave_hull(const std::vector<Vector>& ends, double radius, const FacedHull& hull) {
  std::vector<Vector> axes;
  for (const Vector& normal : hull.normals) axes.push_back(-normal);
  const Vector along = ends.back() - ends.front();
  for (const std::vector<int>& face : hull.faces) {
    for (std::size_t k = 0; k < face.size(); ++k) {
      const int begin = face[k], end = face[(k + 1) % face.size()];
      if (begin > end) continue;
      const Vector edge =
          hull.corners[static_cast<std::size_t>(end)] - hull.corners[static_cast<std::size_t>(begin)];
      const Vector axis = along.cross(edge);
      if (axis.norm() > 1e-4 * along.norm() * edge.norm()) axes.push_back(axis.normalized());
    }
  }
  Gap best;
  best.separation = -std::numeric_limits<double>::infinity();
  std::vector<std::pair<double, Vector>> gaps;
  for (Vector axis : axes) {
    const double gap = gap_along(ends, hull.corners, axis) - radius;
    gaps.emplace_back(gap, axis);
    if (gap <= best.separation) continue;
    best.separation = gap;
    best.normal = axis;
  }
  constexpr double kSameDirection = 1.0 - 1.5e-6;  // cosine of 0.1 degrees
  for (const auto& [gap, axis] : gaps) {
    if (axis.dot(best.normal) < kSameDirection) best.runner_up = std::max(best.runner_up, gap);
  }
  return best;
}

// Gap from a sphere or capsule to a hull. `core` is the distance of the round shape's core from the hull,
// zero where the core passes through.
inline Gap gap_to_hull(const Solid& round, const FacedHull& hull, double& core) {
  const Vector along =
      round.type == ShapeType::capsule ? Vector(round.rotation.col(1) * round.half.y()) : Vector::Zero();
  const auto distance = [&](double t) {
    return std::max(distance_to_surface(hull, round.position + t * along), 0.0);
  };
  const Vector x = round.position + (along.isZero(0.0) ? 0.0 : minimize(distance)) * along;
  const Vector way = closest_on_hull(hull, x) - x;
  core = way.norm();
  if (core <= 1e-9 * (round.radius + along.norm())) {
    core = 0.0;
    return leave_hull(corners(round), round.radius, hull);
  }
  Gap gap;
  gap.separation = core - round.radius;
  gap.normal = way / core;
  return gap;
}

}  // namespace scree::reference
