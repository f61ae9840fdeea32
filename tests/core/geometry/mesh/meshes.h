// Meshes for tests whose solids are known.
#pragma once

#include <scree/math.h>
#include <scree/mesh.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace scree::test_solids {

struct TestMesh {
  std::vector<Vec3> vertices;
  std::vector<MeshTriangle> triangles;

  void append(const TestMesh& other) {
    const auto first = static_cast<std::uint32_t>(vertices.size());
    vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const MeshTriangle& t : other.triangles)
      triangles.push_back({first + t.a, first + t.b, first + t.c});
  }
  void flip() {
    for (MeshTriangle& t : triangles) std::swap(t.b, t.c);
  }
  template <class Map>
  void map(Map&& to) {
    for (Vec3& vertex : vertices) vertex = to(vertex);
  }
};

// From -half to half.
inline TestMesh box_mesh(Vec3 half) {
  TestMesh mesh;
  for (const float x : {-half.x, half.x}) {
    for (const float y : {-half.y, half.y}) {
      for (const float z : {-half.z, half.z}) mesh.vertices.push_back({x, y, z});
    }
  }
  constexpr std::uint32_t kFaces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                          {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
  for (const auto& f : kFaces) {
    mesh.triangles.push_back({f[0], f[1], f[2]});
    mesh.triangles.push_back({f[0], f[2], f[3]});
  }
  return mesh;
}

// A torus about the y axis: `around` quads along the ring, `across` about the tube.
inline TestMesh torus_mesh(double ring, double tube, std::uint32_t around, std::uint32_t across) {
  constexpr double kPi = 3.14159265358979323846;
  TestMesh mesh;
  for (std::uint32_t i = 0; i < around; ++i) {
    for (std::uint32_t j = 0; j < across; ++j) {
      const double u = 2 * kPi * i / around, v = 2 * kPi * j / across, r = ring + tube * std::cos(v);
      mesh.vertices.push_back({static_cast<float>(r * std::cos(u)), static_cast<float>(tube * std::sin(v)),
                               static_cast<float>(r * std::sin(u))});
    }
  }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return i % around * across + j % across; };
  for (std::uint32_t i = 0; i < around; ++i) {
    for (std::uint32_t j = 0; j < across; ++j) {
      mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
    }
  }
  return mesh;
}

// An octahedron whose triangles are divided in four, `times` times, with corners at the radius.
inline TestMesh ball_mesh(float radius, int times) {
  TestMesh mesh{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  for (int time = 0; time < times; ++time) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [place, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.vertices.size()));
      if (is_new) mesh.vertices.push_back(normalize(mesh.vertices[a] + mesh.vertices[b]));
      return place->second;
    };
    std::vector<MeshTriangle> finer;
    for (const MeshTriangle& t : mesh.triangles) {
      const std::uint32_t ab = middle(t.a, t.b);
      const std::uint32_t bc = middle(t.b, t.c);
      const std::uint32_t ca = middle(t.c, t.a);
      for (const MeshTriangle& part : {MeshTriangle{t.a, ab, ca}, {t.b, bc, ab}, {t.c, ca, bc}, {ab, bc, ca}})
        finer.push_back(part);
    }
    mesh.triangles = finer;
  }
  mesh.map([&](Vec3 v) { return radius * v; });
  return mesh;
}

}  // namespace scree::test_solids
