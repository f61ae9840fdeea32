// Golden hashes: a text file of runs and what they came to, one line each, the same for every machine,
// compiler, build type and backend. Read by the tests, rewritten by tools/update_goldens alone.
#pragma once

#include <tests/determinism/replay.h>

#include <iosfwd>
#include <string>
#include <vector>

namespace scree::determinism {

struct Golden {
  SceneCase what;
  Digest digest;

  std::string name() const;  // "pile bodies=300,seed=1", without spaces where there are no parameters
};

std::ostream& operator<<(std::ostream& out, const Golden& golden);

// The file's path, tests/determinism/golden/hashes.txt.
std::string golden_path();
// Throws Error with line number and reason.
std::vector<Golden> read_goldens(const std::string& path);
// Replaces the hashes and keeps the comments.
void write_goldens(const std::string& path, const std::vector<Golden>& goldens);

// The name of the runs of random calls in the file; their parameters are bodies and seed, their length counts
// calls. All other runs are scenes.
inline constexpr const char* kRandomCalls = "random_calls";
inline bool is_scene(const SceneCase& what) { return what.scene != kRandomCalls; }
// The hash after each step of a run of either kind.
std::vector<std::uint64_t> play_run(const SceneCase& what, const Schedule& schedule);

}  // namespace scree::determinism
