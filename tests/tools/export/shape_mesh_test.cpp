// Laws of the triangles that stand for shapes: they enclose what the shape does, and look outward.
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <tools/export/shape_mesh.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace scree::exports {
namespace {

ShapeMesh whole_mesh(const Geometry& geometry) {
  ShapeMesh mesh = mesh_of(unit_of(geometry));
  const Vec3 scale = scale_of(geometry);
  for (Vec3& position : mesh.positions)
    position = {scale.x * position.x, scale.y * position.y, scale.z * position.z};
  return mesh;
}

std::vector<MeshTriangle> triangles_of(const ShapeMesh& mesh) {
  std::vector<MeshTriangle> triangles;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
    triangles.push_back({mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]});
  return triangles;
}

Hull wedge() {
  const std::vector<Vec3> points = {{0.5f, -0.3f, 0.4f},   {0.5f, -0.3f, -0.4f}, {-0.5f, -0.3f, 0.4f},
                                    {-0.5f, -0.3f, -0.4f}, {0.0f, 0.5f, 0.3f},   {0.1f, 0.5f, -0.3f}};
  return Hull(points);
}

TEST(ShapeMesh, EnclosesTheVolumeOfTheShape) {
  constexpr double kPi = std::numbers::pi;
  const auto ball = [](double r) { return 4.0 / 3.0 * kPi * r * r * r; };
  const Hull hull = wedge();
  const double stretched = double{hull.volume()} * 2.0 * 0.5 * 3.0;
  // The volume, and what 24 sides may take of it.
  const std::vector<std::pair<Geometry, std::pair<double, double>>> cases = {
      {Sphere{0.7f}, {ball(0.7), 0.05}},
      {Capsule{0.5f, 0.25f}, {ball(0.25) + kPi * 0.0625, 0.05}},
      {Box{{0.5f, 1.0f, 2.0f}}, {8.0, 1e-5}},
      {Box{{0.5f, 1.0f, 2.0f}, 0.1f}, {8.0 + 0.1 * 28.0 + kPi * 0.01 * 7.0 + ball(0.1), 0.05}},
      {ConvexHull{hull, {2.0f, 0.5f, 3.0f}}, {stretched, 1e-5}},
      {Cylinder{0.5f, 0.3f}, {kPi * 0.09, 0.02}},
      {Cone{0.5f, 0.3f}, {kPi * 0.03, 0.02}},
  };
  for (const auto& [geometry, truth] : cases) {
    const ShapeMesh mesh = whole_mesh(geometry);
    ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
    const std::vector<MeshTriangle> triangles = triangles_of(mesh);
    const MeshReport report = inspect_mesh(mesh.positions, triangles);
    EXPECT_EQ(report.open_edges, 0u) << geometry.index();
    EXPECT_EQ(report.flipped_edges, 0u) << geometry.index();
    const double volume = double{mesh_mass(mesh.positions, triangles, 1.0f).mass};
    EXPECT_LE(volume, truth.first * 1.00001) << geometry.index();
    EXPECT_GE(volume, truth.first * (1.0 - truth.second)) << geometry.index();
  }
}

TEST(ShapeMesh, HasNormalsThatLookTheSameWayAsItsTriangles) {
  for (const Geometry& geometry :
       {Geometry{Sphere{}}, Geometry{Capsule{}}, Geometry{Box{}}, Geometry{Cylinder{}}, Geometry{Cone{}},
        Geometry{ConvexHull{wedge()}}, Geometry{HalfSpace{}}}) {
    const ShapeMesh mesh = mesh_of(geometry);
    for (const Vec3& normal : mesh.normals) EXPECT_NEAR(length(normal), 1.0f, 1e-5f);
    for (const MeshTriangle& triangle : triangles_of(mesh)) {
      const Vec3 a = mesh.positions[triangle.a], b = mesh.positions[triangle.b],
                 c = mesh.positions[triangle.c];
      const Vec3 outward = cross(b - a, c - a);
      for (const std::uint32_t corner : {triangle.a, triangle.b, triangle.c})
        EXPECT_GE(dot(outward, mesh.normals[corner]), 0.0f) << geometry.index();
    }
  }
}

TEST(ShapeMesh, OfAMeshIsTheMeshWithoutWhatWasDropped) {
  const std::vector<Vec3> vertices = {
      {0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {1.0f, 1.0f, 0.0f}};
  const std::vector<MeshTriangle> triangles = {{0, 1, 2}, {0, 1, 1}, {0, 1, 2}, {1, 3, 2}};
  const TriangleMesh solid(vertices, triangles);
  ASSERT_EQ(solid.triangle_count(), 2u);
  EXPECT_EQ(mesh_of(solid).indices.size(), 6u);
}

TEST(ShapeMesh, KeysAreEqualWhereScalesAloneDiffer) {
  EXPECT_EQ(key_of(Box{{1.0f, 2.0f, 3.0f}}), key_of(Box{{4.0f, 5.0f, 6.0f}}));
  EXPECT_NE(key_of(Box{{1.0f, 2.0f, 3.0f}}), key_of(Box{{1.0f, 2.0f, 3.0f}, 0.1f}));
  EXPECT_EQ(key_of(Sphere{1.0f}), key_of(Sphere{2.0f}));
  EXPECT_NE(key_of(Sphere{1.0f}), key_of(Cone{}));
  EXPECT_NE(key_of(Capsule{1.0f, 0.5f}), key_of(Capsule{1.0f, 0.4f}));
  EXPECT_EQ(key_of(ConvexHull{wedge()}), key_of(ConvexHull{wedge(), {2.0f, 1.0f, 1.0f}}));
  EXPECT_NE(key_of(ConvexHull{wedge()}), key_of(ConvexHull{wedge(), {2.0f, 1.0f, 1.0f}, 0.1f}));
}

}  // namespace
}  // namespace scree::exports
