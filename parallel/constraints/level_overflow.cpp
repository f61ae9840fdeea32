// Assigns the levels of the overflow; see level_overflow.h. Runs in pack_blocks, between counting and placing
// the keys.
#include <parallel/constraints/level_overflow.h>
#include <parallel/constraints/sort_constraints.h>
#include <parallel/distributed/border.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace scree {

namespace {

// Lists the edges that overflow, kind by kind in the order of their list.
void list_overflow(Constraints& constraints, std::int32_t first, std::size_t count, const KeyTable& table,
                   Crew& crew) {
  Column<std::int32_t>& begins = constraints.overflow_begins;
  begins.resize_discarding(table.kinds);
  std::exclusive_scan(table.totals.begin(), table.totals.begin() + table.kinds, begins.begin(), 0);
  constraints.overflow_edges.resize_discarding(table.in_place[0]);
  const auto keys = static_cast<std::size_t>(kColorPlaces * table.kinds);
  crew.run_ranges(static_cast<int>(count), kSortRows, [&](int begin, int end, int) {
    std::int32_t places[kMostKinds];
    const std::int32_t* const before =
        table.counts.data() + static_cast<std::size_t>(begin / kSortRows) * keys;
    for (int kind = 0; kind < table.kinds; ++kind) places[kind] = begins[kind] + before[kind];
    const int last = first + end;
    for (int i = first + begin; i < last; ++i) {
      const int key = constraints.keys[i];
      if (key >= table.kinds) continue;
      constraints.overflow_edges[places[key]++] = i;
    }
  });
}

// Writes the level of each, and how many constraints each level has.
void find_levels(Constraints& constraints, Column<std::int32_t>& sizes) {
  const auto of_body = [&](std::int32_t body) -> std::int32_t& {
    return constraints.body_colors[body].number;
  };
  constraints.overflow_levels.resize_discarding(constraints.overflow_edges.size());
  for (std::size_t i = 0; i < constraints.overflow_edges.size(); ++i) {
    const Edge& edge = constraints.edges[constraints.overflow_edges[i]];
    std::int32_t &a = of_body(edge.body_a), &b = of_body(edge.body_b);
    a = b = std::max(a, b) + 1;
    constraints.overflow_levels[i] = a;
    if (std::cmp_equal(a, sizes.size())) sizes.push_back(0);
    ++sizes[a];
  }
  for (const std::int32_t i : constraints.overflow_edges) {
    const Edge& edge = constraints.edges[i];
    of_body(edge.body_a) = of_body(edge.body_b) = -1;
  }
}

// Sorts by level; within a level the order stays.
void sort_by_level(const Constraints& constraints, std::size_t levels, KeyTable& table) {
  Column<std::int32_t>& ends = table.level_ends;  // while it sorts: where the level's next edge goes
  ends.resize_discarding(levels);
  std::fill(ends.begin(), ends.end(), 0);
  for (const std::int32_t level : constraints.overflow_levels) ++ends[level];
  std::exclusive_scan(ends.begin(), ends.end(), ends.begin(), 0);
  table.overflow.resize_discarding(constraints.overflow_edges.size());
  for (std::size_t i = 0; i < constraints.overflow_edges.size(); ++i) {
    std::int32_t& end = ends[constraints.overflow_levels[i]];
    table.overflow[end++] = constraints.overflow_edges[i];
  }
}

}  // namespace

void level_overflow(const WorldData& data, Constraints& constraints, std::int32_t first, std::size_t count,
                    bool is_empty, int lanes, KeyTable& table, Crew& crew) {
  table.overflow.clear();
  table.level_ends.clear();
  table.level_sizes.clear();
  table.overflow_lanes = 0;
  Border* const border = border_of(data);
  if (border != nullptr ? is_empty : table.in_place[0] == 0) return;
  list_overflow(constraints, first, count, table, crew);
  if (border != nullptr) {
    level_across(data, constraints, *border, table.level_sizes);
  } else {
    find_levels(constraints, table.level_sizes);
  }
  sort_by_level(constraints, table.level_sizes.size(), table);
  for (std::size_t level = 0; level < table.level_sizes.size(); ++level) {
    for_each_overflow_run(constraints, table, level, [&](std::int32_t begin, std::int32_t end, int) {
      table.overflow_lanes += (end - begin + lanes - 1) / lanes * lanes;
    });
  }
}

}  // namespace scree
