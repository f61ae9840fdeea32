// What a world takes for granted of its columns, checked where they come from outside.
#pragma once

#include <core/snapshot.h>

#include <cstddef>

namespace scree {

// Refuses columns that a world could not step with, and lists the snapshot's contacts. `offset` is that of
// the columns among the bytes that were read.
void check_columns(SnapshotData& snapshot, std::size_t offset);

}  // namespace scree
