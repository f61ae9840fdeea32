// How the state table is declared: a list names each member of a store or of a stage's part once, with its
// kind, type, name and whatever else is known of it. The struct itself, its resizing and forgetting, and all
// that walks the table are made from that list; a member that stands in no list cannot exist.
//
// A list takes five macros, one for each form of member:
//   ROWS  (kind, Row, name, attributes...)               a column with a row for each item of the store
//   LIST  (kind, Row, name, attributes...)               a column with a length of its own
//   VALUE (kind, Type, name, initial, attributes...)     anything that can be assigned
//   TABLE (kind, Type, name, store, sheets...)           another store, or an array of stores or of columns,
//                                                        whose members are no nearer to the state than `kind`
//   OTHER (kind, Type, name)                             dealt with by hand: only its bytes are reported
// The attributes are the constants and functions below.
#pragma once

#include <core/plain/assert.h>
#include <core/state/snapshot/change_marks.h>
#include <core/world/column.h>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

namespace scree {

enum class MemberForm : std::uint8_t { rows, list, value, other };

// What a row must be that comes from outside. Rows of what is dead are looked at only where the rule says so.
struct ValueRule {
  enum class What : std::uint8_t {
    any,
    finite,
    placement,
    within,
    at_most,
    flags,
    not_zero,
    row_of,
    handle_of
  };
  What what = What::any;
  const char* problem = nullptr;
  float low = 0.0f, high = 0.0f;              // within
  std::uint32_t most = 0;                     // at_most; flags of what is alive
  std::uint32_t of_dead = 0;                  // flags of what is dead
  SheetId sheet = SheetId::none;              // row_of, handle_of
  std::int32_t first_row = 0, other_row = 0;  // row_of: from the first one on, or this one
};

// What a row of something dead must be.
struct DeadRule {
  const char* problem = nullptr;  // null: anything
  std::int64_t value = 0;
};

struct Attributes {
  SheetId sheet = SheetId::none;        // of a list: where it is saved
  SheetId each_once = SheetId::none;    // a list that holds rows of this sheet, each once at most
  SheetId all_or_none = SheetId::none;  // has as many rows as this sheet, or none
  bool apart = false;                   // saved in the second sheet of its store
  bool kept = false;                    // derived, but saved: takes longer to make than to copy
  bool hashed = false;
  bool varied = false;          // rows hardly ever equal, so that saving does not look whether they are
  bool counts = false;          // has as many rows as the store
  bool tells_life = false;      // its lowest bit is 1 for what is alive
  bool tells_presence = false;  // zero in free rows, which are not saved
  bool or_none = false;         // has as many rows as the store, or none
  bool event = false;           // what the last step reports to the caller
  // Of rows of bodies and shapes in a world of many ranks: each rank has them, even of what is absent there.
  bool on_all_ranks = false;
  bool travels = false;  // scratch that goes along with what comes to another rank, as state does
  ValueRule rule;
  DeadRule dead;
};

template <class... Each>
constexpr Attributes attributes(Each... each) {
  Attributes all;
  (each(all), ...);
  return all;
}
inline constexpr Attributes kNoAttributes{};

// clang-format off
inline constexpr auto kApart  = [](Attributes& is) { is.apart = true; };
inline constexpr auto kKept   = [](Attributes& is) { is.kept = true; };
inline constexpr auto kHashed = [](Attributes& is) { is.hashed = true; };
inline constexpr auto kVaried = [](Attributes& is) { is.varied = true; };
inline constexpr auto kCounts = [](Attributes& is) { is.counts = true; };
inline constexpr auto kOrNone = [](Attributes& is) { is.or_none = true; };
inline constexpr auto kEvent  = [](Attributes& is) { is.event = true; };
inline constexpr auto kOnAllRanks = [](Attributes& is) { is.on_all_ranks = true; };
inline constexpr auto kTravels    = [](Attributes& is) { is.travels = true; };
inline constexpr auto kTellsLife     = [](Attributes& is) { is.tells_life = is.counts = true; };
inline constexpr auto kTellsPresence = [](Attributes& is) { is.tells_presence = is.counts = true; };
// clang-format on
constexpr auto saved_in(SheetId sheet) {
  return [sheet](Attributes& is) { is.sheet = sheet; };
}
// Calls count on room for all of them.
constexpr auto each_once(SheetId sheet) {
  return [sheet](Attributes& is) { is.each_once = sheet; };
}
constexpr auto all_or_none(SheetId sheet) {
  return [sheet](Attributes& is) { is.all_or_none = sheet; };
}

// Rules of the living.
inline constexpr auto kFinite = [](Attributes& is) {
  is.rule = {.what = ValueRule::What::finite, .problem = "is not finite"};
};
inline constexpr auto kPlacement = [](Attributes& is) {
  is.rule = {.what = ValueRule::What::placement, .problem = "is no placement"};
};
constexpr auto within_limits(float low, float high) {
  return [=](Attributes& is) {
    is.rule = {.what = ValueRule::What::within, .problem = "is out of range", .low = low, .high = high};
  };
}
inline constexpr auto kNotNegative = within_limits(0.0f, std::numeric_limits<float>::max());
constexpr auto not_zero(const char* problem) {
  return [=](Attributes& is) { is.rule = {.what = ValueRule::What::not_zero, .problem = problem}; };
}
constexpr auto mask(std::uint32_t known, const char* problem) {
  return [=](Attributes& is) {
    is.rule = {.what = ValueRule::What::flags, .problem = problem, .most = known, .of_dead = ~0u};
  };
}
// Rules of all rows.
constexpr auto known_flags(std::uint32_t of_living, std::uint32_t of_dead) {
  return [=](Attributes& is) {
    is.rule = {
        .what = ValueRule::What::flags, .problem = "cannot be set", .most = of_living, .of_dead = of_dead};
  };
}
template <class Enum>
constexpr auto at_most(Enum last, const char* problem) {
  return [=](Attributes& is) {
    is.rule = {
        .what = ValueRule::What::at_most, .problem = problem, .most = static_cast<std::uint32_t>(last)};
  };
}
constexpr auto row_of(SheetId sheet, std::int32_t first, std::int32_t other, const char* problem) {
  return [=](Attributes& is) {
    is.rule = {.what = ValueRule::What::row_of,
               .problem = problem,
               .sheet = sheet,
               .first_row = first,
               .other_row = other};
  };
}
constexpr auto handle_of(SheetId sheet, const char* problem) {
  return [=](Attributes& is) {
    is.rule = {.what = ValueRule::What::handle_of, .problem = problem, .sheet = sheet};
  };
}
// A rule of the dead, beside that of the living.
template <class Value>
constexpr auto if_dead(Value value, const char* problem) {
  return [=](Attributes& is) { is.dead = {problem, static_cast<std::int64_t>(value)}; };
}

// A member as walks over the table meet it.
struct Member {
  ColumnKind kind;
  MemberForm form;
  const char* store;
  const char* name;
  const Attributes& is;           // of the table, so it stays
  SheetId sheet = SheetId::none;  // where it is saved
  SheetId rows = SheetId::none;   // of rows: the first sheet of the store, where that is saved
};

// Where a store stands in the table.
struct TablePlace {
  const char* store = "";
  ColumnKind kind = ColumnKind::state;
  SheetId rows = SheetId::none, apart = SheetId::none;
};

constexpr ColumnKind farther(ColumnKind a, ColumnKind b) { return a > b ? a : b; }

constexpr TablePlace inner_place(const TablePlace& outer, ColumnKind kind, const char* store,
                                 SheetId rows = SheetId::none, SheetId apart = SheetId::none) {
  return {store, farther(outer.kind, kind), rows, apart};
}

constexpr Member member_of(const TablePlace& place, MemberForm form, ColumnKind kind, const char* name,
                           const Attributes& is) {
  Member member{farther(place.kind, kind), form, place.store, name, is};
  const bool saved = member.kind == ColumnKind::state || is.kept;
  if (form == MemberForm::rows) {
    member.rows = place.rows;
    if (saved) member.sheet = is.apart ? place.apart : place.rows;
  } else if (form == MemberForm::list && saved) {
    member.sheet = is.sheet;
  }
  return member;
}

// An array of stores or of columns that any integers and enumerators index.
template <class Item, std::size_t kCount>
struct TableArray : std::array<Item, kCount> {
  Item& operator[](std::convertible_to<std::size_t> auto index) { return *(this->begin() + checked(index)); }
  const Item& operator[](std::convertible_to<std::size_t> auto index) const {
    return *(this->begin() + checked(index));
  }

