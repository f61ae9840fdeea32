// Laws of built meshes: what is kept of the input, the tree over it, and that nothing depends on the order of
// what is handed in but the numbers of triangles.
#include <core/geometry/mesh/mesh_build.h>
#include <gtest/gtest.h>
#include <scree/error.h>
#include <tests/core/geometry/mesh/meshes.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>

namespace scree {
namespace {

using test_solids::TestMesh;

TriangleMesh build(const TestMesh& mesh) { return TriangleMesh(mesh.vertices, mesh.triangles); }
const MeshSolid& solid_of(const TriangleMesh& mesh) { return *MeshAccess::solid(mesh); }

// Triangles of any size and place, which share no more than some corners.
TestMesh random_mesh(std::uint32_t triangles, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(-20.0f, 30.0f);
  TestMesh mesh;
  const std::uint32_t vertices = triangles / 2 + 3;
  for (std::uint32_t i = 0; i < vertices; ++i)
    mesh.vertices.push_back({place(random), place(random), place(random)});
  for (std::uint32_t i = 0; i < triangles; ++i) {
    const auto a = static_cast<std::uint32_t>(random() % vertices);
    mesh.triangles.push_back({a, (a + 1 + i % 3) % vertices, (a + 5 + i % 7) % vertices});
  }
  return mesh;
}

// Triangles that share no corners.
TestMesh loose_mesh(std::uint32_t triangles, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(-50.0f, 50.0f);
  TestMesh mesh;
  for (std::uint32_t i = 0; i < 3 * triangles; ++i) {
    mesh.vertices.push_back({place(random), place(random), place(random)});
    if (i % 3 == 0) mesh.triangles.push_back({i, i + 1, i + 2});
  }
  return mesh;
}

struct TestBox {
  Vec3 lower, upper;
};
TestBox child_box(const NodeBlock& node, int child) {
  return {{node.bounds[0][child], node.bounds[1][child], node.bounds[2][child]},
          {node.bounds[3][child], node.bounds[4][child], node.bounds[5][child]}};
}
bool is_empty(const TestBox& box) { return box.lower.x > box.upper.x; }
bool holds(const TestBox& outer, const TestBox& inner) {
  for (int axis = 0; axis < 3; ++axis) {
    if (inner.lower[axis] < outer.lower[axis] || inner.upper[axis] > outer.upper[axis]) return false;
  }
  return true;
}
Vec3 point(const MeshData& data, std::int32_t vertex) {
  return {data.vertex[3 * vertex], data.vertex[3 * vertex + 1], data.vertex[3 * vertex + 2]};
}

void check_tree(const MeshData& data) {
  std::int32_t blocks = (data.triangle_count + kTreeBlock - 1) / kTreeBlock;
  for (std::int32_t triangle = 0; triangle < data.triangle_count; ++triangle) {
    const std::int32_t leaf = triangle / kTreeBlock;
    const TestBox box = child_box(data.nodes[0][leaf / kTreeBlock], leaf % kTreeBlock);
    for (const std::int32_t vertex : data.corners[triangle].vertex) {
      ASSERT_GE(vertex, 0);
      ASSERT_LT(vertex, data.vertex_count);
      const Vec3 p = point(data, vertex);
      ASSERT_TRUE(holds(box, {p, p})) << triangle;
    }
  }
  for (int level = 0; level < data.levels; ++level) {
    const std::int32_t parents = (blocks + kTreeBlock - 1) / kTreeBlock;
    for (std::int32_t child = 0; child < parents * kTreeBlock; ++child) {
      const TestBox box = child_box(data.nodes[level][child / kTreeBlock], child % kTreeBlock);
      ASSERT_EQ(is_empty(box), child >= blocks) << level << " " << child;
      if (level == 0 || child >= blocks) continue;
      for (int k = 0; k < kTreeBlock; ++k) {
        const TestBox inner = child_box(data.nodes[level - 1][child], k);
        if (!is_empty(inner)) {
          ASSERT_TRUE(holds(box, inner));
        }
      }
    }
    blocks = parents;
  }
  ASSERT_EQ(blocks, 1);
}

TEST(TriangleMeshTree, EveryBoxHoldsWhatIsBelowIt) {
  for (const std::uint32_t count :
       {1u, 2u, 15u, 16u, 17u, 255u, 256u, 257u, 300u, 4095u, 4096u, 4097u, 20000u}) {
    const TriangleMesh mesh = build(loose_mesh(count, count));
    ASSERT_EQ(mesh.triangle_count(), count);
    check_tree(solid_of(mesh).data);
  }
  check_tree(solid_of(build(random_mesh(5000, 1))).data);
  check_tree(solid_of(build(test_solids::torus_mesh(3, 1, 40, 20))).data);
}

TEST(TriangleMeshTree, ColumnsEndWithCopiesOfTheLastTriangle) {
  const TriangleMesh mesh = build(test_solids::box_mesh({1, 2, 3}));
  const MeshColumns& columns = solid_of(mesh).columns;
  EXPECT_EQ(mesh.triangle_count(), 12u);
  ASSERT_EQ(columns.corners.size(), 16u);
  ASSERT_EQ(columns.turns.size(), 16u);
  ASSERT_EQ(columns.given.size(), 16u);
  for (int i = 12; i < 16; ++i) {
    EXPECT_EQ(columns.given[i], columns.given[11]);
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(columns.corners[i].vertex[k], columns.corners[11].vertex[k]);
      EXPECT_EQ(columns.turns[i].edge[k].sine, columns.turns[11].edge[k].sine);
    }
  }
}

TEST(TriangleMeshTree, LeavesAreListedByGivenNumbers) {
  const TriangleMesh mesh = build(random_mesh(5000, 3));
  const MeshData& data = solid_of(mesh).data;
  for (std::int32_t i = 1; i < data.triangle_count; ++i) {
    if (i % kTreeBlock != 0) {
      EXPECT_LT(data.given[i - 1], data.given[i]);
    }
  }
}

// The boxes of leaves of a fine grid are small: 16 triangles of it lie close together.
TEST(TriangleMeshTree, LeavesOfAGridAreCompact) {
  TestMesh mesh = test_solids::torus_mesh(3, 1, 128, 64);
  std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), std::mt19937(1));
  const TriangleMesh built = build(mesh);
  const MeshData& data = solid_of(built).data;
  double sum = 0.0;
  const std::int32_t leaves = data.triangle_count / kTreeBlock;
  for (std::int32_t leaf = 0; leaf < leaves; ++leaf) {
    const TestBox box = child_box(data.nodes[0][leaf / kTreeBlock], leaf % kTreeBlock);
    sum += length(box.upper - box.lower);
  }
  EXPECT_LT(sum / leaves, 0.75);  // m; 16 triangles cover 0.116 m^2, a square of 0.34 m
}

