// The course of the mover's example: what stands on it, and the will of the one who walks it.
#pragma once

#include <scree/scree.h>

namespace scree::course {

inline constexpr float kStep = 1.0f / 60.0f;  // s
inline constexpr int kMostSteps = 60 * 60;    // the walker needs about 35 s

// Where the walker is on its course.
enum class Part { stairs, slope, pier, ferry, crates, elevator, arrived };
const char* name_of(Part part);

struct Figures {
  double nearest = 1.0;  // m, of the capsule to any shape
  int steps_in_air = 0;
};

struct Course {
  Course();

  World world;
  BodyId ferry, elevator;
  BodyId crates[3];
  MoverSettings settings;
  MoverState walker;
  Figures figures;
  int steps_done = 0;

  Part part() const;
  const char* ground_name() const;
  float crates_moved() const;  // m, the first of them
};

// One step: the world's, and then the walker's.
void advance(Course& course, Workers& workers);

}  // namespace scree::course
