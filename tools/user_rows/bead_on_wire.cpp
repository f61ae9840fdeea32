// The program scree_bead_on_wire: a bead slides down a helix without friction. No joint knows such a wire;
// two rows of a user joint do. Prints how far the bead gets from the wire, and its energy and place beside
// the exact ones. Exit codes: 0 all within what README.md states, 1 not so.
#include <scree/scree.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace {

using scree::Vec3;

// x = (R cos s, c s, R sin s).
constexpr float kRadius = 1.0f;  // m, R
constexpr float kClimb = 0.3f;   // m a radian, c
constexpr float kDt = 1.0f / 960.0f;
constexpr int kSteps = 2 * 960;
constexpr double kGravity = 9.81;  // m/s^2, of WorldSettings

// Where the wire is, by angle s.
struct Wire {
  Vec3 point, tangent, normal, binormal;  // the normal leads to the axis
};
Wire wire_at(float s) {
  const float length = std::sqrt(kRadius * kRadius + kClimb * kClimb);
  const Vec3 out{std::cos(s), 0, std::sin(s)}, around{-std::sin(s), 0, std::cos(s)};
  const Vec3 tangent = (1 / length) * (kRadius * around + Vec3{0, kClimb, 0});
  const Vec3 normal = -1.0f * out;
  return {kRadius * out + Vec3{0, kClimb * s, 0}, tangent, normal, cross(tangent, normal)};
}

// The angle of the wire's nearest point, by Newton's method from one nearby.
float nearest_angle(Vec3 x, float s) {
  for (int i = 0; i < 4; ++i) {
    const Vec3 speed = kRadius * Vec3{-std::sin(s), 0, std::cos(s)} + Vec3{0, kClimb, 0};
    s += dot(x - wire_at(s).point, speed) / dot(speed, speed);
  }
  return s;
}

// Two rows across the wire: C = n . (x - p), J = [0, 0, n, 0]. The wire leaves its tangent by v^2 / (2 rho)
// t^2 towards the axis, with the radius of curvature rho = (R^2 + c^2) / R. Over a step that is a mean speed
// of v^2 / (2 rho) dt, and with it as the target's the bead ends each step on the wire.
void state_rows(const scree::UserRowBatch& batch) {
  constexpr float kCurvature = kRadius / (kRadius * kRadius + kClimb * kClimb);  // 1/m
  for (std::size_t i = 0; i < batch.joints.size(); ++i) {
    const scree::BodyId bead = batch.world.joint_def(batch.joints[i]).body_b;
    const Vec3 x = batch.world.center_of_mass(bead), v = batch.world.linear_velocity(bead);
    const Wire wire = wire_at(nearest_angle(x, x.y / kClimb));
    const float along = dot(v, wire.tangent);
    const std::size_t row = scree::kMaxUserRows * i;
    batch.jacobians[row] = {.linear_b = wire.normal};
    batch.targets[row] = {.error = dot(wire.normal, x - wire.point),
                          .speed = 0.5f * batch.dt * kCurvature * along * along};
    batch.jacobians[row + 1] = {.linear_b = wire.binormal};
    batch.targets[row + 1] = {.error = dot(wire.binormal, x - wire.point)};
  }
}

bool report(const char* what, double value, double most, const char* unit) {
  const bool holds = value <= most;
  std::printf("%-28s %12.3g %-4s at most %g %s\n", what, value, unit, most, holds ? "" : "EXCEEDED");
  return holds;
}

}  // namespace

int main() {
  // Rows stay while a step lasts: more steps serve better than more substeps.
  scree::World world({.substeps = 1, .sleeping = false});
  const float start = 10.0f;
  const scree::BodyId bead = world.create_body({.position = wire_at(start).point});
  world.add_shape(bead, scree::Sphere{.radius = 0.05f});
  world.create_joint({.body_a = scree::kWorld, .body_b = bead},
                     scree::UserJoint{{scree::RowKind::held, scree::RowKind::held}});
  world.set_user_row_callback(state_rows);
  scree::Workers workers(1);
  double farthest = 0, energy_error = 0;
  for (int i = 0; i < kSteps; ++i) {
    scree::step(world, kDt, workers);
    const Vec3 x = world.center_of_mass(bead), v = world.linear_velocity(bead);
    const Vec3 away = x - wire_at(nearest_angle(x, x.y / kClimb)).point;
    farthest = std::max(farthest, static_cast<double>(length(away)));
    const double fallen = kGravity * static_cast<double>(start * kClimb - x.y);
    energy_error = std::max(energy_error, std::abs(0.5 * static_cast<double>(dot(v, v)) - fallen));
  }
  // s'' = -g c / (R^2 + c^2).
  const double time = kSteps * static_cast<double>(kDt), c = kClimb, r = kRadius;
  const double exact = start - 0.5 * kGravity * c / (r * r + c * c) * time * time;
  const Vec3 x = world.center_of_mass(bead);
  const double fallen = kGravity * c * (start - exact);  // J/kg
  std::printf("a bead on a helix: %d steps of 1/960 s, %.2f turns\n", kSteps, (start - exact) / 6.283185307);
  const bool holds[] = {
      report("largest way off the wire", farthest, 5e-5, "m"),
      report("largest energy error", energy_error / fallen, 1e-3, ""),
      report("place along the wire", std::abs(nearest_angle(x, x.y / kClimb) - exact), 5e-3, "rad")};
  return holds[0] && holds[1] && holds[2] ? 0 : 1;
}
