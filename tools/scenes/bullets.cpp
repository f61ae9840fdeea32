// Bullets on a wall of bricks, on a thin plate, and on each other.
#include <tools/scenes/builders.h>
#include <tools/scenes/random.h>

#include <algorithm>

namespace scree::scenes {
namespace {

constexpr float kBulletRadius = 0.005f;   // m
constexpr float kLeadDensity = 11340.0f;  // kg/m^3, of lead
constexpr float kPlateHalf = 3.0f;        // m, half the side of the plate
constexpr float kPlateThin = 0.005f;      // m, half of its thickness
constexpr float kBeside = 4.0f;           // m, from the wall to the middle of the plate, and of the crossfire
constexpr float kSeconds = 4.0f;          // in which all arrive
constexpr float kWallHalf = 0.25f;        // m, half of it

}  // namespace

Scene bullets(const Parameters& parameters) {
  const int count = whole(parameters, "bullets");
  const float speed = real(parameters, "speed");
  Scene scene = wall({{"columns", parameters.at("columns")}, {"rows", parameters.at("rows")}});
  scene.name = "bullets";
  scene.steps = 360;
  scene.settings.max_linear_speed = std::max(scene.settings.max_linear_speed, 2.0f * speed);
  const float half_width = 0.5f * static_cast<float>(whole(parameters, "columns"));
  const float height = 0.5f * static_cast<float>(whole(parameters, "rows"));
  const float aside = half_width + kBeside;
  const std::uint32_t plate = add_shape(scene, Box{{kPlateHalf, kPlateHalf, kPlateThin}});
  add_body(scene, {.type = BodyType::fixed, .position = {aside, kPlateHalf, 0}}, plate);
  const std::uint32_t bullet = add_shape(scene, Sphere{kBulletRadius},
                                         {.friction = 0.3f, .restitution = 0.2f, .density = kLeadDensity});
  Random random(static_cast<std::uint64_t>(parameters.at("seed")));
  Vec3 target;
  // In turn one on the wall, one on the plate, and two on each other. None falls on its way.
  for (int i = 0; i < count; ++i) {
    const int turn = i % 4;
    if (turn == 0)
      target = {random.between(-half_width, half_width), random.between(0.1f, height), -kWallHalf};
    if (turn == 1)
      target = {aside + random.between(-0.9f, 0.9f) * kPlateHalf, random.between(0.1f, 5.9f), -kPlateThin};
    if (turn == 2) target = {-aside + random.between(-0.5f, 0.5f), random.between(0.5f, 5.5f), 0};
    const float seconds =
        kSeconds * static_cast<float>(i - (turn == 3 ? 1 : 0) + 1) / static_cast<float>(count);
    const float way = turn == 3 ? 1.0f : -1.0f;  // from where it comes
    BodyDef def{.position = {target.x, target.y, target.z + way * (kBulletRadius + seconds * speed)},
                .linear_velocity = {0, 0, -way * speed},
                .gravity_factor = 0};
    add_body(scene, def, bullet);
  }
  return scene;
}

}  // namespace scree::scenes
