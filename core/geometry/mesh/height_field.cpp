// Height fields as meshes; see scree/height_field.h.
#include <core/geometry/mesh/mesh_build.h>
#include <core/geometry/mesh/mesh_check.h>
#include <core/world/check.h>
#include <core/world/fp_environment.h>
#include <scree/height_field.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace scree {

namespace {

constexpr const char* kName = "height_field_mesh";
constexpr Call kCall{kName, -1, ""};

void check_grid(const HeightField& field) {
  const auto check_lines = [](const char* what, std::size_t lines) {
    if (lines < 2 || lines > kMaxMeshCount)
      fail_range(kCall, what, static_cast<double>(lines), 2.0, static_cast<double>(kMaxMeshCount));
  };
  check_lines("columns", field.columns);
  check_lines("rows", field.rows);
  if (field.columns > kMaxMeshCount / field.rows ||
      2 * (field.columns - 1) > kMaxMeshCount / (field.rows - 1)) {
    fail(kCall,
         std::to_string(field.columns) + " x " + std::to_string(field.rows) +
             " heights are too many: there may be " + std::to_string(kMaxMeshCount) + " triangles at most",
         ErrorCode::too_many);
  }
  const auto check_length = [](const char* what, std::size_t length, std::size_t expected) {
    if (length == expected) return;
    fail(kCall, std::string("there are ") + std::to_string(length) + " " + what + ", must be " +
                    std::to_string(expected));
  };
  check_length("heights", field.heights.size(), field.columns * field.rows);
  if (!field.holes.empty()) check_length("holes", field.holes.size(), (field.columns - 1) * (field.rows - 1));
  const auto check_spacing = [](const char* what, float spacing, std::size_t lines) {
    check_range(kCall, what, spacing, kMinExtent, kMaxExtent / static_cast<float>(lines - 1));
  };
  check_spacing("spacing_x", field.spacing_x, field.columns);
  check_spacing("spacing_z", field.spacing_z, field.rows);
  for (std::size_t i = 0; i < field.heights.size(); ++i) {
    if (field.heights[i] >= -kMaxExtent && field.heights[i] <= kMaxExtent) continue;
    const std::string place = "the height at column " + std::to_string(i % field.columns) + ", row " +
                              std::to_string(i / field.columns);
    fail_range(kCall, place.c_str(), field.heights[i], -kMaxExtent, kMaxExtent);
  }
}

std::vector<Vec3> points_of(const HeightField& field) {
  std::vector<Vec3> points;
  points.reserve(field.heights.size());
  const auto line = [](std::size_t number, float spacing) {
    return std::min(static_cast<float>(static_cast<double>(number) * double{spacing}), kMaxExtent);
  };
  for (std::size_t row = 0; row < field.rows; ++row) {
    for (std::size_t column = 0; column < field.columns; ++column) {
      points.push_back({line(column, field.spacing_x), field.heights[row * field.columns + column],
                        line(row, field.spacing_z)});
    }
  }
  return points;
}

// Triangles of cells that are no holes, with their numbers.
struct Cells {
  std::vector<MeshTriangle> triangles;
  std::vector<std::int32_t> number;
};
Cells cells_of(const HeightField& field) {
  Cells cells;
  const std::size_t count = (field.columns - 1) * (field.rows - 1);
  cells.triangles.reserve(2 * count);
  cells.number.reserve(2 * count);
  for (std::size_t cell = 0; cell < count; ++cell) {
    if (!field.holes.empty() && field.holes[cell] != 0) continue;
    const std::size_t row = cell / (field.columns - 1), column = cell % (field.columns - 1);
    const auto a = static_cast<std::uint32_t>(row * field.columns + column);
    const auto c = static_cast<std::uint32_t>(a + field.columns);
    const std::uint32_t b = a + 1, d = c + 1;
    // Both diagonals span the same way along the ground.
    const auto climb = [&](std::uint32_t from, std::uint32_t to) {
      return std::abs(double{field.heights[to]} - double{field.heights[from]});
    };
    if (climb(a, d) <= climb(b, c)) {
      cells.triangles.push_back({a, d, b});
      cells.triangles.push_back({a, c, d});
    } else {
      cells.triangles.push_back({a, c, b});
      cells.triangles.push_back({b, c, d});
    }
    for (std::size_t k = 0; k < 2; ++k) cells.number.push_back(static_cast<std::int32_t>(2 * cell + k));
  }
  return cells;
}

}  // namespace

TriangleMesh height_field_mesh(const HeightField& field, const MeshMaterials& materials) {
  const FpEnvironment environment;
  check_grid(field);
  const std::size_t all = 2 * (field.columns - 1) * (field.rows - 1);
  const Cells cells = cells_of(field);
  if (cells.triangles.empty()) fail(kCall, "all " + std::to_string(all / 2) + " cells are holes");
  check_mesh_materials(kName, all, materials);
  std::vector<std::uint8_t> surface;
  if (!materials.of_triangle.empty()) {
    for (const std::int32_t number : cells.number)
      surface.push_back(materials.of_triangle[static_cast<std::size_t>(number)]);
  }
  MeshParts parts = make_parts(kName, points_of(field), cells.triangles, {surface, materials.materials});
  for (std::int32_t& given : parts.given) given = cells.number[static_cast<std::size_t>(given)];
  parts.report.given.triangles = all;
  parts.report.dropped_triangles = all - parts.triangles.size();
  return MeshAccess::mesh(complete_mesh(std::move(parts)));
}

}  // namespace scree
