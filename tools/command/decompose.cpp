// See decompose.h.
#include <tools/command/decompose.h>
#include <tools/command/text.h>
#include <tools/meshes/mesh_file.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

namespace scree::command {

namespace {

using Json = nlohmann::ordered_json;

Json list_of(Vec3 v) { return {v.x, v.y, v.z}; }

struct Box {
  Vec3 lower{}, upper{};
};
Box bounds_of(std::span<const Hull> hulls) {
  Box box{hulls[0].vertices()[0], hulls[0].vertices()[0]};
  for (const Hull& hull : hulls) {
    for (const Vec3& vertex : hull.vertices()) {
      for (int axis = 0; axis < 3; ++axis) {
        box.lower[axis] = std::min(box.lower[axis], vertex[axis]);
        box.upper[axis] = std::max(box.upper[axis], vertex[axis]);
      }
    }
  }
  return box;
}

}  // namespace

DecomposeFigures decompose_file(const DecomposeArguments& arguments) {
  const meshes::Mesh mesh = read_shape_file(arguments);
  DecomposeFigures figures{arguments.file, mesh.triangles.size(), {}, 0.0};
  const auto start = std::chrono::steady_clock::now();
  try {
    figures.parts = decompose(mesh.vertices, mesh.triangles, arguments.options);
  } catch (const Error& error) {  // it names no file
    throw Error(arguments.file + ": " + error.what(), error.code());
  }
  figures.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return figures;
}

std::string to_table(const DecomposeFigures& figures) {
  const DecomposeReport& report = figures.parts.report;
  std::string table = printable(figures.file) + "\n";
  table += row("triangles", grouped(figures.triangles));
  table += row("  left out", grouped(report.dropped_triangles));
  table += row("parts", grouped(figures.parts.hulls.size()) +
                            (report.reached_limit ? ", as many as there may be" : ""));
  table += row("  cuts", grouped(report.cuts));
  table += row("  merges", grouped(report.merges));
  table += row("  too thin", grouped(report.dropped_parts));
  if (report.joined_pieces > 0) table += row("joined pieces", grouped(report.joined_pieces));
  table += row("cut vertices", grouped(report.cut_vertices));
  table += row("volume", format("mesh %.6g, hulls %.6g m^3", report.mesh_volume, report.hull_volume));
  table += row("concavity", format("%.6g m", report.concavity));
  table += row("hulls from mesh", format("%.6g m", report.hulls_from_mesh));
  table += row("mesh from hulls", format("%.6g m", report.mesh_from_hulls));
  table += row("time", format("%.3f s", figures.seconds));
  return table;
}

std::string to_json(const DecomposeFigures& figures) {
  const DecomposeReport& report = figures.parts.report;
  Json parts = Json::array();
  for (const Hull& hull : figures.parts.hulls) {
    parts.push_back({{"vertices", hull.vertices().size()},
                     {"faces", hull.face_count()},
                     {"volume", hull.volume()},
                     {"centroid", list_of(hull.centroid())}});
  }
  const Json json{{"file", figures.file},
                  {"triangles", figures.triangles},
                  {"dropped_triangles", report.dropped_triangles},
                  {"cuts", report.cuts},
                  {"merges", report.merges},
                  {"reached_limit", report.reached_limit},
                  {"dropped_parts", report.dropped_parts},
                  {"joined_pieces", report.joined_pieces},
                  {"cut_vertices", report.cut_vertices},
                  {"mesh_volume", report.mesh_volume},
                  {"hull_volume", report.hull_volume},
                  {"concavity", report.concavity},
                  {"hulls_from_mesh", report.hulls_from_mesh},
                  {"mesh_from_hulls", report.mesh_from_hulls},
                  {"seconds", figures.seconds},
                  {"parts", parts}};
  return json.dump(2) + "\n";
}

std::string to_obj(const DecomposeFigures& figures) { return meshes::to_obj(figures.parts.hulls); }

std::string to_scene(const DecomposeFigures& figures) {
  const std::vector<Hull>& parts = figures.parts.hulls;
  Json hulls, shapes = Json::array();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::string name = "part " + std::to_string(i);
    Json points = Json::array();
    for (const Vec3& vertex : parts[i].vertices()) points.push_back(list_of(vertex));
    hulls[name] = {{"points", points}};
    shapes.push_back({{"type", "hull"}, {"hull", name}});
  }
  const Box box = bounds_of(parts);
  const Vec3 size = box.upper - box.lower;
  const float largest = std::max({size.x, size.y, size.z});
  const Vec3 middle = 0.5f * (box.lower + box.upper);
  const Json floor{{"type", "fixed"},
                   {"position", {0.0, -largest, 0.0}},
                   {"shapes", {{{"type", "box"}, {"half_extents", {10 * largest, largest, 10 * largest}}}}}};
  const Json body{{"name", "decomposed"},
                  {"position", {-middle.x, 0.5f * largest - box.lower.y, -middle.z}},
                  {"shapes", shapes}};
  const Json scene{{"hulls", hulls}, {"bodies", {floor, body}}};
  return scene.dump(1) + "\n";
}

}  // namespace scree::command
