// Bodies and joints for the tests of the joint kernels: rows filled by hand, and a step of nothing else. All
// joints of a bench are solved at once, so no two of them share a body that can be pushed, but for a hub.
#pragma once

#include <core/world/column.h>
#include <core/world/math.h>
#include <gtest/gtest.h>
#include <simd/dispatch/kernels.h>
#include <tests/simd/all_kernels.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace scree::joint_tests {

using kernel_tests::all_kernels;
using kernel_tests::scalar_kernels;

inline constexpr float kNoLimit = std::numeric_limits<float>::infinity();
inline constexpr JointAxisRow kFreeAxis{-kNoLimit, kNoLimit, 0, 0, 1, 1, kNoLimit, kDriveNone};
inline constexpr JointAxisRow kHeldAxis{0, 0, 0, 0, 1, 1, kNoLimit, kDriveNone};

struct Random {
  std::mt19937 engine;
  explicit Random(unsigned seed) : engine(seed) {}
  float uniform(float low, float high) { return std::uniform_real_distribution<float>(low, high)(engine); }
  Vec3 vector(float size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  Quat rotation() {
    return normalize(Quat{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(0.1f, 1)});
  }
};

inline Quat turn(Vec3 axis, float angle) {
  const float s = std::sin(angle / 2);
  return {axis.x * s, axis.y * s, axis.z * s, std::cos(angle / 2)};
}

struct Bench {
  Column<PoseRow> pose;
  Column<VelocityRow> velocity, free_velocity;
  Column<DeltaRow> delta;
  Column<InertiaRow> inertia, local_mass;
  Column<LocalInertiaRow> local_inertia;
  Column<MotionRow> motion;
  Column<std::uint8_t> step_notes;
  Column<std::int32_t> joint_count;
  Column<ForceRow> force;
  Column<float> center, transform, timer, mass, energy;
  Column<std::uint8_t> non_finite, flags;
  Column<DriftRow> drift;
  Column<std::int32_t> moving, rows;
  Column<JointFrames> frames;
  Column<JointParameters> parameters;
  Column<std::int32_t> user;  // of user joints; each joint has numbers of its own
  Column<std::uint32_t> user_state;
  Column<UserJacobians> user_jacobians;
  Column<UserTargets> user_targets;
  Column<UserBounds> user_bounds;
  Column<JointImpulses> impulses;
  Column<JointReactionRow> reactions;
  Column<char> blocks;
  Column<float> residual, parts_a, parts_b;
  Column<std::uint8_t> shared;
  Vec3 gravity{0, 0, 0};
  float dt = 1.0f / 60.0f;
  int substeps = 4;
  bool warm = false;  // impulses of a step before are there
  bool bare = false;  // neither bias nor warm start
  simd::BodySide fixed = simd::BodySide::none;
  simd::BodySide hub = simd::BodySide::none;  // that body is the same one in all joints
  bool peaks = false;                         // largest reactions are kept

  Bench() {
    for (int row = 0; row < kFirstBody; ++row) add_row({}, {0, 0, 0}, {}, {0, 0, 0}, {0, 0, 0});
  }

  // A body of principal moments of inertia; one of mass 0 cannot be pushed.
  std::int32_t add_body(float kilograms, Vec3 moments, Vec3 position, Quat rotation = {}, Vec3 linear = {},
                        Vec3 angular = {}) {
    InertiaRow inverse{};
    if (kilograms > 0) {
      inverse.inverse_mass = 1 / kilograms;
      inverse.inverse_inertia[0] = 1 / moments.x;
      inverse.inverse_inertia[3] = 1 / moments.y;
      inverse.inverse_inertia[5] = 1 / moments.z;
    }
    const std::int32_t row = add_row(inverse, position, rotation, linear, angular);
    local_inertia[static_cast<std::size_t>(row)] = {{moments.x, 0, 0, moments.y, 0, moments.z}, {0, 0}};
    mass[static_cast<std::size_t>(row)] = kilograms;
    moving.push_back(row);
    return row;
  }

