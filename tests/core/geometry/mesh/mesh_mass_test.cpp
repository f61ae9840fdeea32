// Laws of the mass of closed meshes, held to formulas and to hulls.
#include <gtest/gtest.h>
#include <scree/error.h>
#include <scree/hull.h>
#include <scree/world.h>
#include <tests/core/geometry/mesh/meshes.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace scree {
namespace {

using test_solids::TestMesh;

constexpr double kPi = 3.14159265358979323846;

MassProperties mass_of(const TestMesh& mesh, float density = 1000.0f) {
  return mesh_mass(mesh.vertices, mesh.triangles, density);
}

std::string mass_refusal(const TestMesh& mesh, float density = 1000.0f) {
  try {
    mass_of(mesh, density);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

float largest(const MassProperties& mass) {
  return std::max({mass.inertia[0], mass.inertia[1], mass.inertia[2]});
}

void expect_near(const MassProperties& mass, const MassProperties& truth, float tolerance, float reach) {
  EXPECT_NEAR(mass.mass, truth.mass, tolerance * truth.mass);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(mass.center[i], truth.center[i], tolerance * reach) << i;
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(mass.inertia[i], truth.inertia[i], tolerance * largest(truth)) << i;
}

float uniform(std::mt19937& random, float low, float high) {
  return std::uniform_real_distribution<float>(low, high)(random);
}

TEST(MeshMass, OfABoxIsThatOfTheFormula) {
  const MassProperties mass = mass_of(test_solids::box_mesh({1, 2, 3}), 2.0f);
  EXPECT_EQ(mass.mass, 96.0f);
  EXPECT_EQ(mass.center, Vec3{});
  const float truth[6] = {32 * 13, 32 * 10, 32 * 5, 0, 0, 0};
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(mass.inertia[i], truth[i], 1e-4f) << i;
}

TEST(MeshMass, OfATorusApproachesTheFormula) {
  // Of N by N quads, the error falls by N^-2.
  const double ring = 2.0, tube = 0.5;
  const double truth = 2 * kPi * kPi * ring * tube * tube;
  const double axial = truth * (ring * ring + 0.75 * tube * tube);
  const double across = truth * (0.5 * ring * ring + 0.625 * tube * tube);
  double last[3]{};
  for (const std::uint32_t n : {32u, 64u, 128u}) {
    const MassProperties mass = mass_of(test_solids::torus_mesh(ring, tube, n, n), 1.0f);
    const double errors[3] = {truth - mass.mass, axial - mass.inertia[1], across - mass.inertia[0]};
    for (int i = 0; i < 3; ++i) {
      EXPECT_GT(errors[i], 0.0);
      if (n > 32) {
        EXPECT_NEAR(last[i] / errors[i], 4.0, 0.15) << i << " " << n;
      }
      last[i] = errors[i];
    }
  }
  EXPECT_LT(last[0] / truth, 1e-3);
}

TEST(MeshMass, OfABallApproachesTheFormula) {
  const double truth = 4.0 / 3.0 * kPi * 8.0;
  const MassProperties mass = mass_of(test_solids::ball_mesh(2.0f, 5), 1.0f);
  EXPECT_NEAR(mass.mass / truth, 1.0, 1.5e-3);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(mass.inertia[i] / (0.4 * 4.0 * truth), 1.0, 2.5e-3);
}

TEST(MeshMass, FarFromTheOriginIsTheSame) {
  TestMesh mesh = test_solids::torus_mesh(2.0, 0.5, 24, 12);
  mesh.map([](Vec3 v) {
    return Vec3{std::round(v.x * 64) / 64, std::round(v.y * 64) / 64, std::round(v.z * 64) / 64};
  });
  const MassProperties near = mass_of(mesh);
  const Vec3 way{65536, -32768, 16384};  // coordinates stay exact
  mesh.map([&](Vec3 v) { return v + way; });
  MassProperties far = mass_of(mesh);
  far.center = far.center - way;
  expect_near(far, near, 1e-2f, 1.0f);  // of the center: coordinates have steps of 1/128 m there
  far.center = near.center;
  expect_near(far, near, 1e-6f, 1.0f);
}

TEST(MeshMass, TurnsWithTheMesh) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 20; ++trial) {
    TestMesh mesh = test_solids::box_mesh({1, 2, 3});
    const MassProperties mass = mass_of(mesh);
    const float x = uniform(random, -1, 1), y = uniform(random, -1, 1);
    const float z = uniform(random, -1, 1), angle = uniform(random, -3, 3);
    const Quat turn = from_axis_angle({x, y, z}, angle);
    mesh.map([&](Vec3 v) { return rotate(turn, v); });
    const PrincipalAxes axes = principal_axes(mass_of(mesh));
    const float truth[3] = {mass.inertia[2], mass.inertia[1], mass.inertia[0]};
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(axes.moments[i] / truth[i], 1.0, 1e-5);
    // The longest half extent lies along the axis of the least moment.
    EXPECT_NEAR(std::abs(dot(rotate(axes.rotation, {1, 0, 0}), rotate(turn, {0, 0, 1}))), 1.0, 1e-5);
  }
}

TEST(MeshMass, AHollowIsTakenOff) {
  TestMesh shell = test_solids::box_mesh({2, 2, 2}), hollow = test_solids::box_mesh({1, 1, 1});
  hollow.flip();
  hollow.map([](Vec3 v) { return v + Vec3{0.5f, 0, 0}; });
  shell.append(hollow);
  const MassProperties mass = mass_of(shell, 1.0f);
  EXPECT_NEAR(mass.mass, 64.0f - 8.0f, 1e-5f);
  EXPECT_NEAR(mass.center.x, -8.0f * 0.5f / 56.0f, 1e-6f);
}

TEST(MeshMass, InsideOutIsTheSame) {
  TestMesh mesh = test_solids::torus_mesh(2.0, 0.5, 16, 16);
  mesh.map([](Vec3 v) { return v + Vec3{0.3f, 1.0f, -2.0f}; });
  const MassProperties mass = mass_of(mesh);
  mesh.flip();
  expect_near(mass_of(mesh), mass, 1e-6f, 1.0f);
  EXPECT_GT(mass.mass, 0.0f);
}

TEST(MeshMass, AgreesWithHullsOfRandomPoints) {
  std::mt19937 random(11);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Vec3> points;
    for (int i = 0; i < 40; ++i) {
      const float x = uniform(random, -3, 3);
      const float y = uniform(random, -1, 1);
      const float z = uniform(random, 4, 5);
      points.push_back({x, y, z});
    }
    const Hull hull(points);
    TestMesh mesh;
    mesh.vertices.assign(hull.vertices().begin(), hull.vertices().end());
    for (std::size_t f = 0; f < hull.face_count(); ++f) {
      const auto loop = hull.face(f);
      for (std::size_t k = 1; k + 1 < loop.size(); ++k)
        mesh.triangles.push_back({loop[0], loop[k], loop[k + 1]});
    }
    World world;
    const BodyId body = world.create_body({});
    world.add_shape(body, ConvexHull{.hull = hull}, {.density = 500.0f});
    expect_near(mass_of(mesh, 500.0f), world.mass_properties(body), 2e-5f, 5.0f);
  }
}

