// Polytopes of the evaluator: brute force over faces and edges, with rejections that change no result.
#include "bench/polytope.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace scree::bench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Squared sine between two directions below which their cross product is no axis of its own.
constexpr double kParallelEdges = 1e-12;

// Volume, centroid and inertia from the tetrahedra between the origin and fans over the faces: with corners
// a, b, c their second moments are det/120 (a a' + b b' + c c' + s s'), s = a + b + c.
void integrate(Polytope& polytope) {
  Vector3d first_moment = Vector3d::Zero();
  Matrix3d second_moment = Matrix3d::Zero();
  double volume = 0.0;
  for (const std::vector<int>& loop : polytope.loops) {
    const Vector3d& a = polytope.vertices[static_cast<std::size_t>(loop[0])];
    for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
      const Vector3d& b = polytope.vertices[static_cast<std::size_t>(loop[i])];
      const Vector3d& c = polytope.vertices[static_cast<std::size_t>(loop[i + 1])];
      const Vector3d sum = a + b + c;
      const double det = a.dot(b.cross(c));
      volume += det / 6.0;
      first_moment += det / 24.0 * sum;
      second_moment +=
          det / 120.0 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
    }
  }
  polytope.volume = volume;
  polytope.centroid = first_moment / volume;
  second_moment -= volume * polytope.centroid * polytope.centroid.transpose();
  polytope.inertia = second_moment.trace() * Matrix3d::Identity() - second_moment;
}

// The area vector of a loop (Newell): right for corners that are a little off their plane, too.
Vector3d loop_normal(const Polytope& polytope, const std::vector<int>& loop) {
  const Vector3d& origin = polytope.vertices[static_cast<std::size_t>(loop[0])];
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
    sum += (polytope.vertices[static_cast<std::size_t>(loop[i])] - origin)
               .cross(polytope.vertices[static_cast<std::size_t>(loop[i + 1])] - origin);
  }
  return sum.normalized();
}

void add_edges(Polytope& polytope) {
  std::map<std::pair<int, int>, int> face_of;  // the face whose loop holds the directed edge
  for (std::size_t face = 0; face < polytope.loops.size(); ++face) {
    const std::vector<int>& loop = polytope.loops[face];
    for (std::size_t i = 0; i < loop.size(); ++i) {
      face_of[{loop[i], loop[(i + 1) % loop.size()]}] = static_cast<int>(face);
    }
  }
  for (const auto& [ends, face] : face_of) {
    const auto back = face_of.find({ends.second, ends.first});
    if (ends.first > ends.second || back == face_of.end()) continue;
    const Vector3d arc = polytope.normals[static_cast<std::size_t>(face)].cross(
        polytope.normals[static_cast<std::size_t>(back->second)]);
    polytope.edges.push_back({{ends.first, ends.second}, {face, back->second}, arc});
  }
}

double reach(const std::vector<Vector3d>& vertices, const Vector3d& direction) {
  double best = -std::numeric_limits<double>::infinity();
  for (const Vector3d& vertex : vertices) best = std::max(best, direction.dot(vertex));
  return best;
}

// From corners and loops to the rest.
void finish(Polytope& polytope) {
  integrate(polytope);
  for (Vector3d& vertex : polytope.vertices) vertex -= polytope.centroid;
  for (const std::vector<int>& loop : polytope.loops) {
    polytope.normals.push_back(loop_normal(polytope, loop));
    polytope.offsets.push_back(reach(polytope.vertices, polytope.normals.back()));
  }
  add_edges(polytope);
  polytope.inner_radius = *std::min_element(polytope.offsets.begin(), polytope.offsets.end());
  for (const Vector3d& vertex : polytope.vertices) {
    polytope.outer_radius = std::max(polytope.outer_radius, vertex.norm());
  }
}

// The largest gap over a's faces; stops above `enough`.
double face_gap(const Polytope& a, const std::vector<Vector3d>& vertices_b, double best, double enough) {
  for (std::size_t face = 0; face < a.normals.size(); ++face) {
    best = std::max(best, -reach(vertices_b, -a.normals[face]) - a.offsets[face]);
    if (best > enough) break;
  }
  return best;
}

struct MovedEdge {
  Vector3d point;  // one end
  Vector3d arc;    // as Polytope::Edge
  Vector3d normal[2];
};

