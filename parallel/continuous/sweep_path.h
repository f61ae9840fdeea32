// When a ball that moves along a straight way meets an obstacle: what sweep_fast_bodies.cpp and
// sweep_mesh.cpp share; the former tells what a sweep is.
//
// An obstacle has `shape`, its row, and distance_at(path, t): how far the path is from it at time t, which is
// a convex function along the path.
#pragma once

#include <core/geometry/balls.h>
#include <core/plain/rows.h>
#include <core/world/math.h>

#include <algorithm>
#include <cstdint>

namespace scree::sweeps {

inline constexpr float kNever = 2.0f;  // times run from 0 to 1

// Distance of a point that moves along a line from a convex shape, negative within, its slope by time, and
// the unit vector by which it grows; both are zero within boxes. Along a line it is a convex function: a
// tangent never overestimates it.
struct Distance {
  float value, slope;
  Vec3 normal;
};

inline Distance from_core(Vec3 way, Vec3 velocity, float radius) {
  const float far = length(way);
  if (!(far > 0.0f)) return {far - radius, 0.0f, {}};
  return {far - radius, dot(way, velocity) / far, (1.0f / far) * way};
}

// What balls are swept against: shapes that they touch when the step begins, the others, or all.
enum class Against { touched, others, all };

// A point at `start` + t `motion` in the frame of an obstacle.
struct Path {
  Vec3 start, motion;
};

// When the path comes as near as `target`; kNever if it does not. Newton's method on a convex function comes
// nearer from one side, so no meeting is missed. Goes on from `t`, where `distance` has been found.
template <class Obstacle>
float first_within(const Obstacle& obstacle, const Path& path, float target, float tolerance, float t,
                   Distance& distance) {
  constexpr int kIterations = 32;  // four or five are usual
  for (int i = 0; i < kIterations; ++i) {
    if (!(distance.slope < 0.0f)) return kNever;
    if (distance.value - target <= tolerance) return t;
    t += (target - distance.value) / distance.slope;
    if (!(t <= 1.0f)) return kNever;
    distance = obstacle.distance_at(path, t);
  }
  return kNever;
}

// The distance that a ball's center must keep.
struct Core {
  float distance, tolerance;  // m
};
inline Core core_of(const Path& path, float radius, float distance) {
  // A core that overlaps at the start may come nearer by a tenth of its center's distance.
  constexpr float kNearer = 0.9f;
  // Newton's method ends within these shares of the slop, the radius and the distance.
  constexpr float kSlopShare = 0.1f, kLengthShare = 0.02f;
  constexpr float kRounding = 1e-6f;  // of the path's coordinates: about eight units in the last place
  const float rounding = kRounding * (length(path.start) + length(path.motion));
  return {std::min(kCoreShare * radius, kNearer * distance),
          std::min({kSlopShare * kLinearSlop, kLengthShare * radius, kLengthShare * distance}) + rounding};
}

// Where a path meets an obstacle, from 0 to 1 along it, and the direction out of the obstacle. Of meetings at
// the same time the one with the smallest index counts.
struct Meeting {
  float time = kNever;
  std::int32_t obstacle = -1;
  Vec3 normal{};
};
inline Meeting earlier(const Meeting& a, const Meeting& b) {
  return b.time < a.time || (b.time == a.time && b.obstacle < a.obstacle) ? b : a;
}

// When a ball meets the obstacle, if its core is to meet it as well; else kNever.
template <class Obstacle>
float meeting(const Obstacle& obstacle, const Path& path, float radius) {
  Distance distance = obstacle.distance_at(path, 0.0f);
  if (!(distance.value > 0.0f)) return kNever;
  const Core core = core_of(path, radius, distance.value);
  float met = 0.0f;
  const bool overlaps = !(distance.value > radius);
  if (!overlaps) met = first_within(obstacle, path, radius, core.tolerance, 0.0f, distance);
  if (met == kNever) return kNever;
  const float core_met = first_within(obstacle, path, core.distance, core.tolerance, met, distance);
  return overlaps || core_met == kNever ? core_met : met;
}

// When a ball's core meets the obstacle that the ball touched when the step began, and the normal there, if
// it is to come deeper by the end of the step, `left` such paths later, than a contact leaves what it holds.
template <class Obstacle>
Meeting core_meeting(const Obstacle& obstacle, const Path& path, float radius, float left) {
  Distance distance = obstacle.distance_at(path, 0.0f);
  if (!(distance.value > 0.0f)) return {};
  const Core core = core_of(path, radius, distance.value);
  const float met = first_within(obstacle, path, core.distance, core.tolerance, 0.0f, distance);
  const float held = std::min(core.distance, radius - kLinearSlop);
  if (met == kNever || !(distance.value + (1.0f - met + left) * distance.slope < held)) return {};
  return {met, obstacle.shape, distance.normal};
}

// A box around what moves within a step.
struct Swept {
  float lower[3], upper[3];

  Swept() = default;
  Swept(const float (&low)[3], const float (&high)[3])
      : lower{low[0], low[1], low[2]}, upper{high[0], high[1], high[2]} {}
  Swept(Vec3 start, Vec3 end, float radius)
      : lower{std::min(start.x, end.x) - radius, std::min(start.y, end.y) - radius,
              std::min(start.z, end.z) - radius},
        upper{std::max(start.x, end.x) + radius, std::max(start.y, end.y) + radius,
              std::max(start.z, end.z) + radius} {}
};

// A ball over a stretch of the step, which it began at `origin`.
struct Sweep {
  std::int32_t shape;
  Vec3 origin, start, end;
  float radius, left;  // m; stretches that follow
  Against against;
  Swept core;
};

}  // namespace scree::sweeps
