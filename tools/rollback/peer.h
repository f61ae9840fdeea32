// One of the two players' machines: it never waits for the other's input, it predicts it; and when the input
// that arrives is another one, it goes back to the step that was predicted wrong and steps on from there.
#pragma once

#include <tools/rollback/game.h>
#include <tools/rollback/link.h>

#include <array>
#include <cstdint>
#include <map>
#include <vector>

namespace scree::rollback {

/// Steps that a peer goes back at most, and so runs ahead of the other's inputs: a snapshot each.
inline constexpr int kWindow = 12;

/// How often something was done, and how long it took.
struct Cost {
  std::int64_t count = 0;
  double total_ms = 0.0;
  double max_ms = 0.0;

  void add(double ms);
  double mean_ms() const { return count > 0 ? total_ms / static_cast<double>(count) : 0.0; }
};

struct PeerFigures {
  std::int64_t rollbacks = 0;
  std::int64_t longest_rollback = 0;  ///< steps
  std::int64_t stalls = 0;            ///< ticks without a step, as the window was exhausted
  std::int64_t hashes_compared = 0;   ///< with those that the other one sent
  std::int64_t hashes_different = 0;
  Cost save;
  Cost restore;
  Cost step;              ///< the first time
  Cost resimulated_step;  ///< again
  std::size_t window_bytes = 0;
};

class Peer {
 public:
  /// `player` is 0 or 1. Ends after `steps`.
  Peer(int player, int boxes, int steps, Hands hands, Workers& workers);

  /// Whatever a peer does in a 60th of a second: takes what has arrived, corrects the past, takes one step
  /// unless the other is too far behind, and sends.
  void tick(int now, Link& incoming, Link& outgoing);

  /// All steps are taken, and the other's inputs are known for all of them: nothing can change any more.
  bool is_done() const { return current_ == steps_ && known() == steps_; }
  const std::vector<Input>& inputs() const { return mine_; }
  /// Of the state before each step, and of the end. Final once the peer is done.
  std::vector<std::uint64_t> hashes() const;
  PeerFigures figures() const;

 private:
  int known() const { return static_cast<int>(theirs_.size()); }
  Input predict(int step) const;
  void take(const Packet& packet);
  void correct_the_past();
  void compare_hashes();
  void take_step(int step, Cost& cost);
  Packet make_packet() const;

  int player_;
  int steps_;
  Hands hands_;
  Workers& workers_;
  Game game_;
  int current_ = 0;                            // steps taken
  std::vector<Input> mine_;                    // by step
  std::vector<Input> theirs_;                  // by step, as far as they have arrived
  std::vector<Input> assumed_;                 // by step: what of theirs the step was taken with
  int first_wrong_;                            // step that was taken with a wrong assumption; steps_: none
  int acknowledged_ = 0;                       // of mine_, which the other has
  std::array<Snapshot, kWindow> window_;       // before step s: s % kWindow
  std::vector<std::uint64_t> hashes_;          // before each step
  std::map<int, std::uint64_t> their_hashes_;  // by step; not compared yet
  PeerFigures figures_;
};

}  // namespace scree::rollback
