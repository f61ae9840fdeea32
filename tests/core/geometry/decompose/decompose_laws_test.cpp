// Laws of any decomposition: order does not matter, options are kept, the mesh is covered, and nothing that
// is closed is too strange.
#include <gtest/gtest.h>
#include <scree/decompose.h>
#include <scree/error.h>
#include <tests/core/geometry/decompose/shapes.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <numeric>
#include <string>

namespace scree {
namespace {

using namespace test_solids;

Decomposition decompose(const TestMesh& mesh, const DecomposeOptions& options = {}) {
  return scree::decompose(mesh.vertices, mesh.triangles, options);
}

// SplitMix64.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint32_t below(std::uint32_t count) {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return static_cast<std::uint32_t>((z ^ (z >> 31)) % count);
  }
  float between(float low, float high) {
    return low + (high - low) * (static_cast<float>(below(1u << 20)) / float{1u << 20});
  }

 private:
  std::uint64_t state_;
};

// Vertices and triangles in another order, and other corners first.
TestMesh shuffled(const TestMesh& mesh, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::uint32_t> order(mesh.vertices.size()), place(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  for (std::size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
  }
  TestMesh other;
  for (const std::uint32_t vertex : order) {
    place[vertex] = static_cast<std::uint32_t>(other.vertices.size());
    other.vertices.push_back(mesh.vertices[vertex]);
  }
  for (const MeshTriangle& t : mesh.triangles) {
    const std::uint32_t corners[3] = {place[t.a], place[t.b], place[t.c]};
    const std::uint32_t first = random.below(3);
    other.triangles.push_back({corners[first], corners[(first + 1) % 3], corners[(first + 2) % 3]});
  }
  for (std::size_t i = other.triangles.size(); i > 1; --i) {
    std::swap(other.triangles[i - 1], other.triangles[random.below(static_cast<std::uint32_t>(i))]);
  }
  return other;
}

// FNV-1a of all bits.
std::uint64_t hash_of(const Decomposition& all) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const Hull& hull : all.hulls) {
    for (const Vec3& vertex : hull.vertices()) {
      for (int axis = 0; axis < 3; ++axis) {
        hash = (hash ^ std::bit_cast<std::uint32_t>(vertex[axis])) * 0x100000001b3u;
      }
    }
    hash = (hash ^ hull.face_count()) * 0x100000001b3u;
  }
  return hash;
}

// Some balls, boxes and Ls, stretched, turned and overlapping.
TestMesh random_heap(Random& random) {
  TestMesh heap;
  for (std::uint32_t count = 1 + random.below(4); count > 0; --count) {
    const TestMesh kinds[] = {box_mesh({1, 0.4f, 0.6f}), ball_mesh(0.8f, 2), l_mesh(), u_mesh(),
                              torus_mesh(1.0, 0.3, 12, 8)};
    TestMesh mesh = kinds[random.below(5)];
    const Vec3 scale{random.between(0.3f, 1), random.between(0.3f, 1), random.between(0.3f, 1)};
    mesh.map([&](Vec3 v) { return Vec3{scale.x * v.x, scale.y * v.y, scale.z * v.z}; });
    const Quat turn = normalize(
        Quat{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1), random.between(0.1f, 1)});
    heap.append(moved(mesh, turn, {random.between(-2, 2), random.between(-2, 2), random.between(-2, 2)}));
  }
  return heap;
}

// Tetrahedra between few points of a small lattice, inside out as often as not: closed, and with flat,
// doubled and crossing triangles, repeated corners and edges of many.
TestMesh random_tangle(Random& random) {
  TestMesh mesh;
  for (int i = 0; i < 10; ++i) {
    mesh.vertices.push_back({static_cast<float>(random.below(3)), static_cast<float>(random.below(3)),
                             static_cast<float>(random.below(3))});
  }
  for (std::uint32_t count = 1 + random.below(8); count > 0; --count) {
    const std::uint32_t a = random.below(10), b = random.below(10), c = random.below(10),
                        d = random.below(10);
    mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {a, c, d}, {a, d, b}, {b, d, c}});
  }
  return mesh;
}

