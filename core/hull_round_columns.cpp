#include <core/hull_round_columns.h>

#include <array>
#include <cmath>

namespace scree {

namespace {

using Numbers = std::array<double, 3>;

Numbers numbers_of(Vec3 v) { return {double(v.x), double(v.y), double(v.z)}; }
Numbers difference(Vec3 to, Vec3 from) {
  const Numbers a = numbers_of(to), b = numbers_of(from);
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
double dot(const Numbers& a, const Numbers& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

std::size_t padded(std::size_t count) {
  constexpr std::size_t kBlock = kHullPadding;
  return (count + kBlock - 1) / kBlock * kBlock;
}

struct SidePlane {
  float normal[3];
  float offset;
};

// The plane through a face's side and along the face's normal. In double precision, because the sides of a
// sliver are short.
SidePlane side_plane(Vec3 begin, Vec3 end, const HullTopology::Plane& face) {
  const Numbers way = difference(end, begin);
  const Numbers up{double(face.normal[0]), double(face.normal[1]), double(face.normal[2])};
  Numbers side{way[1] * up[2] - way[2] * up[1], way[2] * up[0] - way[0] * up[2],
               way[0] * up[1] - way[1] * up[0]};
  const double scale = 1.0 / std::sqrt(dot(side, side));
  for (double& x : side) x *= scale;
  return {{float(side[0]), float(side[1]), float(side[2])}, float(dot(side, numbers_of(begin)))};
}

void fill_edge(const HullTopology& topology, std::size_t index, float* const (&column)[13], std::size_t to) {
  const HullTopology::Edge& edge = topology.edges[index];
  const Vec3 begin = topology.vertices[edge.vertex[0]];
  const Numbers point = numbers_of(begin), way = difference(topology.vertices[edge.vertex[1]], begin);
  for (std::size_t k = 0; k < 3; ++k) {
    column[k][to] = float(point[k]);
    column[3 + k][to] = float(way[k]);
    column[6 + k][to] = topology.planes[edge.face[0]].normal[k];
    column[9 + k][to] = topology.planes[edge.face[1]].normal[k];
  }
  column[12][to] = float(1.0 / dot(way, way));
}

}  // namespace

HullRoundData make_round_columns(const HullTopology& topology, HullRoundColumns& columns) {
  const std::size_t edges = topology.edges.size(), edge_rows = padded(edges);
  const std::size_t sides = topology.loops.size(), side_rows = padded(sides) + kHullPadding;
  const std::size_t faces = topology.planes.size();
  columns.numbers.resize(13 * edge_rows + 4 * side_rows);
  columns.indices.resize(2 * edge_rows + padded(faces + 1));
  HullRoundData data{};

  float* edge_column[13];
  for (std::size_t k = 0; k < 13; ++k) edge_column[k] = columns.numbers.data() + k * edge_rows;
  std::int32_t* edge_face[2] = {columns.indices.data(), columns.indices.data() + edge_rows};
  for (std::size_t row = 0; row < edge_rows; ++row) {
    const std::size_t index = row < edges ? row : 0;
    fill_edge(topology, index, edge_column, row);
    for (std::size_t side = 0; side < 2; ++side) edge_face[side][row] = topology.edges[index].face[side];
  }
  for (std::size_t k = 0; k < 3; ++k) {
    data.edge_point[k] = edge_column[k];
    data.edge_way[k] = edge_column[3 + k];
    data.edge_normal_0[k] = edge_column[6 + k];
    data.edge_normal_1[k] = edge_column[9 + k];
  }
  data.edge_inverse = edge_column[12];
  data.edge_face[0] = edge_face[0];
  data.edge_face[1] = edge_face[1];

  float* side_column[4];
  for (std::size_t k = 0; k < 4; ++k) {
    side_column[k] = columns.numbers.data() + 13 * edge_rows + k * side_rows;
  }
  std::int32_t* side_begin = columns.indices.data() + 2 * edge_rows;
  for (std::size_t face = 0; face < faces; ++face) {
    const std::size_t begin = topology.begin[face], end = topology.begin[face + 1];
    side_begin[face] = static_cast<std::int32_t>(begin);
    for (std::size_t corner = begin; corner < end; ++corner) {
      const std::size_t next = corner + 1 < end ? corner + 1 : begin;
      const SidePlane plane = side_plane(topology.vertices[topology.loops[corner]],
                                         topology.vertices[topology.loops[next]], topology.planes[face]);
      for (std::size_t k = 0; k < 3; ++k) side_column[k][corner] = plane.normal[k];
      side_column[3][corner] = plane.offset;
    }
  }
  side_begin[faces] = static_cast<std::int32_t>(sides);
  for (std::size_t k = 0; k < 3; ++k) data.side_normal[k] = side_column[k];
  data.side_offset = side_column[3];
  data.side_begin = side_begin;
  return data;
}

}  // namespace scree
