// See planes.h.
#include <core/geometry/decompose/planes.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace scree::decomposition {

namespace {

constexpr double kLeastSine = 0.17;          // 10 degrees: finer creases are those of curved surfaces
constexpr std::size_t kMostEdges = 4096;     // of a piece
constexpr std::size_t kMostEdgePlanes = 24;  // of a part
constexpr double kSameNormal = 1e-10;        // 1 - cosine
constexpr int kAxisPlanes = 11;              // along each axis
constexpr int kDiagonalPlanes = 7;           // along each diagonal

// An edge as a triangle has it.
struct EdgeUse {
  std::uint32_t low, high;
  std::uint32_t triangle;
  std::uint32_t apex;
};

std::vector<EdgeUse> edge_uses(const Surface& surface) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * surface.triangles.size());
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
    const Triangle& corners = surface.triangles[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(corners[k], corners[(k + 1) % 3]);
      uses.push_back({low, high, t, corners[(k + 2) % 3]});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    if (a.low != b.low) return a.low < b.low;
    return a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
  });
  return uses;
}

// Of a triangle, looking out of the solid; without area a normal of 0.
Plane plane_of(const Surface& surface, std::uint32_t triangle, bool inside_out) {
  const auto& [a, b, c] = surface.triangles[triangle];
  const Vector& corner = surface.points[a];
  const Vector normal = cross(surface.points[b] - corner, surface.points[c] - corner);
  const double size = std::sqrt(dot(normal, normal));
  if (!(size > 0.0)) return {};
  const Vector unit = ((inside_out ? -1.0 : 1.0) / size) * normal;
  return {unit, dot(unit, corner)};
}

bool make_edge(const Surface& surface, const EdgeUse& first, const EdgeUse& second, bool inside_out,
               ReentrantEdge& edge) {
  edge.from = surface.points[first.low];
  edge.to = surface.points[first.high];
  edge.faces[0] = plane_of(surface, first.triangle, inside_out);
  edge.faces[1] = plane_of(surface, second.triangle, inside_out);
  const Vector turn = cross(edge.faces[0].normal, edge.faces[1].normal);
  const double cosine = dot(edge.faces[0].normal, edge.faces[1].normal);
  edge.sharpness = cosine > 0.0 ? std::sqrt(dot(turn, turn)) : 1.0;
  if (!(edge.sharpness >= kLeastSine)) return false;
  if (!(edge.faces[0].height(surface.points[second.apex]) > 0.0)) return false;
  const Vector across = edge.faces[0].normal - edge.faces[1].normal;
  const double size = std::sqrt(dot(across, across));
  if (!(size > 0.0)) return false;
  edge.half.normal = (1.0 / size) * across;
  edge.half.offset = dot(edge.half.normal, edge.from);
  return true;
}

// Planes that several edges ask for, each once.
struct EdgePlane {
  CutPlane cut;
  double weight = 0.0;  // m: length times sharpness of its edges
};

void ask_for(std::vector<EdgePlane>& planes, const Plane& plane, PlaneKind kind, double weight,
             double tolerance) {
  for (EdgePlane& other : planes) {
    const double cosine = dot(other.cut.plane.normal, plane.normal);
    if (std::abs(cosine) < 1.0 - kSameNormal) continue;
    const double offset = cosine > 0.0 ? plane.offset : -plane.offset;
    if (std::abs(other.cut.plane.offset - offset) > tolerance) continue;
    other.weight += weight;
    return;
  }
  if (planes.size() < 4 * kMostEdgePlanes) planes.push_back({{plane, kind, 0.0, 0.0}, weight});
}

std::vector<Vector> directions() {
  std::vector<Vector> all;
  for (const int zeros : {2, 1, 0}) {
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          const Vector way{double(x), double(y), double(z)};
          const int size = x * x + y * y + z * z;
          const bool positive = x != 0 ? x > 0 : (y != 0 ? y > 0 : z > 0);
          if (size == 3 - zeros && positive) all.push_back((1.0 / std::sqrt(double(size))) * way);
        }
      }
    }
  }
  return all;
}

// The interval that polygons occupy along a direction, and its largest gap.
struct Extent {
  double lower = 0.0, upper = 0.0;
  double gap_lower = 0.0, gap_upper = 0.0;
};
Extent extent_along(const Fragments& fragments, const Vector& direction) {
  std::vector<double> heights;
  for (const Vector& point : fragments.points) heights.push_back(dot(direction, point));
  std::vector<std::array<double, 2>> intervals;
  for (std::size_t polygon = 0; polygon < fragments.size(); ++polygon) {
    const std::uint32_t first = fragments.begin[polygon], end = fragments.begin[polygon + 1];
    double lower = heights[fragments.corners[first]], upper = lower;
    for (std::uint32_t i = first; i < end; ++i) {
      lower = std::min(lower, heights[fragments.corners[i]]);
      upper = std::max(upper, heights[fragments.corners[i]]);
    }
    intervals.push_back({lower, upper});
  }
  std::sort(intervals.begin(), intervals.end());
  Extent extent{intervals[0][0], intervals[0][1]};
  for (const auto& [lower, upper] : intervals) {
    if (lower - extent.upper > extent.gap_upper - extent.gap_lower) {
      extent.gap_lower = extent.upper;
      extent.gap_upper = lower;
    }
    extent.upper = std::max(extent.upper, upper);
  }
  return extent;
}

