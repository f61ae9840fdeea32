// How a fast body moves within a step, for what is swept along its way; see sweep_fast_bodies.cpp.
#pragma once

#include <core/geometry/balls.h>
#include <core/world/world_data.h>

#include <algorithm>

namespace scree::sweeps {

// A body's motion in the step: along a straight way, while its long axis swings by the shorter way and the
// rest turns about that. So a stick that spins about itself goes where its axis does, and not around a cone
// into the ground.
struct Motion {
  Vec3 way;
  Quat swing, twist;  // twist first
};

// `axis`: a unit vector, or zero.
Motion motion_of(const DeltaRow& delta, Vec3 axis);
// Up to time t, 0 to 1.
DeltaRow part_of(const Motion& motion, float t);
Quat part_of(Quat turn, float t);

// From a body's center of mass to a point of one of its shapes, as the step begins.
Vec3 arm_of(const WorldData& data, std::int32_t body, std::int32_t shape, Vec3 in_shape);

// balls_of() without copying those that hulls keep; `made` is for the others.
const Balls& balls_at(const WorldData& data, std::int32_t shape, Balls& made);

// The axis of a body's least inertia as the step begins, which is that of a stick; zero where it has none.
Vec3 long_axis_of(const WorldData& data, std::int32_t body);

// Where the centers of a body's balls lie as the step begins.
struct Arms {
  Vec3 axis;            // long_axis_of()
  float reach = 0.0f;   // m, the largest distance from the center of mass
  float beside = 0.0f;  // m, from the axis
};

Arms arms_of(const WorldData& data, std::int32_t body);

// A body on its way through the step.
struct Mover {
  Vec3 start;     // center of mass as the step begins
  Motion motion;  // of the whole step
  float stop;     // time after which it stands still

  bool stands_at(float t) const { return t >= stop; }
  DeltaRow delta_at(float t) const { return part_of(motion, std::min(t, stop)); }
};
Mover mover_of(const WorldData& data, std::int32_t body, float stop);

// What a body's pairs share when it is followed.
struct Course {
  Mover mover;          // that nothing stops
  DeltaRow begin, end;  // at the times 0 and 1
  float turn;           // chord_of()
  float rate;           // rate_of()
  float bow;            // m for an arm of 1 m; see bow_of()
};
Course course_of(const WorldData& data, std::int32_t body);

// m, by which the end of an arm of 1 m leaves, as the body turns, the straight line between where it is at
// the step's beginning and end, at any time; see sweep_clear.cpp.
float bow_of(const Motion& motion);
// m, by which the turn of the whole motion moves the end of an arm of 1 m, at most.
float chord_of(const Motion& motion);
// rad per step, at most, at any time of the motion.
float rate_of(const Motion& motion);

// m, the most that the center of any ball moves in the step; an upper bound.
float farthest_way(const CoreRow& core, const DeltaRow& delta);
// Whether the body's motion may bring a core into something that its ball did not touch.
bool is_fast(const CoreRow& core, const DeltaRow& delta);
bool has_finite_motion(const DeltaRow& delta);
// Whether the body may rebound from the shape.
bool may_rebound(const WorldData& data, std::int32_t body, std::int32_t obstacle);

// Joints would not hold what goes on without them.
inline bool is_jointed(const WorldData& data, std::int32_t body) {
  return (data.bodies.motion[body].flags & std::uint32_t{kMotionJointed}) != 0;
}

// A sweep that puts a body back may raise it without slowing it. A body with contacts gives that energy up:
// its speed along gravity, downward or upward, is cut, to 0 at most. What falls freely goes back along its
// parabola instead, and what is jointed does neither. (Giving the energy back where the body makes up for its
// time changed nothing.)
void pay_for_height(WorldData& data, std::int32_t body, Vec3 back);

// Where the step of a swept body ends.
struct StepEnd {
  float time = 2.0f;      // 0 to 1: it was stopped there; sweeps::kNever: it was not
  bool held = false;      // by what it touched: a part of its way was taken off
  bool rebounds = false;  // from what stopped it
  Vec3 carried{};         // m, by what stopped it and moves on
  float lag = 0.0f;       // s, that the body makes up for in this step
};

// Shapes of two bodies that move and may pass through each other.
struct MovingPair {
  std::int32_t shape[2];
  std::int32_t place[2];  // of their bodies among those that are swept; -1: nothing stops it
};

// What comes next in a step: a pair meets, or (pair -1) a swept body what rests.
struct Meet {
  float time;
  std::int32_t pair;
  std::int32_t place;  // of the body that meets what rests
  int stopped;         // bodies of the pair that had stopped when this was found
};

// rad, in the whole motion, by a ball that lies at `arms`.
float turn_of(const Motion& motion, const Arms& arms);

}  // namespace scree::sweeps