TEST(TriangleMesh, KeepsVerticesAndTrianglesAsGiven) {
  const TestMesh given = test_solids::torus_mesh(2, 0.5, 20, 10);
  const TriangleMesh mesh = build(given);
  ASSERT_EQ(mesh.vertices().size(), given.vertices.size());
  EXPECT_TRUE(std::equal(given.vertices.begin(), given.vertices.end(), mesh.vertices().begin()));
  ASSERT_EQ(mesh.triangle_count(), given.triangles.size());
  for (std::size_t i = 0; i < given.triangles.size(); ++i) EXPECT_EQ(mesh.triangle(i), given.triangles[i]);
  EXPECT_EQ(mesh.report().merged_vertices, 0u);
  EXPECT_EQ(mesh.report().dropped_triangles, 0u);
  EXPECT_TRUE(mesh.report().given.is_closed());
}

TEST(TriangleMesh, PositionsAreRoundedOnceAboutTheCenter) {
  TestMesh given = random_mesh(300, 8);
  given.map([](Vec3 v) { return v + Vec3{1000, -300, 7}; });
  const TriangleMesh mesh = build(given);
  const MeshSolid& solid = solid_of(mesh);
  float radius = 0.0f;
  Vec3 half{};
  for (std::int32_t i = 0; i < solid.data.vertex_count; ++i) {
    const auto given_vertex = static_cast<std::size_t>(solid.columns.given_vertex[i]);
    const Vec3 given_point = mesh.vertices()[given_vertex], p = point(solid.data, i);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(p[axis], static_cast<float>(double{given_point[axis]} - solid.origin[axis]));
      half[axis] = std::max(half[axis], std::abs(p[axis]));
    }
    radius = std::max(radius, length(p));
  }
  for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(solid.extent.half[axis], half[axis]);
  EXPECT_NEAR(solid.extent.radius, radius, 1e-5f * radius);
}

