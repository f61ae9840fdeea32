// A world whose columns are filled by hand, for tests and benchmarks of single stages.
#pragma once

#include <core/world/math.h>
#include <core/world/world_data.h>
#include <parallel/crew/crew.h>
#include <parallel/stages.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace scree::testing {

// A small generator of its own (PCG32, M. O'Neill, 2014): the standard distributions differ between
// libraries.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 2 + 1) { bits(); }
  std::uint32_t bits() {
    const std::uint64_t old = state_;
    state_ = old * 6364136223846793005u + 1442695040888963407u;
    const auto x = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
    const auto turn = static_cast<std::uint32_t>(old >> 59);
    return x >> turn | x << ((32 - turn) & 31);
  }
  std::uint32_t below(std::uint32_t limit) { return bits() % limit; }
  float uniform(float low, float high) {
    return low + (high - low) * static_cast<float>(bits() >> 8) * 0x1p-24f;
  }
  Vec3 point(Vec3 half) {
    return {uniform(-half.x, half.x), uniform(-half.y, half.y), uniform(-half.z, half.z)};
  }
  Quat rotation() {
    Quat q{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    q.w += q.w < 0 ? -0.1f : 0.1f;  // never near zero length
    return normalize(q);
  }

 private:
  std::uint64_t state_;
};

class HandMadeWorld {
 public:
  WorldData data;

  HandMadeWorld() {
    data.bodies.resize(kFirstBody);
    std::fill(data.bodies.first_joint.begin(), data.bodies.first_joint.end(), -1);
  }

  std::int32_t add_body(BodyType type, Vec3 position, Quat rotation = {}) {
    const std::size_t body = data.bodies.type.size();
    data.bodies.resize(body + 1);
    data.bodies.type[body] = type;
    data.bodies.flags[body] = kBodyAlive;
    data.bodies.first_shape[body] = -1;
    data.bodies.first_joint[body] = -1;
    place(static_cast<std::int32_t>(body), position, rotation);
    return static_cast<std::int32_t>(body);
  }

  // Reuses the slot of a destroyed shape, if there is one.
  std::int32_t add_shape(std::int32_t body, ShapeType type, ExtentRow extent, Pose local = {},
                         Filter filter = {}) {
    Shapes& shapes = data.shapes;
    std::size_t shape = shapes.type.size();
    if (shapes.free_slots.empty()) {
      shapes.resize(shape + 1);
    } else {
      shape = static_cast<std::size_t>(shapes.free_slots.back());
      shapes.free_slots.pop_back();
    }
    shapes.type[shape] = type;
    shapes.body[shape] = body;
    shapes.extent[shape] = extent;
    shapes.local_pose[shape] = row_of(local);
    shapes.filter[shape] = filter;
    const auto index = static_cast<std::size_t>(body);
    shapes.next[shape] = data.bodies.first_shape[index];
    data.bodies.first_shape[index] = static_cast<std::int32_t>(shape);
    shapes.flags[shape] |= kShapeAlive | kShapeNew;
    shapes.tree[shape] = tree_of(index);
    mark_dirty(static_cast<std::int32_t>(shape));
    data.contacts.pairs_stale = true;
    return static_cast<std::int32_t>(shape);
  }

  std::int32_t add_sphere(BodyType type, Vec3 position, float radius, Filter filter = {}) {
    return add_shape(add_body(type, position), ShapeType::sphere, {{0, 0, 0}, radius}, {}, filter);
  }
  std::int32_t add_box(BodyType type, Vec3 position, Vec3 half, Quat rotation = {}) {
    return add_shape(add_body(type, position, rotation), ShapeType::box, {{half.x, half.y, half.z}, 0});
  }
  // A sphere, a capsule or a box of about a meter.
  std::int32_t add_random_shape(std::int32_t body, Random& random, Pose local = {}, Filter filter = {}) {
    const float r = random.uniform(0.2f, 0.5f);
    switch (random.below(3)) {
      case 0:
        return add_shape(body, ShapeType::sphere, {{0, 0, 0}, r}, local, filter);
      case 1:
        return add_shape(body, ShapeType::capsule, {{0, random.uniform(0.1f, 0.5f), 0}, r}, local, filter);
      default:
        return add_shape(body, ShapeType::box,
                         {{r, random.uniform(0.2f, 0.5f), random.uniform(0.2f, 0.5f)}, 0}, local, filter);
    }
  }

