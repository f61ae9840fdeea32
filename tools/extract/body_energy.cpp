// See body_energy.h.
#include <tools/extract/body_energy.h>

namespace scree::extract {

double kinetic_energy(const World& world, BodyId body) {
  if (world.body_type(body) != BodyType::dynamic) return 0.0;
  const MassProperties mass = world.mass_properties(body);
  const Vec3 v = world.linear_velocity(body);
  const Vec3 w = rotate_back(world.pose(body).rotation, world.angular_velocity(body));
  const auto square = [](float x) { return double{x} * double{x}; };
  const double linear = double{mass.mass} * (square(v.x) + square(v.y) + square(v.z));
  const double diagonal = double{mass.inertia[0]} * square(w.x) + double{mass.inertia[1]} * square(w.y) +
                          double{mass.inertia[2]} * square(w.z);
  const double mixed = double{mass.inertia[3]} * double{w.x} * double{w.y} +
                       double{mass.inertia[4]} * double{w.x} * double{w.z} +
                       double{mass.inertia[5]} * double{w.y} * double{w.z};
  return 0.5 * linear + 0.5 * diagonal + mixed;
}

double potential_energy(const World& world, BodyId body) {
  if (world.body_type(body) != BodyType::dynamic) return 0.0;
  const Vec3 g = world.settings().gravity, x = world.center_of_mass(body);
  const double work = double{g.x} * double{x.x} + double{g.y} * double{x.y} + double{g.z} * double{x.z};
  return -double{world.gravity_factor(body)} * double{world.mass_properties(body).mass} * work;
}

}  // namespace scree::extract
