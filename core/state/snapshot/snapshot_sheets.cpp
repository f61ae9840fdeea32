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

SheetId sheet_of(std::string_view store, std::string_view name) {
  const auto is_one_of = [&](std::initializer_list<std::string_view> names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  if (store == "bodies") {
    if (name == "free_slots") return SheetId::free_bodies;
    return is_one_of({"pose", "velocity", "force", "sleep_time", "drift"}) ? SheetId::bodies_moving
                                                                           : SheetId::bodies;
  }
  if (store == "shapes") {
    if (name == "free_slots") return SheetId::free_shapes;
    if (name == "dirty") return SheetId::dirty_shapes;
    return is_one_of({"fat_bounds", "pose"}) ? SheetId::shapes_moving : SheetId::shapes;
  }
  if (store == "hulls") return name == "free_slots" ? SheetId::free_hulls : SheetId::hulls;
  if (store == "contacts.pairs") return name == "axis" ? SheetId::pair_axes : SheetId::pairs;
  if (store == "contacts.resting") return name == "axis" ? SheetId::resting_axes : SheetId::resting;
  if (store == "contacts.now") {
    return is_one_of({"points", "manifold"}) ? SheetId::contacts_moving : SheetId::contacts;
  }
  if (store == "contacts") return name == "forces" ? SheetId::contact_forces : SheetId::free_contacts;
  if (store == "joints") {
    if (name == "free_slots") return SheetId::free_joints;
    return is_one_of({"impulses", "color"}) ? SheetId::joints_moving : SheetId::joints;
  }
  if (store == "events") {
    if (name == "touching") return SheetId::events_touching;
    if (name == "resting") return SheetId::events_resting;
    if (name == "woken") return SheetId::events_woken;
    if (name == "lost") return SheetId::events_lost;
  }
  std::abort();  // a new column belongs into some sheet
}

struct SheetTable {
  std::array<SheetPlace, kMostColumns> place;
  std::array<std::array<std::uint16_t, kMostSheetColumns>, kSheetCount> row_bytes{};
  std::array<std::size_t, kSheetCount> columns{};

  SheetTable() {
    std::array<std::size_t, kSheetCount> bytes{};
    std::size_t number = 0;
    for_each_saved_column(empty_table(), [&](const char* store, const char* name, auto& column) {
      const SheetId id = sheet_of(store, name);
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
  for_each_saved_column(data, [&](const char*, const char*, auto& column) {
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
  mark(data.contacts.marks, data.contacts.touching, kPageMoved | kPageChanged);
}

// Which pages of a sheet may differ from those of the last save.
struct Watch {
  const PageMarks* marks = nullptr;  // with one of `bits`
  std::uint8_t bits = 0;
  std::size_t kept = 0;  // of the first pages, without marks

  bool may_differ(std::size_t page) const {
    if (marks == nullptr) return page >= kept;
    return page >= marks->pages.size() || (marks->pages[page] & bits) != 0;
  }
  // Whether any page of [first, end) may, of which `first` is a multiple of PageGroup::kMost.
  bool any_may_differ(std::size_t first, std::size_t end) const {
    if (marks == nullptr) return end > kept;
    if (end > marks->pages.size()) return true;
    std::uint64_t all = 0, word = 0;
    for (std::size_t page = first; page < end; page += sizeof word) {
      std::memcpy(&word, marks->pages.data() + page, std::min(sizeof word, end - page));
      all |= word;
      word = 0;
    }
    return (all & 0x0101010101010101u * bits) != 0;
  }
};

Watch watch_of(SheetId sheet, const WorldData& data) {
  constexpr std::uint8_t kMoved = kPageMoved | kPageChanged;
  const auto list = [](const ListMark& mark) { return Watch{nullptr, 0, mark.kept / kPageRows}; };
  switch (sheet) {
    case SheetId::bodies_moving:
      return {&data.bodies.marks, kMoved, 0};
    case SheetId::bodies:
      return {&data.bodies.marks, kPageChanged, 0};
    case SheetId::shapes_moving:
      return {&data.shapes.marks, kMoved, 0};
    case SheetId::shapes:
      return {&data.shapes.marks, kPageChanged, 0};
    case SheetId::joints_moving:
      return {&data.joints.marks, kMoved, 0};
    case SheetId::joints:
      return {&data.joints.marks, kPageChanged, 0};
    case SheetId::contacts_moving:
      return {&data.contacts.marks, kMoved, 0};
    case SheetId::contacts:
      return {&data.contacts.marks, kPageChanged, 0};
    case SheetId::resting:
    case SheetId::resting_axes:
    case SheetId::events_resting:
      return {&data.contacts.resting_marks, kMoved, 0};
    case SheetId::free_bodies:
      return list(data.bodies.free_mark);
    case SheetId::free_shapes:
      return list(data.shapes.free_mark);
    case SheetId::free_joints:
      return list(data.joints.free_mark);
    case SheetId::free_contacts:
      return list(data.contacts.free_mark);
    default:
      return {};  // all pages, which are compared then
  }
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

void load_page(const SavedPage& page, std::span<const std::uint16_t> row_bytes, std::size_t row,
               std::span<std::byte* const> columns) {
  const PageContent& content = page.content;
  const auto count = static_cast<std::size_t>(std::popcount(content.present));
  if (count == 0) return;
  const bool is_run = content.present == rows_mask(count);
  const std::byte* from = page.data();
  for (std::size_t i = 0; i < row_bytes.size(); ++i) {
    const std::size_t size = row_bytes[i];
    const bool is_equal = (content.equal >> i & 1u) != 0;
    std::byte* to = columns[i] + row * size;
    if (is_run) {
      put_rows(from, is_equal, size, count, to);
    } else {
      put_present_rows(from, is_equal, size, content.present, to);
    }
    from += is_equal ? size : count * size;
  }
}

template <class Store>
void reserve_store(Store& store, std::size_t rows) {
  store.for_each_column([rows](ColumnKind, const char*, auto& column) { column.reserve(rows); });
}

template <class Store>
void resize_unsaved(Store& store, std::size_t rows) {
  store.for_each_column([rows](ColumnKind kind, const char*, auto& column) {
    if (kind != ColumnKind::state) column.resize(rows);  // keeps what is loaded already
  });
}

void forget_marks(WorldData& data) {
  data.bodies.marks.forget(data.bodies.flags.size());
  data.shapes.marks.forget(data.shapes.flags.size());
  data.joints.marks.forget(data.joints.flags.size());
  data.contacts.marks.forget(data.contacts.now.points.size());
  data.contacts.resting_marks.forget(data.contacts.resting.pair.size());
  data.bodies.free_mark.kept = data.bodies.free_slots.size();
  data.shapes.free_mark.kept = data.shapes.free_slots.size();
  data.joints.free_mark.kept = data.joints.free_slots.size();
  data.contacts.free_mark.kept = data.contacts.free_rows.size();
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
    forget_marks(data);
    data.last_save = {snapshot.pages, snapshot.id};
  } catch (...) {  // no memory for marks
    data.last_save = {};
  }
}

void reserve_columns(const Sheets& sheets, WorldData& data) {
  const auto rows = [&](SheetId id) { return sheets[id].rows; };
  const std::size_t bodies = rows(SheetId::bodies), shapes = rows(SheetId::shapes);
  const std::size_t contacts = rows(SheetId::contacts), joints = rows(SheetId::joints);
  reserve_store(data.bodies, bodies);
  data.bodies.free_slots.reserve(bodies);
  data.bodies.to_place.reserve(bodies);
  data.bodies.changed.reserve(bodies);
  reserve_store(data.shapes, shapes);
  data.shapes.free_slots.reserve(shapes);
  data.shapes.dirty.reserve(shapes);
  data.shapes.wakers.reserve(shapes);
  data.shapes.changed.reserve(shapes);
  reserve_store(data.hulls, rows(SheetId::hulls));
  data.hulls.free_slots.reserve(rows(SheetId::hulls));
  reserve_store(data.contacts.pairs, rows(SheetId::pairs));
  reserve_store(data.contacts.resting, rows(SheetId::resting));
  data.contacts.resting_links.reserve(rows(SheetId::resting));
  reserve_store(data.contacts.now, contacts);
  data.contacts.free_rows.reserve(contacts);
  reserve_store(data.joints, joints);
  data.joints.changed.reserve(joints);
  data.contacts.forces.reserve(rows(SheetId::contact_forces));
  data.joints.free_slots.reserve(joints);
  data.events.lost.reserve(rows(SheetId::events_lost));
  data.events.touching.reserve(rows(SheetId::events_touching));
  data.events.resting.reserve(rows(SheetId::events_resting));
  data.events.woken.reserve(bodies);
}

void load_sheets(const Sheets& sheets, WorldData& data) {
  const SheetTable& table = sheet_table();
  std::array<std::array<std::byte*, kMostSheetColumns>, kSheetCount> columns;
  std::size_t number = 0;
  for_each_saved_column(data, [&](const char*, const char*, auto& column) {
    const SheetPlace place = table.place[number++];
    if (is_of_contacts(place.sheet)) {
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
      load_page(*sheet.page(page), row_bytes, page * kPageRows, columns[i]);
    }
  }
  resize_unsaved(data.bodies, sheets[SheetId::bodies].rows);
  resize_unsaved(data.shapes, sheets[SheetId::shapes].rows);
  resize_unsaved(data.hulls, sheets[SheetId::hulls].rows);
  resize_unsaved(data.contacts.pairs, sheets[SheetId::pairs].rows);
  resize_unsaved(data.contacts.resting, sheets[SheetId::resting].rows);
  resize_unsaved(data.contacts.now, sheets[SheetId::contacts].rows);
  resize_unsaved(data.joints, sheets[SheetId::joints].rows);
}

}  // namespace scree