  void destroy_body(std::int32_t body) {
    const auto index = static_cast<std::size_t>(body);
    for (std::int32_t shape = data.bodies.first_shape[index]; shape >= 0;) {
      const auto s = static_cast<std::size_t>(shape);
      mark_dirty(shape);
      shape = data.shapes.next[s];
      data.shapes.flags[s] = kShapeDirty;
      data.shapes.tree[s] = TreeKind::none;
      data.shapes.free_slots.push_back(static_cast<std::int32_t>(s));
    }
    if ((data.bodies.flags[index] & kBodyAsleep) != 0) --data.bodies.asleep;
    data.bodies.flags[index] = 0;
    data.bodies.first_shape[index] = -1;
    data.contacts.pairs_stale = true;
  }

  void place(std::int32_t body, Vec3 position, Quat rotation) {
    data.bodies.pose[static_cast<std::size_t>(body)] = row_of({position, rotation});
  }
  // As a call does it, between steps.
  void move_by_call(std::int32_t body, Vec3 position) {
    const auto index = static_cast<std::size_t>(body);
    PoseRow& pose = data.bodies.pose[index];
    pose.position[0] = position.x;
    pose.position[1] = position.y;
    pose.position[2] = position.z;
    for (std::int32_t shape = data.bodies.first_shape[index]; shape >= 0;
         shape = data.shapes.next[static_cast<std::size_t>(shape)]) {
      mark_dirty(shape);
    }
  }

  void set_asleep(std::int32_t body, bool asleep) {
    const auto index = static_cast<std::size_t>(body);
    data.bodies.asleep += (asleep ? 1 : 0) - ((data.bodies.flags[index] & kBodyAsleep) != 0 ? 1 : 0);
    data.bodies.flags[index] = static_cast<std::uint8_t>(kBodyAlive | (asleep ? kBodyAsleep : 0));
    for (std::int32_t shape = data.bodies.first_shape[index]; shape >= 0;
         shape = data.shapes.next[static_cast<std::size_t>(shape)]) {
      data.shapes.tree[static_cast<std::size_t>(shape)] = tree_of(index);
    }
  }

  bool alive(std::int32_t body) const {
    return (data.bodies.flags[static_cast<std::size_t>(body)] & kBodyAlive) != 0;
  }

  void integrate(float dt) {
    for (std::size_t body = kFirstBody; body < data.bodies.type.size(); ++body) {
      if (tree_of(body) == TreeKind::frozen) continue;
      PoseRow& pose = data.bodies.pose[body];
      const VelocityRow& v = data.bodies.velocity[body];
      for (int axis = 0; axis < 3; ++axis) pose.position[axis] += v.linear[axis] * dt;
      const Quat q{pose.rotation[0], pose.rotation[1], pose.rotation[2], pose.rotation[3]};
      const float h = 0.5f * dt;
      const Quat turn = normalize(Quat{v.angular[0] * h, v.angular[1] * h, v.angular[2] * h, 1.0f});
      const Quat turned = normalize(turn * q);
      pose.rotation[0] = turned.x;
      pose.rotation[1] = turned.y;
      pose.rotation[2] = turned.z;
      pose.rotation[3] = turned.w;
    }
  }

  // The list of shapes that may move, ascending.
  void refresh() {
    data.shapes.trees_changed = true;
    data.shapes.moving.clear();
    for (std::size_t shape = 0; shape < data.shapes.type.size(); ++shape) {
      const TreeKind tree = data.shapes.tree[shape];
      if ((data.shapes.flags[shape] & kShapeAlive) == 0) continue;
      if (tree == TreeKind::awake || tree == TreeKind::kinematic) {
        data.shapes.moving.push_back(static_cast<std::int32_t>(shape));
      }
    }
  }

 private:
  static PoseRow row_of(const Pose& pose) {
    return {{pose.position.x, pose.position.y, pose.position.z},
            0,
            {pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w}};
  }
  TreeKind tree_of(std::size_t body) const {
    if ((data.bodies.flags[body] & kBodyAlive) == 0) return TreeKind::none;
    if (data.bodies.type[body] == BodyType::kinematic) return TreeKind::kinematic;
    const bool awake =
        data.bodies.type[body] == BodyType::dynamic && (data.bodies.flags[body] & kBodyAsleep) == 0;
    return awake ? TreeKind::awake : TreeKind::frozen;
  }
  void mark_dirty(std::int32_t shape) {
    std::uint8_t& flags = data.shapes.flags[static_cast<std::size_t>(shape)];
    if ((flags & kShapeDirty) != 0) return;
    flags |= kShapeDirty;
    data.shapes.dirty.push_back(shape);
  }
};

// Every instruction set that runs here, with one and with several threads.
inline std::vector<WorkersOptions> all_workers() {
  std::vector<WorkersOptions> result;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    result.push_back({.threads = 1, .isa = isa});
    result.push_back({.threads = 3, .isa = isa});
  }
  return result;
}

}  // namespace scree::testing
