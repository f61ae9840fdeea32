// Laws of sensors: what they see, and when it enters and leaves.
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <tools/scenes/random.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace scree {
namespace {

constexpr float kSensorStep = 1.0f / 60.0f;  // s
constexpr ShapeOptions kSensor{.sensor = true};

using Sight = std::pair<ShapeId, ShapeId>;  // sensor and visitor
using Sights = std::set<Sight>;

Sights sights_of(std::span<const SensorEvent> events) {
  Sights sights;
  for (const SensorEvent& event : events) sights.insert({event.sensor, event.visitor});
  return sights;
}

class SensorEvents : public ::testing::Test {
 protected:
  World world{WorldSettings{.gravity = {}, .contact_events = ContactEvents::all}};
  Workers workers{1};

  BodyId body(BodyType type, Vec3 position, Vec3 velocity = {}) {
    return world.create_body({.type = type, .position = position, .linear_velocity = velocity});
  }
  ShapeId sensor(Vec3 position, const Geometry& geometry, Vec3 velocity = {}) {
    const bool moves = velocity != Vec3{};
    return world.add_shape(body(moves ? BodyType::kinematic : BodyType::fixed, position, velocity), geometry,
                           {}, kSensor);
  }
  ShapeId visitor(Vec3 position, Vec3 velocity = {}, float radius = 0.1f) {
    return world.add_shape(body(BodyType::dynamic, position, velocity), Sphere{radius});
  }
  void run(int steps = 1, float dt = kSensorStep) {
    for (int i = 0; i < steps; ++i) step(world, dt, workers);
  }
  Sights begins() const { return sights_of(world.sensor_begins()); }
  Sights ends() const { return sights_of(world.sensor_ends()); }
  std::vector<ShapeId> visitors(ShapeId of) const {
    std::vector<ShapeId> all(world.visitors_of(of, {}));
    world.visitors_of(of, all);
    return all;
  }
};

TEST_F(SensorEvents, BodiesOfEveryTypeAreSeen) {
  const ShapeId hall = sensor({}, Box{{10, 10, 10}});
  std::vector<ShapeId> inside;
  inside.push_back(world.add_shape(body(BodyType::fixed, {-5, 0, 0}), Sphere{1}));
  inside.push_back(world.add_shape(body(BodyType::kinematic, {0, 0, 0}), Box{}));
  inside.push_back(world.add_shape(body(BodyType::dynamic, {5, 0, 0}), Capsule{}));
  visitor({30, 0, 0});
  run();
  EXPECT_EQ(visitors(hall), inside);
  EXPECT_EQ(world.sensor_begins().size(), 3u);
  EXPECT_EQ(world.sensor_begins()[2].visitor_body, world.body_of(inside[2]));
  EXPECT_EQ(world.sensor_begins()[2].sensor_body, world.body_of(hall));
  run(120);
  EXPECT_FALSE(world.is_awake(world.body_of(inside[2])));
  EXPECT_EQ(visitors(hall), inside);
  EXPECT_TRUE(world.sensor_begins().empty());
  EXPECT_TRUE(world.sensor_ends().empty());
}

TEST_F(SensorEvents, SensorsOfEveryTypeOfBodySeeFixedBodies) {
  const ShapeId wall = world.add_shape(body(BodyType::fixed, {}), Box{{1, 1, 1}});
  Sights expected;
  for (const BodyType type : {BodyType::fixed, BodyType::kinematic, BodyType::dynamic})
    expected.insert({world.add_shape(body(type, {1.2f, 0, 0}), Sphere{0.3f}, {}, kSensor), wall});
  run();
  EXPECT_EQ(begins(), expected);
}

TEST_F(SensorEvents, SensorsSeeNeitherSensorsNorTheirOwnBody) {
  const ShapeId outer = sensor({}, Sphere{2});
  sensor({0.5f, 0, 0}, Sphere{2});
  world.add_shape(world.body_of(outer), Sphere{1});
  run();
  EXPECT_EQ(world.visitors_of(outer, {}), 0u);
  EXPECT_EQ(world.sensor_begins().size(), 1u);  // the other one sees the ball
}

TEST_F(SensorEvents, FiltersOfBothSidesDecide) {
  const ShapeId eye = world.add_shape(body(BodyType::fixed, {}), Sphere{2}, {},
                                      {.filter = {.category = 1, .mask = 6, .group = 3}, .sensor = true});
  const auto add = [&](const Filter& filter) {
    return world.add_shape(body(BodyType::dynamic, {}), Sphere{0.1f}, {}, {.filter = filter});
  };
  const ShapeId both = add({.category = 2, .mask = 1});
  add({.category = 8, .mask = 1});
  add({.category = 2, .mask = 4});
  const ShapeId group = add({.category = 8, .mask = 8, .group = 3});
  run();
  EXPECT_EQ(visitors(eye), (std::vector{both, group}));
  world.set_filter(both, {.category = 8, .mask = 1});
  run();
  EXPECT_EQ(ends(), (Sights{{eye, both}}));
}

TEST_F(SensorEvents, SensorsPushNothingAndWeighNothing) {
  const ShapeId ball = visitor({-1, 0, 0}, {10, 0, 0});
  sensor({}, Box{{0.5f, 0.5f, 0.5f}});
  const MassProperties before = world.mass_properties(world.body_of(ball));
  world.add_shape(world.body_of(ball), Box{{2, 1, 1}}, {}, {.local_pose = {{3, 0, 0}, {}}, .sensor = true});
  const MassProperties after = world.mass_properties(world.body_of(ball));
  EXPECT_EQ(after.mass, before.mass);
  EXPECT_EQ(after.center, before.center);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(after.inertia[i], before.inertia[i]);
  int contacts = 0;
  for (int i = 0; i < 30; ++i) {
    run();
    contacts += static_cast<int>(world.stats().contacts + world.stats().pairs);
  }
  EXPECT_EQ(contacts, 0);
  EXPECT_EQ(world.linear_velocity(world.body_of(ball)), (Vec3{10, 0, 0}));
  world.set_material(world.add_shape(world.body_of(ball), Sphere{5}, {}, kSensor), {.density = 5e4f});
  EXPECT_EQ(world.mass_properties(world.body_of(ball)).mass, before.mass);
}

TEST_F(SensorEvents, ASlowBallIsSeenFromTheFirstTouchToTheLast) {
  const ShapeId slab = sensor({}, Box{{0.25f, 5, 5}});
  const ShapeId ball = visitor({-2, 0, 0}, {1, 0, 0}, 0.5f);
  int seen = 0;
  for (int i = 0; i < 240; ++i) {
    run();
    const float x = world.pose(world.body_of(ball)).position.x;
    const bool touches = std::abs(x) <= 0.75f;
    EXPECT_EQ(world.visitors_of(slab, {}), touches ? 1u : 0u) << x;
    seen += static_cast<int>(world.sensor_begins().size()) - static_cast<int>(world.sensor_ends().size());
    EXPECT_EQ(seen, touches ? 1 : 0);
  }
}

// Balls cross a thin disk-like box in one step, or pass beside it.
TEST_F(SensorEvents, WhatCrossesWithinOneStepBeginsAndEndsInIt) {
  scenes::Random random(3);
  for (int trial = 0; trial < 300; ++trial) {
    World own{WorldSettings{.gravity = {}, .max_linear_speed = 2000.0f}};
    const float sensor_speed = trial % 3 == 0 ? 0.0f : random.between(-300.0f, 300.0f);
    const BodyId gate = own.create_body(
        {.type = BodyType::kinematic, .position = {}, .linear_velocity = {0, sensor_speed, 0}});
    const ShapeId eye = own.add_shape(gate, Box{{0.005f, 1, 1}}, {}, kSensor);
    const float speed = random.between(100.0f, 1000.0f);
    const float start = -random.between(0.2f, 0.8f) * speed * kSensorStep;
    const float lateral = trial % 2 == 0 ? 0.0f : random.between(-500.0f, 500.0f);
    const float height = random.between(-2.0f, 2.0f);
    const float radius = 0.05f;
    const ShapeId bullet = own.add_shape(
        own.create_body({.position = {start, height, 0}, .linear_velocity = {speed, lateral, 0}}),
        Sphere{radius});
    step(own, kSensorStep, workers);
    // Relative to the gate the ball comes to its plane at this height.
    const float crossing = height + (lateral - sensor_speed) * (-start / speed);
    // Where the way is oblique, it touches beside that point, too.
    const float slope = std::abs(lateral - sensor_speed) / speed;
    const float doubt = radius + slope * (radius + 0.005f) + 0.01f;
    const Sights begun = sights_of(own.sensor_begins());
    if (std::abs(crossing) < 1.0f) {
      EXPECT_EQ(begun, (Sights{{eye, bullet}})) << trial;
      EXPECT_EQ(sights_of(own.sensor_ends()), begun) << trial;
    } else if (std::abs(crossing) > 1.0f + doubt) {
      EXPECT_TRUE(begun.empty()) << trial << " at " << crossing;
    }
    EXPECT_EQ(own.visitors_of(eye, {}), 0u);
  }
}

TEST_F(SensorEvents, FastSensorsSeeWhatRests) {
  std::vector<ShapeId> crossed;
  const ShapeId blade = sensor({-5, 0, 0}, Box{{0.01f, 1, 1}}, {600, 0, 0});
  for (int i = 0; i < 8; ++i)
    crossed.push_back(
        visitor({static_cast<float>(i) - 4, 0.2f * static_cast<float>(i) - 0.8f, 0}, {}, 0.05f));
  visitor({0, 1.2f, 0}, {}, 0.05f);
  const ShapeId wall = world.add_shape(body(BodyType::fixed, {0, -1.5f, 0}), Box{{0.1f, 1, 1}});
  run();
  Sights expected{{blade, wall}};
  for (const ShapeId shape : crossed) expected.insert({blade, shape});
  EXPECT_EQ(begins(), expected);
  EXPECT_EQ(ends(), expected);
}

TEST_F(SensorEvents, WhatIsDestroyedHasLeft) {
  const ShapeId eye = sensor({}, Sphere{5}), other = sensor({}, Sphere{4});
  const ShapeId ball = visitor({}), stays = visitor({1, 0, 0});
  run();
  EXPECT_EQ(begins().size(), 4u);
  world.destroy_body(world.body_of(ball));
  const ShapeId successor = visitor({});  // in the same slot
  EXPECT_EQ(successor.index, ball.index);
  world.destroy_shape(other);
  run();
  EXPECT_EQ(ends(), (Sights{{eye, ball}, {other, ball}, {other, stays}}));
  EXPECT_EQ(begins(), (Sights{{eye, successor}}));
  EXPECT_EQ(visitors(eye), (std::vector{successor, stays}));
  EXPECT_THROW(world.visitors_of(other, {}), Error);
  world.destroy_shape(eye);
  run();
  EXPECT_EQ(ends(), (Sights{{eye, successor}, {eye, stays}}));
  run();
  EXPECT_TRUE(world.sensor_ends().empty());
}

TEST_F(SensorEvents, CallsThatMoveABodyAreSeenAfterTheNextStep) {
  const ShapeId eye = sensor({}, Sphere{1});
  const ShapeId ball = visitor({50, 0, 0});
  run();
  world.set_pose(world.body_of(ball), {{0.5f, 0, 0}, {}});
  EXPECT_EQ(world.visitors_of(eye, {}), 0u);
  run(1, 0.0f);  // steps of no length see, too
  EXPECT_EQ(begins(), (Sights{{eye, ball}}));
  world.set_pose(world.body_of(eye), {{20, 0, 0}, {}});
  run();
  EXPECT_EQ(ends(), (Sights{{eye, ball}}));
}

TEST_F(SensorEvents, OnlySensorsHaveVisitors) {
  const ShapeId ball = visitor({});
  EXPECT_FALSE(world.is_sensor(ball));
  try {
    world.visitors_of(ball, {});
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("visitors_of: shape 0 is no sensor"), std::string::npos)
        << error.what();
  }
}

TEST_F(SensorEvents, QueriesPassOverSensorsUnlessAsked) {
  const ShapeId eye = sensor({}, Sphere{1});
  const ShapeId ball = visitor({3, 0, 0});
  const Ray ray{{-5, 0, 0}, {20, 0, 0}};
  EXPECT_TRUE(world.is_sensor(eye));
  EXPECT_EQ(cast_ray(world, ray)->shape, ball);
  EXPECT_EQ(cast_ray(world, ray, {.sensors = true})->shape, eye);
  EXPECT_TRUE(overlap_point(world, {}).empty());
  EXPECT_EQ(overlap_point(world, {}, {.sensors = true}).size(), 1u);
}

// A world of sensors and others on bodies of all types that move, and calls in between.
struct Crowd {
  World world{WorldSettings{.gravity = {0, -3, 0}, .contact_events = ContactEvents::all}};
  scenes::Random random;
  std::vector<BodyId> bodies;

  explicit Crowd(std::uint64_t seed) : random(seed) {
    for (int i = 0; i < 120; ++i) add();
  }
  Vec3 place(float reach) {
    const float x = random.between(-reach, reach);
    const float y = random.between(-reach, reach);
    const float z = random.between(-reach, reach);
    return {x, y, z};
  }
  void add() {
    const auto type = static_cast<BodyType>(random.below(3));
    const Vec3 position = place(6.0f);
    const Vec3 velocity = place(random.below(5) == 0 ? 200.0f : 5.0f);
    const Quat rotation = random.rotation();
    const BodyId body = world.create_body({.type = type, .position = position, .rotation = rotation});
    if (type != BodyType::fixed) world.set_linear_velocity(body, velocity);
    const float size = random.between(0.1f, 1.0f);
    const bool seeing = random.below(3) == 0;
    const Geometry forms[] = {Sphere{size}, Capsule{size, 0.5f * size}, Box{{size, 0.3f, 0.5f}}};
    world.add_shape(body, forms[random.below(3)], {}, {.sensor = seeing});
    bodies.push_back(body);
  }
  void change() {
    const std::size_t which = random.below(static_cast<std::uint32_t>(bodies.size()));
    const BodyId body = bodies[which];
    if (random.below(2) == 0) {
      world.destroy_body(body);
      bodies.erase(bodies.begin() + static_cast<std::ptrdiff_t>(which));
      add();
    } else {
      const Vec3 position = place(6.0f);
      world.set_pose(body, {position, {}});
    }
  }
  std::vector<ShapeId> shapes() const {
    std::vector<ShapeId> all;
    for (const BodyId body : bodies) {
      std::vector<ShapeId> own(world.shapes_of(body, {}));
      world.shapes_of(body, own);
      all.insert(all.end(), own.begin(), own.end());
    }
    return all;
  }
};

TEST_F(SensorEvents, AgreeWithOverlapsInRandomWorlds) {
  Crowd crowd(11);
  Sights seen;
  int passes = 0;
  for (int i = 0; i < 150; ++i) {
    step(crowd.world, kSensorStep, workers);
    Sights expected;
    for (const ShapeId shape : crowd.shapes()) {
      if (!crowd.world.is_sensor(shape)) continue;
      const BodyId body = crowd.world.body_of(shape);
      for (const OverlapHit& hit : overlap_shape(
               crowd.world, {crowd.world.geometry(shape), crowd.world.pose(body)}, {.ignored = body})) {
        expected.insert({shape, hit.shape});
      }
      std::vector<ShapeId> listed(crowd.world.visitors_of(shape, {}));
      crowd.world.visitors_of(shape, listed);
      EXPECT_TRUE(std::ranges::is_sorted(listed, {}, [](ShapeId id) { return id.index; }));
      for (const ShapeId visitor : listed) EXPECT_TRUE(expected.contains({shape, visitor}));
    }
    const Sights begun = sights_of(crowd.world.sensor_begins()), ended = sights_of(crowd.world.sensor_ends());
    EXPECT_EQ(begun.size(), crowd.world.sensor_begins().size());
    for (const Sight& sight : begun) {
      EXPECT_FALSE(seen.contains(sight));
      passes += ended.contains(sight) ? 1 : 0;
      seen.insert(sight);
    }
    for (const Sight& sight : ended) EXPECT_EQ(seen.erase(sight), 1u);
    EXPECT_EQ(seen, expected) << "in step " << i;
    crowd.change();
  }
  EXPECT_GT(passes, 5);
}

TEST_F(SensorEvents, GoOnInRestoredWorlds) {
  Crowd crowd(5);
  for (int i = 0; i < 3; ++i) step(crowd.world, kSensorStep, workers);
  Snapshot saved;
  save(crowd.world, saved);
  const auto bytes = write_snapshot<std::vector<std::byte>>(saved);
  World other, from_bytes;
  restore(other, saved);
  restore(from_bytes, read_snapshot(bytes));
  std::size_t changes = 0;
  for (int i = 0; i < 30; ++i) {
    step(crowd.world, kSensorStep, workers);
    step(other, kSensorStep, workers);
    step(from_bytes, kSensorStep, workers);
    const auto rows = [](std::span<const SensorEvent> events) {
      std::vector<std::pair<std::uint32_t, std::uint32_t>> names;
      for (const SensorEvent& event : events) names.push_back({event.sensor.index, event.visitor.index});
      return names;
    };
    EXPECT_EQ(rows(other.sensor_begins()), rows(crowd.world.sensor_begins()));
    EXPECT_EQ(rows(other.sensor_ends()), rows(crowd.world.sensor_ends()));
    EXPECT_EQ(rows(from_bytes.sensor_begins()), rows(crowd.world.sensor_begins()));
    EXPECT_EQ(rows(from_bytes.sensor_ends()), rows(crowd.world.sensor_ends()));
    changes += crowd.world.sensor_begins().size();
  }
  EXPECT_GE(changes, 5u);
}

}  // namespace
}  // namespace scree
