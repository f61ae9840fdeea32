// Proofs that two shapes do not come near each other in a step; part of sweep_moving.cpp, which follows the
// balls of the others.
#pragma once

#include <core/geometry/balls.h>
#include <core/world/world_data.h>
#include <parallel/continuous/sweep_motion.h>

#include <cstdint>

namespace scree::sweeps {

// m; a ball's way leaves the chords that are swept by less.
inline constexpr float kMostBend = 0.2f * kLinearSlop;

// A body from a moment to the end of the step.
struct Leg {
  Vec3 start;             // center of mass as the step begins
  DeltaRow from, to;      // at that moment and at the end
  float turn, rate, bow;  // as in Course; infinite bow: nothing is known
};

// `stop`: the time after which the body stands still.
Leg leg_of(const Course& course, float stop, float from);

// A shape's way in the frame of an obstacle that a box holds.
struct Passage {
  Vec3 place[2];    // of the shape's origin, at the beginning of the leg and at its end
  Vec3 axes[2][3];  // of the shape
  Vec3 half;        // m, of the obstacle's box, and by how much more chords of the balls' ways may reach it
  bool is_boxed;    // else all else is empty
};

// Whether one plane, fixed in the world, parts two balls or capsules by more than contacts look, from a
// moment to the end of the step. May miss that, but is never wrong.
bool stay_parted(const WorldData& data, const std::int32_t (&shape)[2], const Leg (&leg)[2]);
// Whether no chord of the way of any ball of the shape, in the frame of the obstacle's body, comes as near to
// what holds the obstacle as contacts look. May miss that, but is never wrong. `passage`: for what may come
// near.
bool stays_clear(const WorldData& data, std::int32_t shape, const Leg& leg, std::int32_t obstacle,
                 const Leg& other, Passage& passage);
// The same of one of the balls, which is in the shape's frame.
bool stays_clear(const Passage& passage, const Ball& ball);

// A box that holds an obstacle where the step begins; of meshes and half-spaces there is none.
struct ObstacleBox {
  Vec3 origin;
  Quat back;    // into the obstacle's axes
  Vec3 half;    // m
  float scale;  // m, of the coordinates that places of balls come from
  bool is_there;
};
// `start`, `other`: centers of mass of the ball's body and of the obstacle's, as the step begins.
ObstacleBox box_about(const WorldData& data, std::int32_t obstacle, Vec3 start, Vec3 other);
// Whether no point of the line between two comes within `room`, m, and the slop of the box. May miss that,
// but is never wrong.
bool stays_beside(const ObstacleBox& box, Vec3 from, Vec3 to, float room);

// Whether no ball of one of two shapes touches the other one as the step begins; the same.
bool starts_clear(const WorldData& data, std::int32_t a, std::int32_t b);

}  // namespace scree::sweeps
