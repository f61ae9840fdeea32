// Walks through trees of blocks: lane = child of a block. Each walk has a measure, which tells for 16 boxes
// at once from where on they matter, and goes to those that matter first. Walks through the broad phase's
// trees (query_walk.cpp) and through those of meshes (mesh_walk.cpp) share it.
//
// A measure of a box is at most that of what lies within it, in spite of rounding: a walk that goes on while
// measures are at most the limit misses nothing.
#pragma once

#include <simd/queries/query_kernels.h>
#include <simd/wide/wide.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// More than the relative errors of the few operations of a measure: eight units in the last place.
inline constexpr float kLess = 1.0f - 5e-7f, kMore = 1.0f + 5e-7f;

using Bounds = float[6][kBlock];

// The fraction at which the moving box enters, or a miss. The differences are exact but for one rounding, so
// the errors are relative ones (T. Ize, "Robust BVH ray traversal", JCGT 2(2), 2013).
class Crossing {
 public:
  explicit Crossing(const CrossTask& task) {
    for (int axis = 0; axis < 3; ++axis) {
      origin_[axis] = F(task.origin[axis]);
      inverse_[axis] = F(task.inverse[axis]);
      const bool backward = task.inverse[axis] < 0.0f;
      near_[axis] = backward ? axis + 3 : axis;
      far_[axis] = backward ? axis : axis + 3;
      near_half_[axis] = backward ? F(task.half[axis]) : F(-task.half[axis]);
    }
  }
  std::uint32_t measure(const Bounds& bounds, int first, float limit, float* at) const {
    F enters(0.0f), leaves(limit);
    for (int axis = 0; axis < 3; ++axis) {
      const F near = load(&bounds[near_[axis]][first]) + near_half_[axis];
      const F far = load(&bounds[far_[axis]][first]) - near_half_[axis];
      enters = max(enters, (near - origin_[axis]) * inverse_[axis]);
      leaves = min(leaves, (far - origin_[axis]) * inverse_[axis]);
    }
    enters = enters * F(kLess);
    store(at, enters);
    return bits(enters <= leaves * F(kMore));
  }

 private:
  F origin_[3], inverse_[3], near_half_[3];
  int near_[3], far_[3];
};

// Zero where the boxes meet.
class Meeting {
 public:
  explicit Meeting(const MeetTask& task) {
    for (int axis = 0; axis < 3; ++axis) {
      lower_[axis] = F(task.lower[axis]);
      upper_[axis] = F(task.upper[axis]);
    }
  }
  std::uint32_t measure(const Bounds& bounds, int first, float, float* at) const {
    M meets(lower_[0] <= load(&bounds[3][first]));
    meets = meets & (load(&bounds[0][first]) <= upper_[0]);
    for (int axis = 1; axis < 3; ++axis) {
      meets = meets & (lower_[axis] <= load(&bounds[axis + 3][first])) &
              (load(&bounds[axis][first]) <= upper_[axis]);
    }
    store(at, F(0.0f));
    return bits(meets);
  }

 private:
  F lower_[3], upper_[3];
};

// The square of the distance of the boxes.
class Approach {
 public:
  explicit Approach(const MeetTask& task) {
    for (int axis = 0; axis < 3; ++axis) {
      lower_[axis] = F(task.lower[axis]);
      upper_[axis] = F(task.upper[axis]);
    }
  }
  std::uint32_t measure(const Bounds& bounds, int first, float limit, float* at) const {
    F sum(0.0f);
    for (int axis = 0; axis < 3; ++axis) {
      const F below = load(&bounds[axis][first]) - upper_[axis];
      const F above = lower_[axis] - load(&bounds[axis + 3][first]);
      const F apart = max(max(below, above), F(0.0f));
      sum = sum + apart * apart;
    }
    sum = sum * F(kLess);
    store(at, sum);
    return bits(sum <= F(limit));
  }

 private:
  F lower_[3], upper_[3];
};

// A block or shape that is still to be visited, and from where on it matters.
struct Visit {
  float at;
  std::int32_t child;
  std::int32_t level;
};

// Writes the children that matter within the limit, those that matter first behind the others. Returns their
// number.
template <class Measure>
int list_children(const Measure& measure, const Bounds& bounds, float limit, std::int32_t first_child,
                  std::int32_t level, Visit* list) {
  alignas(64) float at[kBlock];
  std::uint32_t met = 0;
  for (int first = 0; first < kBlock; first += kLanes) {
    met |= measure.measure(bounds, first, limit, at + first) << first;
  }
  int count = 0;
  for (; met != 0; met &= met - 1) {
    const int lane = __builtin_ctz(met);
    int place = count++;
    for (; place > 0 && list[place - 1].at < at[lane]; --place) list[place] = list[place - 1];
    list[place] = {at[lane], first_child + lane, level};
  }
  return count;
}

// Walks through a tree whose root is the only block of the last of `levels` levels. Leaf blocks that matter
// are handed to visit(block, at, limit), which returns the new limit; one below zero ends the walk.
template <class Measure, class VisitLeaf>
float walk_nodes(const Measure& measure, const NodeBlock* const* nodes, int levels, float limit,
                 VisitLeaf&& visit) {
  if (levels == 0) return limit;
  Visit stack[(kMaxTreeLevels + 1) * kBlock];  // each level leaves at most its 16 children behind
  int depth = 0;
  stack[depth++] = {0.0f, 0, levels - 1};
  while (depth > 0) {
    const Visit next = stack[--depth];
    if (!(next.at <= limit)) continue;
    if (next.level >= 0) {
      const NodeBlock& node = nodes[next.level][next.child];
      depth += list_children(measure, node.bounds, limit, next.child * kBlock, next.level - 1, stack + depth);
      continue;
    }
    limit = visit(next.child, next.at, limit);
    if (limit < 0.0f) return limit;
  }
  return limit;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
