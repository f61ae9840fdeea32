// Finds pairs: bounds -> the list of candidate pairs, sorted by (a, b), a < b, and the place of each in the
// last list.
//
// Keeps the list while no shape leaves its fat bounds and no call changes anything. Else joins the trees of
// awake, kinematic and frozen shapes into a new list, or where few shapes have left their bounds, joins these
// and keeps the other pairs (find_pairs_moved.cpp). It depends on the bounds alone, never on the order in
// the trees or on how the work was split.
//
// Pairs of two frozen shapes rest in rows of their own. These cost nothing until one of their shapes wakes or
// a call changes it: then they are pulled out of `resting` before the new list is made. Pairs of the new list
// whose shapes are both frozen go there. The other resting pairs are not read.
#include <core/world/resting_pairs.h>
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/broad_phase/merge_pairs.h>
#include <parallel/crew/list_where.h>
#include <parallel/stages.h>

#include <algorithm>
#include <utility>

namespace scree {

namespace {

constexpr int kPairsPerChunk = 2048;       // 5 to 10 microseconds
constexpr std::size_t kRowsPerShape = 16;  // at rest, which cost as much to pass over as one shape's to find

// Finds the rows of the new list in the last one. Returns whether both lists are the same.
bool match_rows(WorldData& data, const BroadPhase& broad_phase, Crew& crew) {
  const Column<ShapePair>& last = data.contacts.pairs.pair;
  const Column<ShapePair>& list = broad_phase.sorted;
  Column<std::int32_t>& previous = data.contacts.last_place;
  previous.resize_discarding(list.size());
  data.contacts.last_number = data.contacts.list_number;
  const bool some_new = !broad_phase.dirty.empty();
  std::atomic<bool> same{list.size() == last.size()};
  crew.run_ranges(static_cast<int>(list.size()), kPairsPerChunk, [&](int begin, int end, int) {
    const ShapePair* const behind = last.end();
    const ShapePair* row = std::lower_bound(last.begin(), behind, list[begin], comes_before);
    bool in_place = true;
    for (int i = begin; i < end; ++i) {
      const ShapePair pair = list[i];
      const std::uint64_t key = key_of(pair);
      while (row != behind && key_of(*row) < key) ++row;
      bool found = row != behind && key_of(*row) == key;
      if (some_new && ((data.shapes.flags[pair.a] | data.shapes.flags[pair.b]) & kShapeNew) != 0) {
        found = false;
      }
      const std::int32_t before = found ? static_cast<std::int32_t>(row - last.begin()) : -1;
      previous[i] = before;
      in_place = in_place && before == i;
    }
    if (!in_place) same.store(false, std::memory_order_relaxed);
  });
  return same.load(std::memory_order_relaxed);
}

// Adds the other contacts of the pairs whose first ones are listed.
void add_followers(const ContactRows& contacts, Column<std::int32_t>& list) {
  const std::size_t pairs = list.size();
  for (std::size_t i = 0; i < pairs; ++i) {
    for (std::int32_t next = next_contact(contacts, list[i]); next >= 0;
         next = next_contact(contacts, next)) {
      list.push_back(next);
    }
  }
}

void swap_pairs(Contacts& contacts) {
  std::swap(contacts.pairs, contacts.pairs_before);
  ++contacts.list_number;
}

// Makes the new list `pairs` and the last one `pairs_before`. Contacts stay in their rows: their pairs keep
// the numbers, and rows of pairs that are gone become free.
void swap_lists(WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  Contacts& contacts = data.contacts;
  swap_pairs(contacts);
  PairRows& pairs = contacts.pairs;
  PairRows& before = contacts.pairs_before;
  pairs.pair.swap(broad_phase.sorted);
  const std::size_t count = pairs.pair.size();
  const bool hulls = !data.hulls.data.empty();
  pairs.contact.resize_discarding(count);
  pairs.axis.resize_discarding(hulls ? count : 0);
  crew.run_ranges(static_cast<int>(count), kPairsPerChunk, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) {
      const bool known = contacts.last_place[i] >= 0;
      const std::int32_t row = contacts.last_place[i];
      pairs.contact[i] = known ? std::exchange(before.contact[row], -1) : -1;
      if (hulls) pairs.axis[i] = known && !before.axis.empty() ? before.axis[row] : ContactAxis{};
    }
  });
  list_where(
      crew, before.contact.size(), broad_phase.places, broad_phase.lost,
      [&](std::int32_t row) { return before.contact[row] >= 0; },
      [&](std::int32_t row) { return before.contact[row]; });
  add_followers(contacts.now, broad_phase.lost);
  crew.run_ranges(static_cast<int>(broad_phase.lost.size()), kPairsPerChunk, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) contacts.now.points[broad_phase.lost[i]] = 0;
  });
  contacts.free_rows.append(std::as_const(broad_phase.lost).span());
  for (const std::int32_t contact : broad_phase.lost) contacts.marks.mark(contact);
}

