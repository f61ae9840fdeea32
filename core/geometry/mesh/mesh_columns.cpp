// What kernels read, from the parts of a mesh; see core/plain/mesh.h. And the parts again.
#define XXH_INLINE_ALL
#include <core/geometry/hull/hull_numbers.h>
#include <core/geometry/mesh/mesh_stages.h>
#include <core/world/fp_environment.h>
#include <core/world/material.h>

#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace scree {

namespace {

std::vector<Corners> corners_of(std::span<const MeshTriangle> triangles) {
  std::vector<Corners> corners;
  corners.reserve(triangles.size());
  for (const MeshTriangle& t : triangles) corners.push_back({t.a, t.b, t.c});
  return corners;
}

// Rows in the tree's order, and copies of the last one up to a whole leaf.
template <class Row, class At>
void fill_ordered(Column<Row>& column, std::span<const std::int32_t> order, At&& at) {
  column.resize_for_overwrite(padded(order.size()));
  for (std::size_t i = 0; i < column.size(); ++i)
    column[i] = at(static_cast<std::size_t>(order[std::min(i, order.size() - 1)]));
}

// Rows of vertices in the order in which the triangles of the tree need them, so that those of a leaf lie
// side by side; those that no triangle has come last. Returns the row of each vertex.
std::vector<std::int32_t> order_vertices(const MeshParts& parts, std::span<const std::int32_t> order,
                                         MeshColumns& columns) {
  std::vector<std::int32_t> rows(parts.vertices.size(), -1);
  columns.given_vertex.reserve(rows.size());
  const auto take = [&](std::size_t vertex) {
    if (rows[vertex] >= 0) return;
    rows[vertex] = static_cast<std::int32_t>(columns.given_vertex.size());
    columns.given_vertex.push_back(static_cast<std::int32_t>(vertex));
  };
  for (const std::int32_t i : order) {
    const MeshTriangle& t = parts.triangles[static_cast<std::size_t>(i)];
    for (const std::uint32_t vertex : {t.a, t.b, t.c}) take(vertex);
  }
  for (std::size_t vertex = 0; vertex < rows.size(); ++vertex) take(vertex);
  return rows;
}

void fill_triangles(const MeshParts& parts, std::span<const MeshTurns> turns,
                    std::span<const std::int32_t> order, MeshColumns& columns) {
  const std::vector<std::int32_t> rows = order_vertices(parts, order, columns);
  fill_ordered(columns.corners, order, [&](std::size_t i) {
    const MeshTriangle& t = parts.triangles[i];
    return MeshCorners{rows[t.a], rows[t.b], rows[t.c]};
  });
  fill_ordered(columns.turns, order, [&](std::size_t i) { return turns[i]; });
  fill_ordered(columns.given, order, [&](std::size_t i) { return parts.given[i]; });
  if (!parts.surface.empty())
    fill_ordered(columns.material, order, [&](std::size_t i) { return parts.surface[i]; });
  columns.row_of_number.resize_for_overwrite(order.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    columns.row_of_number[order[i]] = static_cast<std::int32_t>(i);
  columns.materials.resize(parts.materials.size());
  std::transform(parts.materials.begin(), parts.materials.end(), columns.materials.begin(), material_row);
}

void point_data(MeshSolid& solid, std::size_t triangles) {
  const MeshColumns& columns = solid.columns;
  MeshData& data = solid.data;
  data.vertex_count = static_cast<std::int32_t>(solid.vertices.size());
  data.triangle_count = static_cast<std::int32_t>(triangles);
  data.vertex = columns.vertex.data();
  data.corners = columns.corners.data();
  data.turns = columns.turns.data();
  data.given = columns.given.data();
  data.material = columns.material.empty() ? nullptr : columns.material.data();
  data.materials = columns.materials.empty() ? nullptr : columns.materials.data();
}

void fill_points(std::span<const Vec3> points, MeshSolid& solid) {
  double square = 0.0;
  solid.columns.vertex.resize_for_overwrite(3 * points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 place = points[static_cast<std::size_t>(solid.columns.given_vertex[i])];
    for (int axis = 0; axis < 3; ++axis) {
      const float coordinate = place[axis];
      solid.columns.vertex[3 * i + static_cast<std::size_t>(axis)] = coordinate;
      solid.extent.half[axis] = std::max(solid.extent.half[axis], std::abs(coordinate));
    }
    const Vector point = to_vector(place);
    square = std::max(square, dot(point, point));
  }
  solid.extent.radius = round_up(std::sqrt(square));
}

std::uint64_t hash_of(const MeshParts& parts, std::span<const MaterialRow> materials) {
  XXH64_state_t state;
  XXH64_reset(&state, 0);
  const auto add = [&state](const auto& rows) {
    if (!rows.empty()) XXH64_update(&state, rows.data(), rows.size() * sizeof rows[0]);
  };
  add(parts.vertices);
  add(std::span(parts.origin));
  add(parts.triangles);
  add(parts.given);
  add(parts.surface);
  add(materials);
  return XXH64_digest(&state);
}

template <class Row>
bool equal_rows(const Column<Row>& a, const Column<Row>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Row)) == 0);
}

}  // namespace

