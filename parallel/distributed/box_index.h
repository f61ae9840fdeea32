// Which boxes another box meets, among many; for ghosts.cpp and sweep_across.cpp.
#pragma once

#include <parallel/broad_phase/broad_phase.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

namespace scree {

inline BoundsRow empty_box() {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  BoundsRow box{};
  for (int axis = 0; axis < 3; ++axis) {
    box.lower[axis] = kInfinity;
    box.upper[axis] = -kInfinity;
  }
  return box;
}

inline void include(BoundsRow& box, const BoundsRow& other) {
  for (int axis = 0; axis < 3; ++axis) {
    box.lower[axis] = std::min(box.lower[axis], other.lower[axis]);
    box.upper[axis] = std::max(box.upper[axis], other.upper[axis]);
  }
}

// Boxes along the axis on which they reach farthest.
class BoxIndex {
 public:
  explicit BoxIndex(std::vector<BoundsRow> boxes) : boxes_(std::move(boxes)) {
    BoundsRow all = empty_box();
    for (const BoundsRow& box : boxes_) include(all, box);
    const auto reach = [&](int axis) { return all.upper[axis] - all.lower[axis]; };
    for (const int axis : {1, 2}) {
      if (reach(axis) > reach(axis_)) axis_ = axis;
    }
    std::sort(boxes_.begin(), boxes_.end(), [&](const BoundsRow& one, const BoundsRow& other) {
      return one.lower[axis_] < other.lower[axis_];
    });
    float farthest = -std::numeric_limits<float>::infinity();
    for (const BoundsRow& box : boxes_) reaches_.push_back(farthest = std::max(farthest, box.upper[axis_]));
  }
  bool meets(const BoundsRow& bounds) const {
    auto place = static_cast<std::size_t>(
        std::upper_bound(boxes_.begin(), boxes_.end(), bounds.upper[axis_],
                         [&](float upper, const BoundsRow& box) { return upper < box.lower[axis_]; }) -
        boxes_.begin());
    while (place > 0 && reaches_[--place] >= bounds.lower[axis_]) {
      if (bounds_meet(boxes_[place], bounds)) return true;
    }
    return false;
  }

 private:
  int axis_ = 0;
  std::vector<BoundsRow> boxes_;
  std::vector<float> reaches_;  // how far the boxes up to one of them reach
};

}  // namespace scree
