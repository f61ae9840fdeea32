// Brings ghosts: before pairs are found, each rank gets the bodies of others whose fat bounds meet those of
// its own, and those that joints tie to these. See border.h.
//
// All ranks tell each other the box around their shapes. Two whose boxes meet tell each other the boxes of
// small groups of their shapes, and each lends the bodies that meet one of the other's. That may be more than
// needed: a pair of two ghosts is none, whatever their bounds.
#include <core/world/edit.h>
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/crew/list_where.h>
#include <parallel/distributed/body_motion.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/messages.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <vector>

namespace scree {

namespace {

constexpr int kShapesPerBox = simd::kBlock;
constexpr int kBoxesPerTask = 64;

BoundsRow empty_box() {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  BoundsRow box{};
  for (int axis = 0; axis < 3; ++axis) {
    box.lower[axis] = kInfinity;
    box.upper[axis] = -kInfinity;
  }
  return box;
}

void include(BoundsRow& box, const BoundsRow& other) {
  for (int axis = 0; axis < 3; ++axis) {
    box.lower[axis] = std::min(box.lower[axis], other.lower[axis]);
    box.upper[axis] = std::max(box.upper[axis], other.upper[axis]);
  }
}

bool boxes_meet(const BoundsRow& x, const BoundsRow& y) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(x.lower[axis] <= y.upper[axis] && y.lower[axis] <= x.upper[axis])) return false;
  }
  return true;
}

// Writes Border::boxes, around groups of own shapes that are neighbors in the last tree, and returns the box
// around all of them.
BoundsRow box_own_shapes(const WorldData& data, Border& border, Crew& crew) {
  const BroadPhase& broad_phase = static_cast<const BroadPhase&>(*data.broad_phase);
  const Shapes& shapes = data.shapes;
  const Column<std::int32_t>& order = broad_phase.trees[kAwakeTree].order;
  const auto is_own = [&](std::int32_t shape) {
    return shapes.tree[shape] == TreeKind::awake && border.owns(shapes.body[shape]);
  };
  const auto is_in_tree = [&](std::int32_t shape) {
    return std::cmp_less(shape, broad_phase.tree_of.size()) && broad_phase.tree_of[shape] == kAwakeTree;
  };
  list_where(
      crew, shapes.moving.size(), border.places, border.found,
      [&](std::int32_t i) { return is_own(shapes.moving[i]) && !is_in_tree(shapes.moving[i]); },
      [&](std::int32_t i) { return shapes.moving[i]; });
  const auto in_tree = static_cast<int>(order.size()) / kShapesPerBox;
  const auto others = static_cast<int>(border.found.size());
  const int count = in_tree + (others + kShapesPerBox - 1) / kShapesPerBox;
  border.boxes.resize(static_cast<std::size_t>(count));
  crew.run_ranges(count, kBoxesPerTask, [&](int begin, int end, int) {
    for (int place = begin; place < end; ++place) {
      BoundsRow box = empty_box();
      const bool tree = place < in_tree;
      const Column<std::int32_t>& list = tree ? order : border.found;
      const int first = (tree ? place : place - in_tree) * kShapesPerBox;
      const int last = std::min(first + kShapesPerBox, static_cast<int>(list.size()));
      for (int i = first; i < last; ++i) {
        if (list[i] >= 0 && is_own(list[i])) include(box, shapes.fat_bounds[list[i]]);
      }
      border.boxes[static_cast<std::size_t>(place)] = box;
    }
  });
  BoundsRow all = empty_box();
  for (const BoundsRow& box : border.boxes) include(all, box);
  return all;
}

// The boxes of another rank, along the axis on which they reach farthest.
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
      if (boxes_meet(boxes_[place], bounds)) return true;
    }
    return false;
  }

 private:
  int axis_ = 0;
  std::vector<BoundsRow> boxes_;
  std::vector<float> reaches_;  // how far the boxes up to one of them reach
};

// Joints to bodies of other ranks.
void find_ties(const WorldData& data, Border& border) {
  const Joints& joints = data.joints;
  if (!border.ties_stale && joints.changed.empty() && !joints.all_changed) return;
  border.ties_stale = false;
  for (Halo& halo : border.halos) halo.tied.clear();
  const auto tie = [&](std::int32_t own, std::int32_t other) {
    const std::int32_t rank = border.owner_of(other);
    if (border.owns(own) && !border.owns(other) && rank != kEveryRank)
      border.halos[static_cast<std::size_t>(rank)].tied.push_back(own);
  };
  for (std::size_t joint = 0; joint < joints.flags.size(); ++joint) {
    if ((joints.flags[joint] & kJointAlive) == 0) continue;
    tie(joints.bodies[joint].a, joints.bodies[joint].b);
    tie(joints.bodies[joint].b, joints.bodies[joint].a);
  }
}

