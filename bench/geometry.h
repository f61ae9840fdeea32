// Geometry of the evaluator: signed gaps between placed shapes, in double precision.
//
// Used only by the evaluator. It shares no code with the engine under test, so that an error in the engine's
// collision cannot hide in the figures that evaluate it.
#pragma once

#include "bench/polytope.h"
#include "bench/surface.h"

#include <scree/scree.h>

#include <Eigen/Geometry>

#include <limits>
#include <memory>

namespace scree::bench {

Eigen::Vector3d to_double(Vec3 vector);
Eigen::Quaterniond to_double(Quat rotation);  ///< renormalized

/// A shape at its place in the world: a box, a hull, a mesh, a half-space, or a segment with a radius, which
/// is a capsule or, without length, a ball.
struct PlacedShape {
  bool is_box = false;
  bool is_half_space = false;              ///< all below the plane through the center, across the second axis
  std::shared_ptr<const Surface> surface;  ///< of a mesh
  std::shared_ptr<const Polytope> polytope;                ///< of a hull
  Eigen::Vector3d center = Eigen::Vector3d::Zero();        ///< of a hull: its centroid
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();      ///< columns: the shape's axes
  Eigen::Vector3d half_extents = Eigen::Vector3d::Zero();  ///< of a box
  Eigen::Vector3d half_segment = Eigen::Vector3d::Zero();  ///< from center to one end, world axes
  double radius = 0.0;                                     ///< 0 for all but segments
  Eigen::Vector3d lower = Eigen::Vector3d::Zero();         ///< bounds, infinite for a half-space
  Eigen::Vector3d upper = Eigen::Vector3d::Zero();

  bool is_convex() const { return !surface && !is_half_space; }
};

/// Places a shape of a body. `polytope` is the result of make_polytope for a hull, `surface` that of
/// make_surface for a mesh; if missing, they are made.
PlacedShape place(const Geometry& geometry, const Pose& local_pose, const Pose& body_pose,
                  std::shared_ptr<const Polytope> polytope = nullptr,
                  std::shared_ptr<const Surface> surface = nullptr);

/// The lowest of a convex shape's points along a unit direction: the least product with it.
double lowest_along(const PlacedShape& shape, const Eigen::Vector3d& direction);

/// The signed distance of two shapes, of which one is convex; exact for half-spaces, and for meshes what
/// surface_gap says. For convex ones: Negative when they overlap: minus the shortest separating translation
/// (exact for all pairs). Positive when they are apart: exact for pairs with a ball or capsule, a lower bound
/// (the largest gap along a separating axis) between boxes and hulls. The search may end with any lower bound
/// above `enough`. Infinite where neither is convex.
double signed_gap(const PlacedShape& a, const PlacedShape& b,
                  double enough = std::numeric_limits<double>::infinity());

}  // namespace scree::bench
