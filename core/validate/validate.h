// Validation: whether the stores of a world agree with each other, asked by the step before and between its
// stages and by restore, in builds with assertions only (see core/plain/assert.h). What is wrong aborts where
// it is found, naming the condition. parallel/validate/validate_stages.h has what only stages know of.
//
// A world of many rows is validated in every k-th step, so that a step looks at kValidatedRows rows each time
// on average: what large worlds get wrong, small ones get wrong, too.
#pragma once

#include <core/world/world_data.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace scree {

#ifdef SCREE_ASSERTIONS

inline constexpr std::size_t kValidatedRows = 16384;

// Whether this step is one in which a world of that size is validated.
bool is_validated(const WorldData& data);

// Lists of shapes and joints hold what names their body, both ways; lists of free slots, of what is dirty or
// changed name exactly the rows that are; counts are right. Holds between the steps, after any call.
void validate_stores(const WorldData& data);
// The pairs that move ascend, no row of contacts has two pairs, free rows are the others, pairs at rest stand
// in the lists of their shapes. Holds outside find_pairs and collide.
void validate_pairs(const WorldData& data);

// So many zeros, in memory that the thread keeps: a step in the steady state allocates nothing. Until the
// next call.
std::vector<std::uint8_t>& validation_marks(std::size_t count);

// Each entry of the list names another row that `belongs` holds for, and all of these are named.
template <class Belongs>
bool lists_exactly(const Column<std::int32_t>& list, std::size_t rows, Belongs&& belongs) {
  std::vector<std::uint8_t>& is_listed = validation_marks(rows);
  for (const std::int32_t row : list) {
    if (row < 0 || std::cmp_greater_equal(row, rows) || is_listed[static_cast<std::size_t>(row)] != 0)
      return false;
    is_listed[static_cast<std::size_t>(row)] = 1;
  }
  for (std::size_t row = 0; row < rows; ++row) {
    if (belongs(row) != (is_listed[row] != 0)) return false;
  }
  return true;
}

// No row stands before one that is not greater.
template <class List, class Before>
bool ascends(const List& list, Before&& before) {
  for (std::size_t i = 1; i < list.size(); ++i) {
    if (!before(list[i - 1], list[i])) return false;
  }
  return true;
}
template <class List>
bool ascends(const List& list) {
  return ascends(list, std::less<>());
}

#else

inline void validate_stores(const WorldData&) {}
inline void validate_pairs(const WorldData&) {}

#endif

}  // namespace scree
