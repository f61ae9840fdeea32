// The program scree_differential_drive: a robot on two driven wheels that roll without slipping. The wheels
// never touch a ground: rows of user joints are their contact with it. Prints the circle that the robot
// drives beside the one that its wheels' speeds make. Exit codes: 0 all within what README.md states, 1 not
// so.
#include <scree/scree.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>

namespace {

using scree::BodyId;
using scree::JointId;
using scree::RowKind;
using scree::Vec3;

constexpr float kRadius = 0.1f;                // m, of the wheels
constexpr float kTrack = 0.5f;                 // m, from wheel to wheel
constexpr float kLeft = 4.0f, kRight = 10.0f;  // rad/s, of the wheels
constexpr float kDt = 1.0f / 240.0f;
constexpr int kSteps = 20 * 240, kSettling = 2 * 240;
constexpr Vec3 kUp{0, 1, 0};

enum Part : std::uint64_t { kWheel, kCaster };  // user data of the joints

// Axes of the robot in the world: it drives along its x axis, its wheels turn about its z axis.
Vec3 forward_of(const scree::World& world, BodyId chassis) {
  const Vec3 x = rotate(world.pose(chassis).rotation, {1, 0, 0});
  return normalize(Vec3{x.x, 0, x.z});
}

// A wheel of radius R whose lowest point stands still: v + w x (-R up) = 0 forwards and sideways, which are
// equations of velocities alone, and its center no lower than R.
void state_wheel(const scree::UserRowBatch& batch, std::size_t i, Vec3 forward) {
  const BodyId wheel = batch.world.joint_def(batch.joints[i]).body_b;
  const Vec3 side = cross(forward, kUp), arm = -kRadius * kUp;
  const std::size_t row = scree::kMaxUserRows * i;
  batch.jacobians[row] = {.linear_b = forward, .angular_b = cross(arm, forward)};
  batch.jacobians[row + 1] = {.linear_b = side, .angular_b = cross(arm, side)};
  batch.jacobians[row + 2] = {.linear_b = kUp};
  batch.targets[row + 2] = {.error = batch.world.center_of_mass(wheel).y - kRadius};
}

// What keeps the chassis from tipping over its axle: its x axis stays level.
void state_caster(const scree::UserRowBatch& batch, std::size_t i, BodyId chassis, Vec3 forward) {
  const Vec3 x = rotate(batch.world.pose(chassis).rotation, {1, 0, 0});
  const std::size_t row = scree::kMaxUserRows * i;
  batch.jacobians[row] = {.angular_b = cross(forward, kUp)};
  batch.targets[row] = {.error = x.y};
}

bool report(const char* what, double value, double most, const char* unit) {
  const bool holds = value <= most;
  std::printf("%-28s %12.3g %-4s at most %g %s\n", what, value, unit, most, holds ? "" : "EXCEEDED");
  return holds;
}

}  // namespace

int main() {
  scree::World world({.sleeping = false});
  const BodyId chassis = world.create_body({.position = {0, kRadius, 0}});
  world.add_shape(chassis, scree::Box{.half_extents = {0.2f, 0.05f, 0.2f}}, {.density = 200});
  BodyId wheels[2];
  for (int side = 0; side < 2; ++side) {
    const float z = (side == 0 ? -0.5f : 0.5f) * kTrack;  // the left one first
    wheels[side] = world.create_body({.position = {0, kRadius, z}});
    world.add_shape(wheels[side], scree::Sphere{.radius = kRadius});
    // Hinges turn about the x axes of their frames; a wheel that rolls forwards turns about -z.
    const scree::Quat axle{0, 0.70710678f, 0, 0.70710678f};
    world.create_joint(
        {.body_a = chassis, .body_b = wheels[side], .frame_a = {{0, 0, z}, axle}, .frame_b = {{}, axle}},
        scree::HingeJoint{
            {.drive = scree::Drive::motor, .speed = side == 0 ? kLeft : kRight, .max_force = 20}});
    world.create_joint({.body_a = scree::kWorld, .body_b = wheels[side], .user_data = kWheel},
                       scree::UserJoint{{RowKind::motor, RowKind::motor, RowKind::limit}});
  }
  world.create_joint({.body_a = scree::kWorld, .body_b = chassis, .user_data = kCaster},
                     scree::UserJoint{{RowKind::held}});
  world.set_user_row_callback([=](const scree::UserRowBatch& batch) {
    const Vec3 forward = forward_of(batch.world, chassis);
    for (std::size_t i = 0; i < batch.joints.size(); ++i) {
      if (batch.world.user_data(batch.joints[i]) == kWheel) {
        state_wheel(batch, i, forward);
      } else {
        state_caster(batch, i, chassis, forward);
      }
    }
  });

  scree::Workers workers(1);
  double slip = 0, least[2] = {1e9, 1e9}, most[2] = {-1e9, -1e9};
  for (int i = 0; i < kSteps; ++i) {
    scree::step(world, kDt, workers);
    if (i < kSettling) continue;
    const Vec3 p = world.center_of_mass(chassis);
    const double at[2] = {static_cast<double>(p.x), static_cast<double>(p.z)};
    for (int k = 0; k < 2; ++k) least[k] = std::min(least[k], at[k]), most[k] = std::max(most[k], at[k]);
    for (const BodyId wheel : wheels) {
      const Vec3 v = world.velocity_at(wheel, world.center_of_mass(wheel) - kRadius * kUp);
      slip = std::max(slip, static_cast<double>(std::hypot(v.x, v.z)));
    }
  }
  // The axle's middle moves at R (left + right) / 2 and turns at R (right - left) / track.
  const double exact = static_cast<double>(0.5f * kTrack * (kRight + kLeft) / (kRight - kLeft));
  const double radius = 0.25 * (most[0] - least[0] + most[1] - least[1]);
  std::printf("a differential drive: %d steps of 1/240 s; radius %.5f m, exact %.5f m\n", kSteps, radius,
              exact);
  const bool holds[] = {report("error of the radius", std::abs(radius / exact - 1), 1e-4, ""),
                        report("largest slip of a wheel", slip, 1e-5, "m/s")};
  return holds[0] && holds[1] ? 0 : 1;
}
