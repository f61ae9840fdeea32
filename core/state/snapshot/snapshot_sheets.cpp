// Saves and loads the sheets of a snapshot; see snapshot_sheets.h.
#include <core/state/snapshot/saved_columns.h>
#include <core/state/snapshot/snapshot.h>
#include <core/state/snapshot/snapshot_sheets.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <cstring>

namespace scree {

namespace {

constexpr std::size_t kMostColumns = 96;       // of all sheets
constexpr std::size_t kMostSheetColumns = 24;  // of one

struct SheetTable {
  std::array<SheetPlace, kMostColumns> place;
  std::array<std::array<std::uint16_t, kMostSheetColumns>, kSheetCount> row_bytes{};
  std::array<std::size_t, kSheetCount> columns{};

  SheetTable() {
    std::array<std::size_t, kSheetCount> bytes{};
    std::size_t number = 0;
    for_each_saved_column(empty_table(), [&](const Member& member, auto& column) {
      const SheetId id = member.sheet;
      const auto sheet = static_cast<std::size_t>(id);
      const auto size = static_cast<std::uint16_t>(sizeof(*column.data()));
      place.at(number++) = {id, static_cast<std::uint8_t>(columns[sheet]), size};
      row_bytes[sheet].at(columns[sheet]++) = size;
      bytes[sheet] += size;
      if (bytes[sheet] > PagePacker::kMostRowBytes) std::abort();
    });
  }
};

const SheetTable& sheet_table() {
  static const SheetTable table;
  return table;
}

// --- saving ---

// Where a world's columns lie, by sheet.
struct SheetColumns {
  std::array<PageSource, kMostSheetColumns> column;
  std::size_t count = 0;
  std::size_t rows = 0;
};

std::array<SheetColumns, kSheetCount> columns_of(WorldData& data) {
  std::array<SheetColumns, kSheetCount> all;
  const SheetTable& table = sheet_table();
  std::size_t number = 0;
  for_each_saved_column(data, [&](const Member&, auto& column) {
    const SheetPlace place = table.place[number++];
    SheetColumns& sheet = all[static_cast<std::size_t>(place.sheet)];
    sheet.column[place.column] = {reinterpret_cast<const std::byte*>(column.data()), place.row_bytes};
    sheet.count = std::size_t{place.column} + 1;
    sheet.rows = column.size();
  });
  return all;
}

// Marks what moves, as steps do not.
void mark_moving(WorldData& data) {
  const auto mark = [](PageMarks& pages, const Column<std::int32_t>& list, std::uint8_t how) {
    for (const std::int32_t row : list) pages.mark(row, how);
  };
  mark(data.bodies.marks, data.bodies.awake, kPageMoved);
  mark(data.bodies.marks, data.bodies.kinematic, kPageMoved);
  mark(data.shapes.marks, data.shapes.moving, kPageMoved);
  mark(data.joints.marks, data.joints.active, kPageMoved);
  mark(data.contacts.marks, data.contacts.active, kPageMoved | kPageChanged);
}

// Which pages of a sheet may differ from those of the last save.
struct Watch {
  const PageMarks* marks = nullptr;  // with one of `bits`
  std::uint8_t bits = 0;
  std::size_t kept = 0;  // of the first pages, without marks

