// Laws of the adapters: what a scene says happens in every engine that is there, or its adapter refuses.
#include "bench/engine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace scree::bench {
namespace {

using scenes::Scene;

constexpr float kDt = 1.0f / 60.0f;
constexpr float kNear = 0.03f;  // m, the least that all engines keep to

std::uint32_t add_one(Scene& scene, const Geometry& geometry, const BodyDef& def,
                      const Material& material = {}) {
  scenes::SceneBody body;
  body.def = def;
  body.first_shape = static_cast<std::uint32_t>(scene.shapes.size());
  body.shape_count = 1;
  scene.shapes.push_back({geometry, material, {}});
  scene.bodies.push_back(body);
  return static_cast<std::uint32_t>(scene.bodies.size() - 1);
}

// A square in the plane y = 0, seen from above.
TriangleMesh plate(float half_width) {
  const std::vector<Vec3> vertices = {{-half_width, 0, -half_width},
                                      {-half_width, 0, half_width},
                                      {half_width, 0, -half_width},
                                      {half_width, 0, half_width}};
  return TriangleMesh(vertices, std::vector<MeshTriangle>{{0, 1, 2}, {2, 1, 3}});
}

// Runs the scene in every engine and hands on the final states. Returns the engines that refused it.
std::vector<std::string> in_every_engine(
    const Scene& scene, int steps,
    const std::function<void(const std::string&, const std::vector<BodyState>&)>& check) {
  std::vector<std::string> refused;
  for (const EngineInfo& info : engines()) {
    std::unique_ptr<Engine> engine;
    try {
      check_scene(info, scene);
      engine = info.create({&scene, 1}, {.threads = 1, .continuous = scene.settings.continuous});
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("does not support "), std::string::npos) << error.what();
      refused.push_back(info.name);
      continue;
    }
    for (int step = 0; step < steps; ++step) {
      for (const scenes::SceneDrive& drive : scene.drives) {
        const double end = (step + 1) * double{kDt};
        engine->move_kinematic(0, drive.body, scenes::drive_target(drive, end), kDt);
      }
      engine->step(kDt);
    }
    std::vector<BodyState> states;
    engine->read(0, states);
    check(info.name, states);
    EXPECT_EQ(engine->complaint(), "") << info.name;
  }
  return refused;
}

TEST(Engines, BodiesRestOnMeshesAndHalfSpaces) {
  for (const Geometry& ground : {Geometry{plate(5.0f)}, Geometry{HalfSpace{}}}) {
    Scene scene;
    add_one(scene, ground, {.type = BodyType::fixed, .position = {0, 2, 0}});
    add_one(scene, Sphere{0.5f}, {.position = {-2.1f, 2.7f, 0.3f}});
    add_one(scene, Box{{0.5f, 0.3f, 0.5f}}, {.position = {0.2f, 2.5f, 0.1f}});
    add_one(scene, Capsule{0.4f, 0.3f}, {.position = {2.2f, 2.8f, 0.4f}});
    const auto refused = in_every_engine(scene, 120, [](const std::string& engine, const auto& states) {
      EXPECT_NEAR(states[1].pose.position.y, 2.5f, kNear) << engine;
      EXPECT_NEAR(states[2].pose.position.y, 2.3f, kNear) << engine;
      EXPECT_NEAR(states[3].pose.position.y, 2.7f, kNear) << engine;
    });
    EXPECT_TRUE(refused.empty()) << refused.front();
  }
}

TEST(Engines, ShapesOfMeshesHaveTheirPlaceInTheBody) {
  const auto half = static_cast<float>(std::sqrt(0.5));
  for (const Geometry& ground : {Geometry{plate(5.0f)}, Geometry{HalfSpace{}}}) {
    Scene scene;
    // The body turns y to x, and the shape turns it back.
    add_one(scene, ground, {.type = BodyType::fixed, .position = {0, 2, 0}, .rotation = {0, 0, -half, half}});
    scene.shapes[0].options.local_pose = {{-1.0f, 0, 0}, {0, 0, half, half}};
    add_one(scene, Box{{0.5f, 0.3f, 0.5f}}, {.position = {0.2f, 3.5f, 0.1f}});
    const auto refused = in_every_engine(scene, 60, [](const std::string& engine, const auto& states) {
      EXPECT_NEAR(states[1].pose.position.y, 3.3f, kNear) << engine;
    });
    EXPECT_TRUE(refused.empty()) << refused.front();
  }
}

