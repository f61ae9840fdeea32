// Kernels of the broad phase: bounds of shapes, boxes of trees, and the join of two trees.
//
// Called by update_bounds (poses -> bounds) and find_pairs (bounds -> trees -> pairs). Whether two shapes
// become a pair depends only on the bounds of the two.
#pragma once

#include <core/plain/rows.h>
#include <core/plain/tree.h>

#include <cstdint>

namespace scree::simd {

inline constexpr int kBlock = kTreeBlock;
using scree::kMaxTreeLevels;
using scree::NodeBlock;

// 16 shapes.
struct alignas(64) LeafBlock {
  float bounds[6][kBlock];
  float center[3][kBlock];  // of the bounding spheres
  float radius[kBlock];
  std::int32_t shape[kBlock];  // -1: empty
  std::int32_t body[kBlock];   // of the shapes; two of one body make no pair
  std::uint32_t special;       // bit per shape: its pairs must be checked for filters and joints
  std::uint32_t moved;         // bit per shape: it has new bounds; meaningful where JoinTask::moved_only
  std::uint32_t padding[14];
};

// An implicit 16-ary tree: child c of block b is block b * 16 + c of the level below.
struct TreeView {
  const LeafBlock* leaves;
  const NodeBlock* nodes[kMaxTreeLevels];  // nodes[0]: boxes of the leaf blocks
  int levels;                              // of nodes; 0: the tree is empty
  const PoseRow* pose;                     // by shape, may be null: queries fetch rows of shapes ...
  const ExtentRow* extent;                 // ... that they are about to ask ahead
};

// The values of ShapeType and BodyType that the bounds kernel distinguishes.
inline constexpr std::int32_t kBoundsSphere = 0;
inline constexpr std::int32_t kBoundsCapsule = 1;
inline constexpr std::int32_t kBoundsHull = 3;
inline constexpr std::int32_t kBoundsMesh = 4;
inline constexpr std::int32_t kBoundsRoundedBox = 6;
inline constexpr std::int32_t kBoundsRoundedHull = 7;
inline constexpr std::int32_t kBoundsCylinder = 8;
inline constexpr std::int32_t kBoundsCone = 9;
inline constexpr std::int32_t kBoundsFixedBody = 0;

// update_bounds: lane = shape, for the shapes list[begin] to list[end - 1].
struct BoundsTask {
  const std::int32_t* list;
  const std::int32_t* shape_body;
  const std::uint8_t* shape_type;
  const std::uint8_t* body_type;
  const ExtentRow* extent;
  const PoseRow* local_pose;
  const PoseRow* body_pose;
  const VelocityRow* body_velocity;
  PoseRow* shape_pose;    // written
  BoundsRow* fat_bounds;  // written where the shape left it, or everywhere if `force`
  StepMotion* motion;     // written; infinite for fast shapes, or all if `force`
  std::uint8_t* left;     // by place in the list: whether the shape left them; not written where null
  float dt;
  bool force;
};

// refit_leaves: gathers the bounds of order[16 b ...] into leaf block b and its box into nodes.
struct RefitTask {
  const std::int32_t* order;  // whole blocks; -1: empty
  const BoundsRow* fat_bounds;
  LeafBlock* leaves;
  NodeBlock* nodes;
};

// join: the pairs of the shapes in query blocks [begin, end) with the shapes of `target`.
struct JoinTask {
  const LeafBlock* query;
  const NodeBlock* query_boxes;
  TreeView target;
  bool self;          // target is the query's own tree: each pair is found once, by the earlier shape
  bool moved_only;    // only pairs with a shape of the query that has moved; see LeafBlock::moved
  bool spares_moved;  // and not with a shape of another tree that has moved: its own query finds these
  ShapePair* pairs;   // out; a < b
  std::int64_t capacity;
};

// Progress of a join. It ends at the first block whose pairs do not fit into capacity - kBlock. Then `count`
// is the number before that block, and `needed` the capacity that the block requires.
struct JoinState {
  int block;            // in, out: the next one
  std::int64_t count;   // in, out: pairs written
  std::int64_t needed;  // out
  bool special;         // in, out: some pair has a special shape
};

// Longest row that rank_rows accepts; the caller sorts longer ones.
inline constexpr std::int32_t kRankedRow = 256;

// rank_rows: consecutive rows of unordered members -> pairs in ascending order. Owner o's row begins where
// the row before it ends, and ends at row_ends[o].
struct RankTask {
  const std::int32_t* others;  // readable for a block beyond the last
  const std::int32_t* row_ends;
  std::int32_t first_owner;
  std::int32_t owners;
  ShapePair* pairs;
};

struct PairKernels {
  // Returns the number of shapes that left their fat bounds.
  int (*update_bounds)(const BoundsTask& task, int begin, int end);
  void (*refit_leaves)(const RefitTask& task, int begin, int end);
  // Boxes of the blocks [begin, end) of one level, into the level above.
  void (*refit_nodes)(const NodeBlock* children, NodeBlock* parents, int begin, int end);
  void (*join)(const JoinTask& task, int end, JoinState& state);
  void (*rank_rows)(const RankTask& task);
};

}  // namespace scree::simd
