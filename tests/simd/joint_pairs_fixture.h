// Bodies in pairs with a joint each, for the tests of the joint kernels: rows filled by hand, and a step as
// parallel/solve.cpp takes it, without contacts.
#pragma once

#include <core/column.h>
#include <core/math.h>
#include <gtest/gtest.h>
#include <scree/joint.h>
#include <simd/kernels.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace scree::joint_pairs {

constexpr float kPi = std::numbers::pi_v<float>;

inline Quat turn(Vec3 axis, float angle) {
  const float s = std::sin(angle / 2) / length(axis);
  return {axis.x * s, axis.y * s, axis.z * s, std::cos(angle / 2)};
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  float uniform(float low, float high) { return std::uniform_real_distribution<float>(low, high)(engine_); }
  Vec3 vector(float size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  Quat rotation() {
    const Vec3 axis = vector(1.0f);
    return turn(length(axis) > 0.01f ? axis : Vec3{1, 0, 0}, uniform(-kPi, kPi));
  }

 private:
  std::mt19937 engine_;
};

inline std::vector<const simd::Kernels*> all_kernels() {
  std::vector<const simd::Kernels*> sets;
  for (int set = 0; set < simd::kInstructionSetCount; ++set) {
    const simd::Kernels* kernels = simd::find_kernels(static_cast<simd::InstructionSet>(set));
    if (kernels != nullptr) sets.push_back(kernels);
  }
  return sets;
}

inline JointParameters free_parameters() {
  JointParameters p{};
  for (JointAxisRow& axis : p.axis) {
    axis = {-kNoLimit, kNoLimit, 0, 0, 1.0f, 1.0f, kNoLimit, kDriveNone};
  }
  p.damping_ratio = p.angular_damping_ratio = 1.0f;
  p.axis[3].lower = p.axis[3].upper = p.axis[3].target = 0.0f;
  p.axis[3].speed = 1.0f;  // the target of rotation drives: none
  return p;
}

struct JointWorld {
  Column<PoseRow> pose;
  Column<VelocityRow> velocity, free_velocity;
  Column<DeltaRow> delta;
  Column<InertiaRow> inertia, local_mass;
  Column<LocalInertiaRow> local_inertia;
  Column<MotionRow> motion;
  Column<ForceRow> force;
  Column<std::uint8_t> touched, broken, flags;
  Column<DriftRow> drift;
  Column<float> center, transform, timer, mass, energy;
  Column<std::int32_t> list, rows;
  Column<JointFrames> frames;
  Column<JointParameters> parameters;
  Column<JointImpulses> impulses;
  Column<JointReactionRow> reactions;
  Column<char> blocks;
  float residual = 0.0f;
  Vec3 gravity{0, -9.81f, 0};
  int substeps = 4;
  float joint_hertz_ratio = 0.125f;  // of the rate of substeps
  float warm_start_scale = 1.0f;

  JointWorld() {
    for (int row = 0; row < kFirstBody; ++row) add_row(0.0f, {}, {}, {}, {});
  }

  std::size_t add_row(float body_mass, Vec3 moment, Vec3 position, Quat rotation, const Velocity& v) {
    const auto inverse = [](float x) { return x > 0.0f ? 1.0f / x : 0.0f; };
    pose.push_back(
        {{position.x, position.y, position.z}, 0, {rotation.x, rotation.y, rotation.z, rotation.w}});
    velocity.push_back({{v.linear.x, v.linear.y, v.linear.z}, {v.angular.x, v.angular.y, v.angular.z}, {}});
    free_velocity.push_back({});
    delta.push_back({{0, 0, 0}, {0, 0, 0, 1}, 0});
    const InertiaRow m{
        {inverse(moment.x), 0, 0, inverse(moment.y), 0, inverse(moment.z)}, inverse(body_mass), 0};
    inertia.push_back(m);
    local_mass.push_back(m);
    local_inertia.push_back({{moment.x, 0, 0, moment.y, 0, moment.z}, {}});
    const bool round = moment.x == moment.y && moment.y == moment.z;
    motion.push_back({0, 0, 1.0f, kMotionJointed | (round ? 0u : std::uint32_t{kMotionGyroscopic})});
    force.push_back({});
    touched.push_back(0);
    broken.push_back(0);
    for (int i = 0; i < 3; ++i) center.push_back(0.0f);
    for (int i = 0; i < 7; ++i) transform.push_back(0.0f);
    timer.push_back(0.0f);
    drift.push_back({});
    flags.push_back(0);
    mass.push_back(body_mass);
    energy.push_back(0.0f);
    return pose.size() - 1;
  }
  // A dynamic body; `moment`: inertia about its axes.
  std::int32_t add_body(float body_mass, Vec3 moment, Vec3 position, Quat rotation = {},
                        const Velocity& v = {}) {
    list.push_back(static_cast<std::int32_t>(add_row(body_mass, moment, position, rotation, v)));
    return list.back();
  }

  // Frames in the axes of the bodies, from their centers of mass.
  std::size_t add_joint(std::int32_t a, Pose frame_a, std::int32_t b, Pose frame_b,
                        const JointParameters& given = free_parameters()) {
    const auto fill = [](float* anchor, float* rotation, const Pose& p) {
      const float position[3] = {p.position.x, p.position.y, p.position.z};
      const float turned[4] = {p.rotation.x, p.rotation.y, p.rotation.z, p.rotation.w};
      std::memcpy(anchor, position, sizeof(position));
      std::memcpy(rotation, turned, sizeof(turned));
    };
    JointFrames f{};
    fill(f.anchor_a, f.rotation_a, frame_a);
    fill(f.anchor_b, f.rotation_b, frame_b);
    f.row_a = a;
    f.row_b = b;
    frames.push_back(f);
    parameters.push_back(given);
    impulses.push_back({});
    reactions.push_back({});
    return frames.size() - 1;
  }

  simd::JointArgs joint_args(float dt) {
    simd::JointArgs args{};
    args.rows = rows.data();
    args.blocks = blocks.data();
    args.frames = frames.data();
    args.parameters = parameters.data();
    args.impulses = impulses.data();
    args.reactions = reactions.data();
    args.pose = pose.data();
    args.velocity = velocity.data();
    args.delta = delta.data();
    args.inertia = inertia.data();
    args.substep = dt / static_cast<float>(substeps);
    args.inverse_substep = 1.0f / args.substep;
    args.max_hertz = joint_hertz_ratio * args.inverse_substep;
    const float turn_rate = 2.0f * kPi * joint_hertz_ratio, a1 = 4.0f + turn_rate, a2 = turn_rate * a1;
    args.stiff = {turn_rate * args.inverse_substep / a1, a2 / (1.0f + a2), 1.0f / (1.0f + a2)};
    args.push_speed = 3.0f;
    args.warm_start_scale = warm_start_scale;
    args.impulse_keep = warm_start_scale > 0.0f ? 1.0f : 0.0f;
    args.residual = &residual;
    return args;
  }

  simd::BodyArgs body_args(float dt) {
    simd::BodyArgs args{};
    args.list = list.data();
    args.pose = pose.data();
    args.velocity = velocity.data();
    args.free_velocity = free_velocity.data();
    args.delta = delta.data();
    args.inertia = inertia.data();
    args.local_mass = local_mass.data();
    args.local_inertia = local_inertia.data();
    args.motion = motion.data();
    args.touched = touched.data();
    args.force = force.data();
    args.center = center.data();
    args.transform = transform.data();
    args.sleep_timer = timer.data();
    args.drift = drift.data();
    args.flags = flags.data();
    args.mass = mass.data();
    args.kinetic_energy = energy.data();
    args.broken = broken.data();
    args.gravity[0] = gravity.x;
    args.gravity[1] = gravity.y;
    args.gravity[2] = gravity.z;
    args.substep = dt / static_cast<float>(substeps);
    args.step = dt;
    args.max_linear_speed = 400.0f;
    args.max_angular_speed = 400.0f;
    args.sleep_time = 1.0f;
    args.warm_start = warm_start_scale > 0.0f;
    return args;
  }

  // All joints are of one variant, and no body has two of them.
  void step(const simd::Kernels& kernels, int variant, float dt = 1.0f / 60.0f) {
    const simd::JointVariantKernels& joint_kernels = kernels.joint.variant[variant];
    const int joints = static_cast<int>(frames.size()), bodies = static_cast<int>(list.size());
    rows.clear();
    for (int j = 0; j < joints + kernels.lanes; ++j) rows.push_back(j < joints ? j : joints - 1);
    const int block_count = (joints + kernels.lanes - 1) / kernels.lanes;
    blocks.resize(static_cast<std::size_t>(block_count) * joint_kernels.block_bytes);
    const simd::ConstraintChunk chunk{
        variant, block_count, joints, 0, 0, 0, simd::BodySide::none, simd::BodySide::none};
    for (int i = 0; i < kernels.lanes; ++i) list.push_back(list.back());  // what a kernel may read
    simd::JointArgs joint = joint_args(dt);
    simd::BodyArgs body = body_args(dt);
    kernels.body.prepare(body, 0, bodies);
    joint_kernels.prepare(joint, chunk);
    for (int substep = 0; substep < substeps; ++substep) {
      body.first_substep = substep == 0;
      joint.elapsed = static_cast<float>(substep) * joint.substep;
      kernels.body.integrate_velocities(body, 0, bodies);
      if (substep == 0 && warm_start_scale > 0.0f) joint_kernels.warm_start(joint, chunk);
      joint_kernels.solve(joint, chunk);
      kernels.body.integrate_poses(body, 0, bodies);
      joint.elapsed = static_cast<float>(substep + 1) * joint.substep;
      if (substep == substeps - 1) {
        joint_kernels.relax_measured(joint, chunk);
      } else {
        joint_kernels.relax(joint, chunk);
      }
    }
    joint_kernels.store(joint, chunk);
    kernels.body.finish(body, 0, bodies);
    list.resize(static_cast<std::size_t>(bodies));
  }

  Vec3 position(std::int32_t row) const {
    const float* p = pose[static_cast<std::size_t>(row)].position;
    return {p[0], p[1], p[2]};
  }
  Quat rotation(std::int32_t row) const {
    const float* q = pose[static_cast<std::size_t>(row)].rotation;
    return {q[0], q[1], q[2], q[3]};
  }
  Vec3 linear(std::int32_t row) const {
    const float* v = velocity[static_cast<std::size_t>(row)].linear;
    return {v[0], v[1], v[2]};
  }
  Vec3 angular(std::int32_t row) const {
    const float* w = velocity[static_cast<std::size_t>(row)].angular;
    return {w[0], w[1], w[2]};
  }
  // Of a joint's frames in the world.
  Pose frame_a(std::size_t joint) const {
    const JointFrames& f = frames[joint];
    return placed(f.row_a, f.anchor_a, f.rotation_a);
  }
  Pose frame_b(std::size_t joint) const {
    const JointFrames& f = frames[joint];
    return placed(f.row_b, f.anchor_b, f.rotation_b);
  }
  Vec3 anchor_speed(std::size_t joint) const {
    const JointFrames& f = frames[joint];
    return linear(f.row_b) + cross(angular(f.row_b), frame_b(joint).position - position(f.row_b)) -
           linear(f.row_a) - cross(angular(f.row_a), frame_a(joint).position - position(f.row_a));
  }

 private:
  Pose placed(std::int32_t row, const float* anchor, const float* turned) const {
    return {position(row) + rotate(rotation(row), {anchor[0], anchor[1], anchor[2]}),
            rotation(row) * Quat{turned[0], turned[1], turned[2], turned[3]}};
  }
};

}  // namespace scree::joint_pairs
