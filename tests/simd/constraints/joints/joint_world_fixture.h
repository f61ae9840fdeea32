// The bench of joint_fixture.h with frames given in the bodies, and what laws of joints ask of it.
#pragma once

#include "joint_fixture.h"

#include <scree/joint.h>

#include <string>

namespace scree::joint_tests {

inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr Vec3 kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1}, kWeight{0, -9.81f, 0};

inline Quat about(Vec3 axis, float angle) { return turn(axis * (1 / length(axis)), angle); }

inline JointParameters free_parameters() {
  JointParameters p{};
  for (JointAxisRow& axis : p.axis) axis = kFreeAxis;
  p.damping_ratio = p.angular_damping_ratio = 1;
  return p;
}
// Of joints with a rotation drive: its target, where axis 3 of others is, is no rotation.
inline JointParameters free_rotation() {
  JointParameters p = free_parameters();
  p.axis[3] = {0, 0, 0, 1, 1, 1, 0, kDriveNone};
  return p;
}

struct JointWorld : Bench {
  std::int32_t add_body(float kilograms, Vec3 moments, Vec3 position, Quat rotation = {},
                        const Velocity& v = {}) {
    const std::int32_t body = Bench::add_body(kilograms, moments, position, rotation, v.linear, v.angular);
    const bool round = moments.x == moments.y && moments.y == moments.z;
    if (!round) motion[static_cast<std::size_t>(body)].flags |= kMotionGyroscopic;
    return body;
  }
  std::size_t add_joint(std::int32_t a, const Pose& in_a, std::int32_t b, const Pose& in_b,
                        const JointParameters& given = free_rotation()) {
    const std::size_t joint = Bench::add_joint(a, placed(a, in_a), b, placed(b, in_b));
    parameters[joint] = given;
    return joint;
  }
  void step(const simd::Kernels& kernels, JointType type, bool rich = true) {
    Bench::step(kernels, type, rich);
  }

  void step(const simd::Kernels& kernels, int variant) {
    Bench::step(kernels, static_cast<JointType>(variant / 2), variant % 2 != 0);
  }

  Vec3 linear(std::int32_t body) const {
    const float* v = velocity[static_cast<std::size_t>(body)].linear;
    return {v[0], v[1], v[2]};
  }
  Vec3 angular(std::int32_t body) const {
    const float* w = velocity[static_cast<std::size_t>(body)].angular;
    return {w[0], w[1], w[2]};
  }
  // Of anchor b against anchor a.
  Vec3 anchor_speed(std::size_t joint) const {
    const JointFrames& f = frames[joint];
    return linear(f.row_b) + cross(angular(f.row_b), frame_b(joint).position - position_of(f.row_b)) -
           linear(f.row_a) - cross(angular(f.row_a), frame_a(joint).position - position_of(f.row_a));
  }
  Quat turned(std::size_t joint) const {
    return conjugate(frame_a(joint).rotation) * frame_b(joint).rotation;
  }

 private:
  Pose placed(std::int32_t body, const Pose& local) const {
    return {position_of(body) + rotate(rotation_of(body), local.position),
            rotation_of(body) * local.rotation};
  }
};

// Adds two bodies that fly about and turn, or one beside the world, and a joint of them. Frame b lies in
// frame a where `between` says, but for `slip`, m and rad. The functions draw from `random`, too.
template <class Moments, class Between, class Parameters>
void add_random_joint(JointWorld& world, Random& random, bool of_world, float slip, Moments&& moments,
                      Between&& between, Parameters&& parameters) {
  const Pose frame_a{random.vector(0.5f), random.rotation()}, frame_b{random.vector(0.5f), random.rotation()};
  const auto velocity = [&] { return Velocity{random.vector(2), random.vector(3)}; };
  std::int32_t a = kFixedRow;
  Pose at_a{};
  if (!of_world) {
    at_a = {random.vector(2), random.rotation()};
    a = world.add_body(random.uniform(0.5f, 5), moments(), at_a.position, at_a.rotation, velocity());
  }
  const Pose free = between();
  const Quat to_a = at_a.rotation * frame_a.rotation, slipped = about(kX + random.vector(0.5f), slip);
  const Quat b = normalize(to_a * free.rotation * slipped * conjugate(frame_b.rotation));
  const Vec3 anchor = at_a.position + rotate(at_a.rotation, frame_a.position) + rotate(to_a, free.position) +
                      random.vector(slip);
  const std::int32_t body_b =
      world.add_body(random.uniform(0.5f, 5), moments(), anchor - rotate(b, frame_b.position), b, velocity());
  world.add_joint(a, frame_a, body_b, frame_b, parameters());
}

}  // namespace scree::joint_tests
