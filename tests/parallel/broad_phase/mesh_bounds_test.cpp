// Laws of the bounds of meshes: they contain every corner however the mesh is turned, are no larger than box
// and ball require, and have the same bits on every backend.
#include <core/geometry/mesh/mesh_build.h>
#include <core/world/edit.h>
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <tests/parallel/hand_made_world.h>
#include <tools/scenes/random.h>

#include <cstring>
#include <vector>

namespace scree::testing {
namespace {

using scenes::Random;

constexpr float kMeshStep = 1.0f / 60.0f;  // s

Vec3 random_point(Random& random, Vec3 size) {
  const float x = random.between(-size.x, size.x), y = random.between(-size.y, size.y);
  return {x, y, random.between(-size.z, size.z)};
}

// Meshes of all shapes and places, some of them flat, fixed and kinematic.
World make_mesh_world() {
  Random random(9);
  World world;
  for (int i = 0; i < 200; ++i) {
    std::vector<Vec3> points(3 + random.below(40));
    const Vec3 shift = random_point(random, {500, 500, 500});
    const Vec3 size{random.between(0.1f, 30.0f), i % 4 == 0 ? 0.0f : random.between(0.1f, 30.0f), 2.0f};
    for (Vec3& p : points) p = random_point(random, size) + shift;
    std::vector<MeshTriangle> triangles;
    for (std::uint32_t k = 2; k < points.size(); ++k) triangles.push_back({k - 2, k - 1, k});
    const BodyId body = world.create_body({.type = i % 2 == 0 ? BodyType::fixed : BodyType::kinematic,
                                           .position = random_point(random, {100, 100, 100}),
                                           .rotation = random.rotation(),
                                           .linear_velocity = random_point(random, {5, 5, 5}),
                                           .angular_velocity = random_point(random, {1, 1, 1})});
    world.add_shape(body, TriangleMesh(points, triangles), {},
                    {.local_pose = {random_point(random, {9, 9, 9}), random.rotation()}});
  }
  return world;
}

TEST(MeshBounds, HoldEveryCornerAndHaveTheSameBitsEverywhere) {
  std::vector<BoundsRow> expected;
  for (const WorkersOptions& options : all_workers()) {
    World world = make_mesh_world();
    Workers workers(options);
    for (int k = 0; k < 3; ++k) step(world, kMeshStep, workers);
    const WorldData& data = internals(world);
    const Shapes& shapes = data.shapes;
    for (std::size_t s = 0; s < shapes.flags.size(); ++s) {
      const MeshData& mesh = *data.meshes.data[shapes.mesh[s]];
      const PoseRow& pose = shapes.pose[s];
      const Quat rotation{pose.rotation[0], pose.rotation[1], pose.rotation[2], pose.rotation[3]};
      const Vec3 place{pose.position[0], pose.position[1], pose.position[2]};
      const BoundsRow& bounds = shapes.fat_bounds[s];
      for (std::int32_t i = 0; i < mesh.vertex_count; ++i) {
        const Vec3 corner =
            place + rotate(rotation, {mesh.vertex[3 * i], mesh.vertex[3 * i + 1], mesh.vertex[3 * i + 2]});
        for (int k = 0; k < 3; ++k) {
          ASSERT_GE(corner[k], bounds.lower[k] + 0.4f * kSpeculativeDistance) << s;
          ASSERT_LE(corner[k], bounds.upper[k] - 0.4f * kSpeculativeDistance) << s;
        }
        const Vec3 center = 0.5f * (to_vec3(bounds.lower) + to_vec3(bounds.upper));
        ASSERT_LE(length(corner - center), bounds.sphere_radius) << s;
      }
      const VelocityRow& v = data.bodies.velocity[shapes.body[s]];
      const float most = shapes.extent[s].radius + 0.5f * kSpeculativeDistance + 0.05f +
                         0.5f * kMeshStep * length(to_vec3(v.linear)) + 2e-3f;
      EXPECT_LE(bounds.sphere_radius, most) << s;
      for (int k = 0; k < 3; ++k) EXPECT_LE(0.5f * (bounds.upper[k] - bounds.lower[k]), most) << s;
    }
    const auto rows = shapes.fat_bounds.span();
    if (expected.empty()) expected.assign(rows.begin(), rows.end());
    EXPECT_EQ(std::memcmp(expected.data(), rows.data(), rows.size_bytes()), 0);
  }
}

}  // namespace
}  // namespace scree::testing
