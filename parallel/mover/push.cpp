// Pushes and weight, by the world's calls; see push.h.
#include <parallel/mover/push.h>

#include <algorithm>
#include <optional>

namespace scree::mover {

namespace {

// The rows of an inertia times a vector, solved for the vector by Cramer's rule.
std::optional<Vector> divide_by_inertia(const MassProperties& mass, Vector torque) {
  const float(&i)[6] = mass.inertia;
  const Vector row[3] = {{i[0], i[3], i[4]}, {i[3], i[1], i[5]}, {i[4], i[5], i[2]}};
  const Vector across[3] = {cross(row[1], row[2]), cross(row[2], row[0]), cross(row[0], row[1])};
  const double determinant = dot(row[0], across[0]);
  if (!(determinant > 0.0)) return std::nullopt;
  return (1.0 / determinant) * (torque.x * across[0] + torque.y * across[1] + torque.z * across[2]);
}

// How much an impulse of 1 N s along the normal changes the body's speed along it at the point, 1/kg:
// 1/m + n . ((I^-1 (r x n)) x r), as D. Baraff, "Analytical methods for dynamic simulation", 1989.
double response(const World& world, BodyId body, Vector point, Vector normal) {
  const MassProperties mass = world.mass_properties(body);
  const queries::Axes axes = queries::to_axes(world.pose(body).rotation);
  const Vector arm = point - queries::to_vector(world.center_of_mass(body));
  const std::optional<Vector> spin = divide_by_inertia(mass, turn_back(axes, cross(arm, normal)));
  const double turning = spin ? dot(normal, cross(axes * *spin, arm)) : 0.0;
  return 1.0 / double{mass.mass} + std::max(turning, 0.0);
}

// What a body shall have as a speed away from the mover: where it reaches into the mover, a way out.
double leaving_speed(const Touch& touch) {
  constexpr double kRate = 10.0, kMost = 3.0;  // 1/s, m/s
  return std::clamp(-kRate * touch.distance, 0.0, kMost);
}

}  // namespace

void push_bodies(World& world, const Task& task, const Course& course, Vector carried) {
  struct Impulse {
    BodyId body;
    Vector point, normal;
    double leaving = 0.0;  // m/s
    Vector velocity;       // m/s, of the mover in the world
  };
  std::array<Impulse, kMostTouched> impulses{};
  std::size_t count = 0;
  // All queries come first: calls change what they see.
  for (std::size_t i = 0; i < course.push_count; ++i) {
    const auto& [touch, velocity] = course.push[i];
    if (world.is_quarantined(touch.body)) continue;
    const double height = dot(task.up, queries::to_vector(world.center_of_mass(touch.body)));
    impulses[count++] = {touch.body, point_at_height(task, course.position, touch, height), touch.normal,
                         leaving_speed(touch), velocity + carried};
  }
  double left = double{task.settings.push_force} * task.dt;
  for (std::size_t i = 0; i < count && left > 0.0; ++i) {
    const Impulse& push = impulses[i];
    const Vec3 point = queries::to_vec3(push.point);
    const Vector body = queries::to_vector(world.velocity_at(push.body, point));
    const double approach = dot(push.normal, body - push.velocity) + push.leaving;
    if (!(approach > 0.0)) continue;
    const double impulse = std::min(approach / response(world, push.body, push.point, push.normal), left);
    world.add_impulse_at(push.body, queries::to_vec3(-impulse * push.normal), point);
    left -= impulse;
  }
}

void press_on_ground(World& world, const Task& task, const Touch& ground) {
  constexpr double kMostLoad = 10.0;  // times the body's mass: more squashes contacts of a step
  if (ground.type != BodyType::dynamic || !(task.settings.mass > 0.0f)) return;
  const double mass =
      std::min(double{task.settings.mass}, kMostLoad * double{world.mass_properties(ground.body).mass});
  world.add_force_at(ground.body, queries::to_vec3(mass * queries::to_vector(world.settings().gravity)),
                     queries::to_vec3(ground.point));
}

}  // namespace scree::mover