std::vector<MovedEdge> moved_edges(const Polytope& polytope, const Eigen::Isometry3d& pose) {
  std::vector<MovedEdge> moved;
  moved.reserve(polytope.edges.size());
  const Matrix3d rotation = pose.linear();
  for (const Polytope::Edge& edge : polytope.edges) {
    moved.push_back({pose * polytope.vertices[static_cast<std::size_t>(edge.vertex[0])],
                     rotation * edge.arc,
                     {rotation * polytope.normals[static_cast<std::size_t>(edge.face[0])],
                      rotation * polytope.normals[static_cast<std::size_t>(edge.face[1])]}});
  }
  return moved;
}

// Two edges make a face of the Minkowski difference where the arc between a's normals crosses the one between
// b's reversed normals on the unit sphere (Gregorius: The Separating Axis Test between Convex Polyhedra,
// 2013).
bool arcs_cross(const MovedEdge& a, const MovedEdge& b) {
  const double b0 = -b.normal[0].dot(a.arc);
  const double b1 = -b.normal[1].dot(a.arc);
  if (b0 * b1 >= 0.0) return false;
  const double a0 = a.normal[0].dot(b.arc);
  const double a1 = a.normal[1].dot(b.arc);
  return a0 * a1 < 0.0 && b0 * a0 < 0.0;
}

double edge_gap(const Polytope& a, const Polytope& b, const Eigen::Isometry3d& pose, double best,
                double enough) {
  const std::vector<MovedEdge> edges_a = moved_edges(a, Eigen::Isometry3d::Identity());
  const std::vector<MovedEdge> edges_b = moved_edges(b, pose);
  for (const MovedEdge& edge_a : edges_a) {
    for (const MovedEdge& edge_b : edges_b) {
      if (!arcs_cross(edge_a, edge_b)) continue;
      Vector3d axis = edge_a.arc.cross(edge_b.arc);
      const double squared = axis.squaredNorm();
      if (squared <= kParallelEdges * edge_a.arc.squaredNorm() * edge_b.arc.squaredNorm()) continue;
      axis /= std::sqrt(squared);
      if (axis.dot(edge_a.point) < 0.0) axis = -axis;  // away from a's centroid, its origin
      best = std::max(best, axis.dot(edge_b.point - edge_a.point));
      if (best > enough) return best;
    }
  }
  return best;
}

bool is_over_face(const Polytope& polytope, std::size_t face, const Vector3d& point) {
  const std::vector<int>& loop = polytope.loops[face];
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vector3d& from = polytope.vertices[static_cast<std::size_t>(loop[i])];
    const Vector3d& to = polytope.vertices[static_cast<std::size_t>(loop[(i + 1) % loop.size()])];
    if (polytope.normals[face].dot((to - from).cross(point - from)) < 0.0) return false;
  }
  return true;
}

}  // namespace

std::shared_ptr<const Polytope> make_polytope(const ConvexHull& hull) {
  auto polytope = std::make_shared<Polytope>();
  for (const Vec3 vertex : hull.hull.vertices()) {
    polytope->vertices.emplace_back(double{vertex.x} * double{hull.scale.x},
                                    double{vertex.y} * double{hull.scale.y},
                                    double{vertex.z} * double{hull.scale.z});
  }
  for (std::size_t face = 0; face < hull.hull.face_count(); ++face) {
    const auto corners = hull.hull.face(face);
    polytope->loops.emplace_back(corners.begin(), corners.end());
  }
  finish(*polytope);
  return polytope;
}

Polytope make_box_polytope(const Eigen::Vector3d& half_extents) {
  Polytope polytope;
  for (int i = 0; i < 8; ++i) {  // bit k of i: the upper side of axis k
    polytope.vertices.emplace_back(i & 1 ? half_extents.x() : -half_extents.x(),
                                   i & 2 ? half_extents.y() : -half_extents.y(),
                                   i & 4 ? half_extents.z() : -half_extents.z());
  }
  polytope.loops = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  finish(polytope);
  return polytope;
}

Polytope make_prism_polytope(const std::array<Vector3d, 3>& corners, const Vector3d& offset) {
  Polytope polytope;
  for (const Vector3d& corner : corners) polytope.vertices.push_back(corner);
  for (const Vector3d& corner : corners) polytope.vertices.push_back(corner + offset);
  polytope.loops = {{0, 1, 2}, {5, 4, 3}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}};
  finish(polytope);
  return polytope;
}

