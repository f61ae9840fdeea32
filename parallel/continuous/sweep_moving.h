// Fast bodies that meet others that move; part of sweep_fast_bodies.cpp.
#pragma once

#include <parallel/broad_phase/broad_phase.h>

#include <algorithm>

namespace scree::sweeps {

// The place of a body among those that are swept, which ascend; -1: it is not.
inline std::int32_t place_of(const Column<std::int32_t>& fast, std::int32_t body) {
  const auto* const found = std::lower_bound(fast.begin(), fast.end(), body);
  return found != fast.end() && *found == body ? static_cast<std::int32_t>(found - fast.begin()) : -1;
}

// Notes the fast kinematic bodies, which nothing stops, and dynamic ones that they may meet: these are swept.
void note_fast_kinematic_bodies(WorldData& data, float dt);

// Lists the pairs of fast bodies with others that move, which one may pass.
void list_chases(WorldData& data, BroadPhase& broad_phase, float dt, Crew& crew);
// Keeps the centers of shapes of these that touch on their sides.
void hold_at_moving(WorldData& data, BroadPhase& broad_phase);

// Ends the steps of fast bodies where they meet each other or what moves slowly. `step_ends` are known as far
// as what rests is concerned.
void end_at_moving(WorldData& data, BroadPhase& broad_phase, Crew& crew);

}  // namespace scree::sweeps
