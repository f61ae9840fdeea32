// Convex polyhedra against each other as a reference for tests: all separating axes, scalar, in double
// precision.
#pragma once

#include <core/geometry/hull/hull_topology.h>
#include <core/geometry/reference/collide.h>

#include <utility>

namespace scree::reference {

// A convex polyhedron in the world.
struct Polyhedron {
  struct Edge {
    Vector point, along, normal_0, normal_1;
  };
  std::vector<Vector> vertices;
  std::vector<Vector> normals;
  std::vector<double> offsets;
  std::vector<Edge> edges;
  double radius = 0.0;  // of the ball about the frame's origin that encloses the polyhedron
};

// The hull at a pose, relative to `origin` (positions far from the world's origin keep their precision).
inline Polyhedron make_polyhedron(const HullTopology& hull, const PoseRow& pose, const Vector& origin) {
  const float* q = pose.rotation;
  const Eigen::Matrix3d turn = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix();
  const Vector position = Vector(pose.position[0], pose.position[1], pose.position[2]) - origin;
  Polyhedron p;
  for (const Vec3& v : hull.vertices) {
    p.vertices.push_back(turn * Vector(v.x, v.y, v.z) + position);
    p.radius = std::max(p.radius, Vector(v.x, v.y, v.z).norm());
  }
  for (std::size_t f = 0; f < hull.planes.size(); ++f) {
    const float* n = hull.planes[f].normal;
    p.normals.push_back((turn * Vector(n[0], n[1], n[2])).normalized());
    double offset = -1e300;
    for (const Vector& v : p.vertices) offset = std::max(offset, p.normals.back().dot(v));
    p.offsets.push_back(offset);
  }
  for (const HullTopology::Edge& e : hull.edges) {
    const Vector begin = p.vertices[e.vertex[0]], end = p.vertices[e.vertex[1]];
    p.edges.push_back({begin, end - begin, p.normals[e.face[0]], p.normals[e.face[1]]});
  }
  return p;
}

inline double farthest(const Polyhedron& p, const Vector& axis) {
  double result = -1e300;
  for (const Vector& v : p.vertices) result = std::max(result, axis.dot(v));
  return result;
}
// Gap along an axis from the first polyhedron to the second.
inline double gap_of_axis(const Polyhedron& a, const Polyhedron& b, const Vector& axis) {
  return -farthest(b, -axis) - farthest(a, axis);
}

// Largest height of a point above the polyhedron's planes; negative inside.
inline double distance_beyond(const Polyhedron& p, const Vector& point) {
  double result = -1e300;
  for (std::size_t f = 0; f < p.normals.size(); ++f) {
    result = std::max(result, p.normals[f].dot(point) - p.offsets[f]);
  }
  return result;
}

// Whether two edges may span a face of the Minkowski difference, with `slack` for rounding.
inline bool may_cross(const Polyhedron::Edge& a, const Polyhedron::Edge& b, double slack) {
  const double c = b.normal_0.dot(a.along), d = b.normal_1.dot(a.along);
  const double e = a.normal_0.dot(b.along), f = a.normal_1.dot(b.along);
  return c * d < slack && e * f < slack && c * f < slack;
}

// Axes closer than 0.08 degrees count as one in the search for a runner-up.
inline constexpr double kSameAxis = 0.999999;

// Best separating axis among all face normals and all cross products of edges. All vertices measure every
// candidate; `sift` only drops pairs of edges that cannot touch.
inline Gap polyhedra_gap(const Polyhedron& a, const Polyhedron& b, bool sift = true) {
  std::vector<std::pair<double, Vector>> gaps;
  for (const Vector& n : a.normals) gaps.emplace_back(gap_of_axis(a, b, n), n);
  for (const Vector& n : b.normals) gaps.emplace_back(gap_of_axis(a, b, -n), -n);
  for (const Polyhedron::Edge& one : a.edges) {
    for (const Polyhedron::Edge& two : b.edges) {
      if (sift && !may_cross(one, two, 1e-12)) continue;
      const Vector product = one.along.cross(two.along);
      if (product.norm() < 1e-7 * one.along.norm() * two.along.norm()) continue;
      const Vector axis = product.normalized();
      for (const Vector& way : {axis, Vector(-axis)}) gaps.emplace_back(gap_of_axis(a, b, way), way);
    }
  }
  Gap best;
  best.separation = -std::numeric_limits<double>::infinity();
  for (const auto& [gap, axis] : gaps) {
    if (gap <= best.separation) continue;
    best.separation = gap;
    best.normal = axis;
  }
  for (const auto& [gap, axis] : gaps) {
    if (axis.dot(best.normal) < kSameAxis) best.runner_up = std::max(best.runner_up, gap);
  }
  return best;
}

}  // namespace scree::reference
