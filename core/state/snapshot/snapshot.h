// What is inside a snapshot: the state columns of a world in pages, which snapshots of the same world share
// as far as they are equal, and what the world has besides. snapshot_sheets.cpp saves and loads the columns,
// snapshot_columns.cpp packs them one behind the other, snapshot_bytes.cpp writes and reads that,
// snapshot_check.cpp checks it, snapshot_changes.cpp compares.
#pragma once

#include <core/state/snapshot/snapshot_sheets.h>
#include <core/world/world_data.h>
#include <scree/snapshot.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace scree {

// The state that stands in no column.
using SavedWorld = WorldData::Values;

struct SnapshotData {
  bool is_full = false;          // holds a world
  bool is_part = false;          // of which bodies may be absent: see absent_rows.h. No user gets it
  std::uint64_t id = 0;          // another one for each content, in this process
  std::uint32_t handle_tag = 0;  // of the world that was saved; 0: of none, read from bytes
  SavedWorld world;
  std::shared_ptr<SavedPages> pages = std::make_shared<SavedPages>();
  Sheets used;                    // scratch: what the pages were before
  std::vector<SharedHull> hulls;  // by slot
  std::vector<SharedMesh> meshes;

  SnapshotData() = default;
  SnapshotData(const SnapshotData&) = delete;
  SnapshotData& operator=(const SnapshotData&) = delete;
  ~SnapshotData();  // worlds may know the pages for longer: they go now
};

// A page of the later snapshot.
struct KeptPage {
  SheetId sheet;
  std::uint32_t number;
  PageOwner page;
};

struct SnapshotChangesData {
  bool is_full = false;
  std::uint64_t base = 0;  // its id
  std::uint32_t handle_tag = 0;
  SavedWorld world;
  std::array<std::size_t, kSheetCount> rows{};
  std::vector<KeptPage> pages;  // that are not those of the base; by sheet, ascending
  std::size_t page_bytes = 0;
  std::vector<SharedHull> hulls;
  std::vector<SharedMesh> meshes;
};

std::uint64_t next_snapshot_id();

// What is inside; null before the first save.
struct SnapshotAccess {
  static std::unique_ptr<SnapshotChangesData>& data(SnapshotChanges& changes) { return changes.data_; }
  static const SnapshotChangesData* data(const SnapshotChanges& changes) { return changes.data_.get(); }
  static std::unique_ptr<SnapshotData>& data(Snapshot& snapshot) { return snapshot.data_; }
  static const SnapshotData* data(const Snapshot& snapshot) { return snapshot.data_.get(); }
};

// Whether all slots have the same solids.
bool same_slots(const std::vector<SharedHull>& a, const std::vector<SharedHull>& b);
bool same_slots(const std::vector<SharedMesh>& a, const std::vector<SharedMesh>& b);
// What a snapshot or its changes hold of hulls and meshes, copied where it differs.
template <class To>
void copy_slots(const std::vector<SharedHull>& hulls, const std::vector<SharedMesh>& meshes, To& to) {
  if (!same_slots(to.hulls, hulls)) to.hulls = hulls;
  if (!same_slots(to.meshes, meshes)) to.meshes = meshes;
}
template <class Owner>
std::size_t bytes_of_slots(const Owner& owner) {
  return owner.hulls.size() * sizeof(SharedHull) + owner.meshes.size() * sizeof(SharedMesh);
}

// save() for code that has the data of a world only. Call place_matter() first: cores are saved. With
// `remember` false the world still measures changes from the save that it remembers.
void save_world(const WorldData& data, SnapshotData& snapshot, bool remember);

// Of a snapshot that holds a world; throws Error, which names the call.
const SnapshotData& filled(const Snapshot& snapshot, const char* call);

}  // namespace scree
