// The program behind tools/soak: random scenes, recorded on one backend and replayed on all, until time is up
// or results differ. Exit codes: 0 no difference, 1 a difference or failure, 2 bad input.
#include <tools/files/output_file.h>
#include <tools/soak_program/golden.h>
#include <tools/soak_program/round.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

namespace scree::soak {
namespace {

using Clock = std::chrono::steady_clock;

volatile std::sig_atomic_t g_interrupted = 0;  // by Ctrl-C: the round is finished, the summary printed

void interrupt(int) {
  g_interrupted = 1;
  std::signal(SIGINT, SIG_DFL);  // a second Ctrl-C ends the program at once
}

struct Options {
  double minutes = 60.0;
  std::int64_t rounds = 0;  // 0: as many as time allows
  std::uint64_t seed = 0;
  bool golden = false;
  bool update_golden = false;
  std::string golden_file = SCREE_SOAK_GOLDEN;
  std::string keep = "soak_recordings";
  std::vector<std::string> files;
};

void print_summary(const Tally& tally, std::int64_t golden_hashes, Clock::time_point start) {
  const double minutes = std::chrono::duration<double, std::ratio<60>>(Clock::now() - start).count();
  std::printf(
      "%lld %s in %.1f minutes: %lld steps, %lld bodies; %lld hashes and %lld whole states compared\n",
      static_cast<long long>(tally.rounds), tally.rounds == 1 ? "round" : "rounds", minutes,
      static_cast<long long>(tally.steps), static_cast<long long>(tally.bodies),
      static_cast<long long>(tally.hashes + golden_hashes), static_cast<long long>(tally.states));
}

int report(const Failure& failure) {
  std::printf("\nDIFFERENT: %s\nonce more: %s\n", failure.what.c_str(), failure.command.c_str());
  return 1;
}

int soak(const Options& options) {
  Rounds rounds(options.keep);
  GoldenMatrix matrix(options.golden_file, options.keep);
  const Clock::time_point start = Clock::now();
  const auto minutes_passed = [&] {
    return std::chrono::duration<double, std::ratio<60>>(Clock::now() - start).count();
  };
  std::optional<Failure> failure;
  for (const std::string& file : options.files) {
    if (!failure && g_interrupted == 0) failure = rounds.verify_file(file);
  }
  if (!failure && options.golden && g_interrupted == 0) failure = matrix.check();
  for (std::uint64_t round = 0; !failure && g_interrupted == 0 && minutes_passed() < options.minutes;
       ++round) {
    if (options.rounds > 0 && round == static_cast<std::uint64_t>(options.rounds)) break;
    failure = rounds.play(options.seed + round);
  }
  const int exit_code = failure ? report(*failure) : 0;
  print_summary(rounds.tally(), matrix.hashes_compared(), start);
  return exit_code;
}

int run(int argc, char** argv) {
  CLI::App app(
      "Records random scenes on random backends and replays them on all others, until time is up or a hash "
      "differs.",
      "scree_soak");
  Options options;
  app.add_option("FILES", options.files, "Recordings to verify first, on every instruction set");
  app.add_option("--minutes", options.minutes,
                 "How long; the last round is finished (default 60; 0: no rounds)");
  app.add_option("--rounds", options.rounds, "Largest number of rounds (default 0: as many as time allows)");
  const CLI::Option* seed = app.add_option("--seed", options.seed,
                                           "Of the first round; the next ones count on "
                                           "(default: from the clock)");
  app.add_option("--keep", options.keep, "Folder for recordings that differ (default soak_recordings)");
  app.add_flag("--golden", options.golden, "Play the long golden matrix before the rounds");
  app.add_option("--golden-file", options.golden_file, "The runs of the golden matrix and their hashes");
  app.add_flag("--update-golden", options.update_golden,
               "Rewrite the hashes of the golden matrix and do nothing else");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (!(options.minutes >= 0.0)) throw Error("--minutes must not be negative");
  if (options.rounds < 0) throw Error("--rounds must not be negative");
  if (seed->empty()) {
    options.seed =
        static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count()) % 1'000'000;
  }
  if (options.update_golden) {
    GoldenMatrix(options.golden_file, options.keep).update();
    return 0;
  }
  return soak(options);
}

}  // namespace
}  // namespace scree::soak

int main(int argc, char** argv) {
  std::signal(SIGINT, scree::soak::interrupt);
  scree::files::prepare_process();
  try {
    const int exit_code = scree::soak::run(argc, argv);
    scree::files::write_standard_output("");  // what was printed is there, too
    return exit_code;
  } catch (const scree::Error& error) {
    std::cerr << "scree_soak: " << error.what() << "\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "scree_soak: " << error.what() << "\n";
    return 1;
  }
}
