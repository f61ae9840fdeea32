// Brings ghosts: before pairs are found, each rank gets the bodies of others whose fat bounds meet those of
// its own, and those that joints tie to these. See border.h.
//
// All ranks tell each other the box around their shapes. Two whose boxes meet tell each other the boxes of
// small groups of their shapes, and each lends the bodies that meet one of the other's. That may be more than
// needed: a pair of two ghosts is none, whatever their bounds.
#include <core/world/edit.h>
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/crew/list_where.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/box_index.h>
#include <parallel/distributed/messages.h>
#include <parallel/distributed/send_bodies.h>
#include <parallel/stages.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace scree {

namespace {

constexpr std::size_t kShapesPerBox = 16;
constexpr int kShapesPerTask = 4096;
constexpr std::size_t kFewAdded = 256;  // resting shapes that do not pay for a new list

// Around all of them.
BoundsRow box_shapes(const WorldData& data, const Column<std::int32_t>& shapes, Crew& crew) {
  const auto count = static_cast<int>(shapes.size());
  std::vector<BoundsRow> parts(static_cast<std::size_t>((count + kShapesPerTask - 1) / kShapesPerTask));
  crew.run_ranges(count, kShapesPerTask, [&](int begin, int end, int) {
    BoundsRow box = empty_box();
    for (int i = begin; i < end; ++i) include(box, data.shapes.fat_bounds[shapes[i]]);
    parts[static_cast<std::size_t>(begin / kShapesPerTask)] = box;
  });
  BoundsRow all = empty_box();
  for (const BoundsRow& box : parts) include(all, box);
  return all;
}

// Lists own bodies' shapes that are there.
void list_own_shapes(const WorldData& data, Border& border, Crew& crew) {
  const Shapes& shapes = data.shapes;
  list_where(
      crew, shapes.moving.size(), border.places, border.own_shapes,
      [&](std::int32_t i) { return border.owns(shapes.body[shapes.moving[i]]); },
      [&](std::int32_t i) { return shapes.moving[i]; });
}

// `changed`: all shapes that may have come to rest since the last step.
void list_resting_shapes(const WorldData& data, Border& border, const Column<std::int32_t>& changed,
                         Crew& crew) {
  RestingShapes& resting = border.resting;
  const std::size_t kept = resting.shapes.size() - resting.added;
  if (border.halos_stale || data.bodies.asleep == 0 || resting.is_stale ||
      resting.added > kFewAdded + kept / 2) {
    resting.shapes.clear();
    if (data.bodies.asleep > 0)
      list_where(crew, data.shapes.flags.size(), border.places, resting.shapes,
                 [&](std::int32_t shape) { return rests_here(data, border, shape); });
    resting.box = box_shapes(data, resting.shapes, crew);
    resting.added = 0;
    resting.is_stale = false;
    ++resting.lists;
    return;
  }
  for (const std::int32_t shape : changed) {
    if (!rests_here(data, border, shape)) continue;
    resting.shapes.push_back(shape);
    include(resting.box, data.shapes.fat_bounds[shape]);
    ++resting.added;
  }
}

// All ranks' boxes. They tell, too, whether calls have made manifolds stale, which only those find who have
// the body.
void share_boxes(WorldData& data, Border& border, Crew& crew) {
  BoundsRow own = box_shapes(data, border.own_shapes, crew);
  include(own, border.resting.box);
  own.padding = data.contacts.manifolds_stale ? 1.0f : 0.0f;
  border.around = gather_rows(border.transport, own);
  for (const BoundsRow& of_rank : border.around)
    data.contacts.manifolds_stale = data.contacts.manifolds_stale || of_rank.padding != 0.0f;
}

// Of a list, from some place on, the shapes that meet a box -> Border::found.
void find_near(const WorldData& data, Border& border, std::span<const std::int32_t> shapes,
               const BoundsRow& box, Crew& crew) {
  list_where(
      crew, shapes.size(), border.places, border.found,
      [&](std::int32_t i) {
        return bounds_meet(data.shapes.fat_bounds[shapes[static_cast<std::size_t>(i)]], box);
      },
      [&](std::int32_t i) { return shapes[static_cast<std::size_t>(i)]; });
}

bool is_same_box(const BoundsRow& one, const BoundsRow& other) {
  return std::equal(std::begin(one.lower), std::end(one.lower), std::begin(other.lower)) &&
         std::equal(std::begin(one.upper), std::end(one.upper), std::begin(other.upper));
}

// Lists own shapes that lie in the box around those of another rank; of resting ones looks at those alone
// that it has not seen, as long as the box stays.
void list_near(const WorldData& data, Border& border, std::int32_t rank, Crew& crew) {
  const BoundsRow& around = border.around[static_cast<std::size_t>(rank)];
  Halo& halo = border.halos[static_cast<std::size_t>(rank)];
  const std::span<const std::int32_t> resting = std::as_const(border.resting.shapes).span();
  if (halo.resting_list != border.resting.lists || !is_same_box(halo.resting_box, around)) {
    halo.near_resting.clear();
    halo.resting_seen = 0;
    halo.resting_list = border.resting.lists;
    halo.resting_box = around;
  }
  find_near(data, border, resting.subspan(halo.resting_seen), around, crew);
  halo.near_resting.insert(halo.near_resting.end(), border.found.begin(), border.found.end());
  halo.resting_seen = resting.size();
  find_near(data, border, std::as_const(border.own_shapes).span(), around, crew);
  halo.near.assign(border.found.begin(), border.found.end());
  const std::size_t awake = halo.near.size();
  std::copy_if(halo.near_resting.begin(), halo.near_resting.end(), std::back_inserter(halo.near),
               [&](std::int32_t shape) { return rests_here(data, border, shape); });
  const std::size_t resting_still = halo.near.size() - awake;
  if (halo.near_resting.size() > kFewAdded + 2 * resting_still) border.resting.is_stale = true;
}

// Spreads ten bits, to every third place.
std::uint32_t spread_bits(std::uint32_t bits) {
  bits = (bits | bits << 16) & 0x030000ffu;
  bits = (bits | bits << 8) & 0x0300f00fu;
  bits = (bits | bits << 4) & 0x030c30c3u;
  return (bits | bits << 2) & 0x09249249u;
}

// Boxes around groups of these shapes. They are sorted along a curve (G. M. Morton, "A computer oriented
// geodetic data base", 1966), so that groups are near each other and boxes small.
std::vector<BoundsRow> box_groups(const WorldData& data, const std::vector<std::int32_t>& shapes) {
  BoundsRow all = empty_box();
  for (const std::int32_t shape : shapes) include(all, data.shapes.fat_bounds[shape]);
  const auto place_of = [&](std::int32_t shape) {
    const BoundsRow& bounds = data.shapes.fat_bounds[shape];
    std::uint32_t place = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const float share = (bounds.lower[axis] - all.lower[axis]) / (all.upper[axis] - all.lower[axis]);
      const float cell = share >= 0.0f ? std::min(1023.0f * share, 1023.0f) : 0.0f;  // nor no number
      place |= spread_bits(static_cast<std::uint32_t>(cell)) << axis;
    }
    return place;
  };
  std::vector<std::pair<std::uint32_t, std::int32_t>> sorted;
  for (const std::int32_t shape : shapes) sorted.push_back({place_of(shape), shape});
  std::sort(sorted.begin(), sorted.end());
  std::vector<BoundsRow> boxes;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    if (i % kShapesPerBox == 0) boxes.push_back(empty_box());
    include(boxes.back(), data.shapes.fat_bounds[sorted[i].second]);
  }
  return boxes;
}

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
std::vector<std::int32_t> list_lent(const WorldData& data, const Halo& halo, const BoxIndex& boxes) {
  const Shapes& shapes = data.shapes;
  std::vector<std::int32_t> lent = halo.tied;
  for (const std::int32_t shape : halo.near) {
    if (boxes.meets(shapes.fat_bounds[shape])) lent.push_back(shapes.body[shape]);
  }
  keep_each_once(lent);
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
  send_bodies(border.transport, to, data, arrivals_of(lent, halo.lent));
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
  receive_bodies(border.transport, from, data, arrivals_of(borrowed, halo.borrowed));
  halo.borrowed = std::move(borrowed);
}

