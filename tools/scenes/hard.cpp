// Scenes that solvers find hard: heavy weights on light boxes, an arch, and a little of everything.
#include <tools/scenes/angles.h>
#include <tools/scenes/builders.h>
#include <tools/scenes/frames.h>

#include <cstdint>
#include <vector>

namespace scree::scenes {
namespace {

constexpr Vec3 kCube{0.5f, 0.5f, 0.5f};  // m, half-extents
constexpr float kDensity = 1000.0f;      // kg/m^3

void add_heavy_stack(Scene& scene, Vec3 at, int boxes, float ratio) {
  const std::uint32_t light = add_shape(scene, Box{kCube}, {.density = kDensity});
  const std::uint32_t heavy = add_shape(scene, Box{kCube}, {.density = ratio * kDensity});
  for (int i = 0; i < boxes; ++i) {
    BodyDef def;
    def.position = {at.x, at.y + 0.5f + static_cast<float>(i), at.z};
    add_body(scene, def, i + 1 < boxes ? light : heavy);
  }
}

// A half circle of equal stones, its inner and outer radius `thickness` apart, its ends on the ground.
void add_arch(Scene& scene, Vec3 at, int stones, float radius, float thickness, float depth) {
  const double sector = 180.0 / stones;
  std::vector<Vec3> corners;
  for (const double side : {-0.5, 0.5}) {
    const SineCosine edge = sine_cosine(90.0 + side * sector);
    for (const float r : {radius - 0.5f * thickness, radius + 0.5f * thickness}) {
      for (const float z : {-0.5f * depth, 0.5f * depth}) {
        corners.push_back(
            {static_cast<float>(r * edge.cosine), static_cast<float>(r * edge.sine) - radius, z});
      }
    }
  }
  const std::uint32_t stone = add_shape(scene, ConvexHull{.hull = Hull(corners)}, {.friction = 0.8f});
  for (int i = 0; i < stones; ++i) {
    const double degrees = sector * (i + 0.5);
    const SineCosine middle = sine_cosine(degrees);
    BodyDef def;
    def.position = {at.x + static_cast<float>(radius * middle.cosine),
                    at.y + static_cast<float>(radius * middle.sine), at.z};
    def.rotation = rotation_about({0.0f, 0.0f, 1.0f}, degrees - 90.0);
    add_body(scene, def, stone);
  }
}

// Links of 0.4 m, each a hinge across the chain, let go level, with a weight at the end.
void add_hinged_chain(Scene& scene, Vec3 from, int links, float weight) {
  constexpr float kPitch = 0.4f;
  const std::uint32_t link = add_shape(scene, Box{{0.2f, 0.05f, 0.1f}});
  const std::uint32_t ball = add_shape(scene, Sphere{0.2f}, {.density = weight * kDensity});
  std::uint32_t last = kWorldItself;
  for (int i = 0; i <= links; ++i) {
    BodyDef def;
    def.position = from + Vec3{kPitch * (static_cast<float>(i) + 0.5f), 0.0f, 0.0f};
    const std::uint32_t body = add_body(scene, def, i < links ? link : ball);
    const Pose edge{from + Vec3{kPitch * static_cast<float>(i), 0.0f, 0.0f},
                    rotation_about({0, 1, 0}, -90.0)};
    add_joint_at(scene, last, body, edge, HingeJoint{});
    last = body;
  }
}

}  // namespace

Scene heavy_stack(const Parameters& parameters) {
  Scene scene = start_scene("heavy_stack", 600);
  scene.settings.sleeping = false;
  add_ground(scene, 50.0f);
  add_heavy_stack(scene, {}, whole(parameters, "bodies"), real(parameters, "ratio"));
  return scene;
}

Scene arch(const Parameters& parameters) {
  constexpr float kRadius = 5.0f;  // m, of the middle of the stones
  Scene scene = start_scene("arch", 600);
  scene.settings.sleeping = false;
  add_ground(scene, 50.0f, {.friction = 0.8f});
  add_arch(scene, {}, whole(parameters, "stones"), kRadius, kRadius * real(parameters, "thickness"), 1.0f);
  return scene;
}

Scene solver_sampler(const Parameters& parameters) {
  Scene scene = start_scene("solver_sampler", 200);
  scene.settings.sleeping = false;
  scene.settings.solver = static_cast<Solver>(whole(parameters, "solver"));
  scene.settings.solver_options.iterations = 20;
  add_ground(scene, 50.0f);
  add_heavy_stack(scene, {-3.0f, 0.0f, 0.0f}, 3, 20.0f);
  add_arch(scene, {3.0f, 0.0f, 0.0f}, 5, 1.5f, 0.5f, 0.6f);
  add_hinged_chain(scene, {-1.0f, 4.0f, 3.0f}, 5, 10.0f);
  const std::uint32_t ball =
      add_shape(scene, Sphere{0.25f}, {.restitution = 0.6f, .rolling_resistance = 0.01f});
  for (int i = 0; i < 4; ++i) {
    BodyDef def;
    def.position = {0.15f * static_cast<float>(i), 1.0f + 0.6f * static_cast<float>(i), -2.0f};
    def.linear_velocity = {1.0f, 0.0f, 0.0f};
    add_body(scene, def, ball);
  }
  return scene;
}

}  // namespace scree::scenes
