// The kernels' view of a hull: one aligned allocation that holds HullData and its columns.
#pragma once

#include <core/geometry/hull/hull_round_columns.h>
#include <core/geometry/hull/hull_topology.h>
#include <core/plain/hull.h>

#include <cstddef>
#include <memory>

namespace scree {

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
