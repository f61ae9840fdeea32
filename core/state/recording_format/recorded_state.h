// The state of a world as a recording holds it: a snapshot whose hulls and meshes are numbers.
//
//   u64      hash_of_state()
//   ...      the fields of SavedWorld
//   u32      number of slots of hulls, and these: see snapshot_hulls.h
//   u32      number of slots of meshes, and these: see snapshot_meshes.h
//   u64      number of the bytes that follow, to the end: snapshot_columns.h
#pragma once

#include <core/state/snapshot/snapshot_bytes.h>
#include <core/state/snapshot/snapshot_solids.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace scree {

// `numbers` as from SolidList::numbers_of.
void write_state(const SnapshotData& snapshot, const SlotNumbers& numbers, ByteWriter& writer);
// Throws RefusedBytes for what no world could go on from. `is_part`: see SnapshotData.
Snapshot read_state(std::span<const std::byte> bytes, const SolidViews& solids, bool is_part = false);
// Of bytes as write_state makes them.
std::uint64_t recorded_state_hash(std::span<const std::byte> bytes);

}  // namespace scree