TEST(DecomposeLaws, OrderDoesNotMatter) {
  TestMesh two = star_mesh(3);
  two.append(moved(l_mesh(), odd_rotation(), {2, 0, 0}));
  for (const TestMesh& mesh : {l_mesh(), torus_mesh(1.0, 0.3, 20, 12), two}) {
    const Decomposition once = decompose(mesh, {.resolution = 32});
    for (const std::uint64_t seed : {1u, 2u}) {
      const Decomposition again = decompose(shuffled(mesh, seed), {.resolution = 32});
      EXPECT_TRUE(again.hulls == once.hulls);
      EXPECT_EQ(hash_of(again), hash_of(once));
      EXPECT_EQ(again.report.hulls_from_mesh, once.report.hulls_from_mesh);
      EXPECT_EQ(again.report.mesh_from_hulls, once.report.mesh_from_hulls);
    }
  }
}

TEST(DecomposeLaws, ARepeatedVertexIsOne) {
  const TestMesh mesh = l_mesh();
  TestMesh apart;
  for (const MeshTriangle& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(apart.vertices.size());
    for (const std::uint32_t corner : {t.a, t.b, t.c}) apart.vertices.push_back(mesh.vertices[corner]);
    apart.triangles.push_back({first, first + 1, first + 2});
  }
  apart.vertices.push_back({100, 0, 0});  // that no triangle has
  EXPECT_TRUE(decompose(apart).hulls == decompose(mesh).hulls);
}

TEST(DecomposeLaws, InsideOutIsTheSameSolid) {
  for (TestMesh mesh : {l_mesh(), u_mesh()}) {
    const Decomposition outward = decompose(mesh);
    mesh.flip();
    const Decomposition inward = decompose(mesh);
    ASSERT_EQ(inward.hulls.size(), outward.hulls.size());
    EXPECT_NEAR(inward.report.hull_volume, outward.report.hull_volume, 1e-5);
    EXPECT_EQ(inward.report.mesh_volume, outward.report.mesh_volume);
  }
}

TEST(DecomposeLaws, HasTheSameBitsEverywhere) {
  EXPECT_EQ(hash_of(decompose(moved(u_mesh(), {0, 0, 0.6f, 0.8f}, {1, 2, 3}))), 3750258171744519467u);
  EXPECT_EQ(hash_of(decompose(star_mesh(4), {.resolution = 32})), 13943110554792932060u);
}

TEST(DecomposeLaws, KeepsTheMostParts) {
  for (const int most : {1, 2, 5}) {
    const Decomposition all =
        decompose(torus_mesh(1.0, 0.3, 24, 12), {.max_parts = most, .max_vertices = 256});
    EXPECT_LE(all.hulls.size(), static_cast<std::size_t>(most));
    EXPECT_TRUE(all.report.reached_limit);
    EXPECT_LT(all.report.mesh_from_hulls, 1e-5);
  }
}

TEST(DecomposeLaws, KeepsTheMostVertices) {
  const Decomposition all = decompose(star_mesh(3), {.max_vertices = 12});
  for (const Hull& hull : all.hulls) EXPECT_LE(hull.vertices().size(), 12u);
  EXPECT_GT(all.report.cut_vertices, 0u);
}

TEST(DecomposeLaws, AConcavityInMetersIsTheSameAsItsShare) {
  const TestMesh mesh = torus_mesh(1.0, 0.3, 24, 12);  // 2.6 m
  const Decomposition share = decompose(mesh, {.concavity_share = 0.05f});
  const Decomposition meters = decompose(mesh, {.concavity_share = 0.9f, .concavity = 0.13f});
  EXPECT_NEAR(share.report.concavity, 0.13, 1e-6);
  EXPECT_TRUE(share.hulls == meters.hulls);
}