 private:
  static std::size_t checked(std::convertible_to<std::size_t> auto index) {
    const auto place = static_cast<std::size_t>(index);
    SCREE_ASSERT(place < kCount);
    return place;
  }
};

template <class T>
inline constexpr bool kIsColumn = false;
template <class Row>
inline constexpr bool kIsColumn<Column<Row>> = true;
template <>
inline constexpr bool kIsColumn<PageMarks> = true;

template <class T>
concept Table = requires {
  typename std::remove_const_t<T>::IsTable;
};

// Walks a store, or all of an array of stores or columns.
template <class Inner, class Visit>
void visit_table(Inner& inner, const TablePlace& place, const char* name, Visit& visit) {
  if constexpr (Table<Inner>) {
    std::remove_const_t<Inner>::visit_members(inner, place, visit);
  } else if constexpr (kIsColumn<std::remove_const_t<Inner>>) {
    visit(member_of(place, MemberForm::list, place.kind, name, kNoAttributes), inner);
  } else {
    for (auto& each : inner) visit_table(each, place, name, visit);
  }
}

// Empties it; the memory stays.
template <class Inner>
void forget_table(Inner& inner, ColumnKind kind) noexcept {
  if constexpr (Table<Inner>) {
    inner.forget(kind);
  } else if constexpr (kIsColumn<Inner>) {
    if (kind != ColumnKind::state) inner.clear();
  } else {
    for (auto& each : inner) forget_table(each, kind);
  }
}

// --- what a list becomes ---

#define SCREE_NOTHING(...)

#define SCREE_DECLARE_ROWS(kind, Row, name, ...) Column<Row> name;
#define SCREE_DECLARE_LIST(kind, Row, name, ...) Column<Row> name;
#define SCREE_DECLARE_VALUE(kind, Type, name, initial, ...) Type name = initial;
#define SCREE_DECLARE_TABLE(kind, Type, name, ...) Type name;
#define SCREE_DECLARE_OTHER(kind, Type, name) Type name;

#define SCREE_CHECK_LIST(kind, Row, name, ...)                                                           \
  static_assert(ColumnKind::kind != ColumnKind::state || attributes(__VA_ARGS__).sheet != SheetId::none, \
                "a list that is state must be saved in some sheet");

#define SCREE_VISIT_MEMBER(form, kind, name, ...)                                       \
  {                                                                                     \
    static constexpr Attributes kIs = attributes(__VA_ARGS__);                          \
    visit(member_of(place, MemberForm::form, ColumnKind::kind, #name, kIs), self.name); \
  }
#define SCREE_VISIT_ROWS(kind, Row, name, ...) SCREE_VISIT_MEMBER(rows, kind, name __VA_OPT__(, ) __VA_ARGS__)
#define SCREE_VISIT_LIST(kind, Row, name, ...) SCREE_VISIT_MEMBER(list, kind, name __VA_OPT__(, ) __VA_ARGS__)
#define SCREE_VISIT_VALUE(kind, Type, name, initial, ...) \
  SCREE_VISIT_MEMBER(value, kind, name __VA_OPT__(, ) __VA_ARGS__)
#define SCREE_VISIT_TABLE(kind, Type, name, ...) \
  visit_table(self.name, inner_place(place, ColumnKind::kind, __VA_ARGS__), #name, visit);
#define SCREE_VISIT_OTHER(kind, Type, name) SCREE_VISIT_MEMBER(other, kind, name)

#define SCREE_RESIZE_ROWS(kind, Row, name, ...) name.resize(count);

#define SCREE_FORGET_ROWS(kind, Row, name, ...) \
  if (outer != ColumnKind::state) name.clear();
#define SCREE_FORGET_LIST(kind, Row, name, ...) \
  if (farther(outer, ColumnKind::kind) != ColumnKind::state) name.clear();
#define SCREE_FORGET_VALUE(kind, Type, name, initial, ...) \
  if (farther(outer, ColumnKind::kind) != ColumnKind::state) name = initial;
#define SCREE_FORGET_TABLE(kind, Type, name, ...) forget_table(name, farther(outer, ColumnKind::kind));

// The members of a list, the walk over them with visit(Member, member), the resizing of its rows, and what
// becomes of it when the world is replaced: what is not state is emptied and gets its initial values, except
// rows of a store that is state, which stay as many as they are.
#define SCREE_TABLE_OF(MEMBERS)                                                                          \
  MEMBERS(SCREE_DECLARE_ROWS, SCREE_DECLARE_LIST, SCREE_DECLARE_VALUE, SCREE_DECLARE_TABLE,              \
          SCREE_DECLARE_OTHER)                                                                           \
  MEMBERS(SCREE_NOTHING, SCREE_CHECK_LIST, SCREE_NOTHING, SCREE_NOTHING, SCREE_NOTHING)                  \
  using IsTable = void;                                                                                  \
  template <class Self, class Visit>                                                                     \
  static void visit_members([[maybe_unused]] Self& self, [[maybe_unused]] const TablePlace& place,       \
                            Visit&& visit) {                                                             \
    MEMBERS(SCREE_VISIT_ROWS, SCREE_VISIT_LIST, SCREE_VISIT_VALUE, SCREE_VISIT_TABLE, SCREE_VISIT_OTHER) \
  }                                                                                                      \
  void resize([[maybe_unused]] std::size_t count) {                                                      \
    MEMBERS(SCREE_RESIZE_ROWS, SCREE_NOTHING, SCREE_NOTHING, SCREE_NOTHING, SCREE_NOTHING)               \
  }                                                                                                      \
  void forget([[maybe_unused]] ColumnKind outer) noexcept {                                              \
    MEMBERS(SCREE_FORGET_ROWS, SCREE_FORGET_LIST, SCREE_FORGET_VALUE, SCREE_FORGET_TABLE, SCREE_NOTHING) \
  }

#define SCREE_VALUE_IF_state(...) __VA_ARGS__
#define SCREE_VALUE_IF_derived(...)
#define SCREE_VALUE_IF_scratch(...)
#define SCREE_DECLARE_SAVED(kind, Type, name, initial, ...) SCREE_VALUE_IF_##kind(Type name = initial;)
#define SCREE_DECLARE_SAVED_TABLE(kind, Type, name, ...) SCREE_VALUE_IF_##kind(Type::Values name;)
#define SCREE_VISIT_SAVED(kind, Type, name, initial, ...) \
  SCREE_VALUE_IF_##kind(SCREE_VISIT_VALUE(kind, Type, name, initial __VA_OPT__(, ) __VA_ARGS__))
#define SCREE_VISIT_SAVED_TABLE(kind, Type, name, ...) \
  SCREE_VALUE_IF_##kind(SCREE_VISIT_TABLE(kind, Type, name, __VA_ARGS__))
#define SCREE_SAVE_VALUE(kind, Type, name, initial, ...) SCREE_VALUE_IF_##kind(to.name = name;)
#define SCREE_SAVE_TABLE(kind, Type, name, ...) SCREE_VALUE_IF_##kind(name.save_values(to.name);)
#define SCREE_LOAD_VALUE(kind, Type, name, initial, ...) SCREE_VALUE_IF_##kind(name = from.name;)
#define SCREE_LOAD_TABLE(kind, Type, name, ...) SCREE_VALUE_IF_##kind(name.load_values(from.name);)

// A store of a world. Its values of kind state are a struct of their own, too: what snapshots hold of it
// beside columns.
#define SCREE_STORE(Name, MEMBERS)                                                                         \
  struct Name {                                                                                            \
    SCREE_TABLE_OF(MEMBERS)                                                                                \
    struct Values {                                                                                        \
      MEMBERS(SCREE_NOTHING, SCREE_NOTHING, SCREE_DECLARE_SAVED, SCREE_DECLARE_SAVED_TABLE, SCREE_NOTHING) \
      using IsTable = void;                                                                                \
      template <class Self, class Visit>                                                                   \
      static void visit_members([[maybe_unused]] Self& self, [[maybe_unused]] const TablePlace& place,     \
                                [[maybe_unused]] Visit&& visit) {                                          \
        MEMBERS(SCREE_NOTHING, SCREE_NOTHING, SCREE_VISIT_SAVED, SCREE_VISIT_SAVED_TABLE, SCREE_NOTHING)   \
      }                                                                                                    \
    };                                                                                                     \
    void save_values([[maybe_unused]] Values& to) const {                                                  \
      MEMBERS(SCREE_NOTHING, SCREE_NOTHING, SCREE_SAVE_VALUE, SCREE_SAVE_TABLE, SCREE_NOTHING)             \
    }                                                                                                      \
    void load_values([[maybe_unused]] const Values& from) {                                                \
      MEMBERS(SCREE_NOTHING, SCREE_NOTHING, SCREE_LOAD_VALUE, SCREE_LOAD_TABLE, SCREE_NOTHING)             \
    }                                                                                                      \
    template <class Visitor>                                                                               \
    void for_each_column(Visitor&& visit) {                                                                \
      visit_members(*this, TablePlace{}, [&visit](const Member& member, auto& column) {                    \
        if constexpr (kIsColumn<std::remove_reference_t<decltype(column)>>) {                              \
          if (member.form == MemberForm::rows) visit(member.kind, member.name, column);                    \
        }                                                                                                  \
      });                                                                                                  \
    }                                                                                                      \
  };

#define SCREE_OR_STATE(kind, ...) || ColumnKind::kind == ColumnKind::state

// What only one stage looks into: no part of the state.
#define SCREE_PART(Name, MEMBERS)                                                                 \
  struct Name final : Part {                                                                      \
    SCREE_TABLE_OF(MEMBERS)                                                                       \
    static_assert(!(false MEMBERS(SCREE_OR_STATE, SCREE_OR_STATE, SCREE_OR_STATE, SCREE_OR_STATE, \
                                  SCREE_OR_STATE)),                                               \
                  "what is state belongs into a store, or no snapshot would hold it");            \
    void report(const char* store, const Visit& visit) const override {                           \
      report_members(*this, store, visit);                                                        \
    }                                                                                             \
    void forget() noexcept override { forget(ColumnKind::derived); }                              \
  };

}  // namespace scree
