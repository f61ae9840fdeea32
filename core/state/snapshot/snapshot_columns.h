// The columns of a snapshot as bytes: every state column of the table, in the table's order, and
// Bodies::core, which takes longer to make than to copy.
//
// Each begins at a multiple of 8 bytes with its number of rows and the number of bytes that follow, 8 bytes
// each, in one of four forms. Nothing else distinguishes columns of different worlds, so the table is
// part of the format: see layout_of_columns.
#pragma once

#include <core/state/snapshot/snapshot.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace scree {

enum class ColumnForm : std::uint8_t {
  plain,     // the rows
  blocks,    // rows in blocks of kSavedBlock: a byte for each block, 1 where all of its rows are equal, then
             // the first row of those blocks and all rows of the others
  contacts,  // the rows of contacts, without the free ones
  contact_blocks,  // these in blocks
};
inline constexpr std::size_t kSavedBlock = kPageRows;

inline constexpr std::size_t kColumnAlignment = 8;
inline constexpr std::size_t kColumnHeadBytes = 2 * sizeof(std::uint64_t);  // rows and bytes

// Where a column lies among the bytes.
struct SavedColumn {
  std::string_view store;
  std::string_view name;
  ColumnForm form;
  std::size_t row_bytes;
  std::size_t rows;
  std::size_t bytes;
  std::size_t begin;  // of the bytes, behind the two numbers
};

// All of them, without memory of its own.
struct SavedColumns {
  static constexpr std::size_t kMost = 96;
  std::array<SavedColumn, kMost> column;
  std::size_t count = 0;

  const SavedColumn& find(std::string_view store, std::string_view name) const;
};

// Bytes, and what is needed to find a contact's row in them.
struct PackedColumns {
  Column<std::byte> bytes;
  Column<std::int32_t> contacts;  // the rows of ContactRows that are no free ones, ascending
};

// Packs a snapshot's columns. Throws std::bad_alloc.
void pack_columns(const Sheets& sheets, Column<std::byte>& bytes);

// Finds the columns. `problem` is called with an offset and a reason where they are not what would have been
// written, and must not return; what was written has no such problem.
using ColumnProblem = void (*)(const void* context, std::size_t offset, const char* reason);
SavedColumns find_columns(const Column<std::byte>& columns, ColumnProblem problem = nullptr,
                          const void* context = nullptr);

// Unpacks the state columns except the rows of contacts, of which it does `points`.
void load_columns(const PackedColumns& packed, const SavedColumns& saved, WorldData& data);
// Unpacks all into sheets that are empty.
void unpack_columns(const PackedColumns& packed, const SavedColumns& saved, Sheets& sheets);

// Lists the rows in which `points` is not zero.
void list_contacts(const std::uint8_t* points, std::size_t rows, Column<std::int32_t>& contacts);

// Tells tables apart: a hash of names, forms and row sizes.
std::uint64_t layout_of_columns();

}  // namespace scree
