// The program scree_rollback: plays a session and prints its costs. Exit codes: 0 all hashes agree, 1 hashes
// differ or the session failed, 2 bad input.
#include <tools/files/output_file.h>
#include <tools/rollback/session.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <iostream>

namespace scree::rollback {
namespace {

unsigned long long number(std::uint64_t value) { return value; }
long long number(std::int64_t value) { return value; }

void print_cost(const char* what, const Cost& cost) {
  std::printf("  %-20s %8lld times  %7.3f ms mean  %7.3f ms max\n", what, number(cost.count), cost.mean_ms(),
              cost.max_ms);
}

void print(const SessionOptions& options, const SessionReport& report) {
  std::printf("%d steps in %d ticks; %lld packets, %lld lost\n", options.steps, report.ticks,
              number(report.packets), number(report.lost_packets));
  for (std::size_t place = 0; place < report.peers.size(); ++place) {
    const PeerFigures& peer = report.peers[place];
    std::printf("peer %zu\n", place + 1);
    std::printf("  %-20s %8lld, the longest of %lld steps\n", "rollbacks", number(peer.rollbacks),
                number(peer.longest_rollback));
    std::printf("  %-20s %8lld ticks\n", "stalled", number(peer.stalls));
    print_cost("step", peer.step);
    print_cost("re-simulated step", peer.resimulated_step);
    print_cost("save", peer.save);
    print_cost("restore", peer.restore);
    std::printf("  %-20s %8.1f KiB for %d snapshots\n", "window",
                static_cast<double>(peer.window_bytes) / 1024.0, kWindow);
    std::printf("  %-20s %8lld, %lld of them different\n", "hashes compared", number(peer.hashes_compared),
                number(peer.hashes_different));
    std::printf("  %-20s %016llx\n", "hash", number(report.hashes[place]));
  }
  std::printf("perfect knowledge\n  %-20s %016llx\n", "hash", number(report.expected_hash));
  if (report.is_sound()) {
    std::printf("all agree\n");
  } else if (report.first_difference >= 0) {
    std::printf("DIFFERENT: a peer is not where it should be after %d steps\n", report.first_difference);
  } else {
    std::printf("DIFFERENT: the peers told each other different hashes on the way\n");
  }
}

int run(int argc, char** argv) {
  CLI::App app(
      "Two peers play a game over a link with delay and loss: each predicts what the other one presses, and "
      "rolls "
      "back where it was wrong.",
      "scree_rollback");
  SessionOptions options;
  app.add_option("--steps", options.steps, "Steps of 1/60 s (default 600)");
  app.add_option("--bodies", options.boxes, "Boxes in the pile (default 300)");
  app.add_option("--delay", options.link.delay, "Ticks of 1/60 s that a packet takes, one way (default 4)");
  app.add_option("--jitter", options.link.jitter,
                 "Ticks that it takes longer, at most, at random (default 2)");
  app.add_option("--loss", options.link.loss, "Percent of the packets that are lost, 0 to 95 (default 10)");
  app.add_option("--seed", options.link.seed, "Seed of the link and of the inputs (default 1)");
  app.add_option("--threads", options.threads, "Threads of each peer (default 0: one per core)");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const SessionReport report = run_session(options);
  print(options, report);
  return report.is_sound() ? 0 : 1;
}

}  // namespace
}  // namespace scree::rollback

int main(int argc, char** argv) {
  scree::files::prepare_process();
  try {
    const int exit_code = scree::rollback::run(argc, argv);
    scree::files::write_standard_output("");  // what was printed is there, too
    return exit_code;
  } catch (const scree::Error& error) {
    std::cerr << "scree_rollback: " << error.what() << "\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "scree_rollback: " << error.what() << "\n";
    return 1;
  }
}
