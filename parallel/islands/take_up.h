// Updates an ascending list of what takes part by a list of what has changed. Serial; the cost depends on the
// lengths of both.
#pragma once

#include <core/world/column.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace scree {

// Removes the changed entries from an ascending list, and inserts those of them that `keep` holds for.
// `changed` ascends, too.
template <class Keep>
void take_up(Column<std::int32_t>& list, const Column<std::int32_t>& changed,
             const Column<std::uint8_t>& is_changed, Column<std::int32_t>& scratch, Keep&& keep) {
  SCREE_ASSERT(std::adjacent_find(list.begin(), list.end(), std::greater_equal<>()) == list.end());
  SCREE_ASSERT(std::adjacent_find(changed.begin(), changed.end(), std::greater_equal<>()) == changed.end());
  scratch.resize_discarding(list.size() + changed.size());
  std::int32_t* to = scratch.data();
  const std::int32_t* next = changed.begin();
  for (const std::int32_t row : list) {
    for (; next != changed.end() && *next < row; ++next) {
      if (keep(*next)) *to++ = *next;
    }
    if (is_changed[row] == 0) *to++ = row;
  }
  for (; next != changed.end(); ++next) {
    if (keep(*next)) *to++ = *next;
  }
  scratch.resize(to - scratch.data());
  list.swap(scratch);
}

template <class Store>
void forget_changes(Store& store) {
  for (const std::int32_t row : store.changed) store.is_changed[row] = 0;
  store.changed.clear();
}

}  // namespace scree
