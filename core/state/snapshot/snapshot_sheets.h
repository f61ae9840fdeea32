// The columns of a snapshot in memory: sheets of pages. A sheet has the columns of one store that change
// together: what steps write of whatever moves is apart from what calls write, and each list is by itself.
// The state table names each column's sheet.
//
// Saving takes the pages of the last save of the same world and replaces those that are marked as changed
// since (change_marks.h, which lists the sheets). Lists without marks are compared page by page.
#pragma once

#include <core/state/snapshot/snapshot_pages.h>
#include <core/world/world_data.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>

namespace scree {

struct SnapshotData;

struct Sheets {
  std::array<Sheet, kSheetCount> sheet;

  Sheet& operator[](SheetId id) { return sheet[static_cast<std::size_t>(id)]; }
  const Sheet& operator[](SheetId id) const { return sheet[static_cast<std::size_t>(id)]; }
  std::size_t bytes() const;
  void clear() noexcept;
};

// What a snapshot has. Worlds remember whose pages they were last saved to; they may look at the id, and copy
// the sheets if it is the one that they know, from another thread than that which saves into the snapshot.
struct SavedPages {
  std::mutex mutex;      // of `id`, and of `sheets` unless it is 0
  std::uint64_t id = 0;  // of the content; 0 while that changes
  Sheets sheets;
};

// Where a saved column is.
struct SheetPlace {
  SheetId sheet;
  std::uint8_t column;  // of the sheet
  std::uint16_t row_bytes;
};
// By the column's number among all saved ones.
SheetPlace place_of_column(std::size_t number);
// Row sizes of a sheet's columns.
std::span<const std::uint16_t> columns_of(SheetId sheet);

// The column's part of a page of its sheet.
PageColumn column_of(const SavedPage& page, SheetPlace place);

// Fills the snapshot's pages. With `remember` the world is marked as saved. Throws std::bad_alloc; the pages
// are of no use then.
void save_sheets(WorldData& data, SnapshotData& snapshot, bool remember);

// Makes sure that load_sheets and later calls that count on room in lists cannot fail.
void reserve_columns(const Sheets& sheets, WorldData& data);
// Fills the state columns. Derived and scratch columns of stores get as many rows; what is in them is not
// made. Rows that all are zero are not written to where `may_be_zero`: in new pages, they take no memory.
void load_sheets(const Sheets& sheets, WorldData& data, bool may_be_zero);
// The world is what the snapshot has, and is marked as saved to it.
void remember_saved(WorldData& data, const SnapshotData& snapshot) noexcept;

// Begins with other content in place of what the pages have: they become those of `base`, or empty without
// one. `used` gets what they were. Returns whether the base was still there: its id may not be the given one.
bool begin_pages(SnapshotData& snapshot, const std::shared_ptr<SavedPages>& base, std::uint64_t base_id);
void finish_pages(SnapshotData& snapshot);
// Instead, where memory has run out.
void drop_pages(SnapshotData& snapshot) noexcept;

}  // namespace scree
