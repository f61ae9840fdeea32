// Trees of the broad phase: sorts their members and computes their boxes, for the join.
// find_pairs_members.cpp chooses the members.
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/crew/list_where.h>

#include <algorithm>
#include <cmath>

namespace scree {

namespace {

constexpr int kShapesPerChunk = 4096;  // a few microseconds of bytes
// Refits between two sorts. Bodies travel little in 16 steps, and a sort costs about as much as the rest.
constexpr int kRefitsPerSort = 16;
constexpr float kLargestFloat = 3.402823466e38f;

using Spread = CenterSpread;

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

// Cells turned at a time: compilers vectorize loops over them, which takes a third of the time of single
// cells.
constexpr int kCells = 16;

// Cells of a 65536^3 grid, by axis.
struct Cells {
  std::uint32_t at[3][kCells];
};

// Puts zero bits between the bits of a 16-bit number: bit i goes to bit 3 i.
std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | x << 16) & 0x0000ff0000ff;
  x = (x | x << 8) & 0x00f00f00f00f;
  x = (x | x << 4) & 0x0c30c30c30c3;
  x = (x | x << 2) & 0x249249249249;
  return x;
}

// All ones where the number has the bit.
std::uint32_t ones_where(std::uint32_t x, int bit) { return 0u - (x >> bit & 1u); }

// Turns cells so that their interleaved bits are their place along a Hilbert curve instead of a Morton curve:
// J. Skilling, "Programming the Hilbert curve", AIP Conf. Proc. 707, 2004. Blocks of 16 neighbors along it
// are rounder, which saves 20 to 35 % of the join (pairs_bench, join_trees).
void turn_to_hilbert(Cells& cells) {
  std::uint32_t(&x)[kCells] = cells.at[0], (&y)[kCells] = cells.at[1], (&z)[kCells] = cells.at[2];
  for (int bit = 15; bit > 0; --bit) {
    const std::uint32_t below = (1u << bit) - 1;
    for (int i = 0; i < kCells; ++i) {
      std::uint32_t along_x = x[i] ^ (ones_where(x[i], bit) & below);
      for (std::uint32_t* along : {&y[i], &z[i]}) {
        const std::uint32_t set = ones_where(*along, bit) & below;
        const std::uint32_t swapped = (along_x ^ *along) & below & ~set;
        along_x ^= set | swapped;
        *along ^= swapped;
      }
      x[i] = along_x;
    }
  }
  std::uint32_t flip[kCells] = {};
  for (int i = 0; i < kCells; ++i) {
    y[i] ^= x[i];
    z[i] ^= y[i];
  }
  for (int bit = 15; bit > 0; --bit) {
    for (int i = 0; i < kCells; ++i) flip[i] ^= ones_where(z[i], bit) & ((1u << bit) - 1);
  }
  for (int i = 0; i < kCells; ++i) {
    x[i] ^= flip[i];
    y[i] ^= flip[i];
    z[i] ^= flip[i];
  }
}

// A grid of 65536^3 cells around the mean of the centers. Its size follows the mean distance from there, not
// the farthest shape: one that fell out of the scene must not put the whole pile into one cell.
struct CurveGrid {
  double origin[3];
  double cells_per_meter;

  // Keys of at most kCells shapes.
  void write_keys(const Column<BoundsRow>& bounds, const std::int32_t* shapes, int count,
                  SortKey* keys) const {
    Cells cells{};
    for (int i = 0; i < count; ++i) {
      const BoundsRow& row = bounds[shapes[i]];
      if (is_empty(row)) continue;
      for (int axis = 0; axis < 3; ++axis) {
        const double place = (center_of(row, axis) - origin[axis]) * cells_per_meter + 32768.0;
        cells.at[axis][i] = static_cast<std::uint32_t>(std::clamp(place, 0.0, 65535.0));
      }
    }
    turn_to_hilbert(cells);
    for (int i = 0; i < count; ++i) {
      std::uint64_t key = 0;
      for (int axis = 0; axis < 3; ++axis) key |= spread_bits(cells.at[axis][i]) << (2 - axis);
      const bool is_nowhere = is_empty(bounds[shapes[i]]);
      keys[i] = {is_nowhere ? ~std::uint64_t{0} >> 16 : key, shapes[i], 0};
    }
  }
};

