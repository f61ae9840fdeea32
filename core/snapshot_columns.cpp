// Packs and unpacks the columns of a snapshot; see snapshot_columns.h.
#define XXH_INLINE_ALL
#include <core/snapshot_columns.h>
#include <core/state_table.h>
#include <xxhash.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <string>
#include <type_traits>

namespace scree {

namespace {

constexpr std::size_t aligned(std::size_t at) {
  return (at + kColumnAlignment - 1) / kColumnAlignment * kColumnAlignment;
}
constexpr std::size_t blocks_of(std::size_t rows) { return (rows + kSavedBlock - 1) / kSavedBlock; }

// Rows that hardly ever are equal. Bodies, shapes, pairs and joints have some, so that no snapshot is far
// smaller than what it unpacks to.
template <class Row>
constexpr bool kPlainRow =
    std::is_same_v<Row, PoseRow> || std::is_same_v<Row, BoundsRow> || std::is_same_v<Row, ShapePair> ||
    std::is_same_v<Row, TouchRow> || std::is_same_v<Row, JointBodies> || std::is_same_v<Row, JointImpulses>;

template <class Row>
ColumnForm form_of(std::string_view store, std::string_view name) {
  if (store == "contacts.now") {
    if (name == "points") return ColumnForm::plain;
    // What few contacts have in many scenes.
    const bool rare = name == "anchor" || name == "surface";
    return rare ? ColumnForm::contact_blocks : ColumnForm::contacts;
  }
  const bool rare = store == "events" && name == "resting";  // often zero
  return kPlainRow<Row> && !rare ? ColumnForm::plain : ColumnForm::blocks;
}

// What is derived, but takes longer to make than to copy.
bool is_kept(std::string_view store, std::string_view name) { return store == "bodies" && name == "core"; }

// Calls visit(store, name, form, column) for the columns that a snapshot holds.
template <class Visit>
void for_each_saved_column(WorldData& data, Visit&& visit) {
  for_each_column(data, [&visit](ColumnKind kind, const char* store, const char* name, auto& column) {
    using Row = std::remove_reference_t<decltype(column[0])>;
    static_assert(std::is_trivially_copyable_v<Row>);
    if (kind == ColumnKind::state || is_kept(store, name))
      visit(store, name, form_of<Row>(store, name), column);
  });
}

// A world's columns without rows, for what depends on the table alone.
WorldData& empty_table() {
  static WorldData table;
  return table;
}

// --- packing ---

template <class Row>
std::size_t most_bytes(const Column<Row>& column) {
  return kColumnAlignment + kColumnHeadBytes + blocks_of(column.size()) + column.size() * sizeof(Row);
}

std::byte* put(std::byte* out, const void* from, std::size_t bytes) {
  if (bytes > 0) std::memcpy(out, from, bytes);
  return out + bytes;
}

template <class Row>
std::byte* put_blocks(std::byte* out, const Column<Row>& column) {
  std::byte* flags = out;
  out += blocks_of(column.size());
  for (std::size_t first = 0; first < column.size(); first += kSavedBlock) {
    const std::size_t rows = std::min(kSavedBlock, column.size() - first);
    const auto* block = reinterpret_cast<const std::byte*>(column.data() + first);
    const bool equal = std::memcmp(block, block + sizeof(Row), (rows - 1) * sizeof(Row)) == 0;
    *flags++ = std::byte{equal};
    out = put(out, block, (equal ? 1 : rows) * sizeof(Row));
  }
  return out;
}

// Calls copy(row, place, rows) for rows of contacts and their places among these: many at a time where they
// lie together, else one by one, because a run that ends anywhere costs more than its copy.
template <class Copy>
void for_each_run(const Column<std::int32_t>& contacts, Copy&& copy) {
  constexpr std::size_t kRun = 16;
  constexpr std::size_t kStep = 4;  // before looking for a run again
  const std::size_t count = contacts.size();
  std::size_t place = 0;
  while (place + kRun <= count) {
    const std::int32_t row = contacts[place];
    const auto runs_to = [&](std::size_t rows) {
      return place + rows <= count && contacts[place + rows - 1] - row == static_cast<std::int32_t>(rows - 1);
    };
    if (runs_to(kRun)) {
      std::size_t rows = kRun;
      while (runs_to(rows + kRun)) rows += kRun;
      copy(row, place, rows);
      place += rows;
    } else {
      for (std::size_t i = 0; i < kStep; ++i) copy(contacts[place + i], place + i, std::size_t{1});
      place += kStep;
    }
  }
  for (; place < count; ++place) copy(contacts[place], place, std::size_t{1});
}

template <class Row>
std::byte* put_contacts(std::byte* out, const Column<Row>& column, const Column<std::int32_t>& contacts) {
  const auto* const from = reinterpret_cast<const std::byte*>(column.data());
  for_each_run(contacts, [=](std::int32_t row, std::size_t place, std::size_t rows) {
    std::memcpy(out + place * sizeof(Row), from + static_cast<std::size_t>(row) * sizeof(Row),
                rows * sizeof(Row));
  });
  return out + contacts.size() * sizeof(Row);
}

template <class Row>
std::byte* put_contact_blocks(std::byte* out, const Column<Row>& column,
                              const Column<std::int32_t>& contacts) {
  const Row* const from = column.data();
  std::byte* flags = out;
  out += blocks_of(contacts.size());
  for (std::size_t first = 0; first < contacts.size(); first += kSavedBlock) {
    const std::size_t rows = std::min(kSavedBlock, contacts.size() - first);
    const std::int32_t* const list = contacts.data() + first;
    const auto* block = reinterpret_cast<const std::byte*>(from + list[0]);
    if (list[rows - 1] - list[0] != static_cast<std::int32_t>(rows - 1)) {
      for (std::size_t i = 0; i < rows; ++i) {
        std::memcpy(out + i * sizeof(Row), static_cast<const void*>(from + list[i]), sizeof(Row));
      }
      block = out;
    }
    const bool equal = std::memcmp(block, block + sizeof(Row), (rows - 1) * sizeof(Row)) == 0;
    *flags++ = std::byte{equal};
    const std::size_t bytes = (equal ? 1 : rows) * sizeof(Row);
    if (block != out) std::memcpy(out, block, bytes);
    out += bytes;
  }
  return out;
}

// --- unpacking ---

template <class Row>
void take_blocks(const std::byte* from, std::size_t rows, Column<Row>& column) {
  const std::byte* flags = from;
  from += blocks_of(rows);
  for (std::size_t first = 0; first < rows; first += kSavedBlock) {
    const std::size_t count = std::min(kSavedBlock, rows - first);
    Row* const block = column.data() + first;
    const bool equal = *flags++ != std::byte{0};
    const std::size_t bytes = (equal ? 1 : count) * sizeof(Row);
    std::memcpy(static_cast<void*>(block), from, bytes);
    from += bytes;
    if (equal) std::fill(block + 1, block + count, block[0]);
  }
}

template <class Row>
void take_contacts(const std::byte* from, const Column<std::int32_t>& contacts, Column<Row>& column) {
  auto* const to = reinterpret_cast<std::byte*>(column.data());
  for_each_run(contacts, [=](std::int32_t row, std::size_t place, std::size_t rows) {
    std::memcpy(to + static_cast<std::size_t>(row) * sizeof(Row), from + place * sizeof(Row),
                rows * sizeof(Row));
  });
}

template <class Row>
void take_contact_blocks(const std::byte* from, const Column<std::int32_t>& contacts, Column<Row>& column) {
  const std::byte* flags = from;
  from += blocks_of(contacts.size());
  Row* const rows = column.data();
  for (std::size_t first = 0; first < contacts.size(); first += kSavedBlock) {
    const std::size_t count = std::min(kSavedBlock, contacts.size() - first);
    const std::size_t stride = *flags++ != std::byte{0} ? 0 : sizeof(Row);
    for (std::size_t i = 0; i < count; ++i) {
      std::memcpy(static_cast<void*>(rows + contacts[first + i]), from + i * stride, sizeof(Row));
    }
    from += stride == 0 ? sizeof(Row) : count * stride;
  }
}

std::uint64_t number_at(const Column<std::byte>& columns, std::size_t at) {
  std::uint64_t number;
  std::memcpy(&number, columns.data() + at, sizeof number);
  return number;
}

// Whether the bytes of a column are as many as its rows ask for.
bool is_complete(const SavedColumn& saved, const std::byte* bytes) {
  if (saved.form == ColumnForm::plain || saved.form == ColumnForm::contacts) {
    return saved.rows <= saved.bytes / saved.row_bytes && saved.rows * saved.row_bytes == saved.bytes;
  }
  if (saved.rows > saved.bytes * kSavedBlock) return false;
  const std::size_t blocks = blocks_of(saved.rows);
  std::size_t packed = 0;
  for (std::size_t block = 0; block < blocks; ++block) {
    if (bytes[block] > std::byte{1}) return false;
    const std::size_t rows = std::min(kSavedBlock, saved.rows - block * kSavedBlock);
    packed += bytes[block] != std::byte{0} ? 1 : rows;
  }
  return saved.bytes == blocks + packed * saved.row_bytes;
}

// The sizes of a world's stores.
struct StoreRows {
  std::size_t bodies, shapes, hulls, pairs, resting, contacts, joints;

