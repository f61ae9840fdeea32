// Columns of a hull from its topology; see core/plain/hull.h.
#include <core/hull_columns.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>

namespace scree {

namespace {

constexpr std::size_t kAlignment = 64;
constexpr float kFarOffset = 1e30f;  // m; no plane that pads is ever the nearest

std::int32_t padded(std::size_t count) {
  const std::size_t block = static_cast<std::size_t>(kHullPadding);
  return static_cast<std::int32_t>((count + block - 1) / block * block);
}

float round_down(double value) {
  const float nearest = static_cast<float>(value);
  return double{nearest} > value ? std::nextafter(nearest, -std::numeric_limits<float>::infinity()) : nearest;
}
float round_up(double value) { return -round_down(-value); }

// Hands out pieces of one allocation. Without memory it only counts.
class Allocation {
 public:
  explicit Allocation(void* memory) : memory_(static_cast<std::byte*>(memory)) {}

  template <class Row>
  Row* take(std::int32_t rows) {
    Row* piece = memory_ != nullptr ? reinterpret_cast<Row*>(memory_ + used_) : nullptr;
    const std::size_t bytes = static_cast<std::size_t>(rows) * sizeof(Row);
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
};

Pieces take_pieces(Allocation& allocation, const HullTopology& topology) {
  const std::int32_t vertices = padded(topology.vertices.size()), faces = padded(topology.planes.size());
  Pieces pieces{};
  pieces.data = allocation.take<HullData>(1);
  for (float*& column : pieces.vertex) column = allocation.take<float>(vertices);
  for (float*& column : pieces.normal) column = allocation.take<float>(faces);
  pieces.offset = allocation.take<float>(faces);
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

// The planes hold the hull from outside; what is surely within it reaches to the lowest corner of each face.
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
  data->padded_vertices = padded(topology.vertices.size());
  data->padded_edges = padded(topology.edges.size());
  data->padded_faces = padded(topology.planes.size());
  data->inner_radius = round_down(inner_radius(topology));
  data->outer_radius = round_up(outer_radius(topology));
  for (int k = 0; k < 3; ++k) {
    data->vertex[k] = pieces.vertex[k];
    data->normal[k] = pieces.normal[k];
  }
  data->offset = pieces.offset;
  fill_vertices(pieces, topology);
  fill_planes(pieces, topology);
  data->round = make_round_columns(topology, columns.round);
  columns.bytes += columns.round.numbers.capacity_bytes() + columns.round.indices.capacity_bytes();
  columns.data = data;
  return columns;
}

}  // namespace scree
