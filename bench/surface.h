// Triangle meshes of the evaluator: their triangles in double precision, and how deep a convex body is in
// them.
//
// Triangles are found by a tree of their own; the engine's is not asked.
#pragma once

#include "bench/polytope.h"

#include <scree/scree.h>

#include <Eigen/Geometry>

#include <array>
#include <memory>
#include <vector>

namespace scree::bench {

/// The triangles of a mesh in its own frame, m, and a tree of boxes over them.
struct Surface {
  struct Triangle {
    std::array<Eigen::Vector3d, 3> corners;
    Eigen::Vector3d normal;  ///< of unit length, to the front
  };
  struct Node {
    Eigen::AlignedBox3d bounds;
    int first = 0;  ///< of its triangles
    int count = 0;
    int next = 0;  ///< the node behind its subtree; a node whose subtree ends right behind it is a leaf
  };

  std::vector<Triangle> triangles;
  std::vector<Node> nodes;  ///< the root first, children behind their parent
};

/// The triangles that a mesh has left, in the order in which they were given.
std::vector<MeshTriangle> triangles_of(const TriangleMesh& mesh);

std::shared_ptr<const Surface> make_surface(const TriangleMesh& mesh);

/// Minus the depth of a convex body in a surface: over the triangles that it cuts, the largest of the
/// shortest ways that take the body off one of them to its front. As the way is free to lead over the edges
/// of that triangle, it is never longer than the way off the whole surface, and as long where a corner or a
/// round part sinks into a face by less than its distance from the edges.
///
/// Positive where the body cuts none: a lower bound of its distance from the triangles that it is in front
/// of. Distances above `enough` may come out as infinity, as does that of a body behind the surface. `pose`
/// brings the body's frame to the surface's.
double surface_gap(const Surface& surface, const Polytope& body, const Eigen::Isometry3d& pose,
                   double enough);
/// The same for all that is within `radius` of a segment center +- half_segment.
double surface_gap(const Surface& surface, const Eigen::Vector3d& center, const Eigen::Vector3d& half_segment,
                   double radius, double enough);

}  // namespace scree::bench
