// Laws of slender bodies: needles, slivers and plates, whose inertia differs by hundreds from axis to axis,
// among bodies hundreds of times their mass.
#include <tests/physics/lab.h>

#include <algorithm>

namespace scree::physics {
namespace {

double potential_energy(const SceneLab& heap) {
  const double gravity = -double{heap.scene.settings.gravity.y};
  double sum = 0.0;
  for (const BodyId body : heap.bodies) {
    if (heap.lab.world.body_type(body) != BodyType::dynamic) continue;
    sum += double{heap.lab.world.mass_properties(body).mass} * gravity * heap.lab.height(body);
  }
  return sum;
}

double fastest(const SceneLab& heap) {
  double speed = 0.0;
  for (const BodyId body : heap.bodies) speed = std::max(speed, heap.lab.velocity(body).norm());
  return speed;
}

TEST(Slender, AHeapOfThemNeverGainsEnergyAndComesToRest) {
  SceneLab heap("hull_zoo", {{"bodies", 200}, {"max_vertices", 32}});
  double height = 0.0;
  for (const BodyId body : heap.bodies) height = std::max(height, heap.lab.height(body));
  const double free_fall = std::sqrt(2.0 * -double{heap.scene.settings.gravity.y} * height);
  double energy = potential_energy(heap) + heap.lab.world.stats().kinetic_energy;
  for (int step = 0; step < 400; ++step) {
    heap.lab.run(1);
    const double now = potential_energy(heap) + heap.lab.world.stats().kinetic_energy;
    // Overlaps are pushed apart, which lifts: by less than a thousandth of what there is.
    ASSERT_LT(now, energy * 1.001) << "step " << step;
    ASSERT_LT(fastest(heap), 1.5 * free_fall) << "step " << step;
    energy = now;
  }
  EXPECT_LT(heap.lab.world.stats().kinetic_energy, 2e-4 * energy);
}

TEST(Slender, NobodyEverSeesASpeedAboveTheLimits) {
  WorldSettings settings = without_sleep();
  settings.max_linear_speed = 5.0f;
  settings.max_angular_speed = 7.0f;
  Lab lab(settings);
  lab.add_ground({.restitution = 1.0f});
  std::vector<BodyId> needles;
  for (int i = 0; i < 20; ++i) {
    needles.push_back(lab.add(
        {.position = {2.0f * static_cast<float>(i), 3.0f, 0},
         .rotation = {0, 0, std::sin(0.1f * static_cast<float>(i)), std::cos(0.1f * static_cast<float>(i))}},
        Box{{0.02f, 0.6f, 0.02f}}, {.restitution = 1.0f}));
  }
  for (int step = 0; step < 120; ++step) {
    lab.run(1);
    for (const BodyId needle : needles) {
      const Vec3 spin = lab.world.angular_velocity(needle);
      EXPECT_LT(lab.velocity(needle).norm(), 5.0 * 1.00001);
      EXPECT_LT(std::hypot(spin.x, spin.y, spin.z), 7.0f * 1.00001f);
    }
  }
}

}  // namespace
}  // namespace scree::physics
