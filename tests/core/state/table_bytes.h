// The columns and values of a world as bytes, in the order of the state table. Tests compare them in loops: a
// walk over the table within another one would be compiled for each pair of members.
#pragma once

#include <core/world/state_table.h>

#include <string>
#include <type_traits>
#include <vector>

namespace scree::test {

inline std::string name_of(const Member& member) { return std::string(member.store) + "." + member.name; }

struct ColumnBytes {
  Member member;
  unsigned char* first;  // byte of the first row
  std::size_t row_bytes, rows;

  std::size_t bytes() const { return row_bytes * rows; }
  unsigned char* row(std::size_t index) const { return first + index * row_bytes; }
};

// They hold until the world is changed.
inline std::vector<ColumnBytes> columns_of(WorldData& data) {
  std::vector<ColumnBytes> columns;
  for_each_column_member(data, [&columns](const Member& member, auto& column) {
    columns.push_back(
        {member, reinterpret_cast<unsigned char*>(column.data()), sizeof(*column.data()), column.size()});
  });
  return columns;
}

struct ValueBytes {
  Member member;
  unsigned char* first;
};

// The values that are plain memory.
inline std::vector<ValueBytes> values_of(WorldData& data) {
  std::vector<ValueBytes> values;
  for_each_member(data, [&values](const Member& member, auto& it) {
    using It = std::remove_reference_t<decltype(it)>;
    if constexpr (!kIsColumn<It> && std::is_trivially_copyable_v<It> && !std::is_pointer_v<It>) {
      if (member.form == MemberForm::value) values.push_back({member, reinterpret_cast<unsigned char*>(&it)});
    }
  });
  return values;
}

}  // namespace scree::test
