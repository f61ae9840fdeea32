// The golden runs of the tests: scenes and random calls, and their hashes. The tests read them; only
// tools/update_goldens rewrites them.
#pragma once

#include <tests/determinism/replay.h>
#include <tools/scenes/golden_file.h>

#include <cstdint>
#include <string>
#include <vector>

namespace scree::determinism {

using scenes::Golden;

// The file's path, tests/determinism/golden/hashes.txt.
std::string golden_path();

// The name of the runs of random calls in the file; their parameters are bodies and seed, their length counts
// calls. All other runs are scenes.
inline constexpr const char* kRandomCalls = "random_calls";
inline bool is_scene(const SceneCase& what) { return what.scene != kRandomCalls; }
// The runs of the file that are scenes.
std::vector<Golden> scene_goldens();
// The hash after each step of a run of either kind.
std::vector<std::uint64_t> play_run(const SceneCase& what, const Schedule& schedule);

// Names tests of golden runs after their scenes; a number keeps several sizes of one scene apart.
inline constexpr auto kGoldenName = [](const auto& info) {
  return info.param.what.scene + "_" + std::to_string(info.index);
};

}  // namespace scree::determinism
