// Scenes of many equal joints: a net.
#include <tools/scenes/builders.h>

#include <cstdint>

namespace scree::scenes {

// Bodies go down a column and then to the next one, each followed by the joints to the body above it and to
// its left: the order of the published scene.
Scene joint_grid(const Parameters& parameters) {
  constexpr float kRadius = 0.4f;      // m
  constexpr std::uint32_t kClass = 2;  // of spheres, which do not collide with each other
  const int columns = whole(parameters, "columns");
  const int rows = whole(parameters, "rows");
  Scene scene = start_scene("joint_grid", 100);
  scene.settings.sleeping = false;
  scene.settings.continuous = false;
  const std::uint32_t sphere =
      add_shape(scene, Sphere{kRadius}, {}, {.filter = {.category = kClass, .mask = ~kClass}});
  const JointDef below{.frame_a = {{0.0f, -0.5f, 0.0f}, {}}, .frame_b = {{0.0f, 0.5f, 0.0f}, {}}};
  const JointDef right{.frame_a = {{0.5f, 0.0f, 0.0f}, {}}, .frame_b = {{-0.5f, 0.0f, 0.0f}, {}}};
  for (int column = 0; column < columns; ++column) {
    for (int row = 0; row < rows; ++row) {
      BodyDef def;
      def.type = row == 0 ? BodyType::fixed : BodyType::dynamic;
      def.position = {static_cast<float>(column), static_cast<float>(-row), 0.0f};
      const std::uint32_t body = add_body(scene, def, sphere);
      if (row > 0) add_joint(scene, body - 1, body, BallJoint{}, below);
      if (column > 0) add_joint(scene, body - static_cast<std::uint32_t>(rows), body, BallJoint{}, right);
    }
  }
  return scene;
}

}  // namespace scree::scenes
