// Packs and unpacks the columns of a snapshot; see snapshot_columns.h.
#define XXH_INLINE_ALL
#include <core/state/snapshot/saved_columns.h>
#include <core/state/snapshot/snapshot_columns.h>
#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <string>
#include <type_traits>

namespace scree {

namespace {

constexpr std::size_t aligned(std::size_t at) {
  return (at + kColumnAlignment - 1) / kColumnAlignment * kColumnAlignment;
}
constexpr std::size_t blocks_of(std::size_t rows) { return pages_of(rows); }

ColumnForm form_of(const Member& member) {
  if (!is_of_contacts(member.sheet)) return member.is.varied ? ColumnForm::plain : ColumnForm::blocks;
  if (member.is.tells_presence) return ColumnForm::plain;
  return member.is.varied ? ColumnForm::contacts : ColumnForm::contact_blocks;
}

// --- packing ---

void put(Column<std::byte>& out, const void* from, std::size_t bytes) {
  const std::size_t at = out.size();
  out.resize_for_overwrite(at + bytes);
  if (bytes > 0) std::memcpy(out.data() + at, from, bytes);
}

void align(Column<std::byte>& out) {
  while (out.size() % kColumnAlignment != 0) out.push_back(std::byte{0});
}

// Calls visit(page, part) for the pages of a sheet, with one column's part of them.
template <class Visit>
void for_each_part(const Sheet& sheet, SheetPlace place, Visit&& visit) {
  for (std::size_t number = 0; number < pages_of(sheet.rows); ++number) {
    const SavedPage& page = *sheet.page(number);
    visit(page, column_of(page, place));
  }
}

std::size_t rows_in(const SavedPage& page) {
  return static_cast<std::size_t>(std::popcount(page.content.present));
}

// The rows that are present.
void put_rows(const Sheet& sheet, SheetPlace place, Column<std::byte>& out) {
  for_each_part(sheet, place, [&](const SavedPage& page, const PageColumn& part) {
    if (!part.is_equal) return put(out, part.bytes, rows_in(page) * place.row_bytes);
    for (std::size_t i = 0; i < rows_in(page); ++i) put(out, part.bytes, place.row_bytes);
  });
}

// All rows, where free ones are zero.
void put_with_free_rows(const Sheet& sheet, SheetPlace place, Column<std::byte>& out) {
  std::size_t left = sheet.rows;
  for_each_part(sheet, place, [&](const SavedPage& page, const PageColumn& part) {
    const std::size_t begin = out.size(), count = std::min(left, kPageRows);
    out.resize_for_overwrite(begin + count * place.row_bytes);
    std::memset(out.data() + begin, 0, count * place.row_bytes);
    const std::byte* from = part.bytes;
    for (std::uint64_t rows = page.content.present; rows != 0; rows &= rows - 1) {
      const auto row = static_cast<std::size_t>(std::countr_zero(rows));
      std::memcpy(out.data() + begin + row * place.row_bytes, from, place.row_bytes);
      if (!part.is_equal) from += place.row_bytes;
    }
    left -= count;
  });
}

// A page is a block.
void put_blocks(const Sheet& sheet, SheetPlace place, Column<std::byte>& out) {
  static_assert(kSavedBlock == kPageRows);
  for_each_part(sheet, place,
                [&](const SavedPage&, const PageColumn& part) { out.push_back(std::byte{part.is_equal}); });
  for_each_part(sheet, place, [&](const SavedPage& page, const PageColumn& part) {
    put(out, part.bytes, (part.is_equal ? 1 : rows_in(page)) * place.row_bytes);
  });
}

// Blocks of the rows that are present, which are others than those of the pages.
void put_contact_blocks(const Sheet& sheet, SheetPlace place, std::size_t contacts, Column<std::byte>& out) {
  Column<std::byte> rows;
  put_rows(sheet, place, rows);
  const std::size_t flags = out.size(), size = place.row_bytes;
  out.resize_for_overwrite(flags + blocks_of(contacts));
  for (std::size_t first = 0; first < contacts; first += kSavedBlock) {
    const std::size_t count = std::min(kSavedBlock, contacts - first);
    const std::byte* block = rows.data() + first * size;
    const bool equal = std::memcmp(block, block + size, (count - 1) * size) == 0;
    out[flags + first / kSavedBlock] = std::byte{equal};
    put(out, block, (equal ? 1 : count) * size);
  }
}

// --- unpacking ---

// Into rows that are zero, of which those that stay so take no memory in new pages.
template <class Row>
void take_blocks(const std::byte* from, std::size_t rows, Column<Row>& column) {
  const std::byte* flags = from;
  from += blocks_of(rows);
  for (std::size_t first = 0; first < rows; first += kSavedBlock) {
    const std::size_t count = std::min(kSavedBlock, rows - first);
    Row* const block = column.data() + first;
    const bool equal = *flags++ != std::byte{0};
    const std::size_t bytes = (equal ? 1 : count) * sizeof(Row);
    const bool is_zero =
        equal && std::all_of(from, from + sizeof(Row), [](std::byte b) { return b == std::byte{0}; });
    if (!is_zero) std::memcpy(static_cast<void*>(block), from, bytes);
    from += bytes;
    if (equal && !is_zero) std::fill(block + 1, block + count, block[0]);
  }
}

// Reads one column in pages.
class PageReader {
 public:
  PageReader(const SavedColumn& saved, const std::byte* columns)
      : saved_(saved), flags_(columns + saved.begin), rows_(flags_) {
    if (saved.form == ColumnForm::blocks || saved.form == ColumnForm::contact_blocks) {
      rows_ += blocks_of(saved.rows);
    }
  }

