// A session: two peers, the link between them, and a referee that knows all inputs from the beginning.
#pragma once

#include <tools/rollback/peer.h>

#include <array>
#include <cstdint>

namespace scree::rollback {

struct SessionOptions {
  int steps = 600;
  int boxes = 300;
  LinkOptions link;  ///< of both directions; the seed also determines the players' inputs
  int threads = 0;   ///< of each peer; 0: one per core
};

struct SessionReport {
  std::array<PeerFigures, kPlayers> peers;
  std::array<std::uint64_t, kPlayers> hashes{};  ///< at the end
  std::uint64_t expected_hash = 0;               ///< of the referee
  /// The first state in which a peer differs from the referee, by the number of steps before it; -1: none.
  int first_difference = -1;
  int ticks = 0;  ///< of the session; without stalls the number of steps plus the link's delay
  std::int64_t packets = 0;
  std::int64_t lost_packets = 0;

  /// Both peers agree with the referee in every state, and with each other in all states that they compared.
  bool is_sound() const;
};

/// Throws scree::Error for options outside their ranges, which it names, and for a link so bad that the peers
/// get nowhere.
SessionReport run_session(const SessionOptions& options);

}  // namespace scree::rollback
