// The kernels' view of a hull: one aligned allocation that holds HullData and its columns.
#pragma once

#include <core/geometry/hull/hull_topology.h>
#include <core/plain/hull.h>
#include <core/world/column.h>

#include <cstddef>
#include <memory>

namespace scree {

// The columns that spheres and capsules need (hull_round_columns.cpp): edges, and the planes that bound each
// face.

// The memory that HullRoundData points into. May be moved, not copied.
struct HullRoundColumns {
  Column<float> numbers;
  Column<std::int32_t> indices;
};

// Fills `columns` from a hull's topology and returns the pointers into them.
HullRoundData make_round_columns(const HullTopology& topology, HullRoundColumns& columns);

struct FreeColumns {
  void operator()(void* memory) const noexcept;
};

struct HullColumns {
  std::unique_ptr<void, FreeColumns> memory;
  const HullData* data = nullptr;  // at the beginning of `memory`
  HullRoundColumns round;          // what HullData::round points into
  std::size_t bytes = 0;
};

// Throws std::bad_alloc.
HullColumns make_hull_columns(const HullTopology& topology);

}  // namespace scree
