// See check_options.h.
#include <core/geometry/decompose/check_options.h>
#include <core/geometry/mesh/mesh_check.h>
#include <core/plain/hull.h>
#include <core/world/limits.h>
#include <core/world/number_text.h>
#include <scree/error.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace scree::decomposition {

namespace {

std::string text_of(double value) { return number_text(value, 7); }

template <class Number>
void check_range(const char* name, Number value, Number least, Number most) {
  if (value >= least && value <= most) return;
  throw Error(std::string("decompose: ") + name + " is " + text_of(static_cast<double>(value)) +
              ", must lie in [" + text_of(static_cast<double>(least)) + ", " +
              text_of(static_cast<double>(most)) + "]");
}

// An edge as a triangle passes it, by its places.
struct Pass {
  std::array<float, 6> places;  // of the lower end, then of the higher one
  bool down = false;
  std::uint32_t from = 0, to = 0;  // vertices
};

std::array<float, 3> place_of(const Vec3& v) { return {v.x + 0.0f, v.y + 0.0f, v.z + 0.0f}; }

std::vector<Pass> find_passes(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles) {
  std::vector<Pass> passes;
  for (const MeshTriangle& t : triangles) {
    const std::uint32_t corners[3] = {t.a, t.b, t.c};
    std::array<float, 3> places[3];
    for (std::size_t k = 0; k < 3; ++k) places[k] = place_of(vertices[corners[k]]);
    if (places[0] == places[1] || places[1] == places[2] || places[2] == places[0]) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      const auto& low = std::min(places[k], places[next]);
      const auto& high = std::max(places[k], places[next]);
      passes.push_back({{low[0], low[1], low[2], high[0], high[1], high[2]},
                        places[next] < places[k],
                        corners[k],
                        corners[next]});
    }
  }
  std::sort(passes.begin(), passes.end(), [](const Pass& a, const Pass& b) {
    if (a.places != b.places) return a.places < b.places;
    return a.from != b.from ? a.from < b.from : a.to < b.to;
  });
  return passes;
}

std::string vertex_text(std::span<const Vec3> vertices, std::uint32_t index) {
  const Vec3& v = vertices[index];
  return std::to_string(index) + " (" + text_of(v.x) + ", " + text_of(v.y) + ", " + text_of(v.z) + ")";
}

// The first edges that triangles do not pass as often one way as the other.
std::string first_faults(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles) {
  constexpr int kNamed = 3;
  const std::vector<Pass> passes = find_passes(vertices, triangles);
  std::string text;
  int named = 0;
  for (std::size_t first = 0, end = 0; first < passes.size() && named < kNamed; first = end) {
    std::size_t down = 0;
    for (end = first; end < passes.size() && passes[end].places == passes[first].places; ++end)
      down += passes[end].down ? 1 : 0;
    if (2 * down == end - first) continue;
    text += std::string(named == 0 ? "" : "; ") +
            ((end - first) % 2 != 0 ? "an open one from vertex " : "a flipped one from vertex ") +
            vertex_text(vertices, passes[first].from) + " to vertex " +
            vertex_text(vertices, passes[first].to);
    ++named;
  }
  return text;
}

}  // namespace

void check_options(const DecomposeOptions& options) {
  check_range("concavity_share", options.concavity_share, 0.001f, 1.0f);
  check_range("concavity", options.concavity, 0.0f, kMaxExtent);
  check_range("max_parts", options.max_parts, 1, 1024);
  check_range("max_vertices", options.max_vertices, 4, kMaxHullVertices);
  check_range("resolution", options.resolution, 16, 256);
}

void check_closed(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles) {
  if (triangles.empty()) throw Error("decompose: the mesh has no triangles");
  const MeshReport report = report_mesh(vertices, triangles);
  if (report.is_closed()) return;
  throw Error("decompose: the mesh is not closed: of " + std::to_string(report.edges) + " edges " +
              std::to_string(report.open_edges) + " are open and " + std::to_string(report.flipped_edges) +
              " are between triangles that look to different sides, first " +
              first_faults(vertices, triangles));
}

}  // namespace scree::decomposition
