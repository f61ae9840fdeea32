// Every mistake of a caller ends in an Error that names the call, the value and the limit, and changes
// nothing.
#include <tests/core/world/world_fixture.h>

#include <functional>
#include <limits>
#include <vector>

namespace scree::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

class BadInput : public ::testing::Test {
 protected:
  World world;
  BodyId body = world.create_body({.position = {1, 2, 3}, .linear_velocity = {1, 0, 0}});
  ShapeId shape = world.add_shape(body, Box{});

  // The call throws, names itself, and leaves the world as it was.
  void expect_rejected(const std::string& call, const std::string& word, const std::function<void()>& work) {
    const std::uint64_t hash = world.hash();
    const std::size_t bodies = world.body_count(), shapes = world.shape_count();
    const MassProperties mass = world.mass_properties(body);
    consume_dirty(world);
    const std::string error = error_of(work);
    EXPECT_EQ(error.rfind("World::" + call + ": ", 0), 0u) << call << " said: " << error;
    EXPECT_NE(error.find(word), std::string::npos) << call << " said: " << error;
    EXPECT_EQ(world.hash(), hash);
    EXPECT_EQ(world.body_count(), bodies);
    EXPECT_EQ(world.shape_count(), shapes);
    EXPECT_EQ(world.mass_properties(body).mass, mass.mass);
    EXPECT_TRUE(internals(world).shapes.dirty.empty());
    EXPECT_FALSE(internals(world).contacts.pairs_stale);
  }
};

TEST_F(BadInput, IsRefusedInBodyDefinitions) {
  const auto reject = [&](const std::string& word, auto change) {
    BodyDef def;
    change(def);
    expect_rejected("create_body", word, [&] { world.create_body(def); });
  };
  for (const float bad : {kNan, kInf, -kInf}) {
    reject("position", [&](BodyDef& def) { def.position.y = bad; });
    reject("rotation", [&](BodyDef& def) { def.rotation.w = bad; });
    reject("linear_velocity", [&](BodyDef& def) { def.linear_velocity.x = bad; });
    reject("angular_velocity", [&](BodyDef& def) { def.angular_velocity.z = bad; });
    reject("linear_damping", [&](BodyDef& def) { def.linear_damping = bad; });
    reject("angular_damping", [&](BodyDef& def) { def.angular_damping = bad; });
    reject("gravity_factor", [&](BodyDef& def) { def.gravity_factor = bad; });
    reject("mass", [&](BodyDef& def) { def.mass = bad; });
  }
  reject("mass is -1", [](BodyDef& def) { def.mass = -1.0f; });
  reject("mass is 0", [](BodyDef& def) { def.mass = 0.0f; });
  reject("linear_damping is -1", [](BodyDef& def) { def.linear_damping = -1.0f; });
  reject("angular_damping is -1", [](BodyDef& def) { def.angular_damping = -1.0f; });
  reject("[-10000000, 10000000]", [](BodyDef& def) { def.position.x = 2e7f; });
  reject("length 0", [](BodyDef& def) { def.rotation = {0, 0, 0, 0}; });
  reject("length 2", [](BodyDef& def) { def.rotation = {0, 2, 0, 0}; });
  reject("type", [](BodyDef& def) { def.type = static_cast<BodyType>(3); });
  reject("locks", [](BodyDef& def) { def.locks = static_cast<AxisLocks>(64); });
}

TEST_F(BadInput, IsRefusedInGeometry) {
  for (const float bad : {kNan, kInf, -1.0f, 0.0f, 1e-5f, 1e6f}) {
    const Geometry bad_ones[] = {Sphere{bad},      Capsule{bad, 1},  Capsule{1, bad},
                                 Box{{bad, 1, 1}}, Box{{1, bad, 1}}, Box{{1, 1, bad}}};
    for (const Geometry& geometry : bad_ones) {
      expect_rejected("add_shape", "[", [&] { world.add_shape(body, geometry); });
      expect_rejected("set_geometry", "[", [&] { world.set_geometry(shape, geometry); });
    }
  }
}

