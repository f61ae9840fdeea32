// Columns of a hull from its topology; see core/plain/hull.h.
#include <core/geometry/hull/hull_columns.h>
#include <core/geometry/hull/hull_numbers.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>

namespace scree {

namespace {

constexpr std::size_t kAlignment = 64;
constexpr float kFarOffset = 1e30f;  // m; padding planes are never the nearest

// Hands out pieces of one allocation. Only counts bytes while it has no memory.
class Allocation {
 public:
  explicit Allocation(void* memory) : memory_(static_cast<std::byte*>(memory)) {}

  template <class Row>
  Row* take(std::size_t rows) {
    Row* piece = memory_ != nullptr ? reinterpret_cast<Row*>(memory_ + used_) : nullptr;
    const std::size_t bytes = rows * sizeof(Row);
    used_ += (bytes + kAlignment - 1) / kAlignment * kAlignment;
    return piece;
  }
  std::size_t used() const { return used_; }

 private:
  std::byte* memory_;
  std::size_t used_ = 0;
};

struct Pieces {
  HullData* data;
  float* vertex[3];
  float* normal[3];
  float* offset;
  float* arc_middle[3];
  float* arc_middle_point;
  float* arc_tilt[3];
  float* arc_tilt_point;
  float* arc_cosine;
  HullEdge* edge;
  std::uint8_t* loop;
  std::uint16_t* loop_begin;
};

Pieces take_pieces(Allocation& allocation, const HullTopology& topology) {
  const std::size_t vertices = padded(topology.vertices.size()), faces = padded(topology.planes.size());
  Pieces pieces{};
  pieces.data = allocation.take<HullData>(1);
  for (float*& column : pieces.vertex) column = allocation.take<float>(vertices);
  for (float*& column : pieces.normal) column = allocation.take<float>(faces);
  pieces.offset = allocation.take<float>(faces);
  const std::size_t edges = padded(topology.edges.size());
  for (float*& column : pieces.arc_middle) column = allocation.take<float>(edges);
  pieces.arc_middle_point = allocation.take<float>(edges);
  for (float*& column : pieces.arc_tilt) column = allocation.take<float>(edges);
  pieces.arc_tilt_point = allocation.take<float>(edges);
  pieces.arc_cosine = allocation.take<float>(edges);
  pieces.edge = allocation.take<HullEdge>(topology.edges.size());
  pieces.loop = allocation.take<std::uint8_t>(topology.loops.size());
  pieces.loop_begin = allocation.take<std::uint16_t>(topology.begin.size());
  return pieces;
}

void fill_vertices(const Pieces& pieces, const HullTopology& topology) {
  const std::size_t count = topology.vertices.size();
  for (std::size_t i = 0; i < static_cast<std::size_t>(pieces.data->padded_vertices); ++i) {
    const Vec3& v = topology.vertices[i < count ? i : 0];
    pieces.vertex[0][i] = v.x;
    pieces.vertex[1][i] = v.y;
    pieces.vertex[2][i] = v.z;
  }
}

void fill_planes(const Pieces& pieces, const HullTopology& topology) {
  const std::size_t count = topology.planes.size();
  for (std::size_t i = 0; i < static_cast<std::size_t>(pieces.data->padded_faces); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      pieces.normal[k][i] = i < count ? topology.planes[i].normal[k] : 0.0f;
    }
    pieces.offset[i] = i < count ? topology.planes[i].offset : kFarOffset;
  }
}

// Rounds to the floats that the kernels will read.
Vector rounded(const Vector& v) {
  Vector result{};
  for (std::size_t k = 0; k < 3; ++k) result[k] = double{static_cast<float>(v[k])};
  return result;
}

// Middle of the arc between the normals of an edge's faces. The normals' sum vanishes for the edge of a
// blade; the sum of the directions along the arc vanishes for a flat edge. The two never vanish together.
Vector arc_middle(const Vector& normal_0, const Vector& normal_1, const Vector& along) {
  const double scale = 1.0 / std::sqrt(dot(along, along));
  const Vector forth = cross(along, normal_0), back = cross(normal_1, along);
  Vector sum{};
  for (std::size_t k = 0; k < 3; ++k) sum[k] = normal_0[k] + normal_1[k] + scale * (forth[k] + back[k]);
  const double inverse = 1.0 / std::sqrt(dot(sum, sum));
  for (double& x : sum) x *= inverse;
  return sum;
}

void fill_edge(const Pieces& pieces, const HullTopology& topology, std::size_t i) {
  const HullTopology::Edge& from = topology.edges[i];
  const Vector point = to_vector(topology.vertices[from.vertex[0]]);
  const Vector end = to_vector(topology.vertices[from.vertex[1]]);
  const Vector normal_0 = to_vector(topology.planes[from.face[0]].normal);
  const Vector normal_1 = to_vector(topology.planes[from.face[1]].normal);
  Vector along{}, tilt{};
  for (std::size_t k = 0; k < 3; ++k) {
    along[k] = end[k] - point[k];
    tilt[k] = 0.5 * (normal_1[k] - normal_0[k]);
  }
  const Vector middle = rounded(arc_middle(normal_0, normal_1, along));
  tilt = rounded(tilt);
  for (std::size_t k = 0; k < 3; ++k) {
    pieces.arc_middle[k][i] = static_cast<float>(middle[k]);
    pieces.arc_tilt[k][i] = static_cast<float>(tilt[k]);
  }
  pieces.arc_middle_point[i] = static_cast<float>(dot(middle, point));
  pieces.arc_tilt_point[i] = static_cast<float>(dot(tilt, point));
  pieces.arc_cosine[i] = round_down(std::min(dot(middle, normal_0), dot(middle, normal_1)));

  HullEdge& edge = *new (pieces.edge + i) HullEdge{};
  for (std::size_t k = 0; k < 3; ++k) {
    edge.point[k] = static_cast<float>(point[k]);
    edge.along[k] = static_cast<float>(along[k]);
    edge.normal_0[k] = static_cast<float>(normal_0[k]);
    edge.normal_1[k] = static_cast<float>(normal_1[k]);
  }
  for (std::size_t k = 0; k < 2; ++k) {
    edge.vertex[k] = from.vertex[k];
    edge.face[k] = from.face[k];
  }
}

void fill_edges(const Pieces& pieces, const HullTopology& topology) {
  const std::size_t count = topology.edges.size();
  for (std::size_t i = 0; i < count; ++i) fill_edge(pieces, topology, i);
  for (std::size_t i = count; i < static_cast<std::size_t>(pieces.data->padded_edges); ++i) {
    for (std::size_t k = 0; k < 3; ++k) pieces.arc_middle[k][i] = pieces.arc_tilt[k][i] = 0.0f;
    pieces.arc_middle_point[i] = kFarOffset;
    pieces.arc_tilt_point[i] = 0.0f;
    pieces.arc_cosine[i] = 1.0f;
  }
}

void fill_loops(const Pieces& pieces, const HullTopology& topology) {
  std::copy(topology.loops.begin(), topology.loops.end(), pieces.loop);
  std::copy(topology.begin.begin(), topology.begin.end(), pieces.loop_begin);
}

// Radius of a ball within the hull. Planes lie outside the hull by rounding, so it takes each face's lowest
// corner.
double inner_radius(const HullTopology& topology) {
  double radius = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < topology.planes.size(); ++f) {
    const float* n = topology.planes[f].normal;
    for (std::size_t k = topology.begin[f]; k < topology.begin[f + 1]; ++k) {
      const Vec3& v = topology.vertices[topology.loops[k]];
      radius = std::min(radius, double{n[0]} * v.x + double{n[1]} * v.y + double{n[2]} * v.z);
    }
  }
  return std::max(radius, 0.0);
}