  bool is_of_all_rows() const { return saved_.form == ColumnForm::plain; }
  void take(std::size_t count, std::byte* to) {
    if (saved_.form == ColumnForm::contacts) {
      std::memcpy(to, rows_, count * saved_.row_bytes);
      rows_ += count * saved_.row_bytes;
      return;
    }
    while (count > 0) {
      const std::size_t rows = std::min(count, kSavedBlock - row_ % kSavedBlock);
      const bool equal = flags_[row_ / kSavedBlock] != std::byte{0};
      const std::size_t stride = equal ? 0 : saved_.row_bytes;
      for (std::size_t i = 0; equal && i < rows; ++i) {
        std::memcpy(to + i * saved_.row_bytes, rows_, saved_.row_bytes);
      }
      if (!equal) std::memcpy(to, rows_, rows * saved_.row_bytes);
      rows_ += rows * stride;
      row_ += rows;
      if (equal && row_ % kSavedBlock == 0) rows_ += saved_.row_bytes;
      to += rows * saved_.row_bytes;
      count -= rows;
    }
  }
  // The rows among the next `count` that are present.
  void take_present(std::size_t count, std::uint64_t present, std::byte* to) {
    if (present == rows_mask(count)) {
      std::memcpy(to, rows_, count * saved_.row_bytes);
      rows_ += count * saved_.row_bytes;
      return;
    }
    for (std::size_t i = 0; i < count; ++i, rows_ += saved_.row_bytes) {
      if ((present >> i & 1u) == 0) continue;
      std::memcpy(to, rows_, saved_.row_bytes);
      to += saved_.row_bytes;
    }
  }

 private:
  const SavedColumn& saved_;
  const std::byte* flags_;
  const std::byte* rows_;
  std::size_t row_ = 0;
};

void unpack_sheet(const PackedColumns& packed, const SavedColumns& saved, SheetId id, Sheet& sheet) {
  std::vector<PageReader> readers;
  std::vector<PageSource> sources;
  std::array<std::byte, kPageRows * PagePacker::kMostRowBytes> scratch;
  std::byte* place = scratch.data();
  std::size_t rows = 0;
  for (std::size_t i = 0; i < saved.count; ++i) {
    if (place_of_column(i).sheet != id) continue;
    const SavedColumn& column = saved.column[i];
    readers.emplace_back(column, packed.bytes.data());
    sources.push_back({place, column.row_bytes});
    place += kPageRows * column.row_bytes;
    rows = column.rows;
  }
  const SavedColumn& points = saved.find("contacts.now", "points");
  if (is_of_contacts(id)) rows = points.rows;
  Sheet used;
  SheetEditor editor(sheet, used, rows);
  PagePacker packer;
  for (std::size_t page = 0; page < editor.pages(); ++page) {
    if (page % PageGroup::kMost == 0) editor.open(page / PageGroup::kMost);
    const std::size_t first = page * kPageRows, count = std::min(kPageRows, rows - first);
    std::uint64_t present = rows_mask(count);
    if (is_of_contacts(id)) {
      const std::byte* const free = packed.bytes.data() + points.begin + first;
      for (std::size_t i = 0; i < count; ++i) {
        if (free[i] == std::byte{0}) present &= ~(std::uint64_t{1} << i);
      }
    }
    for (std::size_t i = 0; i < readers.size(); ++i) {
      auto* to = const_cast<std::byte*>(sources[i].first);
      if (readers[i].is_of_all_rows()) {
        readers[i].take_present(count, present, to);
      } else {
        readers[i].take(static_cast<std::size_t>(std::popcount(present)), to);
      }
    }
    packer.pack(sources, present, true);
    editor.replace(page, packer.content(), packer.bytes());
    if ((page + 1) % PageGroup::kMost == 0 || page + 1 == editor.pages()) editor.close();
  }
}

std::uint64_t number_at(const Column<std::byte>& columns, std::size_t at) {
  std::uint64_t number;
  std::memcpy(&number, columns.data() + at, sizeof number);
  return number;
}

// Whether the bytes of a column are as many as its rows ask for, and blocks of equal rows are packed.
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
    const bool equal = bytes[block] != std::byte{0};
    const std::size_t first = blocks + packed * saved.row_bytes;
    packed += equal ? 1 : rows;
    if (saved.bytes < blocks + packed * saved.row_bytes) return false;
    const std::byte* row = bytes + first;
    if (!equal && std::memcmp(row, row + saved.row_bytes, (rows - 1) * saved.row_bytes) == 0) return false;
  }
  return saved.bytes == blocks + packed * saved.row_bytes;
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
  contacts.resize(to - contacts.data());
}