TEST(Engines, AKinematicMeshLiftsWhatLiesOnIt) {
  Scene scene;
  const std::uint32_t lift = add_one(scene, plate(5.0f), {.type = BodyType::kinematic});
  add_one(scene, Box{{0.5f, 0.3f, 0.5f}}, {.position = {0.2f, 0.3f, 0.1f}});
  // Round a far center: 30 degrees up to 2.5 m in 5 s, which is as good as straight up.
  scene.drives.push_back({.body = lift,
                          .start = {},
                          .center = {-5, 0, 0},
                          .axis = {0, 0, 1},
                          .degrees_per_second = 6.0,
                          .turns_body = false});
  const auto refused = in_every_engine(scene, 300, [](const std::string& engine, const auto& states) {
    EXPECT_NEAR(states[0].pose.position.y, 2.5f, kNear) << engine;
    EXPECT_NEAR(states[1].pose.position.y, 2.8f, 0.1f) << engine;
  });
  for (const std::string& engine : refused) EXPECT_EQ(engine, "box3d");
}

TEST(Engines, TrianglesWithMaterialsAreRefusedByAllButScree) {
  const std::vector<Vec3> vertices = {{-5, 0, -5}, {-5, 0, 5}, {5, 0, -5}};
  const std::vector<Material> ice = {{.friction = 0.0f}};
  const std::vector<std::uint8_t> of_triangle = {0};
  Scene scene;
  add_one(scene,
          TriangleMesh(vertices, std::vector<MeshTriangle>{{0, 1, 2}},
                       {.of_triangle = of_triangle, .materials = ice}),
          {.type = BodyType::fixed});
  const auto refused =
      in_every_engine(scene, 1, [](const std::string& engine, const auto&) { EXPECT_EQ(engine, "scree"); });
  EXPECT_EQ(refused.size() + 1, engines().size());
}

TEST(Engines, MixFrictionAndRestitutionAsTheSceneAsks) {
  struct Case {
    MixRule rule;
    bool slides;   // friction 1 on a ground without any
    bool bounces;  // restitution 0.8 on a ground of 0
  };
  for (const Case& one : {Case{MixRule::minimum, true, false}, Case{MixRule::maximum, false, true},
                          Case{MixRule::product, true, false}}) {
    Scene scene;
    scene.settings.sleeping = false;
    add_one(scene, Box{{50, 1, 50}}, {.type = BodyType::fixed, .position = {0, -1, 0}},
            {.friction = 0.0f, .restitution = 0.0f, .friction_mix = one.rule, .restitution_mix = one.rule});
    const Material rough{
        .friction = 1.0f, .restitution = 0.8f, .friction_mix = one.rule, .restitution_mix = one.rule};
    add_one(scene, Box{{0.5f, 0.3f, 0.5f}}, {.position = {0, 0.3f, 0}, .linear_velocity = {4, 0, 0}}, rough);
    add_one(scene, Sphere{0.5f}, {.position = {0, 2.5f, 5}}, rough);
    const auto refused = in_every_engine(scene, 60, [&](const std::string& engine, const auto& states) {
      EXPECT_EQ(states[1].linear_velocity.x > 3.5f, one.slides) << engine;
      EXPECT_LT(states[1].linear_velocity.x, one.slides ? 4.5f : 0.5f) << engine;
      // A second after the start it is on its way up, or has come to rest.
      EXPECT_EQ(states[2].pose.position.y > 0.8f, one.bounces) << engine;
    });
    EXPECT_TRUE(refused.empty()) << refused.front();
  }
}

// The angle of frame b in frame a about x.
double turn_of(const Quat& rotation) { return 2.0 * std::atan2(double{rotation.x}, double{rotation.w}); }

TEST(Engines, HingesStopAtTheirOwnLimits) {
  // Two bars whose far ends are drawn down turn about x by gravity, one each way, to different limits.
  for (const float side : {1.0f, -1.0f}) {
    Scene scene;
    add_one(scene, Box{{0.1f, 0.1f, 0.5f}}, {.position = {0, 5, 0.5f * side}});
    HingeJoint hinge;
    hinge.angle = {.lower = -0.3f, .upper = 0.6f, .drive = Drive::motor, .max_force = 1.0f};
    scenes::SceneJoint joint;
    joint.joint = hinge;
    joint.body_a = scenes::kWorldItself;
    joint.body_b = 0;
    joint.def.frame_a.position = {0, 5, 0};
    joint.def.frame_b.position = {0, 0, -0.5f * side};
    scene.joints.push_back(joint);
    const auto refused = in_every_engine(scene, 240, [&](const std::string& engine, const auto& states) {
      EXPECT_NEAR(turn_of(states[0].pose.rotation), side > 0 ? 0.6 : -0.3, 0.06) << engine;
    });
    for (const std::string& engine : refused) EXPECT_EQ(engine, "ode");
  }
}

