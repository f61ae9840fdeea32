// What a world takes for granted of its columns, checked where they come from outside.
#pragma once

#include <core/state/snapshot/snapshot_columns.h>

#include <cstddef>
#include <vector>

namespace scree {

// Refuses columns that a world could not step with, lists the contacts and finds the columns. `offset` is
// that of the columns among the bytes that were read.
SavedColumns check_columns(PackedColumns& packed, const SnapshotData& snapshot, std::size_t offset);

}  // namespace scree
