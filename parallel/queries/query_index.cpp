// The query index; see query_index.h.
#include <core/world/fp_environment.h>
#include <parallel/queries/query_index.h>
#include <parallel/queries/query_solid.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace scree {

namespace {

using simd::kBlock;

constexpr std::int64_t kSmallestTree = 64;  // shapes
constexpr std::int64_t kTreeGrowth = 8;
constexpr float kLargestFloat = 3.402823466e38f;
constexpr double kFarthest = 1e18;   // m; a shape beyond it is in the trees' empty boxes
constexpr double kRounding = 1e-6;   // of coordinates: more than the box and its place are rounded by
constexpr double kLeastPad = 1e-30;  // m; keeps the box of anything from being flat

std::int64_t capacity_of(int level) {
  std::int64_t capacity = kSmallestTree;
  for (int i = 0; i < level; ++i) capacity *= kTreeGrowth;
  return capacity;
}

bool is_here(const WorldData& data, std::int32_t shape) {
  return (data.shapes.flags[shape] & kShapeAlive) != 0 && !is_absent(data.bodies, data.shapes.body[shape]);
}

LooseItem item_of(const WorldData& data, std::int32_t shape) {
  const queries::Solid solid = queries::solid_of(data, shape);
  const queries::Vector reach = queries::reach_of(solid);
  LooseItem item{};
  item.shape = shape;
  for (int axis = 0; axis < 3; ++axis) {
    const double center = solid.position[axis];
    const double size = reach[axis] + kRounding * (std::abs(center) + reach[axis]) + kLeastPad;
    item.center[axis] = static_cast<float>(center);
    item.lower[axis] = static_cast<float>(center - size);
    item.upper[axis] = static_cast<float>(center + size);
    if (std::abs(center) + size <= kFarthest) continue;
    // Also where it is no number.
    for (int each = 0; each < 3; ++each) {
      item.center[each] = 0.0f;
      item.lower[each] = kLargestFloat;
      item.upper[each] = -kLargestFloat;
    }
    break;
  }
  return item;
}

// Orders the items so that children of a block lie together: halves of about equal numbers along the longest
// side, down to the blocks.
void order_items(LooseItem* items, std::int64_t count) {
  while (count > kBlock) {
    std::int64_t unit = kBlock;  // items in a full child
    while (unit * kBlock < count) unit *= kBlock;
    const std::int64_t children = (count + unit - 1) / unit;
    const std::int64_t left = children / 2 * unit;
    float low[3], high[3];
    for (int axis = 0; axis < 3; ++axis) low[axis] = high[axis] = items[0].center[axis];
    for (std::int64_t i = 1; i < count; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], items[i].center[axis]);
        high[axis] = std::max(high[axis], items[i].center[axis]);
      }
    }
    int longest = 0;
    for (int axis = 1; axis < 3; ++axis) {
      if (high[axis] - low[axis] > high[longest] - low[longest]) longest = axis;
    }
    std::nth_element(items, items + left, items + count, [longest](const LooseItem& a, const LooseItem& b) {
      return a.center[longest] != b.center[longest] ? a.center[longest] < b.center[longest]
                                                    : a.shape < b.shape;
    });
    order_items(items, left);
    items += left;
    count -= left;
  }
}

template <class Block>
void empty_lane(Block& block, int lane) {
  for (int axis = 0; axis < 3; ++axis) {
    block.bounds[axis][lane] = kLargestFloat;
    block.bounds[axis + 3][lane] = -kLargestFloat;
  }
}

// The box of a leaf, into its lane of the level above.
void enclose(const simd::LeafBlock& leaf, simd::NodeBlock& parent, int lane) {
  empty_lane(parent, lane);
  for (int child = 0; child < kBlock; ++child) {
    for (int axis = 0; axis < 3; ++axis) {
      float &lower = parent.bounds[axis][lane], &upper = parent.bounds[axis + 3][lane];
      lower = std::min(lower, leaf.bounds[axis][child]);
      upper = std::max(upper, leaf.bounds[axis + 3][child]);
    }
  }
}