void gather_rows(const PairRows& from, const Column<std::int32_t>& places, PairRows& to, Crew& crew) {
  const bool hulls = !from.axis.empty();
  to.pair.resize_discarding(places.size());
  to.contact.resize_discarding(places.size());
  to.axis.resize_discarding(hulls ? places.size() : 0);
  crew.run_ranges(static_cast<int>(places.size()), kPairsPerChunk, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) {
      const std::int32_t row = places[i];
      to.pair[i] = from.pair[row];
      to.contact[i] = from.contact[row];
      if (hulls) to.axis[i] = from.axis[row];
    }
  });
}

std::int64_t count_contacts(const Contacts& contacts, const PairRows& rows) {
  std::int64_t count = 0;
  for (const std::int32_t first : rows.contact) {
    for_each_contact(contacts, first, [&](std::int32_t) { ++count; });
  }
  return count;
}

// Lists the rows of `resting` that cannot stay there, ascending: their shapes have left the frozen trees, or
// a call has changed them. Reads the lists of these shapes, or all rows where that is less work or the shapes
// are not known.
void list_leaving(WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  Contacts& contacts = data.contacts;
  const Column<ShapePair>& resting = contacts.resting.pair;
  Column<std::int32_t>& leaving = broad_phase.frozen_pairs;
  const auto leaves = [&](std::int32_t shape) {
    return !is_frozen_tree(broad_phase.tree_of[shape]) || broad_phase.is_dirty[shape] != 0;
  };
  if (broad_phase.all_left || kRowsPerShape * broad_phase.leavers.size() > resting.size()) {
    contacts.resting_looks += static_cast<std::int64_t>(resting.size());
    list_where(crew, resting.size(), broad_phase.places, leaving,
               [&](std::int32_t row) { return leaves(resting[row].a) || leaves(resting[row].b); });
    return;
  }
  leaving.clear();
  for (const std::int32_t shape : broad_phase.leavers) {
    if (!leaves(shape)) continue;
    for_each_resting(data, shape, [&](std::int32_t row, std::int32_t other) {
      if (shape < other || !leaves(other)) leaving.push_back(row);  // once, where both do
    });
  }
  std::sort(leaving.begin(), leaving.end());
}

// Moves the rows BroadPhase::frozen_pairs, which ascend, from `resting` back into the last list.
void take_rows(WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  Contacts& contacts = data.contacts;
  PairRows& pulled = broad_phase.pulled;
  broad_phase.by_pair.resize_discarding(broad_phase.frozen_pairs.size());
  std::copy(broad_phase.frozen_pairs.begin(), broad_phase.frozen_pairs.end(), broad_phase.by_pair.begin());
  sort_by_pair(broad_phase, contacts.resting.pair, broad_phase.by_pair, crew);
  gather_rows(contacts.resting, broad_phase.by_pair, pulled, crew);
  move_touching(data, broad_phase.by_pair);
  remove_resting(data, broad_phase.frozen_pairs);
  contacts.resting_contacts -= count_contacts(contacts, pulled);
  add_pairs(data, pulled, crew);
}