// Own bodies that meet the boxes of another rank, or are tied to its bodies.
std::vector<std::int32_t> list_lent(const WorldData& data, Border& border, const Halo& halo,
                                    const BoundsRow& around, const BoxIndex& boxes, Crew& crew) {
  const Shapes& shapes = data.shapes;
  list_where(
      crew, shapes.moving.size(), border.places, border.found,
      [&](std::int32_t i) {
        const std::int32_t shape = shapes.moving[i];
        return border.owns(shapes.body[shape]) && boxes_meet(shapes.fat_bounds[shape], around) &&
               boxes.meets(shapes.fat_bounds[shape]);
      },
      [&](std::int32_t i) { return shapes.body[shapes.moving[i]]; });
  std::vector<std::int32_t> lent(border.found.begin(), border.found.end());
  lent.insert(lent.end(), halo.tied.begin(), halo.tied.end());
  std::sort(lent.begin(), lent.end());
  lent.erase(std::unique(lent.begin(), lent.end()), lent.end());
  return lent;
}

// Of a list, what an earlier one had not.
std::vector<std::int32_t> arrivals_of(const std::vector<std::int32_t>& now,
                                      const std::vector<std::int32_t>& before) {
  std::vector<std::int32_t> arrivals;
  std::set_difference(now.begin(), now.end(), before.begin(), before.end(), std::back_inserter(arrivals));
  return arrivals;
}

constexpr std::int32_t kSameList = -1;

void send_halo(const WorldData& data, Border& border, std::int32_t to, std::vector<std::int32_t> lent) {
  Halo& halo = border.halos[static_cast<std::size_t>(to)];
  if (lent == halo.lent) return send_list<std::int32_t>(border.transport, to, std::span(&kSameList, 1));
  send_list<std::int32_t>(border.transport, to, lent);
  send_bodies(border, to, data, arrivals_of(lent, halo.lent));
  halo.lent = std::move(lent);
}

void receive_halo(WorldData& data, Border& border, std::int32_t from) {
  Halo& halo = border.halos[static_cast<std::size_t>(from)];
  std::vector<std::int32_t> borrowed = receive_list<std::int32_t>(border.transport, from);
  if (borrowed.size() == 1 && borrowed[0] == kSameList) return;
  for (std::size_t i = 0; i < borrowed.size(); ++i) {
    check_owner(border, from, borrowed[i]);
    if (i > 0 && borrowed[i] <= borrowed[i - 1]) refuse_world_of(from);
  }
  receive_bodies(border, from, data, arrivals_of(borrowed, halo.borrowed));
  halo.borrowed = std::move(borrowed);
}

// Bodies of others that nobody lends any more go. Returns whether any has come or gone.
bool replace_ghosts(WorldData& data, Border& border) {
  std::vector<std::int32_t> ghosts;
  for (const Halo& halo : border.halos)
    ghosts.insert(ghosts.end(), halo.borrowed.begin(), halo.borrowed.end());
  std::sort(ghosts.begin(), ghosts.end());
  if (ghosts == border.ghosts) return false;
  for (const std::int32_t body : arrivals_of(border.ghosts, ghosts)) set_absent(data, body, true);
  border.ghosts = std::move(ghosts);
  return true;
}

}  // namespace

void share_ghosts(WorldData& data, Crew& crew) {
  Border& border = *border_of(data);
  BroadPhase& broad_phase = broad_phase_of(data);
  const auto ranks = static_cast<std::int32_t>(border.halos.size());
  border.transport.begin_step();
  update_dirty_bounds(data, broad_phase, data.last_dt, crew);
  find_ties(data, border);
  if (border.halos_stale) {
    for (Halo& halo : border.halos) halo.lent.clear(), halo.borrowed.clear();
  }
  const std::vector<BoundsRow> around = gather_rows(border.transport, box_own_shapes(data, border, crew));
  const BoundsRow& own = around[static_cast<std::size_t>(border.transport.rank())];
  std::vector<std::int32_t> near;
  for (std::int32_t rank = 0; rank < ranks; ++rank) {
    Halo& halo = border.halos[static_cast<std::size_t>(rank)];
    if (rank == border.transport.rank()) continue;
    if (!halo.tied.empty() || boxes_meet(own, around[static_cast<std::size_t>(rank)])) {
      near.push_back(rank);
    } else {
      halo.lent.clear(), halo.borrowed.clear();  // as the other side does
    }
  }
  for (const std::int32_t to : near) {
    std::vector<BoundsRow> boxes;
    std::copy_if(border.boxes.begin(), border.boxes.end(), std::back_inserter(boxes),
                 [&](const BoundsRow& box) { return boxes_meet(box, around[static_cast<std::size_t>(to)]); });
    send_list<BoundsRow>(border.transport, to, boxes);
  }
  for (const std::int32_t to : near) {
    const BoxIndex boxes(receive_list<BoundsRow>(border.transport, to));
    const auto place = static_cast<std::size_t>(to);
    send_halo(data, border, to, list_lent(data, border, border.halos[place], around[place], boxes, crew));
  }
  for (const std::int32_t from : near) receive_halo(data, border, from);
  border.halos_stale = false;
  // A whole new list of pairs is made, as if calls had created or destroyed the ghosts.
  if (replace_ghosts(data, border)) broad_phase.left_is_known = false;
}

}  // namespace scree
