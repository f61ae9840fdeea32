// See rows_in_order.h.
#include <core/state/world_difference.h>
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/crew/crew.h>
#include <parallel/distributed/local_columns.h>
#include <parallel/distributed/world_parts.h>
#include <parallel/recording/rows_in_order.h>
#include <scree/snapshot.h>

#include <algorithm>
#include <utility>

namespace scree {

namespace {

template <class Row>
void take_in_order(const Column<std::int32_t>& order, Column<Row>& rows) {
  if (rows.empty()) return;
  Column<Row> taken;
  taken.resize(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) taken[i] = rows[order[i]];
  rows.swap(taken);
}

// Free rows hold what a body, shape or joint had when it went, which only its owner knew.
template <class Store, class Flag>
void clear_free_rows(Store& store, Flag alive) {
  for (std::size_t row = 0; row < store.flags.size(); ++row) {
    if ((store.flags[row] & alive) == 0)
      zero_row(store, static_cast<std::int32_t>(row), LocalColumns::travelling);
  }
}

void clear_free_rows(Joints& joints) {
  for (std::size_t row = 0; row < joints.flags.size(); ++row) {
    if ((joints.flags[row] & kJointAlive) != 0) continue;
    joints.impulses[row] = {};
    joints.color[row] = kNoColor;
  }
}

// All pairs move, and contacts come in their order, without free rows. It is for comparing columns alone:
// what is derived of them is stale then.
void put_rows_in_order(WorldData& data, Crew& crew) {
  pull_all_pairs(data, crew);
  Contacts& contacts = data.contacts;
  Column<std::int32_t> order;
  for (std::size_t row = 0; row < contacts.pairs.pair.size(); ++row) {
    std::int32_t& first = contacts.pairs.contact[row];
    const auto begin = static_cast<std::int32_t>(order.size());
    for_each_contact(contacts, first, [&](std::int32_t contact) { order.push_back(contact); });
    if (first >= 0) first = begin;
  }
  ContactRows& now = contacts.now;
  take_in_order(order, now.points);
  take_in_order(order, now.next);
  take_in_order(order, now.manifold);
  take_in_order(order, now.features);
  take_in_order(order, now.anchor);
  take_in_order(order, now.surface);
  take_in_order(order, now.color);
  take_in_order(order, contacts.forces);
  for (std::size_t row = 0; row < now.next.size(); ++row) {
    if (now.next[row] != 0) now.next[row] = static_cast<std::int32_t>(row) + 2;
  }
  contacts.free_rows.clear();
  data.contacts.pairs_stale = true;  // the next step lists them anew, as it does after any of this
  std::sort(data.shapes.dirty.begin(), data.shapes.dirty.end());
  std::sort(data.events.woken.begin(), data.events.woken.end(),
            [](const SlotName& one, const SlotName& other) {
              return std::pair(one.index, one.generation) < std::pair(other.index, other.generation);
            });
}

std::string first_difference_of_own(World& left, World& right, Crew& crew) {
  for (World* const world : {&left, &right}) {
    put_rows_in_order(internals(*world), crew);
    clear_free_rows(internals(*world).bodies, kBodyAlive);
    clear_free_rows(internals(*world).shapes, kShapeAlive);
    clear_free_rows(internals(*world).joints);
  }
  return first_difference_of_copies(left, right);
}

}  // namespace

std::string first_difference_but_for_order(const World& expected, const World& actual) {
  World left = clone(expected), right = clone(actual);  // whose free rows are empty
  Workers workers(1);
  Crew crew(workers);
  return first_difference_of_own(left, right, crew);
}

std::string first_difference_of_parts(World& expected, World& actual, Crew& crew) {
  World left = copy_part(expected, crew), right = copy_part(actual, crew);
  return first_difference_of_own(left, right, crew);
}

}  // namespace scree
