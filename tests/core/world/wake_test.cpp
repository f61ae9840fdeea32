// Laws of waking: every change that can affect a body's motion wakes it.
#include <core/world/wake.h>
#include <tests/core/world/world_fixture.h>

#include <functional>
#include <limits>
#include <utility>
#include <vector>

namespace scree::test {
namespace {

class Waking : public ::testing::Test {
 protected:
  World world;
  BodyId ground = world.create_body({.type = BodyType::fixed});
  ShapeId ground_shape = world.add_shape(ground, Box{});
  BodyId lower = world.create_body({});
  ShapeId lower_shape = world.add_shape(lower, Box{});
  BodyId upper = world.create_body({});
  ShapeId upper_shape = world.add_shape(upper, Box{});
  BodyId aside = world.create_body({});
  ShapeId aside_shape = world.add_shape(aside, Box{});

  // Ground, lower and upper touch in a row; the one aside only has a candidate pair.
  void SetUp() override {
    add_touching(world, ground_shape, lower_shape);
    add_touching(world, lower_shape, upper_shape);
    add_pair(world, upper_shape, aside_shape);
    sleep_all();
  }
  void sleep_all() {
    wake_neighbors(internals(world));  // deferred requests of calls
    for (const BodyId body : {lower, upper, aside}) {
      if (world.is_alive(body)) put_to_sleep(world, body);
    }
    internals(world).bodies.lists_dirty = false;
  }
};

TEST_F(Waking, ReadingLooksForNeighborsOnceUntilAnotherCallAsksForThem) {
  const MadeOnce& made = internals(world).shapes.waking_made;
  world.set_pose(ground, {});
  const std::int64_t before = made.times_made();
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(world.is_awake(lower));
    EXPECT_FALSE(world.is_awake(aside));
    world.set_user_data(upper, 7);
    world.add_force(lower, {1, 0, 0});
  }
  EXPECT_EQ(made.times_made(), before + 1);
  world.set_pose(lower, {});
  EXPECT_TRUE(world.is_awake(upper));
  EXPECT_EQ(made.times_made(), before + 2);
}

TEST_F(Waking, ChangesOfMotionWakeTheBody) {
  const std::vector<std::pair<const char*, std::function<void()>>> calls = {
      {"wake", [&] { world.wake(upper); }},
      {"set_pose", [&] { world.set_pose(upper, {}); }},
      {"set_linear_velocity",
       [&] {
         world.set_linear_velocity(upper, {1, 0, 0});
       }},
      {"set_angular_velocity",
       [&] {
         world.set_angular_velocity(upper, {1, 0, 0});
       }},
      {"set_mass_properties", [&] { world.set_mass_properties(upper, {}); }},
      {"reset_mass", [&] { world.reset_mass(upper); }},
      {"set_linear_damping", [&] { world.set_linear_damping(upper, 1); }},
      {"set_angular_damping", [&] { world.set_angular_damping(upper, 1); }},
      {"set_gravity_factor", [&] { world.set_gravity_factor(upper, 2); }},
      {"set_locks", [&] { world.set_locks(upper, AxisLocks::rotation_x); }},
      {"set_can_sleep", [&] { world.set_can_sleep(upper, false); }},
      {"add_force",
       [&] {
         world.add_force(upper, {1, 0, 0});
       }},
      {"add_torque",
       [&] {
         world.add_torque(upper, {1, 0, 0});
       }},
      {"add_impulse",
       [&] {
         world.add_impulse(upper, {1, 0, 0});
       }},
      {"add_angular_impulse",
       [&] {
         world.add_angular_impulse(upper, {1, 0, 0});
       }},
      {"add_shape", [&] { world.add_shape(upper, Sphere{}); }},
      {"set_geometry", [&] { world.set_geometry(upper_shape, Sphere{}); }},
      {"set_material", [&] { world.set_material(upper_shape, {.friction = 0}); }},
      {"set_filter", [&] { world.set_filter(upper_shape, {}); }},
      {"set_local_pose", [&] { world.set_local_pose(upper_shape, {}); }},
      {"destroy_shape", [&] { world.destroy_shape(upper_shape); }},
  };
  for (const auto& [name, call] : calls) {
    SCOPED_TRACE(name);
    sleep_all();
    internals(world).bodies.sleep_time[row_of(upper)] = 0.4f;
    ASSERT_FALSE(world.is_awake(upper));
    call();
    EXPECT_TRUE(world.is_awake(upper));
    EXPECT_EQ(internals(world).bodies.sleep_time[row_of(upper)], 0.0f);
    EXPECT_TRUE(internals(world).bodies.lists_dirty);
    EXPECT_FALSE(world.is_awake(aside));
  }
}

TEST_F(Waking, CallsThatChangeNothingWakeNoBody) {
  world.pose(upper);
  world.mass_properties(upper);
  world.material(upper_shape);
  world.set_user_data(upper, 1);
  world.set_can_sleep(upper, true);
  world.add_shapes(upper, {}, {});
  EXPECT_FALSE(world.is_awake(upper));
}

TEST_F(Waking, DestroyingABodyWakesTheBodiesThatTouchedIt) {
  world.destroy_body(lower);
  EXPECT_TRUE(world.is_awake(upper));
  EXPECT_FALSE(world.is_awake(aside));
}

TEST_F(Waking, DestroyingTheGroundWakesTheBodiesOnIt) {
  world.destroy_body(ground);
  EXPECT_TRUE(world.is_awake(lower));
  EXPECT_FALSE(world.is_awake(upper));  // follows with its island in the next step
}

TEST_F(Waking, ReusedSlotsDoNotHideBodiesThatTouchedTheirPredecessors) {
  world.destroy_body(lower);
  const BodyId successor = world.create_body({});
  const ShapeId successor_shape = world.add_shape(successor, Sphere{});
  ASSERT_EQ(successor.index, lower.index);
  ASSERT_EQ(successor_shape.index, lower_shape.index);
  EXPECT_TRUE(world.is_awake(upper));
}

TEST_F(Waking, ARejectedCreationLeavesDeadSlotsWithTheirBodies) {
  world.destroy_body(lower);
  std::vector<BodyDef> defs(2);
  defs[1].position.x = std::numeric_limits<float>::quiet_NaN();
  std::vector<BodyId> ids(2);
  EXPECT_THROW(world.create_bodies(defs, std::vector<Geometry>(2), {}, {}, ids), Error);
  EXPECT_EQ(internals(world).shapes.body[row_of(lower_shape)], static_cast<std::int32_t>(lower.index));
  EXPECT_TRUE(world.is_awake(upper));
}

TEST_F(Waking, TheRequestIsFulfilledOnceForManyCalls) {
  world.destroy_bodies(std::vector<BodyId>{lower, aside});
  WorldData& data = internals(world);
  EXPECT_TRUE(data.shapes.wake_requested);
  EXPECT_NE(data.bodies.flags[row_of(upper)] & kBodyAsleep, 0);
  wake_neighbors(data);
  EXPECT_EQ(data.bodies.flags[row_of(upper)] & kBodyAsleep, 0);
  EXPECT_FALSE(data.shapes.wake_requested);
  for (const std::uint8_t flags : data.shapes.flags) EXPECT_EQ(flags & kShapeWakes, 0);
}

TEST_F(Waking, MovingOrChangingTheGroundWakesTheBodiesOnIt) {
  const std::vector<std::pair<const char*, std::function<void()>>> calls = {
      {"set_pose",
       [&] {
         world.set_pose(ground, {{0, 1, 0}, {}});
       }},
      {"set_geometry", [&] { world.set_geometry(ground_shape, Sphere{}); }},
      {"set_material", [&] { world.set_material(ground_shape, {.friction = 0}); }},
      {"set_filter", [&] { world.set_filter(ground_shape, {.mask = 0}); }},
      {"set_body_type", [&] { world.set_body_type(ground, BodyType::kinematic); }},
      {"set_linear_velocity",
       [&] {
         world.set_linear_velocity(ground, {1, 0, 0});
       }},
      {"set_mass_properties",
       [&] {
         world.set_mass_properties(ground, {.center = {0, 0.04f, 0}});
       }},
      {"reset_mass", [&] { world.reset_mass(ground); }},
      {"destroy_shape", [&] { world.destroy_shape(ground_shape); }},
  };
  for (const auto& [name, call] : calls) {
    SCOPED_TRACE(name);
    sleep_all();
    call();
    EXPECT_TRUE(world.is_awake(lower));
    EXPECT_FALSE(world.is_awake(aside));
  }
}

TEST_F(Waking, MovingTheGroundWakesBodiesThatItMayTouch) {
  add_pair(world, ground_shape, aside_shape);
  world.set_material(upper_shape, {.friction = 0});
  EXPECT_FALSE(world.is_awake(aside)) << "nothing fixed has moved";
  world.set_pose(ground, {{0, 0.03f, 0}, {}});
  EXPECT_TRUE(world.is_awake(aside));
}

TEST_F(Waking, NewGravityAndDisabledSleepWakeAllBodies) {
  WorldSettings settings;
  settings.substeps = 2;
  world.set_settings(settings);
  EXPECT_FALSE(world.is_awake(aside));
  settings.gravity = {0, 9.81f, 0};
  world.set_settings(settings);
  EXPECT_TRUE(world.is_awake(aside));
  sleep_all();
  settings.sleeping = false;
  world.set_settings(settings);
  EXPECT_TRUE(world.is_awake(aside));
}

TEST_F(Waking, FixedBodiesAreNeverAwakeAndKinematicOnesAlways) {
  EXPECT_FALSE(world.is_awake(ground));
  world.wake(ground);
  EXPECT_FALSE(world.is_awake(ground));
  EXPECT_TRUE(world.is_awake(world.create_body({.type = BodyType::kinematic})));
}

}  // namespace
}  // namespace scree::test
