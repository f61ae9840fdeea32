// Hulls of snapshots as bytes; see snapshot_hulls.h.
#include <core/geometry/hull/hull_build.h>
#include <core/geometry/hull/hull_stages.h>
#include <core/geometry/hull/hull_store.h>
#include <core/state/snapshot/snapshot_hulls.h>
#include <core/world/limits.h>

#include <cmath>

namespace scree {

namespace {

using Loops = std::vector<std::vector<std::int32_t>>;

// --- reading ---

struct SolidSize {
  std::size_t vertices, faces, corners;
};

SolidSize read_size(ByteReader& reader) {
  const std::size_t at = reader.at();
  const SolidSize size{reader.take<std::uint32_t>(), reader.take<std::uint32_t>(),
                       reader.take<std::uint32_t>()};
  const bool fits = size.vertices >= 4 && size.vertices <= kMaxHullVertices && size.faces >= 4 &&
                    size.faces <= kMaxHullFaces && size.corners <= 2 * kMaxHullEdges &&
                    2 * (size.vertices + size.faces) == size.corners + 4;  // Euler's formula
  if (!fits) refuse_bytes(at, "no polyhedron has so many vertices, faces and edges");
  return size;
}

std::vector<Vec3> read_vectors(ByteReader& reader, std::size_t count, float limit) {
  const std::size_t at = reader.at();
  std::vector<Vec3> vectors(count);
  std::memcpy(vectors.data(), reader.take_bytes(count * sizeof(Vec3)), count * sizeof(Vec3));
  const auto fits = [limit](float x) { return x >= -limit && x <= limit; };
  for (std::size_t i = 0; i < count; ++i) {
    if (fits(vectors[i].x) && fits(vectors[i].y) && fits(vectors[i].z)) continue;
    refuse_bytes(at + i * sizeof(Vec3), "a hull's point lies too far away");
  }
  return vectors;
}

void read_report(ByteReader& reader, HullReport& report) {
  for (std::size_t* count :
       {&report.given_points, &report.merged_points, &report.inner_points, &report.cut_vertices}) {
    *count = static_cast<std::size_t>(reader.take<std::uint64_t>());
  }
  const std::size_t at = reader.at();
  report.deviation = reader.take<float>();
  if (!(report.deviation >= 0.0f && report.deviation <= kMaxExtent)) {
    refuse_bytes(at, "a hull's deviation is out of range");
  }
}

// Faces whose sides meet in pairs, one there and one back, and that use all vertices.
Loops read_loops(ByteReader& reader, const SolidSize& size) {
  std::size_t at = reader.at(), corners = 0;
  Loops loops(size.faces);
  for (auto& loop : loops) {
    const auto count = reader.take<std::uint16_t>();
    corners += count;
    if (count < 3 || corners > size.corners) refuse_bytes(at, "a hull's face has a wrong number of corners");
    loop.resize(count);
  }
  if (corners != size.corners) refuse_bytes(at, "a hull's faces have a wrong number of corners");
  at = reader.at();
  const auto side_of = [&](std::int32_t from, std::int32_t to) {
    return static_cast<std::size_t>(from) * size.vertices + static_cast<std::size_t>(to);
  };
  std::vector<bool> sides(size.vertices * size.vertices), used(size.vertices), in_face(size.vertices);
  for (auto& loop : loops) {
    in_face.assign(size.vertices, false);
    for (std::int32_t& vertex : loop) {
      vertex = reader.take<std::uint8_t>();
      if (static_cast<std::size_t>(vertex) >= size.vertices) {
        refuse_bytes(reader.at() - 1, "a hull's corner names no vertex");
      }
      // Kernels have room for as many corners of a face as a hull has vertices.
      if (in_face[static_cast<std::size_t>(vertex)]) {
        refuse_bytes(reader.at() - 1, "a hull's face has a corner twice");
      }
      in_face[static_cast<std::size_t>(vertex)] = used[static_cast<std::size_t>(vertex)] = true;
    }
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const std::int32_t from = loop[k], to = loop[(k + 1) % loop.size()];
      if (from == to || sides[side_of(from, to)]) refuse_bytes(at, "a hull's face has a side twice");
      sides[side_of(from, to)] = true;
    }
  }
  for (const auto& loop : loops) {
    for (std::size_t k = 0; k < loop.size(); ++k) {
      if (!sides[side_of(loop[(k + 1) % loop.size()], loop[k])]) refuse_bytes(at, "a hull is not closed");
    }
  }
  for (const bool vertex_used : used) {
    if (!vertex_used) refuse_bytes(at, "a hull's vertex is no corner");
  }
  return loops;
}

bool all_finite(const float* numbers, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(numbers[i])) return false;
  }
  return true;
}