TEST_F(BadInput, IsRefusedInMaterials) {
  const auto reject = [&](const std::string& word, auto change) {
    Material material;
    change(material);
    expect_rejected("add_shape", word, [&] { world.add_shape(body, Sphere{}, material); });
    expect_rejected("set_material", word, [&] { world.set_material(shape, material); });
    std::vector<BodyId> ids(1);
    expect_rejected("create_bodies", word, [&] {
      world.create_bodies(std::vector<BodyDef>(1), std::vector<Geometry>(1), material, {}, ids);
    });
  };
  for (const float bad : {kNan, kInf, -1.0f}) {
    reject("friction", [&](Material& m) { m.friction = bad; });
    reject("restitution", [&](Material& m) { m.restitution = bad; });
    reject("rolling_resistance", [&](Material& m) { m.rolling_resistance = bad; });
    reject("patch_radius", [&](Material& m) { m.patch_radius = bad; });
    reject("density", [&](Material& m) { m.density = bad; });
  }
  reject("density is 0", [](Material& m) { m.density = 0.0f; });
  reject("restitution is 1.5", [](Material& m) { m.restitution = 1.5f; });
  reject("surface_velocity", [](Material& m) { m.surface_velocity.y = kNan; });
  reject("friction_mix", [](Material& m) { m.friction_mix = static_cast<MixRule>(5); });
  reject("restitution_mix", [](Material& m) { m.restitution_mix = static_cast<MixRule>(5); });
}

TEST_F(BadInput, IsRefusedInLocalPoses) {
  for (const Pose& bad : {Pose{{kNan, 0, 0}, {}}, Pose{{0, 2e5f, 0}, {}}, Pose{{}, {1, 1, 1, 1}}}) {
    expect_rejected("add_shape", "local_pose",
                    [&] { world.add_shape(body, Sphere{}, {}, {.local_pose = bad}); });
    expect_rejected("set_local_pose", "", [&] { world.set_local_pose(shape, bad); });
  }
}

TEST_F(BadInput, IsRefusedByCallsThatChangeABody) {
  for (const float bad : {kNan, kInf}) {
    const Vec3 v{0, bad, 0};
    expect_rejected("set_pose", "position", [&] { world.set_pose(body, {v, {}}); });
    expect_rejected("set_pose", "rotation", [&] { world.set_pose(body, {{}, {0, 0, 0, bad}}); });
    expect_rejected("set_linear_velocity", "velocity", [&] { world.set_linear_velocity(body, v); });
    expect_rejected("set_angular_velocity", "velocity", [&] { world.set_angular_velocity(body, v); });
    expect_rejected("velocity_at", "world_point", [&] { world.velocity_at(body, v); });
    expect_rejected("set_linear_damping", "damping", [&] { world.set_linear_damping(body, bad); });
    expect_rejected("set_angular_damping", "damping", [&] { world.set_angular_damping(body, bad); });
    expect_rejected("set_gravity_factor", "factor", [&] { world.set_gravity_factor(body, bad); });
    expect_rejected("add_force", "force", [&] { world.add_force(body, v); });
    expect_rejected("add_torque", "torque", [&] { world.add_torque(body, v); });
    expect_rejected("add_force_at", "force", [&] { world.add_force_at(body, v, {}); });
    expect_rejected("add_force_at", "world_point", [&] { world.add_force_at(body, {}, v); });
    expect_rejected("add_impulse", "impulse", [&] { world.add_impulse(body, v); });
    expect_rejected("add_impulse_at", "impulse", [&] { world.add_impulse_at(body, v, {}); });
    expect_rejected("add_impulse_at", "world_point", [&] { world.add_impulse_at(body, {}, v); });
    expect_rejected("add_angular_impulse", "impulse", [&] { world.add_angular_impulse(body, v); });
  }
  expect_rejected("set_linear_damping", "-1", [&] { world.set_linear_damping(body, -1); });
  expect_rejected("set_angular_damping", "-1", [&] { world.set_angular_damping(body, -1); });
  expect_rejected("set_body_type", "type", [&] { world.set_body_type(body, static_cast<BodyType>(9)); });
  expect_rejected("set_locks", "locks", [&] { world.set_locks(body, static_cast<AxisLocks>(200)); });
}

TEST_F(BadInput, LoadsThatWouldOverflowAreRefused) {
  expect_rejected("add_force", "acceleration", [&] { world.add_force(body, {1e25f, 0, 0}); });
  expect_rejected("add_torque", "angular acceleration", [&] { world.add_torque(body, {1e25f, 0, 0}); });
  expect_rejected("add_impulse", "velocity", [&] { world.add_impulse(body, {1e25f, 0, 0}); });
  expect_rejected("add_angular_impulse", "velocity", [&] { world.add_angular_impulse(body, {1e25f, 0, 0}); });
  // Each alone is fine, the sum is not.
  for (int i = 0; i < 2; ++i) world.add_force(body, {4e17f, 0, 0});
  expect_rejected("add_force", "acceleration", [&] { world.add_force(body, {4e17f, 0, 0}); });
}