// Moves the pairs of which a shape has left its tree or was changed by a call from `resting` back into the
// last list. Returns whether there are any.
bool pull_rows(WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  if (data.contacts.resting.pair.empty()) return false;
  if (broad_phase.leavers.empty() && !broad_phase.all_left) return false;
  list_leaving(data, broad_phase, crew);
  if (broad_phase.frozen_pairs.empty()) return false;
  take_rows(data, broad_phase, crew);
  return true;
}

// Moves the pairs of two frozen shapes from `pairs` to `resting`; `last_place` follows the others.
void part_lists(WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  Contacts& contacts = data.contacts;
  const Column<ShapePair>& all = contacts.pairs.pair;
  const auto rests = [&](std::int32_t row) {
    return is_frozen_tree(broad_phase.tree_of[all[row].a]) && is_frozen_tree(broad_phase.tree_of[all[row].b]);
  };
  list_where(crew, all.size(), broad_phase.places, broad_phase.frozen_pairs, rests);
  if (broad_phase.frozen_pairs.empty()) return;
  list_where(crew, all.size(), broad_phase.places, broad_phase.moving_pairs,
             [&](std::int32_t row) { return !rests(row); });
  gather_rows(contacts.pairs, broad_phase.frozen_pairs, broad_phase.pulled, crew);
  gather_rows(contacts.pairs, broad_phase.moving_pairs, contacts.pairs_before, crew);
  swap_pairs(contacts);
  add_resting(data, broad_phase.pulled);
  contacts.resting_contacts += count_contacts(contacts, broad_phase.pulled);
  const Column<std::int32_t>& moving = broad_phase.moving_pairs;
  broad_phase.moving_last_place.resize_discarding(moving.size());
  crew.run_ranges(static_cast<int>(moving.size()), kPairsPerChunk, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) broad_phase.moving_last_place[i] = contacts.last_place[moving[i]];
  });
  contacts.last_place.swap(broad_phase.moving_last_place);
}

// Fixed shapes that a call has created or moved may overlap sleepers, and frozen trees are not joined with
// one another. So these shapes count as kinematic for the next list. Returns whether there are any.
bool lend_arrivals(WorldData& data, BroadPhase& broad_phase, TreeKind from, TreeKind to) {
  bool any = false;
  for (const std::int32_t shape : broad_phase.dirty) {
    if ((data.shapes.flags[shape] & kShapeAlive) == 0 || data.shapes.tree[shape] != from) continue;
    if (data.bodies.type[data.shapes.body[shape]] != BodyType::fixed) continue;
    data.shapes.tree[shape] = to;
    broad_phase.changed.push_back(shape);
    any = true;
  }
  return any;
}

}  // namespace

BroadPhase& broad_phase_of(WorldData& data) {
  if (data.broad_phase == nullptr) data.broad_phase = std::make_unique<BroadPhase>();
  return static_cast<BroadPhase&>(*data.broad_phase);
}

void add_pairs(WorldData& data, const PairRows& added, Crew& crew) {
  Contacts& contacts = data.contacts;
  PairRows& all = contacts.pairs_before;
  const PairRows& kept = contacts.pairs;
  const std::size_t count = kept.pair.size() + added.pair.size();
  const bool hulls = !kept.axis.empty() || !added.axis.empty();
  all.pair.resize_discarding(count);
  all.contact.resize_discarding(count);
  all.axis.resize_discarding(hulls ? count : 0);
  merge_pairs(kept.pair, added.pair, crew, [&](std::size_t place, bool is_added, std::size_t row) {
    const PairRows& from = is_added ? added : kept;
    all.pair[place] = from.pair[row];
    all.contact[place] = from.contact[row];
    if (hulls) all.axis[place] = from.axis.empty() ? ContactAxis{} : from.axis[row];
  });
  swap_pairs(contacts);
}

