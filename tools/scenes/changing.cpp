// Scenes in which bodies arrive and leave while many others rest: a large world, a streamed world, a fountain
// of bodies.
#include <tools/scenes/builders.h>
#include <tools/scenes/random.h>

#include <cmath>

namespace scree::scenes {
namespace {

constexpr float kPlainCell = 1.0f;                              // m, of plains of boxes
constexpr float kUneven = 0.05f;                                // m, by which their tops differ
constexpr float kBallRadius = 0.4f;                             // m
constexpr Material kBallMaterial{.rolling_resistance = 0.02f};  // so that they come to rest

// A box of a plain, whose top is about y = 0.
void add_tile(Scene& scene, std::uint32_t shape, float x, float z, Random& random, bool later) {
  const float top = random.between(-kUneven, kUneven);
  add_body(scene, {.type = BodyType::fixed, .position = {x, top - 0.5f * kPlainCell, z}}, shape);
  scene.bodies.back().comes_later = later;
}

std::uint32_t count_of(const Scene& scene) { return static_cast<std::uint32_t>(scene.bodies.size()); }

}  // namespace

Scene large_world(const Parameters& parameters) {
  Scene scene = start_scene("large_world", 600);
  const int boxes = whole(parameters, "bodies"), interval = whole(parameters, "interval");
  const auto side = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(boxes))));
  Random random(static_cast<std::uint64_t>(parameters.at("seed")));
  const std::uint32_t tile = add_shape(scene, Box{{0.5f * kPlainCell, 0.5f * kPlainCell, 0.5f * kPlainCell}});
  const std::uint32_t ball = add_shape(scene, Sphere{kBallRadius}, kBallMaterial);
  scene.bodies.reserve(static_cast<std::size_t>(boxes + scene.steps / interval));
  const auto along = [&](int i) {
    return kPlainCell * (static_cast<float>(i) - 0.5f * static_cast<float>(side));
  };
  for (int i = 0; i < boxes; ++i) add_tile(scene, tile, along(i % side), along(i / side), random, false);
  // Not near the rim, so that they stay.
  const float reach = 0.4f * kPlainCell * static_cast<float>(side - 1);
  for (int step = 0; step < scene.steps; step += interval) {
    const float x = random.between(-reach, reach), z = random.between(-reach, reach);
    scene.changes.push_back({step, count_of(scene), 1, true});
    add_body(scene, {.position = {x, 2.0f, z}}, ball);
    scene.bodies.back().comes_later = true;
  }
  return scene;
}

// The camera goes along x, a block a second, in the middle of the blocks that are there.
Scene streaming(const Parameters& parameters) {
  constexpr int kStepsPerSecond = 60, kColumns = 10;  // boxes of a block along x
  constexpr int kStepsPerBall = 10;
  Scene scene = start_scene("streaming", 600);
  const int blocks = whole(parameters, "blocks"), boxes = whole(parameters, "bodies");
  const int seconds = scene.steps / kStepsPerSecond;
  Random random(static_cast<std::uint64_t>(parameters.at("seed")));
  const std::uint32_t tile = add_shape(scene, Box{{0.5f * kPlainCell, 0.5f * kPlainCell, 0.5f * kPlainCell}});
  const std::uint32_t ball = add_shape(scene, Sphere{kBallRadius}, kBallMaterial);
  const int rows = (boxes + kColumns - 1) / kColumns;
  const float half_width = 0.5f * kPlainCell * static_cast<float>(rows);
  for (int block = 0; block < blocks + seconds; ++block) {
    for (int i = 0; i < boxes; ++i) {
      const float x = kPlainCell * static_cast<float>(block * kColumns + i % kColumns);
      const float z = kPlainCell * static_cast<float>(i / kColumns) - half_width;
      add_tile(scene, tile, x, z, random, block >= blocks);
    }
  }
  const auto first_of = [&](int block) { return static_cast<std::uint32_t>(block * boxes); };
  const auto size = static_cast<std::uint32_t>(boxes);
  for (int step = 0; step < scene.steps; ++step) {
    const int second = step / kStepsPerSecond;
    if (step % kStepsPerSecond == kStepsPerSecond - 1) {
      scene.changes.push_back({step, first_of(second), size, false});
      scene.changes.push_back({step, first_of(blocks + second), size, true});
    }
    if (step % kStepsPerBall != 0) continue;
    const float camera = kPlainCell * kColumns *
                         (static_cast<float>(step) / kStepsPerSecond + 0.5f * static_cast<float>(blocks));
    scene.changes.push_back({step, count_of(scene), 1, true});
    const float x = camera + random.between(-5.0f, 5.0f), z = random.between(-0.4f, 0.4f) * half_width;
    add_body(scene, {.position = {x, 2.0f, z}}, ball);
    scene.bodies.back().comes_later = true;
  }
  return scene;
}

Scene spawning(const Parameters& parameters) {
  constexpr float kSpacing = 1.0f;  // m, between bodies that arrive together
  constexpr float kHeight = 4.0f;   // m
  Scene scene = start_scene("spawning", 400);
  const int bodies = whole(parameters, "bodies"), life = whole(parameters, "life");
  Random random(static_cast<std::uint64_t>(parameters.at("seed")));
  // Ten generations lie beside each other: a new generation reuses the place of the oldest, which has fallen
  // by then.
  constexpr int kPlaces = 25;
  const auto side = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(bodies * kPlaces))));
  add_pit(scene, 0.5f * kSpacing * static_cast<float>(side + 2), 2.0f * kHeight);
  const std::uint32_t shapes[] = {add_shape(scene, Sphere{0.2f}), add_shape(scene, Box{{0.2f, 0.15f, 0.25f}}),
                                  add_shape(scene, Capsule{0.15f, 0.15f})};
  for (int step = 0; step < scene.steps; ++step) {
    if (step >= life) {
      const auto oldest = static_cast<std::uint32_t>(1 + (step - life) * bodies);
      scene.changes.push_back({step, oldest, static_cast<std::uint32_t>(bodies), false});
    }
    scene.changes.push_back({step, count_of(scene), static_cast<std::uint32_t>(bodies), true});
    for (int i = 0; i < bodies; ++i) {
      const int place = i * kPlaces + step % kPlaces;
      const auto along = [&](int cell) {
        return kSpacing * (static_cast<float>(cell) - 0.5f * static_cast<float>(side - 1));
      };
      const Vec3 position{along(place % side), kHeight, along(place / side)};
      // Drawn one after the other: compilers take arguments in an order of their own.
      const Quat rotation = random.rotation();
      const std::uint32_t shape = shapes[random.below(3)];
      add_body(scene, {.position = position, .rotation = rotation}, shape);
      scene.bodies.back().comes_later = true;
    }
  }
  return scene;
}

}  // namespace scree::scenes
