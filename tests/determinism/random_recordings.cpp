// Recordings of random calls: every schedule replays them with the same hashes.
#include <scree/recording.h>
#include <tests/determinism/player.h>
#include <tests/determinism/replay.h>

#include <memory>

namespace scree::determinism {
namespace {

// The hashes after each step, with hashes of events.
std::vector<std::uint64_t> record(const Sequence& sequence, const Schedule& schedule,
                                  const std::string& file) {
  Shift shift(schedule);
  Player player(shift, false, nullptr);
  player.stay_in_one_world();
  Recorder recorder(player.world(), file, {.keyframe_spacing = 40});
  for (const Call& call : sequence) player.make(call);
  if (!recorder.is_recording()) throw BrokenPromise("recording has ended: " + recorder.error());
  recorder.finish();
  return player.hashes();
}

// Compares a player with the recorded world; empty if they agree. Includes the world's hash, but no events.
std::string difference(scree::Player& player, const Schedule& schedule) {
  const RecordingInfo& info = player.info();
  Shift shift(schedule);
  if (schedule.size() == 1) {
    const std::optional<Divergence> found = player.verify(info.first_step, info.last_step, shift.at(0));
    return found ? "step " + std::to_string(found->step) + ": " + found->difference : std::string();
  }
  player.seek(info.first_step, shift.at(0));
  for (int i = 0; player.step(shift.at(i)); ++i) {
    if (player.recorded_hash() != player.world().hash()) return "step " + std::to_string(player.position());
  }
  return player.position() == info.last_step ? std::string() : "the recording ends too early";
}

}  // namespace

std::optional<Failure> find_recording_failure(const Sequence& sequence, const Schedule& recorded_on,
                                              const std::vector<Schedule>& schedules,
                                              const std::string& file) {
  try {
    const Played expected = play(sequence, {kReference}, false);
    if (record(sequence, recorded_on, file) != expected.hashes) {
      return Failure{"hashes differ while they are recorded", recorded_on};
    }
    scree::Player player(file);
    if (!player.info().finished) return Failure{"the recording is not finished", recorded_on};
    for (const Schedule& schedule : schedules) {
      const std::string found = difference(player, schedule);
      if (!found.empty())
        return Failure{"recorded, and played on " + name_of(schedule) + ": " + found, schedule};
    }
  } catch (const BrokenPromise& broken) {
    return Failure{broken.what(), recorded_on};
  } catch (const Error& error) {
    return Failure{std::string("a recording is refused: ") + error.what(), recorded_on};
  }
  return {};
}

}  // namespace scree::determinism
