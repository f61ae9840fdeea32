// Trees of the broad phase: who belongs to which (update_members) and their boxes (refit_trees). Read by the
// join.
#include <parallel/broad_phase.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace scree {

namespace {

constexpr int kShapesPerChunk = 4096;  // a few microseconds of bytes
// Refits between two sorts. Bodies travel little in 16 steps, and a sort costs about as much as the rest.
constexpr int kRefitsPerSort = 16;
constexpr float kLargestFloat = 3.402823466e38f;

using Members = BroadPhase::Members;
using Spread = BroadPhase::Spread;

// Compares one chunk of shapes with the last list.
void compare_chunk(const Shapes& shapes, BroadPhase& broad_phase, int begin, int end, Members& members) {
  const std::uint8_t* flags = shapes.flags.data();
  const auto* tree = reinterpret_cast<const std::uint8_t*>(shapes.tree.data());
  const std::uint8_t* before = broad_phase.kinds.data();
  std::uint8_t* next = broad_phase.kinds_next.data();
  static_assert(kShapeAlive == 1 && static_cast<int>(TreeKind::none) == 0);
  for (int i = begin; i < end; ++i) {
    next[i] = static_cast<std::uint8_t>(tree[i] & static_cast<std::uint8_t>(-(flags[i] & kShapeAlive)));
  }
  for (int kind = 0; kind < kTreeCount; ++kind) members.added[kind] = members.removed[kind] = 0;
  if (std::memcmp(next + begin, before + begin, static_cast<std::size_t>(end - begin)) == 0) return;
  for (int kind = 0; kind < kTreeCount; ++kind) members.all[kind] = 0;
  for (int i = begin; i < end; ++i) {
    ++members.all[next[i]];
    if (next[i] == before[i]) continue;
    ++members.added[next[i]];
    ++members.removed[before[i]];
  }
}

// Writes the shapes that have just joined a tree behind the others.
void append_members(BroadPhase& broad_phase, int kind, std::int32_t added, int shapes, Crew& crew) {
  PairTree& tree = broad_phase.trees[kind];
  const auto begin = static_cast<std::int32_t>(tree.order.size());
  const std::int32_t blocks = (added + simd::kBlock - 1) / simd::kBlock;
  const std::int32_t end = begin + blocks * simd::kBlock;
  tree.order.resize(static_cast<std::size_t>(end));
  std::fill(tree.order.begin() + (end - simd::kBlock), tree.order.end(), -1);
  tree.appended += end - begin;
  std::int32_t place = begin;
  for (Members& members : broad_phase.members) {
    members.first[kind] = place;
    place += members.added[kind];
  }
  crew.run_ranges(shapes, kShapesPerChunk, [&](int first, int last, int) {
    const Members& members = broad_phase.members[static_cast<std::size_t>(first / kShapesPerChunk)];
    if (members.added[kind] == 0) return;
    std::int32_t* to = tree.order.data() + members.first[kind];
    for (int i = first; i < last; ++i) {
      const auto index = static_cast<std::size_t>(i);
      if (broad_phase.kinds_next[index] == kind && broad_phase.kinds[index] != kind) *to++ = i;
    }
  });
}

bool is_empty(const BoundsRow& bounds) { return bounds.lower[0] > bounds.upper[0]; }
double center_of(const BoundsRow& bounds, int axis) {
  return 0.5 * (static_cast<double>(bounds.lower[axis]) + static_cast<double>(bounds.upper[axis]));
}

// Joins the sums of chunks in their order.
Spread total_of(const Column<Spread>& spreads) {
  Spread total{};
  for (const Spread& spread : spreads) {
    for (int axis = 0; axis < 3; ++axis) total.sum[axis] += spread.sum[axis];
    total.count += spread.count;
  }
  return total;
}

// Puts zero bits between the bits of a 16-bit number: bit i goes to bit 3 i.
std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | x << 16) & 0x0000ff0000ff;
  x = (x | x << 8) & 0x00f00f00f00f;
  x = (x | x << 4) & 0x0c30c30c30c3;
  x = (x | x << 2) & 0x249249249249;
  return x;
}

