// Geometry of the evaluator: separating axes for boxes and hulls, closest points for balls and capsules,
// lowest points for half-spaces.
#include "bench/geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace scree::bench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Squared sine between two edges below which their cross product is no axis of its own: the face normals
// already cover parallel edges.
constexpr double kParallel = 1e-12;

double box_reach(const PlacedShape& box, const Vector3d& direction) {
  return (box.axes.transpose() * direction).cwiseAbs().dot(box.half_extents);
}

double gap_along(const PlacedShape& a, const PlacedShape& b, const Vector3d& unit) {
  return std::abs(unit.dot(b.center - a.center)) - box_reach(a, unit) - box_reach(b, unit);
}

// Separating axes: for two convex polytopes the depth is the smallest overlap over all face normals and all
// cross products of edges (Gottschalk, Lin, Manocha: OBBTree, 1996).
double box_box_gap(const PlacedShape& a, const PlacedShape& b) {
  double best = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    best = std::max(best, gap_along(a, b, a.axes.col(i)));
    best = std::max(best, gap_along(a, b, b.axes.col(i)));
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Vector3d axis = a.axes.col(i).cross(b.axes.col(j));
      const double squared = axis.squaredNorm();
      if (squared > kParallel) best = std::max(best, gap_along(a, b, axis / std::sqrt(squared)));
    }
  }
  return best;
}

// Distance of a segment that misses the box: the squared distance along the segment is convex and piecewise
// quadratic, so the root of its derivative lies between two neighboring breakpoints.
double box_segment_distance(const Vector3d& half_extents, const Vector3d& center,
                            const Vector3d& half_segment) {
  const auto slope =
      [&](double t) {  // half the derivative of the squared distance at center + t half_segment
        double sum = 0.0;
        for (int k = 0; k < 3; ++k) {
          const double p = center[k] + t * half_segment[k];
          sum += (p - std::clamp(p, -half_extents[k], half_extents[k])) * half_segment[k];
        }
        return sum;
      };
  double before = -1.0;  // the bracket: breakpoints left and right of the root, closing in
  double after = 1.0;
  const auto close_in = [&](double t) {
    if (std::abs(t) >= 1.0) return;
    if (slope(t) < 0.0) {
      before = std::max(before, t);
    } else {
      after = std::min(after, t);
    }
  };
  for (int k = 0; k < 3; ++k) {
    if (half_segment[k] == 0.0) continue;
    close_in((-half_extents[k] - center[k]) / half_segment[k]);
    close_in((half_extents[k] - center[k]) / half_segment[k]);
  }
  const double left = slope(before);
  const double right = slope(after);
  double nearest = before;
  if (right <= 0.0) {
    nearest = after;
  } else if (left < 0.0) {
    nearest = before - left / (right - left) * (after - before);
  }
  const Vector3d point = center + nearest * half_segment;
  return (point - point.cwiseMax(-half_extents).cwiseMin(half_extents)).norm();
}

double box_round_gap(const PlacedShape& box, const PlacedShape& round) {
  const Vector3d center = box.axes.transpose() * (round.center - box.center);
  const Vector3d half_segment = box.axes.transpose() * round.half_segment;
  const double length_squared = half_segment.squaredNorm();
  double separation = (center.cwiseAbs() - box.half_extents - half_segment.cwiseAbs()).maxCoeff();
  for (int k = 0; k < 3; ++k) {
    const Vector3d axis = Vector3d::Unit(k).cross(half_segment);
    const double squared = axis.squaredNorm();
    if (squared <= kParallel * length_squared || squared == 0.0) continue;
    const double reach = box.half_extents.dot(axis.cwiseAbs());  // the segment is a point along this axis
    separation = std::max(separation, (std::abs(center.dot(axis)) - reach) / std::sqrt(squared));
  }
  if (separation <= 0.0) return separation - round.radius;
  return box_segment_distance(box.half_extents, center, half_segment) - round.radius;
}

// The pose of b's frame in a's.
Eigen::Isometry3d relative_pose(const PlacedShape& a, const PlacedShape& b) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = a.axes.transpose() * b.axes;
  pose.translation() = a.axes.transpose() * (b.center - a.center);
  return pose;
}

double hull_gap(const PlacedShape& hull, const PlacedShape& other, double enough) {
  const Eigen::Isometry3d pose = relative_pose(hull, other);
  if (other.polytope) return polytope_gap(*hull.polytope, *other.polytope, pose, enough);
  if (other.is_box) return polytope_gap(*hull.polytope, make_box_polytope(other.half_extents), pose, enough);
  const Vector3d half_segment = hull.axes.transpose() * other.half_segment;
  const double apart =
      pose.translation().norm() - half_segment.norm() - other.radius - hull.polytope->outer_radius;
  if (apart > enough) return apart;
  return segment_gap(*hull.polytope, pose.translation(), half_segment) - other.radius;
}

