// The columns of the state table that snapshots hold, in the order in which they are saved, loaded, written
// and read: those that have a sheet.
#pragma once

#include <core/world/state_table.h>

#include <type_traits>

namespace scree {

// Calls visit(Member, column) for the columns that a snapshot holds, in the order of the table.
template <class Visit>
void for_each_saved_column(WorldData& data, Visit&& visit) {
  for_each_column_member(data, [&visit](const Member& member, auto& column) {
    if (member.sheet != SheetId::none) visit(member, column);
  });
}

// A world's columns without rows, for what depends on the table alone.
inline WorldData& empty_table() {
  static WorldData table;
  return table;
}

}  // namespace scree
