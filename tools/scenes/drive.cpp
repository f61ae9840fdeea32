// Driven bodies: their target poses, and the call that moves them there.
#include <tools/scenes/angles.h>
#include <tools/scenes/scene.h>

#include <cmath>

namespace scree::scenes {
namespace {

struct Vector {
  double x, y, z;
};

Vector cross(Vector a, Vector b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

double dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

Vector to_double(Vec3 v) { return {double{v.x}, double{v.y}, double{v.z}}; }

// The rotation by `degrees` about the unit axis after `start`, of length 1.
Quat turned_about(Vector axis, double degrees, Quat start) {
  const auto [sine, cosine] = sine_cosine(0.5 * degrees);
  const Vector u{axis.x * sine, axis.y * sine, axis.z * sine};
  const Vector v{double{start.x}, double{start.y}, double{start.z}};
  const double w = double{start.w};
  const Vector uv = cross(u, v);
  const double x = cosine * v.x + w * u.x + uv.x;
  const double y = cosine * v.y + w * u.y + uv.y;
  const double z = cosine * v.z + w * u.z + uv.z;
  const double s = cosine * w - dot(u, v);
  const double scale = 1.0 / std::sqrt(x * x + y * y + z * z + s * s);
  return {static_cast<float>(x * scale), static_cast<float>(y * scale), static_cast<float>(z * scale),
          static_cast<float>(s * scale)};
}

}  // namespace

Pose drive_target(const SceneDrive& drive, double seconds) {
  const double degrees = drive.degrees_per_second * seconds;
  const Vector given = to_double(drive.axis);
  const double scale = 1.0 / std::sqrt(dot(given, given));
  const Vector axis{given.x * scale, given.y * scale, given.z * scale};
  const Vector center = to_double(drive.center);
  const Vector start = to_double(drive.start.position);
  const Vector arm{start.x - center.x, start.y - center.y, start.z - center.z};
  const Vector across = cross(axis, arm);
  const double along = dot(axis, arm);
  const auto [sine, cosine] = sine_cosine(degrees);
  // Rodrigues' rotation formula.
  const auto coordinate = [&, s = sine, c = cosine](double origin, double r, double perpendicular, double a) {
    return static_cast<float>(origin + r * c + perpendicular * s + a * along * (1.0 - c));
  };
  const Vec3 position{coordinate(center.x, arm.x, across.x, axis.x),
                      coordinate(center.y, arm.y, across.y, axis.y),
                      coordinate(center.z, arm.z, across.z, axis.z)};
  return {position,
          drive.turns_body ? turned_about(axis, degrees, drive.start.rotation) : drive.start.rotation};
}

void drive(World& world, std::span<const SceneDrive> drives, std::span<const BodyId> bodies,
           std::int64_t steps_done, float dt) {
  const double end = static_cast<double>(steps_done + 1) * double{dt};
  if (dt == 0.0f) return;  // nothing moves in such a step
  for (const SceneDrive& one : drives) {
    const BodyId body = bodies[one.body];
    if (world.is_alive(body)) world.set_kinematic_target(body, drive_target(one, end), dt);
  }
}

}  // namespace scree::scenes
