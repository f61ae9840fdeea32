// Two sorted lists of pairs that have no pair in common, gone over as one. Cut along the second list, so that
// what is put where depends on the lists alone.
#pragma once

#include <core/pair_key.h>
#include <parallel/crew.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace scree {

// Calls put(place, is_of_second, row) once for each pair of both lists: `place` is the pair's in the list of
// all, `row` the one in its own. On any thread.
template <class Put>
void merge_pairs(const Column<ShapePair>& first, const Column<ShapePair>& second, Crew& crew, Put&& put) {
  constexpr std::size_t kChunk = 4096;
  const std::size_t chunks = std::max<std::size_t>((second.size() + kChunk - 1) / kChunk, 1);
  const auto place_of = [&](std::size_t row_of_second) {
    if (row_of_second == 0) return std::size_t{0};
    if (row_of_second == second.size()) return first.size();
    return static_cast<std::size_t>(
        std::lower_bound(first.begin(), first.end(), second[row_of_second], comes_before) - first.begin());
  };
  crew.run(static_cast<int>(chunks), [&](int chunk, int) {
    std::size_t b = static_cast<std::size_t>(chunk) * kChunk;
    const std::size_t b_end = std::min(b + kChunk, second.size());
    std::size_t a = place_of(b);
    const std::size_t a_end = place_of(b_end);
    while (a < a_end || b < b_end) {
      const bool is_of_second = a == a_end || (b < b_end && comes_before(second[b], first[a]));
      put(a + b, is_of_second, is_of_second ? b : a);
      ++(is_of_second ? b : a);
    }
  });
}

}  // namespace scree
