// Laws of height fields: where their points and triangles are, which diagonals part cells, and what is
// refused.
#include <core/geometry/mesh/mesh_build.h>
#include <gtest/gtest.h>
#include <scree/error.h>
#include <scree/height_field.h>
#include <scree/math.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace scree {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::vector<float> random_heights(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> height(-2.0f, 3.0f);
  std::vector<float> heights(count);
  for (float& h : heights) h = height(random);
  return heights;
}

std::string field_refusal(const HeightField& field, const MeshMaterials& materials = {}) {
  try {
    height_field_mesh(field, materials);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

Vec3 normal_of(const TriangleMesh& mesh, std::size_t triangle) {
  const MeshTriangle t = mesh.triangle(triangle);
  const auto v = mesh.vertices();
  return cross(v[t.b] - v[t.a], v[t.c] - v[t.a]);
}

TEST(HeightField, PointsStandOnTheGrid) {
  const std::vector<float> heights = random_heights(5 * 4, 1);
  const TriangleMesh mesh =
      height_field_mesh({.columns = 5, .rows = 4, .heights = heights, .spacing_x = 0.3f, .spacing_z = 2.0f});
  ASSERT_EQ(mesh.vertices().size(), 20u);
  ASSERT_EQ(mesh.triangle_count(), 24u);
  for (std::size_t i = 0; i < 20; ++i) {
    const Vec3 expected{static_cast<float>(static_cast<double>(i % 5) * double{0.3f}), heights[i],
                        2.0f * static_cast<float>(i / 5)};
    EXPECT_EQ(mesh.vertices()[i], expected);
  }
}

// Seen from above the triangles of a cell cover it: each has half of its area, and looks up.
TEST(HeightField, TrianglesLookUpAndCoverTheirCells) {
  const std::vector<float> heights = random_heights(9 * 7, 2);
  const TriangleMesh mesh =
      height_field_mesh({.columns = 9, .rows = 7, .heights = heights, .spacing_x = 0.5f});
  for (std::size_t cell = 0; cell < 48; ++cell) {
    const float column = static_cast<float>(cell % 8), row = static_cast<float>(cell / 8);
    for (const std::size_t k : {0u, 1u}) {
      EXPECT_NEAR(normal_of(mesh, 2 * cell + k).y, 0.5f, 1e-6f);
      const MeshTriangle t = mesh.triangle(2 * cell + k);
      int on_edge = 0;
      for (const std::uint32_t corner : {t.a, t.b, t.c}) {
        const Vec3 v = mesh.vertices()[corner];
        EXPECT_TRUE(v.x == 0.5f * column || v.x == 0.5f * (column + 1));
        EXPECT_TRUE(v.z == row || v.z == row + 1);
        on_edge += v.z == row + static_cast<float>(k) ? 1 : 0;
      }
      EXPECT_EQ(on_edge, 2);  // its edge along the least or the greatest row
    }
  }
  EXPECT_EQ(mesh.report().given.open_edges, 2u * (8 + 6));
  EXPECT_EQ(mesh.report().given.flipped_edges, 0u);
}

TEST(HeightField, TheShorterDiagonalPartsACell) {
  const auto has = [](const std::vector<float>& heights, std::uint32_t from, std::uint32_t to) {
    const TriangleMesh mesh = height_field_mesh({.columns = 2, .rows = 2, .heights = heights});
    for (const std::size_t k : {0u, 1u}) {
      const MeshTriangle t = mesh.triangle(k);
      const auto is_corner = [&t](std::uint32_t v) { return t.a == v || t.b == v || t.c == v; };
      if (!is_corner(from) || !is_corner(to)) return false;
    }
    return true;
  };
  EXPECT_TRUE(has({0, 0, 0, 0}, 0, 3));
  EXPECT_TRUE(has({1, 0, 0, 1}, 0, 3));
  EXPECT_TRUE(has({0, 1, 1, 0}, 0, 3));
  EXPECT_TRUE(has({0, 1, 1, 0.5f}, 1, 2));
  EXPECT_TRUE(has({0, 0, 0, 5}, 1, 2));
  EXPECT_TRUE(has({0, 0, 5, 0}, 0, 3));
}

TEST(HeightField, HolesLeaveCellsOutAndKeepTheNumbersOfOthers) {
  const std::vector<float> heights = random_heights(6 * 5, 3);
  std::vector<std::uint8_t> holes(20, 0);
  holes[0] = holes[7] = 1;
  holes[13] = 255;
  const HeightField field{.columns = 6, .rows = 5, .heights = heights};
  HeightField with_holes = field;
  with_holes.holes = holes;
  const TriangleMesh whole = height_field_mesh(field), mesh = height_field_mesh(with_holes);
  EXPECT_EQ(mesh.triangle_count(), 34u);
  EXPECT_EQ(mesh.report().given.triangles, 40u);
  EXPECT_EQ(mesh.report().dropped_triangles, 6u);
  for (std::size_t i = 0; i < 40; ++i) {
    if (holes[i / 2] != 0) {
      EXPECT_THROW(mesh.triangle(i), Error);
      continue;
    }
    const MeshTriangle a = whole.triangle(i), b = mesh.triangle(i);
    EXPECT_EQ(whole.vertices()[a.a], mesh.vertices()[b.a]);
    EXPECT_EQ(whole.vertices()[a.b], mesh.vertices()[b.b]);
    EXPECT_EQ(whole.vertices()[a.c], mesh.vertices()[b.c]);
  }
  const MeshParts parts = parts_of(*MeshAccess::solid(mesh));
  EXPECT_EQ(find_defect(parts), "");
}

TEST(HeightField, FlatOnesAreFlat) {
  const std::vector<float> heights(40 * 30, 1.25f);
  const TriangleMesh mesh =
      height_field_mesh({.columns = 40, .rows = 30, .heights = heights, .spacing_x = 0.1f});
  const MeshData& data = MeshAccess::solid(mesh)->data;
  for (std::int32_t i = 0; i < data.triangle_count; ++i) {
    for (const EdgeTurn& turn : data.turns[i].edge) {
      EXPECT_TRUE((turn.sine == 0 && turn.cosine == kTurnUnit) ||
                  (turn.sine == kTurnUnit && turn.cosine == 0));
    }
  }
}

TEST(HeightField, MaterialsFollowTheirTriangles) {
  const std::vector<float> heights(9, 0.0f);
  const std::vector<std::uint8_t> surface{0, 1, 255, 0, 1, 255, 0, 1};
  const std::vector<std::uint8_t> holes{0, 1, 0, 0};
  const Material materials[2]{{.friction = 0.1f}, {.friction = 0.2f}};
  const TriangleMesh mesh =
      height_field_mesh({.columns = 3, .rows = 3, .heights = heights, .holes = holes}, {surface, materials});
  const MeshData& data = MeshAccess::solid(mesh)->data;
  ASSERT_EQ(data.triangle_count, 6);
  for (std::int32_t i = 0; i < data.triangle_count; ++i)
    EXPECT_EQ(data.material[i], surface[static_cast<std::size_t>(data.given[i])]);
}

TEST(HeightField, RefusesWithTheValueAndTheLimit) {
  const std::vector<float> heights(12, 0.0f);
  const HeightField sound{.columns = 4, .rows = 3, .heights = heights};
  const auto refused = [&](auto&& change) {
    HeightField field = sound;
    change(field);
    return field_refusal(field);
  };
  EXPECT_EQ(refused([](HeightField&) {}), "");
  EXPECT_EQ(refused([](HeightField& f) { f.columns = 1; }),
            "height_field_mesh: columns is 1, must lie in [2, 1.07374182e+09]");
  EXPECT_EQ(refused([](HeightField& f) { f.rows = 0; }),
            "height_field_mesh: rows is 0, must lie in [2, 1.07374182e+09]");
  EXPECT_EQ(
      refused([](HeightField& f) { f.columns = f.rows = 100000; }),
      "height_field_mesh: 100000 x 100000 heights are too many: there may be 1073741824 triangles at most");
  EXPECT_EQ(refused([](HeightField& f) { f.rows = 4; }),
            "height_field_mesh: there are 12 heights, must be 16");
  const std::vector<std::uint8_t> holes(7);
  EXPECT_EQ(refused([&](HeightField& f) { f.holes = holes; }),
            "height_field_mesh: there are 7 holes, must be 6");
  for (const float wrong : {0.0f, -1.0f, kNan, std::numeric_limits<float>::infinity(), 4e4f}) {
    const std::string x = refused([&](HeightField& f) { f.spacing_x = wrong; });
    EXPECT_EQ(x.find("height_field_mesh: spacing_x is "), 0u) << x;
    const std::string z = refused([&](HeightField& f) { f.spacing_z = wrong * 2; });
    EXPECT_EQ(z.find("height_field_mesh: spacing_z is "), 0u) << z;
  }
  for (const float wrong : {kNan, std::numeric_limits<float>::infinity(), -1.1e5f}) {
    std::vector<float> bad = heights;
    bad[6] = wrong;
    const std::string message = refused([&](HeightField& f) { f.heights = bad; });
    EXPECT_EQ(message.find("height_field_mesh: the height at column 2, row 1 is "), 0u) << message;
  }
  const std::vector<std::uint8_t> all(6, 1);
  EXPECT_EQ(refused([&](HeightField& f) { f.holes = all; }), "height_field_mesh: all 6 cells are holes");
  const std::vector<std::uint8_t> surface(11, 255);
  EXPECT_EQ(field_refusal(sound, {surface, {}}),
            "height_field_mesh: of_triangle names the materials of 11 triangles, but there are 12");
}

}  // namespace
}  // namespace scree
