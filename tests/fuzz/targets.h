// Targets of fuzzing: what reads bytes from anywhere, each as a function that takes any bytes.
//
// A target throws BrokenLaw where a reader breaks its word: where it crashes, hangs or takes more memory than
// stated here, where a refusal names no place or no reason, and where what was accepted does not behave as
// what calls have made does. Fed by libFuzzer (run), and with the corpus by the ordinary tests
// (corpus_test.cpp).
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

// Scene files: parse_scene, and the worlds that small scenes come to.
void scene_target(Input input);
// Snapshots: read_snapshot, and the worlds that they are restored to.
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

// Memory that a reader may take at once, bytes: for itself and by byte of its input. Stated, not measured:
// what is taken is below a half of it.
struct MemoryBound {
  std::size_t fixed;
  std::size_t per_byte;

  std::size_t of(std::size_t bytes) const { return fixed + per_byte * bytes; }
};

// A scene's hulls are built while it is read: of 16 KiB of text there are up to 400 of 256 corners.
inline constexpr MemoryBound kSceneBound{16u << 20, 4096};
// A solid of 4 corners is 200 bytes, and with its columns for wide kernels 10 KiB.
inline constexpr MemoryBound kSnapshotBound{1u << 20, 128};
// Free rows of contacts are a byte each, and as much room as others once they are restored.
inline constexpr MemoryBound kRestoreBound{1u << 20, 1024};

// Compressed bytes come to 1024 times as many, of which a state takes as much as a snapshot's.
inline constexpr MemoryBound kRecordingBound{16u << 20, 16384};

}  // namespace scree::fuzz
