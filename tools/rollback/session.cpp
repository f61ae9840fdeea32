// See session.h.
#include <tools/rollback/session.h>

#include <algorithm>
#include <string>

namespace scree::rollback {
namespace {

constexpr int kPatience =
    100'000;  // ticks beyond the steps, at most; longer waits mean that the link is broken

// Fails for NaN, too.
void check_range(const char* option, double value, double low, double high) {
  if (value >= low && value <= high) return;
  const auto text = [](double number) {
    std::string digits = std::to_string(number);
    digits.erase(digits.find_last_not_of('0') + 1);
    if (!digits.empty() && digits.back() == '.') digits.pop_back();
    return digits;
  };
  throw Error(std::string(option) + " " + text(value) + " must be from " + text(low) + " to " + text(high));
}

void check(const SessionOptions& options) {
  check_range("--steps", options.steps, 1, 1'000'000);
  check_range("--bodies", options.boxes, 0, 20'000);
  check_range("--delay", options.link.delay, 0, 1000);
  check_range("--jitter", options.link.jitter, 0, 1000);
  check_range("--loss", options.link.loss, 0, 95);
  check_range("--threads", options.threads, 0, 1024);
}

// A separate seed for each random part of a session.
std::uint64_t seed_of(std::uint64_t session, int part) {
  scenes::Random random(session);
  std::uint64_t seed = 0;
  for (int i = 0; i <= part; ++i) seed = random.next();
  return seed;
}

Link make_link(const SessionOptions& options, int direction) {
  LinkOptions link = options.link;
  link.seed = seed_of(options.link.seed, 2 + direction);
  return Link(link);
}

int first_difference(const std::vector<std::uint64_t>& expected, const std::vector<std::uint64_t>& actual) {
  const auto place = std::mismatch(expected.begin(), expected.end(), actual.begin(), actual.end());
  if (place.first == expected.end() && place.second == actual.end()) return -1;
  return static_cast<int>(place.first - expected.begin());
}

}  // namespace

bool SessionReport::is_sound() const {
  return first_difference < 0 &&
         std::all_of(hashes.begin(), hashes.end(),
                     [&](std::uint64_t hash) { return hash == expected_hash; }) &&
         std::all_of(peers.begin(), peers.end(),
                     [](const PeerFigures& peer) { return peer.hashes_different == 0; });
}

SessionReport run_session(const SessionOptions& options) {
  check(options);
  Workers workers(options.threads);
  const auto make_peer = [&](int player) {
    return Peer(player, options.boxes, options.steps, Hands(seed_of(options.link.seed, player)), workers);
  };
  Peer first = make_peer(0), second = make_peer(1);
  Link to_second = make_link(options, 0), to_first = make_link(options, 1);
  SessionReport report;
  while (!first.is_done() || !second.is_done()) {
    if (report.ticks > options.steps + kPatience) throw Error("the link lets nothing through");
    first.tick(report.ticks, to_first, to_second);
    second.tick(report.ticks, to_second, to_first);
    ++report.ticks;
  }
  // The referee's machine differs: one thread, one lane.
  Workers judge(WorkersOptions{.threads = 1, .isa = Isa::scalar});
  std::vector<Inputs> inputs(static_cast<std::size_t>(options.steps));
  for (std::size_t i = 0; i < inputs.size(); ++i) inputs[i] = {first.inputs()[i], second.inputs()[i]};
  const std::vector<std::uint64_t> expected = play_with_perfect_knowledge(options.boxes, inputs, judge);
  report.expected_hash = expected.back();
  for (const Peer* peer : {&first, &second}) {
    const std::size_t place = peer == &first ? 0 : 1;
    const std::vector<std::uint64_t> hashes = peer->hashes();
    const int difference = first_difference(expected, hashes);
    if (difference >= 0 && (report.first_difference < 0 || difference < report.first_difference)) {
      report.first_difference = difference;
    }
    report.hashes[place] = hashes.back();
    report.peers[place] = peer->figures();
  }
  report.packets = to_first.sent() + to_second.sent();
  report.lost_packets = to_first.lost() + to_second.lost();
  return report;
}

}  // namespace scree::rollback
