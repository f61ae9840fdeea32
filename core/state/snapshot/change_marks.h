// What has changed in the stores of a world since it was last saved, page by page: saving copies these pages
// only (snapshot_sheets.h).
//
// Whoever writes to a state column marks the row. What moves is not marked in each step: saving looks at the
// lists of what moves, and who leaves one of these is marked then. So steps pay nothing, but whoever takes
// rows out of Bodies::awake and kinematic, Shapes::moving, Joints::active or Contacts::touching must have
// marked them. No row is marked by two threads at a time.
#pragma once

#include <core/world/column.h>

#include <cstddef>
#include <cstdint>
#include <memory>

namespace scree {

struct SavedPages;

inline constexpr std::size_t kPageRows = 64;

constexpr std::size_t pages_of(std::size_t rows) { return (rows + kPageRows - 1) / kPageRows; }

enum PageMark : std::uint8_t {
  kPageMoved = 1,    // in the columns that steps write, see snapshot_sheets.cpp
  kPageChanged = 2,  // in any column
};

// Of one store. Pages behind the last one have come since: they count as changed. A world that has never been
// saved has none.
struct PageMarks {
  Column<std::uint8_t> pages;  // PageMark

  void mark(std::int32_t row, std::uint8_t how = kPageMoved | kPageChanged) {
    SCREE_ASSERT(row >= 0);
    const std::size_t page = static_cast<std::size_t>(row) / kPageRows;
    if (page < pages.size()) pages[page] = static_cast<std::uint8_t>(pages[page] | how);
  }
  void forget(std::size_t rows) {
    pages.clear();
    pages.resize(pages_of(rows));  // to zero
  }
};

// Of a list that grows and shrinks at its end only.
struct ListMark {
  std::size_t kept = 0;  // entries that have stayed

  void cut(std::size_t size) {
    if (size < kept) kept = size;
  }
};

// What the marks of a world are about.
struct LastSave {
  std::shared_ptr<SavedPages> pages;
  std::uint64_t id = 0;  // that the pages had: others can not be relied on
};

}  // namespace scree
