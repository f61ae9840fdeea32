// Saving, restoring and cloning worlds.
#include <core/geometry/hull/hull_build.h>
#include <core/geometry/mesh/mesh_build.h>
#include <core/state/snapshot/absent_rows.h>
#include <core/state/snapshot/snapshot.h>
#include <core/validate/validate.h>
#include <core/world/edit.h>
#include <core/world/fp_environment.h>
#include <core/world/resting_pairs.h>
#include <core/world/state_table.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <string>
#include <utility>

namespace scree {

namespace {

bool same_hull(const SharedHull& a, const SharedHull& b) {
  return a.solid == b.solid && HullAccess::solid(a.geometry.hull) == HullAccess::solid(b.geometry.hull) &&
         a.geometry.scale == b.geometry.scale && a.geometry.rounding == b.geometry.rounding;
}

bool same_mesh(const SharedMesh& a, const SharedMesh& b) { return a.solid == b.solid; }

std::uint64_t content_of(const SharedHull& shared) { return hull_content(shared.geometry); }
std::uint64_t content_of(const SharedMesh& shared) { return mesh_content(*shared.solid); }

// What Hulls and Meshes hold besides their columns.
template <class Shared>
struct SlotIndex {
  std::vector<Shared> shared;
  ContentSlots slot_of;

  explicit SlotIndex(const std::vector<Shared>& slots) : shared(slots) {
    for (std::size_t slot = 0; slot < shared.size(); ++slot) {
      if (shared[slot].solid == nullptr) continue;
      slot_of.emplace(content_of(shared[slot]), static_cast<std::int32_t>(slot));
    }
  }
  template <class Store>
  void swap_into(Store& store) noexcept {
    store.shared.swap(shared);
    store.slot_of.swap(slot_of);
  }
};

const HullData* data_of(const SharedHull& shared) { return shared.data.get(); }
const MeshData* data_of(const SharedMesh& shared) { return &shared.solid->data; }

template <class Store>
void derive_slots(Store& store) {
  for (std::size_t slot = 0; slot < store.shared.size(); ++slot)
    store.data[slot] = store.shared[slot].solid != nullptr ? data_of(store.shared[slot]) : nullptr;
}

// What follows makes what is derived of rows, and counts. Lists and values that are not state have been
// forgotten.

void derive_bodies(Bodies& bodies) {
  for (std::size_t row = 0; row < bodies.flags.size(); ++row) {
    if (bodies.is_absent[row] == 0)
      bodies.transform[row] = transform_of(bodies.pose[row], bodies.center[row]);
    bodies.is_changed[row] = 0;
    bodies.alive += (bodies.flags[row] & kBodyAlive) != 0 ? 1 : 0;
    bodies.asleep += (bodies.flags[row] & kBodyAsleep) != 0 ? 1 : 0;
  }
  std::fill(bodies.unplaced.begin(), bodies.unplaced.end(), std::uint8_t{0});
}

void derive_shapes(WorldData& data) {
  Shapes& shapes = data.shapes;
  shapes.waking_made.forget();
  shapes.queries_made.forget();
  for (std::int32_t& before : shapes.previous) before = -1;
  for (std::size_t row = 0; row < shapes.flags.size(); ++row) {
    shapes.is_changed[row] = 0;
    shapes.is_noted[row] = 0;
    const bool is_here = !is_absent_row(data, SheetId::shapes, row);
    if (is_here) shapes.motion[row] = motion_at_rest(shapes.pose[row]);
    if ((shapes.flags[row] & kShapeWakes) != 0) shapes.wakers.push_back(static_cast<std::int32_t>(row));
    if ((shapes.flags[row] & kShapeAlive) == 0) continue;
    ++shapes.alive;
    const std::int32_t behind = shapes.next[row];
    if (behind >= 0) shapes.previous[behind] = static_cast<std::int32_t>(row);
    if (shapes.events[row] != ContactEvents::none) ++shapes.asking;
    if (shapes.hooks[row] != ContactHooks::none) ++shapes.hooked;
    if ((shapes.flags[row] & kShapeSensor) != 0) ++shapes.sensors;
    if (is_here) place_shape_in_body(data, static_cast<std::int32_t>(row));
  }
}

// The contacts of a list learn their pairs. Returns how many there are.
std::int64_t name_pairs(const PairRows& pairs, ContactRows& contacts) {
  std::int64_t count = 0;
  for (std::size_t row = 0; row < pairs.pair.size(); ++row) {
    for (std::int32_t contact = pairs.contact[row]; contact >= 0; contact = next_contact(contacts, contact)) {
      contacts.pair[contact] = pairs.pair[row];
      ++count;
    }
  }
  return count;
}

void derive_contacts(WorldData& data) {
  Contacts& contacts = data.contacts;
  link_resting(data);
  name_pairs(contacts.pairs, contacts.now);
  contacts.resting_contacts = name_pairs(contacts.resting, contacts.now);
  contacts.by_shape_made.forget();
  contacts.resting_order_made.forget();
}

// The links back and the frames of joints, and where the numbers of user joints stand.
void derive_joints(WorldData& data) {
  Joints& joints = data.joints;
  for (std::size_t row = 0; row < joints.flags.size(); ++row) {
    joints.previous[row] = {-1, -1};
    joints.reaction[row] = {};
    joints.is_changed[row] = 0;
  }
  for (std::size_t row = 0; row < joints.flags.size(); ++row) {
    if ((joints.flags[row] & kJointAlive) == 0) continue;
    ++joints.alive;
    if ((joints.flags[row] & kJointReports) != 0) ++joints.reporting;
    place_joint(data, static_cast<std::int32_t>(row));
    link_back(data, static_cast<std::int32_t>(row));
  }
  const Column<std::int32_t>& users = data.user_joints.joint;
  for (std::size_t row = 0; row < users.size(); ++row)
    joints.user[users[row]] = static_cast<std::int32_t>(row);
}

void derive_events(Events& events) {
  events.resting_touches = std::count_if(events.resting.begin(), events.resting.end(),
                                         [](const TouchRow& row) { return row.events != 0; });
}

}  // namespace

bool same_slots(const std::vector<SharedHull>& a, const std::vector<SharedHull>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same_hull);
}
bool same_slots(const std::vector<SharedMesh>& a, const std::vector<SharedMesh>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same_mesh);
}

