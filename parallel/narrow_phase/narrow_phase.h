// Scratch of collide: the pairs of this step, grouped by the types of their shapes and by whether they have
// touched.
#pragma once

#include <core/world/column.h>
#include <core/world/world_data.h>
#include <simd/collide/collide_kernels.h>

#include <array>
#include <cstdint>

namespace scree {

struct NarrowPhase : Part {
  // Pairs handled by one chunk of the passes over pairs.
  static constexpr int kPairChunk = 1024;
  // Chunks of pairs that are no contacts in one round: their rows, 2 MB of manifolds, stay in the caches.
  static constexpr int kRoundChunks = 64;
  // Groups: the collide types of pairs that are contacts, then those of pairs that are not.
  static constexpr std::size_t kGroups = 2 * simd::kCollideTypes;
  using Counts = std::array<std::int32_t, kGroups>;
  struct Outcome {          // of one chunk of pairs
    std::int32_t touching;  // contacts of an awake dynamic body, then where they go
    std::int32_t resting;   // other contacts
    std::int32_t lost;      // contacts that are no more, then where they go
  };

  Column<std::uint8_t> kind;    // scratch; per pair: collide type, kSkipped or kNever
  Column<Counts> chunk_counts;  // scratch; per chunk of pairs: how many of each group, then where they go
  Column<Outcome> outcomes;     // scratch; per chunk of pairs
  Column<std::int32_t> order;   // scratch; the pairs by group, ascending
  Column<std::int32_t> unused;  // scratch; rows that a round took in vain
  Column<std::int32_t> places;  // scratch; of list_where
  std::array<std::int32_t, kGroups + 1> group_begin{};  // first pair of each group in `order`

  void report(const Visit& visit) const override;
};

}  // namespace scree
