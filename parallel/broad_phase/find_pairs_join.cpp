// Joins of the broad phase: trees -> unsorted pairs, chunk by chunk, for sort_pairs. Frozen trees are not
// joined with one another: pairs of two frozen shapes are carried over from the last list.
#include <core/constraints/joint_parameters.h>
#include <core/world/pair_key.h>
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/distributed/border.h>

#include <algorithm>
#include <limits>
#include <new>

namespace scree {

namespace {

constexpr int kBlocksPerChunk = 8;        // of 16 shapes: 10 to 20 microseconds
constexpr int kRowsPerChunk = 4096;       // of the last list
constexpr std::size_t kFirstPairs = 512;  // room that a chunk starts with

bool same_or_never(const Filter& x, const Filter& y) {
  if (x.group != 0 && x.group == y.group) return x.group < 0;
  return (x.mask & y.category) == 0 || (y.mask & x.category) == 0;
}

struct JoinRules {
  bool filter_all = false;    // all pairs, not just those of special shapes
  bool moved_only = false;    // as JoinTask has it
  bool spares_moved = false;  // as JoinTask has it
};

// Appends the pairs of the query blocks [begin, end) with one tree to `pairs`. `pairs` keeps its whole
// capacity as its size; returns the number of rows that count.
std::int64_t join_blocks(const WorldData& data, const PairTree& query, const PairTree& target, int begin,
                         int end, JoinRules rules, std::int64_t count, Column<ShapePair>& pairs, Crew& crew) {
  if (target.levels == 0) return count;
  simd::JoinTask task{};
  task.query = query.leaves.data();
  task.query_boxes = query.nodes[0].data();
  task.target.leaves = target.leaves.data();
  for (int level = 0; level < target.levels; ++level) task.target.nodes[level] = target.nodes[level].data();
  task.target.levels = target.levels;
  task.self = &query == &target;
  task.moved_only = rules.moved_only;
  task.spares_moved = rules.spares_moved;
  simd::JoinState state{begin, count, 0, false};
  while (true) {
    task.pairs = pairs.data();
    task.capacity = static_cast<std::int64_t>(pairs.size());
    crew.kernels().pair.join(task, end, state);
    if (state.block == end) break;
    pairs.resize(state.needed + state.needed / 2);
  }
  const Border* const border = border_of(data);
  const bool filters = state.special || rules.filter_all;
  if (!filters && border == nullptr) return state.count;
  ShapePair* const first = pairs.data() + count;
  ShapePair* const last = pairs.data() + state.count;
  const auto is_none = [&](const ShapePair& pair) {
    return (filters && !may_collide(data, pair.a, pair.b)) ||
           !knows(border, data.shapes.body[pair.a], data.shapes.body[pair.b]);
  };
  return std::remove_if(first, last, is_none) - pairs.data();
}

// Appends the rows of the last list whose shapes both still exist and are frozen, and still overlap if a call
// has changed one.
void carry_rows(const WorldData& data, const BroadPhase& broad_phase, int begin, int end,
                Column<ShapePair>& pairs) {
  const bool changed = data.contacts.pairs_stale || !broad_phase.dirty.empty();
  const Border* const border = border_of(data);
  for (int row = begin; row < end; ++row) {
    const ShapePair pair = data.contacts.pairs.pair[row];
    const std::int32_t a = pair.a, b = pair.b;
    if (!is_frozen_tree(broad_phase.tree_of[a]) || !is_frozen_tree(broad_phase.tree_of[b])) continue;
    if (changed) {
      if (((data.shapes.flags[a] | data.shapes.flags[b]) & kShapeNew) != 0) continue;
      if (!may_collide(data, pair.a, pair.b)) continue;
      if (!knows(border, data.shapes.body[pair.a], data.shapes.body[pair.b])) continue;
      const bool either_dirty = (broad_phase.is_dirty[a] | broad_phase.is_dirty[b]) != 0;
      if (either_dirty && !bounds_meet(data.shapes.fat_bounds[a], data.shapes.fat_bounds[b])) continue;
    }
    pairs.push_back(pair);
  }
}

int chunks_of(int count, int size) { return (count + size - 1) / size; }

// Whether this joint joins these bodies and keeps them from colliding.
bool holds_apart(const Joints& joints, std::int32_t joint, std::int32_t body_a, std::int32_t body_b) {
  const JointBodies ends = joints.bodies[joint];
  return (joints.flags[joint] & (kJointEnabled | kJointCollides)) == kJointEnabled &&
         ((ends.a == body_a && ends.b == body_b) || (ends.a == body_b && ends.b == body_a));
}

// By a joint whose bodies do not collide. It is in the lists of both, so the shorter list suffices.
bool are_held_apart(const WorldData& data, std::int32_t body_a, std::int32_t body_b) {
  const Joints& joints = data.joints;
  std::int32_t of_a = data.bodies.first_joint[body_a];
  std::int32_t of_b = data.bodies.first_joint[body_b];
  while (of_a >= 0 && of_b >= 0) {
    if (holds_apart(joints, of_a, body_a, body_b) || holds_apart(joints, of_b, body_a, body_b)) return true;
    of_a = next_joint(joints, of_a, body_a);
    of_b = next_joint(joints, of_b, body_b);
  }
  return false;
}

}  // namespace

bool may_collide(const WorldData& data, std::int32_t shape_a, std::int32_t shape_b) {
  const std::int32_t body_a = data.shapes.body[shape_a];
  const std::int32_t body_b = data.shapes.body[shape_b];
  if (body_a == body_b || is_sensor(data.shapes, shape_a) || is_sensor(data.shapes, shape_b)) return false;
  if (data.bodies.type[body_a] != BodyType::dynamic && data.bodies.type[body_b] != BodyType::dynamic)
    return false;
  if (same_or_never(data.shapes.filter[shape_a], data.shapes.filter[shape_b])) return false;
  return !are_held_apart(data, data.shapes.body[shape_a], data.shapes.body[shape_b]);
}

std::int64_t join_trees(WorldData& data, BroadPhase& broad_phase, JoinScope scope, Crew& crew) {
  const bool carry = scope == JoinScope::all_and_carried, moved_only = scope == JoinScope::moved;
  const PairTree& awake = broad_phase.trees[kAwakeTree];
  const PairTree& kinematic = broad_phase.trees[kKinematicTree];
  const int awake_chunks = chunks_of(leaf_blocks(awake), kBlocksPerChunk);
  const int kinematic_chunks = chunks_of(leaf_blocks(kinematic), kBlocksPerChunk);
  const auto rows = static_cast<int>(data.contacts.pairs.pair.size());
  const int chunks = awake_chunks + kinematic_chunks + (carry ? chunks_of(rows, kRowsPerChunk) : 0);
  std::vector<Column<ShapePair>>& found = broad_phase.found;
  const auto used = static_cast<std::size_t>(chunks);
  if (found.size() < used) found.resize(used);
  for (std::size_t unused = used; unused < found.size(); ++unused) found[unused].clear();

  crew.run(chunks, [&](int chunk, int) {
    Column<ShapePair>& pairs = found[static_cast<std::size_t>(chunk)];
    if (chunk >= awake_chunks + kinematic_chunks) {
      pairs.clear();
      const int begin = (chunk - awake_chunks - kinematic_chunks) * kRowsPerChunk;
      carry_rows(data, broad_phase, begin, std::min(begin + kRowsPerChunk, rows), pairs);
      return;
    }
    pairs.resize_discarding(std::max(pairs.capacity_bytes() / sizeof(ShapePair), kFirstPairs));
    std::int64_t count = 0;
    if (chunk < awake_chunks) {
      const int begin = chunk * kBlocksPerChunk;
      const int end = std::min(begin + kBlocksPerChunk, leaf_blocks(awake));
      for (const PairTree& target : std::span(broad_phase.trees).subspan(kAwakeTree)) {
        count = join_blocks(data, awake, target, begin, end, {.moved_only = moved_only}, count, pairs, crew);
      }
    } else {  // kinematic bodies wake sleeping ones; against fixed ones they have nothing to do
      const int begin = (chunk - awake_chunks) * kBlocksPerChunk;
      const int end = std::min(begin + kBlocksPerChunk, leaf_blocks(kinematic));
      for (const PairTree& frozen : frozen_trees(broad_phase)) {
        count = join_blocks(data, kinematic, frozen, begin, end,
                            {.filter_all = true, .moved_only = moved_only}, count, pairs, crew);
      }
      // Awake shapes ask kinematic ones; but if only what has moved asks, these must ask those that have not.
      if (moved_only)
        count = join_blocks(data, kinematic, awake, begin, end, {.moved_only = true, .spares_moved = true},
                            count, pairs, crew);
    }
    pairs.resize(count);
  });

  std::int64_t total = 0;
  for (const Column<ShapePair>& pairs : found) total += static_cast<std::int64_t>(pairs.size());
  // Rows are numbered with 32 bits; more of them would take some 800 GB.
  if (total > std::numeric_limits<std::int32_t>::max()) throw std::bad_alloc();
  return total;
}

}  // namespace scree