void refit_above(QueryTree& tree, const simd::Kernels& kernels) {
  for (int level = 1; level < tree.levels; ++level) {
    kernels.pair.refit_nodes(tree.nodes[level - 1].data(), tree.nodes[level].data(), 0,
                             static_cast<int>(tree.nodes[level - 1].size()));
  }
}

// Builds the loose tree of this number from `items`.
void build_tree(QueryIndex& index, int number, const simd::Kernels& kernels) {
  Column<LooseItem>& items = index.items;
  order_items(items.data(), static_cast<std::int64_t>(items.size()));
  QueryTree& tree = index.trees[number];
  const std::size_t blocks = (items.size() + kBlock - 1) / kBlock;
  tree.levels = lay_out_levels(blocks, tree.leaves, tree.nodes);
  for (std::size_t block = 0; block < blocks; ++block) {
    simd::LeafBlock& leaf = tree.leaves[block];
    leaf = {};
    for (int lane = 0; lane < kBlock; ++lane) {
      const std::size_t slot = block * kBlock + static_cast<std::size_t>(lane);
      empty_lane(leaf, lane);
      leaf.shape[lane] = -1;
      if (slot >= items.size()) continue;
      const LooseItem& item = items[slot];
      for (int axis = 0; axis < 3; ++axis) {
        leaf.bounds[axis][lane] = item.lower[axis];
        leaf.bounds[axis + 3][lane] = item.upper[axis];
        leaf.center[axis][lane] = item.center[axis];
      }
      leaf.shape[lane] = item.shape;
      index.place_of[item.shape] = {number, static_cast<std::int32_t>(slot)};
    }
    enclose(leaf, tree.nodes[0][block / kBlock], static_cast<int>(block % kBlock));
  }
  refit_above(tree, kernels);
  tree.members = static_cast<std::int32_t>(items.size());
  index.boxes_made += static_cast<std::int64_t>(items.size());
}

// Adds what the tree holds to `items`, and empties it.
void take_items(QueryIndex& index, QueryTree& tree) {
  if (tree.members > 0) {
    for (const simd::LeafBlock& leaf : tree.leaves) {
      for (int lane = 0; lane < kBlock; ++lane) {
        if (leaf.shape[lane] < 0) continue;
        LooseItem item{};
        item.shape = leaf.shape[lane];
        for (int axis = 0; axis < 3; ++axis) {
          item.center[axis] = leaf.center[axis][lane];
          item.lower[axis] = leaf.bounds[axis][lane];
          item.upper[axis] = leaf.bounds[axis + 3][lane];
        }
        index.items.push_back(item);
      }
    }
  }
  tree.members = tree.levels = 0;
}

// Puts the items into the first tree that can hold them together with all smaller trees, which it empties.
void place_items(QueryIndex& index, const simd::Kernels& kernels) {
  if (index.items.empty()) return;
  auto members = static_cast<std::int64_t>(index.items.size()) + index.trees[0].members;
  int level = 0;
  while (level + 1 < kLooseTrees && capacity_of(level) < members) members += index.trees[++level].members;
  for (int i = 0; i <= level; ++i) take_items(index, index.trees[i]);
  build_tree(index, level, kernels);
  constexpr std::size_t kKeptItems = 65536;
  if (index.items.size() > kKeptItems) index.items = {};
  index.items.clear();
}

// Takes a shape out of whatever tree it is in, and lists it for another one if it lives.
void loosen(const WorldData& data, QueryIndex& index, std::int32_t shape) {
  LoosePlace& place = index.place_of[shape];
  if (index.is_loose[shape] == 0) {
    index.loose.push_back(shape);
    index.is_loose[shape] = 1;
  } else if (place.tree >= 0) {
    QueryTree& tree = index.trees[place.tree];
    simd::LeafBlock& leaf = tree.leaves[place.slot / kBlock];
    empty_lane(leaf, place.slot % kBlock);
    leaf.shape[place.slot % kBlock] = -1;
    --tree.members;
  }
  place = {-1, -1};
  if (is_here(data, shape)) index.items.push_back(item_of(data, shape));
}

