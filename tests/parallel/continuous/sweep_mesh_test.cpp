// Laws of triangles that are listed once for all balls of a body: its balls meet the same triangle at the
// same time as if each walked through the mesh.
#include <core/geometry/mesh/mesh_build.h>
#include <core/world/math.h>
#include <parallel/continuous/sweep_mesh.h>
#include <scree/height_field.h>
#include <tests/simd/all_kernels.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace scree::sweeps {
namespace {

class SweepMesh : public ::testing::Test {
 protected:
  static constexpr int kSide = 60;
  std::mt19937 random{1};
  const TriangleMesh mesh = hills();
  const MeshData& data = MeshAccess::solid(mesh)->data;

  float between(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random); }
  Vec3 point(float reach, float height) {
    return {between(-reach, reach), between(-height, height), between(-reach, reach)};
  }
  TriangleMesh hills() {
    std::vector<float> heights;
    for (int i = 0; i < kSide * kSide; ++i) heights.push_back(between(-0.3f, 0.3f));
    return height_field_mesh({.columns = kSide, .rows = kSide, .heights = heights});
  }
  PoseRow pose() {
    PoseRow row{};
    const Quat q = normalize(Quat{between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1)});
    const float rotation[4] = {q.x, q.y, q.z, q.w};
    std::copy(rotation, rotation + 4, row.rotation);
    for (float& place : row.position) place = between(-50.0f, 50.0f);
    return row;
  }
};

TEST_F(SweepMesh, BallsMeetListedTrianglesAsTheyMeetTheMesh) {
  int met = 0, listed = 0, crowded = 0, empty = 0;
  const std::vector<const simd::Kernels*> sets = kernel_tests::all_kernels();
  for (int body = 0; body < 400; ++body) {
    const simd::QueryKernels& kernels = sets[static_cast<std::size_t>(body) % sets.size()]->query;
    const PoseRow at = pose();
    const Quat rotation{at.rotation[0], at.rotation[1], at.rotation[2], at.rotation[3]};
    const Vec3 origin{at.position[0], at.position[1], at.position[2]};
    const auto place = [&](Vec3 local) { return origin + rotate(rotation, local); };
    const Vec3 from = point(20.0f, 1.5f), way = point(1.5f, 3.0f);
    const float reach = between(0.05f, 2.0f);
    NearTriangles near;
    list_near_triangles(kernels, data, at, {place(from), place(from + way), reach}, near);
    (near.too_many ? crowded : near.count > 0 ? listed : empty) += 1;
    EXPECT_EQ(near.count > 0,
              is_near_mesh(kernels, data, at, {place(from), place(from + way), reach}, nullptr));
    for (int ball = 0; ball < 8; ++ball) {
      const float radius = reach * between(0.1f, 0.5f);
      const Vec3 arm = (0.99f * (reach - radius)) * normalize(point(1.0f, 1.0f));
      const Vec3 start = place(from + arm), end = place(from + way + arm);
      for (const Against against : {Against::touched, Against::others, Against::all}) {
        const Sweep sweep{0, start, start, end, radius, 0.0f, against, {start, end, kCoreShare * radius}};
        const Meeting walked = meeting_with_mesh(kernels, data, at, sweep, 7, nullptr);
        const Meeting met_listed = meeting_with_mesh(kernels, data, at, sweep, 7, &near);
        EXPECT_EQ(walked.time, met_listed.time);
        EXPECT_EQ(walked.obstacle, met_listed.obstacle);
        EXPECT_EQ(walked.normal, met_listed.normal);
        met += walked.time < kNever ? 1 : 0;
      }
      const MeshReach part{start, end, radius};
      EXPECT_EQ(is_near_mesh(kernels, data, at, part, nullptr), is_near_mesh(kernels, data, at, part, &near));
    }
  }
  EXPECT_GT(met, 200);
  EXPECT_GT(listed, 50);
  EXPECT_GT(crowded, 20);
  EXPECT_GT(empty, 20);
}