TEST(Engines, BallsStopAtTheirConeAndTwistAndHoldTheirAnchors) {
  for (const bool reversed : {false, true}) {
    Scene scene;
    scene.settings.gravity = {0, -9.81f, 0};
    // A bar along x whose cone opens along x: it sinks by the cone's angle.
    add_one(scene, Box{{0.5f, 0.1f, 0.1f}}, {.position = {0.5f, 5, 0}});
    // A bar across z that hangs by a ball with its axis along x: gravity twists it.
    const float side = reversed ? -1.0f : 1.0f;
    add_one(scene, Box{{0.1f, 0.1f, 0.5f}}, {.position = {8, 5, 0.5f * side}});
    BallJoint cone{.cone_limit = 0.5f, .twist_lower = -0.4f, .twist_upper = 0.4f};
    BallJoint twist{.cone_limit = 0.1f, .twist_lower = -0.3f, .twist_upper = 0.6f};
    for (BallJoint* ball : {&cone, &twist}) ball->drive = {.drive = Drive::motor, .max_torque = 1.0f};
    scenes::SceneJoint joint;
    joint.body_a = scenes::kWorldItself;
    joint.joint = cone;
    joint.body_b = 0;
    joint.def.frame_a.position = {0, 5, 0};
    joint.def.frame_b.position = {-0.5f, 0, 0};
    scene.joints.push_back(joint);
    joint.joint = twist;
    joint.body_b = 1;
    joint.def.frame_a.position = {8, 5, 0};
    joint.def.frame_b.position = {0, 0, -0.5f * side};
    scene.joints.push_back(joint);
    const Evaluator evaluator(scene);
    const auto refused = in_every_engine(scene, 300, [&](const std::string& engine, const auto& states) {
      EXPECT_NEAR(states[0].pose.position.y, 5.0 - 0.5 * std::sin(0.5), 0.06) << engine;
      EXPECT_NEAR(turn_of(states[1].pose.rotation), side > 0 ? 0.6 : -0.3, 0.1) << engine;
      DriftStatistics drift;
      evaluator.add_joint_drift(states, drift);
      EXPECT_LT(drift.max(), 0.02) << engine;
    });
    for (const std::string& engine : refused) EXPECT_EQ(engine, "ode");
  }
}

TEST(Engines, TellHowManyBodiesAreAwake) {
  Scene scene;
  add_one(scene, Box{{5, 1, 5}}, {.type = BodyType::fixed, .position = {0, -1, 0}});
  add_one(scene, Box{{0.5f, 0.5f, 0.5f}}, {.position = {0, 0.5f, 0}});
  add_one(scene, Box{{0.5f, 0.5f, 0.5f}}, {.position = {50, 5000, 0}});
  for (const EngineInfo& info : engines()) {
    const auto engine = info.create({&scene, 1}, {.threads = 1, .continuous = scene.settings.continuous});
    engine->step(kDt);
    EXPECT_EQ(engine->awake(), 2) << info.name;
    for (int step = 0; step < 300; ++step) engine->step(kDt);
    EXPECT_EQ(engine->awake(), 1) << info.name;
  }
}

TEST(Engines, RefuseSmoothShapes) {
  for (const Geometry& geometry : {Geometry{Cylinder{}}, Geometry{Cone{}}, Geometry{Box{{1, 1, 1}, 0.1f}}}) {
    Scene scene;
    add_one(scene, geometry, {});
    for (const EngineInfo& info : engines()) EXPECT_THROW(check_scene(info, scene), Error) << info.name;
  }
}

TEST(Engines, JoinedBodiesDoNotTouchUnlessTheyMay) {
  for (const bool touch : {false, true}) {
    Scene scene;
    scene.settings.gravity = {};
    add_one(scene, Box{{0.5f, 0.5f, 0.5f}}, {.position = {0, 0, 0}});
    add_one(scene, Box{{0.5f, 0.5f, 0.5f}}, {.position = {0.6f, 0, 0}});
    scenes::SceneJoint joint;
    joint.joint = BallJoint{};
    joint.body_a = 0;
    joint.body_b = 1;
    joint.def.collide_connected = touch;
    joint.def.frame_a.position = {0.3f, 0.4f, 0};
    joint.def.frame_b.position = {-0.3f, 0.4f, 0};
    scene.joints.push_back(joint);
    // Where they collide, the overlap turns them about the anchor above their middles.
    const auto refused = in_every_engine(scene, 60, [&](const std::string& engine, const auto& states) {
      const double turned = std::abs(double{states[0].pose.rotation.z});
      if (touch) {
        EXPECT_GT(turned, 0.02) << engine;
      } else {
        EXPECT_LT(turned, 1e-3) << engine;
      }
    });
    for (const std::string& engine : refused) EXPECT_EQ(engine, "ode");
  }
}

}  // namespace
}  // namespace scree::bench