// Planes hold all vertices by the way they are made; corners must lie in them.
bool is_convex(const HullTopology& topology, float outer_radius) {
  const float tolerance = 1e-2f * outer_radius;  // merged faces keep to a hundredth of that
  for (std::size_t face = 0; face < topology.planes.size(); ++face) {
    const HullTopology::Plane& plane = topology.planes[face];
    if (!all_finite(plane.normal, 3) || !std::isfinite(plane.offset)) return false;
    for (std::size_t k = topology.begin[face]; k < topology.begin[face + 1]; ++k) {
      const Vec3& v = topology.vertices[topology.loops[k]];
      const float reach = plane.normal[0] * v.x + plane.normal[1] * v.y + plane.normal[2] * v.z;
      if (!(reach >= plane.offset - tolerance)) return false;
    }
  }
  return true;
}

bool has_finite_columns(const HullSolid& solid) {
  const HullData& data = *solid.columns.data;
  const auto edges = static_cast<std::size_t>(data.edge_count);
  for (int axis = 0; axis < 3; ++axis) {
    if (!all_finite(data.arc_middle[axis], edges) || !all_finite(data.arc_tilt[axis], edges)) return false;
  }
  const Column<float>& round = solid.columns.round.numbers;
  return all_finite(data.arc_middle_point, edges) && all_finite(data.arc_tilt_point, edges) &&
         all_finite(data.arc_cosine, edges) && all_finite(round.data(), round.size());
}

SharedHull read_slot(ByteReader& reader, std::span<const SolidPointer> solids) {
  const std::size_t begin = reader.at();
  const auto base = reader.take<std::int32_t>(), scaled = reader.take<std::int32_t>();
  Vec3 scale;
  for (float* axis : {&scale.x, &scale.y, &scale.z}) {
    const std::size_t at = reader.at();
    *axis = reader.take<float>();
    if (!(*axis >= kMinHullScale && *axis <= kMaxHullScale))
      refuse_bytes(at, "a hull's scale is out of range");
  }
  const std::size_t rounding_at = reader.at();
  const auto rounding = reader.take<float>();
  if (!(rounding >= 0.0f && rounding <= kMaxExtent))
    refuse_bytes(rounding_at, "a hull's rounding is out of range");
  const bool is_unit = scale == Vec3{1.0f, 1.0f, 1.0f};
  if (base == -1 && scaled == -1 && is_unit && rounding == 0.0f) return {};
  const auto count = static_cast<std::int32_t>(solids.size());
  const bool known = base >= 0 && base < count && scaled >= 0 && scaled < count;
  if (!known || (is_unit && base != scaled)) refuse_bytes(begin, "a slot of hulls names no solid");
  return shared_hull({HullAccess::hull(solids[static_cast<std::size_t>(base)]), scale, rounding},
                     solids[static_cast<std::size_t>(scaled)]);
}

}  // namespace

