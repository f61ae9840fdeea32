// Calls of World as a whole: creation, settings, columns and memory. Bodies, shapes and bulk creation have
// files of their own.
#include <core/state/recording_format/recorded_calls.h>
#include <core/world/check.h>
#include <core/world/edit.h>
#include <core/world/state_table.h>
#include <core/world/wake.h>
#include <scree/world.h>

#include <atomic>
#include <cstddef>
#include <mutex>
#include <string>
#include <utility>

namespace scree {

namespace {

// The fixed world's row and the empty ones beside it: identity poses, no velocity, no inertia.
void make_reserved_rows(Bodies& bodies) {
  bodies.resize(kFirstBody);
  for (std::int32_t row = 0; row < kFirstBody; ++row) {
    bodies.type[row] = BodyType::fixed;
    bodies.pose[row].rotation[3] = 1.0f;
    bodies.transform[row] = Pose{};
    bodies.delta[row].rotation[3] = 1.0f;
    bodies.first_shape[row] = -1;
    bodies.first_joint[row] = -1;
  }
}

// Another one for each world of this process; 0 is none.
std::uint32_t next_handle_tag() {
  static std::atomic<std::uint32_t> last{0};
  std::uint32_t tag = 0;
  while (tag == 0) tag = last.fetch_add(1, std::memory_order_relaxed) + 1;
  return tag;
}

}  // namespace

WorldData& internals(World& world, const char* call) {
  if (world.data_ == nullptr) {
    throw Error(std::string(call) + ": the world has been moved from", ErrorCode::moved_from);
  }
  return *world.data_;
}
const WorldData& internals(const World& world, const char* call) {
  return internals(const_cast<World&>(world), call);
}

void check_whole(const WorldData& data, const char* call) {
  if (data.border == nullptr) return;
  throw Error(std::string(call) + ": the world is a part of a distributed one; ask its DistributedWorld",
              ErrorCode::wrong_state);
}

World::World(const WorldSettings& settings) {
  check_settings({"World"}, settings);
  data_ = std::make_unique<WorldData>();
  const std::uint32_t tag = next_handle_tag();
  data_->handle_tags = {tag, tag};
  data_->settings = settings;
  make_reserved_rows(data_->bodies);
}

World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

void World::share_handles(const World& other) {
  constexpr Call call{"share_handles"};
  WorldData& data = opened(call, data_);
  const WorldData& from = opened(call, other.data_);
  const bool has_given_any = data.bodies.flags.size() > kFirstBody;
  if (has_given_any && data.handle_tags.given != from.handle_tags.given) {
    fail(call, "the world has given handles already", ErrorCode::wrong_state);
  }
  data.handle_tags = from.handle_tags;
}

const WorldSettings& World::settings() const { return opened({"settings"}, data_).settings; }

void World::set_settings(const WorldSettings& settings) {
  constexpr Call call{"set_settings"};
  WorldData& data = opened(call, data_);
  const CallRecord<RecordedCall::set_settings> call_record(data, settings);
  check_settings(call, settings);
  // What rested under the old gravity may fall under the new one; without sleep no body may rest.
  const bool wakes =
      settings.gravity != data.settings.gravity || (data.settings.sleeping && !settings.sleeping);
  // A timer may have run to more than the new time for a body that has begun to move.
  if (settings.sleep_time < data.settings.sleep_time) {
    for (std::size_t row = 0; row < data.bodies.sleep_time.size(); ++row) {
      if (data.bodies.sleep_time[row] == 0.0f) continue;
      data.bodies.sleep_time[row] = 0.0f;
      data.bodies.marks.mark(row);
    }
  }
  // Nothing would make up for it.
  if (data.settings.continuous && !settings.continuous) {
    for (std::size_t row = 0; row < data.bodies.velocity.size(); ++row) {
      if (data.bodies.velocity[row].lag == 0.0f) continue;
      data.bodies.velocity[row].lag = 0.0f;
      data.bodies.marks.mark(row);
    }
  }
  if (settings.contact_events != data.settings.contact_events) data.events.asked_of_all = true;
  data.settings = settings;
  if (!wakes) return;
  for (std::size_t row = 0; row < data.bodies.flags.size(); ++row)
    wake_body(data, static_cast<std::int32_t>(row));
}

const StepStats& World::stats() const { return opened({"stats"}, data_).stats; }

std::span<const Pose> World::poses() const noexcept {
  if (data_ == nullptr) return {};
  return data_->bodies.transform.span();
}

std::span<const Velocity> World::velocities() const noexcept {
  static_assert(sizeof(Velocity) == sizeof(VelocityRow) && alignof(Velocity) == alignof(VelocityRow));
  static_assert(offsetof(Velocity, linear) == offsetof(VelocityRow, linear) &&
                offsetof(Velocity, angular) == offsetof(VelocityRow, angular));
  if (data_ == nullptr) return {};
  const Column<VelocityRow>& rows = data_->bodies.velocity;
  return {reinterpret_cast<const Velocity*>(rows.data()), rows.size()};
}

std::span<const ContactEvent> World::contact_begins() const noexcept {
  if (data_ == nullptr) return {};
  return std::as_const(data_->events.begins).span();
}

std::span<const ContactEvent> World::contact_persists() const noexcept {
  if (data_ == nullptr) return {};
  return std::as_const(data_->events.persists).span();
}

std::span<const ContactEnd> World::contact_ends() const noexcept {
  if (data_ == nullptr) return {};
  return std::as_const(data_->events.ends).span();
}

std::span<const ContactEvent> World::contact_hits() const noexcept {
  if (data_ == nullptr) return {};
  return std::as_const(data_->events.hits).span();
}

std::span<const SensorEvent> World::sensor_begins() const noexcept {
  if (data_ == nullptr) return {};
  return std::as_const(data_->events.sensor_begins).span();
}

std::span<const SensorEvent> World::sensor_ends() const noexcept {
  if (data_ == nullptr) return {};
  return std::as_const(data_->events.sensor_ends).span();
}

std::span<const BodyId> World::restored_bodies() const noexcept {
  if (data_ == nullptr) return {};
  return std::as_const(data_->events.restored).span();
}

std::span<const BodyId> World::quarantined_bodies() const noexcept {
  if (data_ == nullptr) return {};
  return std::as_const(data_->events.quarantined).span();
}

std::span<const BodyId> World::sleep_begins() const noexcept {
  if (data_ == nullptr) return {};
  return std::as_const(data_->events.sleep_begins).span();
}

std::span<const BodyId> World::sleep_ends() const noexcept {
  if (data_ == nullptr) return {};
  return std::as_const(data_->events.sleep_ends).span();
}

std::span<const JointId> World::broken_joints() const noexcept {
  if (data_ == nullptr) return {};
  return std::as_const(data_->events.broken).span();
}

std::span<const JointEvent> World::joint_events() const noexcept {
  if (data_ == nullptr) return {};
  return std::as_const(data_->events.strained).span();
}

std::span<const JointId> World::destroyed_joints() const noexcept {
  if (data_ == nullptr) return {};
  return std::as_const(data_->events.destroyed).span();
}

MemoryUse World::memory_use() const {
  MemoryUse use;
  if (data_ == nullptr) return use;
  // Columns whose sizes are read here grow in calls that may run at the same time.
  const std::lock_guard while_saving(data_->saving);
  const auto while_waking = data_->shapes.waking_made.hold();
  const auto while_ordering = data_->contacts.resting_order_made.hold();
  const auto while_listing = data_->contacts.by_shape_made.hold();
  const auto while_querying = data_->shapes.queries_made.hold();
  for_each_member_size(*data_,
                       [&use](ColumnKind kind, const char*, const char*, std::size_t, std::size_t capacity) {
                         switch (kind) {
                           case ColumnKind::state:
                             use.state += capacity;
                             break;
                           case ColumnKind::derived:
                             use.derived += capacity;
                             break;
                           case ColumnKind::scratch:
                             use.scratch += capacity;
                             break;
                         }
                       });
  return use;
}

}  // namespace scree
