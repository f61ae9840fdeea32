// Merges two sorted lists of pairs that have no pair in common. Splits the work along the longer list, so
// that the result depends on the lists alone.
#pragma once

#include <core/world/pair_key.h>
#include <parallel/crew/crew.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace scree {

// Calls put(place, is_of_second, row) once for each pair of both lists, on any thread: `place` is its place
// in the merged list, `row` the one in its own list.
template <class Put>
void merge_pairs(const Column<ShapePair>& first, const Column<ShapePair>& second, Crew& crew, Put&& put) {
  constexpr std::size_t kChunk = 4096;
  SCREE_ASSERT(std::is_sorted(first.begin(), first.end(), comes_before));
  SCREE_ASSERT(std::is_sorted(second.begin(), second.end(), comes_before));
  const bool cuts_first = first.size() > second.size();
  const Column<ShapePair>&longer = cuts_first ? first : second, &other = cuts_first ? second : first;
  // The number of pairs of the other list that come before one of the longer list.
  const auto place_of = [&](std::size_t row) {
    if (row == longer.size()) return other.size();
    if (row == 0) return std::size_t{0};
    return static_cast<std::size_t>(std::lower_bound(other.begin(), other.end(), longer[row], comes_before) -
                                    other.begin());
  };
  crew.run(static_cast<int>((longer.size() + kChunk - 1) / kChunk), [&](int chunk, int) {
    const std::size_t begin = static_cast<std::size_t>(chunk) * kChunk;
    const std::size_t end = std::min(begin + kChunk, longer.size());
    std::size_t a = cuts_first ? begin : place_of(begin), b = cuts_first ? place_of(begin) : begin;
    const std::size_t a_end = cuts_first ? end : place_of(end), b_end = cuts_first ? place_of(end) : end;
    while (a < a_end || b < b_end) {
      const bool is_of_second = a == a_end || (b < b_end && comes_before(second[b], first[a]));
      put(a + b, is_of_second, is_of_second ? b : a);
      ++(is_of_second ? b : a);
    }
  });
}

}  // namespace scree
