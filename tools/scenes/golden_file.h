// Golden hashes: a text file of runs of scenes and their hashes, one line each, the same for every machine,
// compiler, build type and backend. The tests have one such file, the soak has another.
//
// A line: scene, parameters ("bodies=300,seed=1", or "-" for none), steps, and two hashes of 16 hexadecimal
// digits. Empty lines and lines that start with # have no meaning.
#pragma once

#include <tools/scenes/scene.h>

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace scree::scenes {

/// A scene at a size and a length.
struct Run {
  std::string scene;
  Parameters parameters;
  int steps = 0;
};

/// The result of a run: the hash after the last step, and a digest of the hashes of all steps.
struct RunHashes {
  std::uint64_t last = 0;
  std::uint64_t all = 0;

  friend bool operator==(const RunHashes&, const RunHashes&) = default;
};
std::ostream& operator<<(std::ostream& out, const RunHashes& hashes);

struct Golden {
  Run what;
  RunHashes digest;

  std::string name() const;  ///< "pile bodies=300,seed=1", "stack -" where there are no parameters
};
std::ostream& operator<<(std::ostream& out, const Golden& golden);

/// Throws scree::Error with file, line and reason.
std::vector<Golden> read_goldens(const std::string& file);
/// Replaces the hashes, and keeps the comments and all text before the hashes. `goldens` must come from
/// read_goldens of the same file. Throws scree::Error.
void write_goldens(const std::string& file, const std::vector<Golden>& goldens);

/// "bodies=300,seed=1", or "-" for none. Whole values are written as integers.
std::string text_of(const Parameters& parameters);

/// 16 hexadecimal digits.
std::string hex(std::uint64_t hash);

}  // namespace scree::scenes
