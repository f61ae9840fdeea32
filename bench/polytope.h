// Convex polyhedra of the evaluator: corners, faces and edges in double precision, about the centroid.
#pragma once

#include <scree/scree.h>

#include <Eigen/Geometry>

#include <array>
#include <memory>
#include <vector>

namespace scree::bench {

/// Lengths in m; directions and offsets in the polytope's own frame, whose origin is the centroid.
struct Polytope {
  struct Edge {
    int vertex[2];
    int face[2];  ///< on either side
    Eigen::Vector3d
        arc;  ///< normal of the arc between the faces' normals: along the edge, not of unit length
  };

  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::vector<int>> loops;   ///< corners of each face, counterclockwise seen from outside
  std::vector<Eigen::Vector3d> normals;  ///< of each face, of unit length, outward
  std::vector<double> offsets;           ///< of each face: the largest normal . vertex of all vertices
  std::vector<Edge> edges;
  Eigen::Vector3d centroid;   ///< in the frame that the shape was given in
  double volume = 0.0;        ///< m^3
  Eigen::Matrix3d inertia;    ///< about the centroid, for unit density
  double inner_radius = 0.0;  ///< of the largest ball about the centroid within
  double outer_radius = 0.0;  ///< of the smallest ball about the centroid around
};

/// The scaled hull. Takes the faces from the hull, but computes planes, volume and inertia here: a missing or
/// skewed face makes overlaps look deeper, never shallower.
std::shared_ptr<const Polytope> make_polytope(const ConvexHull& hull);
Polytope make_box_polytope(const Eigen::Vector3d& half_extents);
/// The prism between a triangle, counterclockwise seen from outside, and its copy at `offset` behind it.
Polytope make_prism_polytope(const std::array<Eigen::Vector3d, 3>& corners, const Eigen::Vector3d& offset);

/// The largest gap along the normals of faces and the cross products of edges that are normals of the
/// Minkowski difference. `pose` brings b's frame to a's. Exact for overlapping polytopes; a lower bound for
/// others. Any gap above `enough` ends the search.
double polytope_gap(const Polytope& a, const Polytope& b, const Eigen::Isometry3d& pose, double enough);

/// The signed distance of a polytope and a segment center +- half_segment; exact. A ball's has no length.
double segment_gap(const Polytope& polytope, const Eigen::Vector3d& center,
                   const Eigen::Vector3d& half_segment);

/// Of two segments, each given by its center and half of its vector.
double segment_distance(const Eigen::Vector3d& center_a, const Eigen::Vector3d& half_a,
                        const Eigen::Vector3d& center_b, const Eigen::Vector3d& half_b);

}  // namespace scree::bench
