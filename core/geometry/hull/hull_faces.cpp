// Polygons from triangles; see hull_stages.h.
#include <core/geometry/hull/hull_numbers.h>
#include <core/geometry/hull/hull_stages.h>
#include <scree/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

namespace scree {

namespace {

using Loop = std::vector<std::int32_t>;

constexpr int kFaceToleranceTries = 4;  // the last one at zero
constexpr double kSmallerFaceTolerance = 0.25;

using Position = std::array<double, 3>;

std::size_t at(std::int32_t index) { return static_cast<std::size_t>(index); }

// Points in grid coordinates.
struct Places {
  std::span<const GridPoint> points;
  GridSteps steps;

  const GridPoint& operator[](std::int32_t index) const { return points[at(index)]; }
  std::size_t size() const { return points.size(); }
  GridPlane plane_of(const HullTriangle& triangle) const {
    const auto& vertex = triangle.vertex;
    return scree::plane_of((*this)[vertex[0]], (*this)[vertex[1]], (*this)[vertex[2]], steps);
  }
  Position position(std::int32_t index) const {
    const GridPoint& p = points[at(index)];
    return {p[0] * steps[0], p[1] * steps[1], p[2] * steps[2]};
  }
};

// Triangles in descending order of area, then ascending by their lowest corners.
std::vector<std::int32_t> by_area(const Places& places, const TriangleHull& hull) {
  struct Key {
    double inverse_area;
    Loop corners;
    std::int32_t triangle;
  };
  std::vector<Key> keys;
  for (std::size_t t = 0; t < hull.triangles.size(); ++t) {
    const auto& vertex = hull.triangles[t].vertex;
    Key key{places.plane_of(hull.triangles[t]).inverse_length,
            {vertex.begin(), vertex.end()},
            static_cast<std::int32_t>(t)};
    std::sort(key.corners.begin(), key.corners.end());
    keys.push_back(std::move(key));
  }
  std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) {
    return a.inverse_area != b.inverse_area ? a.inverse_area < b.inverse_area : a.corners < b.corners;
  });
  std::vector<std::int32_t> order;
  for (const Key& key : keys) order.push_back(key.triangle);
  return order;
}

// Grows a face from each triangle that has none yet, largest first. Adds neighbors while their corners lie
// within the tolerance of the first triangle's plane. No point lies above that plane.
std::vector<std::int32_t> find_faces(const Places& places, const TriangleHull& hull, double tolerance,
                                     std::int32_t& face_count) {
  std::vector<std::int32_t> face_of(hull.triangles.size(), -1);
  face_count = 0;
  for (const std::int32_t seed : by_area(places, hull)) {
    if (face_of[at(seed)] >= 0) continue;
    const GridPlane plane = places.plane_of(hull.triangles[at(seed)]);
    const std::int32_t face = face_count++;
    std::vector<std::int32_t> members{seed};
    face_of[at(seed)] = face;
    for (std::size_t k = 0; k < members.size(); ++k) {
      for (const std::int32_t next : hull.triangles[at(members[k])].neighbor) {
        if (face_of[at(next)] >= 0) continue;
        const auto& vertex = hull.triangles[at(next)].vertex;
        const bool within = std::all_of(vertex.begin(), vertex.end(), [&](std::int32_t v) {
          return plane.distance(places[v]) >= -tolerance;
        });
        if (!within) continue;
        face_of[at(next)] = face;
        members.push_back(next);
      }
    }
  }
  return face_of;
}

// Number of faces that meet at each point.
std::vector<std::int32_t> count_faces(std::size_t points, const TriangleHull& hull,
                                      const std::vector<std::int32_t>& face_of) {
  std::vector<std::pair<std::int32_t, std::int32_t>> meetings;
  for (std::size_t t = 0; t < hull.triangles.size(); ++t) {
    for (const std::int32_t v : hull.triangles[t].vertex) meetings.emplace_back(v, face_of[t]);
  }
  std::sort(meetings.begin(), meetings.end());
  meetings.erase(std::unique(meetings.begin(), meetings.end()), meetings.end());
  std::vector<std::int32_t> count(points, 0);
  for (const auto& meeting : meetings) ++count[at(meeting.first)];
  return count;
}

