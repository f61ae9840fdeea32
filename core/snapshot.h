// What is inside a snapshot: the state columns of a world one behind the other, packed, and what the world
// has besides. snapshot_columns.cpp packs, snapshot_bytes.cpp writes and reads, snapshot_check.cpp checks,
// snapshot_changes.cpp compares.
#pragma once

#include <core/world_data.h>
#include <scree/snapshot.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace scree {

// The state that stands in no column.
struct SavedWorld {
  WorldSettings settings;
  std::uint64_t step_count = 0;
  float last_dt = 0.0f;
  float last_substep = 0.0f;
  bool wake_requested = false;
  bool manifolds_stale = false;
  bool pairs_stale = false;
};

struct SnapshotData {
  bool is_full = false;  // holds a world
  std::uint64_t id = 0;  // another one for each content, in this process
  SavedWorld world;
  Column<std::byte> columns;      // see snapshot_columns.h
  Column<std::int32_t> contacts;  // the rows of ContactRows that are no free ones, ascending
  std::vector<SharedHull> hulls;  // by slot
};

struct SnapshotChangesData {
  bool is_full = false;
  std::uint64_t base = 0;  // its id
  SavedWorld world;
  Column<std::byte> columns;  // see snapshot_changes.cpp
  std::vector<SharedHull> hulls;
};

std::uint64_t next_snapshot_id();

// What is inside; null before the first save.
struct SnapshotAccess {
  static std::unique_ptr<SnapshotChangesData>& data(SnapshotChanges& changes) { return changes.data_; }
  static const SnapshotChangesData* data(const SnapshotChanges& changes) { return changes.data_.get(); }
  static std::unique_ptr<SnapshotData>& data(Snapshot& snapshot) { return snapshot.data_; }
  static const SnapshotData* data(const Snapshot& snapshot) { return snapshot.data_.get(); }
};

bool same_hulls(const std::vector<SharedHull>& a, const std::vector<SharedHull>& b);  // of one geometry

// save() for those who have no World at hand, after place_matter(): cores are saved.
void save_world(const WorldData& data, SnapshotData& snapshot);

// Of a snapshot that holds a world; throws Error, which names the call.
const SnapshotData& filled(const Snapshot& snapshot, const char* call);

}  // namespace scree
