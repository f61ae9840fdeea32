// What is known of simple shapes: how many parts they have, and how well these fit.
#include <gtest/gtest.h>
#include <scree/decompose.h>
#include <tests/core/geometry/decompose/shapes.h>

#include <algorithm>
#include <cmath>

namespace scree {
namespace {

using namespace test_solids;

Decomposition decomposed(const TestMesh& mesh, const DecomposeOptions& options = {}) {
  return scree::decompose(mesh.vertices, mesh.triangles, options);
}

// m: how far above one of the planes of its faces a point lies at most. The distance from the hull is no
// less.
double height_above(const Hull& hull, Vec3 point) {
  double height = -1e30;
  for (std::size_t f = 0; f < hull.face_count(); ++f) {
    const auto face = hull.face(f);
    const Vec3 a = hull.vertices()[face[0]], b = hull.vertices()[face[1]], c = hull.vertices()[face[2]];
    const Vec3 normal = normalize(cross(b - a, c - a));
    height = std::max(height, static_cast<double>(dot(normal, point - a)));
  }
  return height;
}

double height_above(const Decomposition& all, Vec3 point) {
  double least = 1e30;
  for (const Hull& hull : all.hulls) least = std::min(least, height_above(hull, point));
  return least;
}

void expect_exact(const Decomposition& all, std::size_t parts, double volume) {
  EXPECT_EQ(all.hulls.size(), parts);
  EXPECT_NEAR(all.report.hull_volume, volume, 1e-5 * volume);
  EXPECT_NEAR(all.report.mesh_volume, volume, 1e-5 * volume);
  EXPECT_LT(all.report.distance(), 1e-5);
  EXPECT_EQ(all.report.dropped_parts, 0u);
  EXPECT_FALSE(all.report.reached_limit);
}

TEST(Decompose, LeavesABoxWhole) {
  const Decomposition all = decomposed(box_mesh({1, 2, 3}));
  expect_exact(all, 1, 48);
  EXPECT_EQ(all.hulls[0].face_count(), 6u);
  EXPECT_EQ(all.report.cuts, 0u);
}

TEST(Decompose, MakesTwoBoxesOfAnL) {
  const Decomposition all = decomposed(l_mesh());
  expect_exact(all, 2, kVolumeOfL);
  for (const Hull& hull : all.hulls) EXPECT_EQ(hull.face_count(), 6u);
}

TEST(Decompose, MakesThreeBoxesOfAU) {
  const Decomposition all = decomposed(u_mesh());
  expect_exact(all, 3, kVolumeOfU);
  for (const Hull& hull : all.hulls) EXPECT_EQ(hull.face_count(), 6u);
}

TEST(Decompose, FindsTheFacesOfTurnedShapes) {
  expect_exact(decomposed(moved(l_mesh(), odd_rotation(), {3, 1, 2})), 2, kVolumeOfL);
  expect_exact(decomposed(moved(u_mesh(), odd_rotation(), {-5, 0, 2})), 3, kVolumeOfU);
}

TEST(Decompose, KeepsTheHoleOfATorus) {
  const Decomposition all = decomposed(torus_mesh(1.0, 0.3, 64, 32), {.max_vertices = 128});
  EXPECT_GE(all.hulls.size(), 8u);
  EXPECT_LE(all.hulls.size(), 20u);
  EXPECT_NEAR(all.report.hull_volume, all.report.mesh_volume, 0.04 * all.report.mesh_volume);
  EXPECT_LE(all.report.hulls_from_mesh, 1.1 * all.report.concavity);
  EXPECT_GT(height_above(all, {0, 0, 0}), 0.55);
}

TEST(Decompose, KeepsTheCavityOfACup) {
  const Decomposition all = decomposed(cup_mesh());
  EXPECT_LE(all.hulls.size(), 32u);
  // A ball of radius 0.8 lies in it, where 0.9 is the most.
  EXPECT_GT(height_above(all, {0, 1.1f, 0}), 0.8);
  EXPECT_LT(all.report.mesh_from_hulls, 0.02);
  EXPECT_LE(all.report.hulls_from_mesh, 1.1 * all.report.concavity);
}

TEST(Decompose, KeepsTheBumpsOfAStar) {
  const Decomposition all = decomposed(star_mesh(4));
  EXPECT_LE(all.hulls.size(), 32u);
  EXPECT_LE(all.report.hulls_from_mesh, 1.1 * all.report.concavity);
  EXPECT_LT(all.report.mesh_from_hulls, all.report.concavity);
  EXPECT_NEAR(all.report.hull_volume, all.report.mesh_volume, 0.1 * all.report.mesh_volume);
}

TEST(Decompose, MakesTwoPartsOfTwoBalls) {
  TestMesh mesh = ball_mesh(1.0f, 3);
  mesh.append(moved(ball_mesh(1.0f, 3), odd_rotation(), {1.2f, 1.3f, 1.4f}));  // their bounds overlap
  const Decomposition all = decomposed(mesh, {.max_vertices = 256});
  EXPECT_EQ(all.hulls.size(), 2u);
  EXPECT_EQ(all.report.cuts, 0u);
  EXPECT_NEAR(all.report.hull_volume, all.report.mesh_volume, 0.02 * all.report.mesh_volume);
}

TEST(Decompose, KeepsOverlappingPiecesApart) {
  TestMesh cross = box_mesh({3, 0.5f, 0.5f});
  cross.append(box_mesh({0.5f, 3, 0.5f}));
  cross.append(box_mesh({0.5f, 0.5f, 3}));
  const Decomposition all = decomposed(cross);
  EXPECT_EQ(all.hulls.size(), 3u);
  EXPECT_LT(all.report.distance(), 1e-6);
  EXPECT_NEAR(all.report.hull_volume, 18.0, 1e-4);
}

TEST(Decompose, KeepsAHollowEmpty) {
  TestMesh shell = box_mesh({2, 2, 2}), hollow = box_mesh({1.5f, 1.5f, 1.5f});
  hollow.flip();
  shell.append(hollow);
  const Decomposition all = decomposed(shell);
  EXPECT_EQ(all.hulls.size(), 6u);
  EXPECT_NEAR(all.report.hull_volume, 64.0 - 27.0, 1e-3);
  EXPECT_GT(height_above(all, {0, 0, 0}), 1.499);
}

TEST(Decompose, GivesTheMassOfTheMesh) {
  const TestMesh mesh = moved(l_mesh(), odd_rotation(), {1, 0, 0});
  double volume = 0.0;
  Vec3 moment{};
  for (const Hull& hull : decomposed(mesh).hulls) {
    volume += static_cast<double>(hull.volume());
    moment = moment + hull.volume() * hull.centroid();
  }
  const MassProperties mass = mesh_mass(mesh.vertices, mesh.triangles, 1.0f);
  EXPECT_NEAR(volume, static_cast<double>(mass.mass), 1e-4);
  const Vec3 center = static_cast<float>(1.0 / volume) * moment;
  EXPECT_LT(length(center - mass.center), 1e-5f);
}

}  // namespace
}  // namespace scree