// Of a mesh and a convex shape.
double mesh_gap(const PlacedShape& mesh, const PlacedShape& other, double enough) {
  const Eigen::Isometry3d pose = relative_pose(mesh, other);
  if (other.polytope) return surface_gap(*mesh.surface, *other.polytope, pose, enough);
  if (other.is_box) return surface_gap(*mesh.surface, make_box_polytope(other.half_extents), pose, enough);
  return surface_gap(*mesh.surface, pose.translation(), mesh.axes.transpose() * other.half_segment,
                     other.radius, enough);
}

double half_space_gap(const PlacedShape& half_space, const PlacedShape& other) {
  const Vector3d normal = half_space.axes.col(1);
  return lowest_along(other, normal) - normal.dot(half_space.center);
}

// Bounds of a box of the shape's frame.
void set_bounds(PlacedShape& shape, const Eigen::AlignedBox3d& box) {
  const Vector3d middle = shape.center + shape.axes * box.center();
  const Vector3d reach = shape.axes.cwiseAbs() * (0.5 * box.sizes());
  shape.lower = middle - reach;
  shape.upper = middle + reach;
}

// Half of the size of the shape's bounds.
Vector3d reach_of(const PlacedShape& shape) {
  if (shape.is_box) return shape.axes.cwiseAbs() * shape.half_extents;
  return shape.half_segment.cwiseAbs().array() + shape.radius;
}

}  // namespace

Eigen::Vector3d to_double(Vec3 vector) { return {double{vector.x}, double{vector.y}, double{vector.z}}; }

Eigen::Quaterniond to_double(Quat rotation) {
  return Eigen::Quaterniond(double{rotation.w}, double{rotation.x}, double{rotation.y}, double{rotation.z})
      .normalized();
}

PlacedShape place(const Geometry& geometry, const Pose& local_pose, const Pose& body_pose,
                  std::shared_ptr<const Polytope> polytope, std::shared_ptr<const Surface> surface) {
  PlacedShape shape;
  const Eigen::Quaterniond body_rotation = to_double(body_pose.rotation);
  shape.center = to_double(body_pose.position) + body_rotation * to_double(local_pose.position);
  shape.axes = (body_rotation * to_double(local_pose.rotation)).toRotationMatrix();
  if (const auto* hull = std::get_if<ConvexHull>(&geometry)) {
    shape.polytope = polytope ? std::move(polytope) : make_polytope(*hull);
    shape.center += shape.axes * shape.polytope->centroid;
    shape.lower = shape.upper = shape.center + shape.axes * shape.polytope->vertices.front();
    for (const Vector3d& vertex : shape.polytope->vertices) {
      const Vector3d corner = shape.center + shape.axes * vertex;
      shape.lower = shape.lower.cwiseMin(corner);
      shape.upper = shape.upper.cwiseMax(corner);
    }
    return shape;
  }
  if (const auto* mesh = std::get_if<TriangleMesh>(&geometry)) {
    shape.surface = surface ? std::move(surface) : make_surface(*mesh);
    set_bounds(shape, shape.surface->nodes.front().bounds);
    return shape;
  }
  if (std::holds_alternative<HalfSpace>(geometry)) {
    shape.is_half_space = true;
    shape.upper.setConstant(std::numeric_limits<double>::infinity());
    shape.lower = -shape.upper;
    return shape;
  }
  if (const auto* box = std::get_if<Box>(&geometry)) {
    shape.is_box = true;
    shape.half_extents = to_double(box->half_extents);
  } else if (const auto* capsule = std::get_if<Capsule>(&geometry)) {
    shape.half_segment = shape.axes.col(1) * double{capsule->half_height};
    shape.radius = double{capsule->radius};
  } else {
    shape.radius = double{std::get<Sphere>(geometry).radius};
  }
  const Vector3d reach = reach_of(shape);
  shape.lower = shape.center - reach;
  shape.upper = shape.center + reach;
  return shape;
}

double lowest_along(const PlacedShape& shape, const Vector3d& direction) {
  const double middle = direction.dot(shape.center);
  if (shape.is_box) return middle - box_reach(shape, direction);
  if (!shape.polytope) return middle - std::abs(direction.dot(shape.half_segment)) - shape.radius;
  double least = std::numeric_limits<double>::infinity();
  const Vector3d seen = shape.axes.transpose() * direction;
  for (const Vector3d& vertex : shape.polytope->vertices) least = std::min(least, seen.dot(vertex));
  return middle + least;
}

double signed_gap(const PlacedShape& a, const PlacedShape& b, double enough) {
  if (!a.is_convex() && !b.is_convex()) return std::numeric_limits<double>::infinity();
  if (!a.is_convex()) return signed_gap(b, a, enough);
  if (b.is_half_space) return half_space_gap(b, a);
  if (b.surface) return mesh_gap(b, a, enough);
  if (a.polytope) return hull_gap(a, b, enough);
  if (b.polytope) return hull_gap(b, a, enough);
  if (a.is_box && b.is_box) return box_box_gap(a, b);
  if (a.is_box) return box_round_gap(a, b);
  if (b.is_box) return box_round_gap(b, a);
  return segment_distance(a.center, a.half_segment, b.center, b.half_segment) - a.radius - b.radius;
}

}  // namespace scree::bench
