// The columns of a hull that spheres and capsules need: edges, and the planes that bound each face.
#pragma once

#include <core/geometry/hull/hull_topology.h>
#include <core/plain/hull.h>
#include <core/world/column.h>

namespace scree {

// What HullRoundData points into. May be moved, not copied.
struct HullRoundColumns {
  Column<float> numbers;
  Column<std::int32_t> indices;
};

// Fills `columns` from a hull's topology and returns the pointers into them.
HullRoundData make_round_columns(const HullTopology& topology, HullRoundColumns& columns);

}  // namespace scree
