// Computes the boxes of the implicit trees, and joins two trees. Called by find_pairs.
//
// One descent serves a leaf block of 16 shapes: it collects the leaf blocks of the other tree whose boxes
// overlap the block's box. Only if there are very many does each shape descend by itself. Each of the 16
// shapes then selects its own leaf blocks, and tests its box, bounding sphere and body against their 16
// shapes at once.
#include <simd/broad_phase/pair_kernels.h>
#include <simd/wide/wide.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

constexpr float kLargestFloat = 3.402823466e38f;
// Leaf blocks that a descent collects before they are processed, or before each shape descends by itself. Any
// number works; most blocks overlap fewer than 32.
constexpr int kMaxCandidates = 128;

struct Box {
  F lower[3], upper[3];
};

// Leaf blocks that overlap the query block's box, and their boxes as columns.
struct Candidates {
  alignas(64) float bounds[6][kMaxCandidates];
  std::int32_t block[kMaxCandidates];
  int count;
};

M overlap(const Box& box, const float* bounds, int stride) {
  const float* lower = bounds;
  const float* upper = bounds + 3 * stride;
  const M x = (load(lower) <= box.upper[0]) & (box.lower[0] <= load(upper));
  const M y = (load(lower + stride) <= box.upper[1]) & (box.lower[1] <= load(upper + stride));
  const M z = (load(lower + 2 * stride) <= box.upper[2]) & (box.lower[2] <= load(upper + 2 * stride));
  return x & y & z;
}

// A bit for each of the block's 16 boxes that overlaps the box.
std::uint32_t overlap_bits(const Box& box, const float (&bounds)[6][kBlock]) {
  std::uint32_t result = 0;
  for (int lane = 0; lane < kBlock; lane += kLanes) {
    result |= bits(overlap(box, &bounds[0][lane], kBlock)) << lane;
  }
  return result;
}

Box broadcast_box(const float (&bounds)[6][kBlock], int lane) {
  return {{F(bounds[0][lane]), F(bounds[1][lane]), F(bounds[2][lane])},
          {F(bounds[3][lane]), F(bounds[4][lane]), F(bounds[5][lane])}};
}

// One shape of the query block: its box, bounding sphere and body.
struct Asker {
  Box box;
  F center[3];
  F radius;
  I body;
};

Asker broadcast_asker(const LeafBlock& query, int slot) {
  return {broadcast_box(query.bounds, slot),
          {F(query.center[0][slot]), F(query.center[1][slot]), F(query.center[2][slot])},
          F(query.radius[slot]),
          I(query.body[slot])};
}

// Appends the shapes of the block whose boxes and bounding spheres overlap the query's, which belong to other
// bodies, and whose bits are set in `asked`. Returns their bits. Does not branch on lanes, because branches
// would be mispredicted; only with few lanes does skipping pay.
std::uint32_t meet(const Asker& asker, const LeafBlock& block, std::uint32_t asked, std::int32_t* others,
                   int& count) {
  std::uint32_t result = 0;
  for (int lane = 0; lane < kBlock; lane += kLanes) {
    const M boxes = overlap(asker.box, &block.bounds[0][lane], kBlock) & mask_from_bits(asked >> lane);
#if SCREE_SIMD_LANES < 8
    if (bits(boxes) == 0) continue;  // nothing would be added
#endif
    // Differences and sums have the same bits (up to sign) whichever of the two shapes is the query.
    const F x = load(&block.center[0][lane]) - asker.center[0];
    const F y = load(&block.center[1][lane]) - asker.center[1];
    const F z = load(&block.center[2][lane]) - asker.center[2];
    const F sum = load(&block.radius[lane]) + asker.radius;
    const M others_body = !(load(&block.body[lane]) == asker.body);
    const M both = boxes & others_body & (x * x + y * y + z * z <= sum * sum);
    count += compress_store(others + count, both, load(&block.shape[lane]));
    result |= bits(both) << lane;
  }
  return result;
}

// May write up to kLanes pairs more than `count`.
void write_pairs(std::int32_t shape, const std::int32_t* others, int count, ShapePair* to) {
  int i = 0;
  do {
    const I other = load(others + i);
    const M smaller = other < I(shape);
    store_interleaved(reinterpret_cast<std::int32_t*>(to + i), select(smaller, other, I(shape)),
                      select(smaller, I(shape), other));
    i += kLanes;
  } while (i < count);
}

// The shapes of the target's leaf block `number` whose pairs with this shape are this one's to find. Of two
// of one tree that ask, it is the earlier one; of two trees, with `spares_moved`, the target's.
std::uint32_t asked_of(const JoinTask& task, int query_block, int slot, std::int32_t number) {
  if (task.spares_moved) return ~task.target.leaves[number].moved;
  if (!task.self || number > query_block) return ~0u;
  const std::uint32_t later = number == query_block ? ~((2u << slot) - 1u) : 0u;
  return task.moved_only ? later | ~task.target.leaves[number].moved : later;
}

