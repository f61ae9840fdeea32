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

Scene terrain(const Parameters& parameters) {
  constexpr float kCell = 1.3f;  // m: mixed bodies fit in any orientation
  constexpr int kLayers = 4;
  const int count = whole(parameters, "bodies");
  int side = 1;
  while (std::int64_t{side} * side * kLayers < count) ++side;
  const float half_width = std::max(10.0f, 1.6f * kCell * static_cast<float>(side));
  Scene scene = start_scene("terrain", 600);
  add_hills(scene, whole(parameters, "triangles"), half_width);
  const std::uint32_t hulls = add_pile_hulls(scene);
  Random random(static_cast<std::uint64_t>(parameters.at("seed")));
  const float spacing = 1.2f * kCell, corner = -0.5f * spacing * static_cast<float>(side - 1);
  for (int i = 0; i < count; ++i) {
    const std::uint32_t shape = add_mixed_shape(scene, hulls, random);
    BodyDef def;
    def.position = {corner + spacing * static_cast<float>(i % side),
                    6.0f + 2.0f * kCell * static_cast<float>(i / (side * side)),
                    corner + spacing * static_cast<float>(i / side % side)};
    def.rotation = random.rotation();
    add_body(scene, def, shape);
  }
  return scene;
}

}  // namespace scree::scenes
