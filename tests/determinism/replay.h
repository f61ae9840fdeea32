// Replay: a scene played step by step, the hash of every step, and the search for where two replays part.
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

// Adds a value to a running number; order counts.
std::uint64_t mixed(std::uint64_t sum, std::uint64_t value);

// One number made from all bits of a world's events, handles included.
std::uint64_t digest_of_events(const World& world);

// The worlds of a scene while they are played. At two thirds of the steps every seventh body is thrown up.
class Playback {
 public:
  explicit Playback(const SceneCase& what, ContactEvents events = ContactEvents::none);
  // From scenes that were built before, for callers who care when the arithmetic of building is done.
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

// Plays the case on the schedule and on the reference side by side and tells where they part: the step, the
// first body and field, and the column of the state table that differed first.
std::string where_they_part(const SceneCase& what, const Schedule& schedule);

}  // namespace scree::determinism
