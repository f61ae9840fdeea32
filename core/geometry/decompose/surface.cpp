// See surface.h.
#include <core/geometry/decompose/surface.h>
#include <core/geometry/solid_integrals.h>

#include <algorithm>
#include <limits>
#include <numeric>

namespace scree::decomposition {

namespace {

// By the places of the corners, with the sense in which they are passed apart.
struct Record {
  Triangle corners;  // ascending
  bool odd = false;  // the triangle passes them in the other sense
};

Record record_of(Triangle corners) {
  Record record{corners, false};
  for (const auto& [i, j] : {std::pair{0u, 1u}, {1u, 2u}, {0u, 1u}}) {
    if (record.corners[i] <= record.corners[j]) continue;
    std::swap(record.corners[i], record.corners[j]);
    record.odd = !record.odd;
  }
  return record;
}

// Of triangles with the same corners those stay that no triangle of the other sense takes away.
void append_uncovered(std::vector<Record>& records, Surface& surface, std::size_t& dropped) {
  std::sort(records.begin(), records.end(), [](const Record& a, const Record& b) {
    return a.corners != b.corners ? a.corners < b.corners : a.odd < b.odd;
  });
  for (std::size_t first = 0, end = 0; first < records.size(); first = end) {
    std::size_t odd = 0;
    for (end = first; end < records.size() && records[end].corners == records[first].corners; ++end) {
      odd += records[end].odd ? 1 : 0;
    }
    const std::size_t even = end - first - odd;
    const auto [a, b, c] = records[first].corners;
    const Triangle kept = even > odd ? Triangle{a, b, c} : Triangle{a, c, b};
    surface.triangles.insert(surface.triangles.end(), std::max(even, odd) - std::min(even, odd), kept);
    dropped += 2 * std::min(even, odd);
  }
}

}  // namespace

double Bounds::extent() const {
  return std::max({upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]});
}

void Bounds::include(const Vector& point) {
  for (std::size_t k = 0; k < 3; ++k) {
    lower[k] = std::min(lower[k], point[k]);
    upper[k] = std::max(upper[k], point[k]);
  }
}

Bounds Surface::bounds() const {
  Bounds all{points[triangles[0][0]], points[triangles[0][0]]};
  for (const Triangle& triangle : triangles) {
    for (const std::uint32_t corner : triangle) all.include(points[corner]);
  }
  return all;
}

double Surface::volume() const {
  const Bounds all = bounds();
  const Vector middle = 0.5 * (all.lower + all.upper);
  SolidIntegrals sums;
  for (const auto& [a, b, c] : triangles)
    sums.add(points[a] - middle, points[b] - middle, points[c] - middle);
  return sums.volume;
}

Surface make_surface(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles,
                     std::size_t& dropped_triangles) {
  Surface surface;
  std::vector<Vector> places;
  for (const Vec3& vertex : vertices) {
    places.push_back({vertex.x + 0.0, vertex.y + 0.0, vertex.z + 0.0});  // zero has one sign
  }
  std::vector<std::uint32_t> order(places.size()), place_of(places.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return places[a] != places[b] ? places[a] < places[b] : a < b;
  });
  for (const std::uint32_t vertex : order) {
    if (surface.points.empty() || surface.points.back() != places[vertex])
      surface.points.push_back(places[vertex]);
    place_of[vertex] = static_cast<std::uint32_t>(surface.points.size() - 1);
  }
  std::vector<Record> records;
  for (const MeshTriangle& t : triangles) {
    const Triangle corners{place_of[t.a], place_of[t.b], place_of[t.c]};
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) {
      ++dropped_triangles;
    } else {
      records.push_back(record_of(corners));
    }
  }
  append_uncovered(records, surface, dropped_triangles);
  return surface;
}

