// Laws of edges: which way the surface turns behind them.
#include <core/geometry/mesh/mesh_build.h>
#include <gtest/gtest.h>
#include <tests/core/geometry/mesh/meshes.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace scree {
namespace {

using test_solids::TestMesh;

constexpr double kHalfTurn = 3.14159265358979323846;

struct Built {
  explicit Built(const TestMesh& given) : mesh(given.vertices, given.triangles) {}
  const MeshData& data() const { return MeshAccess::solid(mesh)->data; }
  EdgeTurn turn(std::int32_t given, int edge) const {
    const std::int32_t row = row_of_given(*MeshAccess::solid(mesh), static_cast<std::size_t>(given));
    return data().turns[row].edge[edge];
  }
  TriangleMesh mesh;
};

double angle(EdgeTurn turn) { return std::atan2(turn.sine, turn.cosine); }
bool is_rim(EdgeTurn turn) { return turn.cosine == 0 && turn.sine == kTurnUnit; }
bool is_flat(EdgeTurn turn) { return turn.cosine == kTurnUnit && turn.sine == 0; }

// Triangles along the edge from (0, 0, 0) to (1, 0, 0): the first lies in the plane y = 0, seen from above,
// beyond the edge the others go on, each turned down by its angle.
TestMesh fan(const std::vector<double>& angles) {
  TestMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0.5f, 0, -1}}, {{0, 1, 2}}};
  for (const double down : angles) {
    mesh.vertices.push_back({0.5f, static_cast<float>(-std::sin(down)), static_cast<float>(std::cos(down))});
    mesh.triangles.push_back({1, 0, static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
  }
  return mesh;
}

TEST(EdgeTurns, AreTheAnglesByWhichNeighborsTurnDown) {
  for (double down = -3.1; down < 3.14; down += 0.1) {
    const Built built(fan({down}));
    EXPECT_NEAR(angle(built.turn(0, 0)), down, 1e-4) << down;
    EXPECT_NEAR(angle(built.turn(1, 0)), down, 1e-4) << down;
    for (int edge = 1; edge < 3; ++edge) EXPECT_TRUE(is_rim(built.turn(0, edge)));
  }
}

TEST(EdgeTurns, AreAnUnitLong) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-kHalfTurn, kHalfTurn);
  for (int trial = 0; trial < 200; ++trial) {
    const EdgeTurn turn = Built(fan({any(random)})).turn(0, 0);
    EXPECT_NEAR(std::hypot(turn.cosine, turn.sine), kTurnUnit, 1.0);
  }
}

TEST(EdgeTurns, TheNeighborThatRisesHighestCounts) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> any(-3.1, 3.1);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> angles{any(random), any(random), any(random)};
    const double highest = *std::min_element(angles.begin(), angles.end());
    EXPECT_NEAR(angle(Built(fan(angles)).turn(0, 0)), highest, 1e-4);
  }
}

TEST(EdgeTurns, OfABoxAreRidgesOf90Degrees) {
  const Built built(test_solids::box_mesh({1, 2, 3}));
  int flat = 0, ridges = 0;
  for (std::int32_t i = 0; i < 12; ++i) {
    for (int edge = 0; edge < 3; ++edge) {
      const EdgeTurn turn = built.turn(i, edge);
      if (is_flat(turn)) ++flat;
      if (turn.cosine == 0 && turn.sine == kTurnUnit) ++ridges;
    }
  }
  EXPECT_EQ(flat, 12);  // a diagonal a face, seen from both its triangles
  EXPECT_EQ(ridges, 24);
}

TEST(EdgeTurns, OfABallAreRidgesAndOfABowlValleys) {
  TestMesh ball = test_solids::ball_mesh(2.0f, 3);
  for (const bool is_bowl : {false, true}) {
    if (is_bowl) ball.flip();
    const Built built(ball);
    for (std::int32_t i = 0; i < built.data().triangle_count; ++i) {
      for (const EdgeTurn& turn : built.data().turns[i].edge) {
        EXPECT_GT(turn.cosine, 0);
        if (is_bowl) {
          EXPECT_LT(turn.sine, 0);
        } else {
          EXPECT_GT(turn.sine, 0);
        }
      }
    }
  }
}

