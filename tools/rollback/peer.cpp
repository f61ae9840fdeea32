// Prediction, rollback, re-simulation; see peer.h.
#include <tools/rollback/peer.h>

#include <algorithm>
#include <chrono>
#include <utility>

namespace scree::rollback {
namespace {

template <class Work>
double milliseconds_of(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

void Cost::add(double ms) {
  ++count;
  total_ms += ms;
  max_ms = std::max(max_ms, ms);
}

Peer::Peer(int player, int boxes, int steps, Hands hands, Workers& workers)
    : player_(player), steps_(steps), hands_(hands), workers_(workers), game_(boxes), first_wrong_(steps) {
  assumed_.resize(static_cast<std::size_t>(steps));
  hashes_.resize(static_cast<std::size_t>(steps));
}

void Peer::tick(int now, Link& incoming, Link& outgoing) {
  for (const Packet& packet : incoming.receive(now)) take(packet);
  correct_the_past();
  compare_hashes();
  if (current_ < steps_) {
    // The oldest step that may still turn out wrong is known(): its snapshot must stay in the window.
    if (current_ - known() < kWindow) {
      mine_.push_back(hands_.next());
      take_step(current_, figures_.step);
      ++current_;
    } else {
      ++figures_.stalls;
    }
  }
  outgoing.send(now, make_packet());
}

// Players hold keys for longer than a step, so it predicts the last known input again.
Input Peer::predict(int step) const {
  const auto index = static_cast<std::size_t>(step);
  if (index < theirs_.size()) return theirs_[index];
  return theirs_.empty() ? Input{} : theirs_.back();
}

void Peer::take(const Packet& packet) {
  acknowledged_ = std::max(acknowledged_, packet.received);
  if (packet.hashed_step >= 0) their_hashes_[packet.hashed_step] = packet.hash;
  for (std::size_t i = 0; i < packet.inputs.size(); ++i) {
    const int step = packet.first_step + static_cast<int>(i);
    if (step != known()) continue;  // known already: packets repeat inputs and overtake each other
    theirs_.push_back(packet.inputs[i]);
    if (step < current_ && !(assumed_[static_cast<std::size_t>(step)] == packet.inputs[i])) {
      first_wrong_ = std::min(first_wrong_, step);
    }
  }
}

void Peer::correct_the_past() {
  if (first_wrong_ >= current_) return;
  const Snapshot& past = window_[static_cast<std::size_t>(first_wrong_ % kWindow)];
  figures_.restore.add(milliseconds_of([&] { restore(game_.world(), past); }));
  ++figures_.rollbacks;
  figures_.longest_rollback =
      std::max(figures_.longest_rollback, static_cast<std::int64_t>(current_ - first_wrong_));
  for (int step = first_wrong_; step < current_; ++step) take_step(step, figures_.resimulated_step);
  first_wrong_ = steps_;
}

void Peer::take_step(int step, Cost& cost) {
  const auto index = static_cast<std::size_t>(step);
  // Also when stepping again: the snapshots taken after a wrong step are wrong, too.
  figures_.save.add(milliseconds_of([&] { save(game_.world(), window_[index % kWindow]); }));
  hashes_[index] = game_.world().hash();
  assumed_[index] = predict(step);
  Inputs inputs;
  inputs[static_cast<std::size_t>(player_)] = mine_[index];
  inputs[static_cast<std::size_t>(1 - player_)] = assumed_[index];
  cost.add(milliseconds_of([&] { game_.advance(inputs, workers_); }));
}

// A state is final when all inputs before it are known. So peers detect a divergence, which needs a defect in
// the game or in the engine, long before the players notice.
void Peer::compare_hashes() {
  while (!their_hashes_.empty()) {
    const auto [step, hash] = *their_hashes_.begin();
    if (step > known() || step >= current_) return;
    ++figures_.hashes_compared;
    if (hash != hashes_[static_cast<std::size_t>(step)]) ++figures_.hashes_different;
    their_hashes_.erase(their_hashes_.begin());
  }
}

Packet Peer::make_packet() const {
  Packet packet;
  packet.first_step = acknowledged_;
  packet.inputs.assign(mine_.begin() + acknowledged_, mine_.end());
  packet.received = known();
  packet.hashed_step = std::min(known(), current_ - 1);
  if (packet.hashed_step >= 0) packet.hash = hashes_[static_cast<std::size_t>(packet.hashed_step)];
  return packet;
}

std::vector<std::uint64_t> Peer::hashes() const {
  std::vector<std::uint64_t> all(hashes_.begin(), hashes_.begin() + current_);
  all.push_back(game_.world().hash());
  return all;
}

PeerFigures Peer::figures() const {
  PeerFigures figures = figures_;
  for (const Snapshot& snapshot : window_) figures.window_bytes += snapshot.bytes();
  return figures;
}

}  // namespace scree::rollback
