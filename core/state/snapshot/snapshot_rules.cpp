// Checks columns from outside by the rules of the state table. What else a world takes for granted of them is
// checked in snapshot_check.cpp, which counts on these rules.
#include <core/state/snapshot/absent_rows.h>
#include <core/state/snapshot/saved_columns.h>
#include <core/state/snapshot/snapshot_refusal.h>
#include <core/world/check.h>

#include <array>
#include <limits>
#include <type_traits>

namespace scree {

namespace {

constexpr std::size_t kMostRows = std::numeric_limits<std::int32_t>::max();

using RowsOfSheets = std::array<std::size_t, kSheetCount>;

std::size_t rows_of(const RowsOfSheets& rows, SheetId sheet) {
  return sheet != SheetId::none ? rows[static_cast<std::size_t>(sheet)] : 0;
}

bool has_right_count(const Member& member, const SavedColumn& column, const RowsOfSheets& rows,
                     std::size_t contacts) {
  if (member.is.counts) return column.rows <= kMostRows;
  if (member.form == MemberForm::rows) {
    if (is_of_contacts(member.sheet)) return column.rows == contacts;
    return column.rows == rows_of(rows, member.rows) || (member.is.or_none && column.rows == 0);
  }
  if (member.is.all_or_none != SheetId::none) {
    return column.rows == rows_of(rows, member.is.all_or_none) || column.rows == 0;
  }
  return column.rows <=
         (member.is.each_once != SheetId::none ? rows_of(rows, member.is.each_once) : kMostRows);
}

// What the rules of rows look at.
struct Stores {
  const WorldData& data;
  bool is_part;
  RowsOfSheets rows{};
  std::array<const std::uint8_t*, kSheetCount> flags{};  // of stores of what lives