TEST_F(SweepMesh, NoBallMeetsATriangleThatWasDropped) {
  int met = 0, kept = 0, dropped = 0;
  const std::vector<const simd::Kernels*> sets = kernel_tests::all_kernels();
  for (int body = 0; body < 3000; ++body) {
    const simd::QueryKernels& kernels = sets[static_cast<std::size_t>(body) % sets.size()]->query;
    const PoseRow at = pose();
    const Quat rotation{at.rotation[0], at.rotation[1], at.rotation[2], at.rotation[3]};
    const Vec3 origin{at.position[0], at.position[1], at.position[2]};
    const auto place = [&](Vec3 local) { return origin + rotate(rotation, local); };
    const Vec3 from = point(20.0f, 1.0f), way = point(0.5f, 1.0f);
    const float reach = between(0.05f, 0.5f);
    NearTriangles near;
    list_near_triangles(kernels, data, at, {place(from), place(from + way), reach}, near);
    if (near.too_many) continue;
    Sweep sweeps[3];
    Ball ends[3];
    for (int ball = 0; ball < 3; ++ball) {
      const float radius = reach * between(0.1f, 0.5f);
      const Vec3 arm = (0.99f * (reach - radius)) * normalize(point(1.0f, 1.0f));
      const Vec3 start = place(from + arm), end = place(from + way + arm);
      sweeps[ball] = {0, start, start, end, radius, 0.0f, Against::all, {start, end, kCoreShare * radius}};
      ends[ball] = {end, radius};
    }
    NearTriangles left = near;
    drop_triangles_below(data, at, ends, 1e-4f, left);
    kept += left.count;
    dropped += near.count - left.count;
    for (Sweep& sweep : sweeps) {
      for (const Against against : {Against::touched, Against::others, Against::all}) {
        sweep.against = against;
        const Meeting of_all = meeting_with_mesh(kernels, data, at, sweep, 7, &near);
        const Meeting of_left = meeting_with_mesh(kernels, data, at, sweep, 7, &left);
        EXPECT_EQ(of_all.time, of_left.time);
        EXPECT_EQ(of_all.normal, of_left.normal);
        met += of_all.time < kNever ? 1 : 0;
      }
    }
  }
  EXPECT_GT(met, 500);
  EXPECT_GT(kept, 2000);
  EXPECT_GT(dropped, 2000);
}

TEST_F(SweepMesh, NoWayInAFreeBoxHasTrianglesNear) {
  int free = 0, near = 0;
  const std::vector<const simd::Kernels*> sets = kernel_tests::all_kernels();
  for (int round = 0; round < 2000; ++round) {
    const simd::QueryKernels& kernels = sets[static_cast<std::size_t>(round) % sets.size()]->query;
    const PoseRow at = pose();
    const Quat rotation{at.rotation[0], at.rotation[1], at.rotation[2], at.rotation[3]};
    const Vec3 origin{at.position[0], at.position[1], at.position[2]};
    const Vec3 middle = origin + rotate(rotation, point(25.0f, 4.0f));
    Swept box({1e9f, 1e9f, 1e9f}, {-1e9f, -1e9f, -1e9f});
    bool any = false;
    for (int way = 0; way < 8; ++way) {
      const Vec3 start = middle + point(1.0f, 1.0f), end = start + point(0.5f, 0.5f);
      const float radius = between(0.0f, 0.5f);
      const Swept around(start, end, radius);
      for (int axis = 0; axis < 3; ++axis) {
        box.lower[axis] = std::min(box.lower[axis], around.lower[axis]);
        box.upper[axis] = std::max(box.upper[axis], around.upper[axis]);
      }
      any = any || is_near_mesh(kernels, data, at, {start, end, radius}, nullptr);
    }
    const bool is_free = !is_near_mesh(kernels, data, at, box);
    free += is_free ? 1 : 0;
    near += any ? 1 : 0;
    ASSERT_FALSE(is_free && any) << "round " << round;
  }
  EXPECT_GT(free, 100);
  EXPECT_GT(near, 500);
}

}  // namespace
}  // namespace scree::sweeps