namespace {

void write_solid(const HullSolid& solid, ByteWriter& writer) {
  const HullTopology& topology = solid.topology;
  writer.put(static_cast<std::uint32_t>(topology.vertices.size()));
  writer.put(static_cast<std::uint32_t>(topology.planes.size()));
  writer.put(static_cast<std::uint32_t>(topology.loops.size()));
  for (const double coordinate : solid.origin) writer.put(coordinate);
  const HullReport& report = solid.report;
  for (const std::size_t count :
       {report.given_points, report.merged_points, report.inner_points, report.cut_vertices}) {
    writer.put(std::uint64_t{count});
  }
  writer.put(report.deviation);
  writer.put_bytes(topology.vertices.data(), topology.vertices.size() * sizeof(Vec3));
  writer.put_bytes(solid.points.data(), solid.points.size() * sizeof(Vec3));
  for (std::size_t face = 0; face < topology.planes.size(); ++face) {
    writer.put(static_cast<std::uint16_t>(topology.begin[face + 1] - topology.begin[face]));
  }
  writer.put_bytes(topology.loops.data(), topology.loops.size());
}

SolidPointer read_solid(ByteReader& reader) {
  const std::size_t begin = reader.at();
  const SolidSize size = read_size(reader);
  auto solid = std::make_shared<HullSolid>();
  for (double& coordinate : solid->origin) {
    const std::size_t at = reader.at();
    coordinate = reader.take<double>();
    if (!(std::abs(coordinate) <= 2.0 * double{kMaxExtent})) {
      refuse_bytes(at, "a hull's origin lies too far away");
    }
  }
  read_report(reader, solid->report);
  const std::vector<Vec3> vertices = read_vectors(reader, size.vertices, 4.0f * kMaxExtent);
  solid->points = read_vectors(reader, size.vertices, kMaxExtent);
  const Loops loops = read_loops(reader, size);
  solid->topology = make_topology(vertices, loops);
  complete_solid(*solid);
  const double volume = solid->integrals.volume;
  const bool sound =
      std::isfinite(volume) && volume > 0.0 && std::isfinite(solid->columns.data->outer_radius) &&
      is_convex(solid->topology, solid->columns.data->outer_radius) && has_finite_columns(*solid);
  if (!sound) refuse_bytes(begin, "a hull is no convex polyhedron");
  return solid;
}

}  // namespace

void write_solids(std::span<const SolidPointer> solids, ByteWriter& writer) {
  writer.put(static_cast<std::uint32_t>(solids.size()));
  for (const SolidPointer& solid : solids) write_solid(*solid, writer);
}

void read_solids(ByteReader& reader, std::vector<SolidPointer>& solids) {
  for (auto left = reader.take<std::uint32_t>(); left > 0; --left) solids.push_back(read_solid(reader));
}

void write_slots(const std::vector<SharedHull>& hulls, const std::vector<std::int32_t>& numbers,
                 ByteWriter& writer) {
  writer.put(static_cast<std::uint32_t>(hulls.size()));
  for (std::size_t slot = 0; slot < hulls.size(); ++slot) {
    writer.put(numbers[2 * slot]);
    writer.put(numbers[2 * slot + 1]);
    const Vec3& scale = hulls[slot].geometry.scale;
    for (const float axis : {scale.x, scale.y, scale.z}) writer.put(axis);
    writer.put(hulls[slot].geometry.rounding);
  }
}

std::vector<SharedHull> read_slots(ByteReader& reader, std::span<const SolidPointer> solids) {
  std::vector<SharedHull> hulls;
  for (auto left = reader.take<std::uint32_t>(); left > 0; --left) hulls.push_back(read_slot(reader, solids));
  return hulls;
}

void write_hulls(const std::vector<SharedHull>& hulls, ByteWriter& writer) {
  SolidList list;
  const std::vector<std::int32_t> numbers = list.numbers_of(hulls, {}).hulls;
  write_solids(list.solids().hulls, writer);
  write_slots(hulls, numbers, writer);
}

std::vector<SharedHull> read_hulls(ByteReader& reader) {
  std::vector<SolidPointer> solids;
  read_solids(reader, solids);
  return read_slots(reader, solids);
}

}  // namespace scree
