// Columns of a hull that spheres and capsules need, from its topology; see HullRoundData in
// core/plain/hull.h.
#include <core/geometry/hull/hull_columns.h>
#include <core/geometry/hull/hull_numbers.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

namespace scree {

namespace {

struct SidePlane {
  float normal[3];
  float offset;
};

// The plane through a face's side and along the face's normal. Uses double precision, because the sides of a
// sliver are short.
SidePlane side_plane(Vec3 begin, Vec3 end, const HullTopology::Plane& face) {
  Vector side = cross(to_vector(end) - to_vector(begin), to_vector(face.normal));
  const double scale = 1.0 / std::sqrt(dot(side, side));
  for (double& x : side) x *= scale;
  return {{float(side[0]), float(side[1]), float(side[2])}, float(dot(side, to_vector(begin)))};
}

void fill_edge(const HullTopology& topology, std::size_t index, float* const (&column)[13], std::size_t to) {
  const HullTopology::Edge& edge = topology.edges[index];
  const Vec3 begin = topology.vertices[edge.vertex[0]];
  const Vector point = to_vector(begin), way = to_vector(topology.vertices[edge.vertex[1]]) - point;
  for (std::size_t k = 0; k < 3; ++k) {
    column[k][to] = float(point[k]);
    column[3 + k][to] = float(way[k]);
    column[6 + k][to] = topology.planes[edge.face[0]].normal[k];
    column[9 + k][to] = topology.planes[edge.face[1]].normal[k];
  }
  column[12][to] = float(1.0 / dot(way, way));
}

struct EdgePlace {
  Vector middle;
  std::uint16_t index;
};

// Orders edges so that each block of 16 lies close together. Splits at a multiple of a block along the
// longest extent, then splits each half again.
void order_by_place(std::span<EdgePlace> edges) {
  const std::size_t blocks = (edges.size() + kHullPadding - 1) / kHullPadding;
  if (blocks < 2) return;
  Vector low = edges[0].middle, high = low;
  for (const EdgePlace& edge : edges) {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], edge.middle[k]);
      high[k] = std::max(high[k], edge.middle[k]);
    }
  }
  std::size_t axis = 0;
  for (const std::size_t k : {std::size_t(1), std::size_t(2)}) {
    if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
  }
  std::sort(edges.begin(), edges.end(), [axis](const EdgePlace& a, const EdgePlace& b) {
    return a.middle[axis] != b.middle[axis] ? a.middle[axis] < b.middle[axis] : a.index < b.index;
  });
  const std::size_t half = blocks / 2 * kHullPadding;
  order_by_place(edges.first(half));
  order_by_place(edges.subspan(half));
}

std::vector<EdgePlace> ordered_edges(const HullTopology& topology) {
  std::vector<EdgePlace> edges;
  for (std::size_t index = 0; index < topology.edges.size(); ++index) {
    const HullTopology::Edge& edge = topology.edges[index];
    const Vector a = to_vector(topology.vertices[edge.vertex[0]]);
    const Vector b = to_vector(topology.vertices[edge.vertex[1]]);
    edges.push_back(
        {{0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])}, static_cast<std::uint16_t>(index)});
  }
  order_by_place(edges);
  return edges;
}

// The ball about the mean of a block's edge middles that encloses all ends. Rounds its radius up.
void fill_block(const HullTopology& topology, std::span<const EdgePlace> edges, float* const (&column)[4],
                std::size_t to) {
  Vector center{};
  for (const EdgePlace& edge : edges) {
    for (std::size_t k = 0; k < 3; ++k) center[k] += edge.middle[k] / double(edges.size());
  }
  for (std::size_t k = 0; k < 3; ++k) column[k][to] = float(center[k]);
  const Vector rounded{double{column[0][to]}, double{column[1][to]}, double{column[2][to]}};
  double radius_2 = 0.0;
  for (const EdgePlace& edge : edges) {
    for (const std::uint8_t end : topology.edges[edge.index].vertex) {
      const Vector way = to_vector(topology.vertices[end]) - rounded;
      radius_2 = std::max(radius_2, dot(way, way));
    }
  }
  column[3][to] = std::nextafter(float(std::sqrt(radius_2)), 1e30f);
}

}  // namespace

HullRoundData make_round_columns(const HullTopology& topology, HullRoundColumns& columns) {
  const std::vector<EdgePlace> edges = ordered_edges(topology);
  const std::size_t edge_rows = padded(edges.size()), blocks = edge_rows / kHullPadding;
  const std::size_t block_rows = padded(blocks);
  const std::size_t sides = topology.loops.size(), side_rows = padded(sides) + kHullPadding;
  const std::size_t faces = topology.planes.size();
  columns.numbers.resize(13 * edge_rows + 4 * block_rows + 4 * side_rows);
  columns.indices.resize(2 * edge_rows + padded(faces + 1));
  HullRoundData data{};

  float* edge_column[13];
  for (std::size_t k = 0; k < 13; ++k) edge_column[k] = columns.numbers.data() + k * edge_rows;
  std::int32_t* edge_face[2] = {columns.indices.data(), columns.indices.data() + edge_rows};
  for (std::size_t row = 0; row < edge_rows; ++row) {
    const std::size_t index = edges[row < edges.size() ? row : (blocks - 1) * kHullPadding].index;
    fill_edge(topology, index, edge_column, row);
    for (std::size_t side = 0; side < 2; ++side) edge_face[side][row] = topology.edges[index].face[side];
  }
  float* block_column[4];
  for (std::size_t k = 0; k < 4; ++k) {
    block_column[k] = columns.numbers.data() + 13 * edge_rows + k * block_rows;
  }
  for (std::size_t row = 0; row < block_rows; ++row) {
    block_column[3][row] = -1e30f;
    if (row >= blocks) continue;
    const std::size_t begin = row * kHullPadding;
    const std::size_t count = std::min<std::size_t>(kHullPadding, edges.size() - begin);
    fill_block(topology, std::span(edges).subspan(begin, count), block_column, row);
  }
  data.edge_blocks = static_cast<std::int32_t>(blocks);
  for (std::size_t k = 0; k < 3; ++k) data.block_center[k] = block_column[k];
  data.block_radius = block_column[3];
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
    side_column[k] = columns.numbers.data() + 13 * edge_rows + 4 * block_rows + k * side_rows;
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
