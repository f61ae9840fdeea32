// Laws of populate(): a world holds what its scene lists, bodies and joints, in the scene's order.
#include <gtest/gtest.h>
#include <tools/scenes/scene.h>

#include <algorithm>
#include <array>
#include <set>

namespace scree::scenes {
namespace {

TEST(Populate, EveryBodyGetsItsPoseItsShapesAndAHandle) {
  for (const SceneInfo& info : catalog()) {
    Parameters parameters;
    if (info.parameters.contains("bodies")) parameters["bodies"] = 60;
    if (info.parameters.contains("layers")) parameters["layers"] = 2;
    if (info.parameters.contains("worlds")) parameters["worlds"] = 2;
    if (info.parameters.contains("ragdolls")) parameters["ragdolls"] = 3;
    if (info.parameters.contains("triangles")) parameters["triangles"] = 500;
    if (info.parameters.contains("wheels")) parameters["wheels"] = 3;
    for (const Scene& scene : build(info.name, parameters)) {
      World world(scene.settings);
      const std::vector<BodyId> ids = populate(world, scene);
      ASSERT_EQ(ids.size(), scene.bodies.size());
      const auto later = static_cast<std::size_t>(std::count_if(
          scene.bodies.begin(), scene.bodies.end(), [](const SceneBody& body) { return body.comes_later; }));
      EXPECT_EQ(world.body_count(), scene.bodies.size() - later);
      EXPECT_EQ(std::set<BodyId>(ids.begin(), ids.end()).size(), ids.size() - later + (later > 0 ? 1 : 0));
      for (std::size_t i = 0; i < ids.size(); ++i) {
        const SceneBody& body = scene.bodies[i];
        if (body.comes_later) {
          EXPECT_EQ(ids[i], BodyId{});
          continue;
        }
        EXPECT_EQ(world.body_type(ids[i]), body.def.type);
        EXPECT_NEAR(world.pose(ids[i]).position.x, body.def.position.x, 1e-4f);
        EXPECT_NEAR(world.pose(ids[i]).position.y, body.def.position.y, 1e-4f);
        std::array<ShapeId, 64> shapes{};
        ASSERT_EQ(world.shapes_of(ids[i], shapes), body.shape_count);
        for (std::uint32_t k = 0; k < body.shape_count; ++k) {
          const SceneShape& expected = scene.shapes[body.first_shape + k];
          EXPECT_EQ(world.geometry(shapes[k]).index(), expected.geometry.index());
          EXPECT_EQ(world.material(shapes[k]), expected.material);
        }
      }
    }
  }
}

TEST(Populate, EveryJointJoinsItsBodiesAsTheSceneSays) {
  for (const SceneInfo& info : catalog()) {
    Parameters parameters;
    if (info.parameters.contains("columns")) parameters["columns"] = 6;
    if (info.parameters.contains("bodies")) parameters["bodies"] = 10;
    if (info.parameters.contains("ragdolls")) parameters["ragdolls"] = 3;
    if (info.parameters.contains("triangles")) parameters["triangles"] = 500;
    if (info.parameters.contains("wheels")) parameters["wheels"] = 3;
    if (info.parameters.contains("worlds")) parameters["worlds"] = 1;
    const Scene scene = build(info.name, parameters).front();
    World world(scene.settings);
    std::vector<JointId> joints;
    const std::vector<BodyId> bodies = populate(world, scene, &joints);
    ASSERT_EQ(joints.size(), scene.joints.size()) << info.name;
    EXPECT_EQ(world.joint_count(), scene.joints.size()) << info.name;
    const auto handle = [&](std::uint32_t body) { return body == kWorldItself ? kWorld : bodies[body]; };
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const SceneJoint& expected = scene.joints[i];
      const JointDef def = world.joint_def(joints[i]);
      EXPECT_EQ(def.body_a, handle(expected.body_a)) << info.name << " " << i;
      EXPECT_EQ(def.body_b, handle(expected.body_b)) << info.name << " " << i;
      EXPECT_EQ(def.frame_a.position, expected.def.frame_a.position);
      EXPECT_EQ(def.frame_b.position, expected.def.frame_b.position);
      EXPECT_EQ(static_cast<std::size_t>(world.joint_type(joints[i])), expected.joint.index());
      if (world.joint_type(joints[i]) == JointType::user) {
        std::vector<UserRow> rows(world.user_rows(joints[i], {}));
        world.user_rows(joints[i], rows);
        EXPECT_EQ(rows, expected.rows);
      }
    }
  }
}

TEST(Populate, MoreJointsThanOneCallTakesKeepTheirOrder) {
  // 150 x 250 balls come to 74,600 joints: two calls.
  const Scene scene = build("joint_grid", {{"columns", 150}, {"rows", 250}}).front();
  ASSERT_GT(scene.joints.size(), std::size_t{1} << 16);
  World world(scene.settings);
  std::vector<JointId> joints;
  const std::vector<BodyId> bodies = populate(world, scene, &joints);
  EXPECT_EQ(world.joint_count(), scene.joints.size());
  for (std::size_t i = 0; i < joints.size(); i += 997) {
    EXPECT_EQ(world.joint_def(joints[i]).body_b, bodies[scene.joints[i].body_b]) << i;
  }
}

}  // namespace
}  // namespace scree::scenes
