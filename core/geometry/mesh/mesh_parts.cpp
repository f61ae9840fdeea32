// From what a caller hands in to the parts of a mesh: vertices in different places, and triangles that have
// an area.
//
// Places are those of the kernels' floats, relative to the center of the box. Where these are coarser than
// the given coordinates, as far from a center near which the numbers are small, vertices that differ may
// become one.
#include <core/geometry/mesh/mesh_check.h>
#include <core/geometry/mesh/mesh_places.h>
#include <core/geometry/mesh/mesh_stages.h>
#include <core/world/check.h>
#include <core/world/fp_environment.h>
#include <scree/error.h>

#include <algorithm>
#include <limits>

namespace scree {

namespace {

constexpr std::uint32_t kNoVertex = 0xffffffffu;

Corners corners_of(const MeshTriangle& t) { return {t.a, t.b, t.c}; }

// Renumbered, and begun with the lowest; repeated corners stay.
Corners places_of(const Places& places, const MeshTriangle& triangle) {
  Corners corner{places.of_point[triangle.a], places.of_point[triangle.b], places.of_point[triangle.c]};
  std::rotate(corner.begin(), std::min_element(corner.begin(), corner.end()), corner.end());
  return corner;
}

// The center of the box of all triangles that have an area. Returns whether there are any.
bool find_origin(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles,
                 double (&origin)[3]) {
  float lower[3], upper[3];
  std::fill_n(lower, 3, std::numeric_limits<float>::max());
  std::fill_n(upper, 3, -std::numeric_limits<float>::max());
  for (const MeshTriangle& t : triangles) {
    if (!has_area(vertices[t.a], vertices[t.b], vertices[t.c])) continue;
    for (const std::uint32_t vertex : corners_of(t)) {
      for (int axis = 0; axis < 3; ++axis) {
        lower[axis] = std::min(lower[axis], vertices[vertex][axis]);
        upper[axis] = std::max(upper[axis], vertices[vertex][axis]);
      }
    }
  }
  for (int axis = 0; axis < 3; ++axis) origin[axis] = 0.5 * (double{lower[axis]} + double{upper[axis]}) + 0.0;
  return lower[0] <= upper[0];
}

// Numbers of the triangles that have an area and are no copy of an earlier one.
std::vector<std::uint32_t> find_sound(std::span<const Vec3> points, std::span<const MeshTriangle> triangles,
                                      const Places& places) {
  std::vector<std::uint32_t> number;
  std::vector<Corners> corners;
  number.reserve(triangles.size());
  corners.reserve(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const MeshTriangle& t = triangles[i];
    if (!has_area(points[t.a], points[t.b], points[t.c])) continue;
    number.push_back(static_cast<std::uint32_t>(i));
    corners.push_back(places_of(places, t));
  }
  const std::vector<bool> repeated = find_repeated(corners, places.count);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (!repeated[i]) number[kept++] = number[i];
  }
  number.resize(kept);
  return number;
}

// Numbers of the vertices that are left; others have the number of the first in their place, or none.
struct Renumbering {
  std::vector<std::uint32_t> first_in_place, number;

  std::uint32_t of(const Places& places, std::uint32_t vertex) const {
    return number[first_in_place[places.of_point[vertex]]];
  }
};
Renumbering renumber(std::span<const MeshTriangle> triangles, std::span<const std::uint32_t> sound,
                     const Places& places) {
  const std::size_t vertices = places.of_point.size();
  std::vector<bool> is_used(places.count);
  for (const std::uint32_t i : sound) {
    for (const std::uint32_t vertex : corners_of(triangles[i])) is_used[places.of_point[vertex]] = true;
  }
  Renumbering result{std::vector<std::uint32_t>(places.count, kNoVertex),
                     std::vector<std::uint32_t>(vertices, kNoVertex)};
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < vertices; ++i) {
    std::uint32_t& first = result.first_in_place[places.of_point[i]];
    if (first != kNoVertex || !is_used[places.of_point[i]]) continue;
    first = static_cast<std::uint32_t>(i);
    result.number[i] = count++;
  }
  return result;
}

void take_surface(const MeshMaterials& given, std::span<const std::uint32_t> sound, MeshParts& parts) {
  if (given.of_triangle.empty()) return;
  bool any = false;
  for (const std::uint32_t i : sound) any = any || given.of_triangle[i] != kShapeMaterial;
  if (!any) return;
  for (const std::uint32_t i : sound) parts.surface.push_back(given.of_triangle[i]);
  for (Material material : given.materials) {
    material.density = Material{}.density;
    material.surface_velocity = {};
    parts.materials.push_back(material);
  }
}

Vec3 without_negative_zeros(Vec3 v) { return {v.x + 0.0f, v.y + 0.0f, v.z + 0.0f}; }

}  // namespace