// Trees of the order of the broad phase's, with the bounds that the last step has left.
void copy_moving(const WorldData& data, const BroadPhase& broad_phase, QueryIndex& index,
                 const simd::Kernels& kernels) {
  for (const std::uint8_t number : {kAwakeTree, kKinematicTree}) {
    QueryTree& tree = index.moving[number];
    Column<std::int32_t>& order = index.order;
    order.clear();
    for (const std::int32_t shape : broad_phase.trees[number].order) {
      if (shape < 0) continue;
      if (broad_phase.tree_of[shape] == number && index.is_loose[shape] == 0) order.push_back(shape);
    }
    while (order.size() % kBlock != 0) order.push_back(-1);
    const std::size_t blocks = order.size() / kBlock;
    tree.levels = lay_out_levels(blocks, tree.leaves, tree.nodes);
    if (blocks == 0) continue;
    const simd::RefitTask task{order.data(), data.shapes.fat_bounds.data(), tree.leaves.data(),
                               tree.nodes[0].data()};
    kernels.pair.refit_leaves(task, 0, static_cast<int>(blocks));
    refit_above(tree, kernels);
  }
}

// Which shapes the trees of the broad phase do not tell the truth of.
void list_loose(const WorldData& data, const BroadPhase* broad_phase, QueryIndex& index) {
  const auto add = [&](std::int32_t shape) {
    if (index.is_loose[shape] == 0) loosen(data, index, shape);
  };
  for (const std::int32_t shape : data.shapes.dirty) add(shape);
  for (const std::int32_t shape : data.shapes.changed) add(shape);
  if (broad_phase != nullptr) {
    for (const std::int32_t shape : broad_phase->changed) add(shape);
  }
  if (broad_phase != nullptr && !data.shapes.trees_changed) return;
  const std::size_t known = broad_phase != nullptr ? broad_phase->tree_of.size() : 0;
  for (std::size_t row = 0; row < data.shapes.flags.size(); ++row) {
    const auto shape = static_cast<std::int32_t>(row);
    if (row < known && broad_phase->tree_of[row] != kNoTree) continue;
    if (is_here(data, shape)) add(shape);
  }
}

void make_base(const WorldData& data, QueryIndex& index, const simd::Kernels& kernels) {
  for (const std::int32_t shape : index.loose) index.is_loose[shape] = 0;
  index.loose.clear();
  index.items.clear();
  constexpr std::size_t kKeptLeaves = 4096;  // memory for more is freed
  for (QueryTree& tree : index.trees) {
    tree.members = tree.levels = 0;
    if (tree.leaves.size() > kKeptLeaves) tree = {};
  }
  for (QueryTree& tree : index.moving) tree.levels = 0;
  const auto* broad_phase = static_cast<const BroadPhase*>(data.broad_phase.get());
  list_loose(data, broad_phase, index);
  index.has_moving = broad_phase != nullptr && broad_phase->bounds_left.load(std::memory_order_relaxed);
  if (index.has_moving) copy_moving(data, *broad_phase, index, kernels);
}

void refresh(WorldData& data, const simd::Kernels& kernels) {
  const FpEnvironment environment;
  if (data.queries == nullptr) data.queries = std::make_unique<QueryIndex>();
  auto& index = static_cast<QueryIndex&>(*data.queries);
  Shapes& shapes = data.shapes;
  const bool keeps_base = index.base_step == data.step_count;
  index.base_step = kNoStep;  // in case that memory runs out
  index.is_loose.resize(shapes.flags.size());
  index.place_of.resize(shapes.flags.size());
  if (keeps_base) {
    for (const std::int32_t shape : shapes.to_query) loosen(data, index, shape);
  } else {
    make_base(data, index, kernels);
  }
  place_items(index, kernels);
  for (const std::int32_t shape : shapes.to_query) shapes.is_noted[shape] = 0;
  shapes.to_query.clear();
  shapes.is_queried = true;
  index.base_step = data.step_count;
}

}  // namespace

const QueryIndex& query_index_of(const WorldData& data, const simd::Kernels& kernels) {
  // Writes only what belongs to queries.
  data.shapes.queries_made.ensure([&] { refresh(const_cast<WorldData&>(data), kernels); });
  return static_cast<const QueryIndex&>(*data.queries);
}

}  // namespace scree
