// Which columns of the state table snapshots hold, for those who save, load, write and read them.
#pragma once

#include <core/world/state_table.h>

#include <string_view>
#include <type_traits>

namespace scree {

// What is derived, but takes longer to make than to copy.
inline bool is_kept(std::string_view store, std::string_view name) {
  return store == "bodies" && name == "core";
}

// Calls visit(store, name, column) for the columns that a snapshot holds, in the order of the table.
template <class Visit>
void for_each_saved_column(WorldData& data, Visit&& visit) {
  for_each_column(data, [&visit](ColumnKind kind, const char* store, const char* name, auto& column) {
    using Row = std::remove_reference_t<decltype(column[0])>;
    static_assert(std::is_trivially_copyable_v<Row>);
    if (kind == ColumnKind::state || (kind == ColumnKind::derived && is_kept(store, name)))
      visit(store, name, column);
  });
}

// A world's columns without rows, for what depends on the table alone.
inline WorldData& empty_table() {
  static WorldData table;
  return table;
}

}  // namespace scree