  bool may_differ(std::size_t page) const {
    if (marks == nullptr) return page >= kept;
    return page >= marks->size() || ((*marks)[page] & bits) != 0;
  }
  // Whether any page of [first, end) may, of which `first` is a multiple of PageGroup::kMost.
  bool any_may_differ(std::size_t first, std::size_t end) const {
    if (marks == nullptr) return end > kept;
    if (end > marks->size()) return true;
    std::uint64_t all = 0, word = 0;
    for (std::size_t page = first; page < end; page += sizeof word) {
      std::memcpy(&word, marks->data() + page, std::min(sizeof word, end - page));
      all |= word;
      word = 0;
    }
    return (all & 0x0101010101010101u * bits) != 0;
  }
};

#define SCREE_WATCH_MARKED(name, marks, bits) \
  case SheetId::name:                         \
    return {&data.marks, bits, 0};
#define SCREE_WATCH_LISTED(name, mark) \
  case SheetId::name:                  \
    return {nullptr, 0, data.mark.kept / kPageRows};
#define SCREE_WATCH_COMPARED(name) \
  case SheetId::name:              \
    return {};

Watch watch_of(SheetId sheet, const WorldData& data) {
  switch (sheet) {
    SCREE_SHEETS(SCREE_WATCH_MARKED, SCREE_WATCH_LISTED, SCREE_WATCH_COMPARED)
    case SheetId::count:
      break;
  }
  return {};
}

// Bits of the contacts among the rows of a page.
std::uint64_t contacts_in(const Column<std::uint8_t>& points, std::size_t first, std::size_t count) {
  std::uint64_t present = 0;
  for (std::size_t i = 0; i < count; ++i) {
    present |= std::uint64_t{points[first + i] != 0} << i;
  }
  return present;
}

void save_sheet(const WorldData& data, SheetId id, SheetColumns& from, const Watch& watch, Sheet& sheet,
                Sheet& used, PagePacker& packer) {
  SheetEditor editor(sheet, used, from.rows);
  const std::span columns(from.column.data(), from.count);
  std::array<const std::byte*, kMostSheetColumns> begin;
  for (std::size_t i = 0; i < from.count; ++i) begin[i] = from.column[i].first;
  for (std::size_t group = 0; group < sheet.groups.size(); ++group) {
    const std::size_t first = group * PageGroup::kMost;
    const std::size_t end = std::min(first + PageGroup::kMost, editor.pages());
    if (end <= editor.base_pages() && !editor.must_open(group) && !watch.any_may_differ(first, end)) continue;
    editor.open(group);
    for (std::size_t page = first; page < end; ++page) {
      if (page < editor.base_pages() && !watch.may_differ(page)) {
        editor.keep(page);
        continue;
      }
      const std::size_t row = page * kPageRows, count = std::min(kPageRows, from.rows - row);
      for (std::size_t i = 0; i < from.count; ++i) {
        from.column[i].first = begin[i] + row * from.column[i].row_bytes;
      }
      packer.pack(columns,
                  is_of_contacts(id) ? contacts_in(data.contacts.now.points, row, count) : rows_mask(count));
      editor.replace(page, packer.content(), packer.bytes());
    }
    editor.close();
  }
}

// --- loading ---

// Writes `count` rows from one or as many.
void put_rows(const std::byte* from, bool is_equal, std::size_t row_bytes, std::size_t count, std::byte* to) {
  if (!is_equal) {
    std::memcpy(to, from, count * row_bytes);
    return;
  }
  const std::size_t all = count * row_bytes;
  std::memcpy(to, from, row_bytes);
  for (std::size_t done = row_bytes; done < all; done *= 2) {
    std::memcpy(to + done, to, std::min(done, all - done));
  }
}

void put_present_rows(const std::byte* from, bool is_equal, std::size_t row_bytes, std::uint64_t present,
                      std::byte* to) {
  for (std::uint64_t left = present; left != 0; left &= left - 1) {
    std::memcpy(to + static_cast<std::size_t>(std::countr_zero(left)) * row_bytes, from, row_bytes);
    if (!is_equal) from += row_bytes;
  }
}

bool is_zero(const std::byte* row, std::size_t bytes) {
  return std::all_of(row, row + bytes, [](std::byte b) { return b == std::byte{0}; });
}

void load_page(const SavedPage& page, std::span<const std::uint16_t> row_bytes, std::size_t row,
               std::span<std::byte* const> columns, bool are_zero) {
  const PageContent& content = page.content;
  const auto count = static_cast<std::size_t>(std::popcount(content.present));
  if (count == 0) return;
  const bool is_run = content.present == rows_mask(count);
  const std::byte* from = page.data();
  for (std::size_t i = 0; i < row_bytes.size(); ++i) {
    const std::size_t size = row_bytes[i];
    const bool is_equal = (content.equal >> i & 1u) != 0;
    std::byte* to = columns[i] + row * size;
    if (are_zero && is_equal && is_zero(from, size)) {
      // as they are
    } else if (is_run) {
      put_rows(from, is_equal, size, count, to);
    } else {
      put_present_rows(from, is_equal, size, content.present, to);
    }
    from += is_equal ? size : count * size;
  }
}

// Of a list or a column that is not saved: rows that calls count on room for.
std::size_t rows_to_reserve(const Sheets& sheets, const Member& member) {
  const auto rows = [&sheets](SheetId sheet) {
    return sheet != SheetId::none ? sheets[sheet].rows : std::size_t{0};
  };
  const SheetId all = member.sheet == SheetId::none ? member.is.all_or_none : SheetId::none;
  return std::max({rows(member.rows), rows(member.sheet), rows(member.is.each_once), rows(all)});
}

// The sheets hold what the world has.
#define SCREE_FORGET_MARKED(name, marks, bits) data.marks.clear();
#define SCREE_COVER_MARKED(name, marks, bits) data.marks.cover(sheets[SheetId::name].rows);
#define SCREE_KEEP_LISTED(name, mark) data.mark.kept = sheets[SheetId::name].rows;
void forget_marks(const Sheets& sheets, WorldData& data) {
  SCREE_SHEETS(SCREE_FORGET_MARKED, SCREE_NOTHING, SCREE_NOTHING)
  SCREE_SHEETS(SCREE_COVER_MARKED, SCREE_KEEP_LISTED, SCREE_NOTHING)
}

}  // namespace

std::size_t Sheets::bytes() const {
  std::size_t sum = 0;
  for (const Sheet& one : sheet) sum += one.bytes();
  return sum;
}

void Sheets::clear() noexcept {
  for (Sheet& one : sheet) one.clear();
}

SheetPlace place_of_column(std::size_t number) { return sheet_table().place[number]; }

std::span<const std::uint16_t> columns_of(SheetId sheet) {
  const auto number = static_cast<std::size_t>(sheet);
  return std::span(sheet_table().row_bytes[number]).first(sheet_table().columns[number]);
}

PageColumn column_of(const SavedPage& page, SheetPlace place) {
  const auto count = static_cast<std::size_t>(std::popcount(page.content.present));
  const auto is_equal = [&](std::size_t column) { return (page.content.equal >> column & 1u) != 0; };
  const std::byte* bytes = page.data();
  const std::span<const std::uint16_t> row_bytes = columns_of(place.sheet);
  for (std::size_t i = 0; count > 0 && i < place.column; ++i) {
    bytes += (is_equal(i) ? std::size_t{1} : count) * row_bytes[i];
  }
  return {bytes, is_equal(place.column)};
}

bool begin_pages(SnapshotData& snapshot, const std::shared_ptr<SavedPages>& base, std::uint64_t base_id) {
  SavedPages& own = *snapshot.pages;
  {
    const std::lock_guard lock(own.mutex);
    const bool is_base = base == snapshot.pages && own.id == base_id && base_id != 0;
    own.id = 0;
    if (is_base) return true;
  }
  std::swap(own.sheets, snapshot.used);
  if (base != nullptr && base != snapshot.pages) {
    const std::lock_guard lock(base->mutex);
    if (base->id == base_id && base_id != 0) {
      own.sheets = base->sheets;
      return true;
    }
  }
  own.sheets.clear();
  return false;
}

void finish_pages(SnapshotData& snapshot) {
  snapshot.used.clear();
  const std::lock_guard lock(snapshot.pages->mutex);
  snapshot.pages->id = snapshot.id;
}

void drop_pages(SnapshotData& snapshot) noexcept {
  const std::lock_guard lock(snapshot.pages->mutex);
  snapshot.pages->id = 0;
  snapshot.pages->sheets.clear();
  snapshot.used.clear();
}

void save_sheets(WorldData& data, SnapshotData& snapshot, bool remember) {
  snapshot.id = next_snapshot_id();
  const bool has_base = begin_pages(snapshot, data.last_save.pages, data.last_save.id);
  if (has_base) mark_moving(data);
  std::array<SheetColumns, kSheetCount> columns = columns_of(data);
  PagePacker packer;
  for (std::size_t i = 0; i < kSheetCount; ++i) {
    const auto id = static_cast<SheetId>(i);
    save_sheet(data, id, columns[i], watch_of(id, data), snapshot.pages->sheets[id], snapshot.used[id],
               packer);
  }
  finish_pages(snapshot);
  if (remember) remember_saved(data, snapshot);
}

void remember_saved(WorldData& data, const SnapshotData& snapshot) noexcept {
  try {
    forget_marks(snapshot.pages->sheets, data);
    data.last_save = {snapshot.pages, snapshot.id};
  } catch (...) {  // no memory for marks
    data.last_save = {};
  }
}

void reserve_columns(const Sheets& sheets, WorldData& data) {
  for_each_column_member(data, [&sheets](const Member& member, auto& column) {
    column.reserve(rows_to_reserve(sheets, member));
  });
}

void load_sheets(const Sheets& sheets, WorldData& data, bool may_be_zero) {
  const SheetTable& table = sheet_table();
  std::array<std::array<std::byte*, kMostSheetColumns>, kSheetCount> columns;
  std::size_t number = 0;
  for_each_saved_column(data, [&](const Member&, auto& column) {
    const SheetPlace place = table.place[number++];
    if (may_be_zero || is_of_contacts(place.sheet)) {
      column.resize(sheets[place.sheet].rows);  // free rows have no chance bytes
    } else {
      column.resize_for_overwrite(sheets[place.sheet].rows);
    }
    columns[static_cast<std::size_t>(place.sheet)][place.column] =
        reinterpret_cast<std::byte*>(column.data());
  });
  Column<std::uint8_t>& points = data.contacts.now.points;
  std::fill(points.begin(), points.end(), std::uint8_t{0});  // of the free rows
  for (std::size_t i = 0; i < kSheetCount; ++i) {
    const Sheet& sheet = sheets.sheet[i];
    const std::span<const std::uint16_t> row_bytes = columns_of(static_cast<SheetId>(i));
    for (std::size_t page = 0; page < pages_of(sheet.rows); ++page) {
      load_page(*sheet.page(page), row_bytes, page * kPageRows, columns[i], may_be_zero);
    }
  }
  for_each_column_member(data, [&sheets](const Member& member, auto& column) {
    if (member.rows != SheetId::none && member.sheet == SheetId::none)
      column.resize(sheets[member.rows].rows);
  });
}

}  // namespace scree