TEST(TriangleMesh, WhatIsFlatStaysFlat) {
  for (int axis = 0; axis < 3; ++axis) {
    TestMesh given = random_mesh(200, 5);
    given.map([axis](Vec3 v) {
      v = v + Vec3{0.1f, 20000.3f, 0.7f};
      v[axis] = 0.123f;
      return v;
    });
    const TriangleMesh mesh = build(given);
    const MeshData& data = solid_of(mesh).data;
    for (std::int32_t i = 0; i < data.vertex_count; ++i) EXPECT_EQ(point(data, i)[axis], 0.0f);
    EXPECT_EQ(solid_of(mesh).extent.half[axis], 0.0f);
  }
}

TEST(TriangleMesh, MergesPlacesAndDropsWhatIsNoTriangle) {
  const TestMesh given{{{9, 9, 9}, {0.0f, 0, 0}, {-0.0f, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {0, 0, 1}},
                       {{1, 2, 3},    // two corners in one place
                        {1, 3, 5},    // on one line
                        {1, 3, 4},    // stays
                        {3, 4, 2},    // the same, begun elsewhere
                        {1, 4, 3},    // its back: stays
                        {4, 3, 6}}};  // stays
  const TriangleMesh mesh = build(given);
  EXPECT_EQ(mesh.triangle_count(), 3u);
  EXPECT_EQ(mesh.vertices().size(), 4u);
  EXPECT_EQ(mesh.report().given.triangles, 6u);
  EXPECT_EQ(mesh.report().merged_vertices, 3u);  // unused, the other zero, of a dropped triangle
  EXPECT_EQ(mesh.report().dropped_triangles, 3u);
  EXPECT_EQ(mesh.triangle(2), (MeshTriangle{0, 1, 2}));
  EXPECT_EQ(mesh.triangle(4), (MeshTriangle{0, 2, 1}));
  EXPECT_EQ(mesh.triangle(5), (MeshTriangle{2, 1, 3}));
  EXPECT_FALSE(std::signbit(mesh.vertices()[0].x));
  for (const std::size_t dropped : {0u, 1u, 3u}) {
    EXPECT_THROW(mesh.triangle(dropped), Error);
  }
  EXPECT_THROW(mesh.triangle(6), Error);
  EXPECT_EQ(solid_of(mesh).origin[0], 0.5);  // unused vertices have no part in the box
}

TEST(TriangleMesh, KeepsSlivers) {
  const TestMesh given{{{0, 0, 0}, {1, 0, 0}, {0.5f, 1e-30f, 0}}, {{0, 1, 2}}};
  EXPECT_EQ(build(given).triangle_count(), 1u);
}

// About a far center the kernels' floats are coarser than the given ones.
TEST(TriangleMesh, MergesWhatTheKernelsCannotTellApart) {
  TestMesh given{{{0, 0, 0}, {1e-4f, 0, 0}, {0, 1e-4f, 0}, {1e5f, 0, 0}, {0, 1e5f, 0}},
                 {{0, 1, 2}, {1, 3, 4}, {0, 4, 3}}};
  const TriangleMesh mesh = build(given);
  EXPECT_EQ(mesh.triangle_count(), 2u);
  EXPECT_EQ(mesh.vertices().size(), 3u);
  EXPECT_EQ(mesh.report().given.vertices, 5u);
  EXPECT_EQ(mesh.report().merged_vertices, 2u);
}

using PlacedTriangle = std::array<std::array<float, 3>, 3>;
PlacedTriangle placed(const MeshData& data, std::int32_t row) {
  PlacedTriangle triangle{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 p = point(data, data.corners[row].vertex[k]);
    triangle[k] = {p.x, p.y, p.z};
  }
  std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
  return triangle;
}

// Where the centers of triangles differ: equal ones are told apart by the triangles' numbers.
TEST(TriangleMesh, LeavesDoNotDependOnTheOrderOfTrianglesAndVertices) {
  const TestMesh given = loose_mesh(3000, 21);
  std::mt19937 random(4);
  std::vector<std::uint32_t> place(given.vertices.size());
  std::iota(place.begin(), place.end(), 0u);
  std::shuffle(place.begin(), place.end(), random);
  TestMesh other{std::vector<Vec3>(place.size()), {}};
  for (std::size_t i = 0; i < place.size(); ++i) other.vertices[place[i]] = given.vertices[i];
  for (const MeshTriangle& t : given.triangles)
    other.triangles.push_back({place[t.b], place[t.c], place[t.a]});
  std::shuffle(other.triangles.begin(), other.triangles.end(), random);
  const TriangleMesh a = build(given), b = build(other);
  const MeshSolid &solid_a = solid_of(a), &solid_b = solid_of(b);
  ASSERT_EQ(a.triangle_count(), b.triangle_count());
  EXPECT_EQ(solid_a.extent.radius, solid_b.extent.radius);
  EXPECT_TRUE(std::equal(solid_a.origin, solid_a.origin + 3, solid_b.origin));
  for (std::int32_t leaf = 0; leaf * kTreeBlock < solid_a.data.triangle_count; ++leaf) {
    std::set<PlacedTriangle> of_a, of_b;
    for (std::int32_t i = leaf * kTreeBlock; i < (leaf + 1) * kTreeBlock; ++i) {
      of_a.insert(placed(solid_a.data, i));
      of_b.insert(placed(solid_b.data, i));
    }
    EXPECT_EQ(of_a, of_b) << leaf;
  }
}

TEST(TriangleMesh, EqualMeshesAreEqual) {
  const TestMesh given = random_mesh(400, 2);
  const TriangleMesh mesh = build(given), same = build(given), copy = mesh;
  EXPECT_EQ(mesh, same);
  EXPECT_EQ(mesh, copy);
  EXPECT_EQ(solid_of(mesh).content_hash, solid_of(same).content_hash);
  EXPECT_EQ(MeshAccess::solid(mesh), MeshAccess::solid(copy));
  TestMesh other = given;
  other.vertices[5].x += 1.0f;
  EXPECT_FALSE(mesh == build(other));
  other = given;
  std::swap(other.triangles[0], other.triangles[1]);
  EXPECT_FALSE(mesh == build(other));
  const Material smooth{.friction = 0.1f};
  std::vector<std::uint8_t> surface(given.triangles.size(), 255);
  EXPECT_EQ(mesh, TriangleMesh(given.vertices, given.triangles, {surface, {}}));
  surface[7] = 0;
  const TriangleMesh icy(given.vertices, given.triangles, {surface, std::span(&smooth, 1)});
  EXPECT_FALSE(mesh == icy);
  EXPECT_EQ(icy, TriangleMesh(given.vertices, given.triangles, {surface, std::span(&smooth, 1)}));
}

TEST(TriangleMesh, MovedFromAndDefaultMeshesAreEmpty) {
  TriangleMesh mesh = build(test_solids::box_mesh({1, 1, 1}));
  const TriangleMesh taken = std::move(mesh);
  for (const TriangleMesh& empty : {mesh, TriangleMesh()}) {  // NOLINT: moved from on purpose
    EXPECT_TRUE(empty.is_empty());
    EXPECT_EQ(empty.triangle_count(), 0u);
    EXPECT_TRUE(empty.vertices().empty());
    EXPECT_EQ(empty.memory(), 0u);
    EXPECT_EQ(empty.report().given.triangles, 0u);
    EXPECT_THROW(empty.triangle(0), Error);
    EXPECT_FALSE(empty == taken);
  }
  EXPECT_EQ(taken.triangle_count(), 12u);
}

TEST(TriangleMesh, MaterialsFollowTheirTriangles) {
  const TestMesh given = test_solids::torus_mesh(2, 0.5, 30, 10);
  const Material materials[2]{{.friction = 0.1f, .density = 5, .surface_velocity = {1, 0, 0}},
                              {.restitution = 0.5f, .patch_radius = 0.25f}};
  std::vector<std::uint8_t> surface(given.triangles.size());
  for (std::size_t i = 0; i < surface.size(); ++i) surface[i] = std::array<std::uint8_t, 3>{0, 1, 255}[i % 3];
  const TriangleMesh mesh(given.vertices, given.triangles, {surface, materials});
  const MeshData& data = solid_of(mesh).data;
  ASSERT_NE(data.material, nullptr);
  for (std::int32_t i = 0; i < data.triangle_count; ++i)
    EXPECT_EQ(data.material[i], surface[static_cast<std::size_t>(data.given[i])]);
  EXPECT_EQ(data.materials[0].friction, 0.1f);
  EXPECT_EQ(data.materials[0].rules & kMaterialMoves, 0u);
  EXPECT_EQ(data.materials[1].restitution, 0.5f);
  EXPECT_EQ(data.materials[1].patch_radius, 0.25f);
  EXPECT_EQ(solid_of(build(given)).data.material, nullptr);
}

TEST(TriangleMesh, TakesFewBytesATriangle) {
  const TriangleMesh mesh = build(test_solids::torus_mesh(30, 10, 400, 250));  // 200,000 triangles
  EXPECT_LT(static_cast<double>(mesh.memory()) / static_cast<double>(mesh.triangle_count()), 60.0);
}

TEST(TriangleMesh, MadeOfItsPartsIsTheSame) {
  TestMesh given = random_mesh(2000, 17);
  given.triangles.push_back(given.triangles[3]);
  given.triangles.insert(given.triangles.begin(), {1, 1, 2});
  std::vector<std::uint8_t> surface(given.triangles.size(), 255);
  surface[100] = 0;
  const Material rough{.friction = 2.0f};
  const TriangleMesh mesh(given.vertices, given.triangles, {surface, std::span(&rough, 1)});
  const MeshParts parts = parts_of(solid_of(mesh));
  EXPECT_EQ(find_defect(parts), "");
  const TriangleMesh again = MeshAccess::mesh(complete_mesh(parts));
  EXPECT_EQ(mesh, again);
  EXPECT_EQ(solid_of(mesh).extent.radius, solid_of(again).extent.radius);
  for (std::int32_t i = 0; i < solid_of(mesh).data.triangle_count; ++i) {
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(solid_of(mesh).data.turns[i].edge[k].sine, solid_of(again).data.turns[i].edge[k].sine);
  }
}

TEST(TriangleMesh, PartsWithDefectsAreFound) {
  const TriangleMesh mesh = build(test_solids::torus_mesh(2, 0.5, 10, 6));
  const MeshParts sound = parts_of(solid_of(mesh));
  const auto defect = [&](auto&& change) {
    MeshParts parts = sound;
    change(parts);
    return find_defect(parts);
  };
  EXPECT_EQ(defect([](MeshParts&) {}), "");
  EXPECT_NE(defect([](MeshParts& p) { p.vertices[3].x = std::numeric_limits<float>::quiet_NaN(); }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.vertices[3].x = 1e6f; }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.vertices[3] = p.vertices[4]; }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.vertices.push_back({100, 0, 0}); }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.triangles[9].b = 60; }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.triangles[9].b = p.triangles[9].a; }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.triangles[9] = p.triangles[8]; }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.triangles.clear(), p.given.clear(); }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.given.pop_back(); }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.given[0] = -1; }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.given[5] = p.given[4]; }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.given.back() = 120; }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.surface.assign(p.triangles.size(), 0); }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.surface.assign(3, 255); }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.materials.assign(256, {}); }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.materials.assign(1, {.friction = -1.0f}); }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.origin[1] = std::numeric_limits<double>::quiet_NaN(); }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.origin[1] = 1e300; }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.report.given.triangles = 3; }), "");
  EXPECT_NE(defect([](MeshParts& p) { p.report.dropped_triangles = 1; }), "");
}

}  // namespace
}  // namespace scree
