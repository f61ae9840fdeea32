// What a mover stands on: found, followed down, stepped onto.
#pragma once

#include <parallel/mover/slide.h>

namespace scree::mover {

struct Ground {
  MoverGround kind = MoverGround::none;
  Touch touch;  // what it stands on
};

// Of all that the mover touches: firm ground, rather that of `before` than others; else what is steep, which
// is firm, too, where it holds the mover from several sides. Edges of firm surfaces carry those who walk.
Ground find_ground(const Task& task, Vector position, bool walks, BodyId before);

// Lowers a mover that has walked onto ground within the snap distance. Leaves it where it is if there is
// none.
Ground follow_down(const Task& task, Vector& position, BodyId before);

// Firm ground right below a mover that falls, where the nearest of what it touches is none.
Ground land_on(const Task& task, Vector position);

// Goes the level way again, from `start`, over a step. False, and nothing changed, if that brings it no
// farther than course.position is, or onto no ground that may be stepped on.
bool step_up(const Task& task, Vector start, Vector velocity, Vector way, Course& course, Ground& ground);

}  // namespace scree::mover
