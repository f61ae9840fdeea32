// What meshes cannot be made of is refused with the value and the limit.
#include <gtest/gtest.h>
#include <scree/error.h>
#include <scree/triangle_mesh.h>
#include <tests/core/geometry/mesh/meshes.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace scree {
namespace {

using test_solids::TestMesh;

std::string mesh_refusal(const TestMesh& mesh, const MeshMaterials& materials = {}) {
  try {
    const TriangleMesh built(mesh.vertices, mesh.triangles, materials);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::invalid_value);
    return error.what();
  }
  return "";
}

TEST(TriangleMeshBadInput, Coordinates) {
  for (const float wrong : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity(), 1.1e5f}) {
    TestMesh mesh = test_solids::box_mesh({1, 1, 1});
    mesh.vertices[6].z = wrong;
    EXPECT_EQ(mesh_refusal(mesh).find("TriangleMesh: coordinate z of vertex 6 is "), 0u)
        << mesh_refusal(mesh);
  }
}

TEST(TriangleMeshBadInput, Corners) {
  for (const std::uint32_t wrong : {8u, 0xffffffffu}) {
    TestMesh mesh = test_solids::box_mesh({1, 1, 1});
    mesh.triangles[10].b = wrong;
    EXPECT_EQ(mesh_refusal(mesh), "TriangleMesh: triangle 10 has a corner at vertex " +
                                      std::to_string(wrong) + ", but there are 8");
  }
}

TEST(TriangleMeshBadInput, NoTriangles) {
  EXPECT_EQ(mesh_refusal({}), "TriangleMesh: the mesh has no triangles");
  EXPECT_EQ(mesh_refusal({{{0, 0, 0}, {1, 1, 1}}, {}}), "TriangleMesh: the mesh has no triangles");
  const TestMesh lines{{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, {{0, 1, 2}, {0, 0, 1}}};
  EXPECT_EQ(mesh_refusal(lines),
            "TriangleMesh: none of the 2 triangles has an area: their corners lie on lines");
}

TEST(TriangleMeshBadInput, Materials) {
  const TestMesh mesh = test_solids::box_mesh({1, 1, 1});
  std::vector<std::uint8_t> surface(12, 0);
  std::vector<Material> materials(1);
  EXPECT_EQ(mesh_refusal(mesh, {surface, materials}), "");
  EXPECT_EQ(mesh_refusal(mesh, {surface, {}}), "TriangleMesh: triangle 0 has material 0, but there are 0");
  surface[4] = 1;
  EXPECT_EQ(mesh_refusal(mesh, {surface, materials}),
            "TriangleMesh: triangle 4 has material 1, but there are 1");
  surface[4] = 255;
  EXPECT_EQ(mesh_refusal(mesh, {surface, materials}), "");
  surface.pop_back();
  EXPECT_EQ(mesh_refusal(mesh, {surface, materials}),
            "TriangleMesh: of_triangle names the materials of 11 triangles, but there are 12");
  surface.push_back(0);
  materials.resize(256);
  EXPECT_EQ(mesh_refusal(mesh, {surface, materials}),
            "TriangleMesh: there are 256 materials, must be at most 255");
  materials.resize(255);
  EXPECT_EQ(mesh_refusal(mesh, {surface, materials}), "");
}

TEST(TriangleMeshBadInput, ValuesOfMaterials) {
  const TestMesh mesh = test_solids::box_mesh({1, 1, 1});
  const std::vector<std::uint8_t> surface(12, 1);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Material& wrong :
       {Material{.friction = -1.0f}, Material{.friction = nan}, Material{.restitution = 1.5f},
        Material{.rolling_resistance = nan}, Material{.density = 0.0f}, Material{.patch_radius = -1.0f},
        Material{.surface_velocity = {nan, 0, 0}}, Material{.friction_mix = static_cast<MixRule>(9)}}) {
    const Material materials[2]{{}, wrong};
    EXPECT_EQ(mesh_refusal(mesh, {surface, materials}).find("TriangleMesh: material 1: "), 0u)
        << mesh_refusal(mesh, {surface, materials});
  }
}

}  // namespace
}  // namespace scree
