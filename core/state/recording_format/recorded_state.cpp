// See recorded_state.h.
#include <core/state/recording_format/recorded_state.h>
#include <core/state/snapshot/snapshot_columns.h>
#include <core/state/snapshot/snapshot_hulls.h>
#include <core/state/snapshot/snapshot_meshes.h>
#include <core/world/fp_environment.h>

namespace scree {

void write_state(const SnapshotData& snapshot, const SlotNumbers& numbers, ByteWriter& writer) {
  Column<std::byte> columns;
  pack_columns(snapshot.pages->sheets, columns);
  writer.reserve(writer.size() + columns.size() + 4096);
  writer.put(hash_of_state(snapshot.world, columns));
  write_world(snapshot.world, writer);
  write_slots(snapshot.hulls, numbers.hulls, writer);
  write_mesh_slots(numbers.meshes, writer);
  write_columns(columns, writer);
}

Snapshot read_state(std::span<const std::byte> bytes, const SolidViews& solids, bool is_part) {
  const FpEnvironment environment;
  ByteReader reader(bytes, "the state");
  Snapshot snapshot;
  SnapshotAccess::data(snapshot) = std::make_unique<SnapshotData>();
  SnapshotData& data = *SnapshotAccess::data(snapshot);
  data.is_part = is_part;
  const auto hash = reader.take<std::uint64_t>();
  read_world(reader, data.world);
  data.hulls = read_slots(reader, solids.hulls);
  data.meshes = read_mesh_slots(reader, solids.meshes);
  read_columns(reader, data);
  if (hash_of_state(data) != hash) refuse_bytes(0, "the hash of the state is wrong");
  data.is_full = true;
  return snapshot;
}

std::uint64_t recorded_state_hash(std::span<const std::byte> bytes) {
  return ByteReader(bytes, "the state").take<std::uint64_t>();
}

}  // namespace scree
