// A round of the soak: records a random scene on one backend. The recording must play with the same bits on
// others, also from any place in the middle.
#pragma once

#include <tools/soak_program/backends.h>
#include <tools/soak_program/plan.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace scree::soak {

/// Totals of a soak so far.
struct Tally {
  std::int64_t rounds = 0;
  std::int64_t steps = 0;   ///< all that were taken, replays included
  std::int64_t bodies = 0;  ///< of all rounds' scenes
  std::int64_t hashes = 0;  ///< compared
  std::int64_t states = 0;  ///< whole ones, compared
};

/// The first difference found.
struct Failure {
  std::string what;
  std::string command;  ///< reproduces it
};

/// The recording of one world of a round.
struct Recorded {
  std::string file;
  std::vector<std::uint64_t> hashes;  ///< after each step, as the recorded world had them
  std::vector<std::byte> end;         ///< its state at the end
};

class Rounds {
 public:
  /// Recordings are made in the folder, and stay there if they show a difference.
  explicit Rounds(std::string folder);

  /// Plays one round; the same one for the same seed. Prints its line.
  std::optional<Failure> play(std::uint64_t seed);
  /// Verifies a recording from elsewhere under all instruction sets.
  std::optional<Failure> verify_file(const std::string& file);
  const Tally& tally() const { return tally_; }

 private:
  std::vector<Recorded> record(const Plan& plan, std::uint64_t seed, scenes::Random& random);
  std::optional<Failure> verify(const Recorded& recorded, scenes::Random& random);
  std::optional<Failure> verify_on(const std::string& file, std::size_t backend);
  std::optional<Failure> replay_on_changing_backends(const Recorded& recorded, scenes::Random& random);
  std::optional<Failure> go_on_from_the_middle(const Recorded& recorded, scenes::Random& random);
  /// One backend of each instruction set.
  std::vector<std::size_t> one_of_each(scenes::Random& random) const;
  Failure failure(const std::string& file, std::size_t backend, const std::string& what) const;

  std::string folder_;
  Backends backends_;
  Tally tally_;
  // Of the round that is played.
  std::size_t recorded_on_ = 0;
  std::int64_t calls_ = 0;
};

}  // namespace scree::soak
