// BroadPhase: what finding pairs remembers between steps. Looked into by update_bounds and find_pairs only.
#pragma once

#include <core/world/world_data.h>
#include <parallel/crew/crew.h>
#include <simd/broad_phase/pair_kernels.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace scree {

// One tree over shapes. Nothing of it reaches the results: whether two shapes become a pair
// depends on their own bounds, and the list is sorted. So it is all derived.
struct PairTree {
  Column<std::int32_t> order;  // shapes along a Hilbert curve, whole blocks; -1: nobody (any more). While it
                               // is unsorted, in any order, those that have left among them
  Column<simd::LeafBlock> leaves;
  Column<simd::NodeBlock> nodes[simd::kMaxTreeLevels];
  int levels = 0;
  std::int32_t members = 0;
  std::int32_t appended = 0;    // places behind the sorted ones, of what moves
  int refits = 0;               // since the last sort
  bool unsorted = true;         // must be sorted before the next join
  bool lost_members = false;    // `order` still names shapes that have left
  bool special_changed = true;  // LeafBlock::special must be made anew
  int leaf_blocks() const { return static_cast<int>(order.size() / simd::kBlock); }
  void clear() noexcept;  // nobody is in it; the memory stays
};

// Which of its trees a shape is in. What is frozen stands in one of several: who arrives comes into the small
// one, which goes into the next larger one when it is full, and so on. So an arrival costs little however
// many are there already, and joins have few trees to ask.
enum TreeIndex : std::uint8_t {
  kNoTree = 0,
  kAwakeTree = 1,
  kKinematicTree = 2,
  kFrozenTree = 3,  // the first one
};
inline constexpr int kFrozenTrees = 9;
inline constexpr int kPairTrees = kFrozenTree + kFrozenTrees;
inline constexpr std::uint8_t kArriving = 0xff;  // will come into one of the frozen trees

inline bool is_frozen_tree(std::uint8_t tree) { return tree >= kFrozenTree; }

struct SortKey {
  std::uint64_t key;   // place along the curve, or of a pair in its order
  std::int32_t shape;  // or the row of the pair
  std::int32_t padding;
};

struct BroadPhase final : Part {
  // derived; update_bounds: a shape has new fat bounds. Where it is not known, true is as good: the list of
  // pairs is made anew then, and comes out the same.
  std::atomic<bool> bounds_left{true};

  Column<std::uint8_t> tree_of;  // derived; TreeIndex of each shape, kNoTree if dead
  Column<std::int32_t> slot_of;  // derived; of shapes in frozen trees: their place in PairTree::order
  PairTree trees[kPairTrees];    // by TreeIndex; kNoTree stays empty
  // What may be met without moving: fixed shapes that calls have just put somewhere stand with the kinematic
  // ones for one step.
  std::span<const PairTree> resting_trees() const { return std::span(trees).subspan(kKinematicTree); }
  std::span<const PairTree> frozen_trees() const { return std::span(trees).subspan(kFrozenTree); }

  // derived; update_bounds, refresh_lists, find_pairs: shapes that may be in another tree than they belong
  // to, or whose box there is an old one; some more than once
  Column<std::int32_t> changed;
  Column<std::int32_t> arrivals;             // scratch; for the frozen trees
  Column<std::int32_t> joined[kFrozenTree];  // scratch; for the others
  Column<std::int32_t> gathered, part;       // scratch; members of a tree that is about to be sorted
  struct LeafOf {
    std::int32_t tree, block;
  };
  Column<LeafOf> thinned;        // scratch; leaves of frozen trees that somebody has left
  Column<std::int32_t> leavers;  // scratch; shapes that have left their frozen tree, or their box there ...
  bool all_left = true;          // scratch; ... or nobody knows who
  std::int64_t refitted = 0;     // derived; leaf blocks of frozen trees that the last list of pairs made anew

  // Shapes that calls changed since the last list. scratch
  Column<std::int32_t> dirty;
  Column<std::uint8_t> is_dirty;  // per shape; all zero outside find_pairs and while nothing was dirty