TEST(MeshMass, IsTakenByBodies) {
  const MassProperties mass = mass_of(test_solids::torus_mesh(0.5, 0.1, 24, 12));
  World world;
  const BodyId body = world.create_body({});
  world.set_mass_properties(body, mass);
  EXPECT_EQ(world.mass_properties(body).mass, mass.mass);
}

TEST(MeshMass, RefusesWhatEnclosesNothing) {
  TestMesh open = test_solids::box_mesh({1, 1, 1});
  open.triangles.pop_back();
  EXPECT_EQ(mass_refusal(open),
            "mesh_mass: the mesh is not closed: of 18 edges 3 are open and 0 are between triangles that look "
            "to different sides");
  TestMesh leaf{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}};
  EXPECT_EQ(mass_refusal(leaf), "mesh_mass: the mesh encloses no volume");
  TestMesh far_leaf = leaf;
  far_leaf.map([](Vec3 v) { return v + Vec3{1e5f - 1, 1e5f - 1, 7}; });
  EXPECT_EQ(mass_refusal(far_leaf), "mesh_mass: the mesh encloses no volume");
  EXPECT_EQ(mass_refusal({}), "mesh_mass: the mesh has no triangles");
}

TEST(MeshMass, RefusesMassesBeyondTheLimits) {
  const TestMesh box = test_solids::box_mesh({1, 1, 1});
  EXPECT_EQ(mass_refusal(box, 0.0f), "mesh_mass: density is 0, must lie in [9.99999997e-07, 1e+09]");
  EXPECT_NE(mass_refusal(box, std::nanf("")).find("density is nan"), std::string::npos);
  EXPECT_NE(mass_refusal(test_solids::box_mesh({1e-6f, 1e-6f, 1e-6f}), 1e-6f).find("the mass is 7.99"),
            std::string::npos);
}

}  // namespace
}  // namespace scree