double outer_radius(const HullTopology& topology) {
  double squared = 0.0;
  for (const Vec3& v : topology.vertices) {
    squared = std::max(squared, double{v.x} * v.x + double{v.y} * v.y + double{v.z} * v.z);
  }
  return std::sqrt(squared);
}

}  // namespace

void FreeColumns::operator()(void* memory) const noexcept { std::free(memory); }

HullColumns make_hull_columns(const HullTopology& topology) {
  Allocation counter(nullptr);
  take_pieces(counter, topology);
  HullColumns columns;
  columns.bytes = counter.used();
  columns.memory.reset(std::aligned_alloc(kAlignment, columns.bytes));
  if (columns.memory == nullptr) throw std::bad_alloc();
  Allocation allocation(columns.memory.get());
  const Pieces pieces = take_pieces(allocation, topology);
  HullData* data = new (pieces.data) HullData{};
  data->vertex_count = static_cast<std::int32_t>(topology.vertices.size());
  data->edge_count = static_cast<std::int32_t>(topology.edges.size());
  data->face_count = static_cast<std::int32_t>(topology.planes.size());
  data->padded_vertices = static_cast<std::int32_t>(padded(topology.vertices.size()));
  data->padded_edges = static_cast<std::int32_t>(padded(topology.edges.size()));
  data->padded_faces = static_cast<std::int32_t>(padded(topology.planes.size()));
  data->inner_radius = round_down(inner_radius(topology));
  data->outer_radius = round_up(outer_radius(topology));
  for (int k = 0; k < 3; ++k) {
    data->vertex[k] = pieces.vertex[k];
    data->normal[k] = pieces.normal[k];
  }
  for (int k = 0; k < 3; ++k) {
    data->arc_middle[k] = pieces.arc_middle[k];
    data->arc_tilt[k] = pieces.arc_tilt[k];
  }
  data->offset = pieces.offset;
  data->arc_middle_point = pieces.arc_middle_point;
  data->arc_tilt_point = pieces.arc_tilt_point;
  data->arc_cosine = pieces.arc_cosine;
  data->edge = pieces.edge;
  data->loop = pieces.loop;
  data->loop_begin = pieces.loop_begin;
  fill_vertices(pieces, topology);
  fill_planes(pieces, topology);
  fill_edges(pieces, topology);
  fill_loops(pieces, topology);
  data->round = make_round_columns(topology, columns.round);
  columns.bytes += columns.round.numbers.capacity_bytes() + columns.round.indices.capacity_bytes();
  columns.data = data;
  return columns;
}

}  // namespace scree