// Pairs of one shape of the query block with the candidates.
void test_shape(const JoinTask& task, int query_block, int slot, const Candidates& candidates,
                JoinState& state) {
  const LeafBlock& query = task.query[query_block];
  const Asker asker = broadcast_asker(query, slot);
  alignas(64) std::int32_t others[(kMaxCandidates + 1) * kBlock];
  int count = 0;
  std::uint32_t special = 0;
  for (int first = 0; first < candidates.count; first += kLanes) {
    std::uint32_t met = bits(overlap(asker.box, &candidates.bounds[0][first], kMaxCandidates));
    for (; met != 0; met &= met - 1) {
      const std::int32_t number = candidates.block[first + __builtin_ctz(met)];
      const LeafBlock& block = task.target.leaves[number];
      const std::uint32_t asked = asked_of(task, query_block, slot, number);
      special |= block.special & meet(asker, block, asked, others, count);
    }
  }
  if (state.count + count + kBlock <= task.capacity) {
    store_unaligned(others + count, I(-1));  // the kernel reads whole registers, also beyond the end
    write_pairs(query.shape[slot], others, count, task.pairs + state.count);
  }
  state.count += count;
  state.special = state.special || special != 0 || (count > 0 && (query.special >> slot & 1u) != 0);
}

bool asks(const JoinTask& task, const LeafBlock& query, int slot) {
  return query.shape[slot] >= 0 && (!task.moved_only || (query.moved >> slot & 1u) != 0);
}

// Writes the pairs of the candidates with the shapes in slots [begin, end) of the query block, and clears the
// candidates.
void work_off(const JoinTask& task, int query_block, int begin, int end, Candidates& candidates,
              JoinState& state) {
  // Tests whole registers: the entries after the last candidate are empty.
  for (int i = candidates.count; i % kLanes != 0; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      candidates.bounds[axis][i] = kLargestFloat;
      candidates.bounds[axis + 3][i] = -kLargestFloat;
    }
  }
  for (int slot = begin; slot < end; ++slot) {
    if (asks(task, task.query[query_block], slot)) test_shape(task, query_block, slot, candidates, state);
  }
  candidates.count = 0;
}

// Collects the leaf blocks of the target that overlap the box. Calls make_room() when there are too many, and
// stops if it returns false.
template <class MakeRoom>
bool descend(const JoinTask& task, int query_block, const Box& box, Candidates& candidates,
             MakeRoom&& make_room) {
  struct Step {
    std::int32_t block;
    std::int32_t level;
  };
  Step stack[kMaxTreeLevels * kBlock];  // each level leaves at most its 16 children behind
  int depth = 0;
  candidates.count = 0;
  stack[depth++] = {0, task.target.levels - 1};
  while (depth > 0) {
    const Step step = stack[--depth];
    const NodeBlock& node = task.target.nodes[step.level][step.block];
    std::uint32_t met = overlap_bits(box, node.bounds);
    const std::int32_t first_child = step.block * kBlock;
    // Children that end before the query block have been queries themselves.
    if (task.self && !task.moved_only) {
      const std::int32_t skipped = (query_block >> (4 * step.level)) - first_child;
      if (skipped > 0) met &= ~((1u << skipped) - 1u);
    }
    for (; met != 0; met &= met - 1) {
      const int lane = __builtin_ctz(met);
      if (step.level > 0) {
        stack[depth++] = {first_child + lane, step.level - 1};
        continue;
      }
      if (candidates.count == kMaxCandidates && !make_room()) return false;
      for (int side = 0; side < 6; ++side)
        candidates.bounds[side][candidates.count] = node.bounds[side][lane];
      candidates.block[candidates.count++] = first_child + lane;
    }
  }
  return true;
}

// Around those that ask.
Box box_of_moved(const LeafBlock& query) {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    F lower(kLargestFloat), upper(-kLargestFloat);
    for (int lane = 0; lane < kBlock; lane += kLanes) {
      const M moved = mask_from_bits(query.moved >> lane);
      lower = min(lower, select(moved, load(&query.bounds[axis][lane]), F(kLargestFloat)));
      upper = max(upper, select(moved, load(&query.bounds[axis + 3][lane]), F(-kLargestFloat)));
    }
    box.lower[axis] = F(reduce_min(lower));
    box.upper[axis] = F(reduce_max(upper));
  }
  return box;
}

