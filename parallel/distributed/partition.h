// Where each rank's part of the space is: recursive coordinate bisection. A cut halves a group of ranks and
// the weight of the bodies in its box, again and again, until each rank has a box of its own (M. Berger and
// S. Bokhari, "A partitioning strategy for nonuniform problems on multiprocessors", 1987).
//
// The outer boxes reach to infinity, so every point has a rank. Nothing of it enters the arithmetic of a
// step.
#pragma once

#include <scree/transport.h>

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace scree {

// Points below go to the lower half of the ranks.
struct Cut {
  std::int32_t axis = 0;
  float at = 0.0f;
};

struct Partition {
  std::vector<Cut> cuts;  // by the first rank of the upper half

  std::int32_t rank_of(const float (&point)[3]) const {
    std::int32_t begin = 0, end = static_cast<std::int32_t>(cuts.size());
    while (end - begin > 1) {
      const std::int32_t middle = begin + (end - begin) / 2;
      const Cut& cut = cuts[static_cast<std::size_t>(middle)];
      (point[cut.axis] < cut.at ? end : begin) = middle;
    }
    return begin;
  }
};

// The part of the space that is a rank's.
struct PartitionBox {
  float lower[3], upper[3];
};
PartitionBox box_of(const Partition& partition, std::int32_t rank);

// What a rank has of the world's weight.
struct WeightedPoint {
  float position[3];
  std::int32_t weight;  // at least 0
};

// Cuts the space so that all ranks get about the same weight. All ranks call it, each with its own points in
// the order of their rows, and get the same cuts. Who has which point decides about no more than the axes
// that these are across.
Partition cut_space(Transport& transport, std::span<const WeightedPoint> points);

}  // namespace scree