// Turns a cell of a 65536^3 grid so that its interleaved bits are its place along a Hilbert curve instead of
// a Morton curve: J. Skilling, "Programming the Hilbert curve", AIP Conf. Proc. 707, 2004. Blocks of 16
// neighbors along it are rounder, which saves 20 to 35 % of the join (pairs_bench, join_trees).
void turn_to_hilbert(std::uint32_t (&x)[3]) {
  for (std::uint32_t bit = 1u << 15; bit > 1; bit >>= 1) {
    const std::uint32_t below = bit - 1;
    for (int axis = 0; axis < 3; ++axis) {
      const std::uint32_t set = (x[axis] & bit) != 0 ? below : 0u;
      const std::uint32_t swapped = (x[0] ^ x[axis]) & below & ~set;
      x[0] ^= set | swapped;
      x[axis] ^= swapped;
    }
  }
  x[1] ^= x[0];
  x[2] ^= x[1];
  std::uint32_t flip = 0;
  for (std::uint32_t bit = 1u << 15; bit > 1; bit >>= 1) {
    if ((x[2] & bit) != 0) flip ^= bit - 1;
  }
  for (std::uint32_t& along : x) along ^= flip;
}

// A grid of 65536^3 cells around the mean of the centers. Its size follows the mean distance from there, not
// the farthest shape: one that fell off the world must not put the whole pile into one cell.
struct CurveGrid {
  double origin[3];
  double cells_per_meter;

  std::uint64_t code(const BoundsRow& bounds) const {
    if (is_empty(bounds)) return ~std::uint64_t{0} >> 16;
    std::uint32_t cell[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double place = (center_of(bounds, axis) - origin[axis]) * cells_per_meter + 32768.0;
      cell[axis] = static_cast<std::uint32_t>(std::clamp(place, 0.0, 65535.0));
    }
    turn_to_hilbert(cell);
    std::uint64_t result = 0;
    for (int axis = 0; axis < 3; ++axis) result |= spread_bits(cell[axis]) << (2 - axis);
    return result;
  }
};

// Lists the members of a tree in broad_phase.sort_keys and lays a grid over them.
CurveGrid gather_members(const WorldData& data, BroadPhase& broad_phase, int kind, Crew& crew) {
  const Column<BoundsRow>& bounds = data.shapes.fat_bounds;
  const int shapes = static_cast<int>(broad_phase.kinds.size());
  std::int32_t place = 0;
  for (Members& members : broad_phase.members) {
    members.first[kind] = place;
    place += members.all[kind];
  }
  broad_phase.sort_keys.resize_discarding(static_cast<std::size_t>(place));
  broad_phase.spreads.resize_discarding(broad_phase.members.size());
  crew.run_ranges(shapes, kShapesPerChunk, [&](int first, int last, int) {
    const auto chunk = static_cast<std::size_t>(first / kShapesPerChunk);
    SortKey* to = broad_phase.sort_keys.data() + broad_phase.members[chunk].first[kind];
    Spread spread{};
    if (broad_phase.members[chunk].all[kind] == 0) last = first;  // sleepers are not looked at one by one
    for (int i = first; i < last; ++i) {
      if (broad_phase.kinds[static_cast<std::size_t>(i)] != kind) continue;
      (to++)->shape = i;
      const BoundsRow& row = bounds[static_cast<std::size_t>(i)];
      if (is_empty(row)) continue;
      for (int axis = 0; axis < 3; ++axis) spread.sum[axis] += center_of(row, axis);
      ++spread.count;
    }
    broad_phase.spreads[chunk] = spread;
  });
  const Spread total = total_of(broad_phase.spreads);
  const double scale = 1.0 / static_cast<double>(std::max<std::int64_t>(total.count, 1));
  CurveGrid grid{{total.sum[0] * scale, total.sum[1] * scale, total.sum[2] * scale}, 0.0};

  broad_phase.spreads.resize_discarding(
      static_cast<std::size_t>((place + kShapesPerChunk - 1) / kShapesPerChunk));
  crew.run_ranges(place, kShapesPerChunk, [&](int first, int last, int) {
    Spread spread{};
    for (int i = first; i < last; ++i) {
      const auto shape = static_cast<std::size_t>(broad_phase.sort_keys[static_cast<std::size_t>(i)].shape);
      if (is_empty(bounds[shape])) continue;
      for (int axis = 0; axis < 3; ++axis) {
        spread.sum[axis] += std::abs(center_of(bounds[shape], axis) - grid.origin[axis]);
      }
    }
    broad_phase.spreads[static_cast<std::size_t>(first / kShapesPerChunk)] = spread;
  });
  const Spread deviation = total_of(broad_phase.spreads);
  const double largest = std::max({deviation.sum[0], deviation.sum[1], deviation.sum[2]}) * scale;
  grid.cells_per_meter = 65536.0 / (32.0 * std::max(largest, 1e-3));
  return grid;
}

