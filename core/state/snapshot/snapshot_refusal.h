// Refusing columns from outside: which row is wrong, and where it stands among the bytes.
// Private to the checks of snapshots.
#pragma once

#include <core/state/snapshot/snapshot.h>
#include <core/state/snapshot/snapshot_bytes.h>
#include <core/state/snapshot/snapshot_columns.h>
#include <core/world/check.h>
#include <core/world/edit.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace scree {

inline std::size_t at(std::int32_t row) { return static_cast<std::size_t>(row); }

// Of a row that is no free one, among these.
inline std::size_t place_of_contact(const PackedColumns& packed, std::size_t row) {
  const Column<std::int32_t>& contacts = packed.contacts;
  const auto* place = std::lower_bound(contacts.begin(), contacts.end(), static_cast<std::int32_t>(row));
  return static_cast<std::size_t>(place - contacts.begin());
}

// Knows where among the bytes a row stands, and refuses it.
class Refusal {
 public:
  Refusal(const PackedColumns& packed, const SavedColumns& saved, std::size_t offset)
      : packed_(packed), saved_(saved), offset_(offset) {}

  void require(bool holds, const char* store, const char* name, std::size_t row, const char* problem) const {
    if (!holds) refuse(store, name, row, problem);
  }

 private:
  [[noreturn]] void refuse(const char* store, const char* name, std::size_t row, const char* problem) const {
    const SavedColumn& column = saved_.find(store, name);
    refuse_bytes(offset_ + column.begin + place_of(column, row),
                 std::string(store) + "." + name + ", row " + std::to_string(row) + ": " + problem);
  }

  std::size_t place_of(const SavedColumn& column, std::size_t row) const {
    switch (column.form) {
      case ColumnForm::plain:
        return row * column.row_bytes;
      case ColumnForm::contacts:
        return place_of_contact(packed_, row) * column.row_bytes;
      case ColumnForm::contact_blocks:
        row = place_of_contact(packed_, row);
        break;
      case ColumnForm::blocks:
        break;
    }
    const std::byte* flags = packed_.bytes.data() + column.begin;
    const std::size_t blocks = (column.rows + kSavedBlock - 1) / kSavedBlock, block = row / kSavedBlock;
    std::size_t packed = 0;
    for (std::size_t before = 0; before < std::min(block, blocks); ++before)
      packed += flags[before] != std::byte{0} ? 1 : kSavedBlock;
    if (block < blocks && flags[block] == std::byte{0}) packed += row % kSavedBlock;
    return blocks + packed * column.row_bytes;
  }

  const PackedColumns& packed_;
  const SavedColumns& saved_;
  const std::size_t offset_;
};

template <class Row>
bool is_finite_row(const Row& row) {
  float numbers[sizeof(Row) / sizeof(float)];
  static_assert(sizeof numbers == sizeof(Row));
  std::memcpy(numbers, &row, sizeof numbers);
  return std::all_of(std::begin(numbers), std::end(numbers), [](float x) { return std::isfinite(x); });
}

inline bool is_placed(const PoseRow& pose) { return is_finite_row(pose) && is_unit(to_quat(pose.rotation)); }

inline constexpr const char* kNotListable = "names a row that cannot be listed, or one twice";

inline std::size_t listed_row(std::int32_t row) { return at(row); }
inline std::size_t listed_row(const SlotName& name) { return name.index; }

// Each entry names one of so many rows, and none twice.
template <class Entry>
void check_each_once(const Column<Entry>& list, std::size_t rows, const char* store, const char* name,
                     const Refusal& refusal) {
  std::vector<bool> seen(rows);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::size_t row = listed_row(list[i]);  // below zero becomes the largest of all
    refusal.require(row < rows && !seen[row], store, name, i, kNotListable);
    seen[row] = true;
  }
}

// Each entry names a row that may be listed; after check_each_once.
template <class MayBeListed>
void check_listed(const Column<std::int32_t>& list, const char* store, const char* name,
                  const Refusal& refusal, MayBeListed&& may_be_listed) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    refusal.require(may_be_listed(at(list[i])), store, name, i, kNotListable);
  }
}

// The slots of a store that can be taken anew: of the dead ones all but those whose generations are used up.
// Each is listed, or it would be lost.
template <class Store, class IsAlive>
void check_free_slots(const Store& store, std::size_t first, const char* name, const Refusal& refusal,
                      IsAlive&& is_alive) {
  const std::size_t rows = store.generation.size();
  const auto is_free = [&](std::size_t row) {
    return row >= first && !is_alive(row) && store.generation[row] != 0;
  };
  check_listed(store.free_slots, name, "free_slots", refusal, is_free);
  std::size_t free = 0;
  for (std::size_t row = first; row < rows; ++row) free += is_free(row) ? 1 : 0;
  refusal.require(store.free_slots.size() == free, name, "free_slots", 0, "some free slot is not listed");
}

// The rules of the state table: numbers of rows, then the rows themselves, except those of contacts, which
// have none. The values of a snapshot throw Error, which names the call.
void check_counts(const PackedColumns& packed, std::size_t hulls, std::size_t meshes,
                  const SavedColumns& saved, const Refusal& refusal);
void check_rules(const WorldData& data, bool is_part, const Refusal& refusal);
void check_values(const Call& call, const SavedWorld& world);

// Checks the joints, whose bodies have been checked.
void check_joints(const WorldData& data, const Refusal& refusal);

}  // namespace scree
