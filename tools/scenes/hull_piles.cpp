// Scenes of hulls: the two published ones. piles.cpp has the hulls that are poured.
#include <tools/scenes/builders.h>
#include <tools/scenes/hulls.h>

#include <vector>

namespace scree::scenes {

Scene convex_pile(const Parameters& parameters) {
  constexpr float kRadius = 2.0f;  // m, of the sphere that the hull's points lie on
  constexpr int kPoints = 32;
  constexpr std::uint32_t kSeed = 42;
  constexpr float kPitch = 4.0f;  // m, between the centers of neighbors
  const int columns = whole(parameters, "columns");
  const int layers = whole(parameters, "layers");
  Scene scene = start_scene("convex_pile", 500);
  add_ground(scene, 250.0f);
  const std::vector<Vec3> points = random_sphere_points(kPoints, kRadius, kSeed);
  const std::uint32_t shape = add_shape(scene, ConvexHull{.hull = Hull(points)});
  const float middle = 0.5f * static_cast<float>(columns);
  for (int layer = 0; layer < layers; ++layer) {
    for (int z = 0; z < columns; ++z) {
      for (int x = 0; x < columns; ++x) {
        BodyDef def;
        def.position = {kPitch * (static_cast<float>(x) - middle),
                        kRadius + kPitch * static_cast<float>(layer),
                        kPitch * (static_cast<float>(z) - middle)};
        add_body(scene, def, shape);
      }
    }
  }
  return scene;
}

Scene junkyard(const Parameters& parameters) {
  constexpr float kPitch = 4.0f;       // m, between the centers of neighbors
  constexpr float kLowest = 25.0f;     // m, height of the lowest layer
  constexpr float kRockRadius = 1.5f;  // m
  constexpr int kRockPoints = 10;
  constexpr float kOrbit = 35.0f;  // m, radius of the pusher's way
  const int columns = whole(parameters, "columns");
  const int layers = whole(parameters, "layers");
  Scene scene = start_scene("junkyard", 500);

  // Ground and walls are one body.
  const std::uint32_t first = add_shape(scene, Box{{120.0f, 1.0f, 120.0f}});
  for (const float side : {-50.0f, 50.0f}) {
    add_shape(scene, Box{{1.0f, 8.0f, 50.0f}}, {}, {.local_pose = {{side, 8.0f, 0.0f}, {}}});
  }
  for (const float side : {-50.0f, 50.0f}) {
    add_shape(scene, Box{{50.0f, 8.0f, 1.0f}}, {}, {.local_pose = {{0.0f, 8.0f, side}, {}}});
  }
  add_body(scene, {.type = BodyType::fixed, .position = {0.0f, -1.0f, 0.0f}}, first, 5);

  const std::vector<Vec3> rock_points = fibonacci_points(kRockPoints, kRockRadius);
  const std::uint32_t rock = add_shape(scene, ConvexHull{.hull = Hull(rock_points)});
  const float edge = -0.5f * kPitch * static_cast<float>(columns - 1);
  for (int y = 0; y < layers; ++y) {
    for (int x = 0; x < columns; ++x) {
      for (int z = 0; z < columns; ++z) {
        BodyDef def;
        def.position = {edge + kPitch * static_cast<float>(x), kLowest + kPitch * static_cast<float>(y),
                        edge + kPitch * static_cast<float>(z)};
        add_body(scene, def, rock);
      }
    }
  }

  const std::uint32_t pusher = add_shape(scene, ConvexHull{.hull = Hull(prism_points(16, 4.0f, 24.0f))});
  const BodyDef def{.type = BodyType::kinematic, .position = {kOrbit, 0.0f, 0.0f}};
  add_body(scene, def, pusher);
  // -6 degrees/s from x to z are +6 about y.
  scene.drives.push_back({.body = static_cast<std::uint32_t>(scene.bodies.size() - 1),
                          .start = {def.position, def.rotation},
                          .center = {},
                          .degrees_per_second = 6.0,
                          .turns_body = false});
  return scene;
}

}  // namespace scree::scenes
