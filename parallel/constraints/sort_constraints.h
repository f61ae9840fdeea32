// Sorts constraints by color and block variant: a counting sort in parts of fixed size, which keeps the order
// of the list within a color and does not depend on threads. For pack_blocks.cpp; the places for
// distributed/, too.
#pragma once

#include <parallel/constraints/constraints.h>
#include <parallel/crew/crew.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>

namespace scree {

inline constexpr int kSortRows = 4096;  // of a list that one task counts and scatters
inline constexpr int kMostKinds = kJointBlockKinds;

// Places, in the order of solving: the overflow, each hub color with the hub as A and as B, the dynamic
// colors, the static ones, and static constraints without a color.
inline constexpr int kFirstHubPlace = 1;
inline constexpr int kFirstDynamicPlace = kFirstHubPlace + 2 * kHubColorLimit;
inline constexpr int kFirstStaticPlace = kFirstDynamicPlace + kColorLimit;
inline constexpr int kStaticHubPlace = kFirstStaticPlace + kColorLimit;
inline constexpr int kColorPlaces = kStaticHubPlace + 1;

inline bool is_hub_place(int place) {
  return (place >= kFirstHubPlace && place < kFirstDynamicPlace) || place == kStaticHubPlace;
}

inline int place_of(const Edge& edge) {
  if (edge.color == kOverflowColor) return 0;
  SCREE_ASSERT(edge.kind != EdgeKind::two_hubs);
  switch (edge.kind) {
    case EdgeKind::pushed_b:
      return edge.color == kStaticHubColor ? kStaticHubPlace : kFirstStaticPlace + edge.color;
    case EdgeKind::hub_a:
      return kFirstHubPlace + 2 * edge.color;
    case EdgeKind::hub_b:
      return kFirstHubPlace + 2 * edge.color + 1;
    default:
      return kFirstDynamicPlace + edge.color;
  }
}

inline constexpr int kContactKinds = simd::kPointBuckets * 2;
inline int bucket_of(std::uint32_t points) { return points == 1 ? 0 : points == 2 ? 1 : 2; }
inline int contact_kind(const Edge& edge) {
  return bucket_of(edge.info & kManifoldPointMask) * 2 + ((edge.info & kManifoldRich) != 0 ? 1 : 0);
}

// Constraints of a hub are solved in groups, but for those without a color.
inline bool is_grouped(const Edge& edge) {
  return (edge.kind == EdgeKind::hub_a || edge.kind == EdgeKind::hub_b) && edge.color != kOverflowColor;
}

// The key of an edge that another rank computes, see parallel/distributed/border.h.
inline constexpr std::uint16_t kNotHere = std::numeric_limits<std::uint16_t>::max();

// Edges of `list`, which are [first, first + list.size()), -> their keys and how many there are of each.
// `kind_of` gives an edge's kind, less than table.kinds, and `is_here`
// whether it is solved here. Returns the sum of `info & mask` of the edges.
template <class KindOf, class IsHere>
std::int64_t count_keys(Constraints& constraints, std::int32_t first, const Column<std::int32_t>& list,
                        std::uint32_t mask, KeyTable& table, Crew& crew, KindOf&& kind_of, IsHere&& is_here) {
  const int count = static_cast<int>(list.size()), parts = (count + kSortRows - 1) / kSortRows;
  const int kinds = table.kinds;  // a copy: the compiler cannot know that counts do not change it
  const auto keys = static_cast<std::size_t>(kColorPlaces * kinds);
  SCREE_ASSERT(keys <= kNotHere);
  table.counts.resize_discarding(static_cast<std::size_t>(parts) * keys);
  table.sums.resize_discarding(parts);
  crew.run_ranges(count, kSortRows, [&](int begin, int end, int) {
    std::int32_t* counts = table.counts.data() + static_cast<std::size_t>(begin / kSortRows) * keys;
    std::fill(counts, counts + keys, 0);
    std::uint32_t sum = 0;
    const int last = first + end;  // a copy, as well
    for (int i = first + begin; i < last; ++i) {
      const Edge& edge = constraints.edges[i];
      if (!is_here(edge)) {
        constraints.keys[i] = kNotHere;
        continue;
      }
      const int key = place_of(edge) * kinds + kind_of(edge);
      constraints.keys[i] = static_cast<std::uint16_t>(key);
      ++counts[key];
      sum += edge.info & mask;
    }
    table.sums[begin / kSortRows] = static_cast<std::int32_t>(sum);
  });
  table.totals.resize_discarding(keys);
  std::int32_t* const totals = table.totals.data();
  std::fill(totals, totals + keys, 0);
  for (int part = 0; part < parts; ++part) {
    std::int32_t* const counts = table.counts.data() + static_cast<std::size_t>(part) * keys;
    for (std::size_t key = 0; key < keys; ++key) {
      const std::int32_t before = totals[key];
      totals[key] += counts[key];
      counts[key] = before;
    }
  }
  table.in_place.resize_discarding(kColorPlaces);
  for (int place = 0; place < kColorPlaces; ++place) {
    const std::int32_t* const of_place = totals + place * table.kinds;
    table.in_place[place] = std::accumulate(of_place, of_place + table.kinds, 0);
  }
  return std::accumulate(table.sums.begin(), table.sums.end(), std::int64_t{0});
}

// An upper bound for the number of hubs, from the constraints in hub places. Only in the overflow may a
// constraint have two hubs.
inline std::int32_t most_hubs(const KeyTable& contacts, const KeyTable& joints) {
  std::int32_t ends = 0;
  for (const KeyTable* table : {&contacts, &joints}) {
    const std::int32_t* const rows = table->in_place.data();
    ends = std::accumulate(rows, rows + kFirstDynamicPlace, ends) + rows[0];
  }
  return ends / (kHubDegree + 1);
}

// Calls work(begin, end, kind) for the runs of one kind in a level of the overflow.
template <class Work>
void for_each_overflow_run(const Constraints& constraints, const KeyTable& table, std::size_t level,
                           Work&& work) {
  const auto kind_at = [&](std::int32_t place) {  // the keys of place 0 are the kinds
    const std::int32_t edge = table.overflow[place];
    return int{constraints.keys[edge]};
  };
  std::int32_t begin = level == 0 ? 0 : table.level_ends[level - 1];
  const std::int32_t level_end = table.level_ends[level];
  while (begin < level_end) {
    const int kind = kind_at(begin);
    std::int32_t end = begin + 1;
    while (end < level_end && kind_at(end) == kind) ++end;
    work(begin, end, kind);
    begin = end;
  }
}

// Sets where the lanes of each key begin; the lanes of the overflow come first. In a hub place each of at
// most `hubs` hubs, which may have any number of rows there, begins with a block of its own.
inline void place_keys(int lanes, std::int32_t hubs, KeyTable& table) {
  const int keys = kColorPlaces * table.kinds;
  table.first_lane.resize_discarding(keys + 1);
  std::int32_t lane = table.overflow_lanes;
  for (int place = 1; place < kColorPlaces; ++place) {
    if (table.in_place[place] == 0) continue;
    for (int kind = 0; kind < table.kinds; ++kind) {
      const int key = place * table.kinds + kind;
      const std::int32_t total = table.totals[key];
      table.first_lane[key] = lane;
      lane += (total + lanes - 1) / lanes * lanes;
      if (place == kStaticHubPlace) {
        lane += total * lanes;
      } else if (is_hub_place(place)) {
        lane += std::min(total, hubs) * lanes;
      }
    }
  }
  table.first_lane[keys] = lane;
}

// `rows`: the entries of `list` in the order of lanes, after count_keys() and place_keys(). Those of the
// overflow are left out.
inline void scatter_rows(const Constraints& constraints, std::int32_t first, const Column<std::int32_t>& list,
                         KeyTable& table, Column<std::int32_t>& rows, Crew& crew) {
  const int kinds = table.kinds;
  const auto keys = static_cast<std::size_t>(kColorPlaces * kinds);
  rows.resize_discarding(table.first_lane.back());
  crew.run_ranges(static_cast<int>(list.size()), kSortRows, [&](int begin, int end, int) {
    std::int32_t* places = table.counts.data() + static_cast<std::size_t>(begin / kSortRows) * keys;
    const std::int32_t* first_lane = table.first_lane.data();
    std::int32_t* to = rows.data();
    const std::uint16_t* const key_at = constraints.keys.data() + first;
    for (int i = begin; i < end; ++i) {
      const int key = key_at[i];
      if (key >= kinds && key != kNotHere) to[first_lane[key] + places[key]++] = list[i];
    }
  });
}

}  // namespace scree