// Lays a grid over the gathered shapes.
CurveGrid lay_grid(const WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  const Column<BoundsRow>& bounds = data.shapes.fat_bounds;
  const Column<std::int32_t>& shapes = broad_phase.gathered;
  const auto count = static_cast<int>(shapes.size());
  broad_phase.spreads.resize_discarding((count + kShapesPerChunk - 1) / kShapesPerChunk);
  crew.run_ranges(count, kShapesPerChunk, [&](int first, int last, int) {
    Spread spread{};
    for (int i = first; i < last; ++i) {
      const BoundsRow& row = bounds[shapes[i]];
      if (is_empty(row)) continue;
      for (int axis = 0; axis < 3; ++axis) spread.sum[axis] += center_of(row, axis);
      ++spread.count;
    }
    broad_phase.spreads[first / kShapesPerChunk] = spread;
  });
  const Spread total = total_of(broad_phase.spreads);
  const double scale = 1.0 / static_cast<double>(std::max<std::int64_t>(total.count, 1));
  CurveGrid grid{{total.sum[0] * scale, total.sum[1] * scale, total.sum[2] * scale}, 0.0};

  crew.run_ranges(count, kShapesPerChunk, [&](int first, int last, int) {
    Spread spread{};
    for (int i = first; i < last; ++i) {
      const std::int32_t shape = shapes[i];
      if (is_empty(bounds[shape])) continue;
      for (int axis = 0; axis < 3; ++axis) {
        spread.sum[axis] += std::abs(center_of(bounds[shape], axis) - grid.origin[axis]);
      }
    }
    broad_phase.spreads[first / kShapesPerChunk] = spread;
  });
  const Spread deviation = total_of(broad_phase.spreads);
  const double largest = std::max({deviation.sum[0], deviation.sum[1], deviation.sum[2]}) * scale;
  grid.cells_per_meter = 65536.0 / (32.0 * std::max(largest, 1e-3));
  return grid;
}

bool is_special(const WorldData& data, std::int32_t shape) {
  const Filter& filter = data.shapes.filter[shape];
  const Filter plain;
  const bool jointed = data.bodies.first_joint[data.shapes.body[shape]] >= 0;
  return jointed || is_sensor(data.shapes, shape) || filter.category != plain.category ||
         filter.mask != plain.mask || filter.group != plain.group;
}

// Writes what the leaf's shapes have besides their bounds.
void describe_leaf(const WorldData& data, const PairTree& tree, simd::LeafBlock& leaf, std::int32_t block) {
  leaf.special = 0;
  for (int slot = 0; slot < simd::kBlock; ++slot) {
    const std::int32_t shape = tree.order[block * simd::kBlock + slot];
    leaf.body[slot] = shape < 0 ? -1 : data.shapes.body[shape];
    if (shape >= 0 && is_special(data, shape)) leaf.special |= 1u << slot;
  }
}

// Lists the members of a tree of awake or kinematic shapes: those of its order that have not left it.
void gather_members(BroadPhase& broad_phase, std::uint8_t index, Crew& crew) {
  const PairTree& tree = broad_phase.trees[index];
  list_where(
      crew, tree.order.size(), broad_phase.places, broad_phase.gathered,
      [&](std::int32_t i) { return tree.order[i] >= 0 && broad_phase.tree_of[tree.order[i]] == index; },
      [&](std::int32_t i) { return tree.order[i]; });
}

// Removes the shapes that have left from the order of a tree of awake or kinematic shapes.
void drop_lost(BroadPhase& broad_phase, std::uint8_t index, Crew& crew) {
  PairTree& tree = broad_phase.trees[index];
  crew.run_ranges(static_cast<int>(tree.order.size()), kShapesPerChunk, [&](int first, int last, int) {
    for (int i = first; i < last; ++i) {
      std::int32_t& shape = tree.order[i];
      if (shape >= 0 && broad_phase.tree_of[shape] != index) shape = -1;
    }
  });
  tree.lost_members = false;
}

// Gives a tree `count` members, in their order.
template <class ShapeAt>
void write_order(PairTree& tree, int count, Crew& crew, ShapeAt&& shape_at) {
  const int places = (count + simd::kBlock - 1) / simd::kBlock * simd::kBlock;
  tree.order.resize_discarding(places);
  crew.run_ranges(places, kShapesPerChunk, [&](int first, int last, int) {
    for (int i = first; i < last; ++i) tree.order[i] = i < count ? shape_at(i) : -1;
  });
  tree.appended = 0;
  tree.refits = 0;
  tree.unsorted = false;
  tree.lost_members = false;
  tree.marks_changed = true;
}

}  // namespace

