// Targets of fuzzing: the readers of outside bytes, each as a function that takes any bytes.
//
// A target throws BrokenLaw if a reader crashes, hangs or takes more memory than stated here, if an error
// names no place or no reason, or if accepted input behaves unlike the result of calls. Fed by libFuzzer
// (run), and with the corpus by the ordinary tests (corpus_test.cpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

namespace scree::fuzz {

using Input = std::span<const std::uint8_t>;

class BrokenLaw : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

inline void require(bool holds, const std::string& law) {
  if (!holds) throw BrokenLaw(law);
}

// Scene files: parse_scene, and the worlds of small scenes.
void scene_target(Input input);
// Snapshots: read_snapshot, and the restored worlds.
void snapshot_target(Input input);
// Recordings: Player, which opens, steps, seeks, branches and verifies.
void recording_target(Input input);

using TargetFunction = void (*)(Input);
struct Target {
  const char* name;  // of its folders in corpus/ and regressions/
  TargetFunction run;
};
inline constexpr Target kTargets[] = {
    {"scene", scene_target}, {"snapshot", snapshot_target}, {"recording", recording_target}};

// Memory that a reader may take at once, bytes: a constant, and a share per byte of its input. The figures
// beside the bounds were measured; only hulls and compressed worlds come near them.
struct MemoryBound {
  std::size_t fixed;
  std::size_t per_byte;

  std::size_t of(std::size_t bytes) const { return fixed + per_byte * bytes; }
};

// 200 bytes, for text that is nested or lists what is short; 1200 for a hull of 256 corners that many shapes
// scale. Bodies that repeat take 110 bytes each, joints 330.
inline constexpr MemoryBound kSceneBound{2u << 20, 2048};
// 3 to 12 bytes: worlds are packed, and hulls have columns for wide kernels.
inline constexpr MemoryBound kSnapshotBound{256u << 10, 64};
// 2 to 15 bytes. Free rows of contacts are 5 bytes each, and 400 once they are restored.
inline constexpr MemoryBound kRestoreBound{256u << 10, 512};
// 350 bytes for a million rows of dead bodies, 400 for hulls: states come to at most 32 times their
// compressed bytes, and take what a snapshot does.
inline constexpr MemoryBound kRecordingBound{1u << 20, 4096};

}  // namespace scree::fuzz