// A grid of random columns and rows, and random diagonals.
TestMesh flat_grid(std::uint32_t side, std::mt19937& random) {
  std::uniform_real_distribution<float> gap(0.01f, 3.0f);
  TestMesh mesh;
  std::vector<float> lines(2 * side);
  for (std::uint32_t i = 0; i < 2 * side; ++i)
    lines[i] = (i % side == 0 ? -20.0f : lines[i - 1] + gap(random));
  for (std::uint32_t row = 0; row < side; ++row) {
    for (std::uint32_t column = 0; column < side; ++column)
      mesh.vertices.push_back({lines[column], 0.3f, lines[side + row]});
  }
  for (std::uint32_t row = 0; row + 1 < side; ++row) {
    for (std::uint32_t column = 0; column + 1 < side; ++column) {
      const std::uint32_t a = row * side + column, b = a + 1, c = a + side, d = c + 1;
      if (random() % 2 == 0) {
        mesh.triangles.push_back({a, c, b});
        mesh.triangles.push_back({b, c, d});
      } else {
        mesh.triangles.push_back({a, d, b});
        mesh.triangles.push_back({a, c, d});
      }
    }
  }
  return mesh;
}

TEST(EdgeTurns, OfAFlatTriangulationAreFlat) {
  std::mt19937 random(12);
  for (int trial = 0; trial < 5; ++trial) {
    TestMesh mesh = flat_grid(20, random);
    std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
    const Built built(mesh);
    int rims = 0;
    for (std::int32_t i = 0; i < built.data().triangle_count; ++i) {
      for (const EdgeTurn& turn : built.data().turns[i].edge) {
        if (is_rim(turn)) ++rims;
        EXPECT_TRUE(is_rim(turn) || is_flat(turn)) << turn.cosine << " " << turn.sine;
      }
    }
    EXPECT_EQ(rims, 4 * 19);
  }
}

// But for the rounding of its corners, after which its triangles lie in slightly different planes.
TEST(EdgeTurns, OfASlantedPlaneAreFlat) {
  std::mt19937 random(13);
  std::uniform_real_distribution<float> any(-1.0f, 1.0f);
  for (int trial = 0; trial < 20; ++trial) {
    TestMesh mesh = flat_grid(12, random);
    const double slope_x = any(random), slope_z = any(random);
    mesh.map([&](Vec3 v) { return Vec3{v.x, static_cast<float>(slope_x * v.x + slope_z * v.z), v.z}; });
    const Built built(mesh);
    for (std::int32_t i = 0; i < built.data().triangle_count; ++i) {
      for (const EdgeTurn& turn : built.data().turns[i].edge)
        EXPECT_TRUE(is_rim(turn) || is_flat(turn)) << turn.cosine << " " << turn.sine;
    }
  }
}

TEST(EdgeTurns, NeighborsThatLookToTheOtherSideAreNone) {
  TestMesh mesh = fan({0.0});
  std::swap(mesh.triangles[1].a, mesh.triangles[1].b);
  const Built built(mesh);
  EXPECT_TRUE(is_rim(built.turn(0, 0)));
  EXPECT_TRUE(is_rim(built.turn(1, 0)));
}

// A sheet with two fronts: within it each side goes on flat, at its rim it turns to the other side.
TEST(EdgeTurns, OfATwoSidedSheetAreFlatWithin) {
  std::mt19937 random(14);
  TestMesh sheet = flat_grid(6, random);
  const std::size_t one_side = sheet.triangles.size();
  for (std::size_t i = 0; i < one_side; ++i) {
    const MeshTriangle t = sheet.triangles[i];
    sheet.triangles.push_back({t.a, t.c, t.b});
  }
  const Built built(sheet);
  EXPECT_EQ(built.mesh.triangle_count(), 2 * one_side);
  int folds = 0;
  for (std::int32_t i = 0; i < built.data().triangle_count; ++i) {
    for (const EdgeTurn& turn : built.data().turns[i].edge) {
      const bool is_fold = turn.cosine == -kTurnUnit && turn.sine == 1;
      EXPECT_TRUE(is_flat(turn) || is_fold);
      folds += is_fold ? 1 : 0;
    }
  }
  EXPECT_EQ(folds, 2 * 4 * 5);
}

TEST(EdgeTurns, DoNotDependOnTheOrderOfTriangles) {
  std::mt19937 random(15);
  TestMesh mesh = fan({0.5, -0.25, -0.25, 2.0, -3.0, 3.0});
  const EdgeTurn turn = Built(mesh).turn(0, 0);
  for (int trial = 0; trial < 20; ++trial) {
    std::shuffle(mesh.triangles.begin() + 1, mesh.triangles.end(), random);
    const EdgeTurn shuffled = Built(mesh).turn(0, 0);
    EXPECT_EQ(shuffled.cosine, turn.cosine);
    EXPECT_EQ(shuffled.sine, turn.sine);
  }
}

}  // namespace
}  // namespace scree
