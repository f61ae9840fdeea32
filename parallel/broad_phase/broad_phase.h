// BroadPhase: the trees and lists that finding pairs keeps between steps. Only update_bounds, find_pairs and
// sweep_fast_bodies use it.
#pragma once

#include <core/world/world_data.h>
#include <parallel/continuous/sweep_motion.h>
#include <parallel/crew/crew.h>
#include <simd/broad_phase/pair_kernels.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace scree {

using TreeLevels = TableArray<Column<simd::NodeBlock>, simd::kMaxTreeLevels>;

// One tree over shapes. Nothing of it reaches the results: whether two shapes become a pair
// depends on their own bounds, and the list is sorted. So it is all derived.
// clang-format off
#define SCREE_PAIR_TREE_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                                \
  LIST (derived, std::int32_t,    order)          /* shapes along a Hilbert curve, whole blocks; -1: none (any  \
                                                     more). While it is unsorted, in any order, those that have \
                                                     left among them */                                         \
  LIST (derived, simd::LeafBlock, leaves)                                                                       \
  TABLE(derived, TreeLevels,      nodes, "broad_phase.trees")                                                   \
  VALUE(derived, int,             levels, 0)                                                                    \
  VALUE(derived, std::int32_t,    members, 0)                                                                   \
  VALUE(derived, std::int32_t,    appended, 0)    /* places behind the sorted ones, of what moves */            \
  VALUE(derived, int,             refits, 0)      /* since the last sort */                                     \
  VALUE(derived, bool,            unsorted, true) /* must be sorted before the next join */                     \
  VALUE(derived, bool,            lost_members, false) /* `order` still names shapes that have left */          \
  VALUE(derived, bool,            marks_changed, true) /* the marks of LeafBlock must be made anew */
// clang-format on
SCREE_STORE(PairTree, SCREE_PAIR_TREE_MEMBERS)

inline int leaf_blocks(const PairTree& tree) { return static_cast<int>(tree.order.size() / simd::kBlock); }
// No shape is in it; the memory stays.
inline void clear_tree(PairTree& tree) noexcept { tree.forget(ColumnKind::derived); }

// The tree that a shape is in. Frozen shapes, which are fixed or asleep, have several: a new one goes into
// the smallest, and a full tree is merged into the next larger one. So an arrival costs little however many
// shapes there are, and joins visit few trees.
enum TreeIndex : std::uint8_t {
  kNoTree = 0,
  kAwakeTree = 1,
  kKinematicTree = 2,
  kFrozenTree = 3,  // the first one
};
inline constexpr int kFrozenTrees = 9;
inline constexpr int kPairTrees = kFrozenTree + kFrozenTrees;
inline constexpr std::uint8_t kArriving = 0xff;  // waits for a place in one of the frozen trees

inline bool is_frozen_tree(std::uint8_t tree) { return tree >= kFrozenTree; }

struct SortKey {
  std::uint64_t key;   // place along the curve, or of a pair in its order
  std::int32_t shape;  // or the row of the pair
  std::int32_t padding;
};

// A leaf of one of the frozen trees.
struct TreeLeaf {
  std::int32_t tree, block;
};

// Of the centers of one chunk of shapes.
struct CenterSpread {
  double sum[3];
  std::int64_t count;
};

using PairTrees = TableArray<PairTree, kPairTrees>;
using JoinedShapes = TableArray<Column<std::int32_t>, kFrozenTree>;
using FoundPairs = std::vector<Column<ShapePair>>;

