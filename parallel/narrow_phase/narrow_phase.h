// Scratch of collide: the pairs of this step, grouped by the types of their shapes and by whether they have
// touched.
#pragma once

#include <core/world/column.h>
#include <core/world/world_data.h>
#include <simd/collide/collide_kernels.h>

#include <array>
#include <cstdint>

namespace scree {

// Pairs handled by one chunk of the passes over pairs.
inline constexpr int kPairChunk = 1024;
// Chunks of pairs that are no contacts in one round: their rows, 2 MB of manifolds, stay in the caches.
inline constexpr int kRoundChunks = 64;
// Groups: the collide types of pairs that are contacts, then those of pairs that are not.
inline constexpr std::size_t kPairGroups = 2 * simd::kCollideTypes;
using GroupCounts = TableArray<std::int32_t, kPairGroups>;
using GroupBegins = TableArray<std::int32_t, kPairGroups + 1>;

struct PairOutcome {     // of one chunk of pairs
  std::int32_t active;   // contacts of an awake dynamic body, then where they go
  std::int32_t resting;  // other contacts
  std::int32_t lost;     // contacts that are no more, then where they go
};

// clang-format off
#define SCREE_NARROW_PHASE_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                             \
  LIST (scratch, std::uint8_t, kind)            /* per pair: collide type, kSkipped or kNever */                \
  LIST (scratch, GroupCounts,  chunk_counts)    /* per chunk of pairs: how many of each group, then where they go */ \
  LIST (scratch, PairOutcome,  outcomes)        /* per chunk of pairs */                                        \
  LIST (scratch, std::int32_t, order)           /* the pairs by group, ascending */                             \
  LIST (scratch, std::int32_t, unused)          /* rows that a round took in vain */                            \
  LIST (scratch, std::int32_t, places)          /* of list_where */                                             \
  VALUE(scratch, GroupBegins,  group_begin, {}) /* first pair of each group in `order` */
// clang-format on
SCREE_PART(NarrowPhase, SCREE_NARROW_PHASE_MEMBERS)

}  // namespace scree
