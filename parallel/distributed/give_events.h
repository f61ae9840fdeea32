// What is remembered of bodies for the events of the next step, which goes with them to another rank: which
// shapes touch, what sensors see, which bodies have woken. Used by give_bodies.cpp.
#pragma once

#include <core/world/world_data.h>
#include <parallel/distributed/border.h>

#include <cstdint>
#include <span>
#include <vector>

namespace scree {

// Who receives what is known of two bodies: those that get one of them from here and have had neither.
struct Receivers {
  std::int32_t ranks[2] = {-1, -1};
  int count = 0;
};
inline Receivers receivers_of(const Border& border, const std::vector<std::int32_t>& next_owner,
                              std::int32_t body_a, std::int32_t body_b) {
  Receivers to;
  for (const std::int32_t body : {body_a, body_b}) {
    if (!border.owns(body)) continue;
    const std::int32_t rank = next_owner[static_cast<std::size_t>(body)];
    if (rank == border.owner_of(body_a) || rank == border.owner_of(body_b)) continue;
    if (to.count == 0 || to.ranks[0] != rank) to.ranks[to.count++] = rank;
  }
  return to;
}

// Whether both shapes and both bodies live.
bool is_there(const WorldData& data, const TouchingPair& pair);

struct SentEvents {
  std::vector<TouchRow> touching = {};
  std::vector<TouchingPair> sensed = {};
  std::vector<SlotName> woken = {};
};

// By receiver, of which there are so many: what goes there. No pair may be at rest.
std::vector<SentEvents> pack_events(const WorldData& data, const Border& border,
                                    const std::vector<std::int32_t>& next_owner, std::size_t receivers);
// Of this rank, for a file: what has gone since the last step, or is everybody's by now. No body takes it
// along.
void append_left_events(const WorldData& data, SentEvents& sent);
// Bodies have become everybody's or one rank's: who tells of a pair with one of them from now on learns
// whether it touches. All ranks call it together, for the same bodies.
void share_events_of(WorldData& data, Border& border, std::span<const std::int32_t> bodies);
// What sensors of everybody's bodies see of such bodies all ranks tell: all of them learn what any knows. All
// ranks call it together.
void share_common_events(WorldData& data, Border& border);
// Forgets, of what touched or was seen in the last step, what another rank tells of by now.
void forget_untold(const WorldData& data, const Border& border, Column<TouchRow>& rows);
void forget_untold(const WorldData& data, const Border& border, Column<TouchingPair>& rows);
void send_events(Transport& transport, std::int32_t to, const SentEvents& sent);
void receive_events(Transport& transport, std::int32_t from, SentEvents& received);
// Owners have changed: forgets what this rank no longer tells of, and adds what it has received.
void take_events(WorldData& data, const Border& border, SentEvents& received);

}  // namespace scree