WindingBins::WindingBins(const Surface& surface) : surface_(surface), bounds_(surface.bounds()) {
  while (count_ < 128 && count_ * count_ * 4 < surface.triangles.size()) count_ *= 2;
  for (std::size_t k = 0; k < 2; ++k) {
    const double size = bounds_.upper[k + 1] - bounds_.lower[k + 1];
    inverse_size_[k] = size > 0.0 ? static_cast<double>(count_) / size : 0.0;
  }
  // Counted first, then filled in.
  begin_.assign(count_ * count_ + 1, 0);
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      const Vector& a = surface.points[surface.triangles[t][0]];
      Bounds box{a, a};
      box.include(surface.points[surface.triangles[t][1]]);
      box.include(surface.points[surface.triangles[t][2]]);
      for (std::size_t i = bin_of(box.lower[1], 1); i <= bin_of(box.upper[1], 1); ++i) {
        for (std::size_t j = bin_of(box.lower[2], 2); j <= bin_of(box.upper[2], 2); ++j) {
          const std::size_t bin = i * count_ + j;
          if (pass == 0) {
            ++begin_[bin + 1];
          } else {
            triangles_[next[bin]++] = static_cast<std::uint32_t>(t);
          }
        }
      }
    }
    if (pass > 0) break;
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    triangles_.resize(begin_.back());
  }
}

// Ascends with the coordinate, whatever is rounded: a triangle lies in the bins of all of its points.
std::size_t WindingBins::bin_of(double coordinate, std::size_t axis) const {
  const double place = (coordinate - bounds_.lower[axis]) * inverse_size_[axis - 1];
  if (!(place > 0.0)) return 0;
  return std::min(static_cast<std::size_t>(std::min(place, 1e6)), count_ - 1);
}

int WindingBins::winding(const Vector& point) const {
  for (std::size_t k = 0; k < 3; ++k) {
    if (point[k] < bounds_.lower[k] || point[k] > bounds_.upper[k]) return 0;
  }
  const double y = point[1], z = point[2];
  // Whether the ray's line passes an edge on its side of larger y, where it spans z at all. Both triangles of
  // an edge compute the same, because the lower end comes first.
  const auto passes = [&](std::uint32_t from, std::uint32_t to) {
    const Vector& p = surface_.points[std::min(from, to)];
    const Vector& q = surface_.points[std::max(from, to)];
    if ((p[2] > z) == (q[2] > z)) return false;
    const double side = (q[1] - p[1]) * (z - p[2]) - (y - p[1]) * (q[2] - p[2]);
    return q[2] > p[2] ? side > 0.0 : side < 0.0;
  };
  int sum = 0;
  const std::size_t bin = bin_of(y, 1) * count_ + bin_of(z, 2);
  for (std::uint32_t i = begin_[bin]; i < begin_[bin + 1]; ++i) {
    const Triangle& corners = surface_.triangles[triangles_[i]];
    int turn = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = corners[k], to = corners[(k + 1) % 3];
      if (passes(from, to)) turn += surface_.points[to][2] > surface_.points[from][2] ? 1 : -1;
    }
    if (turn == 0) continue;
    const Vector& a = surface_.points[corners[0]];
    const Vector normal = cross(surface_.points[corners[1]] - a, surface_.points[corners[2]] - a);
    // Ahead of the point along x: (hit - point) . normal = 0 on the ray, without a division.
    const double height = dot(normal, point - a);
    if (normal[0] == 0.0) continue;
    if ((height < 0.0) == (normal[0] > 0.0) && height != 0.0) sum += turn;
  }
  return sum;
}

NearestTriangles::NearestTriangles(const Surface& surface) : surface_(surface) {
  order_.resize(surface.triangles.size());
  std::iota(order_.begin(), order_.end(), 0u);
  std::vector<Vector> middles;
  for (const auto& [a, b, c] : surface.triangles) {
    middles.push_back(surface.points[a] + surface.points[b] + surface.points[c]);
  }
  build(0, static_cast<std::uint32_t>(order_.size()), middles);
}

