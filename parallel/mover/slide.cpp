// Sliding: the way is cut where a cast meets something, and goes on along the planes of what is touched.
#include <core/plain/assert.h>
#include <parallel/mover/slide.h>

#include <algorithm>
#include <cmath>

namespace scree::mover {

namespace {

constexpr double kUpright = 1e-3;  // cosine: what faces up or down by no more is a wall

enum class Facing { ground, steep, wall, ceiling };

Facing facing_of(const Task& task, Vector normal) {
  const double rise = dot(task.up, normal);
  if (rise >= task.steepest_cosine) return Facing::ground;
  if (rise > kUpright) return Facing::steep;
  return rise >= -kUpright ? Facing::wall : Facing::ceiling;
}

// Planes of one problem. There is room for all: each touch brings one plane, or two.
struct PlaneList {
  std::array<Plane, kMostPlanes> plane;
  std::size_t count = 0;

  void add(const Plane& more) {
    SCREE_ASSERT(count < plane.size());
    plane[count++] = more;
  }
  std::span<const Plane> all() const { return std::span(plane).first(count); }
};

// How much of the wanted displacement or velocity the touch takes or must give, along its normal.
double least_of(const Task& task, const Touch& touch, bool pushes) {
  constexpr double kNear = 0.01;  // of the skin: rounding alone makes nobody move
  if (!pushes) return 0.0;
  const double missing = task.skin - touch.distance;
  return missing > 0.0 && missing < kNear * task.skin ? 0.0 : missing;
}

bool yields(const Touch& touch) { return touch.type != BodyType::fixed; }

// The planes that hold a level way: walls, with their normals made level, so that nothing is climbed.
PlaneList level_walls(const Task& task, std::span<const Touch> touches, Gait gait, bool pushes) {
  constexpr double kFlat = 0.3;  // sine: flatter ceilings stop nobody from the side
  PlaneList walls;
  for (const Touch& touch : touches) {
    const Facing facing = facing_of(task, touch.normal);
    if (facing == Facing::ground || (facing == Facing::ceiling && gait == Gait::fly)) continue;
    const Vector level = level_part(task, touch.normal);
    const double size = length(level);
    if (!(size > kFlat)) continue;
    walls.add({(1.0 / size) * level, least_of(task, touch, pushes) / size, yields(touch)});
  }
  return walls;
}

}  // namespace

Vector allowed_way(const Task& task, std::span<const Touch> touches, Vector wanted, Gait gait, bool pushes) {
  // Velocities are in m/s: the tolerance is that of what they lead to in a step.
  const double unit = pushes ? 1.0 : 1.0 / task.dt;
  const double exact = unit * tolerance(task), give = unit * task.skin;
  PlaneList planes = level_walls(task, touches, gait, pushes);
  const Vector level = nearest_possible(planes.all(), level_part(task, wanted), exact, give);
  double rise = gait == Gait::walk ? 0.0 : dot(task.up, wanted);
  for (const Touch& touch : touches) {
    const double least = least_of(task, touch, pushes);
    const Facing facing = facing_of(task, touch.normal);
    if (facing == Facing::wall) continue;  // holds the level part already
    if (facing == Facing::ground) {
      rise = std::max(rise, (least - dot(touch.normal, level)) / dot(task.up, touch.normal));
    }
    planes.add({touch.normal, least, yields(touch)});
  }
  return nearest_possible(planes.all(), level + rise * task.up, exact, give);
}

namespace {

void note(const Task& task, const Touch& touch, Vector velocity, Gait gait, Course& course) {
  if (!(dot(touch.normal, velocity) < 0.0)) return;
  const Facing facing = facing_of(task, touch.normal);
  if (facing == Facing::ceiling) course.touches_ceiling = true;
  if (facing == Facing::wall || facing == Facing::steep ||
      (facing == Facing::ceiling && gait == Gait::walk)) {
    course.touches_wall = true;
  }
}

void note_push(const Task& task, const Touch& touch, Vector velocity, Course& course) {
  if (touch.type != BodyType::dynamic || facing_of(task, touch.normal) == Facing::ground) return;
  if (task.stands_on.generation != 0 && touch.body == task.stands_on) return;
  for (std::size_t i = 0; i < course.push_count; ++i) {
    if (course.push[i].touch.shape == touch.shape) return;
  }
  if (course.push_count < course.push.size()) course.push[course.push_count++] = {touch, velocity};
}

// What was met on this way already and may be farther off than what is touched now.
struct Met {
  Touch touch;
  double offset = 0.0;  // m, along the normal, of the mover when it touches
};

}  // namespace

void slide(const Task& task, Vector way, Gait gait, Course& course) {
  std::array<Met, kMostMet> met{};
  std::size_t met_count = 0;
  Vector rest = way;
  for (std::size_t round = 0; round < kMostMet; ++round) {
    const Touches& touches = touched_at(task, course.position);
    std::array<Touch, kMostTouched + kMostMet> around{};
    std::size_t count = 0;
    for (const Touch& touch : touches.all()) around[count++] = touch;
    for (std::size_t i = 0; i < met_count; ++i) {
      around[count] = met[i].touch;
      around[count++].distance = dot(met[i].touch.normal, course.position) - met[i].offset + task.skin;
    }
    const std::span<const Touch> all = std::span(around).first(count);
    for (const Touch& touch : all) {
      if (touch.distance > task.skin + slack(task, course.position)) continue;
      note(task, touch, course.velocity, gait, course);
      note_push(task, touch, course.velocity, course);
    }
    course.velocity = allowed_way(task, all, course.velocity, gait, false);
    const Vector step = allowed_way(task, all, rest, gait, true);
    if (!(length(step) > tolerance(task))) return;
    const Meeting meeting = meet_on_way(task, course.position, step, all);
    course.position = placed(course.position + meeting.advance * step);
    if (!meeting.meets) {
      const bool pushed = std::any_of(all.begin(), all.end(),
                                      [&](const Touch& touch) { return least_of(task, touch, true) > 0.0; });
      if (!pushed) return;
      rest = {};
      continue;
    }
    rest = (1.0 - meeting.advance) * rest;
    met[met_count++] = {meeting.touch, dot(meeting.touch.normal, course.position)};
  }
}

}  // namespace scree::mover