// The boundaries of the faces. Returns none if a boundary is not a single simple loop.
std::optional<std::vector<Loop>> find_loops(std::size_t points, const TriangleHull& hull,
                                            const std::vector<std::int32_t>& face_of,
                                            std::int32_t face_count) {
  std::vector<std::vector<std::pair<std::int32_t, std::int32_t>>> borders(at(face_count));
  for (std::size_t t = 0; t < hull.triangles.size(); ++t) {
    const HullTriangle& triangle = hull.triangles[t];
    for (std::size_t k = 0; k < 3; ++k) {
      if (face_of[at(triangle.neighbor[k])] == face_of[t]) continue;
      borders[at(face_of[t])].emplace_back(triangle.vertex[k], triangle.vertex[(k + 1) % 3]);
    }
  }
  std::vector<Loop> loops;
  std::vector<std::int32_t> next(points, -1);
  for (const auto& border : borders) {
    if (border.size() < 3) return std::nullopt;
    for (const auto& edge : border) {
      if (next[at(edge.first)] >= 0) return std::nullopt;
      next[at(edge.first)] = edge.second;
    }
    Loop loop;
    std::int32_t corner = border.front().first;
    for (std::size_t k = 0; k < border.size(); ++k) {
      loop.push_back(corner);
      corner = std::exchange(next[at(corner)], -1);
      if (corner < 0) return std::nullopt;
    }
    if (corner != loop.front()) return std::nullopt;
    loops.push_back(std::move(loop));
  }
  return loops;
}

struct Normal {
  double x = 0.0, y = 0.0, z = 0.0;
};

// Twice the area vector of a polygon: the sum over the triangles between its first corner and its edges.
template <class Point>
Normal area_of(const Loop& loop, const Point& point) {
  Normal sum;
  const Position origin = point(loop[0]);
  for (std::size_t k = 1; k + 1 < loop.size(); ++k) {
    const Position a = point(loop[k]), b = point(loop[k + 1]);
    const double ux = a[0] - origin[0], uy = a[1] - origin[1], uz = a[2] - origin[2];
    const double vx = b[0] - origin[0], vy = b[1] - origin[1], vz = b[2] - origin[2];
    sum.x += uy * vz - uz * vy;
    sum.y += uz * vx - ux * vz;
    sum.z += ux * vy - uy * vx;
  }
  return sum;
}

// Whether a polygon, seen along its normal, turns left at every corner.
bool is_convex(const Places& places, const Loop& loop, const Normal& normal) {
  const auto position = [&](std::int32_t i) { return places.position(i); };
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const Normal turn =
        area_of({loop[k], loop[(k + 1) % loop.size()], loop[(k + 2) % loop.size()]}, position);
    if (!(normal.x * turn.x + normal.y * turn.y + normal.z * turn.z > 0.0)) return false;
  }
  return true;
}

