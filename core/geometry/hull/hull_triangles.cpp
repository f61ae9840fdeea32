// Incremental convex hull with outside sets; see hull_stages.h.
#include <core/geometry/hull/hull_stages.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace scree {

namespace {

// Coordinates have 25 bits with their sign, differences 26, normals 53, products of normals and differences
// 80.
__extension__ using Wide = __int128;

constexpr double kToleranceOfHeight = 0.125;  // a flat hull keeps its corners on both sides

std::array<std::int64_t, 3> difference(const GridPoint& a, const GridPoint& b) {
  return {std::int64_t{a[0]} - b[0], std::int64_t{a[1]} - b[1], std::int64_t{a[2]} - b[2]};
}

// In m.
double length(const std::array<std::int64_t, 3>& v, const GridSteps& steps) {
  const double x = static_cast<double>(v[0]) * steps[0], y = static_cast<double>(v[1]) * steps[1];
  const double z = static_cast<double>(v[2]) * steps[2];
  return std::sqrt(x * x + y * y + z * z);
}

constexpr std::int32_t kNobody = -1;

struct Face {
  HullTriangle triangle;
  GridPlane plane;
  std::vector<std::int32_t> outside;  // points above the plane by more than the tolerance
  std::int32_t farthest = kNobody;
  double farthest_distance = 0.0;
  bool alive = true;
  bool visible = false;  // from the point that is being added
};

struct HorizonEdge {
  std::int32_t from, to;
  std::int32_t beyond;  // the face that stays
};

class Builder {
 public:
  Builder(std::span<const GridPoint> points, const GridSteps& steps, const TriangleLimits& limits)
      : points_(points), steps_(steps), limits_(limits), tolerance_(limits.tolerance) {}

  TriangleHull build() {
    TriangleHull hull;
    if (!begin()) return hull;
    for (int vertices = 4; vertices < limits_.max_vertices; ++vertices) {
      const std::int32_t face = highest_face();
      if (face == kNobody) break;
      add(faces_[at(face)].farthest, face);
    }
    compact(hull);
    return hull;
  }

 private:
  static std::size_t at(std::int32_t index) { return static_cast<std::size_t>(index); }
  const GridPoint& point(std::int32_t index) const { return points_[at(index)]; }

  // The point with the largest measure; the first one of equals.
  template <class Measure>
  std::int32_t farthest_by(const Measure& measure) const {
    std::int32_t best = 0;
    double largest = -1.0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const double value = measure(points_[i]);
      if (value <= largest) continue;
      largest = value;
      best = static_cast<std::int32_t>(i);
    }
    return best;
  }

  // Starts with a tetrahedron of points that are far from one another.
  bool begin() {
    if (points_.size() < 4) return false;
    std::int32_t a = 0;
    const std::int32_t b =
        farthest_by([&](const GridPoint& p) { return length(difference(p, point(a)), steps_); });
    std::int32_t c = farthest_by([&](const GridPoint& p) {
      const double inverse_length = plane_of(point(a), point(b), p, steps_).inverse_length;
      return inverse_length > 0.0 ? 1.0 / inverse_length : 0.0;
    });
    const GridPlane base = plane_of(point(a), point(b), point(c), steps_);
    if (base.inverse_length == 0.0) return false;
    const std::int32_t d = farthest_by([&](const GridPoint& p) { return std::abs(base.distance(p)); });
    const double side = base.distance(point(d));
    if (side == 0.0) return false;
    if (side > 0.0) std::swap(a, c);
    tolerance_ = std::min(tolerance_, kToleranceOfHeight * std::abs(side));
    // Now d lies below the plane of a, b, c.
    const std::int32_t corners[4][3] = {{a, b, c}, {b, a, d}, {c, b, d}, {a, c, d}};
    const std::int32_t neighbors[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
    for (int f = 0; f < 4; ++f) {
      make_face(corners[f][0], corners[f][1], corners[f][2]);
      std::copy_n(neighbors[f], 3, faces_.back().triangle.neighbor.begin());
    }
    for (std::size_t i = 0; i < points_.size(); ++i) assign(static_cast<std::int32_t>(i), 0);
    face_from_.resize(points_.size());
    return true;
  }

  std::int32_t make_face(std::int32_t a, std::int32_t b, std::int32_t c) {
    Face face;
    face.triangle.vertex = {a, b, c};
    face.triangle.neighbor = {kNobody, kNobody, kNobody};
    face.plane = plane_of(point(a), point(b), point(c), steps_);
    faces_.push_back(std::move(face));
    return static_cast<std::int32_t>(faces_.size() - 1);
  }

  // Adds the point to the list of the face that it is highest above, among the faces from `first_face` on.
  void assign(std::int32_t index, std::size_t first_face) {
    double highest = tolerance_;
    std::size_t owner = faces_.size();
    for (std::size_t f = first_face; f < faces_.size(); ++f) {
      const double distance = faces_[f].plane.distance(point(index));
      if (distance <= highest) continue;
      highest = distance;
      owner = f;
    }
    if (owner == faces_.size()) return;
    Face& face = faces_[owner];
    face.outside.push_back(index);
    if (highest > face.farthest_distance || (highest == face.farthest_distance && index < face.farthest)) {
      face.farthest_distance = highest;
      face.farthest = index;
    }
  }

  std::int32_t highest_face() const {
    std::int32_t best = kNobody;
    double highest = 0.0;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (!faces_[f].alive || faces_[f].farthest_distance <= highest) continue;
      highest = faces_[f].farthest_distance;
      best = static_cast<std::int32_t>(f);
    }
    return best;
  }

