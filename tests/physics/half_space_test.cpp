// Half-spaces: what rests, slides, rolls and bounces on a plane without end, at any size and tilt; and
// queries against closed forms.
#include <tests/physics/lab.h>
#include <tools/scenes/random.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace scree::physics {
namespace {

const Hull& cube() {
  static const Hull kCube = [] {
    std::vector<Vec3> corners;
    for (int k = 0; k < 8; ++k)
      corners.push_back({k & 1 ? 1.0f : -1.0f, k & 2 ? 1.0f : -1.0f, k & 4 ? 1.0f : -1.0f});
    return Hull(corners);
  }();
  return kCube;
}

// Shapes that are `size` high above their center as they lie.
std::vector<Geometry> shapes_of(float size) {
  return {Sphere{size}, Capsule{2.0f * size, size}, Box{{2.0f * size, size, 1.5f * size}},
          ConvexHull{cube(), {size, size, size}}};
}

struct Plane {
  Vec3 origin, up;
  float height_of(Vec3 point) const { return dot(point - origin, up); }
};

Plane add_plane(Lab& lab, Vec3 origin, Quat tilt, const Material& material = {}) {
  lab.add({.type = BodyType::fixed, .position = origin, .rotation = tilt}, HalfSpace{}, material);
  return {origin, rotate(tilt, {0, 1, 0})};
}

TEST(HalfSpace, BearsShapesOfAnySizeAtTheirHeight) {
  for (const float size : {0.01f, 0.5f, 20.0f}) {
    const std::vector<Geometry> shapes = shapes_of(size);
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      Lab lab(WorldSettings{});
      add_plane(lab, {3, 7, -2}, {});
      const Quat lying = i == 1 ? rotation_about({0, 0, 1}, 1.5707963267948966) : Quat{};
      const BodyId body = lab.add({.position = {40, 7 + 1.2f * size, 80}, .rotation = lying}, shapes[i]);
      lab.run(600);
      EXPECT_NEAR(lab.height(body) - 7.0, double{size}, 0.02 * double{size} + 0.001)
          << i << ", size " << size;
      EXPECT_LT(lab.velocity(body).norm(), 0.01) << i << ", size " << size;
      EXPECT_FALSE(lab.world.is_awake(body)) << i << ", size " << size;
    }
  }
}

TEST(HalfSpace, BearsFarFromItsOrigin) {
  Lab lab;
  add_plane(lab, {0, 0, 0}, {});
  const BodyId box = lab.add({.position = {5e4f, 0.5f, -5e4f}}, Box{});
  const BodyId ball = lab.add({.position = {-8e6f, 0.5f, 8e6f}}, Sphere{0.5f});
  lab.run(120);
  EXPECT_NEAR(lab.height(box), 0.5, 0.002);
  EXPECT_NEAR(lab.height(ball), 0.5, 0.002);
}

// a = g (sin - mu cos) of what slides; 5/7 g sin of a ball that rolls.
TEST(HalfSpace, SlidesAndRollsAsOnASlope) {
  const double angle = 0.3;
  for (std::size_t i = 0; i < 4; ++i) {
    Lab lab;
    const Quat tilt = rotation_about({0, 0, 1}, -angle);
    const Plane plane = add_plane(lab, {1, 2, 3}, tilt, {.friction = 0.2f});
    const Vec3 across = rotate(tilt, {1, 0, 0});
    const Geometry shape = shapes_of(0.5f)[i];
    const Quat turn = i == 1 ? tilt * rotation_about({1, 0, 0}, 1.5707963267948966) : tilt;
    const Vec3 start = plane.origin + 0.5f * plane.up;
    const BodyId body = lab.add({.position = start, .rotation = turn}, shape, {.friction = 0.2f});
    lab.run(120);
    const double way = static_cast<double>(dot(lab.world.pose(body).position - start, across));
    const double rolls = i == 0 ? 5.0 / 7.0 : 0.0;  // a capsule lies across the slope: (1 + I / (m r^2))^-1
    const double slides = std::sin(angle) - 0.2 * std::cos(angle);
    double acceleration = kGravity * (i == 0 ? rolls * std::sin(angle) : slides);
    if (i == 1) {
      const double inertia = lab.inertia(body)(2, 2) / (lab.mass(body) * 0.25);
      acceleration = kGravity * std::sin(angle) / (1.0 + inertia);
    }
    EXPECT_NEAR(way, 0.5 * acceleration * 4.0, 0.02 * 0.5 * acceleration * 4.0) << i;
    EXPECT_NEAR(static_cast<double>(plane.height_of(lab.world.pose(body).position)), 0.5, 0.005) << i;
  }
}

