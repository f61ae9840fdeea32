// Makes lists in parallel: counts each chunk, then writes it behind the counts of the chunks before, so that
// the list is the same for every number of threads.
#pragma once

#include <core/world/column.h>
#include <parallel/crew/crew.h>

#include <cstddef>
#include <cstdint>
#include <utility>

namespace scree {

// Lists value(i) for each i in [0, count) that keep(i) holds for, in ascending order of i. Both are called on
// any thread, keep up to twice; `list` must not be what they read. `places` is scratch.
template <class Row, class Keep, class Value>
void list_where(Crew& crew, std::size_t count, Column<std::int32_t>& places, Column<Row>& list, Keep&& keep,
                Value&& value) {
  constexpr int kChunk = 4096;  // 5 to 20 microseconds
  SCREE_ASSERT(static_cast<void*>(&places) != static_cast<void*>(&list));
  places.resize_discarding((count + kChunk - 1) / kChunk);
  crew.run_ranges(static_cast<int>(count), kChunk, [&](int begin, int end, int) {
    std::int32_t kept = 0;
    for (int i = begin; i < end; ++i) kept += keep(i) ? 1 : 0;
    places[begin / kChunk] = kept;
  });
  std::int32_t total = 0;
  for (std::int32_t& place : places) {
    const std::int32_t kept = place;
    place = total;
    total += kept;
  }
  list.resize_discarding(total);
  if (total == 0) return;
  crew.run_ranges(static_cast<int>(count), kChunk, [&](int begin, int end, int) {
    const int chunk = begin / kChunk;
    std::int32_t place = places[chunk];
    if (place == (std::cmp_less(chunk + 1, places.size()) ? places[chunk + 1] : total))
      return;  // few are kept of many
    for (int i = begin; i < end; ++i) {
      if (keep(i)) list[place++] = value(i);
    }
  });
}

// Lists the indices themselves.
template <class Keep>
void list_where(Crew& crew, std::size_t count, Column<std::int32_t>& places, Column<std::int32_t>& list,
                Keep&& keep) {
  list_where(crew, count, places, list, keep, [](std::int32_t i) { return i; });
}

}  // namespace scree
