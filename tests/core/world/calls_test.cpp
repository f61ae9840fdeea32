// Effects of the changing calls on motion; reading calls return the values that were set.
#include <core/world/math.h>
#include <tests/core/world/world_fixture.h>

#include <vector>

namespace scree::test {
namespace {

TEST(Calls, ABodyHoldsWhatItsDefinitionSays) {
  World world;
  const BodyDef def{.type = BodyType::kinematic,
                    .position = {1, 2, 3},
                    .rotation = {0, 1, 0, 0},
                    .linear_velocity = {4, 5, 6},
                    .angular_velocity = {7, 8, 9},
                    .linear_damping = 0.1f,
                    .angular_damping = 0.2f,
                    .gravity_factor = -0.5f,
                    .locks = AxisLocks::translation_z | AxisLocks::rotation_x,
                    .can_sleep = false,
                    .user_data = 42};
  const BodyId body = world.create_body(def);
  EXPECT_EQ(world.body_type(body), def.type);
  EXPECT_EQ(world.pose(body), (Pose{def.position, def.rotation}));
  EXPECT_EQ(world.linear_velocity(body), def.linear_velocity);
  EXPECT_EQ(world.angular_velocity(body), def.angular_velocity);
  EXPECT_EQ(world.velocities()[body.index].linear, def.linear_velocity);
  EXPECT_EQ(world.velocities()[body.index].angular, def.angular_velocity);
  EXPECT_EQ(world.linear_damping(body), def.linear_damping);
  EXPECT_EQ(world.angular_damping(body), def.angular_damping);
  EXPECT_EQ(world.gravity_factor(body), def.gravity_factor);
  EXPECT_EQ(world.locks(body), def.locks);
  EXPECT_EQ(world.can_sleep(body), def.can_sleep);
  EXPECT_EQ(world.user_data(body), def.user_data);
}

TEST(Calls, AShapeHoldsWhatItWasMadeOf) {
  World world;
  const BodyId body = world.create_body({});
  const Material material{.friction = 0.1f,
                          .restitution = 0.2f,
                          .rolling_resistance = 0.3f,
                          .density = 400.0f,
                          .patch_radius = 0.6f,
                          .surface_velocity = {1, 2, 3},
                          .friction_mix = MixRule::maximum,
                          .restitution_mix = MixRule::product};
  const ShapeOptions options{.local_pose = {{1, 2, 3}, {0, 0, 1, 0}},
                             .filter = {.category = 2, .mask = 5, .group = -3},
                             .user_data = 77};
  const ShapeId shape = world.add_shape(body, Capsule{0.75f, 0.5f}, material, options);
  EXPECT_EQ(world.body_of(shape), body);
  EXPECT_EQ(std::get<Capsule>(world.geometry(shape)).half_height, 0.75f);
  EXPECT_EQ(std::get<Capsule>(world.geometry(shape)).radius, 0.5f);
  const Material found = world.material(shape);
  EXPECT_EQ(found.friction, material.friction);
  EXPECT_EQ(found.restitution, material.restitution);
  EXPECT_EQ(found.rolling_resistance, material.rolling_resistance);
  EXPECT_EQ(found.density, material.density);
  EXPECT_EQ(found.patch_radius, material.patch_radius);
  EXPECT_EQ(found.surface_velocity, material.surface_velocity);
  EXPECT_EQ(found.friction_mix, material.friction_mix);
  EXPECT_EQ(found.restitution_mix, material.restitution_mix);
  EXPECT_EQ(world.filter(shape).category, 2u);
  EXPECT_EQ(world.filter(shape).mask, 5u);
  EXPECT_EQ(world.filter(shape).group, -3);
  EXPECT_EQ(world.local_pose(shape), options.local_pose);
  EXPECT_EQ(world.user_data(shape), 77u);
  EXPECT_NE(internals(world).shapes.material[row_of(shape)].rules & kMaterialMoves, 0u);
  world.set_material(shape, {});
  EXPECT_EQ(world.material(shape).patch_radius, std::nullopt);
  EXPECT_EQ(internals(world).shapes.material[row_of(shape)].rules & kMaterialMoves, 0u);
}

TEST(Calls, SettersAreReadBack) {
  World world;
  const BodyId body = world.create_body({});
  world.set_pose(body, {{3, 2, 1}, {1, 0, 0, 0}});
  world.set_linear_velocity(body, {1, 1, 1});
  world.set_angular_velocity(body, {2, 2, 2});
  world.set_linear_damping(body, 3);
  world.set_angular_damping(body, 4);
  world.set_gravity_factor(body, 5);
  world.set_can_sleep(body, false);
  world.set_full_sweep(body, true);
  world.set_user_data(body, 6);
  EXPECT_EQ(world.pose(body), (Pose{{3, 2, 1}, {1, 0, 0, 0}}));
  EXPECT_EQ(world.linear_velocity(body), (Vec3{1, 1, 1}));
  EXPECT_EQ(world.angular_velocity(body), (Vec3{2, 2, 2}));
  EXPECT_EQ(world.linear_damping(body), 3.0f);
  EXPECT_EQ(world.angular_damping(body), 4.0f);
  EXPECT_EQ(world.gravity_factor(body), 5.0f);
  EXPECT_TRUE(world.full_sweep(body));
  EXPECT_FALSE(world.can_sleep(body));
  EXPECT_EQ(world.user_data(body), 6u);
}

TEST(Calls, AnImpulseChangesTheVelocityByItselfOverTheMass) {
  World world;
  const BodyId body = world.create_body({.mass = 4.0f});
  world.add_impulse(body, {8, 0, -4});
  EXPECT_EQ(world.linear_velocity(body), (Vec3{2, 0, -1}));
  EXPECT_EQ(world.angular_velocity(body), Vec3{});
}

TEST(Calls, AnImpulseOffTheCenterChangesTheAngularMomentumByItsMoment) {
  World world;
  const BodyId body = world.create_body({.position = {1, 1, 1}, .rotation = {0.6f, 0, 0, 0.8f}});
  world.add_shape(body, Box{{0.5f, 1.0f, 1.5f}}, {.density = 1.0f}, {.local_pose = {{0.5f, 0, 0}, {}}});
  const Vec3 point{2, 3, 1}, impulse{1, -2, 3};
  world.add_impulse_at(body, impulse, point);
  const Vec3 moment = cross(point - world.center_of_mass(body), impulse);
  const Quat rotation = world.pose(body).rotation;
  const Vec3 w = rotate_back(rotation, world.angular_velocity(body));
  const float* inertia = internals(world).bodies.local_inertia[row_of(body)].inertia;
  const Vec3 momentum = rotate(rotation, {inertia[0] * w.x, inertia[3] * w.y, inertia[5] * w.z});
  EXPECT_NEAR(length(momentum - moment), 0.0f, 1e-5f);
  World twin;
  const BodyId other = twin.create_body({.position = {1, 1, 1}, .rotation = {0.6f, 0, 0, 0.8f}});
  twin.add_shape(other, Box{{0.5f, 1.0f, 1.5f}}, {.density = 1.0f}, {.local_pose = {{0.5f, 0, 0}, {}}});
  twin.add_impulse(other, impulse);
  twin.add_angular_impulse(other, moment);
  EXPECT_EQ(twin.hash(), world.hash());
}

TEST(Calls, ForcesAndTorquesAddUp) {
  World world;
  const BodyId body = world.create_body({.position = {0, 1, 0}});
  world.add_force(body, {1, 0, 0});
  world.add_force_at(body, {0, 0, 2}, {3, 1, 0});
  world.add_torque(body, {5, 0, 0});
  const ForceRow& load = internals(world).bodies.force[row_of(body)];
  EXPECT_EQ((Vec3{load.force[0], load.force[1], load.force[2]}), (Vec3{1, 0, 2}));
  EXPECT_EQ((Vec3{load.torque[0], load.torque[1], load.torque[2]}), (Vec3{5, -6, 0}));
}

TEST(Calls, NothingPushesFixedAndKinematicBodies) {
  World world;
  for (const BodyType type : {BodyType::fixed, BodyType::kinematic}) {
    const BodyId body = world.create_body({.type = type});
    world.add_shape(body, Box{});
    world.add_force(body, {1, 1, 1});
    world.add_torque(body, {1, 1, 1});
    world.add_impulse_at(body, {1, 1, 1}, {1, 0, 0});
    EXPECT_EQ(world.linear_velocity(body), Vec3{});
    EXPECT_EQ(world.angular_velocity(body), Vec3{});
    EXPECT_EQ(internals(world).bodies.force[row_of(body)].force[0], 0.0f);
    EXPECT_EQ(internals(world).bodies.local_mass[row_of(body)].inverse_mass, 0.0f);
  }
}

TEST(Calls, FixedBodiesHaveNoVelocity) {
  World world;
  const BodyId body = world.create_body({.type = BodyType::fixed, .linear_velocity = {1, 0, 0}});
  EXPECT_EQ(world.linear_velocity(body), Vec3{});
  world.set_linear_velocity(body, {1, 0, 0});
  world.set_angular_velocity(body, {1, 0, 0});
  EXPECT_EQ(world.linear_velocity(body), Vec3{});
  EXPECT_EQ(world.angular_velocity(body), Vec3{});
  const BodyId mover = world.create_body({.linear_velocity = {1, 0, 0}});
  world.set_body_type(mover, BodyType::fixed);
  EXPECT_EQ(world.linear_velocity(mover), Vec3{});
}

TEST(Calls, LockedAxesHaveNoVelocity) {
  World world;
  const AxisLocks planar = AxisLocks::translation_z | AxisLocks::rotation_x | AxisLocks::rotation_y;
  const BodyId body =
      world.create_body({.linear_velocity = {1, 2, 3}, .angular_velocity = {4, 5, 6}, .locks = planar});
  EXPECT_EQ(world.linear_velocity(body), (Vec3{1, 2, 0}));
  EXPECT_EQ(world.angular_velocity(body), (Vec3{0, 0, 6}));
  world.add_impulse_at(body, {1, 1, 1}, {1, 2, 3});
  EXPECT_EQ(world.linear_velocity(body).z, 0.0f);
  EXPECT_EQ(world.angular_velocity(body).x, 0.0f);
  EXPECT_EQ(world.angular_velocity(body).y, 0.0f);
  world.set_locks(body, AxisLocks::none);
  world.set_linear_velocity(body, {7, 8, 9});
  EXPECT_EQ(world.linear_velocity(body), (Vec3{7, 8, 9}));
  world.set_locks(body, AxisLocks::translation_x);
  EXPECT_EQ(world.linear_velocity(body), (Vec3{0, 8, 9}));
}

TEST(Calls, LocksActWhileTheBodyIsDynamic) {
  World world;
  const AxisLocks locks = AxisLocks::translation_x | AxisLocks::rotation_y;
  const BodyId body = world.create_body({.type = BodyType::kinematic,
                                         .linear_velocity = {1, 2, 3},
                                         .angular_velocity = {4, 5, 6},
                                         .locks = locks});
  world.add_shape(body, Box{});
  const auto acting = [&] { return internals(world).bodies.motion[row_of(body)].flags & kMotionLocksMask; };
  EXPECT_EQ(world.locks(body), locks);
  EXPECT_EQ(acting(), 0u);
  EXPECT_EQ(world.linear_velocity(body), (Vec3{1, 2, 3}));
  world.set_body_type(body, BodyType::dynamic);
  EXPECT_EQ(world.locks(body), locks);
  EXPECT_EQ(acting(), static_cast<std::uint32_t>(locks));
  EXPECT_EQ(world.linear_velocity(body), (Vec3{0, 2, 3}));
  EXPECT_EQ(world.angular_velocity(body), (Vec3{4, 0, 6}));
  world.set_body_type(body, BodyType::kinematic);
  world.set_locks(body, AxisLocks::translation_z);
  EXPECT_EQ(world.locks(body), AxisLocks::translation_z);
  EXPECT_EQ(acting(), 0u);
  world.set_body_type(body, BodyType::dynamic);
  EXPECT_EQ(world.linear_velocity(body), (Vec3{0, 2, 0}));
}

TEST(Calls, TheTransformColumnFollowsFromThePoseRow) {
  World world;
  const BodyId body = world.create_body({.position = {1, 2, 3}, .rotation = {0.6f, 0, 0, 0.8f}});
  world.add_shape(body, Box{}, {}, {.local_pose = {{5, 6, 7}, {}}});
  world.set_pose(body, {{0.1f, 0.2f, 0.3f}, {0, 0.6f, 0, 0.8f}});
  const Bodies& bodies = internals(world).bodies;
  const PoseRow& pose = bodies.pose[row_of(body)];
  const Quat rotation{pose.rotation[0], pose.rotation[1], pose.rotation[2], pose.rotation[3]};
  const Vec3 origin = Vec3{pose.position[0], pose.position[1], pose.position[2]} -
                      rotate(rotation, bodies.center[row_of(body)]);
  EXPECT_EQ(world.pose(body), (Pose{origin, rotation}));
  EXPECT_NEAR(length(origin - Vec3{0.1f, 0.2f, 0.3f}), 0.0f, 1e-6f);
}

TEST(Calls, SettingsAreReadBack) {
  World world;
  WorldSettings settings;
  settings.substeps = 8;
  settings.gravity = {1, 2, 3};
  world.set_settings(settings);
  EXPECT_EQ(world.settings().substeps, 8);
  EXPECT_EQ(world.settings().gravity, (Vec3{1, 2, 3}));
}

// --- marks that calls leave for the broad phase ---

class Marks : public ::testing::Test {
 protected:
  World world;
  BodyId body = world.create_body({});
  ShapeId shape = world.add_shape(body, Box{});
  ShapeId bystander = world.add_shape(world.create_body({}), Box{});

