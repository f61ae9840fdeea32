// Player: repeats the recorded calls and steps, and compares the results.
#include <core/state/recording_format/recorded_state.h>
#include <core/state/world_difference.h>
#include <parallel/recording/player_impl.h>
#include <parallel/recording/rows_in_order.h>

#include <algorithm>
#include <string>
#include <utility>

namespace scree {

void Player::Impl::restore_keyframe(std::size_t keyframe) {
  const std::size_t chunk = keyframe_chunk(keyframe);
  const Snapshot state = file.state(chunk);  // if this cannot be read, the world stays as it is
  if (is_lost) {                             // a step that ran out of memory leaves nothing to go on with
    World fresh;
    fresh.share_handles(world);
    world = std::move(fresh);
  }
  restore(world, state);
  is_measured = false;
  next.reset();
  stream.go_behind(chunk);
  position = keyframe_step(keyframe);
  hash.reset();
  dt.reset();
  is_lost = false;
}

void Player::Impl::turn_measures_on() {
  const WorldSettings& now = world.settings();
  WorldSettings settings = now;
  settings.contact_forces |= measures.contact_forces;
  settings.measure_residual |= measures.residual;
  settings.measure_penetration |= measures.penetration;
  settings.contact_events = settings.contact_events | measures.contact_events;
  if (settings.contact_forces != now.contact_forces || settings.measure_residual != now.measure_residual ||
      settings.measure_penetration != now.measure_penetration ||
      settings.contact_events != now.contact_events) {
    world.set_settings(settings);
    is_measured = true;
  }
}

void Player::Impl::measure(const PlayerMeasures& to) {
  measures = to;
  is_lost |= is_measured;  // the world's settings are no longer those of the recording
  is_measured = false;
}

const RecordStream::Step& Player::Impl::make_calls() {
  if (!next) next = stream.next_step(&world);
  return *next;
}

bool Player::Impl::step(Workers& workers) {
  if (position == file.info().last_step) return false;
  if (is_lost) seek(position, workers, "Player::step");
  try {
    const RecordStream::Step step = make_calls();
    turn_measures_on();
    scree::step(world, step.dt, workers);
    next.reset();
    hash = step.hash;
    dt = step.dt;
    ++position;
  } catch (...) {
    is_lost = true;
    throw;
  }
  return true;
}

void Player::Impl::seek(std::uint64_t step, Workers& workers, const char* call) {
  file.check_step(step, std::string(call) + ": ");
  const std::size_t keyframe = file.keyframe_before(step);
  is_lost |= next.has_value() && step == position;  // its world is that before the calls of the next step
  if (is_lost || position > step || keyframe_step(keyframe) > position) restore_keyframe(keyframe);
  while (position < step) this->step(workers);
  // It must not show whether steps were played to get here.
  WorldData& data = internals(world);
  clear_events(data.events);
  const std::uint64_t step_count = data.stats.step;
  data.stats = {};
  data.stats.step = step_count;
}

std::string Player::Impl::difference_from(std::size_t keyframe) {
  const std::size_t chunk = keyframe_chunk(keyframe);
  save(world, scratch);
  const bool is_shared = file.is_shared(chunk);
  const auto is_equal = [&] {
    return scree::hash_of_state(*SnapshotAccess::data(scratch)) == file.hash_of_state(chunk);
  };
  if (!is_shared && is_equal()) return {};
  World recorded;
  restore(recorded, file.state(chunk));
  if (is_shared) return first_difference_but_for_order(recorded, world);
  const std::string difference = first_state_difference(recorded, world);
  return difference.empty() ? "what snapshots keep besides the columns of kind state" : difference;
}

void Player::Impl::find_difference(Divergence& divergence, Workers& workers) {
  const std::size_t keyframe = file.keyframe_after(position);
  if (keyframe == file.keyframes().size()) return;
  try {
    while (position < keyframe_step(keyframe)) step(workers);
  } catch (const Error& error) {
    divergence.difference = error.what();  // a call that only the world that was recorded could take
    return;
  }
  divergence.difference = difference_from(keyframe);
  divergence.compared_at = position;
}

std::optional<Divergence> Player::Impl::compare_step() {
  const std::uint64_t actual = world.hash();
  if (!hash || actual == *hash) return {};
  return Divergence{.step = position, .expected_hash = *hash, .actual_hash = actual};
}

std::optional<Divergence> Player::Impl::compare_state() {
  const std::size_t keyframe = file.keyframe_after(position);
  if (keyframe == file.keyframes().size() || keyframe_step(keyframe) != position) return {};
  std::string difference = difference_from(keyframe);
  if (difference.empty()) return {};
  return Divergence{.step = position,
                    .expected_hash = file.hash_of_state(keyframe_chunk(keyframe)),
                    .actual_hash = scree::hash_of_state(*SnapshotAccess::data(scratch)),
                    .compared_at = position,
                    .difference = std::move(difference)};
}

Player::Player(const std::string& file) : impl_(std::make_unique<Impl>(file)) {}
Player::Player(std::span<const std::byte> bytes) : impl_(std::make_unique<Impl>(bytes)) {}
Player::~Player() = default;
Player::Player(Player&&) noexcept = default;
Player& Player::operator=(Player&&) noexcept = default;

const RecordingInfo& Player::info() const noexcept { return impl_->file.info(); }

std::span<const std::uint64_t> Player::keyframe_steps() const noexcept {
  return impl_->file.keyframe_steps();
}
const World& Player::world() const noexcept { return impl_->world; }
std::uint64_t Player::position() const noexcept { return impl_->position; }
bool Player::step(Workers& workers) { return impl_->step(workers); }
void Player::make_calls(Workers& workers) {
  if (impl_->position == impl_->file.info().last_step) return;
  if (impl_->is_lost) impl_->seek(impl_->position, workers, "Player::make_calls");
  try {
    impl_->make_calls();
  } catch (...) {
    impl_->is_lost = true;
    throw;
  }
}
void Player::seek(std::uint64_t step, Workers& workers) { impl_->seek(step, workers, "Player::seek"); }
std::optional<std::uint64_t> Player::recorded_hash() const noexcept { return impl_->hash; }
std::optional<float> Player::recorded_dt() const noexcept { return impl_->dt; }
void Player::measure(const PlayerMeasures& measures) { impl_->measure(measures); }
World Player::branch() const { return clone(impl_->world); }

std::optional<Divergence> Player::verify(std::uint64_t from, std::uint64_t to, Workers& workers) {
  constexpr const char* kName = "Player::verify";
  impl_->file.check_step(to, std::string(kName) + ": ");
  if (from > to) {
    throw Error(std::string(kName) + ": step " + std::to_string(from) + " comes after step " +
                std::to_string(to));
  }
  impl_->measure({});
  impl_->seek(from, workers, kName);
  std::optional<Divergence> divergence = impl_->compare_state();
  while (!divergence && impl_->position < to) {
    impl_->step(workers);
    divergence = impl_->compare_step();
    if (divergence) {
      impl_->find_difference(*divergence, workers);
    } else {
      divergence = impl_->compare_state();
    }
  }
  impl_->is_lost |= divergence.has_value();  // what is recorded goes on from a keyframe
  return divergence;
}

std::string first_difference(const World& expected, const World& actual) {
  return first_state_difference(expected, actual);
}

}  // namespace scree
