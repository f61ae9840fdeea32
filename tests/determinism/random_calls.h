// Random calls: sequences of World's public calls, drawn from our own random numbers. Their results must not
// depend on the backend, and no sequence may break a promise of the worlds.
//
// A call carries all its data: the player's slot and the seed of its values. So a sequence stays playable
// when calls are dropped from it, which is how a failing sequence is shrunk.
#pragma once

#include <tests/determinism/backends.h>

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace scree::determinism {

enum class CallKind : std::uint8_t {
  step,
  step_worlds,  // in a list with another one
  create_body,
  create_empty_bodies,  // in bulk, without shapes
  create_bodies,
  destroy_body,
  destroy_bodies,
  add_shape,
  destroy_shape,
  set_pose,
  set_linear_velocity,
  set_angular_velocity,
  shoot,  // so fast that the body is swept
  set_kinematic_target,
  add_load,     // force, force at a point, torque
  add_impulse,  // impulse, impulse at a point, angular impulse
  set_body_type,
  set_filter,
  set_material,
  set_geometry,
  set_local_pose,
  set_contact_events,
  set_mass_properties,
  reset_mass,
  set_damping,
  set_gravity_factor,
  set_locks,
  set_can_sleep,
  set_full_sweep,
  wake,
  set_user_data,
  set_settings,
  create_joint,
  create_joints,  // several at once
  destroy_joint,
  set_joint,
  change_joint,  // frames, stiffness, strength, whether it is enabled and what collides, user data
  save,          // into one of a few snapshots, whole or as changes
  restore,       // what was saved, into this world or another one
  go_round,      // a round trip of the world through snapshots, without effect
  branch,        // clones step on their own
  move_world,
  wrong_call,  // must throw Error and change nothing
  add_mesh,    // to a body that may have one; not drawn, see with_meshes
};
inline constexpr int kCallKindCount = 44;
const char* name_of(CallKind kind);

struct Call {
  CallKind kind = CallKind::step;
  std::uint32_t slot = 0;
  std::uint64_t seed = 0;
};
using Sequence = std::vector<Call>;

// Whether tests play all of their sequences: where they compare in full, and under ThreadSanitizer. For
// ThreadSanitizer one instruction set is as good as another, but each sequence gives another order of calls.
bool wants_all_sequences();
// A number from the environment, for a longer search.
std::uint64_t wish(const char* variable, std::uint64_t otherwise);

// `bodies` is about the number of bodies that the bulk calls keep alive.
Sequence random_sequence(std::uint64_t seed, int calls, int bodies);
// The same with calls between the others that add meshes.
Sequence with_meshes(const Sequence& sequence);

struct Played {
  std::vector<std::uint64_t> hashes;  // after each step; one call may take several
  std::int64_t most_contacts = 0;     // in any step
  bool somebody_slept = false;        // seen only by a run with checks
  std::int64_t sweep_hits = 0;        // in all steps
  std::size_t events = 0;             // begins of contacts, in all steps
  std::size_t hits = 0;               // of contacts, as seen by a run with checks
  std::size_t joint_events = 0;       // likewise
  std::string broken_promise;         // why playing ended early, if it did
};
// Plays on one schedule. With `checks` reads and checks all bodies around every step. Writes each call to
// `log`, if there is one.
Played play(const Sequence& sequence, const Schedule& schedule, bool checks, std::ostream* log = nullptr);

// The failure of a sequence: a promise broken on the reference, or a schedule whose hashes differ.
struct Failure {
  std::string what;
  Schedule schedule;
};
std::optional<Failure> find_failure(const Sequence& sequence, const std::vector<Schedule>& schedules);

// Plays and records to the file on one schedule. Returns the failure of the recording: hashes that differ
// from the reference, or a schedule that does not verify it.
std::optional<Failure> find_recording_failure(const Sequence& sequence, const Schedule& recorded_on,
                                              const std::vector<Schedule>& schedules,
                                              const std::string& file);

// Drops calls, first many at once and then fewer, as long as the remaining sequence fails, for
// a minute at most.
Sequence shrunk(Sequence sequence, const std::function<bool(const Sequence&)>& fails);

// A readable report of the failure with the calls of the shrunk sequence.
std::string describe(const Sequence& sequence, const Failure& failure);

}  // namespace scree::determinism
