// Laws of the built-in scenes with joints: their bodies and joints, and that the joints' frames match at the
// start.
#include <core/world/math.h>
#include <gtest/gtest.h>
#include <tools/scenes/frames.h>
#include <tools/scenes/scene.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace scree::scenes {
namespace {

Scene small(const std::string& name) {
  Parameters parameters;
  if (name == "joint_grid") parameters = {{"columns", 5}, {"rows", 4}};
  if (name == "chain") parameters = {{"links", 10}, {"weight", 1000}};
  if (name == "ragdolls") parameters = {{"ragdolls", 5}};
  if (name == "vehicles") parameters = {{"cars", 3}};
  if (name == "motors") parameters = {{"machines", 2}};
  return build(name, parameters).front();
}

Pose frame_of(const Scene& scene, std::uint32_t body, const Pose& frame) {
  if (body == kWorldItself) return frame;
  const BodyDef& def = scene.bodies[body].def;
  return placed({def.position, def.rotation}, frame);
}

TEST(JointedScenes, AnchorsCoincideWhereTheKindOfJointHoldsThem) {
  for (const char* name : {"joint_grid", "chain", "bridge", "wrecking_ball", "ragdolls", "vehicles", "motors",
                           "card_catapult"}) {
    const Scene scene = small(name);
    ASSERT_FALSE(scene.joints.empty()) << name;
    for (std::size_t i = 0; i < scene.joints.size(); ++i) {
      const SceneJoint& joint = scene.joints[i];
      EXPECT_NE(joint.body_a, joint.body_b) << name << " " << i;
      // These pull along a distance, or have frames on two axles.
      if (std::holds_alternative<DistanceJoint>(joint.joint) ||
          std::holds_alternative<PulleyJoint>(joint.joint) ||
          std::holds_alternative<GearJoint>(joint.joint) ||
          std::holds_alternative<RackAndPinionJoint>(joint.joint)) {
        continue;
      }
      const Vec3 a = frame_of(scene, joint.body_a, joint.def.frame_a).position;
      const Vec3 b = frame_of(scene, joint.body_b, joint.def.frame_b).position;
      EXPECT_LT(length(a - b), 2e-5f) << name << " " << i;
    }
  }
}

TEST(JointGrid, EqualsThePublishedScene) {
  const Scene scene = build("joint_grid").front();
  ASSERT_EQ(scene.bodies.size(), 10000u);
  ASSERT_EQ(scene.joints.size(), 19800u);
  EXPECT_EQ(scene.steps, 100);
  EXPECT_FALSE(scene.settings.sleeping);
  EXPECT_EQ(scene.settings.gravity, (Vec3{0, -10, 0}));
  ASSERT_EQ(scene.shapes.size(), 1u);
  EXPECT_EQ(std::get<Sphere>(scene.shapes[0].geometry).radius, 0.4f);
  const Filter filter = scene.shapes[0].options.filter;
  EXPECT_EQ(filter.category & filter.mask, 0u);  // with each other they do not collide
  std::size_t vertical = 0, horizontal = 0, fixed = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const BodyDef& def = scene.bodies[i].def;
    EXPECT_EQ(def.position, (Vec3{static_cast<float>(i / 100), -static_cast<float>(i % 100), 0}));
    EXPECT_EQ(def.type, i % 100 == 0 ? BodyType::fixed : BodyType::dynamic);
    fixed += def.type == BodyType::fixed;
  }
  EXPECT_EQ(fixed, 100u);
  for (const SceneJoint& joint : scene.joints) {
    EXPECT_EQ(std::get<BallJoint>(joint.joint), BallJoint{});
    const bool down = joint.body_b == joint.body_a + 1;
    EXPECT_TRUE(down || joint.body_b == joint.body_a + 100);
    EXPECT_EQ(joint.def.frame_a.position, down ? (Vec3{0, -0.5f, 0}) : (Vec3{0.5f, 0, 0}));
    EXPECT_EQ(joint.def.frame_b.position, down ? (Vec3{0, 0.5f, 0}) : (Vec3{-0.5f, 0, 0}));
    (down ? vertical : horizontal) += 1;
  }
  EXPECT_EQ(vertical, 9900u);
  EXPECT_EQ(horizontal, 9900u);
}

TEST(Chain, WeightAtTheEndHasTheMassOfTheStatedNumberOfLinks) {
  for (const double weight : {0.5, 1000.0}) {
    const Scene scene = build("chain", {{"links", 7}, {"weight", weight}}).front();
    World world(scene.settings);
    const std::vector<BodyId> bodies = populate(world, scene);
    ASSERT_EQ(bodies.size(), 9u);  // the ground, seven links, the weight
    EXPECT_NEAR(world.mass_properties(bodies[8]).mass / world.mass_properties(bodies[1]).mass, weight,
                1e-4 * weight);
  }
  EXPECT_EQ(build("chain", {{"links", 7}}).front().bodies.size(), 8u);
}

