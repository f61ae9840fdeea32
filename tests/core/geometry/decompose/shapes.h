// Shapes whose parts are known, for tests of the decomposition.
#pragma once

#include <scree/math.h>
#include <tests/core/geometry/mesh/meshes.h>

#include <array>
#include <cstdint>
#include <vector>

namespace scree::test_solids {

using Outline = std::vector<std::array<float, 2>>;

// A polygon, counterclockwise in x and y, from z = 0 to the height. `fans` triangulate it: corners of each
// triangle, counterclockwise.
inline TestMesh prism_mesh(const Outline& outline, const std::vector<MeshTriangle>& fans, float height) {
  TestMesh mesh;
  const auto count = static_cast<std::uint32_t>(outline.size());
  for (const float z : {0.0f, height}) {
    for (const auto& [x, y] : outline) mesh.vertices.push_back({x, y, z});
  }
  for (const MeshTriangle& t : fans) {
    mesh.triangles.push_back({t.a, t.c, t.b});
    mesh.triangles.push_back({t.a + count, t.b + count, t.c + count});
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t next = (i + 1) % count;
    mesh.triangles.push_back({i, next, next + count});
    mesh.triangles.push_back({i, next + count, i + count});
  }
  return mesh;
}

// Two boxes: 3 by 1 and, on its left end, 1 by 3.
inline TestMesh l_mesh() {
  return prism_mesh({{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 4}, {0, 4}},
                    {{0, 1, 3}, {1, 2, 3}, {0, 3, 5}, {3, 4, 5}}, 1.3f);
}
inline constexpr double kVolumeOfL = 6 * 1.3;

// A box of 4 by 1 with legs of 1 by 2.
inline TestMesh u_mesh() {
  return prism_mesh({{0, 0}, {4, 0}, {4, 3}, {3, 3}, {3, 1}, {1, 1}, {1, 3}, {0, 3}},
                    {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {0, 4, 5}, {0, 5, 7}, {5, 6, 7}}, 1.3f);
}
inline constexpr double kVolumeOfU = 8 * 1.3;

// What a profile makes that turns about the y axis: (radius, y) from the lower end of the axis to the upper
// one, outside first; both ends have radius 0.
inline TestMesh turned_mesh(const std::vector<std::array<double, 2>>& profile, std::uint32_t around) {
  constexpr double kPi = 3.14159265358979323846;
  TestMesh mesh;
  std::vector<std::uint32_t> first;
  for (const auto& [radius, y] : profile) {
    first.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    for (std::uint32_t j = 0; j < (radius == 0.0 ? 1 : around); ++j) {
      const double turn = 2 * kPi * j / around;
      mesh.vertices.push_back({static_cast<float>(radius * std::cos(turn)), static_cast<float>(y),
                               static_cast<float>(radius * std::sin(turn))});
    }
  }
  const auto at = [&](std::size_t i, std::uint32_t j) {
    return profile[i][0] == 0.0 ? first[i] : first[i] + j % around;
  };
  for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
    for (std::uint32_t j = 0; j < around; ++j) {
      const std::uint32_t a = at(i, j), b = at(i, j + 1), c = at(i + 1, j + 1), d = at(i + 1, j);
      if (a != b) mesh.triangles.push_back({a, b, c});
      if (c != d) mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

// Radius 1, height 2, walls and floor 0.1 thick, open at the top.
inline TestMesh cup_mesh() {
  return turned_mesh({{0, 0}, {1, 0}, {1, 2}, {0.9, 2}, {0.9, 0.1}, {0, 0.1}}, 48);
}

// A ball with bumps and dents. Only sums and products, so that it has the same bits everywhere.
inline TestMesh star_mesh(int times) {
  TestMesh mesh = ball_mesh(1.0f, times);
  mesh.map([](Vec3 v) {
    const float bumps = v.x * v.x * v.x * v.x + v.y * v.y * v.y * v.y + v.z * v.z * v.z * v.z;
    return (0.3f + 1.2f * bumps * bumps + 0.1f * v.x * v.y) * v;
  });
  return mesh;
}

inline TestMesh moved(TestMesh mesh, Quat rotation, Vec3 offset) {
  mesh.map([&](Vec3 v) { return rotate(rotation, v) + offset; });
  return mesh;
}

// A rotation about no axis in particular.
inline Quat odd_rotation() { return normalize(Quat{0.3f, 0.5f, -0.2f, 0.7f}); }

}  // namespace scree::test_solids