TEST_F(BadInput, IsRefusedInMassProperties) {
  const auto reject = [&](const std::string& word, auto change) {
    scree::MassProperties properties;
    change(properties);
    expect_rejected("set_mass_properties", word, [&] { world.set_mass_properties(body, properties); });
  };
  for (const float bad : {kNan, kInf, 0.0f, -1.0f}) {
    reject("mass", [&](auto& p) { p.mass = bad; });
    for (int i = 0; i < 3; ++i) reject("inertia", [&](auto& p) { p.inertia[i] = bad; });
  }
  reject("center", [](auto& p) { p.center.x = kNan; });
  reject("inertia", [](auto& p) { p.inertia[4] = kNan; });
  reject("positive definite", [](auto& p) { p.inertia[3] = 2.0f; });
  reject("no solid", [](auto& p) { p.inertia[0] = 3.0f; });
}

TEST_F(BadInput, DeadHandlesAreRefused) {
  const BodyId dead = world.create_body({});
  const ShapeId dead_shape = world.add_shape(dead, Sphere{});
  world.destroy_body(dead);
  const std::pair<const char*, std::function<void()>> calls[] = {
      {"destroy_body", [&] { world.destroy_body(dead); }},
      {"destroy_bodies",
       [&] {
         world.destroy_bodies(std::vector<BodyId>{body, dead});
       }},
      {"body_type", [&] { world.body_type(dead); }},
      {"set_body_type", [&] { world.set_body_type(dead, BodyType::fixed); }},
      {"pose", [&] { world.pose(dead); }},
      {"set_pose", [&] { world.set_pose(dead, {}); }},
      {"linear_velocity", [&] { world.linear_velocity(dead); }},
      {"angular_velocity", [&] { world.angular_velocity(dead); }},
      {"velocity_at", [&] { world.velocity_at(dead, {}); }},
      {"set_linear_velocity", [&] { world.set_linear_velocity(dead, {}); }},
      {"set_angular_velocity", [&] { world.set_angular_velocity(dead, {}); }},
      {"center_of_mass", [&] { world.center_of_mass(dead); }},
      {"mass_properties", [&] { world.mass_properties(dead); }},
      {"set_mass_properties", [&] { world.set_mass_properties(dead, {}); }},
      {"reset_mass", [&] { world.reset_mass(dead); }},
      {"linear_damping", [&] { world.linear_damping(dead); }},
      {"angular_damping", [&] { world.angular_damping(dead); }},
      {"gravity_factor", [&] { world.gravity_factor(dead); }},
      {"locks", [&] { world.locks(dead); }},
      {"set_linear_damping", [&] { world.set_linear_damping(dead, 0); }},
      {"set_angular_damping", [&] { world.set_angular_damping(dead, 0); }},
      {"set_gravity_factor", [&] { world.set_gravity_factor(dead, 0); }},
      {"set_locks", [&] { world.set_locks(dead, AxisLocks::none); }},
      {"can_sleep", [&] { world.can_sleep(dead); }},
      {"set_can_sleep", [&] { world.set_can_sleep(dead, true); }},
      {"full_sweep", [&] { world.full_sweep(dead); }},
      {"set_full_sweep", [&] { world.set_full_sweep(dead, true); }},
      {"is_awake", [&] { world.is_awake(dead); }},
      {"wake", [&] { world.wake(dead); }},
      {"user_data", [&] { world.user_data(dead); }},
      {"set_user_data", [&] { world.set_user_data(dead, 1); }},
      {"add_force", [&] { world.add_force(dead, {}); }},
      {"add_force_at", [&] { world.add_force_at(dead, {}, {}); }},
      {"add_torque", [&] { world.add_torque(dead, {}); }},
      {"add_impulse", [&] { world.add_impulse(dead, {}); }},
      {"add_impulse_at", [&] { world.add_impulse_at(dead, {}, {}); }},
      {"add_angular_impulse", [&] { world.add_angular_impulse(dead, {}); }},
      {"add_shape", [&] { world.add_shape(dead, Sphere{}); }},
      {"shapes_of", [&] { world.shapes_of(dead, {}); }},
      {"destroy_shape", [&] { world.destroy_shape(dead_shape); }},
      {"body_of", [&] { world.body_of(dead_shape); }},
      {"geometry", [&] { world.geometry(dead_shape); }},
      {"set_geometry", [&] { world.set_geometry(dead_shape, Sphere{}); }},
      {"material", [&] { world.material(dead_shape); }},
      {"set_material", [&] { world.set_material(dead_shape, {}); }},
      {"filter", [&] { world.filter(dead_shape); }},
      {"set_filter", [&] { world.set_filter(dead_shape, {}); }},
      {"is_sensor", [&] { world.is_sensor(dead_shape); }},
      {"visitors_of", [&] { world.visitors_of(dead_shape, {}); }},
      {"local_pose", [&] { world.local_pose(dead_shape); }},
      {"set_local_pose", [&] { world.set_local_pose(dead_shape, {}); }},
      {"user_data", [&] { world.user_data(dead_shape); }},
      {"set_user_data", [&] { world.set_user_data(dead_shape, 1); }},
  };
  for (const auto& [name, call] : calls) expect_rejected(name, "it was destroyed", call);
}

