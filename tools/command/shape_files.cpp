// See shape_files.h.
#include <tools/command/shape_files.h>
#include <tools/command/text.h>

#include <nlohmann/json.hpp>

namespace scree::command {

namespace {

using Json = nlohmann::ordered_json;

// Errors of the library name no file.
template <class Work>
auto named(const std::string& file, Work&& work) {
  try {
    return work();
  } catch (const Error& error) {
    throw Error(file + ": " + error.what(), error.code());
  }
}

MassProperties hull_mass(const meshes::Mesh& mesh, float density) {
  World world;
  const BodyId body = world.create_body({});
  world.add_shape(body, ConvexHull{.hull = Hull(mesh.vertices)}, {.density = density});
  return world.mass_properties(body);
}

std::string text_of(Vec3 v) { return format("%.6g, %.6g, %.6g", v.x, v.y, v.z); }
Json listed(Vec3 v) { return {v.x, v.y, v.z}; }

Vec3 axis_of(const PrincipalAxes& axes, int i) {
  Vec3 unit{};
  unit[i] = 1.0f;
  return rotate(axes.rotation, unit);
}

}  // namespace

meshes::Mesh read_shape_file(const ShapeFileArguments& arguments) {
  if (!(arguments.scale > 0.0f && arguments.scale <= 1e9f)) {
    throw Error(format("--scale %.9g must be above 0 and at most 1e9", arguments.scale));
  }
  return meshes::read_mesh(arguments.file, arguments.scale);
}

HullFigures build_hull(const HullArguments& arguments) {
  const meshes::Mesh mesh = read_shape_file(arguments);
  const Hull hull =
      named(arguments.file, [&] { return Hull(mesh.vertices, {.max_vertices = arguments.max_vertices}); });
  return {arguments.file,    hull.report(), hull.vertices().size(), hull.edge_count(),
          hull.face_count(), hull.volume(), hull.centroid(),        meshes::to_obj(hull)};
}

MassFigures measure_mass(const MassArguments& arguments) {
  const meshes::Mesh mesh = read_shape_file(arguments);
  return named(arguments.file, [&] {
    MassFigures figures{arguments.file,
                        arguments.of_hull,
                        arguments.density,
                        inspect_mesh(mesh.vertices, mesh.triangles),
                        arguments.of_hull ? hull_mass(mesh, arguments.density)
                                          : mesh_mass(mesh.vertices, mesh.triangles, arguments.density),
                        {}};
    figures.axes = principal_axes(figures.mass);
    return figures;
  });
}

std::string to_table(const HullFigures& figures) {
  const HullReport& report = figures.report;
  std::string table = printable(figures.file) + "\n";
  table += row("points", grouped(report.given_points));
  table += row("  merged", grouped(report.merged_points));
  table += row("  inside", grouped(report.inner_points));
  table += row("  cut off", grouped(report.cut_vertices));
  table += row("deviation", format("%.6g m", report.deviation));
  table += row("vertices", grouped(figures.vertices));
  table += row("edges", grouped(figures.edges));
  table += row("faces", grouped(figures.faces));
  table += row("volume", format("%.6g m^3", figures.volume));
  table += row("centroid", text_of(figures.centroid) + " m");
  return table;
}

std::string to_json(const HullFigures& figures) {
  const HullReport& report = figures.report;
  const Json json{{"file", figures.file},
                  {"given_points", report.given_points},
                  {"merged_points", report.merged_points},
                  {"inner_points", report.inner_points},
                  {"cut_vertices", report.cut_vertices},
                  {"deviation", report.deviation},
                  {"vertices", figures.vertices},
                  {"edges", figures.edges},
                  {"faces", figures.faces},
                  {"volume", figures.volume},
                  {"centroid", listed(figures.centroid)}};
  return json.dump(2) + "\n";
}

std::string to_table(const MassFigures& figures) {
  const MeshReport& report = figures.report;
  const MassProperties& mass = figures.mass;
  std::string table = printable(figures.file) + (figures.of_hull ? ", its convex hull\n" : "\n");
  table += row("triangles", grouped(report.triangles));
  table += row("vertices", grouped(report.vertices));
  table += row("parts", grouped(report.parts));
  table += row("open edges", grouped(report.open_edges));
  table += row("flipped edges", grouped(report.flipped_edges));
  table += row("crowded edges", grouped(report.crowded_edges));
  table += row("without area", grouped(report.repeated_corners + report.no_area));
  table += row("duplicates", grouped(report.duplicates));
  table += row("bounds", text_of(report.lower) + " to " + text_of(report.upper) + " m");
  table += row("density", format("%.6g kg/m^3", figures.density));
  table += row("volume", format("%.6g m^3", mass.mass / figures.density));
  table += row("mass", format("%.6g kg", mass.mass));
  table += row("center", text_of(mass.center) + " m");
  table += row("inertia",
               format("xx %.6g, yy %.6g, zz %.6g, xy %.6g, xz %.6g, yz %.6g kg m^2", mass.inertia[0],
                      mass.inertia[1], mass.inertia[2], mass.inertia[3], mass.inertia[4], mass.inertia[5]));
  for (int i = 0; i < 3; ++i) {
    table += row(i == 0 ? "principal axes" : "",
                 format("%.6g kg m^2 about ", figures.axes.moments[i]) + text_of(axis_of(figures.axes, i)));
  }
  return table;
}

std::string to_json(const MassFigures& figures) {
  const MeshReport& report = figures.report;
  const MassProperties& mass = figures.mass;
  const Quat& rotation = figures.axes.rotation;
  const Json json{{"file", figures.file},
                  {"of_hull", figures.of_hull},
                  {"triangles", report.triangles},
                  {"vertices", report.vertices},
                  {"parts", report.parts},
                  {"edges", report.edges},
                  {"open_edges", report.open_edges},
                  {"flipped_edges", report.flipped_edges},
                  {"crowded_edges", report.crowded_edges},
                  {"repeated_corners", report.repeated_corners},
                  {"no_area", report.no_area},
                  {"duplicates", report.duplicates},
                  {"lower", listed(report.lower)},
                  {"upper", listed(report.upper)},
                  {"density", figures.density},
                  {"mass", mass.mass},
                  {"center", listed(mass.center)},
                  {"inertia", mass.inertia},
                  {"principal_moments", listed(figures.axes.moments)},
                  {"principal_rotation", {rotation.x, rotation.y, rotation.z, rotation.w}}};
  return json.dump(2) + "\n";
}

}  // namespace scree::command
