// Chunks of constraint blocks: what one task of the solver works on. Laid out by
// parallel/constraints/pack_blocks.cpp.
#pragma once

#include <cstddef>
#include <cstdint>

namespace scree::simd {

enum class BodySide : std::int32_t { none, a, b };

// Constraints of a hub that are solved at once, on every instruction set.
inline constexpr int kHubGroup = 16;

// A run of blocks of one variant within one color.
struct ConstraintChunk {
  std::int32_t variant;
  std::int32_t blocks;
  std::int32_t lanes;       // constraints in the run; the last block may be partly filled
  std::int32_t first_lane;  // into the rows in lane order
  std::size_t offset;       // bytes into the blocks
  std::int32_t number;      // of this chunk, for its figures
  BodySide hub;             // which body of the constraints is a hub, if any: one body for all lanes
  BodySide fixed;           // of joints: which body cannot be pushed, if any; its rows are not written
  bool peaks;               // of joints: the largest of their reactions counts, for some of them at least
};

}  // namespace scree::simd