void pull_all_pairs(WorldData& data, Crew& crew) {
  BroadPhase& broad_phase = broad_phase_of(data);
  const std::size_t rows = data.contacts.resting.pair.size();
  if (rows == 0) return;
  list_where(crew, rows, broad_phase.places, broad_phase.frozen_pairs, [](std::int32_t) { return true; });
  take_rows(data, broad_phase, crew);
}

void pull_pairs_of(WorldData& data, std::span<const std::int32_t> bodies, Crew& crew) {
  BroadPhase& broad_phase = broad_phase_of(data);
  std::vector<std::int32_t> rows;
  for (const std::int32_t body : bodies) {
    for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape])
      for_each_resting(data, shape, [&](std::int32_t row, std::int32_t) { rows.push_back(row); });
  }
  if (rows.empty()) return;
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  broad_phase.frozen_pairs.resize_discarding(rows.size());
  std::copy(rows.begin(), rows.end(), broad_phase.frozen_pairs.begin());
  take_rows(data, broad_phase, crew);
}

void find_pairs(WorldData& data, Crew& crew) {
  BroadPhase& broad_phase = broad_phase_of(data);
  Contacts& contacts = data.contacts;
  update_dirty_bounds(data, broad_phase, data.last_dt, crew);
  const bool arrivals =
      data.bodies.asleep > 0 && lend_arrivals(data, broad_phase, TreeKind::frozen, TreeKind::kinematic);
  const bool members_changed = update_members(data, broad_phase, crew);
  contacts.list_kept = true;
  broad_phase.few_moved = false;
  contacts.resting_kept = contacts.resting.pair.size();
  if (members_changed || contacts.pairs_stale || broad_phase.bounds_left.load(std::memory_order_relaxed)) {
    broad_phase.is_dirty.resize(data.shapes.flags.size());
    for (const std::int32_t shape : broad_phase.dirty) broad_phase.is_dirty[shape] = 1;
    refit_trees(data, broad_phase, crew);
    const bool pulled = pull_rows(data, broad_phase, crew);
    contacts.resting_kept = contacts.resting.pair.size();
    // Some pairs of the last list may come to rest now.
    const bool parts = pulled || (data.bodies.asleep > 0 && !contacts.pairs.pair.empty() &&
                                  (members_changed || contacts.pairs_stale || !broad_phase.dirty.empty()));
    broad_phase.few_moved = !pulled && mark_few_moved(data, broad_phase, crew);
    const JoinScope scope = broad_phase.few_moved ? JoinScope::moved
                            : parts               ? JoinScope::all_and_carried
                                                  : JoinScope::all;
    const std::int64_t pairs = join_trees(data, broad_phase, scope, crew);
    sort_pairs(broad_phase, data.shapes.flags.size(), pairs, crew);
    if (broad_phase.few_moved) keep_other_pairs(data, broad_phase, crew);
    contacts.list_kept = match_rows(data, broad_phase, crew) && !parts;
    if (!contacts.list_kept) swap_lists(data, broad_phase, crew);
    if (parts) part_lists(data, broad_phase, crew);
    if (arrivals) lend_arrivals(data, broad_phase, TreeKind::kinematic, TreeKind::frozen);
    for (const std::int32_t shape : broad_phase.dirty) {
      broad_phase.is_dirty[shape] = 0;
      data.shapes.flags[shape] = static_cast<std::uint8_t>(data.shapes.flags[shape] & ~kShapeNew);
      data.shapes.marks.mark(shape);
    }
    broad_phase.dirty.clear();
    forget_left(broad_phase);
    broad_phase.bounds_left.store(false, std::memory_order_relaxed);
    contacts.pairs_stale = false;
  }
  data.stats.pairs = static_cast<std::int64_t>(contacts.pairs.pair.size() + contacts.resting.pair.size());
}

}  // namespace scree