// Calls wake bodies by what touches them, which their owners know. What touches none of a rank's own bodies
// may have woken its ghosts.
void share_rest(WorldData& data, Border& border) {
  struct Rest {
    float sleep_time;
    std::int32_t is_asleep;
  };
  Bodies& bodies = data.bodies;
  share_halos<Rest>(
      border, [](std::int32_t) { return true; },
      [&](std::int32_t body) {
        return Rest{bodies.sleep_time[body], is_asleep(bodies, body) ? 1 : 0};
      },
      [&](std::int32_t body, const Rest& rest) {
        if (rest.is_asleep != 0 && !is_asleep(bodies, body)) refuse_world_of(border.owner_of(body));
        if (rest.is_asleep == 0 && is_asleep(bodies, body)) wake_body(data, body);
        bodies.sleep_time[body] = rest.sleep_time;
      });
}

// Bodies of others that nobody lends any more go. Returns whether any has come or gone.
bool replace_ghosts(WorldData& data, Border& border) {
  std::vector<std::int32_t> ghosts;
  for (const Halo& halo : border.halos)
    ghosts.insert(ghosts.end(), halo.borrowed.begin(), halo.borrowed.end());
  std::sort(ghosts.begin(), ghosts.end());
  if (ghosts == border.ghosts) return false;
  const std::vector<std::int32_t> gone = arrivals_of(border.ghosts, ghosts);
  for (const std::int32_t body : gone) set_absent(data, body, true);
  border.gone += gone.size();
  border.ghosts = std::move(ghosts);
  return true;
}

}  // namespace