void join_block(const JoinTask& task, int query_block, Candidates& candidates, JoinState& state) {
  if (task.moved_only && task.query[query_block].moved == 0) return;
  const Box box = task.moved_only
                      ? box_of_moved(task.query[query_block])
                      : broadcast_box(task.query_boxes[query_block / kBlock].bounds, query_block % kBlock);
  if (descend(task, query_block, box, candidates, [] { return false; })) {
    work_off(task, query_block, 0, kBlock, candidates, state);
    return;
  }
  // The shapes lie far apart: the common box of a few awake shapes in a large world would overlap all of it.
  const LeafBlock& query = task.query[query_block];
  for (int slot = 0; slot < kBlock; ++slot) {
    if (!asks(task, query, slot)) continue;
    const auto work = [&] {
      work_off(task, query_block, slot, slot + 1, candidates, state);
      return true;
    };
    descend(task, query_block, broadcast_box(query.bounds, slot), candidates, work);
    work();
  }
}

// The box of 16 boxes, into one lane of the level above.
void store_union(const float (&bounds)[6][kBlock], NodeBlock* parents, int block) {
  float(&to)[6][kBlock] = parents[block / kBlock].bounds;
  for (int axis = 0; axis < 3; ++axis) {
    F lower = load(&bounds[axis][0]);
    F upper = load(&bounds[axis + 3][0]);
    for (int lane = kLanes; lane < kBlock; lane += kLanes) {
      lower = min(lower, load(&bounds[axis][lane]));
      upper = max(upper, load(&bounds[axis + 3][lane]));
    }
    to[axis][block % kBlock] = reduce_min(lower);
    to[axis + 3][block % kBlock] = reduce_max(upper);
  }
}

void gather_leaf(const RefitTask& task, int block) {
  LeafBlock& leaf = task.leaves[block];
  const float* rows = reinterpret_cast<const float*>(task.fat_bounds);
  for (int lane = 0; lane < kBlock; lane += kLanes) {
    const std::int32_t* order = task.order + block * static_cast<std::int64_t>(kBlock) + lane;
    alignas(64) std::int32_t index[kLanes];
    for (int i = 0; i < kLanes; ++i) index[i] = order[i] < 0 ? 0 : order[i];
    F lower[3], upper[3], radius, padding;
    load_rows(rows, 8, index, lower[0], lower[1], lower[2], radius);
    load_rows(rows + 4, 8, index, upper[0], upper[1], upper[2], padding);
    const M is_empty = load_unaligned(order) < I(0);
    store(&leaf.shape[lane], load_unaligned(order));
    store(&leaf.radius[lane], radius);
    for (int axis = 0; axis < 3; ++axis) {
      store(&leaf.center[axis][lane], (lower[axis] + upper[axis]) * F(0.5f));
      store(&leaf.bounds[axis][lane], select(is_empty, F(kLargestFloat), lower[axis]));
      store(&leaf.bounds[axis + 3][lane], select(is_empty, F(-kLargestFloat), upper[axis]));
    }
  }
}

}  // namespace

void refit_leaves(const RefitTask& task, int begin, int end);
void refit_leaves(const RefitTask& task, int begin, int end) {
  for (int block = begin; block < end; ++block) {
    gather_leaf(task, block);
    store_union(task.leaves[block].bounds, task.nodes, block);
  }
}

void refit_nodes(const NodeBlock* children, NodeBlock* parents, int begin, int end);
void refit_nodes(const NodeBlock* children, NodeBlock* parents, int begin, int end) {
  for (int block = begin; block < end; ++block) store_union(children[block].bounds, parents, block);
}

void join(const JoinTask& task, int end, JoinState& state);
void join(const JoinTask& task, int end, JoinState& state) {
  Candidates candidates;
  state.needed = 0;
  for (; state.block < end; ++state.block) {
    const std::int64_t count = state.count;
    const bool special = state.special;
    join_block(task, state.block, candidates, state);
    if (state.count + kBlock > task.capacity) {
      state.needed = state.count + kBlock;
      state.count = count;
      state.special = special;
      return;
    }
  }
}

// A member's rank is the number of smaller members: no branch depends on the values.
void rank_rows(const RankTask& task);
void rank_rows(const RankTask& task) {
  std::int32_t begin = 0;
  for (std::int32_t owner = 0; owner < task.owners; ++owner) {
    const std::int32_t end = task.row_ends[owner];
    for (std::int32_t i = begin; i < end && end - begin <= kRankedRow; ++i) {
      const std::int32_t other = task.others[i];
      std::int32_t place = begin;
      for (std::int32_t first = begin; first < end; first += kLanes) {
        const std::int32_t left = end - first;
        const std::uint32_t row = left < kLanes ? (1u << left) - 1u : ~0u;
        place += __builtin_popcount(bits(load_unaligned(task.others + first) < I(other)) & row);
      }
      task.pairs[place] = {task.first_owner + owner, other};
    }
    begin = end;
  }
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
