// Where two recordings part.
#include <core/world_difference.h>
#include <parallel/player_impl.h>

#include <algorithm>
#include <string>
#include <utility>

namespace scree {

namespace {

// The hashes of a recording, one after the other, without any step taken.
class HashStream {
 public:
  // The next one is that of the step after `step`.
  HashStream(RecordingFile& file, std::size_t keyframe, std::uint64_t step) : stream_(file) {
    stream_.go_behind(file.keyframes()[keyframe]);
    for (std::uint64_t at = file.info().keyframe_steps[keyframe]; at < step; ++at) next();
  }
  std::uint64_t next() { return stream_.next_step(nullptr).hash; }

 private:
  RecordStream stream_;
};

}  // namespace

std::optional<Divergence> compare(Player& a, Player& b, Workers& workers) {
  Player::Impl &left = *a.impl_, &right = *b.impl_;
  const RecordingInfo &left_info = a.info(), &right_info = b.info();
  const std::uint64_t first = std::max(left_info.first_step, right_info.first_step);
  const std::uint64_t last = std::min(left_info.last_step, right_info.last_step);
  if (first >= last) throw Error("compare: the recordings have no step in common");
  HashStream left_hashes(left.file, left.keyframe_before(first), first);
  HashStream right_hashes(right.file, right.keyframe_before(first), first);
  Divergence divergence;
  for (std::uint64_t step = first; divergence.step == 0 && step < last; ++step) {
    const std::uint64_t expected = left_hashes.next(), actual = right_hashes.next();
    if (expected != actual) {
      divergence = {.step = step + 1, .expected_hash = expected, .actual_hash = actual};
    }
  }
  if (divergence.step == 0) return {};

  std::string problem;
  try {
    left.seek(divergence.step, workers, "compare");
    right.seek(divergence.step, workers, "compare");
    divergence.difference = first_state_difference(left.world, right.world);
    divergence.compared_at = divergence.step;
  } catch (const Error& error) {
    problem = error.what();  // a call that only the world that was recorded could take
  }
  left.is_lost = right.is_lost = true;
  if (!divergence.difference.empty()) return divergence;
  // One of them did not play as it was recorded: its keyframes tell what was.
  divergence.compared_at = 0;
  std::size_t left_keyframe = left.keyframe_after(divergence.step);
  std::size_t right_keyframe = right.keyframe_after(divergence.step);
  while (left_keyframe < left.file.keyframes().size() && right_keyframe < right.file.keyframes().size()) {
    const std::uint64_t left_step = left.keyframe_step(left_keyframe);
    const std::uint64_t right_step = right.keyframe_step(right_keyframe);
    if (left_step == right_step) {
      left.restore_keyframe(left_keyframe);
      right.restore_keyframe(right_keyframe);
      divergence.difference = first_state_difference(left.world, right.world);
      divergence.compared_at = left_step;
      return divergence;
    }
    ++(left_step < right_step ? left_keyframe : right_keyframe);
  }
  divergence.difference = std::move(problem);
  return divergence;
}

}  // namespace scree
