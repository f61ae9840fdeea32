// What decompose refuses, and what it says.
#include <gtest/gtest.h>
#include <scree/decompose.h>
#include <scree/error.h>
#include <tests/core/geometry/decompose/shapes.h>

#include <limits>
#include <string>

namespace scree {
namespace {

using namespace test_solids;

std::string refusal(const TestMesh& mesh, const DecomposeOptions& options = {}) {
  try {
    decompose(mesh.vertices, mesh.triangles, options);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::invalid_value);
    return error.what();
  }
  return "";
}

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(DecomposeBadInput, NamesTheOpenEdges) {
  TestMesh mesh = box_mesh({1, 2, 3});
  mesh.triangles.erase(mesh.triangles.begin());  // corners 0, 1, 3
  EXPECT_EQ(
      refusal(mesh),
      "decompose: the mesh is not closed: of 18 edges 3 are open and 0 are between triangles that look to "
      "different sides, first an open one from vertex 1 (-1, -2, 3) to vertex 0 (-1, -2, -3); an open one "
      "from vertex 0 (-1, -2, -3) to vertex 3 (-1, 2, 3); an open one from vertex 3 (-1, 2, 3) to vertex 1 "
      "(-1, -2, 3)");
}

TEST(DecomposeBadInput, NamesTheFlippedEdges) {
  TestMesh mesh = box_mesh({1, 2, 3});
  std::swap(mesh.triangles[0].b, mesh.triangles[0].c);
  const std::string text = refusal(mesh);
  EXPECT_NE(text.find("0 are open and 3 are between"), std::string::npos) << text;
  EXPECT_NE(text.find("first a flipped one from vertex"), std::string::npos) << text;
}

TEST(DecomposeBadInput, RefusesWhatIsNoMesh) {
  EXPECT_EQ(refusal({}), "decompose: the mesh has no triangles");
  TestMesh mesh = box_mesh({1, 2, 3});
  mesh.triangles[2].b = 8;
  EXPECT_EQ(refusal(mesh), "decompose: triangle 2 has a corner at vertex 8, but there are 8");
  for (const float bad : {kNan, kInfinity, -kInfinity, 1.1e5f}) {
    mesh = box_mesh({1, 2, 3});
    mesh.vertices[5].y = bad;
    EXPECT_NE(refusal(mesh).find("decompose: coordinate y of vertex 5 is "), std::string::npos);
  }
}

TEST(DecomposeBadInput, RefusesWhatEnclosesNothing) {
  EXPECT_EQ(refusal(box_mesh({1, 0, 1})), "decompose: the mesh encloses no volume");
  EXPECT_EQ(refusal({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}}),
            "decompose: the mesh encloses no volume");
  TestMesh nothing = ball_mesh(1.0f, 1), same = nothing;
  same.flip();
  nothing.append(same);
  EXPECT_EQ(refusal(nothing), "decompose: the mesh encloses no volume");
}

TEST(DecomposeBadInput, RefusesWhatIsTooThinForHulls) {
  EXPECT_EQ(refusal(box_mesh({1, 2e-5f, 1})),
            "decompose: no part of the mesh is thick enough for a hull (see Hull)");
  EXPECT_EQ(refusal(box_mesh({2e-5f, 2e-5f, 2e-5f})),
            "decompose: no part of the mesh is thick enough for a hull (see Hull)");
}

TEST(DecomposeBadInput, RefusesOptionsOutOfRange) {
  const TestMesh mesh = box_mesh({1, 2, 3});
  for (const float bad : {0.0f, -1.0f, 0.0009f, 1.1f, kNan, kInfinity}) {
    EXPECT_NE(refusal(mesh, {.concavity_share = bad}).find("concavity_share is "), std::string::npos);
  }
  for (const float bad : {-1.0f, 1.1e5f, kNan, kInfinity}) {
    EXPECT_NE(refusal(mesh, {.concavity = bad}).find("concavity is "), std::string::npos);
  }
  for (const int bad : {0, -1, 1025}) {
    EXPECT_NE(refusal(mesh, {.max_parts = bad}).find("max_parts is "), std::string::npos);
  }
  for (const int bad : {3, 257, -64}) {
    EXPECT_NE(refusal(mesh, {.max_vertices = bad}).find("max_vertices is "), std::string::npos);
  }
  EXPECT_EQ(refusal(mesh, {.resolution = 15}), "decompose: resolution is 15, must lie in [16, 256]");
  EXPECT_EQ(refusal(mesh, {.resolution = 257}), "decompose: resolution is 257, must lie in [16, 256]");
}

TEST(DecomposeBadInput, TakesOptionsAtTheirLimits) {
  const TestMesh mesh = box_mesh({1, 2, 3});
  for (const DecomposeOptions& options :
       {DecomposeOptions{0.001f, 0.0f, 1, 4, 16}, DecomposeOptions{1.0f, 1e5f, 1024, 256, 256}}) {
    EXPECT_EQ(decompose(mesh.vertices, mesh.triangles, options).hulls.size(), 1u);
  }
}

}  // namespace
}  // namespace scree
