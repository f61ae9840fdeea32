// One of the two players' machines. It never waits for the other's input but predicts it. When a different
// input arrives, it goes back to the first wrongly predicted step and steps on from there.
#pragma once

#include <tools/rollback/game.h>
#include <tools/rollback/link.h>

#include <array>
#include <cstdint>
#include <map>
#include <vector>

namespace scree::rollback {

/// Largest number of steps that a peer goes back, and so runs ahead of the other's inputs: a snapshot each.
inline constexpr int kWindow = 12;

/// How often an operation ran, and how long it took.
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
  std::int64_t hashes_compared = 0;   ///< with hashes that the other peer sent
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

  /// The work of a peer in a 60th of a second: receives packets, corrects the past, takes one step unless the
  /// other peer is too far behind, and sends.
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
  std::vector<Input> theirs_;                  // by step, up to the last that arrived
  std::vector<Input> assumed_;                 // by step: the other's input that the step used
  int first_wrong_;                            // step that was taken with a wrong assumption; steps_: none
  int acknowledged_ = 0;                       // of mine_, which the other has
  std::array<Snapshot, kWindow> window_;       // before step s: s % kWindow
  std::vector<std::uint64_t> hashes_;          // before each step
  std::map<int, std::uint64_t> their_hashes_;  // by step; not compared yet
  PeerFigures figures_;
};

}  // namespace scree::rollback
