// Validation of the broad phase's trees after find_pairs; see validate_stages.h.
#ifdef SCREE_ASSERTIONS

#include <parallel/broad_phase/broad_phase.h>
#include <parallel/validate/validate_stages.h>

namespace scree {

namespace {

// Of a shape's bounds or of a child; not where it is empty or not a number.
struct Box {
  float lower[3], upper[3];
  bool is_empty() const { return !(lower[0] <= upper[0] && lower[1] <= upper[1] && lower[2] <= upper[2]); }
};

template <class Block>
Box box_of(const Block& block, std::size_t child) {
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.lower[axis] = block.bounds[axis][child];
    box.upper[axis] = block.bounds[axis + 3][child];
  }
  return box;
}

Box box_of(const BoundsRow& bounds) {
  return {{bounds.lower[0], bounds.lower[1], bounds.lower[2]},
          {bounds.upper[0], bounds.upper[1], bounds.upper[2]}};
}

bool holds(const Box& outer, const Box& inner) {
  if (inner.is_empty()) return true;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(outer.lower[axis] <= inner.lower[axis] && inner.upper[axis] <= outer.upper[axis])) return false;
  }
  return true;
}

void validate_leaves(const WorldData& data, const BroadPhase& broad_phase, std::uint8_t index) {
  const PairTree& tree = broad_phase.trees[index];
  std::int32_t members = 0;
  SCREE_ASSERT(tree.order.size() % simd::kBlock == 0);
  SCREE_ASSERT(tree.leaves.size() == tree.order.size() / simd::kBlock);
  for (std::size_t place = 0; place < tree.order.size(); ++place) {
    const std::int32_t shape = tree.order[place];
    const simd::LeafBlock& leaf = tree.leaves[place / simd::kBlock];
    const std::size_t slot = place % simd::kBlock;
    SCREE_ASSERT(leaf.shape[slot] == shape);
    if (shape < 0) continue;
    SCREE_ASSERT(leaf.body[slot] == data.shapes.body[shape]);
    SCREE_ASSERT(broad_phase.tree_of[shape] == index);
    SCREE_ASSERT(!is_frozen_tree(index) || broad_phase.slot_of[shape] == static_cast<std::int32_t>(place));
    SCREE_ASSERT(holds(box_of(leaf, slot), box_of(data.shapes.fat_bounds[shape])));
    ++members;
  }
  SCREE_ASSERT(tree.members == members);
}

void validate_nodes(const PairTree& tree) {
  for (std::size_t leaf = 0; leaf < tree.leaves.size(); ++leaf) {
    const Box box = box_of(tree.nodes[0][leaf / simd::kBlock], leaf % simd::kBlock);
    for (std::size_t slot = 0; slot < simd::kBlock; ++slot) {
      SCREE_ASSERT(holds(box, box_of(tree.leaves[leaf], slot)));
    }
  }
  for (int level = 1; level < tree.levels; ++level) {
    const Column<simd::NodeBlock>&children = tree.nodes[level - 1], &parents = tree.nodes[level];
    for (std::size_t child = 0; child < children.size(); ++child) {
      const Box box = box_of(parents[child / simd::kBlock], child % simd::kBlock);
      for (std::size_t slot = 0; slot < simd::kBlock; ++slot) {
        SCREE_ASSERT(holds(box, box_of(children[child], slot)));
      }
    }
  }
}

}  // namespace

void validate_trees(const WorldData& data) {
  if (!is_validated(data)) return;
  const auto& broad_phase = static_cast<const BroadPhase&>(*data.broad_phase);
  std::size_t members = 0, present = 0;
  for (std::uint8_t index = kAwakeTree; index < kPairTrees; ++index) {
    validate_leaves(data, broad_phase, index);
    validate_nodes(broad_phase.trees[index]);
    members += static_cast<std::size_t>(broad_phase.trees[index].members);
  }
  std::vector<std::uint8_t>& will_move = validation_marks(data.shapes.flags.size());
  for (const std::int32_t shape : broad_phase.changed) will_move[static_cast<std::size_t>(shape)] = 1;
  for (std::size_t shape = 0; shape < data.shapes.flags.size(); ++shape) {
    const std::uint8_t tree = broad_phase.tree_of[shape];
    const auto kind = is_frozen_tree(tree) ? TreeKind::frozen : static_cast<TreeKind>(tree);
    SCREE_ASSERT(kind == data.shapes.tree[shape] || will_move[shape] != 0);
    const bool is_alive = (data.shapes.flags[shape] & kShapeAlive) != 0;
    present += is_alive && data.bodies.is_absent[data.shapes.body[shape]] == 0 ? 1 : 0;
  }
  SCREE_ASSERT(members == present);
  const auto rests = [&](const ShapePair& pair) {
    return is_frozen_tree(broad_phase.tree_of[pair.a]) && is_frozen_tree(broad_phase.tree_of[pair.b]);
  };
  for (const ShapePair& pair : data.contacts.pairs.pair) SCREE_ASSERT(!rests(pair));
  for (const ShapePair& pair : data.contacts.resting.pair) SCREE_ASSERT(rests(pair));
}

}  // namespace scree

#endif