// Whether every edge has two faces that bend away from each other, and Euler's formula holds.
bool is_sound(const Places& places, const std::vector<Loop>& loops) {
  const auto position = [&](std::int32_t i) { return places.position(i); };
  std::vector<Normal> normals;
  std::map<std::pair<std::int32_t, std::int32_t>, std::size_t> face_of_edge;
  std::vector<std::int32_t> corners;
  for (std::size_t f = 0; f < loops.size(); ++f) {
    const Loop& loop = loops[f];
    normals.push_back(area_of(loop, position));
    if (!is_convex(places, loop, normals.back())) return false;
    for (std::size_t k = 0; k < loop.size(); ++k) {
      if (!face_of_edge.emplace(std::pair{loop[k], loop[(k + 1) % loop.size()]}, f).second) return false;
    }
    corners.insert(corners.end(), loop.begin(), loop.end());
  }
  for (const auto& [edge, face] : face_of_edge) {
    const auto other = face_of_edge.find({edge.second, edge.first});
    if (other == face_of_edge.end()) return false;
    const Normal &m = normals[face], &n = normals[other->second];
    const Position a = position(edge.first), b = position(edge.second);
    const double bend = (m.y * n.z - m.z * n.y) * (b[0] - a[0]) + (m.z * n.x - m.x * n.z) * (b[1] - a[1]) +
                        (m.x * n.y - m.y * n.x) * (b[2] - a[2]);
    if (!(bend > 0.0)) return false;
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  return corners.size() + loops.size() == face_of_edge.size() / 2 + 2;
}

// Rotates loops to begin at their lowest corner, and sorts them.
void put_in_order(std::vector<Loop>& loops) {
  for (Loop& loop : loops) std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
  std::sort(loops.begin(), loops.end());
}

// Renumbers the remaining corners by rank.
HullPolygons ranked(std::vector<Loop> loops) {
  HullPolygons polygons;
  for (const Loop& loop : loops) polygons.corners.insert(polygons.corners.end(), loop.begin(), loop.end());
  std::sort(polygons.corners.begin(), polygons.corners.end());
  polygons.corners.erase(std::unique(polygons.corners.begin(), polygons.corners.end()),
                         polygons.corners.end());
  for (Loop& loop : loops) {
    for (std::int32_t& corner : loop) {
      const auto place = std::lower_bound(polygons.corners.begin(), polygons.corners.end(), corner);
      corner = static_cast<std::int32_t>(place - polygons.corners.begin());
    }
  }
  put_in_order(loops);
  polygons.loops = std::move(loops);
  return polygons;
}

// Drops corners with fewer than three faces, which lie within the tolerance of a face or an edge, and builds
// the hull of the others. Repeats until there are none.
std::optional<HullPolygons> merge(const Places& places, TriangleHull hull, double tolerance) {
  for (;;) {
    std::int32_t face_count = 0;
    const std::vector<std::int32_t> face_of = find_faces(places, hull, tolerance, face_count);
    const std::vector<std::int32_t> faces = count_faces(places.size(), hull, face_of);
    std::vector<std::int32_t> kept;
    bool dropped = false;
    for (std::size_t v = 0; v < faces.size(); ++v) {
      if (faces[v] >= 3) kept.push_back(static_cast<std::int32_t>(v));
      dropped |= faces[v] == 1 || faces[v] == 2;
    }
    if (!dropped) {
      auto loops = find_loops(places.size(), hull, face_of, face_count);
      // At tolerance zero only exactly coplanar triangles are merged, which is sound by construction.
      if (!loops || (tolerance > 0.0 && !is_sound(places, *loops))) return std::nullopt;
      return ranked(std::move(*loops));
    }
    std::vector<GridPoint> rest;
    for (const std::int32_t v : kept) rest.push_back(places[v]);
    hull = find_triangles(rest, places.steps, {std::numeric_limits<int>::max(), 0.0});
    if (hull.triangles.empty()) return std::nullopt;
    for (HullTriangle& triangle : hull.triangles) {
      for (std::int32_t& v : triangle.vertex) v = kept[at(v)];
    }
  }
}

HullTopology::Plane plane_of_face(const std::vector<Vec3>& corners, const Loop& loop) {
  const Normal area = area_of(loop, [&](std::int32_t i) {
    const Vec3& v = corners[at(i)];
    return Position{v.x, v.y, v.z};
  });
  const double size = std::sqrt(area.x * area.x + area.y * area.y + area.z * area.z);
  HullTopology::Plane plane{};
  plane.normal[0] = static_cast<float>(area.x / size);
  plane.normal[1] = static_cast<float>(area.y / size);
  plane.normal[2] = static_cast<float>(area.z / size);
  double offset = -std::numeric_limits<double>::infinity();
  for (const Vec3& v : corners) {  // dropped ones as well: none may lie outside
    const double reach =
        double{plane.normal[0]} * v.x + double{plane.normal[1]} * v.y + double{plane.normal[2]} * v.z;
    offset = std::max(offset, reach);
  }
  plane.offset = round_up(offset);
  return plane;
}

}  // namespace

HullPolygons find_polygons(const std::string& who, std::span<const GridPoint> points, const GridSteps& steps,
                           const TriangleHull& hull, double tolerance) {
  const Places places{points, steps};
  for (int attempt = 0; attempt < kFaceToleranceTries; ++attempt) {
    const bool last = attempt + 1 == kFaceToleranceTries;
    if (auto polygons = merge(places, hull, last ? 0.0 : tolerance)) return std::move(*polygons);
    tolerance *= kSmallerFaceTolerance;
  }
  throw Error(who + ": the points' hull is too degenerate to make faces of");
}

HullTopology make_topology(const std::vector<Vec3>& corners, const std::vector<Loop>& loops) {
  HullTopology topology;
  topology.vertices = corners;
  topology.begin.push_back(0);
  std::map<std::pair<std::int32_t, std::int32_t>, std::uint16_t> face_of_edge;
  for (std::size_t f = 0; f < loops.size(); ++f) {
    const Loop& loop = loops[f];
    for (std::size_t k = 0; k < loop.size(); ++k) {
      topology.loops.push_back(static_cast<std::uint8_t>(loop[k]));
      face_of_edge[{loop[k], loop[(k + 1) % loop.size()]}] = static_cast<std::uint16_t>(f);
    }
    topology.begin.push_back(static_cast<std::uint16_t>(topology.loops.size()));
    topology.planes.push_back(plane_of_face(corners, loop));
  }
  for (const auto& [edge, face] : face_of_edge) {
    if (edge.first > edge.second) continue;
    topology.edges.push_back({{static_cast<std::uint8_t>(edge.first), static_cast<std::uint8_t>(edge.second)},
                              {face, face_of_edge.at({edge.second, edge.first})}});
  }
  return topology;
}

}  // namespace scree