std::uint64_t next_snapshot_id() {
  static std::atomic<std::uint64_t> last{0};
  return last.fetch_add(1, std::memory_order_relaxed) + 1;
}

const SnapshotData& filled(const Snapshot& snapshot, const char* call) {
  if (snapshot.is_empty()) throw Error(std::string(call) + ": the snapshot is empty", ErrorCode::wrong_state);
  return *SnapshotAccess::data(snapshot);
}

Snapshot::Snapshot() noexcept = default;
Snapshot::~Snapshot() = default;
Snapshot::Snapshot(Snapshot&&) noexcept = default;
Snapshot& Snapshot::operator=(Snapshot&&) noexcept = default;

bool Snapshot::is_empty() const noexcept { return data_ == nullptr || !data_->is_full; }

std::size_t Snapshot::bytes() const noexcept {
  if (is_empty()) return 0;
  return sizeof *data_ + sizeof *data_->pages + data_->pages->sheets.bytes() + bytes_of_slots(*data_);
}

std::uint64_t Snapshot::step() const noexcept { return is_empty() ? 0 : data_->world.step_count; }

SnapshotData::~SnapshotData() {
  const std::lock_guard lock(pages->mutex);
  pages->id = 0;
  pages->sheets.clear();
}

void save_world(const WorldData& data, SnapshotData& snapshot, bool remember) {
  snapshot.is_full = snapshot.is_part = false;
  snapshot.handle_tag = data.handle_tags.given;
  data.save_values(snapshot.world);
  try {
    copy_slots(data.hulls.shared, data.meshes.shared, snapshot);
    save_sheets(const_cast<WorldData&>(data), snapshot, remember);  // of which it writes the marks only
  } catch (...) {
    drop_pages(snapshot);
    throw;
  }
  snapshot.is_full = true;
}

namespace {

void save(const World& world, Snapshot& snapshot, bool remember) {
  WorldData& data = internals(const_cast<World&>(world), "save");
  check_whole(data, "save");
  const std::lock_guard lock(data.saving);
  place_matter(data);  // changes nothing that the caller or another reading call could see
  std::unique_ptr<SnapshotData>& to = SnapshotAccess::data(snapshot);
  if (to == nullptr) to = std::make_unique<SnapshotData>();
  save_world(data, *to, remember);
}

}  // namespace

void save(const World& world, Snapshot& snapshot) { save(world, snapshot, true); }

void restore(World& world, const Snapshot& snapshot) {
  constexpr const char* kName = "restore";
  const SnapshotData& from = filled(snapshot, kName);
  WorldData& data = internals(world, kName);
  check_whole(data, kName);
  const Sheets& sheets = from.pages->sheets;
  reserve_columns(sheets, data);
  // Both are made before either is put into the world: what can fail comes first.
  const bool same_hulls = same_slots(from.hulls, data.hulls.shared);
  const bool same_meshes = same_slots(from.meshes, data.meshes.shared);
  SlotIndex<SharedHull> hulls(same_hulls ? SharedHulls{} : from.hulls);
  SlotIndex<SharedMesh> meshes(same_meshes ? SharedMeshes{} : from.meshes);
  if (!same_hulls) hulls.swap_into(data.hulls);
  if (!same_meshes) meshes.swap_into(data.meshes);
  // Nothing can fail from here on.
  const FpEnvironment environment;
  data.forget(ColumnKind::state);
  if (from.handle_tag != 0) data.handle_tags.given = from.handle_tag;
  load_sheets(sheets, data, from.is_part);
  if (from.is_part) find_absent_bodies(data.bodies);
  data.load_values(from.world);
  data.stats.step = data.step_count;
  derive_slots(data.hulls);
  derive_slots(data.meshes);
  derive_shapes(data);
  derive_bodies(data.bodies);
  derive_contacts(data);
  derive_joints(data);
  derive_events(data.events);
  for_each_part(data, [](const char*, Part& part) { part.forget(); });
  remember_saved(data, from);
  validate_stores(data);
  validate_pairs(data);
  if (data.recording.sink != nullptr) data.recording.sink->restored(data);
}

World clone(const World& world) {
  Snapshot snapshot;
  save(world, snapshot, false);
  World copy;
  restore(copy, snapshot);
  return copy;
}

}  // namespace scree