  Stores(const WorldData& of, bool is_of_part) : data(of), is_part(is_of_part) {
    for_each_column_member(data, [this](const Member& member, const auto& column) {
      if (member.form != MemberForm::rows || member.rows == SheetId::none) return;
      const auto sheet = static_cast<std::size_t>(member.rows);
      if (member.is.counts) rows[sheet] = column.size();
      if constexpr (std::is_same_v<decltype(column), const Column<std::uint8_t>&>) {
        if (member.is.tells_life) flags[sheet] = column.data();
      }
    });
  }
  // Null for lists and stores of other things, which have no dead.
  const std::uint8_t* flags_of(const Member& member) const {
    return member.rows != SheetId::none ? flags[static_cast<std::size_t>(member.rows)] : nullptr;
  }
};

template <class Row>
concept Number = std::is_integral_v<Row> || std::is_enum_v<Row>;

bool is_row(std::int32_t value, const ValueRule& rule, const Stores& stores) {
  const bool is_named = value == rule.other_row || value >= rule.first_row;
  return is_named && at(value) < rows_of(stores.rows, rule.sheet);
}

// Calls check(fits), where fits(row, alive) tells whether a row is as the rule says. A rule for rows of
// another type is an error of the table: nothing fits.
template <class Row, class Check>
void with_rule(const ValueRule& rule, const Stores& stores, Check&& check) {
  using What = ValueRule::What;
  if constexpr (sizeof(Row) % sizeof(float) == 0) {
    if (rule.what == What::finite)
      return check([](const Row& row, bool alive) { return !alive || is_finite_row(row); });
  }
  if constexpr (std::is_same_v<Row, PoseRow>) {
    if (rule.what == What::placement)
      return check([](const Row& row, bool alive) { return !alive || is_placed(row); });
  }
  if constexpr (std::is_same_v<Row, float>) {
    if (rule.what == What::within) {
      return check([&](float row, bool alive) { return !alive || (row >= rule.low && row <= rule.high); });
    }
  }
  if constexpr (Number<Row>) {
    const auto number = [](Row row) { return static_cast<std::uint32_t>(row); };
    if (rule.what == What::at_most) return check([&](Row row, bool) { return number(row) <= rule.most; });
    if (rule.what == What::flags) {
      return check(
          [&](Row row, bool alive) { return (number(row) & ~(alive ? rule.most : rule.of_dead)) == 0; });
    }
    if (rule.what == What::not_zero)
      return check([&](Row row, bool alive) { return !alive || number(row) != 0; });
  }
  if constexpr (std::is_same_v<Row, std::int32_t>) {
    if (rule.what == What::row_of) return check([&](Row row, bool) { return is_row(row, rule, stores); });
  }
  if constexpr (std::is_same_v<Row, JointBodies>) {
    if (rule.what == What::row_of) {
      return check([&](Row row, bool) { return is_row(row.a, rule, stores) && is_row(row.b, rule, stores); });
    }
  }
  if constexpr (std::is_same_v<Row, SlotName>) {
    if (rule.what == What::handle_of) {
      return check([&](Row row, bool) { return row.index < rows_of(stores.rows, rule.sheet); });
    }
  }
  check([](const Row&, bool) { return false; });
}

template <class Row>
bool is_value(const Row& row, std::int64_t value) {
  if constexpr (Number<Row>) return static_cast<std::int64_t>(row) == value;
  return false;
}

template <class Row>
void check_rows(const Member& member, const Column<Row>& column, const Stores& stores,
                const Refusal& refusal) {
  const ValueRule& rule = member.is.rule;
  const DeadRule& dead = member.is.dead;
  const std::uint8_t* const flags = stores.flags_of(member);
  const bool may_be_absent = stores.is_part && is_of_present(member);
  const auto check = [&](const char* problem, auto&& fits) {
    for (std::size_t row = 0; row < column.size(); ++row) {
      if (may_be_absent && is_absent_row(stores.data, member.rows, row)) continue;
      const bool alive = flags == nullptr || (flags[row] & 1u) != 0;
      refusal.require(fits(column[row], alive), member.store, member.name, row, problem);
    }
  };
  for (std::size_t row = 0; may_be_absent && row < column.size(); ++row) {
    refusal.require(!is_absent_row(stores.data, member.rows, row) || is_zero_row(column[row]), member.store,
                    member.name, row, "is of a body that is absent, and not zero");
  }
  if (rule.what != ValueRule::What::any) {
    with_rule<Row>(rule, stores, [&](auto&& fits) { check(rule.problem, fits); });
  }
  if (dead.problem != nullptr) {
    check(dead.problem, [&](const Row& row, bool alive) { return alive || is_value(row, dead.value); });
  }
}

}  // namespace

void check_counts(const PackedColumns& packed, std::size_t hulls, std::size_t meshes,
                  const SavedColumns& saved, const Refusal& refusal) {
  RowsOfSheets rows{};
  rows[static_cast<std::size_t>(SheetId::hulls)] = hulls;  // which are no columns
  rows[static_cast<std::size_t>(SheetId::meshes)] = meshes;
  const SavedColumn* column = saved.column.data();
  for_each_saved_column(empty_table(), [&](const Member& member, const auto&) {
    if (member.is.counts) rows[static_cast<std::size_t>(member.rows)] = column->rows;
    ++column;
  });
  column = saved.column.data();
  for_each_saved_column(empty_table(), [&](const Member& member, const auto&) {
    refusal.require(has_right_count(member, *column++, rows, packed.contacts.size()), member.store,
                    member.name, 0, "wrong number of rows");
  });
}

void check_rules(const WorldData& data, bool is_part, const Refusal& refusal) {
  Stores stores(data, is_part);
  stores.rows[static_cast<std::size_t>(SheetId::hulls)] = data.hulls.shared.size();
  stores.rows[static_cast<std::size_t>(SheetId::meshes)] = data.meshes.shared.size();
  for_each_column_member(data, [&](const Member& member, const auto& column) {
    if (member.sheet == SheetId::none) return;
    check_rows(member, column, stores, refusal);
    using Row = std::remove_cvref_t<decltype(column[0])>;
    if constexpr (std::is_same_v<Row, std::int32_t> || std::is_same_v<Row, SlotName>) {
      if (member.is.each_once != SheetId::none) {
        check_each_once(column, rows_of(stores.rows, member.is.each_once), member.store, member.name,
                        refusal);
      }
    }
  });
}

void check_values(const Call& call, const SavedWorld& world) {
  SavedWorld::visit_members(world, TablePlace{"world"}, [&call](const Member& member, const auto& value) {
    if constexpr (std::is_same_v<decltype(value), const float&>) {
      const ValueRule& rule = member.is.rule;
      if (rule.what == ValueRule::What::within) check_range(call, member.name, value, rule.low, rule.high);
    }
  });
}

}  // namespace scree