int lay_out_levels(std::size_t blocks, Column<simd::LeafBlock>& leaves, TreeLevels& nodes) {
  leaves.resize(blocks);
  int levels = 0;
  if (blocks == 0) return levels;
  do {
    const std::size_t parents = (blocks + simd::kBlock - 1) / simd::kBlock;
    Column<simd::NodeBlock>& level = nodes[levels++];
    level.resize(parents);
    for (std::size_t child = blocks; child < parents * simd::kBlock; ++child) {
      for (int axis = 0; axis < 3; ++axis) {
        level.back().bounds[axis][child % simd::kBlock] = kLargestFloat;
        level.back().bounds[axis + 3][child % simd::kBlock] = -kLargestFloat;
      }
    }
    blocks = parents;
  } while (blocks > 1);
  return levels;
}

void sort_gathered(const WorldData& data, BroadPhase& broad_phase, PairTree& tree, Crew& crew) {
  const CurveGrid grid = lay_grid(data, broad_phase, crew);
  const auto count = static_cast<int>(broad_phase.gathered.size());
  broad_phase.sort_keys.resize_discarding(broad_phase.gathered.size());
  broad_phase.sort_keys_other.resize_discarding(broad_phase.gathered.size());
  crew.run_ranges(count, kShapesPerChunk, [&](int first, int last, int) {
    for (int i = first; i < last; i += kCells) {
      grid.write_keys(data.shapes.fat_bounds, &broad_phase.gathered[i], std::min(last - i, kCells),
                      &broad_phase.sort_keys[i]);
    }
  });
  const SortKey* sorted = sort_by_key(broad_phase.sort_keys.data(), broad_phase.sort_keys_other.data(), count,
                                      broad_phase.digit_counts, crew);
  write_order(tree, count, crew, [&](int i) { return sorted[i].shape; });
}

void take_gathered(const BroadPhase& broad_phase, PairTree& tree, Crew& crew) {
  const std::int32_t* const gathered = broad_phase.gathered.data();
  write_order(tree, static_cast<int>(broad_phase.gathered.size()), crew, [&](int i) { return gathered[i]; });
}

void refit_tree(const WorldData& data, PairTree& tree, Crew& crew) {
  tree.levels = lay_out_levels(tree.order.size() / simd::kBlock, tree.leaves, tree.nodes);
  const simd::RefitTask task{tree.order.data(), data.shapes.fat_bounds.data(), tree.leaves.data(),
                             tree.nodes[0].data()};
  const simd::PairKernels& kernels = crew.kernels().pair;
  crew.run_ranges(leaf_blocks(tree), simd::kBlock, [&](int begin, int end, int) {
    kernels.refit_leaves(task, begin, end);
    if (!tree.marks_changed) return;
    for (int block = begin; block < end; ++block) {
      describe_leaf(data, tree, tree.leaves[block], block);
    }
  });
  for (int level = 1; level < tree.levels; ++level) {
    crew.run_ranges(static_cast<int>(tree.nodes[level - 1].size()), simd::kBlock,
                    [&](int begin, int end, int) {
                      kernels.refit_nodes(tree.nodes[level - 1].data(), tree.nodes[level].data(), begin, end);
                    });
  }
  tree.marks_changed = false;
  ++tree.refits;
}

void refit_leaf(const WorldData& data, PairTree& tree, std::int32_t block, Crew& crew) {
  const simd::PairKernels& kernels = crew.kernels().pair;
  const simd::RefitTask task{tree.order.data(), data.shapes.fat_bounds.data(), tree.leaves.data(),
                             tree.nodes[0].data()};
  kernels.refit_leaves(task, block, block + 1);
  describe_leaf(data, tree, tree.leaves[block], block);
  for (int level = 1; level < tree.levels; ++level) {
    block /= simd::kBlock;
    kernels.refit_nodes(tree.nodes[level - 1].data(), tree.nodes[level].data(), block, block + 1);
  }
}

void refit_trees(WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  for (const std::uint8_t index : {kAwakeTree, kKinematicTree}) {
    PairTree& tree = broad_phase.trees[index];
    if (tree.order.empty() && tree.levels == 0) continue;
    if (data.contacts.pairs_stale) tree.marks_changed = true;
    if (tree.unsorted || tree.refits >= kRefitsPerSort) {
      gather_members(broad_phase, index, crew);
      sort_gathered(data, broad_phase, tree, crew);
    } else if (tree.lost_members) {
      drop_lost(broad_phase, index, crew);
    }
    refit_tree(data, tree, crew);
  }
}

}  // namespace scree
