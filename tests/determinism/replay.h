// Replay: a scene played step by step, the hash of every step, and the search for where two replays part.
#pragma once

#include <tests/determinism/backends.h>
#include <tools/scenes/scene.h>

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace scree::determinism {

// A built-in scene at a size and a length.
struct SceneCase {
  std::string scene;
  scenes::Parameters parameters;
  int steps = 0;
};

// What a run comes down to: the hash after the last step, and one number made from the hashes of all steps.
struct Digest {
  std::uint64_t last = 0;
  std::uint64_t all = 0;

  friend bool operator==(const Digest&, const Digest&) = default;
};
std::ostream& operator<<(std::ostream& out, const Digest& digest);
Digest digest_of(const std::vector<std::uint64_t>& hashes);

// Adds a value to a running number; order counts.
std::uint64_t mixed(std::uint64_t sum, std::uint64_t value);

// One number made from all bits of a world's events, handles included.
std::uint64_t digest_of_events(const World& world);

// The worlds of a scene while they are played. At two thirds of the steps every seventh body is thrown up, so
// that what has fallen asleep wakes and what still stands collapses.
class Playback {
 public:
  explicit Playback(const SceneCase& what, ContactEvents events = ContactEvents::none);
  // From scenes that were built before, for callers who care when the arithmetic of building is done.
  Playback(const std::vector<scenes::Scene>& scenes, int steps, ContactEvents events = ContactEvents::none);

  void advance(Workers& workers);
  int steps_taken() const { return steps_taken_; }
  std::uint64_t hash() const;  // of all worlds
  std::vector<World>& worlds() { return worlds_; }

 private:
  void throw_some_up();

  std::vector<World> worlds_;
  std::vector<std::vector<BodyId>> bodies_;
  std::vector<std::vector<scenes::SceneDrive>> drives_;
  float dt_ = 0.0f;
  int steps_ = 0;
  int steps_taken_ = 0;
};

// The hashes after each step.
std::vector<std::uint64_t> play(const SceneCase& what, const Schedule& schedule);

// Plays the case on the schedule and on the reference side by side and tells where they part: the step, the
// first body and field, and the column of the state table that differed first.
std::string where_they_part(const SceneCase& what, const Schedule& schedule);

// 16 hexadecimal digits.
std::string hex(std::uint64_t hash);

}  // namespace scree::determinism