double polytope_gap(const Polytope& a, const Polytope& b, const Eigen::Isometry3d& pose, double enough) {
  const Vector3d center = pose.translation();
  const double apart = center.norm() - a.outer_radius - b.outer_radius;
  if (apart > enough) return apart;
  std::vector<Vector3d> vertices_b;
  vertices_b.reserve(b.vertices.size());
  for (const Vector3d& vertex : b.vertices) vertices_b.push_back(pose * vertex);
  if (center.norm() > 0.0) {  // the axis that separates most separated pairs
    const Vector3d axis = center.normalized();
    const double gap = -reach(vertices_b, -axis) - reach(a.vertices, axis);
    if (gap > enough) return gap;
  }
  double best = face_gap(a, vertices_b, -std::numeric_limits<double>::infinity(), enough);
  if (best > enough) return best;
  const Eigen::Isometry3d back = pose.inverse();
  std::vector<Vector3d> vertices_a;
  vertices_a.reserve(a.vertices.size());
  for (const Vector3d& vertex : a.vertices) vertices_a.push_back(back * vertex);
  best = face_gap(b, vertices_a, best, enough);
  if (best > enough) return best;
  return edge_gap(a, b, pose, best, enough);
}

double segment_distance(const Vector3d& center_a, const Vector3d& half_a, const Vector3d& center_b,
                        const Vector3d& half_b) {
  // Ericson, Real-Time Collision Detection, 5.1.9.
  const Vector3d offset = center_b - center_a;
  const double aa = half_a.squaredNorm();
  const double bb = half_b.squaredNorm();
  const double ab = half_a.dot(half_b);
  const double ao = half_a.dot(offset);
  const double bo = half_b.dot(offset);
  const auto on_segment = [](double value) { return std::clamp(value, -1.0, 1.0); };
  const double determinant = aa * bb - ab * ab;
  double s = determinant > kParallelEdges * aa * bb ? on_segment((ao * bb - ab * bo) / determinant) : 0.0;
  const double t = bb > 0.0 ? on_segment((s * ab - bo) / bb) : 0.0;
  s = aa > 0.0 ? on_segment((ao + t * ab) / aa) : 0.0;
  const double t_again = bb > 0.0 ? on_segment((s * ab - bo) / bb) : 0.0;
  return (offset + t_again * half_b - s * half_a).norm();
}

double segment_gap(const Polytope& polytope, const Vector3d& center, const Vector3d& half_segment) {
  double separation = -std::numeric_limits<double>::infinity();
  for (std::size_t face = 0; face < polytope.normals.size(); ++face) {
    const Vector3d& normal = polytope.normals[face];
    separation = std::max(separation,
                          normal.dot(center) - std::abs(normal.dot(half_segment)) - polytope.offsets[face]);
  }
  const double length_squared = half_segment.squaredNorm();
  for (const Polytope::Edge& edge : polytope.edges) {
    const Vector3d axis = edge.arc.cross(half_segment);
    const double squared = axis.squaredNorm();
    if (length_squared == 0.0 || squared <= kParallelEdges * length_squared * edge.arc.squaredNorm())
      continue;
    const Vector3d unit = axis / std::sqrt(squared);  // along it the segment is a point
    const double along = unit.dot(center);
    separation = std::max(
        {separation, along - reach(polytope.vertices, unit), -along - reach(polytope.vertices, -unit)});
  }
  if (separation <= 0.0) return separation;
  // Apart: the closest points lie on an edge, or an end of the segment is over a face.
  double distance = std::numeric_limits<double>::infinity();
  for (const Polytope::Edge& edge : polytope.edges) {
    const Vector3d& from = polytope.vertices[static_cast<std::size_t>(edge.vertex[0])];
    const Vector3d& to = polytope.vertices[static_cast<std::size_t>(edge.vertex[1])];
    distance =
        std::min(distance, segment_distance(center, half_segment, 0.5 * (from + to), 0.5 * (to - from)));
  }
  for (std::size_t face = 0; face < polytope.normals.size(); ++face) {
    for (const double side : {-1.0, 1.0}) {
      const Vector3d end = center + side * half_segment;
      const double height = polytope.normals[face].dot(end) - polytope.offsets[face];
      if (height > 0.0 && is_over_face(polytope, face, end)) distance = std::min(distance, height);
    }
  }
  return distance;
}

}  // namespace scree::bench
