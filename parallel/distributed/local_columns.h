// Columns whose rows are where the body is: in a world of many ranks, those of absent bodies say nothing.
#pragma once

#include <core/world/world_data.h>

#include <cstdint>
#include <type_traits>

namespace scree {

template <class T>
inline constexpr bool kHasRows = false;
template <class Row>
inline constexpr bool kHasRows<Column<Row>> = true;

// Columns of bodies or shapes whose rows are where the body is: those that travel with it, and those that say
// nothing between two stages, which are zero where it comes to.
enum class LocalColumns { all, travelling, staying };

template <class Store, class Visit>  // visit(column)
void for_each_local_column(Store& store, LocalColumns which, Visit&& visit) {
  std::remove_const_t<Store>::visit_members(store, TablePlace{}, [&](const Member& member, auto& column) {
    if constexpr (kHasRows<std::remove_cvref_t<decltype(column)>>) {
      if (member.form != MemberForm::rows || member.is.on_all_ranks) return;
      const bool travels = member.kind != ColumnKind::scratch || member.is.travels;
      if (which == LocalColumns::all || travels == (which == LocalColumns::travelling)) visit(column);
    }
  });
}

template <class Store>
void zero_row(Store& store, std::int32_t row, LocalColumns which) {
  for_each_local_column(store, which, [row](auto& column) { column[row] = {}; });
}

}  // namespace scree