void share_ghosts(WorldData& data, Crew& crew) {
  Border& border = *border_of(data);
  BroadPhase& broad_phase = broad_phase_of(data);
  const auto ranks = static_cast<std::int32_t>(border.halos.size());
  update_dirty_bounds(data, broad_phase, data.last_dt, crew);
  give_up_rows(data, border);
  find_ties(data, border);
  if (border.halos_stale) {
    pull_all_pairs(data, crew);  // pairs at rest of others' bodies are not for this rank to know
    for (Halo& halo : border.halos) halo.lent.clear(), halo.borrowed.clear();
  }
  list_own_shapes(data, border, crew);
  list_resting_shapes(data, border, broad_phase.changed, crew);
  share_boxes(data, border, crew);
  const std::vector<BoundsRow>& around = border.around;
  const BoundsRow& own = around[static_cast<std::size_t>(border.transport.rank())];
  std::vector<std::int32_t> near;
  for (std::int32_t rank = 0; rank < ranks; ++rank) {
    Halo& halo = border.halos[static_cast<std::size_t>(rank)];
    if (rank == border.transport.rank()) continue;
    if (!halo.tied.empty() || bounds_meet(own, around[static_cast<std::size_t>(rank)])) {
      near.push_back(rank);
    } else {
      halo.lent.clear(), halo.borrowed.clear();  // as the other side does
    }
  }
  for (const std::int32_t to : near) {
    list_near(data, border, to, crew);
    const std::vector<BoundsRow> boxes = box_groups(data, border.halos[static_cast<std::size_t>(to)].near);
    send_list<BoundsRow>(border.transport, to, boxes);
  }
  for (const std::int32_t to : near) {
    const BoxIndex boxes(receive_list<BoundsRow>(border.transport, to));
    send_halo(data, border, to, list_lent(data, border.halos[static_cast<std::size_t>(to)], boxes));
  }
  for (const std::int32_t from : near) receive_halo(data, border, from);
  if (data.settings.sleeping) share_rest(data, border);
  border.halos_stale = false;
  // A whole new list of pairs is made, as if calls had created or destroyed the ghosts. Finding the pairs of
  // these alone, as of what has left its bounds, was no faster in pile, drum, wheel_pile and ragdoll_rain.
  if (replace_ghosts(data, border)) broad_phase.left_is_known = false;
}

void enter_ghosts(WorldData& data, std::span<const std::int32_t> come, Crew& crew) {
  Border& border = *border_of(data);
  BroadPhase& broad_phase = broad_phase_of(data);
  border.ghosts.insert(border.ghosts.end(), come.begin(), come.end());
  keep_each_once(border.ghosts);
  Column<std::int32_t> later;
  later.swap(broad_phase.changed);
  refresh_lists(data, crew);
  update_members(data, broad_phase, crew);
  broad_phase.changed.append(std::as_const(later).span());
  broad_phase.bounds_left.store(true, std::memory_order_relaxed);
  broad_phase.left_is_known = false;
  data.contacts.pairs_stale = true;
}

}  // namespace scree
