// Members of the broad phase's trees: moves shapes between trees. Writes BroadPhase::tree_of, slot_of and the
// trees of frozen shapes; of the other trees only the lists of members.
//
// Frozen shapes are kept in trees of 64, 512, 4096 ... shapes (J. L. Bentley and J. B. Saxe, "Decomposable
// searching problems I: static-to-dynamic transformation", 1980). Arrivals go into the first tree that can
// hold them together with all smaller trees, which it empties. A shape that leaves leaves a hole. So a shape
// is sorted only a few times, and the work depends on how many arrive and leave.
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/crew/list_where.h>

#include <algorithm>
#include <utility>

namespace scree {

namespace {

constexpr std::int64_t kSmallestTree = 64;  // shapes; arrivals come in without being sorted
constexpr std::int64_t kTreeGrowth = 8;     // from one to the next: 4 sorts less often, and has more to ask

std::int64_t capacity_of(int level) {
  std::int64_t capacity = kSmallestTree;
  for (int i = 0; i < level; ++i) capacity *= kTreeGrowth;
  return capacity;
}

TreeKind kind_of(const Shapes& shapes, std::int32_t shape) {
  return (shapes.flags[shape] & kShapeAlive) != 0 ? shapes.tree[shape] : TreeKind::none;
}

TreeKind kind_of_tree(std::uint8_t tree) {
  return is_frozen_tree(tree) ? TreeKind::frozen : static_cast<TreeKind>(tree);
}
static_assert(static_cast<int>(TreeKind::awake) == kAwakeTree);
static_assert(static_cast<int>(TreeKind::kinematic) == kKinematicTree);

// The changed shapes are not known.
void compare_all(const Shapes& shapes, BroadPhase& broad_phase, Crew& crew) {
  list_where(crew, shapes.flags.size(), broad_phase.places, broad_phase.part, [&](std::int32_t shape) {
    return kind_of(shapes, shape) != kind_of_tree(broad_phase.tree_of[shape]);
  });
  broad_phase.changed.append(std::as_const(broad_phase.part).span());
}

void leave_frozen(BroadPhase& broad_phase, std::int32_t shape) {
  const std::uint8_t index = broad_phase.tree_of[shape];
  PairTree& tree = broad_phase.trees[index];
  const std::int32_t slot = broad_phase.slot_of[shape];
  SCREE_ASSERT(tree.order[slot] == shape);
  tree.order[slot] = -1;
  broad_phase.leavers.push_back(shape);
  --tree.members;
  broad_phase.thinned.push_back({index, slot / simd::kBlock});
}

// Removes the changed shapes from the trees that they leave, and lists them for those that they enter.
// Returns whether any enters another kind of tree.
bool sort_out(const Shapes& shapes, BroadPhase& broad_phase) {
  bool any = false;
  broad_phase.arrivals.clear();
  broad_phase.thinned.clear();
  for (Column<std::int32_t>& joined : broad_phase.joined) joined.clear();
  for (const std::int32_t row : broad_phase.changed) {
    std::uint8_t& index = broad_phase.tree_of[row];
    const TreeKind kind = kind_of(shapes, row), before = kind_of_tree(index);
    any = any || kind != before;
    if (kind == TreeKind::frozen) {
      if (index == kArriving) continue;  // stands in the list twice
    } else if (kind == before) {
      continue;
    }
    if (before == TreeKind::frozen) {
      leave_frozen(broad_phase, row);
    } else if (before != TreeKind::none) {
      --broad_phase.trees[index].members;
      broad_phase.trees[index].lost_members = true;
    }
    if (kind == TreeKind::frozen) {
      index = kArriving;
      broad_phase.arrivals.push_back(row);
      continue;
    }
    index = static_cast<std::uint8_t>(kind);
    if (kind != TreeKind::none) broad_phase.joined[index].push_back(row);
  }
  broad_phase.changed.clear();
  return any;
}

// Appends the shapes that have just entered a tree of awake or kinematic shapes.
void append_members(PairTree& tree, const Column<std::int32_t>& joined) {
  if (joined.empty()) return;
  const std::size_t begin = tree.order.size();
  tree.order.append(joined.span());
  while (tree.order.size() % simd::kBlock != 0) tree.order.push_back(-1);
  tree.members += static_cast<std::int32_t>(joined.size());
  tree.appended += static_cast<std::int32_t>(tree.order.size() - begin);
  tree.marks_changed = true;
  // Shapes behind the sorted ones may be anywhere, so there may be only few.
  if (tree.appended * std::int64_t{8} > tree.members) tree.unsorted = true;
}

// Recomputes the boxes of the leaves that shapes have left, each once. Clears trees that have become empty.
void close_ranks(const WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  using LeafOf = TreeLeaf;
  Column<LeafOf>& thinned = broad_phase.thinned;
  std::sort(thinned.begin(), thinned.end(), [](const LeafOf& x, const LeafOf& y) {
    return x.tree != y.tree ? x.tree < y.tree : x.block < y.block;
  });
  LeafOf last{-1, -1};
  for (const LeafOf& leaf : thinned) {
    PairTree& tree = broad_phase.trees[leaf.tree];
    if (leaf.tree == last.tree && leaf.block == last.block) continue;
    last = leaf;
    if (tree.members == 0) {
      clear_tree(tree);
      continue;
    }
    if (tree.levels == 0) continue;
    refit_leaf(data, tree, leaf.block, crew);
    ++broad_phase.refitted;
  }
}

// Puts the arrivals into the free places of the smallest tree.
void fill_smallest(const WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  PairTree& tree = broad_phase.trees[kFrozenTree];
  SCREE_ASSERT(static_cast<std::size_t>(tree.members) + broad_phase.arrivals.size() <= kSmallestTree);
  while (tree.order.size() < kSmallestTree) tree.order.push_back(-1);
  std::size_t slot = 0;
  for (const std::int32_t row : broad_phase.arrivals) {
    while (tree.order[slot] >= 0) ++slot;
    tree.order[slot] = row;
    broad_phase.tree_of[row] = kFrozenTree;
    broad_phase.slot_of[row] = static_cast<std::int32_t>(slot);
  }
  tree.members += static_cast<std::int32_t>(broad_phase.arrivals.size());
  tree.marks_changed = true;
  refit_tree(data, tree, crew);
  broad_phase.refitted += leaf_blocks(tree);
}

// Computes the boxes of a tree of frozen shapes whose order has just been written from `gathered`, and notes
// the place of each shape.
void settle_members(const WorldData& data, BroadPhase& broad_phase, int level, Crew& crew) {
  const auto index = static_cast<std::uint8_t>(kFrozenTree + level);
  PairTree& tree = broad_phase.trees[index];
  tree.members = static_cast<std::int32_t>(broad_phase.gathered.size());
  refit_tree(data, tree, crew);
  broad_phase.refitted += leaf_blocks(tree);
  crew.run_ranges(static_cast<int>(tree.order.size()), 4096, [&](int begin, int end, int) {
    for (int slot = begin; slot < end; ++slot) {
      const std::int32_t row = tree.order[slot];
      if (row < 0) continue;
      broad_phase.tree_of[row] = index;
      broad_phase.slot_of[row] = slot;
    }
  });
  if (broad_phase.gathered.size() <= kSortedMemory) return;
  broad_phase.sort_keys = {};
  broad_phase.sort_keys_other = {};
  broad_phase.gathered = {};
  broad_phase.part = {};
}

// Builds the tree of a level from the arrivals and the trees up to `last`, which become empty.
void merge_trees(const WorldData& data, BroadPhase& broad_phase, int last, int level, Crew& crew) {
  Column<std::int32_t>& gathered = broad_phase.gathered;
  gathered.clear();
  gathered.append(std::as_const(broad_phase.arrivals).span());
  for (int i = 0; i <= last; ++i) {
    PairTree& smaller = broad_phase.trees[kFrozenTree + i];
    list_where(
        crew, smaller.order.size(), broad_phase.places, broad_phase.part,
        [&](std::int32_t slot) { return smaller.order[slot] >= 0; },
        [&](std::int32_t slot) { return smaller.order[slot]; });
    gathered.append(std::as_const(broad_phase.part).span());
    clear_tree(smaller);
  }
  PairTree& tree = broad_phase.trees[kFrozenTree + level];
  sort_gathered(data, broad_phase, tree, crew);
  settle_members(data, broad_phase, level, crew);
}

// Whether the arrivals get a tree of their own, in the order that they had among awake shapes: they have
// fallen asleep together, and the tree of their size is empty. Sorting them along the same curve again would
// take most of the time.
bool keep_order(const WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  const PairTree& awake = broad_phase.trees[kAwakeTree];
  const std::size_t count = broad_phase.arrivals.size();
  int level = 0;
  while (level + 1 < kFrozenTrees && capacity_of(level) < static_cast<std::int64_t>(count)) ++level;
  if (level == 0 || broad_phase.trees[kFrozenTree + level].members > 0) return false;
  if (awake.unsorted || 2 * count < awake.order.size()) return false;
  list_where(
      crew, awake.order.size(), broad_phase.places, broad_phase.gathered,
      [&](std::int32_t i) { return awake.order[i] >= 0 && broad_phase.tree_of[awake.order[i]] == kArriving; },
      [&](std::int32_t i) { return awake.order[i]; });
  if (broad_phase.gathered.size() != count) return false;
  take_gathered(broad_phase, broad_phase.trees[kFrozenTree + level], crew);
  settle_members(data, broad_phase, level, crew);
  return true;
}

// Puts the arrivals into the first tree that holds them and all smaller ones. A tree with more holes than
// members is rebuilt.
void place_arrivals(const WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  const auto tree_at = [&](int level) -> const PairTree& { return broad_phase.trees[kFrozenTree + level]; };
  int last = broad_phase.arrivals.empty() ? -1 : 0;  // this one and all smaller ones are emptied
  for (int i = 1; i < kFrozenTrees; ++i) {
    if (tree_at(i).order.size() > 2 * static_cast<std::size_t>(tree_at(i).members) + simd::kBlock) last = i;
  }
  if (last < 0 || (last == 0 && keep_order(data, broad_phase, crew))) return;
  auto members = static_cast<std::int64_t>(broad_phase.arrivals.size());
  for (int i = 0; i <= last; ++i) members += tree_at(i).members;
  int level = 0;
  while (level + 1 < kFrozenTrees && capacity_of(level) < members) {
    if (++level > last) members += tree_at(last = level).members;
  }
  if (last == 0) {
    fill_smallest(data, broad_phase, crew);
  } else {
    merge_trees(data, broad_phase, last, level, crew);
  }
}

}  // namespace

bool update_members(WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  Shapes& shapes = data.shapes;
  broad_phase.refitted = 0;
  broad_phase.tree_of.resize(shapes.flags.size());
  broad_phase.slot_of.resize(shapes.flags.size());
  broad_phase.leavers.clear();
  broad_phase.all_left = std::exchange(shapes.trees_changed, false);
  if (broad_phase.all_left) compare_all(shapes, broad_phase, crew);
  if (broad_phase.changed.empty()) return false;
  const bool any = sort_out(shapes, broad_phase);
  for (const std::uint8_t index : {kAwakeTree, kKinematicTree}) {
    append_members(broad_phase.trees[index], broad_phase.joined[index]);
  }
  close_ranks(data, broad_phase, crew);
  place_arrivals(data, broad_phase, crew);
  return any;
}

}  // namespace scree
