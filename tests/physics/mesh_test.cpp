// Bodies on triangle meshes: as on the smooth surfaces that these stand for.
#include <tests/physics/lab.h>
#include <tools/scenes/builders.h>
#include <tools/scenes/hulls.h>
#include <tools/scenes/random.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

namespace scree::physics {
namespace {

struct Surface {
  std::vector<Vec3> vertices;
  std::vector<MeshTriangle> triangles;

  TriangleMesh mesh() const { return TriangleMesh(vertices, triangles); }
};

// A flat square of cells with corners moved at random within it, and diagonals drawn at random.
Surface flat_surface(int cells, float half_width, std::uint64_t seed) {
  Surface surface;
  scenes::Random random(seed);
  const auto side = static_cast<std::uint32_t>(cells) + 1;
  const float cell = 2.0f * half_width / static_cast<float>(cells);
  for (std::uint32_t row = 0; row < side; ++row) {
    for (std::uint32_t column = 0; column < side; ++column) {
      const bool inner = row > 0 && column > 0 && row + 1 < side && column + 1 < side;
      const float jitter = inner ? 0.35f * cell : 0.0f;
      surface.vertices.push_back(
          {cell * static_cast<float>(column) - half_width + random.between(-jitter, jitter), 0.0f,
           cell * static_cast<float>(row) - half_width + random.between(-jitter, jitter)});
    }
  }
  for (std::uint32_t row = 0; row + 1 < side; ++row) {
    for (std::uint32_t column = 0; column + 1 < side; ++column) {
      const std::uint32_t a = row * side + column, b = a + 1, c = a + side, d = c + 1;
      const bool turned = random.below(2) == 0;
      surface.triangles.push_back(turned ? MeshTriangle{a, c, b} : MeshTriangle{a, c, d});
      surface.triangles.push_back(turned ? MeshTriangle{b, c, d} : MeshTriangle{a, d, b});
    }
  }
  return surface;
}

// The six sides of a box, seen from outside, or from inside.
Surface box_surface(Vec3 half, bool inward) {
  Surface surface;
  for (const float x : {-half.x, half.x}) {
    for (const float y : {-half.y, half.y}) {
      for (const float z : {-half.z, half.z}) surface.vertices.push_back({x, y, z});
    }
  }
  constexpr std::uint32_t kSides[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                          {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
  for (const auto& side : kSides) {
    MeshTriangle one{side[0], side[1], side[2]}, other{side[0], side[2], side[3]};
    if (inward) std::swap(one.b, one.c), std::swap(other.b, other.c);
    surface.triangles.push_back(one);
    surface.triangles.push_back(other);
  }
  return surface;
}

BodyId add_mesh(Lab& lab, const TriangleMesh& mesh, const Material& material = {}, const Pose& pose = {}) {
  return lab.add({.type = BodyType::fixed, .position = pose.position, .rotation = pose.rotation}, mesh,
                 material);
}

struct Slider {
  const char* name;
  Geometry geometry;
  float height;  // of its center over the floor, m
};
std::vector<Slider> sliders() {
  return {
      {"box", Box{{0.4f, 0.2f, 0.3f}}, 0.2f},
      {"ball", Sphere{0.25f}, 0.25f},
      {"small ball", Sphere{0.02f}, 0.02f},
      {"lying capsule", Capsule{0.3f, 0.15f}, 0.15f},
      {"hull", ConvexHull{.hull = Hull(scenes::box_points({0.3f, 0.25f, 0.3f}))}, 0.25f},
      {"long box", Box{{1.5f, 0.05f, 0.1f}}, 0.05f},
      {"prism", ConvexHull{.hull = Hull(scenes::moved(scenes::prism_points(12, 0.3f, 0.4f), {0, -0.2f, 0}))},
       0.2f}};
}

// Slow ones keep their contacts for some steps.
TEST(Mesh, NothingThatSlidesOverSeamsIsBumped) {
  const TriangleMesh floor = flat_surface(60, 30.0f, 7).mesh();
  for (const Slider& slider : sliders()) {
    for (const auto& [degrees, speed] :
         {std::pair{0.0, 10.0f}, {17.0, 10.0f}, {90.0, 10.0f}, {211.0, 10.0f}, {17.0, 0.3f}, {211.0, 0.1f}}) {
      Lab lab;
      add_mesh(lab, floor, {.friction = 0.0f});
      const double angle = degrees * 3.14159265358979 / 180.0;
      const Vec3 along{static_cast<float>(std::cos(angle)), 0.0f, static_cast<float>(std::sin(angle))};
      const bool lies = slider.name == std::string("lying capsule");
      const Quat turn = rotation_about({0, 1, 0}, angle + 0.3);
      const BodyDef def{.position = -20.0f * along + Vec3{0.0f, slider.height, 0.0f},
                        .rotation = lies ? rotation_about({0, 0, 1}, 1.57079633) : turn,
                        .linear_velocity = speed * along,
                        .can_sleep = false};
      const BodyId body = lab.add(def, slider.geometry, {.friction = 0.0f});
      lab.run(30);  // settles into the floor's spring
      double bump = 0.0, turned = 0.0;
      for (int i = 0; i < 180; ++i) {
        lab.run(1);
        bump = std::max(bump, std::abs(lab.velocity(body).y()));
        turned = std::max(turned, lab.spin(body).norm());
      }
      EXPECT_LT(bump, 1e-3) << slider.name << " at " << degrees << " degrees and " << speed << " m/s";
      EXPECT_LT(turned, 1e-2) << slider.name << " at " << degrees << " degrees and " << speed << " m/s";
      EXPECT_NEAR(lab.velocity(body).norm(), double(speed), 1e-3)
          << slider.name << " at " << degrees << " degrees";
    }
  }
}

TEST(Mesh, ABoxSlidesDownAnInclineAsOnAPlane) {
  const TriangleMesh floor = flat_surface(40, 20.0f, 3).mesh();
  constexpr double kAngle = 0.5, kFriction = 0.3;
  Lab lab;
  const Quat tilt = rotation_about({0, 0, 1}, -kAngle);
  add_mesh(lab, floor, {.friction = static_cast<float>(kFriction)}, {{}, tilt});
  const Eigen::Vector3d start = to_eigen(tilt) * Eigen::Vector3d(-10, 0.25, 0);
  const BodyId box = lab.add({.position = {static_cast<float>(start.x()), static_cast<float>(start.y()),
                                           static_cast<float>(start.z())},
                              .rotation = tilt},
                             Box{{0.5f, 0.25f, 0.5f}}, {.friction = static_cast<float>(kFriction)});
  lab.run(120);
  const double expected = kGravity * (std::sin(kAngle) - kFriction * std::cos(kAngle)) * 2.0;
  EXPECT_NEAR(lab.velocity(box).norm(), expected, 0.01 * expected);
}

TEST(Mesh, ABallRollsAsOnAPlane) {
  const TriangleMesh floor = flat_surface(60, 30.0f, 11).mesh();
  Lab lab;
  add_mesh(lab, floor, {.friction = 0.5f});
  const BodyId ball = lab.add({.position = {-15, 0.3f, 0.123f}, .linear_velocity = {7, 0, 0}}, Sphere{0.3f},
                              {.friction = 0.5f});
  lab.run(180);
  EXPECT_NEAR(lab.velocity(ball).x(), 5.0, 0.05);  // 5/7 of the speed at first
  EXPECT_NEAR(lab.velocity(ball).z(), 0.0, 0.01);
  EXPECT_NEAR(lab.height(ball), 0.3, 2e-3);
}

TEST(Mesh, AStackStandsAsOnABox) {
  std::array<double, 2> top{};
  for (const bool on_mesh : {false, true}) {
    Lab lab;
    if (on_mesh) {
      add_mesh(lab, flat_surface(20, 10.0f, 5).mesh());
    } else {
      lab.add_ground();
    }
    BodyId last;
    for (int i = 0; i < 5; ++i)
      last = lab.add({.position = {0, 0.5f + static_cast<float>(i), 0}}, Box{{0.5f, 0.5f, 0.5f}});
    lab.run(600);
    top[on_mesh ? 1 : 0] = lab.height(last);
    EXPECT_LT(lab.velocity(last).norm(), 1e-3);
  }
  EXPECT_NEAR(top[1], top[0], 1e-4);
}

TEST(Mesh, WhatIsThrownIntoARoomOfMeshStaysInIt) {
  const Vec3 half{4.0f, 3.0f, 4.0f};
  WorldSettings settings;
  Lab lab(settings);
  add_mesh(lab, box_surface(half, true).mesh());
  scenes::Random random(17);
  std::vector<BodyId> bodies;
  for (int i = 0; i < 150; ++i) {
    const Vec3 at{random.between(-3.0f, 3.0f), random.between(-2.0f, 2.0f), random.between(-3.0f, 3.0f)};
    const BodyDef def{.position = at,
                      .rotation = random.rotation(),
                      .linear_velocity = {random.between(-15.0f, 15.0f), random.between(-15.0f, 15.0f),
                                          random.between(-15.0f, 15.0f)}};
    const float size = random.between(0.05f, 0.3f);
    const std::array<Geometry, 4> shapes = {
        Box{{size, 0.5f * size, size}}, Sphere{size}, Capsule{size, 0.6f * size},
        ConvexHull{.hull = Hull(scenes::random_sphere_points(14, size, static_cast<std::uint32_t>(i + 1)))}};
    bodies.push_back(lab.add(def, shapes[static_cast<std::size_t>(i) % shapes.size()]));
  }
  for (int i = 0; i < 900; ++i) {
    lab.run(1);
    for (const BodyId body : bodies) {
      const Eigen::Vector3d at = lab.position(body);
      ASSERT_LT(std::abs(at.x()), half.x) << "step " << i;
      ASSERT_LT(std::abs(at.y()), half.y) << "step " << i;
      ASSERT_LT(std::abs(at.z()), half.z) << "step " << i;
    }
  }
  EXPECT_LE(lab.world.stats().awake_bodies, 15);  // balls and capsules roll on for long
}

// A closed mesh from outside is a solid as far as its surface goes.
TEST(Mesh, ABoxRestsOnTheRidgeOfARoofAlongTheTriangleThatItTouches) {
  Surface roof;
  roof.vertices = {{-5, 0, -5}, {-5, 0, 5}, {5, 0, -5}, {5, 0, 5}, {0, 2, -5}, {0, 2, 5}};
  roof.triangles = {{0, 1, 5}, {0, 5, 4}, {4, 5, 3}, {4, 3, 2}};
  Lab lab;
  add_mesh(lab, roof.mesh(), {.friction = 1.0f});
  // Level above the ridge: a face of the box on the edge of the mesh.
  const BodyId level = lab.add({.position = {0, 2.25f, 0}}, Box{{0.5f, 0.25f, 0.5f}}, {.friction = 1.0f});
  // On a slope of 21.8 degrees, which friction holds.
  const double angle = std::atan2(2.0, 5.0);
  const Quat tilt = rotation_about({0, 0, 1}, -angle);
  const Eigen::Vector3d at = Eigen::Vector3d(2.5, 1, 3) + to_eigen(tilt) * Eigen::Vector3d(0, 0.25, 0);
  const BodyId leaning =
      lab.add({.position = {static_cast<float>(at.x()), static_cast<float>(at.y()), 3.0f}, .rotation = tilt},
              Box{{0.5f, 0.25f, 0.5f}}, {.friction = 1.0f});
  lab.run(60);
  EXPECT_NEAR(lab.height(level), 2.25, 0.01);
  EXPECT_LT((lab.position(leaning) - at).norm(), 0.01);
  EXPECT_LT(lab.velocity(leaning).norm(), 1e-3);
}

TEST(Mesh, TrianglesHaveSurfacesOfTheirOwn) {
  Surface surface = flat_surface(1, 20.0f, 1);  // two triangles
  std::vector<std::uint8_t> of_triangle = {0, 255};
  const std::vector<Material> materials = {{.friction = 0.0f, .friction_mix = MixRule::minimum}};
  const TriangleMesh mesh(surface.vertices, surface.triangles, {of_triangle, materials});
  Lab lab;
  lab.add({.type = BodyType::fixed}, mesh, {.friction = 1.0f});
  const Vec3 middle[2] = {
      (1.0f / 3.0f) * (surface.vertices[surface.triangles[0].a] + surface.vertices[surface.triangles[0].b] +
                       surface.vertices[surface.triangles[0].c]),
      (1.0f / 3.0f) * (surface.vertices[surface.triangles[1].a] + surface.vertices[surface.triangles[1].b] +
                       surface.vertices[surface.triangles[1].c])};
  BodyId boxes[2];
  for (int i = 0; i < 2; ++i) {
    boxes[i] = lab.add({.position = middle[i] + Vec3{0, 0.2f, 0}, .linear_velocity = {0, 0, 1}},
                       Box{{0.2f, 0.2f, 0.2f}}, {.friction = 1.0f});
  }
  lab.run(60);
  EXPECT_NEAR(lab.velocity(boxes[0]).z(), 1.0, 1e-3);
  EXPECT_LT(lab.velocity(boxes[1]).norm(), 1e-3);
}

TEST(Mesh, AKinematicMeshCarriesWhatLiesOnIt) {
  Lab lab;
  const BodyId carrier =
      lab.add({.type = BodyType::kinematic}, flat_surface(10, 5.0f, 2).mesh(), {.friction = 0.8f});
  const BodyId box = lab.add({.position = {0.3f, 0.25f, 0.1f}}, Box{{0.4f, 0.25f, 0.3f}}, {.friction = 0.8f});
  lab.run(30);
  lab.world.set_linear_velocity(carrier, {1, 0.5f, 0});
  lab.run(120);
  EXPECT_NEAR(lab.velocity(box).x(), 1.0, 0.02);
  EXPECT_NEAR(lab.velocity(box).y(), 0.5, 0.02);
  EXPECT_NEAR(lab.height(box), 0.25 + 1.0, 0.02);
}

TEST(Mesh, BodiesOnHillsComeToRestAndSleep) {
  const scenes::Scene scene = scenes::build("terrain", {{"bodies", 120}, {"triangles", 8000}}).front();
  World world(scene.settings);
  const std::vector<BodyId> bodies = populate(world, scene);
  Workers workers{1};
  for (int i = 0; i < 1800; ++i) step(world, scene.dt, workers);
  int lost = 0;
  for (std::size_t i = 1; i < bodies.size(); ++i) lost += world.pose(bodies[i]).position.y < -5.0f ? 1 : 0;
  EXPECT_EQ(lost, 0);
  EXPECT_LE(world.stats().awake_bodies, 12);  // balls and capsules roll on for long
}

TEST(Mesh, BodiesFallThroughTheHolesOfAHeightField) {
  const scenes::Scene scene = scenes::build("height_field", {{"bodies", 400}, {"cells", 4000}}).front();
  World world(scene.settings);
  const std::vector<BodyId> bodies = populate(world, scene);
  Workers workers{1};
  for (int i = 0; i < 900; ++i) step(world, scene.dt, workers);
  int on_ground = 0, on_floor = 0;
  for (std::size_t i = 6; i < bodies.size(); ++i) {  // after the hills, the floor and its walls
    const float y = world.pose(bodies[i]).position.y;
    EXPECT_GT(y, -6.0f) << "body " << i << " left the floor";
    (y > -2.5f ? on_ground : on_floor) += 1;
  }
  EXPECT_GT(on_floor, 5);
  EXPECT_GT(on_ground, 100);
}

// The narrow phase makes points ahead for the speed that a step begins with, though bounds knew another.
TEST(Meshes, StopWhatACallHasMadeFastAtTheirSurface) {
  const std::vector<Vec3> vertices{{0, -9, -9}, {0, -9, 9}, {0, 9, -9}, {0, 9, 9}};
  const std::vector<MeshTriangle> triangles{{0, 1, 2}, {2, 1, 3}};
  const Geometry shapes[] = {Sphere{0.5f}, Capsule{0.5f, 0.5f}, Box{},
                             ConvexHull{.hull = Hull(scenes::box_points({0.5f, 0.5f, 0.5f}))}};
  for (const Geometry& shape : shapes) {
    for (const bool by_impulse : {false, true}) {
      for (const float speed : {2.0f, 5.0f, 10.0f, 20.0f}) {
        for (const float gap : {0.03f, 0.06f}) {  // less than 2 cm and a tenth of the size
          Lab lab(without_gravity());
          lab.add({.type = BodyType::fixed}, TriangleMesh(vertices, triangles));
          const BodyId body = lab.add({.position = {-0.5f - gap, 0, 0}}, shape);
          lab.run(3);
          if (by_impulse) {
            lab.world.add_impulse(body, {speed * lab.world.mass_properties(body).mass, 0, 0});
          } else {
            lab.world.set_linear_velocity(body, {speed, 0, 0});
          }
          double deepest = 0.0;
          for (int step = 0; step < 10; ++step) {
            lab.run(1);
            deepest = std::max(deepest, lab.position(body).x() + 0.5);
          }
          EXPECT_LT(deepest, 0.01) << shape.index() << ", " << speed << " m/s, " << gap << " m, impulse "
                                   << by_impulse;
        }
      }
    }
  }
}

// Bounds look ahead however the velocity came about: a bullet hits what stands on its way in the same step.
TEST(Meshes, ManySmallImpulsesAreOneLargeOne) {
  double speeds[2];
  for (const int parts : {1, 1000}) {
    Lab lab(without_gravity());
    const BodyId target = lab.add({.position = {3, 0, 0}}, Sphere{0.1f});
    const BodyId bullet = lab.add({}, Sphere{0.1f});
    lab.run(2);
    const float impulse = 300.0f * lab.world.mass_properties(bullet).mass / static_cast<float>(parts);
    for (int i = 0; i < parts; ++i) lab.world.add_impulse(bullet, {impulse, 0, 0});
    lab.run(3);
    speeds[parts == 1 ? 0 : 1] = lab.velocity(target).x();
  }
  EXPECT_GT(speeds[0], 100.0);
  EXPECT_NEAR(speeds[1], speeds[0], 0.1);
}

// Steps in a row in which sweeps alone hold a body that falls on hills of `terrain`, at 13 to 17 m/s.
int steps_without_contact(const scenes::Scene& scene, std::size_t number, const Geometry& geometry) {
  Lab lab(scene.settings);
  const scenes::SceneBody& hills = scene.bodies[0];
  lab.add(hills.def, scene.shapes[static_cast<std::size_t>(hills.first_shape)].geometry);
  BodyDef def = scene.bodies[number].def;
  def.position.y += 3.0f;
  lab.add(def, geometry);
  int now = 0, most = 0;
  for (int i = 0; i < 130; ++i) {
    lab.run(1, scene.dt);
    const StepStats& stats = lab.world.stats();
    now = stats.sweep_hits > 0 && stats.contacts == 0 ? now + 1 : 0;
    most = std::max(most, now);
  }
  return most;
}

// Some triangle holds what has come in so deep that each leaves it to the others.
TEST(Meshes, HoldWhatCameInDeepByContacts) {
  const scenes::Scene scene = scenes::build("terrain", {}).front();
  const std::vector<Vec3> corners = scenes::box_points({0.3f, 0.25f, 0.3f});
  const Geometry shapes[] = {
      Box{{0.3f, 0.2f, 0.25f}},
      ConvexHull{.hull = Hull(corners)},
      ConvexHull{.hull = Hull(std::vector<Vec3>{
                     {-0.3f, -0.2f, -0.2f}, {0.3f, -0.2f, -0.2f}, {0, -0.2f, 0.3f}, {0, 0.3f, 0}})},
      Cylinder{0.25f, 0.25f},
      Cone{0.3f, 0.3f},
      Box{{0.2f, 0.15f, 0.2f}, 0.05f},
      ConvexHull{.hull = Hull(corners), .rounding = 0.05f}};
  for (const Geometry& shape : shapes) {
    for (std::size_t body = 1; body < scene.bodies.size(); body += 97)
      EXPECT_LE(steps_without_contact(scene, body, shape), 8) << shape.index() << ", body " << body;
  }
}

}  // namespace
}  // namespace scree::physics