  void SetUp() override { consume_dirty(world); }
  std::uint8_t flags(ShapeId id) { return internals(world).shapes.flags[row_of(id)]; }
};

TEST_F(Marks, MovedShapesAreDirtyButKeepTheirHistory) {
  world.set_pose(body, {{1, 0, 0}, {}});
  world.set_pose(body, {{2, 0, 0}, {}});
  EXPECT_EQ(flags(shape), kShapeAlive | kShapeDirty | kShapeWakes);
  EXPECT_EQ(flags(bystander), kShapeAlive);
  ASSERT_EQ(internals(world).shapes.dirty.size(), 1u);
  EXPECT_EQ(internals(world).shapes.dirty[0], static_cast<std::int32_t>(shape.index));
}

TEST_F(Marks, ChangedGeometryOrTypeLosesItsHistory) {
  world.set_geometry(shape, Sphere{});
  EXPECT_NE(flags(shape) & kShapeNew, 0);
  EXPECT_TRUE(internals(world).contacts.pairs_stale);
  consume_dirty(world);
  world.set_body_type(body, BodyType::kinematic);
  EXPECT_NE(flags(shape) & kShapeNew, 0);
  EXPECT_TRUE(internals(world).contacts.pairs_stale);
}

TEST_F(Marks, AFilterChangeReconsidersThePairs) {
  world.set_filter(shape, {.mask = 0});
  EXPECT_NE(flags(shape) & kShapeDirty, 0);
  EXPECT_EQ(flags(shape) & kShapeNew, 0);
  EXPECT_TRUE(internals(world).contacts.pairs_stale);
}

TEST_F(Marks, AReusedSlotIsNew) {
  world.destroy_shape(shape);
  EXPECT_EQ(flags(shape) & (kShapeAlive | kShapeDirty), kShapeDirty);
  const ShapeId successor = world.add_shape(body, Sphere{});
  ASSERT_EQ(successor.index, shape.index);
  EXPECT_EQ(flags(successor) & (kShapeAlive | kShapeDirty | kShapeNew),
            kShapeAlive | kShapeDirty | kShapeNew);
  EXPECT_EQ(internals(world).shapes.dirty.size(), 1u);
}

TEST_F(Marks, TreesFollowTypeAndSleep) {
  const auto tree = [&] { return internals(world).shapes.tree[row_of(shape)]; };
  EXPECT_EQ(tree(), TreeKind::awake);
  put_to_sleep(world, body);
  EXPECT_EQ(tree(), TreeKind::frozen);
  world.wake(body);
  EXPECT_EQ(tree(), TreeKind::awake);
  world.set_body_type(body, BodyType::kinematic);
  EXPECT_EQ(tree(), TreeKind::kinematic);
  world.set_body_type(body, BodyType::fixed);
  EXPECT_EQ(tree(), TreeKind::frozen);
  world.destroy_shape(shape);
  EXPECT_EQ(tree(), TreeKind::none);
}

TEST_F(Marks, OnlyCallsThatChangeWhatMovesMakeTheListsDirty) {
  world.set_linear_velocity(body, {1, 0, 0});
  world.set_pose(body, {});
  world.add_force(body, {1, 0, 0});
  EXPECT_FALSE(internals(world).bodies.lists_dirty);
  world.create_body({});
  EXPECT_TRUE(internals(world).bodies.lists_dirty);
}

}  // namespace
}  // namespace scree::test
