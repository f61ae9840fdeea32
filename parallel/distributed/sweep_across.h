// Sweeps of fast bodies that meet bodies of other ranks; part of ../continuous/sweep_fast_bodies.cpp.
//
// A rank sweeps its own bodies. Fast bodies that may meet each other form chains, and what happens in a chain
// goes in the order of time: so one rank decides for all of it, the owner of its smallest body. The others
// send that rank the chain's bodies, and get back where their steps end. Chains of one rank's bodies alone
// stay there, and slow or kinematic bodies tie no chains: nothing stops them.
#pragma once

#include <parallel/broad_phase/broad_phase.h>
#include <parallel/crew/crew.h>
#include <parallel/distributed/border.h>

#include <cstdint>
#include <vector>

namespace scree {

class BoxIndex;

// The stages of a step's sweeps between which ranks talk. Does nothing in a world that is not divided.
class SweepAcross {
 public:
  SweepAcross(WorldData& data, BroadPhase& broad_phase, Crew& crew)
      : border_(border_of(data)), data_(data), broad_phase_(broad_phase), crew_(crew) {}

  // BroadPhase::fast has the own bodies that are fast: adds the ghosts that are, as their owners say. Returns
  // whether there are any in the whole world; else there is nothing to sweep on any rank.
  bool share_fast();
  // Brings sleeping bodies of other ranks that lie on the ways of fast ones, which forces of this step may
  // have led out of the bounds that ghosts were found by ...
  void bring_sleepers();
  // ... and on those of bodies that others carry on, which is known when ends are.
  void bring_sleepers_to_carried();
  // BroadPhase::meeting_pairs has the pairs that may meet, and step_ends the time that bodies make up for:
  // keeps the pairs that this rank decides about, and brings their bodies. Both lists of bodies grow by
  // these.
  void bring_chains();
  // What holds touching bodies apart has changed their ways: tells their owners.
  void return_ways();
  // Ends of steps at what rests are known: tells those who decide about the chains.
  void send_ends();
  // Ends of steps are known: tells the owners.
  void return_ends();
  // Ghosts end their steps as their owners say.
  void share_ends();

 private:
  // Own bodies that another rank decides about, or bodies of another rank that this one does.
  struct Visit {
    std::vector<std::int32_t> sent, received;
  };
  template <class Take>
  void exchange(std::vector<std::int32_t> Visit::*sent, std::vector<std::int32_t> Visit::*received,
                Take&& take);
  void bring_sleepers(const std::vector<BoundsRow>& ways);
  std::vector<std::int32_t> sleepers_on(const BoxIndex& ways, std::int32_t rank) const;
  bool is_own_fast(std::int32_t place) const;
  bool keep_known_pairs();
  std::vector<std::int32_t> link_chains() const;
  void spread_chains(std::vector<std::int32_t>& chain_of);
  void send_chains(const std::vector<std::int32_t>& chain_of);
  void admit(std::vector<std::int32_t> visitors, const std::vector<sweeps::MovingPair>& pairs);

  Border* border_;
  WorldData& data_;
  BroadPhase& broad_phase_;
  Crew& crew_;
  bool any_asleep_ = false;         // in the whole world
  bool has_chains_ = false;         // that reach over ranks, in the whole world
  std::vector<Visit> visits_ = {};  // by rank
};

}  // namespace scree
