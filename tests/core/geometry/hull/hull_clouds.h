// Clouds of points and measures that the tests of hulls share.
#pragma once

#include <core/geometry/hull/hull_build.h>
#include <core/world/math.h>
#include <scree/hull.h>
#include <tests/core/world/world_fixture.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace scree::test {

using Cloud = std::vector<Vec3>;

inline Vec3 random_point(Random& random) {
  const float x = random.between(-1.0f, 1.0f), y = random.between(-1.0f, 1.0f);
  return {x, y, random.between(-1.0f, 1.0f)};
}
inline Vec3 random_unit(Random& random) {
  for (;;) {
    const Vec3 v = random_point(random);
    const float size = length(v);
    if (size > 0.1f && size < 1.0f) return v * (1.0f / size);
  }
}
inline Cloud cube_cloud(int count, std::uint64_t seed) {
  Random random(seed);
  Cloud cloud;
  for (int i = 0; i < count; ++i) cloud.push_back(random_point(random));
  return cloud;
}
inline Cloud sphere_cloud(int count, std::uint64_t seed) {
  Random random(seed);
  Cloud cloud;
  for (int i = 0; i < count; ++i) cloud.push_back(random_unit(random));
  return cloud;
}
// `count` points a side on and in a box.
inline Cloud lattice(int count, Vec3 size) {
  Cloud cloud;
  const float step = 1.0f / static_cast<float>(count - 1);
  for (int x = 0; x < count; ++x) {
    for (int y = 0; y < count; ++y) {
      for (int z = 0; z < count; ++z) {
        const Vec3 place{static_cast<float>(x) * step, static_cast<float>(y) * step,
                         static_cast<float>(z) * step};
        cloud.push_back({(place.x - 0.5f) * size.x, (place.y - 0.5f) * size.y, (place.z - 0.5f) * size.z});
      }
    }
  }
  return cloud;
}
inline Cloud prism(int sides, float radius, float half_height) {
  Cloud cloud;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2.0 * 3.14159265358979 * i / sides;
    const auto x = static_cast<float>(radius * std::cos(angle));
    const auto z = static_cast<float>(radius * std::sin(angle));
    cloud.push_back({x, -half_height, z});
    cloud.push_back({x, half_height, z});
  }
  return cloud;
}
inline Cloud turned(Cloud cloud, Quat rotation, Vec3 shift = {}) {
  for (Vec3& p : cloud) p = rotate(rotation, p) + shift;
  return cloud;
}
inline Cloud stretched(Cloud cloud, Vec3 scale) {
  for (Vec3& p : cloud) p = {p.x * scale.x, p.y * scale.y, p.z * scale.z};
  return cloud;
}

inline constexpr Quat kTurn{0.2f, 0.4f, 0.1f, 0.88881944f};  // of unit length

struct NamedCloud {
  const char* name;
  Cloud points;
};
// Point clouds for hulls: round, flat, needle-like, with and without points within faces.
inline std::vector<NamedCloud> all_clouds() {
  return {{"tetrahedron", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
          {"box", lattice(2, {1.0f, 0.4f, 0.7f})},
          {"box of many points", lattice(9, {1.0f, 2.0f, 3.0f})},
          {"turned box", turned(lattice(9, {1.0f, 2.0f, 3.0f}), kTurn, {10, 20, 30})},
          {"box far away", turned(lattice(3, {1.0f, 2.0f, 3.0f}), kTurn, {3000, -2000, 1000})},
          {"plate", turned(lattice(6, {10.0f, 0.01f, 10.0f}), kTurn)},
          {"needle", turned(lattice(6, {0.01f, 10.0f, 0.01f}), kTurn)},
          {"prism", prism(7, 1.0f, 0.5f)},
          {"cylinder", turned(prism(64, 1.0f, 2.0f), kTurn)},
          {"small cloud", cube_cloud(10, 1)},
          {"cube cloud", cube_cloud(3000, 2)},
          {"sphere of 32", sphere_cloud(32, 3)},
          {"sphere of 256", sphere_cloud(256, 4)},
          {"sphere of 2000", sphere_cloud(2000, 5)},
          {"flat ellipsoid", stretched(sphere_cloud(500, 6), {1.0f, 0.002f, 0.3f})},
          {"tiny", stretched(cube_cloud(50, 7), {1e-3f, 1e-3f, 1e-3f})},
          {"huge", stretched(cube_cloud(50, 8), {9e4f, 9e4f, 9e4f})}};
}

inline const HullSolid& solid_of(const Hull& hull) { return *HullAccess::solid(hull); }
inline double extent_of(const Cloud& cloud) {
  Vec3 low = cloud[0], high = cloud[0];
  for (const Vec3& p : cloud) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  return std::max({high.x - low.x, high.y - low.y, high.z - low.z});
}

}  // namespace scree::test
