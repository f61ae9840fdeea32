// Laws of populate(): a world holds what its scene lists, in the scene's order.
#include <gtest/gtest.h>
#include <tools/scenes/scene.h>

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
    for (const Scene& scene : build(info.name, parameters)) {
      World world(scene.settings);
      const std::vector<BodyId> ids = populate(world, scene);
      ASSERT_EQ(ids.size(), scene.bodies.size());
      EXPECT_EQ(world.body_count(), scene.bodies.size());
      EXPECT_EQ(std::set<BodyId>(ids.begin(), ids.end()).size(), ids.size());
      for (std::size_t i = 0; i < ids.size(); ++i) {
        const SceneBody& body = scene.bodies[i];
        EXPECT_EQ(world.body_type(ids[i]), body.def.type);
        EXPECT_NEAR(world.pose(ids[i]).position.x, body.def.position.x, 1e-4f);
        EXPECT_NEAR(world.pose(ids[i]).position.y, body.def.position.y, 1e-4f);
        std::array<ShapeId, 8> shapes{};
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

}  // namespace
}  // namespace scree::scenes
