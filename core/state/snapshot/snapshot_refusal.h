// Refusing columns from outside: which row is wrong, and where it stands among the bytes.
// Private to the checks of snapshots.
#pragma once

#include <core/state/snapshot/snapshot.h>
#include <core/state/snapshot/snapshot_bytes.h>
#include <core/state/snapshot/snapshot_columns.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
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

// Each entry names a row that may be listed, and none twice.
template <class MayBeListed>
void check_list(const Column<std::int32_t>& list, std::size_t rows, const char* store, const char* name,
                const Refusal& refusal, MayBeListed&& may_be_listed) {
  std::vector<bool> seen(rows);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const bool fits = list[i] >= 0 && at(list[i]) < rows && !seen[at(list[i])] && may_be_listed(at(list[i]));
    refusal.require(fits, store, name, i, "names a row that can not be listed, or one twice");
    seen[at(list[i])] = true;
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
  check_list(store.free_slots, rows, name, "free_slots", refusal, is_free);
  std::size_t free = 0;
  for (std::size_t row = first; row < rows; ++row) free += is_free(row) ? 1 : 0;
  refusal.require(store.free_slots.size() == free, name, "free_slots", 0, "some free slot is not listed");
}

// Checks the joints, whose bodies have been checked.
void check_joints(const WorldData& data, const Refusal& refusal);

}  // namespace scree