  // Replaces the faces that the point sees by a fan from the point to their horizon. Side tests are exact, so
  // the visible faces form one piece without holes.
  void add(std::int32_t index, std::int32_t seen) {
    const std::vector<std::int32_t> visible = visible_from(point(index), seen);
    const std::vector<HorizonEdge> horizon = horizon_of(visible);
    const auto first = static_cast<std::int32_t>(faces_.size());
    for (const HorizonEdge& edge : horizon) {
      const std::int32_t face = make_face(edge.from, edge.to, index);
      faces_.back().triangle.neighbor[0] = edge.beyond;
      face_from_[at(edge.from)] = face;
      HullTriangle& beyond = faces_[at(edge.beyond)].triangle;
      for (std::size_t k = 0; k < 3; ++k) {
        if (beyond.vertex[k] == edge.to && beyond.vertex[(k + 1) % 3] == edge.from) beyond.neighbor[k] = face;
      }
    }
    for (std::size_t k = 0; k < horizon.size(); ++k) {
      const std::int32_t next = face_from_[at(horizon[k].to)];
      faces_[at(first) + k].triangle.neighbor[1] = next;
      faces_[at(next)].triangle.neighbor[2] = first + static_cast<std::int32_t>(k);
    }
    for (const std::int32_t f : visible) {
      Face& face = faces_[at(f)];
      face.alive = false;
      face.farthest_distance = 0.0;
      const std::vector<std::int32_t> outside = std::move(face.outside);
      face.outside.clear();
      for (const std::int32_t other : outside) {
        if (other != index) assign(other, at(first));
      }
    }
  }

  std::vector<std::int32_t> visible_from(const GridPoint& eye, std::int32_t seen) {
    std::vector<std::int32_t> visible{seen};
    faces_[at(seen)].visible = true;
    for (std::size_t k = 0; k < visible.size(); ++k) {
      for (const std::int32_t next : faces_[at(visible[k])].triangle.neighbor) {
        Face& face = faces_[at(next)];
        if (face.visible || face.plane.distance(eye) <= 0.0) continue;
        face.visible = true;
        visible.push_back(next);
      }
    }
    return visible;
  }

  std::vector<HorizonEdge> horizon_of(const std::vector<std::int32_t>& visible) const {
    std::vector<HorizonEdge> horizon;
    for (const std::int32_t f : visible) {
      const HullTriangle& triangle = faces_[at(f)].triangle;
      for (std::size_t k = 0; k < 3; ++k) {
        if (faces_[at(triangle.neighbor[k])].visible) continue;
        horizon.push_back({triangle.vertex[k], triangle.vertex[(k + 1) % 3], triangle.neighbor[k]});
      }
    }
    return horizon;
  }

  void compact(TriangleHull& hull) const {
    std::vector<std::int32_t> place(faces_.size(), kNobody);
    std::int32_t count = 0;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (faces_[f].alive) place[f] = count++;
    }
    for (const Face& face : faces_) {
      if (!face.alive) continue;
      hull.triangles.push_back(face.triangle);
      for (std::int32_t& neighbor : hull.triangles.back().neighbor) neighbor = place[at(neighbor)];
      hull.outside.insert(hull.outside.end(), face.outside.begin(), face.outside.end());
    }
  }

  std::span<const GridPoint> points_;
  GridSteps steps_;
  TriangleLimits limits_;
  double tolerance_;
  std::vector<Face> faces_;
  std::vector<std::int32_t>
      face_from_;  // by vertex of the horizon: the new face whose first edge begins there
};

}  // namespace

GridPlane plane_of(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridSteps& steps) {
  const auto u = difference(b, a), v = difference(c, a);
  GridPlane plane;
  plane.normal = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  plane.origin = a;
  // Points transform with the steps, normals with the inverse steps.
  const double size = length(plane.normal, {1.0 / steps[0], 1.0 / steps[1], 1.0 / steps[2]});
  plane.inverse_length = size > 0.0 ? 1.0 / size : 0.0;
  return plane;
}

double GridPlane::distance(const GridPoint& point) const {
  const auto d = difference(point, origin);
  const Wide above = static_cast<Wide>(normal[0]) * d[0] + static_cast<Wide>(normal[1]) * d[1] +
                     static_cast<Wide>(normal[2]) * d[2];
  return static_cast<double>(above) * inverse_length;
}

TriangleHull find_triangles(std::span<const GridPoint> points, const GridSteps& steps,
                            const TriangleLimits& limits) {
  return Builder(points, steps, limits).build();
}

}  // namespace scree
