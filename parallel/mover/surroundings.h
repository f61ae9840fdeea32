// What is around a mover: shapes that it touches, and what it meets on a way, by the public queries.
#pragma once

#include <parallel/mover/mover_limits.h>
#include <parallel/mover/planes.h>
#include <scree/mover.h>

#include <array>
#include <cstddef>
#include <span>

namespace scree::mover {

// A shape beside the mover. It lies behind the plane through `point`.
struct Touch {
  Vector normal;          // of unit length, from the shape to the mover
  Vector point;           // m, of the shape's surface, in the world
  double distance = 0.0;  // m, of the capsule; below zero where the shape reaches into it
  ShapeId shape;
  BodyId body;
  BodyType type = BodyType::fixed;
};

// The nearest of what the mover touches, by distance and then by ShapeId::index.
struct Touches {
  std::array<Touch, kMostTouched> touch;
  std::size_t count = 0;
  // A shape holds a point of the inner segment: it has no plane.
  bool inside = false;
  ShapeId holder;      // the first such shape, by ShapeId::index
  BodyId holder_body;  // that shape's

  std::span<const Touch> all() const { return std::span(touch).first(count); }
};

// One call of move(), with the numbers that all its parts use.
struct Task {
  const World& world;
  const MoverSettings& settings;
  Vector up;               // of unit length
  Quat turn;               // from y to up
  double radius, half;     // m, of the capsule
  double skin;             // m
  double steepest_cosine;  // of slopes that count as ground
  double dt;               // s
  BodyId carrier{};        // whose shapes do not count meanwhile: it carries the mover
  BodyId stands_on{};      // which the mover does not push: it would push itself along
  // What was touched where it was last asked for, and without which carrier: parts of a move ask again.
  mutable Touches known{};
  mutable Vector known_position{};
  mutable BodyId known_carrier{};
  mutable bool is_known = false;
};

Task task_of(const World& world, const MoverSettings& settings, float dt);

// Places are floats, as queries take them, and stay within their limit.
Vector placed(Vector position);
// How much farther off than the skin shapes count as touched: more than rounding moves the mover by.
double slack(const Task& task, Vector position);
// Displacements below are none: of rounding.
inline double tolerance(const Task& task) { return 1e-6 * task.skin; }

// The lowest height, along up, that the mover keeps free below it.
inline double feet(const Task& task, Vector position) {
  return dot(task.up, position) - (task.half + task.radius + task.skin);
}

inline Vector level_part(const Task& task, Vector v) { return v - dot(task.up, v) * task.up; }

// The answer stays until another place is asked for.
const Touches& touched_at(const Task& task, Vector position);

// What the capsule meets on a straight way.
struct Meeting {
  bool meets = false;
  double advance = 1.0;  // the fraction of the way that leaves the skin between them
  Touch touch;           // what is met, with the distance that is left then
};

// Shapes that reach into the capsule already do not stop it: their planes do. Of those that are too near
// already (`around`) only the capsule itself keeps off: their planes have allowed the way.
Meeting meet_on_way(const Task& task, Vector position, Vector way, std::span<const Touch> around = {});
// The same with most of the skin around the capsule, for ways down: the skin stands on edges, too, which the
// capsule would pass by.
Meeting meet_below(const Task& task, Vector position, Vector way);

// Whether a surface with this normal can be walked on.
inline bool is_firm(const Task& task, Vector normal) { return dot(task.up, normal) >= task.steepest_cosine; }
// Whether the edge that the capsule stands on belongs to a surface that can be walked on.
bool is_edge_of_firm(const Task& task, const Touch& touch);

// Where the mover touches a shape at the height (m, along up) nearest to `height`, for shapes that touch it
// along a line; else the point of the touch.
Vector point_at_height(const Task& task, Vector position, const Touch& touch, double height);

// Out of a shape that holds a point of the inner segment, to the nearest free place along some directions;
// the position itself if all are blocked.
Vector escape(const Task& task, Vector position, const Touches& touches);

}  // namespace scree::mover
