// Examines a mesh: vertices in one place become one, edges are sorted and counted. See scree/mesh.h.
#include <core/geometry/mesh/mesh_check.h>
#include <core/geometry/mesh/mesh_places.h>
#include <core/geometry/mesh/mesh_sort.h>
#include <core/world/limits.h>
#include <core/world/number_text.h>
#include <scree/error.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

namespace scree {

namespace {

std::string text_of(double value) { return number_text(value, 9); }

void check_count(const char* call, const char* what, std::size_t count) {
  if (count <= kMaxMeshCount) return;
  throw Error(std::string(call) + ": the mesh has " + std::to_string(count) + " " + what +
                  ", must be at most " + std::to_string(kMaxMeshCount),
              ErrorCode::too_many);
}

void count_edges(std::span<const Corners> triangles, std::size_t vertices, MeshReport& report) {
  each_edge(sort_edges(triangles, vertices), [&](std::span<const EdgePass> passes) {
    std::size_t down = 0;
    for (const EdgePass& pass : passes) down += goes_down(triangles, pass.pass) ? 1 : 0;
    const std::size_t count = passes.size();
    ++report.edges;
    if (count % 2 != 0) ++report.open_edges;
    if (count > 2) ++report.crowded_edges;
    if (count % 2 == 0 && 2 * down != count) ++report.flipped_edges;
  });
}

// Pieces of a mesh: trees whose root is the lowest of their places.
class Pieces {
 public:
  explicit Pieces(std::uint32_t places) : parent_(places) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t root(std::uint32_t place) {
    while (parent_[place] != place) place = parent_[place] = parent_[parent_[place]];
    return place;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

std::size_t count_pieces(const Places& places, std::span<const Corners> triangles) {
  Pieces pieces(places.count);
  for (const Corners& corner : triangles) {
    pieces.join(corner[0], corner[1]);
    pieces.join(corner[1], corner[2]);
  }
  std::vector<bool> is_root(places.count);
  for (const Corners& corner : triangles) is_root[pieces.root(corner[0])] = true;
  return static_cast<std::size_t>(std::count(is_root.begin(), is_root.end(), true));
}

}  // namespace

bool has_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  double u[3], v[3];
  for (int i = 0; i < 3; ++i) {
    u[i] = static_cast<double>(b[i]) - static_cast<double>(a[i]);
    v[i] = static_cast<double>(c[i]) - static_cast<double>(a[i]);
  }
  return u[1] * v[2] != u[2] * v[1] || u[2] * v[0] != u[0] * v[2] || u[0] * v[1] != u[1] * v[0];
}

void check_mesh(const char* call, std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles) {
  check_count(call, "vertices", vertices.size());
  check_count(call, "triangles", triangles.size());
  const std::string who = std::string(call) + ": ";
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const float coordinate = vertices[i][axis];
      if (coordinate >= -kMaxExtent && coordinate <= kMaxExtent) continue;
      throw Error(who + "coordinate " + "xyz"[axis] + " of vertex " + std::to_string(i) + " is " +
                  text_of(coordinate) + ", must lie in [" + text_of(-kMaxExtent) + ", " +
                  text_of(kMaxExtent) + "]");
    }
  }
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (const std::uint32_t corner : {triangles[i].a, triangles[i].b, triangles[i].c}) {
      if (corner < vertices.size()) continue;
      throw Error(who + "triangle " + std::to_string(i) + " has a corner at vertex " +
                  std::to_string(corner) + ", but there are " + std::to_string(vertices.size()));
    }
  }
}

MeshReport report_mesh(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles) {
  const Places places = find_places(vertices);
  MeshReport report;
  report.vertices = places.count;
  report.triangles = triangles.size();
  std::vector<Corners> sound;  // with three different corners
  sound.reserve(triangles.size());
  for (const MeshTriangle& triangle : triangles) {
    const Corners corner{places.of_point[triangle.a], places.of_point[triangle.b],
                         places.of_point[triangle.c]};
    if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) {
      ++report.repeated_corners;
      continue;
    }
    if (!has_area(vertices[triangle.a], vertices[triangle.b], vertices[triangle.c])) ++report.no_area;
    sound.push_back(corner);
  }
  count_edges(sound, places.count, report);
  report.parts = count_pieces(places, sound);
  for (Corners& corner : sound) std::sort(corner.begin(), corner.end());
  const std::vector<bool> repeated = find_repeated(sound, places.count);
  report.duplicates = static_cast<std::size_t>(std::count(repeated.begin(), repeated.end(), true));
  if (!vertices.empty()) report.lower = report.upper = vertices[0];
  for (const Vec3& vertex : vertices) {
    for (int axis = 0; axis < 3; ++axis) {
      report.lower[axis] = std::min(report.lower[axis], vertex[axis]);
      report.upper[axis] = std::max(report.upper[axis], vertex[axis]);
    }
  }
  return report;
}

MeshReport inspect_mesh(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles) {
  check_mesh("inspect_mesh", vertices, triangles);
  return report_mesh(vertices, triangles);
}

}  // namespace scree
