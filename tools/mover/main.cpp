// The program scree_mover: a character walks a course of stairs, a slope, a ferry that turns, crates and an
// elevator, and says where it is. Exit codes: 0 it arrives as README.md states, 1 not so.
#include <tools/mover/course.h>

#include <cstdio>

int main() {
  using scree::course::Part;
  scree::course::Course course;
  scree::Workers workers(1);
  std::printf("%6s %-9s %8s %8s %8s  %s\n", "s", "part", "x", "y", "z", "stands on");
  Part last = Part::arrived;
  for (int i = 0; i < scree::course::kMostSteps && course.part() != Part::arrived; ++i) {
    scree::course::advance(course, workers);
    const bool is_new = course.part() != last;
    last = course.part();
    if (!is_new && i % 60 != 0) continue;
    const scree::Vec3 place = course.walker.position;
    std::printf("%6.2f %-9s %8.3f %8.3f %8.3f  %s\n", static_cast<double>(i) * scree::course::kStep,
                scree::course::name_of(last), place.x, place.y, place.z, course.ground_name());
  }
  const scree::course::Figures& figures = course.figures;
  std::printf("nearest to a shape: %.1f mm; in the air: %d steps; crates pushed by %.2f m\n",
              1e3 * figures.nearest, figures.steps_in_air, course.crates_moved());
  const bool holds = course.part() == Part::arrived && figures.nearest > 0.0 && figures.steps_in_air == 0 &&
                     course.crates_moved() > 1.0;
  std::printf("%s\n", holds ? "arrived" : "NOT AS IT SHOULD BE");
  return holds ? 0 : 1;
}