std::uint32_t NearestTriangles::build(std::uint32_t first, std::uint32_t end, std::vector<Vector>& middles) {
  constexpr std::uint32_t kLeaf = 4;
  const auto node = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  const Vector& start = surface_.points[surface_.triangles[order_[first]][0]];
  Bounds bounds{start, start}, spread{middles[order_[first]], middles[order_[first]]};
  for (std::uint32_t i = first; i < end; ++i) {
    for (const std::uint32_t corner : surface_.triangles[order_[i]]) bounds.include(surface_.points[corner]);
    spread.include(middles[order_[i]]);
  }
  nodes_[node].bounds = bounds;
  if (end - first <= kLeaf) {
    nodes_[node].first = first;
    nodes_[node].count = end - first;
    return node;
  }
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (spread.upper[k] - spread.lower[k] > spread.upper[axis] - spread.lower[axis]) axis = k;
  }
  const std::uint32_t half = first + (end - first) / 2;
  std::nth_element(order_.begin() + first, order_.begin() + half, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double x = middles[a][axis], y = middles[b][axis];
                     return x != y ? x < y : a < b;
                   });
  build(first, half, middles);
  const std::uint32_t second = build(half, end, middles);
  nodes_[node].first = second;
  return node;
}

double NearestTriangles::distance_squared(const Vector& point, double enough) const {
  const auto to_box = [&](std::uint32_t node) {
    const Bounds& box = nodes_[node].bounds;
    double sum = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double out = std::max({box.lower[k] - point[k], point[k] - box.upper[k], 0.0});
      sum += out * out;
    }
    return sum;
  };
  struct Entry {
    std::uint32_t node;
    double distance;
  };
  Entry stack[64];  // a tree of 2^30 triangles is 29 nodes high
  std::size_t height = 0;
  stack[height++] = {0, to_box(0)};
  double best = std::numeric_limits<double>::infinity();
  while (height > 0) {
    const Entry entry = stack[--height];
    if (entry.distance >= best) continue;
    const Node& node = nodes_[entry.node];
    if (node.count == 0) {
      Entry near{entry.node + 1, to_box(entry.node + 1)}, far{node.first, to_box(node.first)};
      if (far.distance < near.distance) std::swap(near, far);
      stack[height++] = far;
      stack[height++] = near;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const auto& [a, b, c] = surface_.triangles[order_[i]];
      best = std::min(best, decomposition::distance_squared(point, surface_.points[a], surface_.points[b],
                                                            surface_.points[c]));
    }
    if (best <= enough) return best;
  }
  return best;
}

// The nearest feature is a corner, an edge or the face; which one, the signs of a few products tell.
double distance_squared(const Vector& point, const Vector& a, const Vector& b, const Vector& c) {
  const Vector corners[3] = {a, b, c};
  const Vector normal = cross(b - a, c - a);
  bool within = true;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector& from = corners[k];
    const Vector edge = corners[(k + 1) % 3] - from, way = point - from;
    if (dot(cross(normal, edge), way) >= 0.0) continue;
    within = false;
    const double size = dot(edge, edge);
    const double along = size > 0.0 ? std::clamp(dot(edge, way) / size, 0.0, 1.0) : 0.0;
    const Vector rest = way - along * edge;
    nearest = std::min(nearest, dot(rest, rest));
  }
  const double size = dot(normal, normal);
  if (!within || size == 0.0) {
    if (size > 0.0) return nearest;
    for (std::size_t k = 0; k < 3; ++k) {  // a triangle without area
      const Vector edge = corners[(k + 1) % 3] - corners[k], way = point - corners[k];
      const double length = dot(edge, edge);
      const double along = length > 0.0 ? std::clamp(dot(edge, way) / length, 0.0, 1.0) : 0.0;
      const Vector rest = way - along * edge;
      nearest = std::min(nearest, dot(rest, rest));
    }
    return nearest;
  }
  const double height = dot(normal, point - a);
  return height * height / size;
}

}  // namespace scree::decomposition