// clang-format off
#define SCREE_BROAD_PHASE_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                              \
  VALUE(derived, std::atomic<bool>, bounds_left, true) /* update_bounds: a shape has new fat bounds. Where it is \
                                                   not known, true is as good: the list of pairs is made anew   \
                                                   then, and comes out the same */                              \
  LIST (scratch, std::uint8_t,  has_left)       /* by place in Shapes::moving: whether it has new fat bounds */  \
  LIST (derived, std::int32_t,  left)           /* update_bounds; the shapes with new fat bounds since the last \
                                                   list, ... */                                                 \
  VALUE(derived, bool,          left_is_known, false) /* ... if these are all, and few, and no call has changed \
                                                   any shape */                                                 \
  VALUE(derived, bool,          few_moved, false) /* the last list kept the pairs of shapes that had not left   \
                                                   their bounds */                                              \
  LIST (scratch, std::uint8_t,  is_moved)       /* per shape: is in `left`; all zero outside find_pairs */      \
  LIST (derived, std::uint8_t,  tree_of)        /* TreeIndex of each shape, kNoTree if dead */                  \
  LIST (derived, std::int32_t,  slot_of)        /* of shapes in frozen trees: their place in PairTree::order */ \
  TABLE(derived, PairTrees,     trees, "broad_phase.trees") /* by TreeIndex; kNoTree stays empty */             \
  LIST (derived, std::int32_t,  changed)        /* update_bounds, refresh_lists, find_pairs: shapes that may be \
                                                   in another tree than they belong to, or whose box there is   \
                                                   an old one; some more than once */                           \
  LIST (scratch, std::int32_t,  arrivals)       /* for the frozen trees */                                      \
  TABLE(scratch, JoinedShapes,  joined, "broad_phase") /* for the others */                                     \
  LIST (scratch, std::int32_t,  gathered)       /* members of a tree that is about to be sorted */              \
  LIST (scratch, std::int32_t,  part)           /* a part of `gathered` */                                      \
  LIST (scratch, TreeLeaf,      thinned)        /* leaves of frozen trees that a shape has left */              \
  LIST (scratch, std::int32_t,  leavers)        /* shapes that have left their frozen tree, or their box there ... */ \
  VALUE(scratch, bool,          all_left, true) /* ... or it is not known which */                              \
  VALUE(derived, std::int64_t,  refitted, 0)    /* leaf blocks of frozen trees that the last list of pairs made \
                                                   anew */                                                      \
  LIST (scratch, std::int32_t,  dirty)          /* shapes that calls changed since the last list */             \
  LIST (scratch, std::int32_t,  displaced)      /* update_bounds; shapes that calls changed since the last narrow \
                                                   phase */                                                     \
  LIST (scratch, std::uint8_t,  is_dirty)       /* per shape; all zero outside find_pairs and while nothing was \
                                                   dirty */                                                     \
  LIST (scratch, std::int32_t,  fast)           /* sweep_fast_bodies; bodies that are swept, ascending */       \
  LIST (scratch, sweeps::StepEnd, step_ends)    /* sweep_fast_bodies; by place in `fast` */                     \
  LIST (scratch, sweeps::Course, courses)       /* sweep_fast_bodies; by place in `fast` */                     \
  LIST (scratch, sweeps::MovingPair, meeting_pairs) /* sweep_fast_bodies; of bodies that move, one of them fast */ \
  LIST (scratch, float,         meeting_times)  /* by `meeting_pairs`; of the first meeting */                   \
  LIST (scratch, std::int32_t,  meets_begin)    /* by place in `fast`, one more: where its pairs begin in ... */ \
  LIST (scratch, std::int32_t,  meets_of)       /* ... this list of places in `meeting_pairs` */                 \
  LIST (scratch, float,         stop_times)     /* by place in `fast` */                                        \
  LIST (scratch, sweeps::Meet,  meets)          /* a heap, the next one first */                                \
  LIST (scratch, std::int32_t,  fast_counts)    /* of list_where */                                           \
  LIST (scratch, CenterSpread,  spreads)                                                                        \
  LIST (scratch, SortKey,       sort_keys)                                                                      \
  LIST (scratch, SortKey,       sort_keys_other)                                                                \
  LIST (scratch, std::uint32_t, digit_counts)                                                                   \
  TABLE(scratch, FoundPairs,    found, "broad_phase") /* pairs of one chunk of the join */                      \
  LIST (scratch, std::int32_t,  bucket_counts)  /* per group of join chunks and bucket */                       \
  LIST (scratch, std::int64_t,  bucket_begins)  /* one more than buckets */                                     \
  LIST (scratch, std::uint8_t,  bucket_is_heavy) /* a row too long for one thread */                            \
  LIST (scratch, std::int32_t,  owner_begins)   /* per worker, for the bucket at hand */                        \
  LIST (scratch, ShapePair,     bucketed)       /* grouped by bucket; later, pairs of the last list that stay */ \
  LIST (scratch, std::int32_t,  others)         /* larger shapes of the pairs, grouped by owner */              \
  LIST (scratch, ShapePair,     sorted)         /* the new list */                                              \
  LIST (scratch, ShapePair,     merged)         /* the new list and pairs of the last one */                    \
  LIST (scratch, std::int32_t,  lost)           /* contacts whose pairs are not in the new list */              \
  LIST (scratch, std::int32_t,  moving_pairs)   /* places in a list: pairs not of two frozen shapes ... */      \
  LIST (scratch, std::int32_t,  frozen_pairs)   /* ... and of two */                                            \
  LIST (scratch, std::int32_t,  by_pair)        /* places in `resting` in the order of their pairs */           \
  LIST (scratch, std::int32_t,  moving_last_place) /* Contacts::last_place of `moving_pairs` */                 \
  TABLE(scratch, PairRows,      pulled, "broad_phase") /* rows on their way from or to `resting` */             \
  LIST (scratch, std::int32_t,  places)         /* of list_where */
