// Meshes of snapshots as bytes; see snapshot_meshes.h.
#include <core/geometry/mesh/mesh_build.h>
#include <core/state/recording_format/value_bytes.h>
#include <core/state/snapshot/snapshot_meshes.h>

#include <cmath>
#include <cstring>

namespace scree {

namespace {

// Calls each(count) for the counts of a report.
template <class Report, class Each>
void each_count(Report& report, Each&& each) {
  static_assert(sizeof(MeshReport) == 10 * sizeof(std::size_t) + 6 * sizeof(float) &&
                    sizeof(TriangleMeshReport) == sizeof(MeshReport) + 2 * sizeof(std::size_t),
                "a new field goes here, too");
  auto& given = report.given;
  each(given.vertices);
  each(given.triangles);
  each(given.repeated_corners);
  each(given.no_area);
  each(given.duplicates);
  each(given.edges);
  each(given.open_edges);
  each(given.crowded_edges);
  each(given.flipped_edges);
  each(given.parts);
  each(report.merged_vertices);
  each(report.dropped_triangles);
}

template <class Row>
void write_rows(const std::vector<Row>& rows, ByteWriter& writer) {
  writer.put_bytes(rows.data(), rows.size() * sizeof(Row));
}

void write_mesh(const MeshSolid& solid, ByteWriter& writer) {
  const MeshParts parts = parts_of(solid);
  writer.put(static_cast<std::uint32_t>(parts.vertices.size()));
  writer.put(static_cast<std::uint32_t>(parts.triangles.size()));
  writer.put(static_cast<std::uint32_t>(parts.materials.size()));
  writer.put(static_cast<std::uint32_t>(parts.surface.empty() ? 0 : 1));
  for (const double coordinate : parts.origin) writer.put(coordinate);
  each_count(parts.report, [&writer](std::size_t count) { writer.put(std::uint64_t{count}); });
  write_value(writer, parts.report.given.lower);
  write_value(writer, parts.report.given.upper);
  write_rows(parts.vertices, writer);
  write_rows(parts.triangles, writer);
  write_rows(parts.given, writer);
  write_rows(parts.surface, writer);
  for (const Material& material : parts.materials) write_value(writer, material);
}

template <class Row>
std::vector<Row> read_rows(ByteReader& reader, std::size_t count) {
  if (count > reader.left() / sizeof(Row)) refuse_bytes(reader.at(), "a mesh is longer than what follows");
  std::vector<Row> rows(count);
  if (count > 0) std::memcpy(rows.data(), reader.take_bytes(count * sizeof(Row)), count * sizeof(Row));
  return rows;
}

MeshPointer read_mesh(ByteReader& reader) {
  const std::size_t begin = reader.at();
  const auto vertices = reader.take<std::uint32_t>(), triangles = reader.take<std::uint32_t>();
  const auto materials = reader.take<std::uint32_t>(), has_surface = reader.take<std::uint32_t>();
  if (materials > kShapeMaterial || has_surface > 1 || (materials > 0 && has_surface == 0))
    refuse_bytes(begin, "a mesh has a wrong number of materials");
  MeshParts parts;
  for (double& coordinate : parts.origin) coordinate = reader.take<double>();
  each_count(parts.report, [&reader](std::size_t& count) {
    count = static_cast<std::size_t>(reader.take<std::uint64_t>());
  });
  const std::size_t at = reader.at();
  for (Vec3* corner : {&parts.report.given.lower, &parts.report.given.upper}) {
    read_value(reader, *corner);
    const bool finite = std::isfinite(corner->x) && std::isfinite(corner->y) && std::isfinite(corner->z);
    if (!finite) refuse_bytes(at, "the box of a mesh is not finite");
  }
  parts.vertices = read_rows<Vec3>(reader, vertices);
  parts.triangles = read_rows<MeshTriangle>(reader, triangles);
  parts.given = read_rows<std::int32_t>(reader, triangles);
  parts.surface = read_rows<std::uint8_t>(reader, has_surface != 0 ? triangles : 0);
  for (std::uint32_t i = 0; i < materials; ++i) read_value(reader, parts.materials.emplace_back());
  if (const std::string defect = find_defect(parts); !defect.empty()) refuse_bytes(begin, defect);
  return complete_mesh(std::move(parts));
}

}  // namespace

void write_mesh_solids(std::span<const MeshPointer> meshes, ByteWriter& writer) {
  writer.put(static_cast<std::uint32_t>(meshes.size()));
  for (const MeshPointer& mesh : meshes) write_mesh(*mesh, writer);
}

void read_mesh_solids(ByteReader& reader, std::vector<MeshPointer>& meshes) {
  for (auto left = reader.take<std::uint32_t>(); left > 0; --left) meshes.push_back(read_mesh(reader));
}

void write_mesh_slots(const std::vector<std::int32_t>& numbers, ByteWriter& writer) {
  writer.put(static_cast<std::uint32_t>(numbers.size()));
  for (const std::int32_t number : numbers) writer.put(number);
}

std::vector<SharedMesh> read_mesh_slots(ByteReader& reader, std::span<const MeshPointer> meshes) {
  std::vector<SharedMesh> slots;
  for (auto left = reader.take<std::uint32_t>(); left > 0; --left) {
    const std::size_t at = reader.at();
    const auto number = reader.take<std::int32_t>();
    if (number < -1 || (number >= 0 && static_cast<std::size_t>(number) >= meshes.size()))
      refuse_bytes(at, "a slot of meshes names no mesh");
    slots.push_back({number >= 0 ? meshes[static_cast<std::size_t>(number)] : nullptr});
  }
  return slots;
}

void write_meshes(const std::vector<SharedMesh>& meshes, ByteWriter& writer) {
  SolidList list;
  const std::vector<std::int32_t> numbers = list.numbers_of({}, meshes).meshes;
  write_mesh_solids(list.solids().meshes, writer);
  write_mesh_slots(numbers, writer);
}

std::vector<SharedMesh> read_meshes(ByteReader& reader) {
  std::vector<MeshPointer> meshes;
  read_mesh_solids(reader, meshes);
  return read_mesh_slots(reader, meshes);
}

}  // namespace scree
