// Finds where two recordings diverge.
#include <core/state/world_difference.h>
#include <parallel/recording/player_impl.h>
#include <parallel/recording/rows_in_order.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace scree {

namespace {

// Reads the hashes of a recording one after the other, without playing steps.
class HashStream {
 public:
  // The next one is that of the step after `step`.
  HashStream(RecordingFile& file, std::size_t keyframe, std::uint64_t step) : stream_(file) {
    stream_.go_behind(file.keyframes()[keyframe]);
    for (std::uint64_t at = file.keyframe_steps()[keyframe]; at < step; ++at) next();
  }
  std::uint64_t next() { return stream_.next_step(nullptr).hash; }

 private:
  RecordStream stream_;
};

// A step at which both recordings have a keyframe, and the keyframes' numbers.
struct CommonKeyframe {
  std::uint64_t step;
  std::size_t left, right;
};

// In order, without the first keyframe of a recording that began later: it holds calls that in the other
// recording come with the next step.
std::vector<CommonKeyframe> common_keyframes(std::span<const std::uint64_t> left_steps,
                                             std::span<const std::uint64_t> right_steps) {
  std::vector<CommonKeyframe> common;
  std::size_t i = 0, j = 0;
  while (i < left_steps.size() && j < right_steps.size()) {
    if (left_steps[i] == right_steps[j]) {
      if ((i == 0) == (j == 0)) common.push_back({left_steps[i], i, j});
      ++i;
      ++j;
    } else {
      ++(left_steps[i] < right_steps[j] ? i : j);
    }
  }
  return common;
}

// The first step up to `last` after which the recorded hashes differ.
std::optional<Divergence> first_step_that_differs(RecordingFile& left, std::size_t left_keyframe,
                                                  RecordingFile& right, std::size_t right_keyframe,
                                                  std::uint64_t first, std::uint64_t last) {
  HashStream left_hashes(left, left_keyframe, first), right_hashes(right, right_keyframe, first);
  for (std::uint64_t step = first + 1; step <= last; ++step) {
    const std::uint64_t expected = left_hashes.next(), actual = right_hashes.next();
    if (expected != actual) return Divergence{.step = step, .expected_hash = expected, .actual_hash = actual};
  }
  return {};
}

}  // namespace

std::optional<Divergence> compare(Player& a, Player& b, Workers& workers) {
  Player::Impl &left = *a.impl_, &right = *b.impl_;
  left.measure({});
  right.measure({});
  const RecordingInfo &left_info = a.info(), &right_info = b.info();
  const std::uint64_t first = std::max(left_info.first_step, right_info.first_step);
  const std::uint64_t last = std::min(left_info.last_step, right_info.last_step);
  if (first >= last) throw Error("compare: the recordings have no step in common");
  std::optional<Divergence> divergence =
      first_step_that_differs(left.file, left.file.keyframe_before(first), right.file,
                              right.file.keyframe_before(first), first, last);
  const std::vector<CommonKeyframe> common = common_keyframes(a.keyframe_steps(), b.keyframe_steps());
  // A keyframe of many ranks has its rows in another order, and so has what goes on from there.
  const auto compare_keyframes = [&](const CommonKeyframe& at) {
    left.restore_keyframe(at.left);
    right.restore_keyframe(at.right);
    divergence->difference = first_difference_but_for_order(left.world, right.world);
    divergence->compared_at = at.step;
  };

  if (!divergence) {
    // State that the hashes of steps may not show for long: friction of shapes that touch nothing, timers of
    // sleep.
    for (const CommonKeyframe& at : common) {
      const std::size_t left_chunk = left.keyframe_chunk(at.left),
                        right_chunk = right.keyframe_chunk(at.right);
      const bool is_shared = left.file.is_shared(left_chunk) || right.file.is_shared(right_chunk);
      const auto hash_of = [](Player::Impl& player, std::size_t chunk) {
        return player.file.hash_of_state(chunk);
      };
      if (!is_shared && hash_of(left, left_chunk) == hash_of(right, right_chunk)) continue;
      divergence = Divergence{.step = at.step};
      compare_keyframes(at);
      if (divergence->difference.empty()) {
        divergence.reset();
        continue;
      }
      divergence->expected_hash = hash_of(left, left_chunk);
      divergence->actual_hash = hash_of(right, right_chunk);
      break;
    }
    return divergence;
  }

  std::string problem;
  try {
    left.seek(divergence->step, workers, "compare");
    right.seek(divergence->step, workers, "compare");
    divergence->difference = first_difference_but_for_order(left.world, right.world);
    divergence->compared_at = divergence->step;
  } catch (const Error& error) {
    problem = error.what();  // a call that only the world that was recorded could take
  }
  left.is_lost = right.is_lost = true;
  if (!divergence->difference.empty()) return divergence;
  // One of them did not play as it was recorded: its keyframes hold the recorded states.
  divergence->compared_at = 0;
  const auto next = std::find_if(common.begin(), common.end(),
                                 [&](const CommonKeyframe& at) { return at.step >= divergence->step; });
  if (next != common.end()) {
    compare_keyframes(*next);
  } else {
    divergence->difference = std::move(problem);
  }
  return divergence;
}

}  // namespace scree
