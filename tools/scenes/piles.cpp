// Scenes of loose bodies: the pile, spheres in a box, and many small worlds.
#include <tools/scenes/builders.h>
#include <tools/scenes/random.h>

#include <algorithm>
#include <cmath>

namespace scree::scenes {
namespace {

// Poured bodies: no dimension reaches further than 0.607 m from the center, so that neighbors in a grid of
// cells of 1.3 m, moved by 0.04 m at most, overlap in no orientation.
constexpr float kReach = 0.607f;  // m
constexpr float kCell = 1.3f;     // m
constexpr float kJitter = 0.04f;  // m
constexpr int kLayers = 24;  // in the column of bodies; they settle to about 2.5 m and arrive within 2.5 s

Geometry random_geometry(Random& random) {
  switch (random.below(3)) {
    case 0: {
      const float x = random.between(0.15f, 0.35f);
      const float y = random.between(0.15f, 0.35f);
      const float z = random.between(0.15f, 0.35f);
      return Box{{x, y, z}};
    }
    case 1:
      return Sphere{random.between(0.2f, 0.4f)};
    default: {
      const float half_height = random.between(0.15f, 0.35f);
      const float radius = random.between(0.12f, 0.25f);
      return Capsule{half_height, radius};
    }
  }
}

// The smallest square of cells that holds the count in that many layers.
int cells_per_side(int count, int layers) {
  int side = 1;
  while (static_cast<std::int64_t>(side) * side * layers < count) ++side;
  return side;
}

// The center of a cell of the column above the floor, jittered; cells go along x, then z, then up.
Vec3 jittered_cell(int index, int side, float cell, float jitter, Random& random) {
  const int layer = index / (side * side);
  const int row = index / side % side;
  const int column = index % side;
  const float corner = -0.5f * cell * static_cast<float>(side);
  const float x = corner + cell * (static_cast<float>(column) + 0.5f) + random.between(-jitter, jitter);
  const float y = cell * (static_cast<float>(layer) + 0.5f) + random.between(-jitter, jitter);
  const float z = corner + cell * (static_cast<float>(row) + 0.5f) + random.between(-jitter, jitter);
  return {x, y, z};
}

Scene poured(const char* name, int bodies, std::uint64_t seed) {
  static_assert(kCell - 2.0f * kJitter >= 2.0f * kReach);
  Scene scene = start_scene(name, 400);
  // At least 2 x 2, so that a pile of ten is a pile and not a tower.
  const int side = std::max(2, cells_per_side(bodies, kLayers));
  const int layers = (bodies + side * side - 1) / (side * side);
  scene.shapes.reserve(static_cast<std::size_t>(bodies) + 5);
  scene.bodies.reserve(static_cast<std::size_t>(bodies) + 1);
  // Walls as high as the column: nothing that bounces off the pile can leave.
  add_pit(scene, 0.5f * kCell * static_cast<float>(side), kCell * static_cast<float>(layers + 1));
  Random random(seed);
  for (int i = 0; i < bodies; ++i) {
    const Geometry geometry = random_geometry(random);
    BodyDef def;
    def.position = jittered_cell(i, side, kCell, kJitter, random);
    def.rotation = random.rotation();
    add_body(scene, def, add_shape(scene, geometry));
  }
  return scene;
}

std::uint64_t seed_of(const Parameters& parameters) {
  return static_cast<std::uint64_t>(parameters.at("seed"));
}

}  // namespace

Scene pile(const Parameters& parameters) {
  return poured("pile", whole(parameters, "bodies"), seed_of(parameters));
}

std::vector<Scene> many_worlds(const Parameters& parameters) {
  std::vector<Scene> worlds;
  const int count = whole(parameters, "worlds");
  worlds.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    worlds.push_back(poured("many_worlds", whole(parameters, "bodies"),
                            seed_of(parameters) + static_cast<std::uint64_t>(i)));
  }
  return worlds;
}

Scene spheres_in_box(const Parameters& parameters) {
  constexpr float kRadius = 0.25f;        // m
  constexpr float kSphereCell = 0.56f;    // m
  constexpr float kSphereJitter = 0.02f;  // m; cell - 2 jitter > 2 radius
  Scene scene = start_scene("spheres_in_box", 400);
  const int bodies = whole(parameters, "bodies");
  // A box twice as high as wide, of which the settled spheres fill three fifths.
  const int side = std::max(1, static_cast<int>(std::cbrt(static_cast<double>(bodies) / 2.0)));
  const int layers = (bodies + side * side - 1) / (side * side);
  add_pit(scene, 0.5f * kSphereCell * static_cast<float>(side), kSphereCell * static_cast<float>(layers + 1),
          true);
  const std::uint32_t sphere = add_shape(scene, Sphere{kRadius});
  Random random(seed_of(parameters));
  for (int i = 0; i < bodies; ++i) {
    BodyDef def;
    def.position = jittered_cell(i, side, kSphereCell, kSphereJitter, random);
    add_body(scene, def, sphere);
  }
  return scene;
}

}  // namespace scree::scenes