  explicit StoreRows(const SavedColumns& saved)
      : bodies(saved.find("bodies", "flags").rows),
        shapes(saved.find("shapes", "flags").rows),
        hulls(saved.find("hulls", "content").rows),
        pairs(saved.find("contacts.pairs", "pair").rows),
        resting(saved.find("contacts.resting", "pair").rows),
        contacts(saved.find("contacts.now", "points").rows),
        joints(saved.find("joints", "flags").rows) {}
};

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

}  // namespace

const SavedColumn& SavedColumns::find(std::string_view store, std::string_view name) const {
  const auto found =
      std::find_if(column.begin(), column.begin() + static_cast<std::ptrdiff_t>(count),
                   [&](const SavedColumn& saved) { return saved.store == store && saved.name == name; });
  if (found == column.begin() + static_cast<std::ptrdiff_t>(count)) std::abort();  // not in the table
  return *found;
}

void list_contacts(const std::uint8_t* points, std::size_t rows, Column<std::int32_t>& contacts) {
  contacts.resize_discarding(rows);
  std::int32_t* to = contacts.data();
  for (std::size_t row = 0; row < rows; ++row) {
    *to = static_cast<std::int32_t>(row);
    to += points[row] != 0 ? 1 : 0;  // no branch: free rows lie anywhere
  }
  contacts.resize(static_cast<std::size_t>(to - contacts.data()));
}

void save_columns(const WorldData& data, SnapshotData& snapshot) {
  auto& table = const_cast<WorldData&>(data);  // its columns are read only
  const Column<std::uint8_t>& points = data.contacts.now.points;
  list_contacts(points.data(), points.size(), snapshot.contacts);
  // Room for one column at a time: packed, most are far smaller than they may be.
  Column<std::byte>& out = snapshot.columns;
  out.clear();
  const auto align = [&out] {
    while (out.size() % kColumnAlignment != 0) out.push_back(std::byte{0});
  };
  for_each_saved_column(table, [&](const char*, const char*, ColumnForm form, auto& column) {
    align();
    const std::size_t begin = out.size();
    out.resize_for_overwrite(begin + most_bytes(column));
    std::byte* const head = out.data() + begin;
    std::byte* const rows = head + kColumnHeadBytes;
    std::byte* end = nullptr;
    std::uint64_t numbers[2] = {column.size(), 0};
    switch (form) {
      case ColumnForm::plain:
        end = put(rows, column.data(), column.span().size_bytes());
        break;
      case ColumnForm::blocks:
        end = put_blocks(rows, column);
        break;
      case ColumnForm::contacts:
        end = put_contacts(rows, column, snapshot.contacts);
        numbers[0] = snapshot.contacts.size();
        break;
      case ColumnForm::contact_blocks:
        end = put_contact_blocks(rows, column, snapshot.contacts);
        numbers[0] = snapshot.contacts.size();
        break;
    }
    numbers[1] = static_cast<std::uint64_t>(end - rows);
    put(head, numbers, sizeof numbers);
    out.resize_for_overwrite(static_cast<std::size_t>(end - out.data()));
  });
  align();
}

SavedColumns find_columns(const Column<std::byte>& columns, ColumnProblem problem, const void* context) {
  SavedColumns saved;
  std::size_t at = 0;
  const auto require = [&](bool holds, std::size_t offset, const char* reason) {
    if (!holds) problem(context, offset, reason);
  };
  for_each_saved_column(empty_table(), [&](const char* store, const char* name, ColumnForm form, auto& rows) {
    at = aligned(at);
    if (problem != nullptr) {
      require(at <= columns.size() && columns.size() - at >= kColumnHeadBytes, at,
              "the columns end too early");
    }
    SavedColumn& column = saved.column.at(saved.count++);
    column = {store,
              name,
              form,
              sizeof(*rows.data()),
              static_cast<std::size_t>(number_at(columns, at)),
              static_cast<std::size_t>(number_at(columns, at + sizeof(std::uint64_t))),
              at + kColumnHeadBytes};
    if (problem != nullptr) {
      require(column.bytes <= columns.size() - column.begin, at, "the columns end too early");
      require(is_complete(column, columns.data() + column.begin), at,
              "a column's number of bytes does not fit its rows");
    }
    at = column.begin + column.bytes;
  });
  if (problem != nullptr) require(aligned(at) == columns.size(), at, "something follows the last column");
  return saved;
}

void reserve_columns(const SavedColumns& saved, WorldData& data) {
  const StoreRows rows(saved);
  reserve_store(data.bodies, rows.bodies);
  data.bodies.free_slots.reserve(rows.bodies);
  data.bodies.to_place.reserve(rows.bodies);
  data.bodies.changed.reserve(rows.bodies);
  reserve_store(data.shapes, rows.shapes);
  data.shapes.free_slots.reserve(rows.shapes);
  data.shapes.dirty.reserve(rows.shapes);
  data.shapes.wakers.reserve(rows.shapes);
  data.shapes.changed.reserve(rows.shapes);
  reserve_store(data.hulls, rows.hulls);
  data.hulls.free_slots.reserve(rows.hulls);
  reserve_store(data.contacts.pairs, rows.pairs);
  reserve_store(data.contacts.resting, rows.resting);
  data.contacts.resting_links.reserve(rows.resting);
  reserve_store(data.contacts.now, rows.contacts);
  data.contacts.free_rows.reserve(rows.contacts);
  reserve_store(data.joints, rows.joints);
  data.joints.changed.reserve(rows.joints);
  data.contacts.forces.reserve(saved.find("contacts", "forces").rows);
  data.joints.free_slots.reserve(rows.joints);
  data.events.lost.reserve(saved.find("events", "lost").rows);
  data.events.touching.reserve(saved.find("events", "touching").rows);
  data.events.resting.reserve(saved.find("events", "resting").rows);
  data.events.woken.reserve(rows.bodies);
}

void load_columns(const SnapshotData& snapshot, const SavedColumns& saved, WorldData& data,
                  bool contact_rows) {
  const StoreRows rows(saved);
  const SavedColumn* from = saved.column.data();
  for_each_saved_column(data, [&](const char*, const char*, ColumnForm form, auto& column) {
    const std::byte* const bytes = snapshot.columns.data() + from->begin;
    switch (form) {
      case ColumnForm::plain:
        column.resize_for_overwrite(from->rows);
        if (from->rows > 0) std::memcpy(static_cast<void*>(column.data()), bytes, from->bytes);
        break;
      case ColumnForm::blocks:
        column.resize_for_overwrite(from->rows);
        take_blocks(bytes, from->rows, column);
        break;
      case ColumnForm::contacts:
        if (!contact_rows) break;
        column.resize(rows.contacts);
        take_contacts(bytes, snapshot.contacts, column);
        break;
      case ColumnForm::contact_blocks:
        if (!contact_rows) break;
        column.resize(rows.contacts);
        take_contact_blocks(bytes, snapshot.contacts, column);
        break;
    }
    ++from;
  });
  if (!contact_rows) return;
  resize_unsaved(data.bodies, rows.bodies);
  resize_unsaved(data.shapes, rows.shapes);
  resize_unsaved(data.hulls, rows.hulls);
  resize_unsaved(data.contacts.pairs, rows.pairs);
  resize_unsaved(data.contacts.resting, rows.resting);
  resize_unsaved(data.contacts.now, rows.contacts);
  resize_unsaved(data.joints, rows.joints);
}

std::uint64_t layout_of_columns() {
  std::string text;
  for_each_saved_column(
      empty_table(), [&text](const char* store, const char* name, ColumnForm form, auto& rows) {
        text += std::string(store) + '.' + name + ':' + std::to_string(sizeof(*rows.data())) + ':' +
                std::to_string(static_cast<int>(form)) + ';';
      });
  return XXH64(text.data(), text.size(), 0);
}

}  // namespace scree
