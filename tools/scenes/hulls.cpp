// Points of hulls: spheres, prisms and the simplest solids.
#include <tools/scenes/angles.h>
#include <tools/scenes/hulls.h>

#include <cmath>

namespace scree::scenes {

std::vector<Vec3> fibonacci_points(int count, float radius) {
  const double turn = 360.0 * 2.0 / (1.0 + std::sqrt(5.0));  // degrees
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count;
    const double across = std::sqrt(1.0 - z * z);
    const auto [sine, cosine] = sine_cosine(turn * i);
    const double r = double{radius};
    points.push_back({static_cast<float>(r * across * cosine), static_cast<float>(r * across * sine),
                      static_cast<float>(r * z)});
  }
  return points;
}

std::vector<Vec3> random_sphere_points(int count, float radius, std::uint32_t seed) {
  std::uint32_t state = seed;
  const auto draw = [&state] {
    state = state * 2147001325u + 715136305u;
    return static_cast<float>(state & 0xffffu) / 65535.0f - 0.5f;
  };
  std::vector<Vec3> points;
  while (static_cast<int>(points.size()) < count) {
    const float x = draw();
    const float y = draw();
    const float z = draw();
    const float square = x * x + y * y + z * z;
    if (square > 0.25f) continue;
    const float scale = radius / std::sqrt(square);
    points.push_back({x * scale, y * scale, z * scale});
  }
  return points;
}

std::vector<Vec3> prism_points(int sides, float radius, float height) {
  std::vector<Vec3> points;
  for (int i = 0; i < sides; ++i) {
    const auto [sine, cosine] = sine_cosine(360.0 * i / sides);
    const float x = static_cast<float>(double{radius} * cosine);
    const float z = static_cast<float>(double{radius} * sine);
    points.push_back({x, 0.0f, z});
    points.push_back({x, height, z});
  }
  return points;
}

std::vector<Vec3> tetrahedron_points(float radius) {
  const float r = radius / std::sqrt(3.0f);
  return {{r, r, r}, {r, -r, -r}, {-r, r, -r}, {-r, -r, r}};
}

std::vector<Vec3> octahedron_points(Vec3 half_extents) {
  const auto [x, y, z] = half_extents;
  return {{x, 0, 0}, {-x, 0, 0}, {0, y, 0}, {0, -y, 0}, {0, 0, z}, {0, 0, -z}};
}

std::vector<Vec3> box_points(Vec3 half_extents) {
  std::vector<Vec3> points;
  for (const float x : {-half_extents.x, half_extents.x}) {
    for (const float y : {-half_extents.y, half_extents.y}) {
      for (const float z : {-half_extents.z, half_extents.z}) points.push_back({x, y, z});
    }
  }
  return points;
}

std::vector<Vec3> scaled(std::vector<Vec3> points, Vec3 scale) {
  for (Vec3& point : points) point = {point.x * scale.x, point.y * scale.y, point.z * scale.z};
  return points;
}

std::vector<Vec3> moved(std::vector<Vec3> points, Vec3 offset) {
  for (Vec3& point : points) point = {point.x + offset.x, point.y + offset.y, point.z + offset.z};
  return points;
}

}  // namespace scree::scenes
