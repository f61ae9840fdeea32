// Saving, restoring and cloning worlds.
#include <core/geometry/hull/hull_build.h>
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
         a.geometry.scale == b.geometry.scale;
}

// What Hulls holds besides its columns.
struct HullIndex {
  std::vector<SharedHull> shared;
  std::unordered_multimap<std::uint64_t, std::int32_t> slot_of;

  explicit HullIndex(const std::vector<SharedHull>& hulls) : shared(hulls) {
    for (std::size_t slot = 0; slot < shared.size(); ++slot) {
      if (shared[slot].solid == nullptr) continue;
      slot_of.emplace(hull_content(shared[slot].geometry), static_cast<std::int32_t>(slot));
    }
  }
};

// What follows makes what is derived of rows, and counts. Lists and values that are not state have been
// forgotten.

void derive_bodies(Bodies& bodies) {
  for (std::size_t row = 0; row < bodies.flags.size(); ++row) {
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
  for (std::int32_t& before : shapes.previous) before = -1;
  for (std::size_t row = 0; row < shapes.flags.size(); ++row) {
    shapes.is_changed[row] = 0;
    if ((shapes.flags[row] & kShapeWakes) != 0) shapes.wakers.push_back(static_cast<std::int32_t>(row));
    if ((shapes.flags[row] & kShapeAlive) == 0) continue;
    ++shapes.alive;
    const std::int32_t behind = shapes.next[row];
    if (behind >= 0) shapes.previous[behind] = static_cast<std::int32_t>(row);
    if (shapes.events[row] != ContactEvents::none) ++shapes.asking;
    place_shape_in_body(data, static_cast<std::int32_t>(row));
  }
}

// The contacts of a list learn their pairs. Returns how many there are.
std::int64_t name_pairs(const PairRows& pairs, ContactRows& contacts) {
  std::int64_t count = 0;
  for (std::size_t row = 0; row < pairs.pair.size(); ++row) {
    const std::int32_t contact = pairs.contact[row];
    if (contact < 0) continue;
    contacts.pair[contact] = pairs.pair[row];
    ++count;
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

bool same_hulls(const std::vector<SharedHull>& a, const std::vector<SharedHull>& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), same_hull);
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
  return sizeof *data_ + sizeof *data_->pages + data_->pages->sheets.bytes() +
         data_->hulls.size() * sizeof(SharedHull);
}

std::uint64_t Snapshot::step() const noexcept { return is_empty() ? 0 : data_->world.step_count; }

SnapshotData::~SnapshotData() {
  const std::lock_guard lock(pages->mutex);
  pages->id = 0;
  pages->sheets.clear();
}

void save_world(const WorldData& data, SnapshotData& snapshot, bool remember) {
  snapshot.is_full = false;
  snapshot.handle_tag = data.handle_tags.given;
  data.save_values(snapshot.world);
  try {
    if (!same_hulls(snapshot.hulls, data.hulls.shared)) snapshot.hulls = data.hulls.shared;
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
  const Sheets& sheets = from.pages->sheets;
  reserve_columns(sheets, data);
  if (!same_hulls(from.hulls, data.hulls.shared)) {
    HullIndex index(from.hulls);
    data.hulls.shared.swap(index.shared);
    data.hulls.slot_of.swap(index.slot_of);
  }
  // Nothing can fail from here on.
  const FpEnvironment environment;
  data.forget(ColumnKind::state);
  if (from.handle_tag != 0) data.handle_tags.given = from.handle_tag;
  load_sheets(sheets, data);
  data.load_values(from.world);
  data.stats.step = data.step_count;
  for (std::size_t slot = 0; slot < data.hulls.shared.size(); ++slot) {
    const SharedHull& shared = data.hulls.shared[slot];
    data.hulls.data[slot] = shared.solid != nullptr ? shared.solid->columns.data : nullptr;
  }
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