// The planes that do not depend on edges.
void append_even(const Fragments& fragments, double thickness, double tolerance,
                 std::vector<CutPlane>& planes) {
  if (fragments.size() == 0) return;
  std::vector<Extent> extents;
  double longest = 0.0;
  for (const Vector& direction : directions()) {
    extents.push_back(extent_along(fragments, direction));
    longest = std::max(longest, extents.back().upper - extents.back().lower);
  }
  for (std::size_t d = 0; d < extents.size(); ++d) {
    const Vector direction = directions()[d];
    const Extent& extent = extents[d];
    if (extent.gap_upper - extent.gap_lower > 2.0 * tolerance) {
      planes.push_back({{direction, 0.5 * (extent.gap_lower + extent.gap_upper)}, PlaneKind::gap, 0.0, 0.0});
    }
    const bool is_axis = direction[0] == 1.0 || direction[1] == 1.0 || direction[2] == 1.0;
    const int count = is_axis ? kAxisPlanes : kDiagonalPlanes;
    const double size = extent.upper - extent.lower, spacing = size / (count + 1);
    for (int i = 1; i <= count; ++i) {
      const double place = i * spacing;
      if (place < thickness || size - place < thickness) continue;
      planes.push_back({{direction, extent.lower + place},
                        is_axis ? PlaneKind::axis : PlaneKind::diagonal,
                        spacing,
                        1.0 - size / longest});
    }
  }
}

}  // namespace

std::vector<ReentrantEdge> find_reentrant_edges(const Surface& surface, bool inside_out) {
  const std::vector<EdgeUse> uses = edge_uses(surface);
  std::vector<ReentrantEdge> edges;
  for (std::size_t first = 0, end = 0; first < uses.size(); first = end) {
    for (end = first;
         end < uses.size() && uses[end].low == uses[first].low && uses[end].high == uses[first].high; ++end) {
    }
    ReentrantEdge edge;
    if (end - first == 2 && make_edge(surface, uses[first], uses[first + 1], inside_out, edge)) {
      edges.push_back(edge);
    }
  }
  std::vector<std::uint32_t> order(edges.size());
  std::iota(order.begin(), order.end(), 0u);
  std::vector<double> weights;
  for (const ReentrantEdge& edge : edges) {
    const Vector way = edge.to - edge.from;
    weights.push_back(edge.sharpness * std::sqrt(dot(way, way)));
  }
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return weights[a] != weights[b] ? weights[a] > weights[b] : a < b;
  });
  order.resize(std::min(order.size(), kMostEdges));
  std::vector<ReentrantEdge> sorted;
  for (const std::uint32_t i : order) sorted.push_back(edges[i]);
  return sorted;
}

std::vector<CutPlane> find_planes(const Cell& cell, const std::vector<ReentrantEdge>& edges,
                                  const Fragments& fragments, double thickness, double tolerance) {
  std::vector<EdgePlane> asked;
  for (const ReentrantEdge& edge : edges) {
    Vector from = edge.from, to = edge.to;
    if (!clip(cell, from, to, 2.0 * tolerance)) continue;
    const Vector way = to - from;
    const double weight = edge.sharpness * std::sqrt(dot(way, way));
    for (const Plane& face : edge.faces) ask_for(asked, face, PlaneKind::face, weight, tolerance);
    ask_for(asked, edge.half, PlaneKind::half, weight, tolerance);
  }
  std::stable_sort(asked.begin(), asked.end(),
                   [](const EdgePlane& a, const EdgePlane& b) { return a.weight > b.weight; });
  std::vector<CutPlane> planes;
  for (std::size_t i = 0; i < std::min(asked.size(), kMostEdgePlanes); ++i) planes.push_back(asked[i].cut);
  append_even(fragments, thickness, tolerance, planes);
  return planes;
}

std::vector<CutPlane> find_middle_planes(const Fragments& fragments) {
  std::vector<CutPlane> planes;
  if (fragments.size() == 0) return planes;
  for (const Vector& direction : directions()) {
    const Extent extent = extent_along(fragments, direction);
    const bool has_gap = extent.gap_upper > extent.gap_lower;
    const double middle =
        has_gap ? 0.5 * (extent.gap_lower + extent.gap_upper) : 0.5 * (extent.lower + extent.upper);
    planes.push_back({{direction, middle}, has_gap ? PlaneKind::gap : PlaneKind::axis, 0.0, 0.0});
  }
  return planes;
}

}  // namespace scree::decomposition
