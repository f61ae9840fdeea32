// Rows of user joints as other kinds of joints have them, made anew from the poses by a callback.
#pragma once

#include <tests/physics/lab.h>

#include <functional>
#include <map>
#include <vector>

namespace scree::physics {

// What a callback knows of one user joint: the bodies' anchors and whatever makes rows of them.
struct Stated {
  BodyId a, b;              // a may be kWorld
  Vec3 anchor_a, anchor_b;  // in the bodies
};

// Where the anchors are, from the centers of mass, and how far apart.
struct Anchored {
  Vec3 arm_a, arm_b, offset;
};
inline Pose pose_of(const World& world, BodyId body) { return body == kWorld ? Pose{} : world.pose(body); }
inline Anchored anchored(const World& world, const Stated& stated) {
  const Pose a = pose_of(world, stated.a), b = pose_of(world, stated.b);
  const Vec3 arm_a = rotate(a.rotation, stated.anchor_a), arm_b = rotate(b.rotation, stated.anchor_b);
  return {arm_a, arm_b, (b.position + arm_b) - (a.position + arm_a)};
}

// J = [-n, -r_a x n, n, r_b x n]: the anchors apart along n.
inline UserRow along(const Anchored& at, Vec3 n, float error) {
  return {.jacobian = {-1.0f * n, -1.0f * cross(at.arm_a, n), n, cross(at.arm_b, n)},
          .target = {.error = error}};
}
// J = [0, -n, 0, n]: b turns against a.
inline UserRow about(Vec3 n, float error) {
  return {.jacobian = {{}, -1.0f * n, {}, n}, .target = {.error = error}};
}

inline constexpr Vec3 kAxes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

inline std::vector<UserRow> ball_rows(const World& world, const Stated& stated) {
  const Anchored at = anchored(world, stated);
  std::vector<UserRow> rows;
  for (int i = 0; i < 3; ++i) rows.push_back(along(at, kAxes[i], at.offset[i]));
  return rows;
}

// A ball and two rows that keep the z axes of both bodies together, which they are at first.
inline std::vector<UserRow> hinge_rows(const World& world, const Stated& stated) {
  std::vector<UserRow> rows = ball_rows(world, stated);
  const Quat a = pose_of(world, stated.a).rotation, b = pose_of(world, stated.b).rotation;
  const Vec3 apart = cross(rotate(a, {0, 0, 1}), rotate(b, {0, 0, 1}));
  for (const Vec3 n : {rotate(a, {1, 0, 0}), rotate(a, {0, 1, 0})}) rows.push_back(about(n, dot(apart, n)));
  return rows;
}

// How far the distance of the anchors is from a length.
inline std::vector<UserRow> distance_row(const World& world, const Stated& stated, float wanted) {
  const Anchored at = anchored(world, stated);
  const float now = length(at.offset);
  return {along(at, at.offset * (1.0f / now), now - wanted)};
}

// Gives a world a callback that makes the rows of each of its user joints.
using MakeRows = std::function<std::vector<UserRow>(const World&)>;
inline void put_rows(const UserRowBatch& batch, std::size_t place, const std::vector<UserRow>& rows) {
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::size_t entry = kMaxUserRows * place + r;
    batch.jacobians[entry] = rows[r].jacobian;
    batch.targets[entry] = rows[r].target;
    batch.bounds[entry] = rows[r].bounds;
  }
}
inline void state_rows(World& world, std::map<JointId, MakeRows> rows) {
  world.set_user_row_callback([rows = std::move(rows)](const UserRowBatch& batch) {
    for (std::size_t i = 0; i < batch.joints.size(); ++i) {
      put_rows(batch, i, rows.at(batch.joints[i])(batch.world));
    }
  });
}

}  // namespace scree::physics
