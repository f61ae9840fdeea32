// How a mover goes a way: along what it meets, and up steps.
#pragma once

#include <parallel/mover/surroundings.h>

namespace scree::mover {

// A dynamic body that was in the way.
struct Push {
  Touch touch;
  Vector velocity;  // m/s, of the mover as it met the body
};

// What happened on a way.
struct Course {
  Vector position;  // m, of the mover
  Vector velocity;  // m/s, without what was stopped
  bool touches_wall = false, touches_ceiling = false;
  std::array<Push, kMostTouched> push{};
  std::size_t push_count = 0;
};

// How the mover treats its way.
enum class Gait {
  walk,  // the way is level: ground lifts and lowers the mover, all else is a wall
  fly,   // ground stops what falls, and slopes deflect it; steep ones cannot be climbed
};

// What of a displacement or a velocity the touched shapes allow. Those of displacements push the mover out of
// the skin (`pushes`); velocities only lose what leads into the shapes.
Vector allowed_way(const Task& task, std::span<const Touch> touches, Vector wanted, Gait gait, bool pushes);

// Goes a way from course.position, and changes the course. A way without length only leaves what has come
// too near.
void slide(const Task& task, Vector way, Gait gait, Course& course);

}  // namespace scree::mover