TEST(HalfSpace, LetsNothingThroughAtAnySpeedOrSize) {
  for (const float speed : {30.0f, 390.0f}) {
    for (const float size : {0.005f, 0.5f}) {
      for (const Geometry& shape : shapes_of(size)) {
        for (const int substeps : {1, 4}) {
          WorldSettings settings = without_gravity();
          settings.substeps = substeps;
          Lab lab(settings);
          const Quat tilt = rotation_about({1, 2, 3}, 1.1);
          const Plane plane = add_plane(lab, {}, tilt);
          const BodyId body = lab.add({.position = 3.0f * plane.up,
                                       .linear_velocity = -speed * plane.up,
                                       .angular_velocity = {20, 30, -10}},
                                      shape);
          for (int i = 0; i < 60; ++i) {
            lab.run(1);
            ASSERT_GT(plane.height_of(lab.world.pose(body).position), -size)
                << speed << " m/s, size " << size;
          }
          EXPECT_GT(dot(lab.world.linear_velocity(body), plane.up), -0.05f) << speed << " m/s, size " << size;
        }
      }
    }
  }
}

TEST(HalfSpace, PushesOutWhatLiesDeepInIt) {
  Lab lab;
  add_plane(lab, {}, {});
  std::vector<BodyId> bodies;
  for (std::size_t i = 0; i < 4; ++i) {
    bodies.push_back(lab.add({.position = {5.0f * static_cast<float>(i), -6.0f, 0}}, shapes_of(0.5f)[i]));
  }
  lab.run(600);
  for (const BodyId body : bodies) EXPECT_GT(lab.height(body), 0.45);
}

TEST(HalfSpace, ReturnsABallToItsHeight) {
  Lab lab;
  add_plane(lab, {}, {}, {.friction = 0, .restitution = 1});
  const BodyId ball = lab.add({.position = {0, 1.5f, 0}}, Sphere{0.5f}, {.friction = 0, .restitution = 1});
  double highest = 0.0;
  for (int i = 0; i < 2000; ++i) {
    lab.run(1);
    if (i >= 1900)
      highest = std::max(highest,
                         lab.height(ball) + 0.5 * lab.velocity(ball).y() * lab.velocity(ball).y() / kGravity);
  }
  EXPECT_NEAR(highest - 0.5, 1.0, 0.01);
}

TEST(HalfSpace, ThatIsKinematicCarriesAndTips) {
  Lab lab;
  const BodyId ground = lab.add({.type = BodyType::kinematic, .linear_velocity = {1, 0.5f, 0}}, HalfSpace{});
  const BodyId box = lab.add({.position = {0, 0.5f, 0}}, Box{});
  lab.run(120);
  EXPECT_NEAR(lab.height(box), 0.5 + 1.0, 0.01);
  EXPECT_NEAR(lab.position(box).x(), 2.0, 0.05);
  lab.world.set_linear_velocity(ground, {});
  lab.world.set_angular_velocity(ground, {0, 0, -0.5f});
  lab.run(90);
  EXPECT_GT(lab.position(box).x(), 2.2);
}

TEST(HalfSpace, BearsAPileAsABoxDoes) {
  for (const bool is_box : {false, true}) {
    Lab lab(WorldSettings{});
    if (is_box) {
      lab.add_ground();
    } else {
      add_plane(lab, {}, {});
    }
    std::vector<BodyId> bodies;
    for (int i = 0; i < 100; ++i) {
      const auto at = [i](int each) { return 1.3f * static_cast<float>(i / each % 4); };
      bodies.push_back(lab.add({.position = {at(1), 0.6f + 1.2f * static_cast<float>(i / 16), at(4)}},
                               shapes_of(0.4f)[static_cast<std::size_t>(i % 4)]));
    }
    lab.run(900);
    int asleep = 0;
    for (const BodyId body : bodies) {
      EXPECT_GT(lab.height(body), 0.38);
      asleep += lab.world.is_awake(body) ? 0 : 1;
    }
    EXPECT_GT(asleep, 60) << (is_box ? "box" : "half-space");
  }
}

