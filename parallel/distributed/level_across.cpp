// Levels of the constraints without a color, where ranks share a world; see border.h.
//
// There are few: they join two bodies of many constraints each. So each rank tells all others of its own, and
// all find the same levels, in the order in which a single process lists them (level_overflow.h).
#include <core/world/pair_key.h>
#include <parallel/constraints/level_overflow.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/messages.h>

#include <algorithm>
#include <compare>
#include <unordered_map>
#include <utility>
#include <vector>

namespace scree {

namespace {

// Where a constraint comes in the order of a single process: kind by kind, and within a kind as in its list.
struct Place {
  std::int32_t kind;
  std::int32_t number;  // of contacts that a pair has
  std::uint64_t row;    // key of the pair, or the joint's row
};

struct Leveled {
  Place place;
  std::int32_t body_a, body_b, level;
  std::int32_t unused = 0;
};

std::strong_ordering compare(const Place& one, const Place& other) {
  if (const auto kinds = one.kind <=> other.kind; kinds != 0) return kinds;
  if (const auto rows = one.row <=> other.row; rows != 0) return rows;
  return one.number <=> other.number;
}

Place place_of_edge(const WorldData& data, const Constraints& constraints, std::int32_t edge) {
  const auto contacts = static_cast<std::int32_t>(data.contacts.active.size());
  if (edge >= contacts) {
    const std::int32_t joint = data.joints.active[edge - contacts];
    return {constraints.edges[edge].info, 0, static_cast<std::uint64_t>(joint)};
  }
  const std::int32_t contact = data.contacts.active[edge];
  std::int32_t number = 0;
  for (std::int32_t before = edge; before > 0; ++number) {
    const ShapePair pair = data.contacts.now.pair[data.contacts.active[--before]];
    if (key_of(pair) != key_of(data.contacts.now.pair[contact])) break;
  }
  return {contact_kind(constraints.edges[edge]), number, key_of(data.contacts.now.pair[contact])};
}

void find_levels_of_all(std::vector<Leveled>& all) {
  std::sort(all.begin(), all.end(),
            [](const Leveled& one, const Leveled& other) { return compare(one.place, other.place) < 0; });
  std::unordered_map<std::int32_t, std::int32_t> next;  // by body: the level of its next constraint
  for (Leveled& one : all) {
    std::int32_t &a = next[one.body_a], &b = next[one.body_b];
    one.level = std::max(a, b);
    a = b = one.level + 1;
  }
}

}  // namespace

void level_across(const WorldData& data, Constraints& constraints, Border& border,
                  Column<std::int32_t>& sizes) {
  std::vector<Leveled> all;
  for (const std::int32_t edge : constraints.overflow_edges) {
    const Edge& of = constraints.edges[edge];
    if (border.owns(of.body_a))
      all.push_back({place_of_edge(data, constraints, edge), of.body_a, of.body_b, 0});
  }
  all = gather_lists(border.transport, all, [](const Leveled&) { return true; });
  find_levels_of_all(all);
  for (const Leveled& one : all) {
    if (std::cmp_equal(one.level, sizes.size())) sizes.push_back(0);
    ++sizes[one.level];
  }
  constraints.overflow_levels.resize_discarding(constraints.overflow_edges.size());
  for (std::size_t i = 0; i < constraints.overflow_edges.size(); ++i) {
    const Place place = place_of_edge(data, constraints, constraints.overflow_edges[i]);
    const auto found =
        std::lower_bound(all.begin(), all.end(), place,
                         [](const Leveled& one, const Place& at) { return compare(one.place, at) < 0; });
    if (found == all.end() || compare(found->place, place) != 0) {
      throw Error("step: rank " + std::to_string(border.here) +
                  " knows of a constraint of which its other rank has not told: their worlds differ");
    }
    constraints.overflow_levels[i] = found->level;
    border.levels.push_back({constraints.overflow_edges[i], found->level});
  }
  std::sort(border.levels.begin(), border.levels.end());
}

}  // namespace scree
