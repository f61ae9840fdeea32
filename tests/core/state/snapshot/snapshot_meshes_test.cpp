// Laws of meshes as bytes: what is written comes back, and what no mesh can be made of is refused.
#include <core/geometry/mesh/mesh_build.h>
#include <core/state/snapshot/snapshot_meshes.h>
#include <gtest/gtest.h>
#include <scree/error.h>
#include <tests/core/geometry/mesh/meshes.h>

#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace scree {
namespace {

using Bytes = std::vector<std::byte>;

MeshPointer make_mesh() {
  test_solids::TestMesh ring = test_solids::torus_mesh(5, 2, 9, 6);
  ring.triangles.insert(ring.triangles.begin() + 3, {1, 1, 2});
  std::vector<std::uint8_t> surface(ring.triangles.size(), 255);
  surface[5] = 1;
  const Material materials[2]{{}, {.friction = 0.25f, .restitution = 0.5f}};
  const TriangleMesh mesh(ring.vertices, ring.triangles, {surface, materials});
  return MeshAccess::solid(mesh);
}

Bytes bytes_of(const std::vector<SharedMesh>& meshes) {
  ByteWriter writer;
  write_meshes(meshes, writer);
  return writer.take();
}
std::vector<SharedMesh> read(const Bytes& bytes) {
  ByteReader reader(bytes);
  std::vector<SharedMesh> meshes = read_meshes(reader);
  EXPECT_EQ(reader.left(), 0u);
  return meshes;
}
std::string refusal(const Bytes& bytes) {
  try {
    read(bytes);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(SnapshotMeshes, ComeBackAsTheyWere) {
  const MeshPointer ring = make_mesh();
  const test_solids::TestMesh box = test_solids::box_mesh({1, 2, 3});
  const TriangleMesh plain(box.vertices, box.triangles);
  const std::vector<SharedMesh> meshes{{ring}, {nullptr}, {MeshAccess::solid(plain)}, {ring}};
  const Bytes bytes = bytes_of(meshes);
  const std::vector<SharedMesh> back = read(bytes);
  ASSERT_EQ(back.size(), 4u);
  EXPECT_EQ(back[1].solid, nullptr);
  EXPECT_EQ(back[3].solid, back[0].solid);
  for (const std::size_t slot : {0u, 2u}) {
    EXPECT_TRUE(equal(*back[slot].solid, *meshes[slot].solid));
    const TriangleMeshReport &a = back[slot].solid->report, &b = meshes[slot].solid->report;
    EXPECT_EQ(a.given.edges, b.given.edges);
    EXPECT_EQ(a.given.repeated_corners, b.given.repeated_corners);
    EXPECT_EQ(a.given.parts, b.given.parts);
    EXPECT_EQ(a.given.upper, b.given.upper);
    EXPECT_EQ(a.merged_vertices, b.merged_vertices);
    EXPECT_EQ(a.dropped_triangles, b.dropped_triangles);
  }
  EXPECT_EQ(bytes_of(back), bytes);
}

TEST(SnapshotMeshes, AreRefusedAtEveryLength) {
  const Bytes whole = bytes_of({{make_mesh()}});
  for (std::size_t length = 0; length < whole.size(); ++length)
    EXPECT_NE(refusal(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length))), "");
}

TEST(SnapshotMeshes, AreRefusedWithTheReason) {
  const Bytes whole = bytes_of({{make_mesh()}});
  const auto refused = [&](std::size_t at, auto value) {
    Bytes wrong = whole;
    std::memcpy(wrong.data() + at, &value, sizeof value);
    return refusal(wrong);
  };
  constexpr std::size_t kCounts = 4, kOrigin = 20, kReport = 44, kVertices = 164, kTriangles = 164 + 54 * 12;
  const auto has = [](const std::string& message, const char* part) {
    return message.find(part) != std::string::npos;
  };
  EXPECT_TRUE(has(refused(kCounts, 0x7fffffffu), "longer than what follows"));
  EXPECT_TRUE(has(refused(kCounts + 8, 256u), "wrong number of materials"));
  EXPECT_TRUE(has(refused(kCounts + 12, 2u), "wrong number of materials"));
  EXPECT_TRUE(has(refused(kOrigin, 1e9), "the center of a mesh is out of range"));
  EXPECT_TRUE(has(refused(kReport + 8, std::uint64_t{3}), "counts other triangles"));
  EXPECT_TRUE(has(refused(kReport + 96, std::numeric_limits<float>::infinity()), "is not finite"));
  EXPECT_TRUE(has(refused(kVertices, std::numeric_limits<float>::quiet_NaN()), "coordinate x of vertex 0"));
  EXPECT_TRUE(has(refused(kTriangles, 54u), "has a corner at vertex 54"));
  EXPECT_TRUE(has(refused(whole.size() - 4, 1), "a slot of meshes names no mesh"));
  EXPECT_TRUE(has(refused(whole.size() - 4, -2), "a slot of meshes names no mesh"));
}

// Whatever is accepted is a mesh whose indices and numbers kernels can rely on.
TEST(SnapshotMeshes, ArbitraryBytesMakeSoundMeshesOrNone) {
  const Bytes whole = bytes_of({{make_mesh()}});
  std::mt19937 random(3);
  int accepted = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    Bytes wrong = whole;
    for (unsigned i = 0; i <= random() % 3; ++i)
      wrong[random() % wrong.size()] ^= static_cast<std::byte>(1u << random() % 8);
    std::vector<SharedMesh> meshes;
    try {
      ByteReader reader(wrong);
      meshes = read_meshes(reader);
    } catch (const Error&) {
      continue;
    }
    ++accepted;
    for (const SharedMesh& mesh : meshes) {
      if (mesh.solid == nullptr) continue;
      const MeshData& data = mesh.solid->data;
      for (std::int32_t i = 0; i < data.triangle_count; ++i) {
        for (const std::int32_t vertex : data.corners[i].vertex) {
          ASSERT_GE(vertex, 0);
          ASSERT_LT(vertex, data.vertex_count);
        }
        if (data.material != nullptr) {
          ASSERT_TRUE(data.material[i] == kShapeMaterial || data.material[i] < 2);
        }
      }
      for (std::int32_t i = 0; i < 3 * data.vertex_count; ++i) ASSERT_LE(std::abs(data.vertex[i]), 4e5f);
    }
  }
  EXPECT_GT(accepted, 100);
}

}  // namespace
}  // namespace scree