TEST(HalfSpace, AnswersQueriesAsItsPlaneDoes) {
  scenes::Random random(7);
  for (int k = 0; k < 300; ++k) {
    SCOPED_TRACE(k);
    Lab lab;
    const auto vector = [&] {
      return Vec3{random.between(-3, 3), random.between(-3, 3), random.between(-3, 3)};
    };
    const Plane plane = add_plane(lab, vector(), random.rotation());
    const Vec3 origin = vector(), translation = 3.0f * vector();
    const float height = plane.height_of(origin), fall = -dot(translation, plane.up);
    const auto hit = cast_ray(lab.world, {.origin = origin, .translation = translation});
    ASSERT_EQ(hit.has_value(), height <= 0.0f || fall >= height);
    EXPECT_EQ(hit && hit->starts_inside, height <= 0.0f);
    if (hit && height > 0.0f) {
      EXPECT_NEAR(hit->fraction, height / fall, 1e-5f);
      EXPECT_NEAR(plane.height_of(hit->point), 0.0f, 2e-5f);
      EXPECT_NEAR(length(hit->normal - plane.up), 0.0f, 1e-6f);
    }
    EXPECT_EQ(overlap_point(lab.world, origin).size(), height <= 0.0f ? 1u : 0u);
    const auto near = closest_to_point(lab.world, origin, 100.0f);
    ASSERT_TRUE(near.has_value());
    EXPECT_NEAR(near->distance, std::max(height, 0.0f), 1e-5f);
    if (height > 0.0f) {
      EXPECT_NEAR(length(near->point - (origin - height * plane.up)), 0.0f, 1e-5f);
    }

    const Quat turn = random.rotation();
    const std::vector<Geometry> shapes = shapes_of(0.5f);
    const std::size_t kind = random.below(4);
    // m, from the center down to the lowest point.
    const Vec3 up = rotate(Quat{-turn.x, -turn.y, -turn.z, turn.w}, plane.up);
    const float depths[] = {0.5f, 0.5f + std::abs(up.y),
                            std::abs(up.x) + 0.5f * std::abs(up.y) + 0.75f * std::abs(up.z),
                            0.5f * (std::abs(up.x) + std::abs(up.y) + std::abs(up.z))};
    const float gap = height - depths[kind];
    const PlacedShape placed{shapes[kind], {origin, turn}};
    EXPECT_EQ(overlap_shape(lab.world, placed).size(), gap <= 0.0f ? 1u : 0u);
    const auto nearest = closest_to_shape(lab.world, placed, 100.0f);
    ASSERT_TRUE(nearest.has_value());
    EXPECT_NEAR(nearest->distance, std::max(gap, 0.0f), 1e-5f);
    const auto met = cast_shape(lab.world, {shapes[kind], {origin, turn}, translation});
    ASSERT_EQ(met.has_value(), gap <= 0.0f || fall >= gap);
    if (met && gap > 0.0f) {
      EXPECT_NEAR(met->fraction, gap / fall, 1e-5f);
    }
  }
  Lab lab;
  EXPECT_THROW(cast_shape(lab.world, {HalfSpace{}, {}, {0, 1, 0}}), Error);
  EXPECT_THROW(overlap_shape(lab.world, {HalfSpace{}, {}}), Error);
}

TEST(HalfSpace, IsSeenBySensors) {
  Lab lab;
  add_plane(lab, {}, {});
  const BodyId probe = lab.world.create_body({.type = BodyType::kinematic, .position = {0, 3, 0}});
  const ShapeId sensor = lab.world.add_shape(probe, Sphere{0.5f}, {}, {.sensor = true});
  lab.run(2);
  EXPECT_EQ(lab.world.visitors_of(sensor, {}), 0u);
  lab.world.set_linear_velocity(probe, {0, -60, 0});
  lab.run(3);
  EXPECT_EQ(lab.world.visitors_of(sensor, {}), 1u);
}

TEST(HalfSpace, GoesThroughSnapshotsAndRecordingsAndClones) {
  Lab lab;
  const BodyId ground = lab.add({.type = BodyType::fixed}, HalfSpace{}, {.friction = 0.3f});
  for (int i = 0; i < 8; ++i) {
    lab.add({.position = {2.0f * static_cast<float>(i), 1.5f, 0}, .angular_velocity = {1, 2, 3}},
            shapes_of(0.4f)[static_cast<std::size_t>(i % 4)]);
  }
  lab.run(20);
  Snapshot snapshot;
  save(lab.world, snapshot);
  World restored, copy = clone(lab.world);
  restore(restored, read_snapshot(write_snapshot(snapshot)));
  lab.run(60);
  for (int i = 0; i < 60; ++i) {
    step(restored, kStep, lab.workers);
    step(copy, kStep, lab.workers);
  }
  EXPECT_EQ(restored.hash(), lab.world.hash());
  EXPECT_EQ(copy.hash(), lab.world.hash());
  ShapeId shape;
  copy.shapes_of(ground, {&shape, 1});
  EXPECT_TRUE(std::holds_alternative<HalfSpace>(copy.geometry(shape)));
}

TEST(HalfSpace, BelongsToNoDynamicBodyAndIsNoSensor) {
  Lab lab;
  const BodyId ball = lab.add({.position = {0, 2, 0}}, Sphere{});
  const BodyId ground = lab.add({.type = BodyType::fixed}, HalfSpace{});
  const auto refuse = [&](auto call, const std::string& message) {
    try {
      call();
      ADD_FAILURE() << "not refused: " << message;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  };
  refuse([&] { lab.world.add_shape(ball, HalfSpace{}); },
         "add_shape: a half-space belongs to fixed and kinematic bodies only");
  refuse([&] { lab.world.add_shape(ground, HalfSpace{}, {}, {.sensor = true}); },
         "a half-space is no sensor");
  refuse([&] { lab.world.set_body_type(ground, BodyType::dynamic); }, "is a half-space, which belongs to");
  ShapeId shape;
  lab.world.shapes_of(ball, {&shape, 1});
  refuse([&] { lab.world.set_geometry(shape, HalfSpace{}); }, "set_geometry: a half-space belongs");
  lab.world.shapes_of(ground, {&shape, 1});
  EXPECT_TRUE(std::holds_alternative<HalfSpace>(lab.world.geometry(shape)));
}

}  // namespace
}  // namespace scree::physics