// clang-format on
SCREE_PART(BroadPhase, SCREE_BROAD_PHASE_MEMBERS)

// The trees that fast bodies are swept against: kinematic and frozen shapes. A fixed shape that a call has
// just created or moved is in the kinematic tree for one step.
inline std::span<const PairTree> obstacle_trees(const BroadPhase& broad_phase) {
  return std::span(broad_phase.trees).subspan(kKinematicTree);
}
inline std::span<const PairTree> frozen_trees(const BroadPhase& broad_phase) {
  return std::span(broad_phase.trees).subspan(kFrozenTree);
}

// The world's broad phase, made at first use.
BroadPhase& broad_phase_of(WorldData& data);
// Fat bounds of the shapes that calls changed.
void update_dirty_bounds(WorldData& data, BroadPhase& broad_phase, float dt, Crew& crew);
// The narrow phase has seen where calls have put shapes: they are at rest again.
void forget_displaced(WorldData& data);

inline bool bounds_meet(const BoundsRow& x, const BoundsRow& y) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(x.lower[axis] <= y.upper[axis] && y.lower[axis] <= x.upper[axis])) return false;
  }
  return true;
}

// Whether filters, bodies and their types let two shapes collide.
bool may_collide(const WorldData& data, std::int32_t a, std::int32_t b);

// Moves the changed shapes into the trees that they belong to; returns whether any has changed its tree since
// the last list. Rebuilds the trees of frozen shapes at once, and marks the others for refit_trees.
bool update_members(WorldData& data, BroadPhase& broad_phase, Crew& crew);
// Makes the trees of awake and kinematic shapes fit their bounds.
void refit_trees(WorldData& data, BroadPhase& broad_phase, Crew& crew);
// Sizes leaves and levels for so many leaf blocks, and empties the places behind the last block of each
// level. Returns the number of levels.
int lay_out_levels(std::size_t blocks, Column<simd::LeafBlock>& leaves, TreeLevels& nodes);
// Sorts `gathered` along the curve, as the tree's new order.
void sort_gathered(const WorldData& data, BroadPhase& broad_phase, PairTree& tree, Crew& crew);
// The same for shapes that are in this order already.
void take_gathered(const BroadPhase& broad_phase, PairTree& tree, Crew& crew);
// Computes the boxes of all blocks of the tree's order.
void refit_tree(const WorldData& data, PairTree& tree, Crew& crew);
// Computes the boxes of one leaf and of all nodes above it.
void refit_leaf(const WorldData& data, PairTree& tree, std::int32_t block, Crew& crew);
// Adds rows in the order of their pairs, none of which is in the list, to Contacts::pairs.
void add_pairs(WorldData& data, const PairRows& added, Crew& crew);
// Moves all pairs at rest there, until the next list of pairs.
void pull_all_pairs(WorldData& data, Crew& crew);
// Moves the pairs at rest of these bodies there.
void pull_pairs_of(WorldData& data, std::span<const std::int32_t> bodies, Crew& crew);
// Which pairs a join finds.
enum class JoinScope {
  all,
  all_and_carried,  // and the pairs of the last list whose shapes are both still frozen
  moved,            // those with a shape of BroadPhase::left
};
// trees -> found. Returns the number of pairs.
std::int64_t join_trees(WorldData& data, BroadPhase& broad_phase, JoinScope scope, Crew& crew);
// Whether the new list can differ from the last one only by pairs with shapes of BroadPhase::left. Marks
// these then.
bool mark_few_moved(WorldData& data, BroadPhase& broad_phase, Crew& crew);
// Adds the other pairs of the last list to `sorted`.
void keep_other_pairs(WorldData& data, BroadPhase& broad_phase, Crew& crew);
// The new list is made: empties `left`, and clears the marks.
void forget_left(BroadPhase& broad_phase);
// found -> sorted.
void sort_pairs(BroadPhase& broad_phase, std::size_t shapes, std::int64_t pairs, Crew& crew);

// Sorts `rows` ascending by the bits of their keys. `other` has the same length and is overwritten. Returns
// the array that holds the result.
SortKey* sort_by_key(SortKey* rows, SortKey* other, std::int32_t count, Column<std::uint32_t>& digit_counts,
                     Crew& crew);
ShapePair* sort_by_key(ShapePair* rows, ShapePair* other, std::int32_t count,
                       Column<std::uint32_t>& digit_counts, Crew& crew);

// Sorts numbers of rows by the pairs of these rows. No two rows have the same pair, but a row may be named
// more than once.
void sort_by_pair(BroadPhase& broad_phase, const Column<ShapePair>& pair_of, Column<std::int32_t>& rows,
                  Crew& crew);
inline constexpr std::size_t kSortedMemory = 65536;  // keys; memory for more of them is freed after sorting

}  // namespace scree
