// Walks through the trees of shapes for queries; see query_walk.h.
#include <simd/queries/query_walk.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// Rows of shapes are all over memory: those that are asked next come while the first is asked. Rays among
// 100,000 bodies take 7 to 11 % less time so. Fetching the next block of the tree ahead gains nothing.
void fetch_ahead(const TreeView& tree, const LeafBlock& leaf, const Visit* shapes, int count) {
  for (int i = 0; i < count; ++i) {
    const std::int32_t shape = leaf.shape[shapes[i].child];
    if (shape < 0) continue;
    __builtin_prefetch(tree.pose + shape);
    __builtin_prefetch(tree.extent + shape);
  }
}

template <class Measure>
float walk(const Measure& measure, const TreeView& tree, float limit, AskShape ask, void* context) {
  return walk_nodes(measure, tree.nodes, tree.levels, limit, [&](std::int32_t block, float, float now) {
    const LeafBlock& leaf = tree.leaves[block];
    Visit shapes[kBlock];
    int count = list_children(measure, leaf.bounds, now, 0, 0, shapes);
    if (tree.pose != nullptr) fetch_ahead(tree, leaf, shapes, count);
    while (count > 0) {
      const Visit shape = shapes[--count];
      if (!(shape.at <= now)) break;
      if (leaf.shape[shape.child] >= 0) now = ask(context, leaf.shape[shape.child], now);
    }
    return now;
  });
}

}  // namespace

float cross_tree(const TreeView& tree, const CrossTask& task, float limit, AskShape ask, void* context);
float cross_tree(const TreeView& tree, const CrossTask& task, float limit, AskShape ask, void* context) {
  return walk(Crossing(task), tree, limit, ask, context);
}

float meet_tree(const TreeView& tree, const MeetTask& task, float limit, AskShape ask, void* context);
float meet_tree(const TreeView& tree, const MeetTask& task, float limit, AskShape ask, void* context) {
  return walk(Meeting(task), tree, limit, ask, context);
}

float approach_tree(const TreeView& tree, const MeetTask& task, float limit, AskShape ask, void* context);
float approach_tree(const TreeView& tree, const MeetTask& task, float limit, AskShape ask, void* context) {
  return walk(Approach(task), tree, limit, ask, context);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