std::shared_ptr<const MeshSolid> complete_mesh(MeshParts parts) {
  const FpEnvironment environment;
  auto solid = std::make_shared<MeshSolid>();
  std::copy_n(parts.origin, 3, solid->origin);
  solid->report = parts.report;
  solid->materials = parts.materials;
  const std::vector<Vec3> points = place_about(parts.origin, parts.vertices);
  std::vector<Corners> corners = corners_of(parts.triangles);
  const std::vector<std::int32_t> order = order_triangles(points, corners);
  fill_triangles(parts, find_turns(points, corners), order, solid->columns);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const MeshTriangle& t = parts.triangles[static_cast<std::size_t>(order[i])];
    corners[i] = {t.a, t.b, t.c};
  }
  make_nodes(points, corners, *solid);
  fill_points(points, *solid);
  solid->content_hash = hash_of(parts, solid->columns.materials.span());
  solid->vertices = std::move(parts.vertices);
  point_data(*solid, order.size());
  return solid;
}

MeshTriangle given_corners(const MeshColumns& columns, std::int32_t row) {
  const auto vertex = [&](int corner) {
    return static_cast<std::uint32_t>(columns.given_vertex[columns.corners[row].vertex[corner]]);
  };
  return {vertex(0), vertex(1), vertex(2)};
}

MeshParts parts_of(const MeshSolid& solid) {
  MeshParts parts;
  parts.vertices = solid.vertices;
  std::copy_n(solid.origin, 3, parts.origin);
  parts.materials = solid.materials;
  parts.report = solid.report;
  const MeshColumns& columns = solid.columns;
  for (const std::int32_t row : columns.row_of_number) {
    parts.triangles.push_back(given_corners(columns, row));
    parts.given.push_back(columns.given[row]);
    if (!columns.material.empty()) parts.surface.push_back(columns.material[row]);
  }
  return parts;
}

std::shared_ptr<const MeshSolid> build_mesh(const char* who, std::span<const Vec3> vertices,
                                            std::span<const MeshTriangle> triangles,
                                            const MeshMaterials& materials) {
  return complete_mesh(make_parts(who, vertices, triangles, materials));
}

bool equal(const MeshSolid& a, const MeshSolid& b) {
  return a.content_hash == b.content_hash && a.vertices == b.vertices &&
         std::equal(a.origin, a.origin + 3, b.origin) && equal_rows(a.columns.corners, b.columns.corners) &&
         equal_rows(a.columns.given_vertex, b.columns.given_vertex) &&
         equal_rows(a.columns.given, b.columns.given) && equal_rows(a.columns.material, b.columns.material) &&
         equal_rows(a.columns.materials, b.columns.materials);
}

std::int32_t row_of_given(const MeshSolid& solid, std::size_t number) {
  const MeshColumns& columns = solid.columns;
  const auto given_at = [&](std::int32_t row) { return static_cast<std::size_t>(columns.given[row]); };
  const auto* found = std::partition_point(columns.row_of_number.begin(), columns.row_of_number.end(),
                                           [&](std::int32_t row) { return given_at(row) < number; });
  return found != columns.row_of_number.end() && given_at(*found) == number ? *found : -1;
}

std::size_t MeshSolid::bytes() const {
  return sizeof *this + vertices.capacity() * sizeof(Vec3) + materials.capacity() * sizeof(Material) +
         columns.vertex.capacity_bytes() + columns.corners.capacity_bytes() + columns.turns.capacity_bytes() +
         columns.given.capacity_bytes() + columns.material.capacity_bytes() +
         columns.materials.capacity_bytes() + columns.nodes.capacity_bytes() +
         columns.row_of_number.capacity_bytes() + columns.given_vertex.capacity_bytes();
}

}  // namespace scree
