// The query index: where queries find the shapes of a world. Queries make it when they are first asked after
// a step or a call; what stands in the broad phase's trees as it was found by the last step stays there.
//
// Frozen shapes that have not changed are found in the broad phase's trees. So are awake and kinematic ones
// if none has left its fat bounds since these trees were made; else they stand in trees of the same order
// with boxes of their own. All others, which calls have created or changed or the step has woken, put to
// sleep or moved, are loose: they stand in trees of 64, 512, 4096 ... shapes, as frozen shapes do in the
// broad phase (find_pairs_members.cpp). So a step costs queries what moves, and a call what it changes.
#pragma once

#include <parallel/broad_phase/broad_phase.h>
#include <simd/dispatch/kernels.h>

#include <cstdint>
#include <limits>

namespace scree {

inline constexpr std::uint64_t kNoStep = std::numeric_limits<std::uint64_t>::max();

// Where a loose shape stands: in a tree and a place of its order; -1: in none, for it is dead.
struct LoosePlace {
  std::int32_t tree, slot;
};

// A loose shape on its way into a tree.
struct LooseItem {
  float center[3];
  std::int32_t shape;
  float lower[3], upper[3];
};

// clang-format off
#define SCREE_LOOSE_TREE_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                               \
  LIST (scratch, simd::LeafBlock, leaves)                                                                       \
  TABLE(scratch, TreeLevels,      nodes, "queries.trees")                                                       \
  VALUE(scratch, int,             levels, 0)                                                                    \
  VALUE(scratch, std::int32_t,    members, 0)
SCREE_STORE(QueryTree, SCREE_LOOSE_TREE_MEMBERS)

inline constexpr int kLooseTrees = 9;
using LooseTrees = TableArray<QueryTree, kLooseTrees>;
using MovingTrees = TableArray<QueryTree, kFrozenTree>;

#define SCREE_QUERY_INDEX_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                              \
  VALUE(scratch, std::uint64_t, base_step, kNoStep) /* step count for which the rest is made */                 \
  VALUE(scratch, bool,          has_moving, false) /* `moving` is used, not the broad phase's trees */          \
  LIST (scratch, std::uint8_t,  is_loose)          /* by shape: what the other trees say of it is not true */   \
  LIST (scratch, LoosePlace,    place_of)          /* by shape, where is_loose */                               \
  LIST (scratch, std::int32_t,  loose)             /* shapes that are loose, or have died as such */            \
  TABLE(scratch, LooseTrees,    trees, "queries")  /* of loose shapes */                                        \
  TABLE(scratch, MovingTrees,   moving, "queries") /* by TreeIndex; kNoTree stays empty */                      \
  LIST (scratch, std::int32_t,  order)             /* of a moving tree */                                       \
  LIST (scratch, LooseItem,     items)             /* of a loose tree that is being made */                     \
  VALUE(scratch, std::int64_t,  boxes_made, 0)     /* of loose shapes so far, for tests of what queries cost */
// clang-format on
SCREE_PART(QueryIndex, SCREE_QUERY_INDEX_MEMBERS)

// The index as it must be now. Any number of threads may call it at once.
const QueryIndex& query_index_of(const WorldData& data, const simd::Kernels& kernels);

// Calls walk(TreeView) for every tree that holds shapes.
inline simd::TreeView view_of(const Shapes& shapes, const Column<simd::LeafBlock>& leaves,
                              const TreeLevels& nodes, int levels) {
  simd::TreeView view{leaves.data(), {}, levels, shapes.pose.data(), shapes.extent.data()};
  for (int level = 0; level < levels; ++level) view.nodes[level] = nodes[level].data();
  return view;
}
// What follows may name a loose shape that is somewhere else or dead: whoever asks must look at is_loose.
template <class Walk>
void for_each_base_tree(const WorldData& data, const QueryIndex& index, Walk&& walk) {
  if (data.broad_phase == nullptr) return;
  const auto& broad_phase = static_cast<const BroadPhase&>(*data.broad_phase);
  for (std::uint8_t tree = kAwakeTree; tree < kPairTrees; ++tree) {
    if (index.has_moving && !is_frozen_tree(tree)) {
      const QueryTree& moving = index.moving[tree];
      if (moving.levels > 0) walk(view_of(data.shapes, moving.leaves, moving.nodes, moving.levels));
    } else {
      const PairTree& from = broad_phase.trees[tree];
      if (from.levels > 0) walk(view_of(data.shapes, from.leaves, from.nodes, from.levels));
    }
  }
}
template <class Walk>
void for_each_loose_tree(const WorldData& data, const QueryIndex& index, Walk&& walk) {
  for (const QueryTree& tree : index.trees) {
    if (tree.members > 0) walk(view_of(data.shapes, tree.leaves, tree.nodes, tree.levels));
  }
}

}  // namespace scree