  // The frames where they lie in the world.
  std::size_t add_joint(std::int32_t a, Pose frame_a, std::int32_t b, Pose frame_b) {
    JointFrames f{};
    f.row_a = a;
    f.row_b = b;
    place(a, frame_a, f.anchor_a, f.rotation_a);
    place(b, frame_b, f.anchor_b, f.rotation_b);
    frames.push_back(f);
    JointParameters p{};
    for (JointAxisRow& axis : p.axis) axis = kFreeAxis;
    p.damping_ratio = p.angular_damping_ratio = 1;
    parameters.push_back(p);
    user.push_back(static_cast<std::int32_t>(user.size()));
    user_state.push_back(kUserActs);
    user_jacobians.resize(user.size());
    user_targets.resize(user.size());
    user_bounds.resize(user.size());
    impulses.resize(frames.size());
    reactions.resize(frames.size());
    return frames.size() - 1;
  }

  Quat rotation_of(std::int32_t body) const {
    const float* q = pose[static_cast<std::size_t>(body)].rotation;
    return {q[0], q[1], q[2], q[3]};
  }
  Vec3 position_of(std::int32_t body) const {
    const float* p = pose[static_cast<std::size_t>(body)].position;
    return {p[0], p[1], p[2]};
  }
  // A joint's frame as it lies in the world.
  Pose frame_a(std::size_t joint) const {
    const JointFrames& f = frames[joint];
    return frame(f.row_a, f.anchor_a, f.rotation_a);
  }
  Pose frame_b(std::size_t joint) const {
    const JointFrames& f = frames[joint];
    return frame(f.row_b, f.anchor_b, f.rotation_b);
  }
  // Anchor b as seen from frame a.
  Vec3 offset(std::size_t joint) const {
    const Pose a = frame_a(joint), b = frame_b(joint);
    return rotate(conjugate(a.rotation), b.position - a.position);
  }
  // Rotation vector of frame b in frame a.
  Vec3 angles(std::size_t joint) const {
    Quat q = conjugate(frame_a(joint).rotation) * frame_b(joint).rotation;
    if (q.w < 0) q = {-q.x, -q.y, -q.z, -q.w};
    const Vec3 v{q.x, q.y, q.z};
    const float sine = length(v);
    return sine > 0 ? v * (2 * std::atan2(sine, q.w) / sine) : v;
  }

  simd::BodyArgs body_args() {
    simd::BodyArgs args{};
    args.list = moving.data();
    args.pose = pose.data();
    args.velocity = velocity.data();
    args.free_velocity = free_velocity.data();
    args.velocity_before = velocity.data();
    args.delta = delta.data();
    args.inertia = inertia.data();
    args.local_mass = local_mass.data();
    args.local_inertia = local_inertia.data();
    args.motion = motion.data();
    args.step_notes = step_notes.data();
    args.force = force.data();
    args.center = center.data();
    args.transform = transform.data();
    args.sleep_timer = timer.data();
    args.drift = drift.data();
    args.flags = flags.data();
    args.mass = mass.data();
    args.kinetic_energy = energy.data();
    args.non_finite = non_finite.data();
    args.gravity[0] = gravity.x;
    args.gravity[1] = gravity.y;
    args.gravity[2] = gravity.z;
    args.substep = dt / static_cast<float>(substeps);
    args.step = dt;
    args.max_linear_speed = args.max_angular_speed = 1e6f;
    args.sleep_time = 1;
    args.warm_start = !bare;
    return args;
  }
  simd::JointArgs joint_args() {
    simd::JointArgs args{};
    args.rows = rows.data();
    args.blocks = blocks.data();
    args.frames = frames.data();
    args.parameters = parameters.data();
    args.user = user.data();
    args.user_state = user_state.data();
    args.user_jacobians = user_jacobians.data();
    args.user_targets = user_targets.data();
    args.user_bounds = user_bounds.data();
    args.impulses = impulses.data();
    args.reactions = reactions.data();
    args.pose = pose.data();
    args.velocity = velocity.data();
    args.delta = delta.data();
    args.joint_count = joint_count.data();
    args.inertia = inertia.data();
    args.substep = dt / static_cast<float>(substeps);
    args.inverse_substep = 1 / args.substep;
    args.max_hertz = 0.25f * args.inverse_substep;
    const float omega = 2 * std::numbers::pi_v<float> * args.max_hertz, a1 = 4 + args.substep * omega,
                a2 = args.substep * omega * a1;
    args.stiff = args.stiff_shared = {omega / a1, a2 / (1 + a2), 1 / (1 + a2)};
    args.max_hertz_shared = args.max_hertz;
    if (bare) args.stiff = {0, 1, 0};
    args.push_speed = 3;
    args.warm_start_scale = warm && !bare ? 1.0f : 0.0f;
    args.impulse_keep = bare ? 0.0f : 1.0f;
    args.parts_a = parts_a.data();
    args.parts_b = parts_b.data();
    args.shared = shared.data();
    args.residual = residual.data();
    return args;
  }

