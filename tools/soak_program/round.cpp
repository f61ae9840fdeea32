// See round.h.
#include <scree/recording.h>
#include <tools/scenes/stage.h>
#include <tools/soak_program/mischief.h>
#include <tools/soak_program/round.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <utility>

namespace scree::soak {
namespace {

constexpr int kStepsFromTheMiddle = 12;
constexpr int kPlacesInTheMiddle = 3;

std::vector<std::byte> state_of(const World& world) {
  Snapshot snapshot;
  save(world, snapshot);
  return write_snapshot(snapshot);
}

std::string describe(const Divergence& divergence) {
  char text[160];
  std::snprintf(text, sizeof text, "step %llu comes to hash %016llx instead of %016llx",
                static_cast<unsigned long long>(divergence.step),
                static_cast<unsigned long long>(divergence.actual_hash),
                static_cast<unsigned long long>(divergence.expected_hash));
  std::string all = text;
  if (!divergence.difference.empty()) {
    all += "; at step " + std::to_string(divergence.compared_at) + ": " + divergence.difference;
  }
  return all;
}

}  // namespace

Rounds::Rounds(std::string folder) : folder_(std::move(folder)) {
  std::error_code problem;
  std::filesystem::create_directories(folder_, problem);
  if (problem) throw Error("--keep " + folder_ + ": " + problem.message());
}

Failure Rounds::failure(const std::string& file, std::size_t backend, const std::string& what) const {
  return {file + ", on " + name_of(backends_.at(backend)) + ": " + what,
          "scree replay " + file + " --verify " + options_of(backends_.at(backend))};
}

std::vector<std::size_t> Rounds::one_of_each(scenes::Random& random) const {
  std::vector<std::size_t> chosen;
  for (std::size_t first = 0; first < backends_.count();) {
    std::size_t last = first;
    while (last < backends_.count() && backends_.at(last).isa == backends_.at(first).isa) ++last;
    chosen.push_back(first + random.below(static_cast<std::uint32_t>(last - first)));
    first = last;
  }
  return chosen;
}

std::vector<Recorded> Rounds::record(const Plan& plan, std::uint64_t seed, scenes::Random& random) {
  scenes::Stage stage(plan.scenes);
  const std::size_t worlds = stage.worlds().size();
  std::vector<Recorded> recorded(worlds);
  std::vector<Recorder> recorders;
  std::vector<Mischief> mischief;
  for (std::size_t i = 0; i < worlds; ++i) {
    recorded[i].file = folder_ + "/seed_" + std::to_string(seed);
    if (i > 0) recorded[i].file.append("_").append(std::to_string(i));
    recorded[i].file += ".scree";
    recorders.emplace_back(stage.worlds()[i], recorded[i].file,
                           RecorderOptions{.keyframe_spacing = plan.keyframe_spacing});
    mischief.emplace_back(random.next(), plan.pause);
  }
  tally_.bodies += static_cast<std::int64_t>(stage.bodies());
  for (int step = 0; step < plan.steps; ++step) {
    for (std::size_t i = 0; i < worlds; ++i) mischief[i].before_step(stage.worlds()[i]);
    stage.advance(plan.dt[static_cast<std::size_t>(step) % plan.dt.size()], backends_.workers(recorded_on_));
    for (std::size_t i = 0; i < worlds; ++i) recorded[i].hashes.push_back(stage.worlds()[i].hash());
    tally_.steps += static_cast<std::int64_t>(worlds);
  }
  for (std::size_t i = 0; i < worlds; ++i) {
    recorders[i].finish();
    recorded[i].end = state_of(stage.worlds()[i]);
    calls_ += mischief[i].calls();
  }
  return recorded;
}

std::optional<Failure> Rounds::verify_on(const std::string& file, std::size_t backend) {
  try {
    Player player(file);
    const RecordingInfo& info = player.info();
    const std::optional<Divergence> divergence =
        player.verify(info.first_step, info.last_step, backends_.workers(backend));
    if (divergence) return failure(file, backend, describe(*divergence));
    const auto steps = static_cast<std::int64_t>(info.last_step - info.first_step);
    tally_.steps += steps;
    tally_.hashes += steps;
    tally_.states += static_cast<std::int64_t>(info.keyframes);
    return {};
  } catch (const Error& error) {
    return failure(file, backend, error.what());
  }
}

std::optional<Failure> Rounds::replay_on_changing_backends(const Recorded& recorded, scenes::Random& random) {
  Player player(recorded.file);
  std::size_t backend = 0;
  for (std::size_t step = 0; step < recorded.hashes.size(); ++step) {
    backend = backends_.random(random);
    const std::string place = "changing backends, step " + std::to_string(step + 1) + ": ";
    if (!player.step(backends_.workers(backend))) {
      return failure(recorded.file, backend, place + "the recording has ended");
    }
    if (player.recorded_hash() != recorded.hashes[step]) {
      return failure(recorded.file, backend,
                     place + "the recording has another hash than the recorded world");
    }
    if (player.world().hash() != recorded.hashes[step]) {
      return failure(recorded.file, backend, place + "another hash than the recorded one");
    }
    ++tally_.steps;
    tally_.hashes += 2;
  }
  ++tally_.states;
  if (state_of(player.world()) != recorded.end) {
    return failure(recorded.file, backend,
                   "changing backends: the hashes agree, the states at the end do not");
  }
  return {};
}

// Seeks to a step and continues from there, with a branch and a world restored from bytes.
std::optional<Failure> Rounds::go_on_from_the_middle(const Recorded& recorded, scenes::Random& random) {
  Player player(recorded.file);
  const std::uint64_t first = player.info().first_step;
  for (int place = 0; place < kPlacesInTheMiddle; ++place) {
    const std::size_t backend = backends_.random(random), other = backends_.random(random);
    Workers &workers = backends_.workers(backend), &others = backends_.workers(other);
    const std::uint32_t begin = random.below(static_cast<std::uint32_t>(recorded.hashes.size()));
    player.seek(first + begin, workers);
    const std::string text = "from step " + std::to_string(player.position()) + " on: ";
    if (begin > 0 && player.world().hash() != recorded.hashes[begin - 1]) {
      return failure(
          recorded.file, backend,
          "sought to step " + std::to_string(first + begin) + ": another hash than the recorded one");
    }
    World branch = player.branch();
    World restored;
    restore(restored, read_snapshot(state_of(player.world())));
    for (int i = 0; i < kStepsFromTheMiddle; ++i) {
      step(branch, 1.0f / 60.0f, workers);
      step(restored, 1.0f / 60.0f, others);
      if (branch.hash() == restored.hash()) continue;
      return failure(recorded.file, other,
                     text + "a branch and a restored world part after " + std::to_string(i + 1) + " steps");
    }
    for (std::size_t i = begin; i < recorded.hashes.size() && i < begin + kStepsFromTheMiddle; ++i) {
      ++tally_.steps;
      ++tally_.hashes;
      if (player.step(others) && player.world().hash() == recorded.hashes[i]) continue;
      return failure(
          recorded.file, other,
          text + "another hash than the recorded one after " + std::to_string(i + 1 - begin) + " steps");
    }
    tally_.steps += 2 * kStepsFromTheMiddle;
    tally_.hashes += kStepsFromTheMiddle + (begin > 0 ? 1 : 0);
  }
  return {};
}

std::optional<Failure> Rounds::verify(const Recorded& recorded, scenes::Random& random) {
  for (const std::size_t backend : one_of_each(random)) {
    if (std::optional<Failure> failed = verify_on(recorded.file, backend)) return failed;
  }
  if (std::optional<Failure> failed = replay_on_changing_backends(recorded, random)) return failed;
  return go_on_from_the_middle(recorded, random);
}

std::optional<Failure> Rounds::verify_file(const std::string& file) {
  scenes::Random random(1);
  for (const std::size_t backend : one_of_each(random)) {
    if (std::optional<Failure> failed = verify_on(file, backend)) return failed;
  }
  std::printf("%s: verified on every instruction set\n", file.c_str());
  return {};
}

std::optional<Failure> Rounds::play(std::uint64_t seed) {
  const auto start = std::chrono::steady_clock::now();
  scenes::Random random(seed);
  const Plan plan = draw_plan(random);
  recorded_on_ = backends_.random(random);
  calls_ = 0;
  std::printf("seed %llu: %s, %d steps on %s", static_cast<unsigned long long>(seed), plan.name.c_str(),
              plan.steps, name_of(backends_.at(recorded_on_)).c_str());
  std::fflush(stdout);  // shows the place if the program hangs or dies
  std::vector<Recorded> recorded;
  std::uintmax_t bytes = 0;
  try {
    recorded = record(plan, seed, random);
    for (const Recorded& one : recorded) {
      if (std::optional<Failure> failed = verify(one, random)) return failed;
      bytes += std::filesystem::file_size(one.file);
    }
  } catch (const std::exception& error) {
    return Failure{"seed " + std::to_string(seed) + ", recordings in " + folder_ + ": " + error.what(),
                   "scree_soak --rounds 1 --seed " + std::to_string(seed)};
  }
  for (const Recorded& one : recorded) std::filesystem::remove(one.file);
  ++tally_.rounds;
  std::printf(", %lld calls, %llu bytes: the same everywhere, %.1f s\n", static_cast<long long>(calls_),
              static_cast<unsigned long long>(bytes),
              std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  return {};
}

}  // namespace scree::soak
