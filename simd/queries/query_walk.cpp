// Walks through the trees of shapes for queries; see query_walk.h.
#include <simd/queries/query_walk.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

template <class Measure>
float walk(const Measure& measure, const TreeView& tree, float limit, AskShape ask, void* context) {
  return walk_nodes(measure, tree.nodes, tree.levels, limit, [&](std::int32_t block, float, float now) {
    const LeafBlock& leaf = tree.leaves[block];
    Visit shapes[kBlock];
    int count = list_children(measure, leaf.bounds, now, 0, 0, shapes);
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
