// Plays, verifies, inspects and compares recordings; see replay.h.
#include <tools/command/clock.h>
#include <tools/command/options.h>
#include <tools/command/progress.h>
#include <tools/command/replay.h>
#include <tools/command/team.h>
#include <tools/files/recordings.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <span>
#include <vector>

namespace scree::command {
namespace {

using files::naming;
using files::open_recording;

double milliseconds_since(Clock::time_point start) { return 1000.0 * seconds_since(start); }

// Progress counts in int; it stops at the largest int.
int progress_count(std::uint64_t steps) {
  return static_cast<int>(std::min<std::uint64_t>(steps, std::numeric_limits<int>::max()));
}

template <class AnyPlayer>
void take_span(const AnyPlayer& player, const ReplayOptions& options, ReplayFigures& figures) {
  figures.from = options.from.value_or(player.info().first_step);
  figures.to = options.to.value_or(player.info().last_step);
  check_span(player.info(), figures.from, figures.to);
  for (const std::uint64_t step : player.keyframe_steps()) {
    if (step > figures.from && step <= figures.to) ++figures.keyframes;
  }
}

void add_times(std::vector<double> times, ReplayFigures& figures) {
  if (times.empty()) return;
  double sum = 0.0;
  for (const double time : times) sum += time;
  figures.ms_mean = sum / static_cast<double>(times.size());
  std::sort(times.begin(), times.end());
  const std::size_t middle = times.size() / 2;
  figures.ms_median = times.size() % 2 == 1 ? times[middle] : 0.5 * (times[middle - 1] + times[middle]);
  figures.ms_min = times.front();
  figures.ms_max = times.back();
}

// Calls taken() after each step.
template <class AnyPlayer, class Taken>
void play(AnyPlayer& player, Workers& workers, Progress& progress, ReplayFigures& figures, Taken&& taken) {
  std::vector<double> times;
  while (player.position() < figures.to) {
    const auto start = Clock::now();
    if (!player.step(workers)) break;
    times.push_back(milliseconds_since(start));
    taken();
    progress.show(progress_count(player.position() - figures.from));
  }
  figures.steps = player.position() - figures.from;
  add_times(std::move(times), figures);
}

// Plays on from keyframe to keyframe to show progress, each time over one, whose states are compared.
// verify_part(begin, end): a Divergence, if there is one.
template <class VerifyPart>
void verify(std::span<const std::uint64_t> keyframe_steps, Progress& progress, ReplayFigures& figures,
            VerifyPart&& verify_part) {
  std::vector<std::uint64_t> ends;
  for (const std::uint64_t step : keyframe_steps) {
    if (step >= figures.from && step + 1 < figures.to) ends.push_back(step + 1);
  }
  ends.push_back(figures.to);
  const auto start = Clock::now();
  std::uint64_t begin = figures.from;
  for (const std::uint64_t end : ends) {
    figures.divergence = verify_part(begin, end);
    if (figures.divergence) break;
    if (end > begin) progress.show(progress_count(end - figures.from));
    begin = end;
  }
  const std::uint64_t reached = figures.divergence ? figures.divergence->step : figures.to;
  figures.steps = reached > figures.from ? reached - figures.from : 0;
  if (figures.steps > 0) figures.ms_mean = milliseconds_since(start) / static_cast<double>(figures.steps);
}

void check_order(std::uint64_t from, std::uint64_t to) {
  if (from > to)
    throw Error("--from " + std::to_string(from) + " must not be beyond --to " + std::to_string(to));
}

}  // namespace

void check_span(const RecordingInfo& info, std::uint64_t from, std::uint64_t to) {
  const auto check_step = [&](const char* option, std::uint64_t step) {
    if (step >= info.first_step && step <= info.last_step) return;
    throw Error(std::string(option) + " " + std::to_string(step) + " must be from " +
                std::to_string(info.first_step) + " to " + std::to_string(info.last_step) +
                ", the steps of the recording");
  };
  check_step("--from", from);
  check_step("--to", to);
  check_order(from, to);
}

ReplayFigures replay(const ReplayOptions& options) {
  check_backend(options.threads, options.isa);
  Player player = open_recording(options.file);
  if (!options.quiet) tell_of_idle_threads(options.threads);
  std::optional<Trace> trace;
  Workers workers = make_workers(options.threads, options.isa, options.trace, trace);
  ReplayFigures figures;
  figures.file = options.file;
  figures.verified = options.verify;
  figures.isa = workers.isa();
  figures.threads = workers.threads();
  take_span(player, options, figures);
  Progress progress(options.file, progress_count(std::max<std::uint64_t>(figures.to - figures.from, 1)),
                    !options.quiet);
  naming(options.file, [&] {
    // The timeline is of the steps that were asked for, not of those that lead there.
    Workers untraced({.threads = options.threads, .isa = options.isa});
    player.seek(figures.from, untraced);
    if (options.verify) {
      verify(player.keyframe_steps(), progress, figures,
             [&](std::uint64_t begin, std::uint64_t end) { return player.verify(begin, end, workers); });
    } else {
      play(player, workers, progress, figures, [&] {
        if (trace) trace->count({&player.world().stats()});
      });
    }
  });
  if (trace) figures.trace = trace->finish(options.trace);
  progress.finish();
  figures.hash = player.world().hash();
  figures.recorded_hash = player.recorded_hash();
  return figures;
}

ReplayFigures replay(const ReplayOptions& options, Team& team) {
  check_backend(options.threads, options.isa);
  if (!options.trace.empty()) throw Error("--trace " + options.trace + ": not with --distributed yet");
  // What all of them find before they begin is told by one of them.
  if (options.from && options.to) check_order(*options.from, *options.to);
  if (!std::ifstream(options.file)) throw Error(options.file + ": cannot be read", ErrorCode::io_failure);
  Workers workers(WorkersOptions{.threads = team.threads_each(options.threads), .isa = options.isa});
  ReplayFigures figures;
  figures.file = options.file;
  figures.verified = options.verify;
  figures.isa = workers.isa();
  figures.threads = workers.threads();
  figures.ranks = team.processes();
  DistributedPlayer player = team.play(options.file, options.from, workers);
  take_span(player, options, figures);
  Progress progress(options.file, progress_count(std::max<std::uint64_t>(figures.to - figures.from, 1)),
                    !options.quiet && team.leads());
  naming(options.file, [&] {
    if (options.verify) {
      verify(player.keyframe_steps(), progress, figures,
             [&](std::uint64_t, std::uint64_t end) { return player.verify(end, workers); });
    } else {
      play(player, workers, progress, figures, [] {});
    }
  });
  progress.finish();
  figures.hash = player.world().hash();
  figures.recorded_hash = player.recorded_hash();
  return figures;
}

InfoFigures inspect(const std::string& file) {
  Player player = open_recording(file);
  InfoFigures figures;
  figures.file = file;
  figures.info = player.info();
  figures.keyframe_steps.assign(player.keyframe_steps().begin(), player.keyframe_steps().end());
  figures.first_bodies = player.world().body_count();
  figures.first_shapes = player.world().shape_count();
  figures.last_bodies = figures.first_bodies;
  figures.last_shapes = figures.first_shapes;
  if (!figures.keyframe_steps.empty()) {
    Workers workers(1);  // a keyframe is a state: nothing is stepped
    naming(file, [&] { player.seek(figures.keyframe_steps.back(), workers); });
    figures.last_bodies = player.world().body_count();
    figures.last_shapes = player.world().shape_count();
  }
  return figures;
}

DiffFigures diff(const DiffOptions& options) {
  check_backend(options.threads, options.isa);
  Player a = open_recording(options.a);
  Player b = open_recording(options.b);
  tell_of_idle_threads(options.threads);
  Workers workers(WorkersOptions{.threads = options.threads, .isa = options.isa});
  DiffFigures figures;
  figures.a = options.a;
  figures.b = options.b;
  figures.first_a = a.info().first_step;
  figures.last_a = a.info().last_step;
  figures.first_b = b.info().first_step;
  figures.last_b = b.info().last_step;
  figures.divergence = naming(options.a + ", " + options.b, [&] { return compare(a, b, workers); });
  return figures;
}

}  // namespace scree::command
