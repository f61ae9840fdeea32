// Scenes of compound bodies: wheels of many hulls, and a drum that turns.
#include <tools/scenes/angles.h>
#include <tools/scenes/builders.h>
#include <tools/scenes/frames.h>
#include <tools/scenes/hulls.h>
#include <tools/scenes/random.h>

#include <algorithm>
#include <cmath>

namespace scree::scenes {
namespace {

constexpr Vec3 kAlongZ{0.0f, 0.0f, 1.0f};

// The corners of a block between two radii, two angles (degrees) and -half_width and half_width along z.
std::vector<Vec3> rim_points(double inner, double outer, double from, double to, float half_width) {
  std::vector<Vec3> points;
  for (const double degrees : {from, to}) {
    const auto [sine, cosine] = sine_cosine(degrees);
    for (const double radius : {inner, outer}) {
      for (const float z : {-half_width, half_width}) {
        points.push_back({static_cast<float>(radius * cosine), static_cast<float>(radius * sine), z});
      }
    }
  }
  return points;
}

// A wheel of 1 m radius that turns about z: 24 blocks of the rim, 12 spokes and a hub.
std::uint32_t add_wheel(Scene& scene) {
  constexpr int kRim = 24, kSpokes = 12;
  constexpr double kRimStep = 360.0 / kRim, kSpokeStep = 360.0 / kSpokes;
  const auto first = static_cast<std::uint32_t>(scene.shapes.size());
  for (int k = 0; k < kRim; ++k) {
    add_shape(scene,
              ConvexHull{.hull = Hull(rim_points(0.82, 1.0, kRimStep * k, kRimStep * (k + 1), 0.15f))});
  }
  for (int k = 0; k < kSpokes; ++k) {
    const auto [sine, cosine] = sine_cosine(kSpokeStep * k);
    const Vec3 middle{static_cast<float>(0.5 * cosine), static_cast<float>(0.5 * sine), 0.0f};
    const Pose place{middle, rotation_about(kAlongZ, kSpokeStep * k)};
    add_shape(scene, ConvexHull{.hull = Hull(box_points({0.34f, 0.04f, 0.06f}))}, {}, {.local_pose = place});
  }
  std::vector<Vec3> hub;
  for (int k = 0; k < kSpokes; ++k) {
    const auto [sine, cosine] = sine_cosine(kSpokeStep * k);
    for (const float z : {-0.2f, 0.2f})
      hub.push_back({static_cast<float>(0.2 * cosine), static_cast<float>(0.2 * sine), z});
  }
  add_shape(scene, ConvexHull{.hull = Hull(hub)});
  return first;
}
constexpr std::uint32_t kWheelParts = 37;

}  // namespace

Scene wheel_pile(const Parameters& parameters) {
  constexpr float kCell = 2.1f;  // m: a wheel fits in any orientation
  constexpr int kLayers = 12;
  const int count = whole(parameters, "wheels");
  int side = 2;
  while (std::int64_t{side} * side * kLayers < count) ++side;
  const int layers = (count + side * side - 1) / (side * side);
  Scene scene = start_scene("wheel_pile", 900);
  add_pit(scene, 0.5f * kCell * static_cast<float>(side), kCell * static_cast<float>(layers + 1));
  const std::uint32_t wheel = add_wheel(scene);
  Random random(static_cast<std::uint64_t>(parameters.at("seed")));
  const float corner = -0.5f * kCell * static_cast<float>(side);
  const auto place = [&](int cell) { return kCell * (static_cast<float>(cell) + 0.5f); };
  for (int i = 0; i < count; ++i) {
    BodyDef def;
    def.position = {corner + place(i % side), place(i / (side * side)), corner + place(i / side % side)};
    def.rotation = random.rotation();
    add_body(scene, def, wheel, kWheelParts);
  }
  return scene;
}

Scene drum(const Parameters& parameters) {
  constexpr float kBox = 0.125f;   // m, half
  constexpr float kPitch = 0.28f;  // m, from box to box
  constexpr int kStaves = 32, kPaddles = 4;
  constexpr float kThick = 0.2f;  // m, half, of staves and lids
  const int count = whole(parameters, "bodies");
  // A drum as long as its radius, which the boxes fill to about a third of its volume.
  const double radius =
      std::max(1.0, std::cbrt(double{kPitch} * kPitch * kPitch * count / (0.34 * 3.1415927)));
  const auto half_length = static_cast<float>(0.5 * radius), r = static_cast<float>(radius);
  Scene scene = start_scene("drum", 400);
  constexpr double kStep = 360.0 / kStaves;
  const auto [half_sine, half_cosine] = sine_cosine(0.5 * kStep);
  const auto first = static_cast<std::uint32_t>(scene.shapes.size());
  const auto add_around = [&](Vec3 half_extents, double distance, double degrees) {
    const auto [sine, cosine] = sine_cosine(degrees);
    const Vec3 at{static_cast<float>(distance * cosine), static_cast<float>(distance * sine), 0.0f};
    add_shape(scene, Box{half_extents}, {}, {.local_pose = {at, rotation_about(kAlongZ, degrees)}});
  };
  for (int k = 0; k < kStaves; ++k) {
    const auto half_width = static_cast<float>((radius + 2.0 * double{kThick}) * half_sine / half_cosine);
    add_around({kThick, half_width, half_length}, radius + double{kThick}, kStep * k);
  }
  for (int k = 0; k < kPaddles; ++k)
    add_around({0.1f * r, 0.05f, half_length}, 0.9 * radius, 360.0 / kPaddles * k);
  for (const float end : {-1.0f, 1.0f}) {
    add_shape(scene, Box{{1.2f * r, 1.2f * r, kThick}}, {},
              {.local_pose = {{0.0f, 0.0f, end * (half_length + kThick)}, {}}});
  }
  const auto parts = static_cast<std::uint32_t>(scene.shapes.size()) - first;
  const std::uint32_t body = add_body(scene, {.type = BodyType::kinematic}, first, parts);
  scene.drives.push_back(
      {.body = body, .start = {}, .center = {}, .axis = kAlongZ, .degrees_per_second = 12.0});
  const std::uint32_t box = add_shape(scene, Box{{kBox, kBox, kBox}});
  const int along = std::max(1, static_cast<int>((2.0f * half_length) / kPitch));
  const float least = -0.5f * kPitch * static_cast<float>(along - 1);
  // Layers of the lower half and as much of the upper one as it takes, each as wide as the drum is there.
  int left = count;
  for (float y = -0.93f * r; left > 0 && y < 0.95f * r; y += kPitch) {
    const float higher = std::max(std::abs(y - kBox), std::abs(y + kBox)) + 0.02f;
    if (higher >= 0.93f * r) continue;
    const float half_chord =
        std::sqrt(0.78f * 0.78f * r * r - std::min(higher * higher, 0.7f * 0.78f * r * r));
    const int across = std::max(1, static_cast<int>(2.0f * half_chord / kPitch));
    for (int x = 0; x < across; ++x) {
      for (int z = 0; z < along && left > 0; ++z, --left) {
        BodyDef def;
        def.position = {kPitch * (static_cast<float>(x) - 0.5f * static_cast<float>(across - 1)), y,
                        least + kPitch * static_cast<float>(z)};
        add_body(scene, def, box);
      }
    }
  }
  return scene;
}

}  // namespace scree::scenes