void pack_columns(const Sheets& sheets, Column<std::byte>& out) {
  std::size_t contacts = 0;
  for_each_part(sheets[SheetId::contacts], {SheetId::contacts, 0, 0},
                [&](const SavedPage& page, const PageColumn&) { contacts += rows_in(page); });
  out.clear();
  out.reserve(sheets.bytes() / 4 * 5 + 4096);  // rows of contacts that are equal take more room here
  std::size_t number = 0;
  for_each_saved_column(empty_table(), [&](const Member& member, auto&) {
    const SheetPlace place = place_of_column(number++);
    const Sheet& sheet = sheets[place.sheet];
    align(out);
    const std::size_t begin = out.size() + kColumnHeadBytes;
    out.resize_for_overwrite(begin);
    std::uint64_t numbers[2] = {sheet.rows, 0};
    switch (form_of(member)) {
      case ColumnForm::plain:
        if (is_of_contacts(place.sheet)) {
          put_with_free_rows(sheet, place, out);
        } else {
          put_rows(sheet, place, out);
        }
        break;
      case ColumnForm::blocks:
        put_blocks(sheet, place, out);
        break;
      case ColumnForm::contacts:
        put_rows(sheet, place, out);
        numbers[0] = contacts;
        break;
      case ColumnForm::contact_blocks:
        put_contact_blocks(sheet, place, contacts, out);
        numbers[0] = contacts;
        break;
    }
    numbers[1] = out.size() - begin;
    std::memcpy(out.data() + begin - kColumnHeadBytes, numbers, sizeof numbers);
  });
  align(out);
}

SavedColumns find_columns(const Column<std::byte>& columns, ColumnProblem problem, const void* context) {
  SavedColumns saved;
  std::size_t at = 0;
  const auto require = [&](bool holds, std::size_t offset, const char* reason) {
    if (!holds) problem(context, offset, reason);
  };
  const auto skip_gap = [&] {
    for (; at < aligned(at); ++at) {
      if (problem != nullptr) {
        require(at < columns.size(), at, "the columns end too early");
        require(columns[at] == std::byte{0}, at, "a gap between columns is not zero");
      }
    }
  };
  for_each_saved_column(empty_table(), [&](const Member& member, auto& rows) {
    const ColumnForm form = form_of(member);
    skip_gap();
    if (problem != nullptr) {
      require(at <= columns.size() && columns.size() - at >= kColumnHeadBytes, at,
              "the columns end too early");
    }
    SavedColumn& column = saved.column.at(saved.count++);
    column = {member.store,
              member.name,
              form,
              sizeof(*rows.data()),
              static_cast<std::size_t>(number_at(columns, at)),
              static_cast<std::size_t>(number_at(columns, at + sizeof(std::uint64_t))),
              at + kColumnHeadBytes};
    if (problem != nullptr) {
      require(column.bytes <= columns.size() - column.begin, at, "the columns end too early");
      require(is_complete(column, columns.data() + column.begin), at, "a column's bytes do not fit its rows");
    }
    at = column.begin + column.bytes;
  });
  skip_gap();
  if (problem != nullptr) require(at == columns.size(), at, "something follows the last column");
  return saved;
}

void load_columns(const PackedColumns& packed, const SavedColumns& saved, WorldData& data) {
  const SavedColumn* from = saved.column.data();
  for_each_saved_column(data, [&](const Member&, auto& column) {
    const std::byte* const bytes = packed.bytes.data() + from->begin;
    if (from->form == ColumnForm::plain) {
      column.resize_for_overwrite(from->rows);
      if (from->rows > 0) std::memcpy(static_cast<void*>(column.data()), bytes, from->bytes);
    } else if (from->form == ColumnForm::blocks) {
      column.clear();
      column.resize(from->rows);
      take_blocks(bytes, from->rows, column);
    }
    ++from;
  });
}

void unpack_columns(const PackedColumns& packed, const SavedColumns& saved, Sheets& sheets) {
  for (std::size_t i = 0; i < kSheetCount; ++i) {
    unpack_sheet(packed, saved, static_cast<SheetId>(i), sheets.sheet[i]);
  }
}

std::uint64_t layout_of_columns() {
  std::string text;
  for_each_saved_column(empty_table(), [&text](const Member& member, auto& rows) {
    const ColumnForm form = form_of(member);
    text += std::string(member.store) + '.' + member.name + ':' + std::to_string(sizeof(*rows.data())) + ':' +
            std::to_string(static_cast<int>(form)) + ';';
  });
  return XXH64(text.data(), text.size(), 0);
}

}  // namespace scree