TEST(Bridge, LoadsBeginApartFromEachOther) {
  constexpr float kSize = 0.6f;  // m
  for (const int loads : {12, 19, 20, 21, 100}) {
    const Scene scene = build("bridge", {{"loads", loads}}).front();
    const std::size_t first = 3 + 40;  // after the ground, the towers and the planks
    ASSERT_EQ(scene.bodies.size(), first + static_cast<std::size_t>(loads));
    for (std::size_t i = first; i < scene.bodies.size(); ++i) {
      for (std::size_t k = first; k < i; ++k) {
        const Vec3 between = scene.bodies[i].def.position - scene.bodies[k].def.position;
        EXPECT_GT(std::max(std::abs(between.x), std::abs(between.y)), kSize) << loads << " " << i << " " << k;
      }
    }
  }
}

TEST(Ragdolls, AreFourteenCapsulesOnThirteenJointsEach) {
  const Scene scene = build("ragdolls", {{"ragdolls", 7}}).front();
  EXPECT_EQ(scene.bodies.size(), 1u + 7u * 14u);
  EXPECT_EQ(scene.joints.size(), 7u * 13u);
  // Each ragdoll is connected: one more joint than its bodies less one would close a ring.
  std::map<std::uint32_t, std::set<std::uint32_t>> humans;
  for (const SceneJoint& joint : scene.joints) {
    EXPECT_EQ((joint.body_a - 1) / 14, (joint.body_b - 1) / 14);
    humans[(joint.body_a - 1) / 14].insert({joint.body_a, joint.body_b});
  }
  for (const auto& [human, bodies] : humans) EXPECT_EQ(bodies.size(), 14u) << human;
  World world(scene.settings);
  const std::vector<BodyId> ids = populate(world, scene);
  double mass = 0.0;
  for (std::size_t i = 1; i <= 14; ++i) mass += static_cast<double>(world.mass_properties(ids[i]).mass);
  EXPECT_GT(mass, 60.0);  // kg
  EXPECT_LT(mass, 85.0);
}

TEST(Ragdolls, BeginWithinTheirLimits) {
  const Scene scene = build("ragdolls", {{"ragdolls", 3}}).front();
  for (std::size_t i = 0; i < scene.joints.size(); ++i) {
    const SceneJoint& joint = scene.joints[i];
    const Quat a = frame_of(scene, joint.body_a, joint.def.frame_a).rotation;
    const Quat b = frame_of(scene, joint.body_b, joint.def.frame_b).rotation;
    if (const auto* ball = std::get_if<BallJoint>(&joint.joint)) {
      const Vec3 axis_a = rotate(a, {1, 0, 0}), axis_b = rotate(b, {1, 0, 0});
      const float angle = std::acos(std::min(1.0f, dot(axis_a, axis_b)));
      EXPECT_LT(angle, ball->cone_limit) << i;
      // The shortest turn between the axes takes one frame to the other: there is no twist.
      const Vec3 untwisted = rotate(turn_between(axis_a, axis_b), rotate(a, {0, 1, 0}));
      EXPECT_NEAR(dot(untwisted, rotate(b, {0, 1, 0})), 1.0f, 1e-4f) << i;
    } else {
      const auto& hinge = std::get<HingeJoint>(joint.joint);
      EXPECT_NEAR(std::abs(dot(rotate(a, {0, 1, 0}), rotate(b, {0, 1, 0}))), 1.0f, 1e-4f) << i;
      EXPECT_LT(hinge.angle.lower, 0.0f);
      EXPECT_GT(hinge.angle.upper, 0.0f);
    }
  }
}

TEST(Motors, ShowEveryKindOfJoint) {
  std::set<std::size_t> kinds;
  for (const SceneJoint& joint : small("motors").joints) kinds.insert(joint.joint.index());
  kinds.insert(small("vehicles").joints.front().joint.index());
  EXPECT_EQ(kinds.size(), static_cast<std::size_t>(kJointTypeCount));
}

TEST(Vehicles, HaveFourWheelsEachAndDriveTheRearOnes) {
  const Scene scene = build("vehicles", {{"cars", 6}}).front();
  ASSERT_EQ(scene.joints.size(), 24u);
  int driven = 0;
  for (const SceneJoint& joint : scene.joints) {
    const auto& wheel = std::get<WheelJoint>(joint.joint);
    // Suspension up, axles across.
    const Quat frame = frame_of(scene, joint.body_a, joint.def.frame_a).rotation;
    EXPECT_NEAR(rotate(frame, {1, 0, 0}).y, 1.0f, 1e-6f);
    EXPECT_NEAR(rotate(frame, {0, 0, 1}).z, 1.0f, 1e-6f);
    driven += wheel.spin.drive == Drive::motor;
  }
  EXPECT_EQ(driven, 12);
}

}  // namespace
}  // namespace scree::scenes
