// Replay: a scene played step by step, the hash of every step, and the search for the first difference of two
// replays.
#pragma once

#include <tests/determinism/backends.h>
#include <tools/scenes/golden_file.h>
#include <tools/scenes/stage.h>

#include <cstdint>
#include <string>
#include <vector>

namespace scree::determinism {

using SceneCase = scenes::Run;
using Digest = scenes::RunHashes;
using scenes::hex;

Digest digest_of(const std::vector<std::uint64_t>& hashes);

// Mixes a value into a hash; order matters.
std::uint64_t mixed(std::uint64_t sum, std::uint64_t value);

// Hash of all bits of a world's events, handles included.
std::uint64_t digest_of_events(const World& world);

// The worlds of a scene during a replay. At two thirds of the steps every seventh body is thrown up.
class Playback {
 public:
  explicit Playback(const SceneCase& what, ContactEvents events = ContactEvents::none);
  // Plays scenes that were built before, for callers to whom the time of that arithmetic matters.
  Playback(const std::vector<scenes::Scene>& scenes, int steps, ContactEvents events = ContactEvents::none);

  void advance(Workers& workers);
  int steps_taken() const { return stage_.steps(); }
  std::uint64_t hash() const;  // of all worlds
  std::vector<World>& worlds() { return stage_.worlds(); }

 private:
  scenes::Stage stage_;
  float dt_;
  int steps_;
};

// The hashes after each step.
std::vector<std::uint64_t> play(const SceneCase& what, const Schedule& schedule);

// Plays the case on the schedule and on the reference side by side and reports the first difference: the
// step, the first body and field, and the first column of the state table that differs.
std::string where_they_part(const SceneCase& what, const Schedule& schedule);

}  // namespace scree::determinism