TEST_F(BadInput, BulkCreationIsAllOrNothing) {
  std::vector<BodyDef> defs(100);
  std::vector<Geometry> geometries(100, Sphere{0.5f});
  std::vector<BodyId> ids(100);
  world.destroy_body(world.create_body({}));  // a free slot, which must stay free
  const std::size_t rows = world.poses().size();
  defs[57].mass = -2.0f;
  expect_rejected("create_bodies", "definition 57: mass is -2", [&] { world.create_bodies(defs, ids); });
  defs[57].mass.reset();
  geometries[99] = Sphere{-1.0f};
  expect_rejected("create_bodies", "definition 99: sphere radius is -1",
                  [&] { world.create_bodies(defs, geometries, {}, {}, ids); });
  EXPECT_EQ(ids, std::vector<BodyId>(100));
  EXPECT_EQ(world.poses().size(), rows);
  geometries[99] = Sphere{1.0f};
  world.create_bodies(defs, geometries, {}, {}, ids);
  EXPECT_EQ(world.body_count(), 101u);
  EXPECT_EQ(world.poses().size(), rows + 99);
}

TEST_F(BadInput, SpansOfUnequalLengthAreRefused) {
  std::vector<BodyId> ids(2);
  expect_rejected("create_bodies", "3 definitions",
                  [&] { world.create_bodies(std::vector<BodyDef>(3), ids); });
  expect_rejected("create_bodies", "1 shapes", [&] {
    world.create_bodies(std::vector<BodyDef>(2), std::vector<Geometry>(1), {}, {}, ids);
  });
}

TEST_F(BadInput, IsRefusedInListsOfShapes) {
  std::vector<ShapeDef> defs(20);
  std::vector<ShapeId> ids(20);
  world.destroy_shape(world.add_shape(body, Box{}));  // a free slot, which must stay free
  const auto reject = [&](const std::string& word, auto change) {
    ShapeDef& def = defs[7];
    change(def);
    expect_rejected("add_shapes", word, [&] { world.add_shapes(body, defs, ids); });
    def = {};
  };
  reject("definition 7: sphere radius is -1", [](ShapeDef& def) { def.geometry = Sphere{-1.0f}; });
  reject("definition 7: ", [](ShapeDef& def) { def.geometry = ConvexHull{}; });
  reject("definition 7: density is 0", [](ShapeDef& def) { def.material.density = 0.0f; });
  reject("definition 7: local_pose", [](ShapeDef& def) { def.options.local_pose.position.x = kNan; });
  reject("definition 7: ", [](ShapeDef& def) { def.options.contact_events = static_cast<ContactEvents>(9); });
  ids.pop_back();
  expect_rejected("add_shapes", "20 definitions", [&] { world.add_shapes(body, defs, ids); });
  ids.emplace_back();
  expect_rejected("add_shapes", "body", [&] { world.add_shapes({body.index, 99}, defs, ids); });
  EXPECT_EQ(ids, std::vector<ShapeId>(20));
  EXPECT_EQ(world.shapes_of(body, {}), 1u);
  world.add_shapes(body, defs, ids);
  EXPECT_EQ(world.shapes_of(body, {}), 21u);
  EXPECT_EQ(internals(world).shapes.flags.size(), 21u);
}

TEST_F(BadInput, ABodyListedTwiceForDestructionIsRefused) {
  const BodyId other = world.create_body({});
  expect_rejected("destroy_bodies", "definition 2: the same body", [&] {
    world.destroy_bodies(std::vector<BodyId>{other, body, other});
  });
  world.destroy_bodies(std::vector<BodyId>{other, body});
  EXPECT_EQ(world.body_count(), 0u);
}

