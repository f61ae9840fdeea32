// Makes lists in parallel: counts each chunk, then writes it behind the counts of the chunks before, so that
// the list is the same for every number of threads.
#pragma once

#include <core/world/column.h>
#include <parallel/crew/crew.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace scree {

// Lists value(i) for each i in [0, count) that keep(i) holds for, in ascending order of i. Both are called on
// any thread, keep once for each; `list` must not be what they read. `places` is scratch.
template <class Row, class Keep, class Value>
void list_where(Crew& crew, std::size_t count, Column<std::int32_t>& places, Column<Row>& list, Keep&& keep,
                Value&& value, const char* name = __builtin_FUNCTION()) {
  constexpr int kChunk = 4096;  // 5 to 20 microseconds
  constexpr int kBits = 32, kWords = kChunk / kBits;
  SCREE_ASSERT(static_cast<void*>(&places) != static_cast<void*>(&list));
  // By chunk: how many are kept, later where they go; then a bit for each of its indices, set if it is kept.
  places.resize_discarding((count + kChunk - 1) / kChunk * (1 + kWords));
  const auto row_of = [](int chunk) { return std::size_t{1 + kWords} * static_cast<std::size_t>(chunk); };
  crew.run_ranges(
      static_cast<int>(count), kChunk,
      [&](int begin, int end, int) {
        std::int32_t* row = &places[row_of(begin / kChunk)];
        std::int32_t kept = 0;
        for (int word = 0; begin + kBits * word < end; ++word) {
          const int first = begin + kBits * word, size = std::min(kBits, end - first);
          std::uint32_t bits = 0;
          for (int bit = 0; bit < size; ++bit) {
            const std::uint32_t kept_one = keep(first + bit) ? 1u : 0u;
            bits |= kept_one << bit;
            kept += static_cast<std::int32_t>(kept_one);
          }
          row[1 + word] = static_cast<std::int32_t>(bits);
        }
        row[0] = kept;
      },
      name);
  std::int32_t total = 0;
  for (std::size_t row = 0; row < places.size(); row += 1 + kWords) {
    const std::int32_t kept = places[row];
    places[row] = total;
    total += kept;
  }
  list.resize_discarding(total);
  if (total == 0) return;
  crew.run_ranges(
      static_cast<int>(count), kChunk,
      [&](int begin, int end, int) {
        const std::int32_t* row = &places[row_of(begin / kChunk)];
        std::int32_t place = row[0];
        for (int word = 0; begin + kBits * word < end; ++word) {
          for (auto bits = static_cast<std::uint32_t>(row[1 + word]); bits != 0; bits &= bits - 1) {
            list[place++] = value(begin + kBits * word + std::countr_zero(bits));
          }
        }
      },
      name);
}

// Lists the indices themselves.
template <class Keep>
void list_where(Crew& crew, std::size_t count, Column<std::int32_t>& places, Column<std::int32_t>& list,
                Keep&& keep, const char* name = __builtin_FUNCTION()) {
  list_where(
      crew, count, places, list, keep, [](std::int32_t i) { return i; }, name);
}

}  // namespace scree
