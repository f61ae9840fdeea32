// Laws of the report on a mesh.
#include <gtest/gtest.h>
#include <scree/error.h>
#include <tests/core/geometry/mesh/meshes.h>

#include <algorithm>
#include <limits>
#include <random>

namespace scree {
namespace {

using test_solids::TestMesh;

MeshReport inspect(const TestMesh& mesh) { return inspect_mesh(mesh.vertices, mesh.triangles); }

std::string inspection_refusal(const TestMesh& mesh) {
  try {
    inspect(mesh);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// Euler: V - E + F = 2 (parts - handles).
long long euler(const MeshReport& report) {
  return static_cast<long long>(report.vertices) - static_cast<long long>(report.edges) +
         static_cast<long long>(report.triangles);
}

TEST(InspectMesh, ClosedSurfacesHaveTheirEulerCharacteristic) {
  for (const auto& [mesh, characteristic] :
       {std::pair{test_solids::box_mesh({1, 2, 3}), 2ll}, std::pair{test_solids::ball_mesh(2.0f, 3), 2ll},
        std::pair{test_solids::torus_mesh(2.0, 0.5, 12, 7), 0ll}}) {
    const MeshReport report = inspect(mesh);
    EXPECT_TRUE(report.is_closed());
    EXPECT_EQ(euler(report), characteristic);
    EXPECT_EQ(2 * report.edges, 3 * report.triangles);
    EXPECT_EQ(report.parts, 1u);
    EXPECT_EQ(report.crowded_edges, 0u);
    EXPECT_EQ(report.duplicates + report.no_area + report.repeated_corners, 0u);
  }
}

TEST(InspectMesh, AHoleOpensTheEdgesAroundIt) {
  TestMesh mesh = test_solids::ball_mesh(1.0f, 2);
  mesh.triangles.erase(mesh.triangles.begin() + 17);
  const MeshReport report = inspect(mesh);
  EXPECT_EQ(report.open_edges, 3u);
  EXPECT_FALSE(report.is_closed());
}

TEST(InspectMesh, ATurnedTriangleFlipsItsThreeEdges) {
  TestMesh mesh = test_solids::box_mesh({1, 1, 1});
  std::swap(mesh.triangles[5].b, mesh.triangles[5].c);
  const MeshReport report = inspect(mesh);
  EXPECT_EQ(report.flipped_edges, 3u);
  EXPECT_EQ(report.open_edges, 0u);
  EXPECT_FALSE(report.is_closed());
}

TEST(InspectMesh, VerticesInOnePlaceAreOne) {
  const TestMesh box = test_solids::box_mesh({1, 2, 3});
  TestMesh soup;  // three corners of its own for each triangle
  for (const MeshTriangle& t : box.triangles) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (const std::uint32_t corner : {t.a, t.b, t.c}) soup.vertices.push_back(box.vertices[corner]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  soup.vertices[0].x += 0.0f;
  const MeshReport report = inspect(soup);
  EXPECT_EQ(report.vertices, 8u);
  EXPECT_TRUE(report.is_closed());
  // Zeros of both signs are one place.
  TestMesh zeros{{{0.0f, 0, 0}, {-0.0f, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 2, 3}, {1, 2, 3}}};
  EXPECT_EQ(inspect(zeros).vertices, 3u);
  EXPECT_EQ(inspect(zeros).duplicates, 1u);
}

TEST(InspectMesh, CountsTrianglesThatAreNone) {
  TestMesh mesh = test_solids::box_mesh({1, 1, 1});
  mesh.triangles.push_back({0, 0, 5});
  mesh.vertices.push_back({-1, -1, 0});  // on the edge from 0 to 1
  mesh.triangles.push_back({0, 8, 1});
  mesh.triangles.push_back({2, 0, 1});  // as the first triangle, turned and begun elsewhere
  const MeshReport report = inspect(mesh);
  EXPECT_EQ(report.repeated_corners, 1u);
  EXPECT_EQ(report.no_area, 1u);
  EXPECT_EQ(report.triangles, 15u);
  EXPECT_EQ(report.duplicates, 0u);
  mesh.triangles.push_back({3, 0, 1});
  EXPECT_EQ(inspect(mesh).duplicates, 1u);
}

TEST(InspectMesh, TwoBoxesAtOneEdgeAreClosedAndCrowded) {
  TestMesh mesh = test_solids::box_mesh({1, 1, 1}), other = mesh;
  other.map([](Vec3 v) { return v + Vec3{2, 2, 0}; });
  mesh.append(other);
  const MeshReport report = inspect(mesh);
  EXPECT_TRUE(report.is_closed());
  EXPECT_EQ(report.crowded_edges, 1u);
  EXPECT_EQ(report.parts, 1u);
}

TEST(InspectMesh, CountsPartsAndBounds) {
  TestMesh mesh = test_solids::ball_mesh(1.0f, 1), far = test_solids::box_mesh({1, 2, 3});
  far.map([](Vec3 v) { return v + Vec3{10, 0, 0}; });
  mesh.append(far);
  const MeshReport report = inspect(mesh);
  EXPECT_EQ(report.parts, 2u);
  EXPECT_EQ(report.lower, (Vec3{-1, -2, -3}));
  EXPECT_EQ(report.upper, (Vec3{11, 2, 3}));
  const MeshReport nothing = inspect({});
  EXPECT_EQ(nothing.parts, 0u);
  EXPECT_FALSE(nothing.is_closed());
}

TEST(InspectMesh, TheOrderOfTrianglesDoesNotMatter) {
  TestMesh mesh = test_solids::torus_mesh(3.0, 1.0, 9, 5);
  mesh.triangles.push_back({0, 1, 7});
  mesh.triangles.push_back({4, 4, 7});
  std::mt19937 random(7);
  const MeshReport report = inspect(mesh);
  for (int trial = 0; trial < 10; ++trial) {
    std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
    const MeshReport shuffled = inspect(mesh);
    EXPECT_EQ(shuffled.edges, report.edges);
    EXPECT_EQ(shuffled.open_edges, report.open_edges);
    EXPECT_EQ(shuffled.flipped_edges, report.flipped_edges);
    EXPECT_EQ(shuffled.crowded_edges, report.crowded_edges);
    EXPECT_EQ(shuffled.parts, report.parts);
  }
}

TEST(InspectMesh, RefusesWithTheNumberAndTheLimit) {
  TestMesh mesh = test_solids::box_mesh({1, 1, 1});
  mesh.vertices[3].y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NE(inspection_refusal(mesh).find("coordinate y of vertex 3 is nan, must lie in [-100000, 100000]"),
            std::string::npos)
      << inspection_refusal(mesh);
  mesh.vertices[3].y = 2e5f;
  EXPECT_NE(inspection_refusal(mesh).find("coordinate y of vertex 3 is 200000"), std::string::npos)
      << inspection_refusal(mesh);
  mesh.vertices[3].y = 1.0f;
  mesh.triangles[4].c = 8;
  EXPECT_EQ(inspection_refusal(mesh), "inspect_mesh: triangle 4 has a corner at vertex 8, but there are 8");
}

}  // namespace
}  // namespace scree
