// A simulated link: packets arrive late, out of order, or not at all. Time is counted in ticks, one a step.
#pragma once

#include <tools/rollback/game.h>

#include <cstdint>
#include <vector>

namespace scree::rollback {

/// What a peer sends at every tick. Until the other one has acknowledged an input it is in every packet, so
/// that a lost packet needs no repair of its own.
struct Packet {
  int first_step = 0;         ///< of `inputs`
  std::vector<Input> inputs;  ///< the sender's own, all that are not acknowledged
  int received = 0;           ///< acknowledges as many of the receiver's inputs
  int hashed_step = -1;       ///< a step before which the sender's state is final ...
  std::uint64_t hash = 0;     ///< ... and its hash, for the receiver to compare
};

struct LinkOptions {
  int delay = 4;       ///< ticks, one way
  int jitter = 2;      ///< ticks, at most so many more, at random
  double loss = 10.0;  ///< percent of the packets
  std::uint64_t seed = 1;
};

/// One direction of the link.
class Link {
 public:
  explicit Link(const LinkOptions& options) : options_(options), random_(options.seed) {}

  void send(int tick, Packet packet);
  /// What has arrived by then, and was not received yet: earliest first.
  std::vector<Packet> receive(int tick);

  std::int64_t sent() const { return sent_; }
  std::int64_t lost() const { return lost_; }

 private:
  struct Traveler {
    int arrival = 0;
    Packet packet;
  };

  LinkOptions options_;
  scenes::Random random_;
  std::vector<Traveler> under_way_;
  std::int64_t sent_ = 0;
  std::int64_t lost_ = 0;
};

}  // namespace scree::rollback
