// See sweep_near.h.
#include <core/world/edit.h>
#include <parallel/continuous/sweep_near.h>
#include <parallel/continuous/sweep_whole.h>

#include <algorithm>
#include <limits>

namespace scree::sweeps {

namespace {

bool meets_lane(const Swept& box, const float (&bounds)[6][simd::kBlock], std::size_t lane) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(box.lower[axis] <= bounds[axis + 3][lane] && bounds[axis][lane] <= box.upper[axis])) return false;
  }
  return true;
}

// Adds a shape, if it is no mesh without a triangle that is near.
void add_near(const Obstacles& obstacles, std::int32_t shape, const Swept& bounds, const Reach& reach,
              NearShapes& near) {
  const MeshData* mesh = mesh_of(obstacles.data, shape);
  int listed = -1;
  if (mesh != nullptr) {
    const PoseRow& pose = obstacles.data.shapes.pose[shape];
    const MeshReach way{reach.start, reach.end, reach.radius};
    if (near.meshes < NearShapes::kMostMeshes) {
      NearTriangles& triangles = near.triangles[near.meshes];
      list_near_triangles(obstacles.kernels, *mesh, pose, way, triangles);
      if (triangles.count == 0) return;
      if (!triangles.too_many) listed = near.meshes++;
    } else if (!is_near_mesh(obstacles.kernels, *mesh, pose, way, nullptr)) {
      return;
    }
  }
  near.row[near.count++] = {shape, bounds, listed};
}

// Whether no shape is near the box, and no triangle of a mesh.
bool is_box_free(const Obstacles& obstacles, const Swept& box) {
  const auto is_far = [&](const simd::LeafBlock& leaf, std::size_t lane) {
    const std::int32_t shape = leaf.shape[lane];
    const MeshData* mesh = mesh_of(obstacles.data, shape);
    return mesh != nullptr && !is_near_mesh(obstacles.kernels, *mesh, obstacles.data.shapes.pose[shape], box);
  };
  const auto trees = obstacle_trees(obstacles.broad_phase);
  return std::all_of(trees.begin(), trees.end(), [&](const PairTree& tree) {
    return tree.levels == 0 || for_each_shape_near(tree, box, tree.levels - 1, 0, is_far);
  });
}

}  // namespace

bool moves_whole(const WorldData& data, std::int32_t body) {
  return (data.bodies.step_notes[body] & kMovesWhole) != 0;
}

float swept_radius(const WorldData& data, std::int32_t body) {
  const float size = data.bodies.core[body].size;
  return moves_whole(data, body) ? std::max(size, reach_of(data, body)) : size;
}

Reach reach_of_way(const WorldData& data, std::int32_t body) {
  const Vec3 start = to_vec3(data.bodies.pose[body].position),
             there = start + to_vec3(data.bodies.delta[body].position);
  const float radius = swept_radius(data, body);
  return {start, there, radius + rounding_of(start, there, radius)};
}

bool are_free(const Obstacles& obstacles, std::span<const std::int32_t> bodies) {
  // Without meshes, walks cost less than this does where it fails.
  if (obstacles.data.meshes.shared.empty()) return false;
  constexpr float kFar = std::numeric_limits<float>::infinity();
  Swept all({kFar, kFar, kFar}, {-kFar, -kFar, -kFar});
  for (const std::int32_t body : bodies) {
    if (!has_finite_motion(obstacles.data.bodies.delta[body])) continue;
    const Swept box = reach_of_way(obstacles.data, body).box;
    for (int axis = 0; axis < 3; ++axis) {
      all.lower[axis] = std::min(all.lower[axis], box.lower[axis]);
      all.upper[axis] = std::max(all.upper[axis], box.upper[axis]);
    }
  }
  // Of ways that leave the range of floats nothing is known.
  for (int axis = 0; axis < 3; ++axis) {
    if (!(all.upper[axis] - all.lower[axis] < kFar)) return false;
  }
  return is_box_free(obstacles, all);
}

void list_near(const Obstacles& obstacles, const Reach& reach, const Swept& box, NearShapes& near) {
  const auto add = [&](const simd::LeafBlock& leaf, std::size_t lane) {
    near.any = near.any || meets_lane(box, leaf.bounds, lane);
    near.too_many = near.count == NearShapes::kMost;
    if (near.too_many) return !near.any;
    const auto& bounds = leaf.bounds;
    add_near(obstacles, leaf.shape[lane],
             {{bounds[0][lane], bounds[1][lane], bounds[2][lane]},
              {bounds[3][lane], bounds[4][lane], bounds[5][lane]}},
             reach, near);
    return true;
  };
  for (const PairTree& tree : obstacle_trees(obstacles.broad_phase)) {
    if (tree.levels > 0 && !for_each_shape_near(tree, reach.box, tree.levels - 1, 0, add)) return;
  }
}

void drop_far_triangles(const WorldData& data, std::int32_t body, const Motion& motion, int stretches,
                        const Reach& reach, NearShapes& near) {
  const std::int32_t shape = data.bodies.first_shape[body];
  // Compounds have too many balls, and bodies without shapes none.
  if (shape < 0 || data.shapes.next[shape] >= 0) return;
  if (near.meshes == 0 || near.too_many || stretches > kMostStretches) return;
  Balls made;
  const Balls& balls = balls_at(data, shape, made);
  Ball ends[kMostEnds];
  Vec3 arms[kMostBalls];
  for (int i = 0; i < balls.count; ++i) arms[i] = arm_of(data, body, shape, balls.ball[i].center);
  std::size_t count = 0;
  if (balls.count > 0) ends[count++] = {reach.end + arms[0], balls.ball[0].radius};  // as for hold_centers()
  for (int k = 1; k <= stretches; ++k) {
    const DeltaRow to = part_of(motion, static_cast<float>(k) / static_cast<float>(stretches));
    for (int i = 0; i < balls.count; ++i) {
      ends[count++] = {reach.start + to_vec3(to.position) + rotate(to_quat(to.rotation), arms[i]),
                       balls.ball[i].radius};
    }
  }
  const float room = 2.0f * rounding_of(reach.start, reach.end, 2.0f * reach.radius);
  int left = 0;
  for (int k = 0; k < near.count; ++k) {
    const NearShapes::Row row = near.row[k];
    if (row.mesh >= 0) {
      NearTriangles& triangles = near.triangles[row.mesh];
      drop_triangles_below(*mesh_of(data, row.shape), data.shapes.pose[row.shape], {ends, count}, room,
                           triangles);
      if (triangles.count == 0) continue;
    }
    near.row[left++] = row;
  }
  near.count = left;
}

}  // namespace scree::sweeps
