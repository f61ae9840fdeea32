// The narrow phase finds the kernels of smooth shapes, whatever the order in which shapes are created.
#include <gtest/gtest.h>
#include <scree/scree.h>

#include <cmath>
#include <string>
#include <vector>

namespace scree::smooth_shapes {
namespace {

struct Named {
  const char* name;
  Geometry geometry;
  float below, above;  // m, from the origin down and up, standing
};

std::vector<Named> convex_shapes() {
  const Hull cube(std::vector<Vec3>{{0.5f, 0.5f, 0.5f},
                                    {-0.5f, 0.5f, 0.5f},
                                    {0.5f, -0.5f, 0.5f},
                                    {0.5f, 0.5f, -0.5f},
                                    {-0.5f, -0.5f, 0.5f},
                                    {-0.5f, 0.5f, -0.5f},
                                    {0.5f, -0.5f, -0.5f},
                                    {-0.5f, -0.5f, -0.5f}});
  return {
      {"cylinder", Cylinder{.half_height = 0.5f, .radius = 0.5f}, 0.5f, 0.5f},
      {"cone", Cone{.half_height = 0.5f, .radius = 0.5f}, 0.5f, 0.5f},
      {"rounded box", Box{{0.4f, 0.4f, 0.4f}, 0.1f}, 0.5f, 0.5f},
      {"rounded hull", ConvexHull{.hull = cube, .scale = {0.8f, 0.8f, 0.8f}, .rounding = 0.1f}, 0.5f, 0.5f},
      {"sphere", Sphere{0.5f}, 0.5f, 0.5f},
      {"capsule", Capsule{0.25f, 0.25f}, 0.5f, 0.5f},
      {"box", Box{{0.5f, 0.5f, 0.5f}}, 0.5f, 0.5f},
      {"hull", ConvexHull{.hull = cube}, 0.5f, 0.5f}};
}
constexpr std::size_t kSmoothShapes = 4;  // of these

TriangleMesh square() {
  const std::vector<Vec3> vertices = {{-2, 0.5f, -2}, {2, 0.5f, -2}, {2, 0.5f, 2}, {-2, 0.5f, 2}};
  const std::vector<MeshTriangle> triangles = {{0, 2, 1}, {0, 3, 2}};
  return TriangleMesh(vertices, triangles);
}

void add(World& world, BodyType type, const Geometry& geometry, float height) {
  world.add_shape(world.create_body({.type = type, .position = {0, height, 0}}), geometry);
}

// One contact, whose normal is vertical, wherever the two lie in the lists.
void expect_contact(const Geometry& lower, BodyType lower_type, const Named& upper, float gap,
                    bool upper_first, const std::string& where) {
  WorldSettings settings;
  settings.contact_events = ContactEvents::all;
  settings.sleeping = false;
  World world(settings);
  const float height = 0.5f + upper.below + gap;
  if (upper_first) add(world, BodyType::dynamic, upper.geometry, height);
  add(world, lower_type, lower, 0.0f);
  if (!upper_first) add(world, BodyType::dynamic, upper.geometry, height);
  Workers workers{1};
  step(world, 1.0f / 60.0f, workers);
  EXPECT_EQ(world.stats().contacts, gap < 0.05f ? 1 : 0) << where;
  for (const ContactEvent& event : world.contact_begins())
    EXPECT_NEAR(std::abs(event.normal.y), 1.0f, 1e-3f) << where;
}

TEST(CollideSmoothShapes, EveryPairOfTypesIsCollidedInBothOrders) {
  const std::vector<Named> shapes = convex_shapes();
  for (std::size_t a = 0; a < kSmoothShapes; ++a) {
    for (std::size_t b = 0; b < shapes.size(); ++b) {
      for (const bool first : {false, true}) {
        const std::string where = std::string(shapes[a].name) + " over " + shapes[b].name;
        expect_contact(shapes[b].geometry, BodyType::dynamic, shapes[a], 0.001f, first, where);
        expect_contact(shapes[b].geometry, BodyType::fixed, shapes[a], -0.002f, first, where);
        expect_contact(shapes[b].geometry, BodyType::fixed, shapes[a], 0.1f, first, where + ", apart");
        expect_contact(shapes[a].geometry, BodyType::fixed, shapes[b], -0.002f, first, where + ", reversed");
      }
    }
  }
}

TEST(CollideSmoothShapes, MeshesAndHalfSpacesAreCollidedInBothOrders) {
  const std::vector<Named> shapes = convex_shapes();
  for (std::size_t a = 0; a < kSmoothShapes; ++a) {
    for (const bool first : {false, true}) {
      expect_contact(square(), BodyType::fixed, shapes[a], -0.002f, first,
                     std::string(shapes[a].name) + " on mesh");
      expect_contact(square(), BodyType::fixed, shapes[a], 0.1f, first,
                     std::string(shapes[a].name) + " over mesh");
      Named raised = shapes[a];
      raised.below -= 0.5f;  // the plane lies at the origin
      expect_contact(HalfSpace{}, BodyType::fixed, raised, -0.002f, first,
                     std::string(raised.name) + " on plane");
      expect_contact(HalfSpace{}, BodyType::fixed, raised, 0.1f, first,
                     std::string(raised.name) + " over plane");
    }
  }
}

}  // namespace
}  // namespace scree::smooth_shapes