  // sweep_fast_bodies. scratch
  Column<std::int32_t> fast;         // bodies that are swept, ascending
  Column<std::uint8_t> fast_hits;    // by place in `fast`
  Column<std::int32_t> fast_counts;  // by chunk of awake bodies, then where they go

  // scratch
  struct Spread {  // of the centers of one chunk of shapes
    double sum[3];
    std::int64_t count;
  };
  Column<Spread> spreads;
  Column<SortKey> sort_keys, sort_keys_other;
  Column<std::uint32_t> digit_counts;
  std::vector<Column<ShapePair>> found;  // pairs of one chunk of the join
  Column<std::int32_t> bucket_counts;    // per group of join chunks and bucket
  Column<std::int64_t> bucket_begins;    // one more than buckets
  Column<std::uint8_t> bucket_is_heavy;  // a row too long for one thread
  Column<std::int32_t> owner_begins;     // per worker, for the bucket at hand
  Column<ShapePair> bucketed;            // grouped by bucket
  Column<std::int32_t> others;           // larger shapes of the pairs, grouped by owner
  Column<ShapePair> sorted;              // the new list
  Column<std::int32_t> lost;             // contacts whose pairs are not in the new list
  Column<std::int32_t> moving, frozen;   // places in a list: pairs of two frozen shapes, and the others
  Column<std::int32_t> by_pair;          // places in `resting` in the order of their pairs
  Column<std::int32_t> moving_previous;  // Contacts::previous of `moving`
  PairRows pulled;                       // rows on their way from or to `resting`
  Column<std::int32_t> places;           // of list_where

  void report(const Visit& visit) const override;
  void forget() noexcept override;
};

// The world's broad phase, made at first use.
BroadPhase& broad_phase_of(WorldData& data);
// Fat bounds of the shapes that calls changed.
void update_dirty_bounds(WorldData& data, BroadPhase& broad_phase, float dt, Crew& crew);

// Whether filters, bodies and their types let two shapes collide.
bool may_collide(const WorldData& data, std::int32_t a, std::int32_t b);

// Brings the changed shapes into the trees that they belong to; returns whether any has come into another one
// since the last list. Trees of what moves are marked and made by refit_trees, those of frozen shapes are
// made at once.
bool update_members(WorldData& data, BroadPhase& broad_phase, Crew& crew);
// Makes the trees of what moves fit the bounds.
void refit_trees(WorldData& data, BroadPhase& broad_phase, Crew& crew);
// Orders `gathered` along the curve: that is the tree's order then.
void sort_gathered(const WorldData& data, BroadPhase& broad_phase, PairTree& tree, Crew& crew);
// The same of those that stand along the curve already.
void take_gathered(const BroadPhase& broad_phase, PairTree& tree, Crew& crew);
// Makes the boxes of all blocks of the tree's order.
void refit_tree(const WorldData& data, PairTree& tree, Crew& crew);
// Makes the boxes of one leaf and all above it.
void refit_leaf(const WorldData& data, PairTree& tree, std::int32_t block, Crew& crew);
// trees -> found; with `carry` also the pairs of the last list whose shapes are both frozen still. Returns
// the number of pairs.
std::int64_t join_trees(WorldData& data, BroadPhase& broad_phase, bool carry, Crew& crew);
// found -> sorted.
void sort_pairs(BroadPhase& broad_phase, std::size_t shapes, std::int64_t pairs, Crew& crew);

// Ascending by the bits of the keys of `rows`; `other` has the same length and is overwritten. Returns the
// one that holds the result.
SortKey* sort_by_key(SortKey* rows, SortKey* other, std::int32_t count, Column<std::uint32_t>& digit_counts,
                     Crew& crew);
ShapePair* sort_by_key(ShapePair* rows, ShapePair* other, std::int32_t count,
                       Column<std::uint32_t>& digit_counts, Crew& crew);

// Sorts numbers of rows by the pairs of these rows. No two rows have the same pair, but a row may be named
// more than once.
void sort_by_pair(BroadPhase& broad_phase, const Column<ShapePair>& pair_of, Column<std::int32_t>& rows,
                  Crew& crew);
inline constexpr std::size_t kSortedMemory = 65536;  // keys; what more took to sort is given back

}  // namespace scree
