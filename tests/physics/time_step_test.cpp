// Laws of changes of the time step: the impulses that contacts store from one step serve the next, whatever
// its length, and never make bodies jump.
#include <tests/physics/lab.h>

namespace scree::physics {
namespace {

// A tower of boxes at rest.
struct Tower {
  explicit Tower(int substeps = 4) {
    WorldSettings settings = without_sleep();
    settings.substeps = substeps;
    settings.contact_hertz = 5.0f;  // low enough for one substep: the tower rests as high with any number
    lab.world.set_settings(settings);
    lab.add_ground();
    for (int i = 0; i < 4; ++i) {
      boxes.push_back(lab.add({.position = {0, 0.5f + static_cast<float>(i), 0}}, Box{}));
    }
    lab.run(600);
  }
  void set_substeps(int substeps) {
    WorldSettings settings = lab.world.settings();
    settings.substeps = substeps;
    lab.world.set_settings(settings);
  }
  // m/s, the largest speed of all boxes in any of the steps.
  double largest_speed(int steps, float dt = kStep) {
    double largest = 0.0;
    for (int i = 0; i < steps; ++i) {
      lab.run(1, dt);
      for (const BodyId box : boxes) largest = std::max(largest, lab.velocity(box).norm());
    }
    return largest;
  }

  Lab lab;
  std::vector<BodyId> boxes;
};

TEST(TimeStep, AStackStaysAtRestWhenShortStepsBecomeLong) {
  for (const float dt : {1e-45f, 1e-40f, 1e-38f, 1e-30f, 1e-20f, 1e-10f, 1e-6f, 1e-4f}) {
    Tower tower;
    EXPECT_LT(tower.largest_speed(3, dt), 0.01) << dt;
    // With useless stored impulses the boxes fall for a moment, by far less than a free body's 0.16 m/s.
    EXPECT_LT(tower.largest_speed(60), 0.05) << dt;
  }
}

TEST(TimeStep, AStackStaysAtRestWhenTheLengthOfStepsAlternates) {
  Tower tower;
  double largest = 0.0;
  for (int i = 0; i < 60; ++i) {
    largest = std::max(largest, tower.largest_speed(1, i % 2 == 0 ? 1.0f / 240.0f : kStep));
  }
  EXPECT_LT(largest, 0.01);
}

TEST(TimeStep, AStackStaysAtRestWhenTheNumberOfSubstepsChanges) {
  for (const auto& [from, to] : {std::pair{1, 64}, {2, 16}, {4, 8}, {8, 4}}) {
    Tower tower(from);
    const double before = tower.largest_speed(1);  // the tower still sinks a little
    tower.set_substeps(to);
    EXPECT_LT(tower.largest_speed(60), before + 0.0005) << from << " to " << to;
  }
}

}  // namespace
}  // namespace scree::physics
