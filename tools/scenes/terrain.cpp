// Scenes on triangle meshes: bodies, ragdolls and balls on hills.
#include <tools/scenes/angles.h>
#include <tools/scenes/builders.h>
#include <tools/scenes/random.h>

#include <algorithm>
#include <cmath>

namespace scree::scenes {
namespace {

double sine(double degrees) { return sine_cosine(degrees).sine; }

// Hills of 2 m about 25 m apart, bumps of 10 cm about 3 m apart, in a bowl whose rim keeps all in.
double height_at(double x, double z, double half_width) {
  const double far = std::max(std::abs(x), std::abs(z)) / half_width;
  const double rim = far > 0.8 ? (far - 0.8) * (far - 0.8) * 25.0 * 0.6 * half_width : 0.0;
  return 1.2 * sine(14.4 * x + 20.0) * sine(13.1 * z + 50.0) + 0.6 * sine(9.7 * (x + z)) +
         0.05 * sine(120.0 * x) * sine(111.0 * z) + rim;
}

}  // namespace

TriangleMesh hills(int triangles, float half_width) {
  const int cells = std::max(1, static_cast<int>(std::sqrt(0.5 * triangles)));
  const auto side = static_cast<std::uint32_t>(cells) + 1;
  std::vector<Vec3> vertices;
  vertices.reserve(static_cast<std::size_t>(side) * side);
  for (std::uint32_t row = 0; row < side; ++row) {
    for (std::uint32_t column = 0; column < side; ++column) {
      const double x = half_width * (2.0 * column / cells - 1.0), z = half_width * (2.0 * row / cells - 1.0);
      vertices.push_back(
          {static_cast<float>(x), static_cast<float>(height_at(x, z, half_width)), static_cast<float>(z)});
    }
  }
  std::vector<MeshTriangle> faces;
  faces.reserve(2 * static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
  for (std::uint32_t row = 0; row + 1 < side; ++row) {
    for (std::uint32_t column = 0; column + 1 < side; ++column) {
      const std::uint32_t a = row * side + column, b = a + 1, c = a + side, d = c + 1;
      if ((row + column) % 2 == 0) {
        faces.push_back({a, c, b});
        faces.push_back({b, c, d});
      } else {
        faces.push_back({a, c, d});
        faces.push_back({a, d, b});
      }
    }
  }
  return TriangleMesh(vertices, faces);
}

void add_hills(Scene& scene, int triangles, float half_width) {
  const std::uint32_t shape = add_shape(scene, hills(triangles, half_width));
  add_body(scene, {.type = BodyType::fixed}, shape);
}

namespace {

// Mixed bodies in four layers over a square.
struct Rain {
  static constexpr float kSpacing = 1.2f * 1.3f;  // m: they fit in any orientation
  static constexpr int kLayers = 4;
  int count, side;
  float half_width;  // m, of the ground
};

Rain rain_of(const Parameters& parameters) {
  const int count = whole(parameters, "bodies");
  int side = 1;
  while (std::int64_t{side} * side * Rain::kLayers < count) ++side;
  return {count, side, std::max(10.0f, 1.6f * 1.3f * static_cast<float>(side))};
}

void add_rain(Scene& scene, const Rain& rain, double seed) {
  const std::uint32_t hulls = add_pile_hulls(scene);
  Random random(static_cast<std::uint64_t>(seed));
  const float corner = -0.5f * Rain::kSpacing * static_cast<float>(rain.side - 1);
  for (int i = 0; i < rain.count; ++i) {
    const std::uint32_t shape = add_mixed_shape(scene, hulls, random);
    BodyDef def;
    def.position = {corner + Rain::kSpacing * static_cast<float>(i % rain.side),
                    6.0f + 2.6f * static_cast<float>(i / (rain.side * rain.side)),
                    corner + Rain::kSpacing * static_cast<float>(i / rain.side % rain.side)};
    def.rotation = random.rotation();
    add_body(scene, def, shape);
  }
}

// A floor 6 m below, with walls up to y = 0.
void add_cellar(Scene& scene, float half_width) {
  const std::uint32_t floor = add_shape(scene, Box{{half_width, 1.0f, half_width}});
  add_body(scene, {.type = BodyType::fixed, .position = {0, -7, 0}}, floor);
  const std::uint32_t along_x = add_shape(scene, Box{{half_width, 3.0f, 1.0f}});
  const std::uint32_t along_z = add_shape(scene, Box{{1.0f, 3.0f, half_width}});
  for (const float side : {-half_width, half_width}) {
    add_body(scene, {.type = BodyType::fixed, .position = {0, -3, side}}, along_x);
    add_body(scene, {.type = BodyType::fixed, .position = {side, -3, 0}}, along_z);
  }
}

}  // namespace

Scene terrain(const Parameters& parameters) {
  const Rain rain = rain_of(parameters);
  Scene scene = start_scene("terrain", 600);
  add_hills(scene, whole(parameters, "triangles"), rain.half_width);
  add_rain(scene, rain, parameters.at("seed"));
  return scene;
}

Scene height_field(const Parameters& parameters) {
  constexpr std::size_t kHoleEvery = 24, kHoleCells = 4;  // cells from hole to hole, and along one
  constexpr double kWithHoles = 0.7;                      // of the half width: none in the rim
  const Rain rain = rain_of(parameters);
  Scene scene = start_scene("height_field", 600);
  const auto cells = static_cast<std::size_t>(std::max(1.0, std::sqrt(parameters.at("cells"))));
  const std::size_t lines = cells + 1;
  const float spacing = 2.0f * rain.half_width / static_cast<float>(cells);
  std::vector<float> heights;
  std::vector<std::uint8_t> holes;
  for (std::size_t row = 0; row < lines; ++row) {
    for (std::size_t column = 0; column < lines; ++column) {
      const double x = rain.half_width *
                       (2.0 * static_cast<double>(column) / static_cast<double>(cells) - 1.0),
                   z = rain.half_width * (2.0 * static_cast<double>(row) / static_cast<double>(cells) - 1.0);
      heights.push_back(static_cast<float>(height_at(x, z, rain.half_width)));
      if (row == cells || column == cells) continue;
      const bool is_inside = std::max(std::abs(x), std::abs(z)) < kWithHoles * rain.half_width;
      const bool is_hole = std::min(row % kHoleEvery, column % kHoleEvery) >= kHoleEvery - kHoleCells;
      holes.push_back(is_inside && is_hole ? 1 : 0);
    }
  }
  const HeightField field{.columns = lines,
                          .rows = lines,
                          .heights = heights,
                          .spacing_x = spacing,
                          .spacing_z = spacing,
                          .holes = holes};
  add_body(scene, {.type = BodyType::fixed, .position = {-rain.half_width, 0, -rain.half_width}},
           add_shape(scene, height_field_mesh(field)));
  add_cellar(scene, rain.half_width);
  add_rain(scene, rain, parameters.at("seed"));
  return scene;
}

}  // namespace scree::scenes
