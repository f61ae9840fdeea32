// The reader of recordings as a target.
#include <scree/recording.h>
#include <scree/scree.h>
#include <tests/fuzz/laws.h>
#include <tests/fuzz/memory_watch.h>

#include <algorithm>
#include <optional>

namespace scree::fuzz {

namespace {

// Only the file limits the calls in a recording. Larger recordings than these are only opened: thousands of
// bodies in one place take seconds for a step with sanitizers.
constexpr std::uint64_t kMostPlayedBytes = 24 << 10;
constexpr std::size_t kMostSteppedShapes = 64;
constexpr std::uint64_t kMostSteps = 6;

std::uint64_t first_of(const RecordingInfo& info) { return info.first_step; }

void require_sound(const Player& player, std::size_t bytes) {
  const RecordingInfo& info = player.info();
  const std::span<const std::uint64_t> steps = player.keyframe_steps();
  require(info.first_step <= info.last_step, "the recording ends before it begins");
  require(info.file_bytes == bytes && info.lost_bytes <= bytes, "the recording has another size");
  require(info.keyframes == steps.size() && info.keyframes > 0, "keyframes are missing");
  require(std::is_sorted(steps.begin(), steps.end()), "keyframes do not ascend");
  require(steps.front() == first_of(info) && steps.back() <= info.last_step, "keyframes lie outside");
}

// Tries all functions of a player. Its reports must be true for any recording.
void play(Player& player) {
  const RecordingInfo& info = player.info();
  require(player.position() == info.first_step, "the player does not stand at the beginning");
  std::uint64_t hash = 0, at = 0;
  for (std::uint64_t i = 0; i < kMostSteps && player.world().shape_count() <= kMostSteppedShapes; ++i) {
    if (!player.step(wide_workers())) {
      require(player.position() == info.last_step, "the player stops before the end");
      break;
    }
    require(player.position() == info.first_step + i + 1, "the player does not count its steps");
    require(player.recorded_hash().has_value(), "a step has no hash");
    hash = player.world().hash();
    at = player.position();
  }
  if (player.world().shape_count() > kMostSteppedShapes) return;
  if (at > first_of(info) && !player.verify(first_of(info), at, narrow_workers())) {
    // A recording that verifies, keyframes included, gives the same states from every starting point.
    player.seek(first_of(info), narrow_workers());
    player.seek(at, wide_workers());
    require(player.world().hash() == hash, "another way leads to another world");
  }
  player.seek(player.keyframe_steps().back(), wide_workers());
  const World branch = player.branch();
  require(branch.hash() == player.world().hash(), "a branch is another world");
  require_laws_of_snapshots(branch);
}

}  // namespace

void recording_target(Input input) {
  const MemoryWatch memory;
  bool opened = false;
  try {
    Player player(std::as_bytes(input));
    opened = true;
    require_sound(player, input.size());
    memory.require_within(kRecordingBound, input.size(), "Player");
    if (player.info().raw_bytes <= kMostPlayedBytes) play(player);
  } catch (const Error& error) {
    require(names_offset(error.what(), "Player: byte ", ": ", input.size()),
            std::string("a refusal without an offset: ") + error.what());
  }
  if (!opened) memory.require_within(kRecordingBound, input.size(), "Player");
}

}  // namespace scree::fuzz
