// Pairs where few shapes have left their fat bounds, as in a pile that settles: only pairs with one of these
// can be new or gone, so these are found, and the others are kept. The list is the same as if all were found.
//
// Shapes that fall asleep change their tree and keep their bounds: their pairs with what is awake stay in the
// list, and those with what is frozen are parted from it as ever. What wakes and what calls change make a
// whole new list.
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/broad_phase/merge_pairs.h>
#include <parallel/crew/list_where.h>

#include <algorithm>
#include <utility>

namespace scree {

namespace {

constexpr int kLeavesPerChunk = 64;

void note_moved(PairTree& tree, const BroadPhase& broad_phase, Crew& crew) {
  crew.run_ranges(leaf_blocks(tree), kLeavesPerChunk, [&](int begin, int end, int) {
    for (int block = begin; block < end; ++block) {
      simd::LeafBlock& leaf = tree.leaves[block];
      leaf.moved = 0;
      for (int slot = 0; slot < simd::kBlock; ++slot) {
        const std::int32_t shape = leaf.shape[slot];
        if (shape >= 0 && broad_phase.is_moved[shape] != 0) leaf.moved |= 1u << slot;
      }
    }
  });
}

}  // namespace

bool mark_few_moved(WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  const Column<std::int32_t>& left = broad_phase.left;
  if (!broad_phase.left_is_known || data.contacts.pairs_stale || !broad_phase.dirty.empty()) return false;
  if (!broad_phase.leavers.empty() || broad_phase.all_left) return false;
  const auto moves = [&](std::int32_t shape) {
    return broad_phase.tree_of[shape] == kAwakeTree || broad_phase.tree_of[shape] == kKinematicTree;
  };
  if (!std::all_of(left.begin(), left.end(), moves)) return false;
  broad_phase.is_moved.resize(data.shapes.flags.size());
  for (const std::int32_t shape : left) broad_phase.is_moved[shape] = 1;
  for (const std::uint8_t tree : {kAwakeTree, kKinematicTree}) {
    note_moved(broad_phase.trees[tree], broad_phase, crew);
  }
  return true;
}

void keep_other_pairs(WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  const Column<ShapePair>& last = data.contacts.pairs.pair;
  Column<ShapePair>&kept = broad_phase.bucketed, &sorted = broad_phase.sorted, &merged = broad_phase.merged;
  list_where(
      crew, last.size(), broad_phase.places, kept,
      [&](std::int32_t i) {
        return (broad_phase.is_moved[last[i].a] | broad_phase.is_moved[last[i].b]) == 0;
      },
      [&](std::int32_t i) { return last[i]; });
  merged.resize_discarding(kept.size() + sorted.size());
  merge_pairs(kept, sorted, crew, [&](std::size_t place, bool is_new, std::size_t row) {
    merged[place] = is_new ? sorted[row] : kept[row];
  });
  sorted.swap(merged);
}

void forget_left(BroadPhase& broad_phase) {
  for (const std::int32_t shape : broad_phase.left) {
    if (std::cmp_less(shape, broad_phase.is_moved.size())) broad_phase.is_moved[shape] = 0;
  }
  broad_phase.left.clear();
  broad_phase.left_is_known = true;
}

}  // namespace scree