TEST(DecomposeLaws, MoreConcavityTakesFewerParts) {
  const TestMesh mesh = star_mesh(3);
  std::size_t last = 1000;
  for (const float share : {0.02f, 0.04f, 0.1f, 0.5f}) {
    const Decomposition all = decompose(mesh, {.concavity_share = share});
    EXPECT_LE(all.hulls.size(), last);
    if (!all.report.reached_limit) {
      EXPECT_LE(all.report.hulls_from_mesh, 1.1 * all.report.concavity);
    }
    last = all.hulls.size();
  }
  EXPECT_EQ(last, 1u);
}

TEST(DecomposeLaws, ScalingScalesTheParts) {
  TestMesh mesh = u_mesh();
  const Decomposition once = decompose(mesh);
  mesh.map([](Vec3 v) { return 1024.0f * v; });
  const Decomposition large = decompose(mesh);
  ASSERT_EQ(large.hulls.size(), once.hulls.size());
  for (std::size_t i = 0; i < once.hulls.size(); ++i) {
    EXPECT_EQ(large.hulls[i].volume(), once.hulls[i].volume() * 1024.0f * 1024.0f * 1024.0f);
  }
}

TEST(DecomposeLaws, HullsCoverTheMesh) {
  Random random(7);
  for (int round = 0; round < 12; ++round) {
    SCOPED_TRACE(round);
    const TestMesh mesh = random_heap(random);
    const Decomposition all = decompose(mesh, {.max_vertices = 256, .resolution = 32});
    const DecomposeReport& report = all.report;
    const double size = 50.0 * report.concavity;  // 2% of it
    EXPECT_EQ(report.dropped_parts, 0u);
    EXPECT_LT(report.mesh_from_hulls, 1e-3 * size);
    // Pieces that overlap count twice in both, but in hulls of several pieces once.
    if (inspect_mesh(mesh.vertices, mesh.triangles).parts == 1) {
      EXPECT_GT(report.hull_volume, 0.999 * report.mesh_volume);
    }
    EXPECT_LT(report.hull_volume, 1.35 * report.mesh_volume);
    if (!report.reached_limit) {
      EXPECT_LE(report.hulls_from_mesh, 1.5 * report.concavity);
    }
  }
}

TEST(DecomposeLaws, AnyClosedMeshIsDecomposedOrRefused) {
  Random random(11);
  int done = 0;
  for (int round = 0; round < 100; ++round) {
    SCOPED_TRACE(round);
    const TestMesh mesh = random_tangle(random);
    try {
      const Decomposition all = decompose(mesh, {.max_parts = 8, .resolution = 16});
      ASSERT_FALSE(all.hulls.empty());
      EXPECT_LE(all.hulls.size(), 8u);
      for (const Hull& hull : all.hulls) EXPECT_GT(hull.volume(), 0.0f);
      ++done;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("decompose: "), std::string::npos) << error.what();
    }
  }
  EXPECT_GT(done, 50);
}

TEST(DecomposeLaws, ManyPiecesAreTakenTogether) {
  TestMesh heap;
  for (int i = 0; i < 200; ++i) {
    heap.append(
        moved(box_mesh({0.2f, 0.2f, 0.2f}), {0, 0, 0, 1},
              {static_cast<float>(i % 10), static_cast<float>(i / 10 % 10), static_cast<float>(i / 100)}));
  }
  const Decomposition all = decompose(heap, {.max_parts = 20, .resolution = 32});
  EXPECT_LE(all.hulls.size(), 20u);
  EXPECT_EQ(all.report.joined_pieces, 200u - 64u);
  EXPECT_TRUE(all.report.reached_limit);
  EXPECT_LT(all.report.mesh_from_hulls, 1e-5);
}

TEST(DecomposeLaws, BackToBackTrianglesAreLeftOut) {
  TestMesh mesh = box_mesh({1, 1, 1});
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {{5, 0, 0}, {6, 0, 0}, {5, 1, 0}});
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 1});
  mesh.triangles.push_back({0, 0, 1});
  const Decomposition all = decompose(mesh);
  EXPECT_EQ(all.hulls.size(), 1u);
  EXPECT_EQ(all.report.dropped_triangles, 3u);
  EXPECT_NEAR(all.report.hull_volume, 8.0, 1e-6);
}

}  // namespace
}  // namespace scree
