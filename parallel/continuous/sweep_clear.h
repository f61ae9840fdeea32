// Proofs that two shapes do not come near each other in a step; part of sweep_moving.cpp, which follows the
// balls of the others.
#pragma once

#include <core/world/world_data.h>
#include <parallel/continuous/sweep_motion.h>

#include <cstdint>

namespace scree::sweeps {

// m; a ball's way leaves the chords that are swept by less.
inline constexpr float kMostBend = 0.2f * kLinearSlop;

// A body from a moment to the end of the step.
struct Leg {
  Vec3 start;         // center of mass as the step begins
  DeltaRow from, to;  // at that moment and at the end
  float turn, bow;    // as in Course; infinite bow: nothing is known
};

// `stop`: the time after which the body stands still.
Leg leg_of(const Course& course, float stop, float from);

// Whether no chord of a ball of the shape's, in the frame of the obstacle's body, comes as near as contacts
// look to the ball around the obstacle. May miss that, but is never wrong.
bool stays_clear(const WorldData& data, std::int32_t shape, const Leg& leg, std::int32_t obstacle,
                 const Leg& other);

// Whether no ball of one of two shapes touches the other one as the step begins; the same.
bool starts_clear(const WorldData& data, std::int32_t a, std::int32_t b);

}  // namespace scree::sweeps