std::vector<Vec3> place_about(const double (&origin)[3], std::span<const Vec3> vertices) {
  std::vector<Vec3> points(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis)
      points[i][axis] = static_cast<float>(double{vertices[i][axis]} - origin[axis]);
  }
  return points;
}

void check_mesh_materials(const char* who, std::size_t triangles, const MeshMaterials& materials) {
  const Call call{who, -1, ""};
  if (materials.materials.size() > kShapeMaterial) {
    fail(call, "there are " + std::to_string(materials.materials.size()) + " materials, must be at most " +
                   std::to_string(kShapeMaterial));
  }
  for (std::size_t i = 0; i < materials.materials.size(); ++i)
    check_material({call.name, static_cast<std::int64_t>(i), call.owner, "material"}, materials.materials[i]);
  if (materials.of_triangle.empty()) return;
  if (materials.of_triangle.size() != triangles) {
    fail(call, "of_triangle names the materials of " + std::to_string(materials.of_triangle.size()) +
                   " triangles, but there are " + std::to_string(triangles));
  }
  for (std::size_t i = 0; i < triangles; ++i) {
    const std::uint8_t material = materials.of_triangle[i];
    if (material == kShapeMaterial || material < materials.materials.size()) continue;
    fail(call, "triangle " + std::to_string(i) + " has material " + std::to_string(int{material}) +
                   ", but there are " + std::to_string(materials.materials.size()));
  }
}

MeshParts make_parts(const char* who, std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles,
                     const MeshMaterials& materials) {
  const FpEnvironment environment;
  check_mesh(who, vertices, triangles);
  const Call call{who, -1, ""};
  check_mesh_materials(who, triangles.size(), materials);
  MeshParts parts;
  parts.report.given = report_mesh(vertices, triangles);
  if (triangles.empty()) fail(call, "the mesh has no triangles");
  const auto fail_flat = [&] {
    fail(call, "none of the " + std::to_string(triangles.size()) +
                   " triangles has an area: their corners lie on lines");
  };
  if (!find_origin(vertices, triangles, parts.origin)) fail_flat();
  const std::vector<Vec3> points = place_about(parts.origin, vertices);
  const Places places = find_places(points);
  const std::vector<std::uint32_t> sound = find_sound(points, triangles, places);
  if (sound.empty()) fail_flat();
  const Renumbering renumbered = renumber(triangles, sound, places);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (renumbered.number[i] != kNoVertex) parts.vertices.push_back(without_negative_zeros(vertices[i]));
  }
  parts.vertices.shrink_to_fit();
  parts.triangles.reserve(sound.size());
  parts.given.reserve(sound.size());
  for (const std::uint32_t i : sound) {
    const MeshTriangle& t = triangles[i];
    parts.triangles.push_back(
        {renumbered.of(places, t.a), renumbered.of(places, t.b), renumbered.of(places, t.c)});
    parts.given.push_back(static_cast<std::int32_t>(i));
  }
  take_surface(materials, sound, parts);
  parts.report.merged_vertices = vertices.size() - parts.vertices.size();
  parts.report.dropped_triangles = triangles.size() - sound.size();
  return parts;
}

std::string find_defect(const MeshParts& parts) {
  const FpEnvironment environment;
  try {
    check_mesh("mesh", parts.vertices, parts.triangles);
    check_mesh_materials("mesh", parts.triangles.size(), {parts.surface, parts.materials});
  } catch (const Error& error) {
    return error.what();
  }
  if (parts.triangles.empty()) return "a mesh has no triangles";
  if (parts.given.size() != parts.triangles.size()) return "a mesh does not number its triangles";
  std::int32_t last = -1;
  for (const std::int32_t number : parts.given) {
    if (number <= last || static_cast<std::size_t>(number) >= kMaxMeshCount)
      return "the triangles of a mesh are numbered out of order";
    last = number;
  }
  const TriangleMeshReport& report = parts.report;
  if (report.given.triangles > kMaxMeshCount || report.given.triangles <= static_cast<std::size_t>(last) ||
      report.dropped_triangles != report.given.triangles - parts.triangles.size())
    return "the report on a mesh counts other triangles than it has";
  for (const double coordinate : parts.origin) {
    if (!(coordinate >= -double{kMaxExtent} && coordinate <= double{kMaxExtent}))
      return "the center of a mesh is out of range";
  }
  const std::vector<Vec3> points = place_about(parts.origin, parts.vertices);
  const Places places = find_places(points);
  if (places.count != points.size()) return "vertices of a mesh lie in one place";
  if (find_sound(points, parts.triangles, places).size() != parts.triangles.size())
    return "a triangle of a mesh has no area, or is there twice";
  std::vector<bool> is_used(points.size());
  for (const MeshTriangle& triangle : parts.triangles) {
    for (const std::uint32_t vertex : corners_of(triangle)) is_used[vertex] = true;
  }
  if (std::find(is_used.begin(), is_used.end(), false) != is_used.end())
    return "a vertex of a mesh belongs to no triangle";
  return "";
}

}  // namespace scree
