// See recorded_state.h.
#include <core/fp_environment.h>
#include <core/recorded_state.h>

namespace scree {

void write_state(const SnapshotData& snapshot, const std::vector<std::int32_t>& numbers, ByteWriter& writer) {
  writer.reserve(writer.size() + snapshot.columns.size() + 4096);
  writer.put(hash_of_state(snapshot));
  write_world(snapshot.world, writer);
  write_slots(snapshot.hulls, numbers, writer);
  write_columns(snapshot, writer);
}

Snapshot read_state(std::span<const std::byte> bytes, std::span<const SolidPointer> solids) {
  const FpEnvironment environment;
  ByteReader reader(bytes, "the state");
  Snapshot snapshot;
  SnapshotAccess::data(snapshot) = std::make_unique<SnapshotData>();
  SnapshotData& data = *SnapshotAccess::data(snapshot);
  const auto hash = reader.take<std::uint64_t>();
  read_world(reader, data.world);
  data.hulls = read_slots(reader, solids);
  read_columns(reader, data);
  if (hash_of_state(data) != hash) refuse_bytes(0, "the hash of the state is wrong");
  data.id = next_snapshot_id();
  data.is_full = true;
  return snapshot;
}

std::uint64_t recorded_state_hash(std::span<const std::byte> bytes) {
  return ByteReader(bytes, "the state").take<std::uint64_t>();
}

}  // namespace scree
