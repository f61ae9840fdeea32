// Sorting constraints by color and block variant: a counting sort in parts of fixed size, so that within a
// color they keep the order of their list and nothing depends on threads. Used by pack_blocks.cpp only.
#pragma once

#include <parallel/constraints.h>
#include <parallel/crew.h>

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace scree {

inline constexpr int kSortRows = 4096;  // of a list that one task counts and scatters

// Places in the order in which they are solved: the overflow, each hub color with the hub as A and as B, the
// dynamic colors, the static ones.
inline constexpr int kFirstHubPlace = 1;
inline constexpr int kFirstDynamicPlace = kFirstHubPlace + 2 * kHubColorLimit;
inline constexpr int kFirstStaticPlace = kFirstDynamicPlace + kColorLimit;
inline constexpr int kColorPlaces = kFirstStaticPlace + kColorLimit;

inline bool is_hub_place(int place) { return place >= kFirstHubPlace && place < kFirstDynamicPlace; }

inline int place_of(const Edge& edge) {
  // Whatever found no color shares the overflow's place: the variant tells static constraints apart.
  if (edge.color == kOverflowColor) return 0;
  switch (edge.kind) {
    case EdgeKind::pushed_b:
      return kFirstStaticPlace + edge.color;
    case EdgeKind::hub_a:
      return kFirstHubPlace + 2 * edge.color;
    case EdgeKind::hub_b:
      return kFirstHubPlace + 2 * edge.color + 1;
    default:
      return kFirstDynamicPlace + edge.color;
  }
}

// Turns counts by part and key into places: rows of one key lie together, parts in their order.
inline void place_keys(Column<std::int32_t>& histogram, int parts, int lanes, KeyTable& table) {
  const int keys = kColorPlaces * table.kinds;
  table.totals.resize_discarding(static_cast<std::size_t>(keys));
  table.first_lane.resize_discarding(static_cast<std::size_t>(keys) + 1);
  std::int32_t* const totals = table.totals.data();
  std::fill(totals, totals + keys, 0);
  for (int part = 0; part < parts; ++part) {
    std::int32_t* const counts = histogram.data() + static_cast<std::ptrdiff_t>(part) * keys;
    for (int key = 0; key < keys; ++key) {
      const std::int32_t before = totals[key];
      totals[key] += counts[key];
      counts[key] = before;
    }
  }
  // A hub's run begins with a block of its own. Two hubs may share a constraint, in the overflow only.
  const std::int32_t hub_ends = std::accumulate(totals, totals + kFirstDynamicPlace * table.kinds, 0) +
                                std::accumulate(totals, totals + table.kinds, 0);
  const std::int32_t most_hubs = hub_ends / (kHubDegree + 1);
  std::int32_t lane = 0;
  for (int key = 0; key < keys; ++key) {
    const int place = key / table.kinds;
    table.first_lane[static_cast<std::size_t>(key)] = lane;
    std::int32_t padded = (totals[key] + lanes - 1) / lanes * lanes;
    if (place == 0) padded = totals[key] * lanes;  // solved one by one: a block each
    if (is_hub_place(place)) padded += std::min(totals[key], most_hubs) * lanes;
    lane += padded;
  }
  table.first_lane[static_cast<std::size_t>(keys)] = lane;
}

// Edges [first, first + list.size()) -> `rows`: the entries of `list` in the order of lanes. `kind_of` gives
// an edge's kind, less than table.kinds.
template <class KindOf>
void sort_edges(Constraints& constraints, std::size_t first, const Column<std::int32_t>& list, int lanes,
                KeyTable& table, Column<std::int32_t>& rows, Crew& crew, KindOf&& kind_of) {
  const int count = static_cast<int>(list.size());
  const int parts = (count + kSortRows - 1) / kSortRows;
  const auto keys = static_cast<std::size_t>(kColorPlaces * table.kinds);
  constraints.keys.resize_discarding(list.size());
  constraints.histogram.resize_discarding(static_cast<std::size_t>(parts) * keys);
  crew.run_ranges(count, kSortRows, [&](int begin, int end, int) {
    std::int32_t* counts = constraints.histogram.data() + static_cast<std::size_t>(begin / kSortRows) * keys;
    std::fill(counts, counts + keys, 0);
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const Edge& edge = constraints.edges[first + i];
      const int key = place_of(edge) * table.kinds + kind_of(edge);
      constraints.keys[i] = static_cast<std::uint16_t>(key);
      ++counts[key];
    }
  });
  place_keys(constraints.histogram, parts, lanes, table);
  rows.resize_discarding(static_cast<std::size_t>(table.first_lane.back()));
  crew.run_ranges(count, kSortRows, [&](int begin, int end, int) {
    std::int32_t* places = constraints.histogram.data() + static_cast<std::size_t>(begin / kSortRows) * keys;
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const int key = constraints.keys[i];
      const int place = places[key]++;
      const int lane =
          table.first_lane[static_cast<std::size_t>(key)] + (key < table.kinds ? place * lanes : place);
      rows[static_cast<std::size_t>(lane)] = list[i];
    }
  });
}

}  // namespace scree