// Orders the members of a tree along the curve.
void sort_members(const WorldData& data, BroadPhase& broad_phase, int kind, Crew& crew) {
  PairTree& tree = broad_phase.trees[kind];
  const CurveGrid grid = gather_members(data, broad_phase, kind, crew);
  const auto count = static_cast<int>(broad_phase.sort_keys.size());
  broad_phase.sort_keys_other.resize_discarding(broad_phase.sort_keys.size());
  crew.run_ranges(count, kShapesPerChunk, [&](int first, int last, int) {
    for (int i = first; i < last; ++i) {
      SortKey& row = broad_phase.sort_keys[static_cast<std::size_t>(i)];
      row.key = grid.code(data.shapes.fat_bounds[static_cast<std::size_t>(row.shape)]);
    }
  });
  const SortKey* sorted = sort_by_key(broad_phase.sort_keys.data(), broad_phase.sort_keys_other.data(), count,
                                      broad_phase.digit_counts, crew);
  const int places = (count + simd::kBlock - 1) / simd::kBlock * simd::kBlock;
  tree.order.resize_discarding(static_cast<std::size_t>(places));
  crew.run_ranges(places, kShapesPerChunk, [&](int first, int last, int) {
    for (int i = first; i < last; ++i)
      tree.order[static_cast<std::size_t>(i)] = i < count ? sorted[i].shape : -1;
  });
  tree.appended = 0;
  tree.refits = 0;
  tree.unsorted = false;
  tree.lost_members = false;
  tree.special_changed = true;
}

// Sizes the levels for the blocks of `order` and empties the places behind the last block of each level.
void lay_out(PairTree& tree) {
  std::size_t blocks = tree.order.size() / simd::kBlock;
  tree.leaves.resize(blocks);
  tree.levels = 0;
  if (blocks == 0) return;
  do {
    const std::size_t parents = (blocks + simd::kBlock - 1) / simd::kBlock;
    Column<simd::NodeBlock>& nodes = tree.nodes[tree.levels++];
    nodes.resize(parents);
    for (std::size_t child = blocks; child < parents * simd::kBlock; ++child) {
      for (int axis = 0; axis < 3; ++axis) {
        nodes.back().bounds[axis][child % simd::kBlock] = kLargestFloat;
        nodes.back().bounds[axis + 3][child % simd::kBlock] = -kLargestFloat;
      }
    }
    blocks = parents;
  } while (blocks > 1);
}

bool is_special(const WorldData& data, std::int32_t shape) {
  const auto index = static_cast<std::size_t>(shape);
  const Filter& filter = data.shapes.filter[index];
  const Filter plain;
  const bool alone = data.shapes.next[index] < 0 &&
                     data.bodies.first_shape[static_cast<std::size_t>(data.shapes.body[index])] == shape;
  const bool jointed = data.bodies.first_joint[static_cast<std::size_t>(data.shapes.body[index])] >= 0;
  return !alone || jointed || filter.category != plain.category || filter.mask != plain.mask ||
         filter.group != plain.group;
}

void mark_special(const WorldData& data, const PairTree& tree, simd::LeafBlock& leaf, std::size_t block) {
  leaf.special = 0;
  for (std::size_t slot = 0; slot < simd::kBlock; ++slot) {
    const std::int32_t shape = tree.order[block * simd::kBlock + slot];
    if (shape >= 0 && is_special(data, shape)) leaf.special |= 1u << slot;
  }
}