TEST_F(BadInput, IsRefusedInSettings) {
  const auto reject = [&](const std::string& word, auto change) {
    WorldSettings settings;
    change(settings);
    expect_rejected("set_settings", word, [&] { world.set_settings(settings); });
    EXPECT_NE(error_of([&] { World another(settings); }).find(word), std::string::npos);
    EXPECT_EQ(world.settings().substeps, 4);
  };
  for (const float bad : {kNan, kInf, -1.0f}) {
    reject("contact_hertz", [&](WorldSettings& s) { s.contact_hertz = bad; });
    reject("contact_damping_ratio", [&](WorldSettings& s) { s.contact_damping_ratio = bad; });
    reject("push_speed", [&](WorldSettings& s) { s.push_speed = bad; });
    reject("restitution_threshold", [&](WorldSettings& s) { s.restitution_threshold = bad; });
    reject("hit_event_speed", [&](WorldSettings& s) { s.hit_event_speed = bad; });
    reject("max_linear_speed", [&](WorldSettings& s) { s.max_linear_speed = bad; });
    reject("max_angular_speed", [&](WorldSettings& s) { s.max_angular_speed = bad; });
    reject("sleep_linear_speed", [&](WorldSettings& s) { s.sleep_linear_speed = bad; });
    reject("sleep_angular_speed", [&](WorldSettings& s) { s.sleep_angular_speed = bad; });
    reject("sleep_time", [&](WorldSettings& s) { s.sleep_time = bad; });
    reject("solver_options.tolerance", [&](WorldSettings& s) { s.solver_options.tolerance = bad; });
    reject("solver_options.relaxation", [&](WorldSettings& s) { s.solver_options.relaxation = bad; });
    reject("solver_options.baumgarte", [&](WorldSettings& s) { s.solver_options.baumgarte = bad; });
    reject("solver_options.slop", [&](WorldSettings& s) { s.solver_options.slop = bad; });
  }
  reject("gravity", [](WorldSettings& s) { s.gravity.y = kNan; });
  reject("hit_event_speed is 2000000", [](WorldSettings& s) { s.hit_event_speed = 2e6f; });
  reject("contact_events is 8", [](WorldSettings& s) { s.contact_events = static_cast<ContactEvents>(8); });
  reject("substeps is 0", [](WorldSettings& s) { s.substeps = 0; });
  reject("substeps is 65", [](WorldSettings& s) { s.substeps = 65; });
  reject("contact_hertz is 0", [](WorldSettings& s) { s.contact_hertz = 0; });
  reject("solver is 8", [](WorldSettings& s) { s.solver = static_cast<Solver>(kSolverCount); });
  reject("iterations is 0", [](WorldSettings& s) { s.solver_options.iterations = 0; });
  reject("baumgarte", [](WorldSettings& s) { s.solver_options.baumgarte = 1.01f; });
  reject("relaxation", [](WorldSettings& s) { s.solver_options.relaxation = 2.0f; });
}

TEST_F(BadInput, ExtremesWithinTheLimitsAreAccepted) {
  world.create_body({.position = {1e6f, -1e6f, 1e6f}, .linear_velocity = {1e6f, 0, 0}});
  const BodyId tiny = world.create_body({});
  world.add_shape(tiny, Sphere{1e-4f}, {.density = 1e-6f});
  const BodyId huge = world.create_body({});
  world.add_shape(huge, Box{{1e5f, 1e5f, 1e5f}}, {.density = 1e9f});
  const BodyId needle = world.create_body({});
  world.add_shape(needle, Capsule{1e5f, 1e-4f});
  for (const BodyId id : {tiny, huge, needle}) {
    const InertiaRow& inverse = internals(world).bodies.local_mass[row_of(id)];
    EXPECT_TRUE(inverse.inverse_mass > 0.0f && inverse.inverse_mass < kInf);
    for (const int diagonal : {0, 3, 5}) {
      EXPECT_TRUE(inverse.inverse_inertia[diagonal] > 0.0f && inverse.inverse_inertia[diagonal] < kInf);
    }
  }
}

TEST_F(BadInput, NearlyUnitRotationsAreNormalized) {
  const BodyId turned = world.create_body({.rotation = {0.6004f, 0, 0, 0.8f}});
  const Quat q = world.pose(turned).rotation;
  EXPECT_NEAR(q.x * q.x + q.w * q.w, 1.0f, 1e-6f);
}

}  // namespace
}  // namespace scree::test
