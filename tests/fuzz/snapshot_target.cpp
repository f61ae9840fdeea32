// The reader of snapshots as a target.
#include <scree/scree.h>
#include <tests/fuzz/laws.h>
#include <tests/fuzz/memory_watch.h>

#include <optional>

namespace scree::fuzz {

namespace {

constexpr float kDt = 1.0f / 60.0f;
constexpr int kStepsOfSnapshot = 3;
// Larger worlds are only restored: a step of many shapes in one place takes seconds with sanitizers.
constexpr std::size_t kMostSteppedShapesOfSnapshot = 64;

std::optional<Snapshot> read(std::span<const std::byte> bytes) {
  const MemoryWatch memory;
  std::optional<Snapshot> snapshot;
  try {
    snapshot = read_snapshot(bytes);
  } catch (const Error& error) {
    require(names_offset(error.what(), "read_snapshot: byte ", ": ", bytes.size()),
            std::string("a refusal without an offset: ") + error.what());
  }
  memory.require_within(kSnapshotBound, bytes.size(), "read_snapshot");
  return snapshot;
}

}  // namespace

void snapshot_target(Input input) {
  const std::optional<Snapshot> snapshot = read(std::as_bytes(input));
  if (!snapshot) return;
  // Equal hulls are written once, even if the bytes held them twice: from the second time on nothing changes.
  const std::vector<std::byte> bytes = write_snapshot(*snapshot);
  require(bytes.size() <= input.size(), "a snapshot grows when it is read and written");
  require(write_snapshot(read_snapshot(bytes)) == bytes, "a snapshot changes when it is read and written");
  const MemoryWatch memory;
  World world;
  restore(world, *snapshot);
  memory.require_within(kRestoreBound, input.size(), "restore");
  require(world.stats().step == snapshot->step(), "the step counter is another");
  require_laws_of_snapshots(world);
  if (world.shape_count() <= kMostSteppedShapesOfSnapshot)
    require_laws_of_steps(world, kDt, kStepsOfSnapshot);
}

}  // namespace scree::fuzz