void refit_tree(const WorldData& data, BroadPhase& broad_phase, int kind, Crew& crew) {
  PairTree& tree = broad_phase.trees[kind];
  lay_out(tree);
  const simd::RefitTask task{tree.order.data(), data.shapes.fat_bounds.data(), tree.leaves.data(),
                             tree.nodes[0].data()};
  const simd::PairKernels& kernels = crew.kernels().pair;
  crew.run_ranges(tree.leaf_blocks(), simd::kBlock, [&](int begin, int end, int) {
    if (tree.lost_members) {
      for (int i = begin * simd::kBlock; i < end * simd::kBlock; ++i) {
        std::int32_t& shape = tree.order[static_cast<std::size_t>(i)];
        if (shape >= 0 && broad_phase.kinds[static_cast<std::size_t>(shape)] != kind) shape = -1;
      }
    }
    kernels.refit_leaves(task, begin, end);
    if (!tree.special_changed) return;
    for (auto block = static_cast<std::size_t>(begin); block < static_cast<std::size_t>(end); ++block) {
      mark_special(data, tree, tree.leaves[block], block);
    }
  });
  for (int level = 1; level < tree.levels; ++level) {
    crew.run_ranges(static_cast<int>(tree.nodes[level - 1].size()), simd::kBlock,
                    [&](int begin, int end, int) {
                      kernels.refit_nodes(tree.nodes[level - 1].data(), tree.nodes[level].data(), begin, end);
                    });
  }
  tree.bounds_changed = false;
  tree.special_changed = false;
  tree.lost_members = false;
  ++tree.refits;
}

}  // namespace

void PairTree::clear() noexcept {
  order.clear();
  leaves.clear();
  for (Column<simd::NodeBlock>& level : nodes) level.clear();
  levels = refits = 0;
  members = appended = 0;
  unsorted = bounds_changed = special_changed = true;
  lost_members = false;
}

bool update_members(WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  const std::size_t shapes = data.shapes.flags.size();
  if (!std::exchange(data.shapes.trees_changed, false)) return false;
  broad_phase.kinds.resize(shapes);
  broad_phase.kinds_next.resize_discarding(shapes);
  broad_phase.members.resize((shapes + kShapesPerChunk - 1) / kShapesPerChunk);
  const auto count = static_cast<int>(shapes);
  crew.run_ranges(count, kShapesPerChunk, [&](int begin, int end, int) {
    compare_chunk(data.shapes, broad_phase, begin, end,
                  broad_phase.members[static_cast<std::size_t>(begin / kShapesPerChunk)]);
  });
  std::int32_t added[kTreeCount] = {}, removed[kTreeCount] = {};
  for (const Members& members : broad_phase.members) {
    for (int kind = 1; kind < kTreeCount; ++kind) {
      added[kind] += members.added[kind];
      removed[kind] += members.removed[kind];
    }
  }
  bool changed = false;
  for (int kind = 1; kind < kTreeCount; ++kind) {
    if (added[kind] == 0 && removed[kind] == 0) continue;
    changed = true;
    PairTree& tree = broad_phase.trees[kind];
    tree.members += added[kind] - removed[kind];
    tree.bounds_changed = true;
    tree.lost_members = tree.lost_members || removed[kind] > 0;
    if (added[kind] == 0) continue;
    tree.special_changed = true;
    // Shapes behind the sorted ones lie anywhere, so they may only be few.
    if ((tree.appended + added[kind]) * std::int64_t{8} > tree.members) tree.unsorted = true;
    if (!tree.unsorted) append_members(broad_phase, kind, added[kind], count, crew);
  }
  broad_phase.kinds.swap(broad_phase.kinds_next);
  return changed;
}

void refit_trees(WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  for (int kind = 1; kind < kTreeCount; ++kind) {
    PairTree& tree = broad_phase.trees[kind];
    if (data.contacts.pairs_stale) tree.special_changed = true;
    if (kind != static_cast<int>(TreeKind::frozen)) tree.bounds_changed = true;
    if (!tree.bounds_changed && !tree.special_changed) continue;
    if (tree.unsorted || (tree.bounds_changed && tree.refits >= kRefitsPerSort)) {
      sort_members(data, broad_phase, kind, crew);
    }
    refit_tree(data, broad_phase, kind, crew);
  }
}

}  // namespace scree
