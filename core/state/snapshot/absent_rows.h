// Snapshots of a part of a world that many processes share: what the part has of bodies that are elsewhere.
// Such bodies are dynamic, and those of their rows' columns that are not on all ranks are zero, as are those
// of their shapes' rows. See SnapshotData::is_part.
#pragma once

#include <core/world/table.h>
#include <core/world/world_data.h>

#include <cstddef>
#include <cstring>

namespace scree {

// All bytes, whatever a new row would be.
template <class Row>
bool is_zero_row(const Row& row) {
  static constexpr std::byte kZero[sizeof(Row)] = {};
  return std::memcmp(&row, kZero, sizeof(Row)) == 0;
}

// Of columns whose rows are where the body is.
constexpr bool is_of_present(const Member& member) {
  return member.form == MemberForm::rows && !member.is.on_all_ranks &&
         (member.rows == SheetId::bodies || member.rows == SheetId::shapes);
}

// Whether the row of a body or a shape is that of an absent body. The shape's body must be in range.
inline bool is_absent_row(const WorldData& data, SheetId rows, std::size_t row) {
  if (rows == SheetId::bodies) return data.bodies.is_absent[row] != 0;
  return (data.shapes.flags[row] & kShapeAlive) != 0 && is_absent(data.bodies, data.shapes.body[row]);
}

// Absent are those whose pose is none. -> Bodies::is_absent, in which the others are zero already.
inline void find_absent_bodies(Bodies& bodies) {
  for (std::size_t row = kFirstBody; row < bodies.flags.size(); ++row) {
    const bool may_be = (bodies.flags[row] & kBodyAlive) != 0 && bodies.type[row] == BodyType::dynamic;
    if (may_be && is_zero_row(bodies.pose[row])) bodies.is_absent[row] = 1;
  }
}

}  // namespace scree
