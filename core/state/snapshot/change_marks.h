// What has changed in the stores of a world since it was last saved, page by page: saving copies these pages
// only (snapshot_sheets.h). The sheets are listed here, each with what tells which of its pages have changed.
//
// Code that writes to a state column marks the row. What moves is not marked in each step: saving looks at
// the lists of what moves, and what leaves one of these is marked then. So steps pay nothing, but code that
// takes rows out of Bodies::awake and kinematic, Shapes::moving, Joints::active or Contacts::active must
// have marked them. No row is marked by two threads at a time.
#pragma once

#include <core/world/column.h>

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

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
struct PageMarks : Column<std::uint8_t> {  // PageMark by page
  void mark(std::integral auto row, std::uint8_t how = kPageMoved | kPageChanged) {
    SCREE_ASSERT(std::in_range<std::size_t>(row));
    const std::size_t page = static_cast<std::size_t>(row) / kPageRows;
    if (page < size()) (*this)[page] = static_cast<std::uint8_t>((*this)[page] | how);
  }
  // Marks for so many rows at least; new ones are zero.
  void cover(std::size_t rows) {
    if (pages_of(rows) > size()) resize(pages_of(rows));
  }
};

// Of a list that grows and shrinks at its end only.
struct ListMark {
  std::size_t kept = 0;  // entries that have stayed

  void cut(std::size_t size) {
    if (size < kept) kept = size;
  }
};

// clang-format off
// The sheets of a snapshot: columns that change together. Members of the state table name theirs.
//   MARKED    by marks of the pages, with one of these bits
//   LISTED    by the mark of a list that grows and shrinks at its end only
//   COMPARED  by comparing all pages
#define SCREE_SHEETS(MARKED, LISTED, COMPARED)                                                     \
  MARKED  (bodies_moving,   bodies.marks,            kPageMoved | kPageChanged)                    \
  MARKED  (bodies,          bodies.marks,            kPageChanged)                                 \
  LISTED  (free_bodies,     bodies.free_mark)                                                                   \
  MARKED  (shapes_moving,   shapes.marks,            kPageMoved | kPageChanged)                    \
  MARKED  (shapes,          shapes.marks,            kPageChanged)                                 \
  LISTED  (free_shapes,     shapes.free_mark)                                                                   \
  COMPARED(dirty_shapes)                                                                           \
  COMPARED(hulls)                                                                                  \
  COMPARED(free_hulls)                                                                             \
  COMPARED(meshes)                                                                                 \
  COMPARED(free_meshes)                                                                            \
  COMPARED(pairs)                                                                                  \
  COMPARED(pair_axes)             /* of which there may be none */                                 \
  MARKED  (resting,         contacts.resting_marks,  kPageMoved | kPageChanged)                    \
  MARKED  (resting_axes,    contacts.resting_marks,  kPageMoved | kPageChanged)                    \
  MARKED  (contacts_moving, contacts.marks,          kPageMoved | kPageChanged)                    \
  MARKED  (contacts,        contacts.marks,          kPageChanged)                                 \
  LISTED  (free_contacts,   contacts.free_mark)                                                                 \
  COMPARED(contact_forces)                                                                         \
  MARKED  (joints_moving,   joints.marks,            kPageMoved | kPageChanged)                    \
  MARKED  (joints,          joints.marks,            kPageChanged)                                 \
  LISTED  (free_joints,     joints.free_mark)                                                                   \
  COMPARED(user_joints)                                                                            \
  COMPARED(events_touching)                                                                        \
  MARKED  (events_resting,  contacts.resting_marks,  kPageMoved | kPageChanged)                    \
  COMPARED(events_woken)                                                                           \
  COMPARED(events_lost)                                                                            \
  COMPARED(events_sensed)                                                                          \
  COMPARED(hook_answers)
// clang-format on

#define SCREE_NAME_SHEET(name, ...) name,
enum class SheetId : std::uint8_t {
  SCREE_SHEETS(SCREE_NAME_SHEET, SCREE_NAME_SHEET, SCREE_NAME_SHEET) count,
  none = count,
};
#undef SCREE_NAME_SHEET
inline constexpr std::size_t kSheetCount = static_cast<std::size_t>(SheetId::count);

// Whether the sheet leaves the free rows of contacts out.
constexpr bool is_of_contacts(SheetId sheet) {
  return sheet == SheetId::contacts_moving || sheet == SheetId::contacts;
}

// What the marks of a world are about.
struct LastSave {
  std::shared_ptr<SavedPages> pages;
  std::uint64_t id = 0;  // that the pages had: others cannot be relied on
};

}  // namespace scree
