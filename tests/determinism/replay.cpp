// See replay.h.
#include <core/state/world_difference.h>
#include <tests/determinism/replay.h>

#include <bit>
#include <cstddef>
#include <cstring>

namespace scree::determinism {
namespace {

constexpr Vec3 kThrownVelocity{0.5f, 3.0f, 0.25f};  // m/s; 0.45 m high

}  // namespace

std::uint64_t mixed(std::uint64_t sum, std::uint64_t value) {
  // Odd multiplier and rotation: a bijection of `sum`, so that no earlier value is forgotten.
  return std::rotl(sum ^ value, 23) * 0x9e3779b97f4a7c15u;
}

Digest digest_of(const std::vector<std::uint64_t>& hashes) {
  Digest digest;
  for (const std::uint64_t hash : hashes) {
    digest.last = hash;
    digest.all = mixed(digest.all, hash);
  }
  return digest;
}

namespace {

// Sums of data that equal histories determine: of handles, index and generation.
std::uint64_t mixed_bytes(std::uint64_t sum, const void* data, std::size_t bytes) {
  for (std::size_t at = 0; at < bytes; at += sizeof(std::uint32_t)) {
    std::uint32_t word;
    std::memcpy(&word, static_cast<const std::byte*>(data) + at, sizeof word);
    sum = mixed(sum, word);
  }
  return sum;
}
template <class Handle>
std::uint64_t mixed_event(std::uint64_t sum, const Handle& handle) {
  return mixed(mixed(sum, handle.index), handle.generation);
}
template <class Contact>
std::uint64_t mixed_ends(std::uint64_t sum, const Contact& contact) {
  sum = mixed_event(mixed_event(sum, contact.shape_a), contact.shape_b);
  return mixed_event(mixed_event(sum, contact.body_a), contact.body_b);
}
std::uint64_t mixed_event(std::uint64_t sum, const SensorEvent& event) {
  sum = mixed_event(mixed_event(sum, event.sensor), event.visitor);
  return mixed_event(mixed_event(sum, event.sensor_body), event.visitor_body);
}
std::uint64_t mixed_event(std::uint64_t sum, const JointEvent& event) {
  sum = mixed_event(sum, event.joint);
  return mixed(mixed(sum, std::bit_cast<std::uint32_t>(event.force)),
               std::bit_cast<std::uint32_t>(event.torque));
}
std::uint64_t mixed_event(std::uint64_t sum, const ContactEnd& contact) { return mixed_ends(sum, contact); }
std::uint64_t mixed_event(std::uint64_t sum, const ContactEvent& contact) {
  constexpr std::size_t kEnds = offsetof(ContactEvent, normal);
  static_assert((sizeof contact - kEnds) % sizeof(std::uint32_t) == 0);
  const auto* bytes = reinterpret_cast<const std::byte*>(&contact);
  return mixed_bytes(mixed_ends(sum, contact), bytes + kEnds, sizeof contact - kEnds);
}

}  // namespace

std::uint64_t digest_of_events(const World& world) {
  std::uint64_t sum = 0;
  const auto add = [&sum](const auto& list) {
    sum = mixed(sum, list.size());
    for (const auto& event : list) sum = mixed_event(sum, event);
  };
  add(world.contact_begins());
  add(world.contact_persists());
  add(world.contact_ends());
  if (!world.contact_hits().empty()) add(world.contact_hits());
  add(world.restored_bodies());
  if (!world.quarantined_bodies().empty()) add(world.quarantined_bodies());
  add(world.sleep_begins());
  add(world.sleep_ends());
  if (!world.sensor_begins().empty()) add(world.sensor_begins());
  if (!world.sensor_ends().empty()) add(world.sensor_ends());
  if (!world.broken_joints().empty()) add(world.broken_joints());
  if (!world.joint_events().empty()) add(world.joint_events());
  if (!world.destroyed_joints().empty()) add(world.destroyed_joints());
  return sum;
}

Playback::Playback(const SceneCase& what, ContactEvents events)
    : Playback(scenes::build(what.scene, what.parameters), what.steps, events) {}

Playback::Playback(const std::vector<scenes::Scene>& scenes, int steps, ContactEvents events)
    : stage_(scenes, events), dt_(scenes.front().dt), steps_(steps) {}

void Playback::advance(Workers& workers) {
  if (stage_.steps() == 2 * steps_ / 3) stage_.throw_up(kThrownVelocity);
  stage_.advance(dt_, workers);
}

std::uint64_t Playback::hash() const {
  std::uint64_t sum = 0;
  for (const World& world : stage_.worlds()) sum = mixed(sum, world.hash());
  return sum;
}

std::vector<std::uint64_t> play(const SceneCase& what, const Schedule& schedule) {
  Shift shift(schedule);
  Playback playback(what);
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < what.steps; ++i) {
    playback.advance(shift.at(i));
    hashes.push_back(playback.hash());
  }
  return hashes;
}

std::string where_they_part(const SceneCase& what, const Schedule& schedule) {
  Shift reference({kReference});
  Shift shift(schedule);
  Playback expected(what);
  Playback actual(what);
  std::string state;
  for (int i = 0; i < what.steps; ++i) {
    expected.advance(reference.at(i));
    actual.advance(shift.at(i));
    for (std::size_t world = 0; world < expected.worlds().size(); ++world) {
      World& expected_world = expected.worlds()[world];
      World& actual_world = actual.worlds()[world];
      const std::string place =
          "in step " + std::to_string(i + 1) + ", world " + std::to_string(world) + ", ";
      if (state.empty()) {
        state = first_column_difference(expected_world, actual_world);
        if (!state.empty()) state = "\n  the state table first differs " + place + state;
      }
      const std::string body = first_body_difference(expected_world, actual_world);
      if (!body.empty()) return "the hash first differs " + place + body + state;
    }
    if (expected.hash() != actual.hash()) {
      return "the hash first differs in step " + std::to_string(i + 1) + ": " + hex(actual.hash()) +
             " instead of " + hex(expected.hash()) + ", but no pose and velocity does" + state;
    }
  }
  return "a second run found no difference: results change from run to run" + state;
}

}  // namespace scree::determinism