  // One step of all bodies and joints, which are all of this variant.
  void step(const simd::Kernels& kernels, JointType type, bool rich) {
    const simd::JointVariantKernels& joints = kernels.joint.variant[simd::joint_variant(type, rich)];
    const int count = static_cast<int>(frames.size()), moved = static_cast<int>(moving.size());
    const int block_count = (count + kernels.lanes - 1) / kernels.lanes;
    rows.resize(0);
    for (int lane = 0; lane < block_count * kernels.lanes; ++lane) {
      rows.push_back(std::min(lane, count - 1));
    }
    blocks.resize(joints.block_bytes * static_cast<std::size_t>(block_count));
    residual.resize(1);
    shared.resize(1);
    parts_a.resize(rows.size());
    parts_b.resize(rows.size());
    simd::BodyArgs body = body_args();
    simd::JointArgs joint = joint_args();
    const simd::ConstraintChunk chunk{
        simd::joint_variant(type, rich), block_count, count, 0, 0, 0, hub, fixed, peaks};
    kernels.body.prepare(body, 0, moved);
    joints.prepare(joint, chunk);
    for (int substep = 0; substep < substeps; ++substep) {
      body.first_substep = substep == 0;
      joint.elapsed = static_cast<float>(substep) * joint.substep;
      kernels.body.integrate_velocities(body, 0, moved);
      if (substep == 0) joints.warm_start(joint, chunk);
      joints.solve(joint, chunk);
      kernels.body.integrate_poses(body, 0, moved);
      joint.elapsed = static_cast<float>(substep + 1) * joint.substep;
      (substep == substeps - 1 ? joints.relax_measured : joints.relax)(joint, chunk);
    }
    joints.store(joint, chunk);
    kernels.body.finish(body, 0, moved);
    warm = true;
  }

 private:
  std::int32_t add_row(const InertiaRow& inverse, Vec3 p, Quat q, Vec3 v, Vec3 w) {
    pose.push_back({{p.x, p.y, p.z}, 0, {q.x, q.y, q.z, q.w}});
    velocity.push_back({{v.x, v.y, v.z}, {w.x, w.y, w.z}, 0, 0});
    free_velocity.push_back({});
    delta.push_back({{0, 0, 0}, {0, 0, 0, 1}, 0});
    inertia.push_back({});
    local_mass.push_back(inverse);
    local_inertia.push_back({});
    motion.push_back({0, 0, inverse.inverse_mass > 0 ? 1.0f : 0.0f, kMotionJointed});
    step_notes.push_back(0);
    joint_count.push_back(0);
    force.push_back({});
    for (int i = 0; i < 3; ++i) center.push_back(0);
    for (int i = 0; i < 7; ++i) transform.push_back(0);
    timer.push_back(0);
    drift.push_back({});
    flags.push_back(0);
    mass.push_back(0);
    energy.push_back(0);
    non_finite.push_back(0);
    return static_cast<std::int32_t>(pose.size()) - 1;
  }
  void place(std::int32_t body, const Pose& in_world, float (&anchor)[3], float (&rotation)[4]) const {
    const Quat back = conjugate(rotation_of(body));
    const Vec3 p = rotate(back, in_world.position - position_of(body));
    const Quat q = normalize(back * in_world.rotation);
    const float places[3] = {p.x, p.y, p.z}, parts[4] = {q.x, q.y, q.z, q.w};
    std::copy(places, places + 3, anchor);
    std::copy(parts, parts + 4, rotation);
  }
  Pose frame(std::int32_t body, const float (&anchor)[3], const float (&rotation)[4]) const {
    const Quat q = rotation_of(body);
    return {position_of(body) + rotate(q, Vec3{anchor[0], anchor[1], anchor[2]}),
            q * Quat{rotation[0], rotation[1], rotation[2], rotation[3]}};
  }
};

}  // namespace scree::joint_tests
