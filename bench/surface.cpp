// Surfaces of the evaluator: a tree finds triangles, each of them stands for a prism below it.
#include "bench/surface.h"

#include <algorithm>
#include <limits>

namespace scree::bench {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kLeafTriangles = 4;
// m, of the plate that stands for a triangle itself. Far below any penetration that matters, far above
// rounding.
constexpr double kPlate = 1e-6;

AlignedBox3d bounds_of(const Surface::Triangle& triangle) {
  AlignedBox3d bounds;
  for (const Vector3d& corner : triangle.corners) bounds.extend(corner);
  return bounds;
}

// Adds the nodes of the triangles [first, first + count), which it puts in order.
void add_nodes(Surface& surface, int first, int count) {
  const std::size_t at = surface.nodes.size();
  surface.nodes.emplace_back();
  AlignedBox3d bounds, centers;
  const auto begin = surface.triangles.begin() + first;
  for (auto triangle = begin; triangle != begin + count; ++triangle) {
    const AlignedBox3d own = bounds_of(*triangle);
    bounds.extend(own);
    centers.extend(own.center());
  }
  surface.nodes[at].bounds = bounds;
  surface.nodes[at].first = first;
  surface.nodes[at].count = count;
  if (count > kLeafTriangles) {
    Eigen::Index axis = 0;
    centers.sizes().maxCoeff(&axis);
    const int half = count / 2;
    std::nth_element(begin, begin + half, begin + count,
                     [axis](const Surface::Triangle& a, const Surface::Triangle& b) {
                       return bounds_of(a).center()[axis] < bounds_of(b).center()[axis];
                     });
    add_nodes(surface, first, half);
    add_nodes(surface, first + half, count - half);
  }
  surface.nodes[at].next = static_cast<int>(surface.nodes.size());
}

template <class Visit>
void for_each_triangle(const Surface& surface, const AlignedBox3d& near, const Visit& visit) {
  for (int at = 0; at < static_cast<int>(surface.nodes.size());) {
    const Surface::Node& node = surface.nodes[static_cast<std::size_t>(at)];
    if (!node.bounds.intersects(near)) {
      at = node.next;
      continue;
    }
    ++at;
    if (node.next != at) continue;
    for (int i = node.first; i < node.first + node.count; ++i) {
      const Surface::Triangle& triangle = surface.triangles[static_cast<std::size_t>(i)];
      if (bounds_of(triangle).intersects(near)) visit(triangle);
    }
  }
}

// The triangle's prism of that depth, about the triangle's middle, which keeps its numbers small.
Polytope prism_below(const Surface::Triangle& triangle, const Vector3d& middle, double depth) {
  std::array<Vector3d, 3> corners = triangle.corners;
  for (Vector3d& corner : corners) corner -= middle;
  return make_prism_polytope(corners, -depth * triangle.normal);
}

// A body as surface_gap sees it, in the surface's frame.
struct Body {
  AlignedBox3d bounds;
  double size;  // m, no two of its points are farther apart
};

// `range(normal)` yields the lowest and highest of the body's points along a direction, `gap(prism, middle)`
// the signed distance from a prism about `middle`.
template <class Range, class Gap>
double gap_of(const Surface& surface, const Body& body, double enough, const Range& range, const Gap& gap) {
  const double reach = std::min(enough, body.size);
  AlignedBox3d near = body.bounds;
  near.min().array() -= reach;
  near.max().array() += reach;
  double least = kInfinity;
  for_each_triangle(surface, near, [&](const Surface::Triangle& triangle) {
    const double height = triangle.normal.dot(triangle.corners[0]);
    const auto [low, high] = range(triangle.normal);
    if (low - height > enough || high - height <= kPlate) return;  // away, or behind
    const Vector3d middle = (triangle.corners[0] + triangle.corners[1] + triangle.corners[2]) / 3.0;
    const double plate = gap(prism_below(triangle, middle, kPlate), middle);
    if (plate > 0.0) {
      if (plate <= enough) least = std::min(least, plate);
      return;
    }
    // So deep that no way off leads through its end.
    const double depth = 2.0 * body.size + 1.0;
    least = std::min(least, gap(prism_below(triangle, middle, depth), middle));
  });
  return least;
}

}  // namespace

std::vector<MeshTriangle> triangles_of(const TriangleMesh& mesh) {
  std::vector<MeshTriangle> triangles;
  triangles.reserve(mesh.triangle_count());
  for (std::size_t i = 0; i < mesh.report().given.triangles; ++i) {
    try {
      triangles.push_back(mesh.triangle(i));
    } catch (const Error&) {
      // It was dropped.
    }
  }
  return triangles;
}

std::shared_ptr<const Surface> make_surface(const TriangleMesh& mesh) {
  auto surface = std::make_shared<Surface>();
  const auto corner = [vertices = mesh.vertices()](std::uint32_t index) {
    const Vec3 v = vertices[index];
    return Vector3d(double{v.x}, double{v.y}, double{v.z});
  };
  for (const MeshTriangle& given : triangles_of(mesh)) {
    const std::array<Vector3d, 3> corners = {corner(given.a), corner(given.b), corner(given.c)};
    const Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    surface->triangles.push_back({corners, normal});
  }
  surface->nodes.reserve(surface->triangles.size());
  add_nodes(*surface, 0, static_cast<int>(surface->triangles.size()));
  return surface;
}

double surface_gap(const Surface& surface, const Polytope& body, const Eigen::Isometry3d& pose,
                   double enough) {
  std::vector<Vector3d> vertices;
  vertices.reserve(body.vertices.size());
  Body moved{{}, 2.0 * body.outer_radius};
  for (const Vector3d& vertex : body.vertices) {
    vertices.push_back(pose * vertex);
    moved.bounds.extend(vertices.back());
  }
  const auto range = [&](const Vector3d& normal) {
    std::pair<double, double> ends{kInfinity, -kInfinity};
    for (const Vector3d& vertex : vertices) {
      const double along = normal.dot(vertex);
      ends = {std::min(ends.first, along), std::max(ends.second, along)};
    }
    return ends;
  };
  return gap_of(surface, moved, enough, range, [&](const Polytope& prism, const Vector3d& middle) {
    Eigen::Isometry3d seen = pose;
    seen.translation() -= middle + prism.centroid;
    return polytope_gap(prism, body, seen, enough);
  });
}

double surface_gap(const Surface& surface, const Vector3d& center, const Vector3d& half_segment,
                   double radius, double enough) {
  Body body{{}, 2.0 * (half_segment.norm() + radius)};
  const Vector3d reach = half_segment.cwiseAbs().array() + radius;
  body.bounds.extend(Vector3d(center - reach));
  body.bounds.extend(Vector3d(center + reach));
  const auto range = [&](const Vector3d& normal) {
    const double middle = normal.dot(center), half = std::abs(normal.dot(half_segment)) + radius;
    return std::pair{middle - half, middle + half};
  };
  return gap_of(surface, body, enough, range, [&](const Polytope& prism, const Vector3d& middle) {
    return segment_gap(prism, center - middle - prism.centroid, half_segment) - radius;
  });
}

}  // namespace scree::bench
