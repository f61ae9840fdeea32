// Approximate convex decomposition: surface -> pieces -> parts, cut and joined -> hulls and figures. See
// scree/decompose.h.
#include <core/geometry/decompose/check_options.h>
#include <core/geometry/decompose/fit.h>
#include <core/geometry/decompose/parts.h>
#include <core/geometry/mesh/mesh_check.h>
#include <core/world/fp_environment.h>
#include <scree/decompose.h>
#include <scree/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace scree {

namespace {

using namespace decomposition;

// Cuts go on a little beyond the parts that are wanted: joining finds better ones among more.
std::size_t most_while_cutting(const DecomposeOptions& options) {
  const auto wanted = static_cast<std::size_t>(options.max_parts);
  return wanted == 1 ? 1 : wanted + wanted / 2 + 4;
}

void check_volume(const Surface& surface) {
  // Tetrahedra that cancel leave what their sum has rounded.
  constexpr double kRounding = 1e-12;
  const double extent = surface.triangles.empty() ? 0.0 : surface.bounds().extent();
  if (!surface.triangles.empty() && std::abs(surface.volume()) > kRounding * extent * extent * extent) return;
  throw Error("decompose: the mesh encloses no volume");
}

// Cuts the worst part until all are good, or there are too many.
void cut_parts(std::vector<CellPart>& parts, std::size_t most, Workshop& workshop, DecomposeReport& report) {
  for (;;) {
    CellPart* worst = nullptr;
    for (CellPart& part : parts) {
      if (part.is_final || part.concavity <= workshop.concavity) continue;
      if (worst == nullptr || part.concavity > worst->concavity) worst = &part;
    }
    if (worst == nullptr) return;
    if (parts.size() >= most) {
      report.reached_limit = true;
      return;
    }
    std::optional<std::array<CellPart, 2>> halves = cut_part(*worst, workshop);
    if (!halves) {
      worst->is_final = true;
      worst->fragments = {};
      continue;
    }
    *worst = std::move((*halves)[0]);
    parts.push_back(std::move((*halves)[1]));
    ++report.cuts;
  }
}

std::vector<Vec3> to_floats(const std::vector<Vector>& points) {
  std::vector<Vec3> result;
  for (const Vector& p : points) {
    result.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
  }
  return result;
}

// Parts that are too thin for hulls are left out and counted.
std::vector<Hull> make_hulls(const std::vector<CellPart>& parts, int max_vertices, DecomposeReport& report) {
  std::vector<Hull> hulls;
  for (const CellPart& part : parts) {
    try {
      hulls.emplace_back(to_floats(part.points), HullOptions{.max_vertices = max_vertices});
    } catch (const Error& error) {
      if (error.code() != ErrorCode::invalid_value) throw;
      ++report.dropped_parts;
    }
  }
  std::stable_sort(hulls.begin(), hulls.end(),
                   [](const Hull& a, const Hull& b) { return a.volume() > b.volume(); });
  return hulls;
}

void measure(const std::vector<Hull>& hulls, const Surface& surface, Workshop& workshop,
             DecomposeReport& report) {
  std::vector<Shell> shells;
  for (const Hull& hull : hulls) {
    shells.push_back(make_shell(hull));
    report.hull_volume += static_cast<double>(hull.volume());
    report.cut_vertices += hull.report().cut_vertices;
    report.hulls_from_mesh =
        std::max(report.hulls_from_mesh,
                 workshop.lattice.concavity(shells.back(), std::numeric_limits<double>::infinity()));
  }
  report.mesh_volume = std::abs(surface.volume());
  report.mesh_from_hulls = distance_from(shells, surface, workshop.lattice.spacing());
}

}  // namespace

Decomposition decompose(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles,
                        const DecomposeOptions& options) {
  const FpEnvironment environment;
  check_options(options);
  check_mesh("decompose", vertices, triangles);
  check_closed(vertices, triangles);
  Decomposition result;
  DecomposeReport& report = result.report;
  const Surface surface = make_surface(vertices, triangles, report.dropped_triangles);
  check_volume(surface);
  Workshop workshop(surface, options);
  report.concavity = workshop.concavity;

  const std::size_t most = most_while_cutting(options);
  std::vector<std::unique_ptr<const Solid>> solids;
  std::vector<CellPart> parts;
  for (Piece& piece : find_pieces(surface, std::max(most, std::size_t{64}), report.joined_pieces)) {
    solids.push_back(std::make_unique<const Solid>(std::move(piece)));
    parts.push_back(whole_part(*solids.back(), workshop));
  }
  cut_parts(parts, most, workshop, report);
  report.dropped_parts += std::erase_if(parts, [](const CellPart& part) { return !part.shell.is_solid(); });
  const auto max_parts = static_cast<std::size_t>(options.max_parts);
  if (join_parts(parts, max_parts, workshop, report.merges) > 0) report.reached_limit = true;
  result.hulls = make_hulls(parts, options.max_vertices, report);
  if (result.hulls.empty()) {
    throw Error("decompose: no part of the mesh is thick enough for a hull (see Hull)");
  }
  measure(result.hulls, surface, workshop, report);
  return result;
}

}  // namespace scree
