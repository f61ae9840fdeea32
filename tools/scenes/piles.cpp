// Scenes of loose bodies: the pile, the zoo of hulls, spheres in a box, and many small worlds.
#include <tools/scenes/builders.h>
#include <tools/scenes/hulls.h>
#include <tools/scenes/random.h>

#include <algorithm>
#include <cmath>

namespace scree::scenes {
namespace {

// Poured bodies: no dimension reaches further than 0.607 m from the center, so that neighbors in a grid of
// cells of 1.3 m, moved by 0.04 m at most, overlap in no orientation.
constexpr float kReach = 0.607f;   // m
constexpr float kPileCell = 1.3f;  // m
constexpr float kJitter = 0.04f;   // m
constexpr int kColumnLayers =
    24;  // in the column of bodies; they settle to about 2.5 m and arrive within 2.5 s

Geometry random_round_or_box(Random& random) {
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

// A pile's hulls, which its bodies share. Irregular: no two axes alike, most centroids off the origin.
const std::vector<ConvexHull>& pile_hulls() {
  static const std::vector<ConvexHull> kHulls = [] {
    std::vector<ConvexHull> hulls;
    hulls.push_back({Hull(tetrahedron_points(0.45f))});
    hulls.push_back({Hull(moved(octahedron_points({0.4f, 0.25f, 0.32f}), {0.05f, 0.0f, 0.02f}))});
    hulls.push_back({Hull(box_points({0.3f, 0.3f, 0.3f})), {1.0f, 0.6f, 0.8f}});
    hulls.push_back({Hull(prism_points(5, 0.3f, 0.4f)), {1.0f, 1.0f, 0.8f}});
    for (const int count : {12, 16, 24, 32}) {
      const auto seed = static_cast<std::uint32_t>(count);
      hulls.push_back({Hull(random_sphere_points(count, 0.4f, seed)), {1.0f, 0.75f, 0.85f}});
    }
    return hulls;
  }();
  return kHulls;
}

// From the tetrahedron to 256 corners, and what is thin in one direction or two.
std::vector<ConvexHull> zoo_hulls(int max_vertices) {
  std::vector<std::vector<Vec3>> clouds = {
      tetrahedron_points(0.5f),
      scaled(tetrahedron_points(0.6f), {1.0f, 1.0f, 0.05f}),                                   // sliver
      {{-0.5f, 0.0f, -0.3f}, {0.5f, 0.0f, -0.3f}, {0.0f, 0.03f, 0.4f}, {0.1f, -0.03f, 0.1f}},  // sliver
      octahedron_points({0.4f, 0.4f, 0.4f}),
      octahedron_points({0.03f, 0.6f, 0.03f}),  // needle
      prism_points(3, 0.35f, 0.4f),
      box_points({0.25f, 0.25f, 0.25f}),
      box_points({0.4f, 0.02f, 0.4f}),    // plate
      box_points({0.55f, 0.04f, 0.04f}),  // needle
      fibonacci_points(10, 0.4f),
      prism_points(12, 0.5f, 0.04f),  // plate
  };
  for (const int count : {16, 32, 64, 128, 256}) {
    clouds.push_back(scaled(fibonacci_points(count, 0.45f), {1.0f, 0.8f, 0.9f}));
  }
  std::vector<ConvexHull> hulls;
  for (const std::vector<Vec3>& points : clouds) {
    if (static_cast<int>(points.size()) <= max_vertices) hulls.push_back({Hull(points)});
  }
  return hulls;
}

// Adds a shape for each hull; returns the place of the first.
std::uint32_t add_hulls(Scene& scene, const std::vector<ConvexHull>& hulls) {
  const auto first = static_cast<std::uint32_t>(scene.shapes.size());
  for (const ConvexHull& hull : hulls) add_shape(scene, hull);
  return first;
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

// Bodies fall from a column of cells into a pit as wide; `next_shape` gives each of them its shape.
template <class NextShape>
void pour(Scene& scene, int bodies, Random& random, const NextShape& next_shape) {
  static_assert(kPileCell - 2.0f * kJitter >= 2.0f * kReach);
  // At least 2 x 2, so that a pile of ten is a pile and not a tower.
  const int side = std::max(2, cells_per_side(bodies, kColumnLayers));
  const int layers = (bodies + side * side - 1) / (side * side);
  scene.shapes.reserve(scene.shapes.size() + static_cast<std::size_t>(bodies) + 5);
  scene.bodies.reserve(static_cast<std::size_t>(bodies) + 1);
  // Walls as high as the column: nothing that bounces off the pile can leave.
  add_pit(scene, 0.5f * kPileCell * static_cast<float>(side), kPileCell * static_cast<float>(layers + 1));
  for (int i = 0; i < bodies; ++i) {
    const std::uint32_t shape = next_shape();
    BodyDef def;
    def.position = jittered_cell(i, side, kPileCell, kJitter, random);
    def.rotation = random.rotation();
    add_body(scene, def, shape);
  }
}

Scene mixed_pile(const char* name, int bodies, std::uint64_t seed) {
  Scene scene = start_scene(name, 400);
  const std::uint32_t first_hull = add_pile_hulls(scene);
  Random random(seed);
  pour(scene, bodies, random, [&] { return add_mixed_shape(scene, first_hull, random); });
  return scene;
}

std::uint64_t seed_of(const Parameters& parameters) {
  return static_cast<std::uint64_t>(parameters.at("seed"));
}

}  // namespace

std::uint32_t add_pile_hulls(Scene& scene) { return add_hulls(scene, pile_hulls()); }

std::uint32_t add_mixed_shape(Scene& scene, std::uint32_t first_hull, Random& random) {
  if (random.below(4) == 0) {
    return first_hull + random.below(static_cast<std::uint32_t>(pile_hulls().size()));
  }
  return add_shape(scene, random_round_or_box(random));
}

Scene pile(const Parameters& parameters) {
  return mixed_pile("pile", whole(parameters, "bodies"), seed_of(parameters));
}

Scene hull_zoo(const Parameters& parameters) {
  Scene scene = start_scene("hull_zoo", 400);
  const std::vector<ConvexHull> hulls = zoo_hulls(whole(parameters, "max_vertices"));
  const std::uint32_t first_hull = add_hulls(scene, hulls);
  Random random(seed_of(parameters));
  pour(scene, whole(parameters, "bodies"), random,
       [&] { return first_hull + random.below(static_cast<std::uint32_t>(hulls.size())); });
  return scene;
}

std::vector<Scene> many_worlds(const Parameters& parameters) {
  std::vector<Scene> worlds;
  const int count = whole(parameters, "worlds");
  worlds.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    worlds.push_back(mixed_pile("many_worlds", whole(parameters, "bodies"),
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
