// Laws of the evaluator: analytic gaps, penetrations, energies and drops.
#include "bench/evaluate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace scree::bench {
namespace {

using scenes::Scene;

constexpr double kExact = 1e-6;  // m: scenes hold floats

void add_body(Scene& scene, const Geometry& geometry, Vec3 position, BodyType type = BodyType::dynamic,
              Quat rotation = {}) {
  scenes::SceneBody body;
  body.def.type = type;
  body.def.position = position;
  body.def.rotation = rotation;
  body.first_shape = static_cast<std::uint32_t>(scene.shapes.size());
  body.shape_count = 1;
  scene.shapes.push_back({geometry, {}, {}});
  scene.bodies.push_back(body);
}

std::vector<BodyState> start_states(const Scene& scene) {
  std::vector<BodyState> states;
  for (const scenes::SceneBody& body : scene.bodies) {
    states.push_back({{body.def.position, body.def.rotation}, {}, {}});
  }
  return states;
}

PenetrationStatistics touching_pairs(const Scene& scene, const std::vector<BodyState>& states) {
  PenetrationStatistics statistics;
  Evaluator(scene).add_touching_pairs(states, statistics);
  return statistics;
}

Quat rotation_about(Vec3 axis, double angle) {
  const auto s = static_cast<float>(std::sin(angle / 2));
  return {axis.x * s, axis.y * s, axis.z * s, static_cast<float>(std::cos(angle / 2))};
}

double gap(const Geometry& a, const Pose& pose_a, const Geometry& b, const Pose& pose_b) {
  const double there = signed_gap(place(a, {}, pose_a), place(b, {}, pose_b));
  const double back = signed_gap(place(b, {}, pose_b), place(a, {}, pose_a));
  EXPECT_NEAR(there, back, 1e-12);
  return there;
}

constexpr double kQuarterTurn = std::numbers::pi / 2;
const Box kUnitBox{{0.5f, 0.5f, 0.5f}};

TEST(Gap, OfTwoSpheresIsCenterDistanceLessRadii) {
  EXPECT_NEAR(gap(Sphere{1.0f}, {}, Sphere{0.5f}, {{0, 1.25f, 0}, {}}), -0.25, kExact);
  EXPECT_NEAR(gap(Sphere{1.0f}, {}, Sphere{0.5f}, {{3, 4, 0}, {}}), 3.5, kExact);
}

TEST(Gap, OfCrossedCapsulesIsMeasuredBetweenTheirAxes) {
  const Capsule capsule{1.0f, 0.25f};
  const Pose lying{{0, 0, 0.4f}, rotation_about({0, 0, 1}, kQuarterTurn)};
  EXPECT_NEAR(gap(capsule, {}, capsule, lying), -0.1, kExact);
}

TEST(Gap, OfParallelCapsulesIsMeasuredWhereTheyOverlapOrEndToEnd) {
  const Capsule capsule{1.0f, 0.25f};
  EXPECT_NEAR(gap(capsule, {}, capsule, {{0.6f, 0.5f, 0}, {}}), 0.1, kExact);
  EXPECT_NEAR(gap(capsule, {}, capsule, {{0, 2.4f, 0}, {}}), -0.1, kExact);
  EXPECT_NEAR(gap(capsule, {}, capsule, {{3, 6, 0}, {}}), 4.5, kExact);
}

TEST(Gap, OfSphereAndBoxIsToTheClosestFaceEdgeOrCorner) {
  EXPECT_NEAR(gap(kUnitBox, {}, Sphere{0.5f}, {{0.9f, 0.1f, 0}, {}}), -0.1, kExact);
  EXPECT_NEAR(gap(kUnitBox, {}, Sphere{0.5f}, {{0.9f, 0.9f, 0}, {}}), std::sqrt(0.32) - 0.5, kExact);
  EXPECT_NEAR(gap(kUnitBox, {}, Sphere{0.5f}, {{0.9f, 0.9f, 0.9f}, {}}), std::sqrt(0.48) - 0.5, kExact);
}

TEST(Gap, OfSphereInsideABoxLeadsThroughTheNearestFace) {
  EXPECT_NEAR(gap(kUnitBox, {}, Sphere{0.1f}, {{0.1f, -0.3f, 0}, {}}), -0.3, kExact);
}

TEST(Gap, OfCapsuleAndBoxIsRightAtFacesEdgesAndEnds) {
  const Capsule capsule{1.0f, 0.25f};
  const Pose lying_on_top{{0, 0.7f, 0}, rotation_about({0, 0, 1}, kQuarterTurn)};
  EXPECT_NEAR(gap(kUnitBox, {}, capsule, lying_on_top), -0.05, kExact);
  // Leaning at 45 degrees against the edge x = y = 0.5, its axis 0.3 from the edge.
  const float away = static_cast<float>(0.5 + 0.3 / std::sqrt(2.0));
  const Pose leaning{{away, away, 0}, rotation_about({0, 0, 1}, kQuarterTurn / 2)};
  EXPECT_NEAR(gap(kUnitBox, {}, capsule, leaning), 0.05, kExact);
  EXPECT_NEAR(gap(kUnitBox, {}, capsule, {{0, 1.7f, 0}, {}}), -0.05, kExact);
}

TEST(Gap, OfCapsuleWhoseAxisCrossesAnEdgeIsTheShortestWayOut) {
  // The axis at 45 degrees passes 0.1 inside of the edge: out by 0.1 plus the radius.
  const Capsule capsule{1.0f, 0.25f};
  const float inside = static_cast<float>(0.5 - 0.1 / std::sqrt(2.0));
  const Pose leaning{{inside, inside, 0}, rotation_about({0, 0, 1}, kQuarterTurn / 2)};
  EXPECT_NEAR(gap(kUnitBox, {}, capsule, leaning), -0.35, kExact);
}

TEST(Gap, OfStackedBoxesIsTheOverlapOfTheirFaces) {
  EXPECT_NEAR(gap(kUnitBox, {}, kUnitBox, {{0.3f, 0.98f, 0.1f}, {}}), -0.02, kExact);
  EXPECT_NEAR(gap(kUnitBox, {}, kUnitBox, {{0.3f, 1.02f, 0.1f}, {}}), 0.02, kExact);
}

TEST(Gap, OfATurnedBoxIsMeasuredAtItsEdge) {
  // Turned by 45 degrees about z, the upper box stands on an edge sqrt(2)/2 below its center.
  const Pose on_edge{{0, static_cast<float>(0.5 + std::sqrt(0.5) - 0.03), 0},
                     rotation_about({0, 0, 1}, kQuarterTurn / 2)};
  EXPECT_NEAR(gap(kUnitBox, {}, kUnitBox, on_edge), -0.03, kExact);
}

TEST(Gap, OfCrossedEdgesIsAlongTheirCommonPerpendicular) {
  // Two boxes, each standing on an edge, the edges crossed at a right angle.
  const Pose below{{0, 0, 0}, rotation_about({1, 0, 0}, kQuarterTurn / 2)};
  const Pose above{{0, static_cast<float>(2 * std::sqrt(0.5) - 0.04), 0},
                   rotation_about({0, 0, 1}, kQuarterTurn / 2)};
  EXPECT_NEAR(gap(kUnitBox, below, kUnitBox, above), -0.04, kExact);
}

TEST(Gap, DoesNotChangeWhenBothShapesMoveTogether) {
  const Quat turn = rotation_about({0.6f, 0.0f, 0.8f}, 1.1);
  const Eigen::Vector3d apart = to_double(turn) * Eigen::Vector3d(0.9, 0.9, 0.2);
  const Pose moved{{float(7 + apart.x()), float(-3 + apart.y()), float(2 + apart.z())}, turn};
  EXPECT_NEAR(gap(kUnitBox, {{7, -3, 2}, turn}, Sphere{0.5f}, moved),
              gap(kUnitBox, {}, Sphere{0.5f}, {{0.9f, 0.9f, 0.2f}, {}}), 2e-6);
}

TEST(Gap, HonorsTheShapesPlaceInItsBody) {
  const Pose local{{0, 2, 0}, {}};
  const Pose body{{0, 0, 0}, rotation_about({0, 0, 1}, kQuarterTurn)};  // the shape ends at x = -2
  EXPECT_NEAR(signed_gap(place(Sphere{1.0f}, local, body), place(Sphere{1.0f}, {}, {{-3.5f, 0, 0}, {}})),
              -0.5, kExact);
}

TEST(Evaluator, CountsEachTouchingPairOnce) {
  Scene scene;
  add_body(scene, Box{{50, 1, 50}}, {0, -1, 0}, BodyType::fixed);
  for (int x = 0; x < 10; ++x) {
    for (int z = 0; z < 10; ++z) add_body(scene, kUnitBox, {2.0f * float(x), 0.49f, 2.0f * float(z)});
  }
  for (int x = 0; x < 10; ++x) add_body(scene, Sphere{0.5f}, {2.0f * float(x), 1.47f, 0});
  const PenetrationStatistics statistics = touching_pairs(scene, start_states(scene));
  EXPECT_EQ(statistics.pairs(), 110);
  EXPECT_NEAR(statistics.mean(), (100 * 0.01 + 10 * 0.02) / 110, kExact);
  EXPECT_NEAR(statistics.max(), 0.02, kExact);
}

TEST(Evaluator, AgreesWithAllPairsTriedOneByOne) {
  Scene scene;
  add_body(scene, Box{{6, 1, 6}}, {0, -1, 0}, BodyType::fixed);
  std::uint32_t seed = 7;
  const auto random = [&seed](float low, float high) {
    seed = seed * 1664525u + 1013904223u;
    return low + (high - low) * static_cast<float>(seed >> 8) / 16777216.0f;
  };
  for (int i = 0; i < 300; ++i) {
    const Vec3 position{random(-5, 5), random(0, 5), random(-5, 5)};
    const Quat turn = rotation_about({0.6f, 0.8f, 0.0f}, double{random(0, 3)});
    const float size = random(0.1f, 0.9f);
    if (i % 3 == 0) add_body(scene, Sphere{size}, position, BodyType::dynamic, turn);
    if (i % 3 == 1) add_body(scene, Capsule{size, 0.3f}, position, BodyType::dynamic, turn);
    if (i % 3 == 2) add_body(scene, Box{{size, 0.2f, 0.4f}}, position, BodyType::dynamic, turn);
  }
  const auto states = start_states(scene);
  std::int64_t pairs = 0;
  double sum = 0.0;
  for (std::size_t i = 0; i < states.size(); ++i) {
    for (std::size_t j = i + 1; j < states.size(); ++j) {
      const double value = signed_gap(place(scene.shapes[i].geometry, {}, states[i].pose),
                                      place(scene.shapes[j].geometry, {}, states[j].pose));
      if (value >= kTouchGap) continue;
      ++pairs;
      sum += std::max(-value, 0.0);
    }
  }
  const PenetrationStatistics statistics = touching_pairs(scene, states);
  EXPECT_GT(pairs, 100);
  EXPECT_EQ(statistics.pairs(), pairs);
  EXPECT_NEAR(statistics.mean(), sum / static_cast<double>(pairs), 1e-12);
}

TEST(Evaluator, IgnoresPairsThatCannotCollide) {
  Scene scene;
  add_body(scene, kUnitBox, {0, 0, 0}, BodyType::fixed);
  add_body(scene, kUnitBox, {0.5f, 0, 0}, BodyType::fixed);
  add_body(scene, Sphere{0.5f}, {20, 0, 0});
  add_body(scene, Sphere{0.5f}, {20, 0.5f, 0});
  scene.shapes[2].options.filter.group = -3;
  scene.shapes[3].options.filter.group = -3;
  EXPECT_EQ(touching_pairs(scene, start_states(scene)).pairs(), 0);
}

TEST(Evaluator, CountsASmallGapAsATouchWithoutPenetration) {
  Scene scene;
  add_body(scene, Sphere{0.5f}, {0, 0, 0});
  add_body(scene, Sphere{0.5f}, {1.0005f, 0, 0});
  add_body(scene, Sphere{0.5f}, {0, 1.002f, 0});
  const PenetrationStatistics statistics = touching_pairs(scene, start_states(scene));
  EXPECT_EQ(statistics.pairs(), 1);
  EXPECT_EQ(statistics.max(), 0.0);
}

TEST(PenetrationStatistics, QuantileIsTheValueThatTheShareDoesNotExceed) {
  PenetrationStatistics statistics;
  for (int i = 1; i <= 1000; ++i) statistics.add(i * 1e-4);
  EXPECT_NEAR(statistics.quantile(0.5), 0.05, 1e-6);
  EXPECT_NEAR(statistics.quantile(0.999), 0.0999, 1e-6);
  EXPECT_EQ(statistics.quantile(1.0), statistics.max());
  EXPECT_NEAR(statistics.mean(), 0.05005, 1e-12);
}

TEST(PenetrationStatistics, DepthsBeyondAMeterAreKeptInTheMaximum) {
  PenetrationStatistics statistics;
  statistics.add(7.5);
  EXPECT_EQ(statistics.quantile(0.999), 7.5);
  EXPECT_EQ(PenetrationStatistics{}.quantile(0.999), 0.0);
}

TEST(BodyMass, OfSolidsIsAnalytic) {
  Scene scene;
  add_body(scene, Box{{0.5f, 1.0f, 1.5f}}, {});
  add_body(scene, Sphere{0.5f}, {});
  add_body(scene, Capsule{1.0f, 0.5f}, {});
  const BodyMass box = body_mass(scene, scene.bodies[0]);
  EXPECT_NEAR(box.mass, 6000.0, 1e-6);
  EXPECT_NEAR(box.inertia(0, 0), 6000.0 / 12 * (4 + 9), 1e-6);
  EXPECT_NEAR(box.inertia(1, 1), 6000.0 / 12 * (1 + 9), 1e-6);
  const BodyMass ball = body_mass(scene, scene.bodies[1]);
  EXPECT_NEAR(ball.mass, 1000 * std::numbers::pi / 6, 1e-9);
  EXPECT_NEAR(ball.inertia(2, 2), 0.1 * ball.mass, 1e-9);
  const BodyMass capsule = body_mass(scene, scene.bodies[2]);
  const double cylinder = 1000 * std::numbers::pi * 0.25 * 2;
  EXPECT_NEAR(capsule.mass, cylinder + ball.mass, 1e-9);
  EXPECT_NEAR(capsule.inertia(1, 1), cylinder * 0.125 + ball.inertia(1, 1), 1e-9);
  // Two half balls of mass m/2, 2 r^2 / 5 about the center of their flat face, at +-1 m.
  const double half_ball = ball.mass / 2;
  const double about_own_center = half_ball * (0.4 * 0.25 - 0.1875 * 0.1875);
  const double across = 2 * (about_own_center + half_ball * 1.1875 * 1.1875);
  EXPECT_NEAR(capsule.inertia(0, 0), cylinder * (0.25 / 4 + 4.0 / 12) + across, 1e-9);
}

TEST(BodyMass, OfTwoHalvesIsThatOfTheWhole) {
  Scene whole, halves;
  add_body(whole, Box{{1.0f, 0.5f, 0.5f}}, {});
  add_body(halves, kUnitBox, {});
  halves.shapes.push_back(halves.shapes.front());
  halves.shapes[0].options.local_pose = {{0.5f, 0, 0}, rotation_about({1, 0, 0}, kQuarterTurn)};
  halves.shapes[1].options.local_pose.position = {-0.5f, 0, 0};
  halves.bodies[0].shape_count = 2;
  const BodyMass one = body_mass(whole, whole.bodies[0]);
  const BodyMass two = body_mass(halves, halves.bodies[0]);
  EXPECT_NEAR(one.mass, two.mass, 1e-9);
  EXPECT_NEAR((one.inertia - two.inertia).norm(), 0.0, 1e-3);  // the quarter turn is a float quaternion
  EXPECT_NEAR(two.center.norm(), 0.0, 1e-12);
}

TEST(BodyMass, GivenMassScalesTheInertia) {
  Scene scene;
  add_body(scene, Sphere{0.5f}, {});
  scene.bodies[0].def.mass = 2.0f;
  EXPECT_NEAR(body_mass(scene, scene.bodies[0]).inertia(0, 0), 0.2, 1e-9);
}

TEST(BodyFigures, KineticEnergyIsTranslationPlusRotationOfDynamicBodies) {
  Scene scene;
  add_body(scene, Box{{0.5f, 1.0f, 1.5f}}, {}, BodyType::dynamic, rotation_about({0, 0, 1}, kQuarterTurn));
  add_body(scene, kUnitBox, {9, 0, 0}, BodyType::kinematic);
  auto states = start_states(scene);
  states[0].linear_velocity = {1, 2, 2};
  states[0].angular_velocity = {0, 3, 0};  // about the body's x axis
  states[1].linear_velocity = {100, 0, 0};
  EXPECT_NEAR(Evaluator(scene).body_figures(states).kinetic_energy, 0.5 * 6000 * 9 + 0.5 * 6500 * 9, 0.1);
}

TEST(BodyFigures, TopDropIsThatOfTheBodiesThatWereOnTop) {
  Scene scene;
  add_body(scene, kUnitBox, {0, 0.5f, 0});
  add_body(scene, kUnitBox, {0, 9.5f, 0});
  add_body(scene, kUnitBox, {5, 9.5f, 0});
  auto states = start_states(scene);
  states[0].pose.position.y = -0.2f;
  states[2].pose.position.y = 8.55f;
  const BodyFigures figures = Evaluator(scene).body_figures(states);
  EXPECT_NEAR(figures.top_drop, 0.95, kExact);
  EXPECT_NEAR(figures.top_height, 0.9, kExact);
  EXPECT_EQ(figures.bodies_left, 0);
}

TEST(BodyFigures, BodiesThatFellOutOrAreNotFiniteHaveLeft) {
  Scene scene;
  add_body(scene, Box{{10, 1, 10}}, {0, -1, 0}, BodyType::fixed);
  for (int i = 0; i < 4; ++i) add_body(scene, Sphere{0.5f}, {2.0f * float(i), 0.5f, 0});
  auto states = start_states(scene);
  states[1].pose.position.y = -3.5f;
  states[2].pose.position.z = 11.5f;
  states[3].pose.position.x = std::numeric_limits<float>::quiet_NaN();
  states[4].pose.position.y = 500.0f;  // a body above the scene has not left
  const Evaluator evaluator(scene);
  const BodyFigures figures = evaluator.body_figures(states);
  EXPECT_EQ(figures.bodies_left, 3);
  EXPECT_TRUE(std::isfinite(figures.kinetic_energy));
  PenetrationStatistics statistics;
  evaluator.add_touching_pairs(states, statistics);
  EXPECT_TRUE(std::isfinite(statistics.mean()));
}

DriftStatistics joint_drift(const Scene& scene, const std::vector<BodyState>& states) {
  DriftStatistics statistics;
  Evaluator(scene).add_joint_drift(states, statistics);
  return statistics;
}

void add_joint(Scene& scene, std::uint32_t a, std::uint32_t b, const Joint& joint, Vec3 anchor_a,
               Vec3 anchor_b) {
  scene.joints.push_back({{.frame_a = {anchor_a, {}}, .frame_b = {anchor_b, {}}}, joint, a, b});
}

TEST(JointDrift, IsTheDistanceOfTheAnchorsWhereTheBodiesAreNow) {
  Scene scene;
  add_body(scene, Sphere{0.1f}, {0, 0, 0});
  add_body(scene, Sphere{0.1f}, {2, 0, 0});
  add_joint(scene, 0, 1, BallJoint{}, {1, 0, 0}, {-1, 0, 0});
  auto states = start_states(scene);
  EXPECT_NEAR(joint_drift(scene, states).max(), 0.0, kExact);
  states[1].pose.position = {2, 0.03f, 0.04f};
  EXPECT_NEAR(joint_drift(scene, states).max(), 0.05, kExact);
  // Turned by a quarter about z, b's anchor stands below its center: at (2, -1), a's at (1, 0).
  states[1].pose = {{2, 0, 0}, rotation_about({0, 0, 1}, kQuarterTurn)};
  EXPECT_NEAR(joint_drift(scene, states).max(), std::sqrt(2.0), kExact);
}

TEST(JointDrift, OfAJointWithTheWorldIsMeasuredInWorldCoordinates) {
  Scene scene;
  add_body(scene, Sphere{0.1f}, {5, 1, 0});
  add_joint(scene, scenes::kWorldItself, 0, HingeJoint{}, {5, 2, 0}, {0, 1, 0});
  auto states = start_states(scene);
  EXPECT_NEAR(joint_drift(scene, states).max(), 0.0, kExact);
  states[0].pose.position.y = 0.75f;
  EXPECT_NEAR(joint_drift(scene, states).max(), 0.25, kExact);
}

TEST(JointDrift, CountsJointsThatHoldAnchorsAndNoOthers) {
  Scene scene;
  add_body(scene, Sphere{0.1f}, {0, 0, 0});
  add_body(scene, Sphere{0.1f}, {1, 0, 0});
  add_body(scene, Sphere{0.1f}, {0, 5, 0}, BodyType::fixed);
  add_body(scene, Sphere{0.1f}, {1, 5, 0}, BodyType::fixed);
  for (const Joint& joint :
       {Joint{BallJoint{}}, Joint{HingeJoint{}}, Joint{WeldJoint{}}, Joint{UniversalJoint{}}}) {
    add_joint(scene, 0, 1, joint, {0, 0, 0}, {0, 0, 0});
  }
  const DriftStatistics held = joint_drift(scene, start_states(scene));
  EXPECT_EQ(held.joints(), 4);
  EXPECT_NEAR(held.mean(), 1.0, kExact);
  // These joints let their anchors part; otherwise nothing could move them.
  for (const Joint& joint : {Joint{SliderJoint{}}, Joint{DistanceJoint{}}, Joint{GearJoint{}}}) {
    add_joint(scene, 0, 1, joint, {0, 0, 0}, {0, 0, 0});
  }
  add_joint(scene, 2, 3, BallJoint{}, {0, 0, 0}, {0, 0, 0});
  add_joint(scene, 0, 1, BallJoint{}, {0, 0, 0}, {0, 0, 0});
  scene.joints.back().def.enabled = false;
  add_joint(scene, 0, 1, BallJoint{}, {0, 0, 0}, {0, 0, 0});
  scene.joints.back().def.hertz = 2.0f;
  EXPECT_EQ(joint_drift(scene, start_states(scene)).joints(), 4);
  auto states = start_states(scene);
  states[1].pose.position.x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(joint_drift(scene, states).joints(), 0);
}

TEST(DriftStatistics, GathersMeanAndMaximumOverManyEvaluations) {
  DriftStatistics statistics;
  EXPECT_EQ(statistics.mean(), 0.0);
  for (const double distance : {0.01, 0.05, 0.03}) statistics.add(distance);
  EXPECT_EQ(statistics.joints(), 3);
  EXPECT_NEAR(statistics.mean(), 0.03, 1e-15);
  EXPECT_EQ(statistics.max(), 0.05);
}

TEST(TouchingPairs, LeaveOutBodiesThatAJointKeepsFromColliding) {
  Scene scene;
  add_body(scene, Sphere{0.5f}, {0, 0, 0});
  add_body(scene, Sphere{0.5f}, {0.9f, 0, 0});
  EXPECT_EQ(touching_pairs(scene, start_states(scene)).pairs(), 1);
  add_joint(scene, 1, 0, BallJoint{}, {-0.45f, 0, 0}, {0.45f, 0, 0});
  EXPECT_EQ(touching_pairs(scene, start_states(scene)).pairs(), 0);
  scene.joints.back().def.collide_connected = true;
  EXPECT_EQ(touching_pairs(scene, start_states(scene)).pairs(), 1);
}

TEST(Evaluator, BodiesNotYetCreatedOrAlreadyDestroyedCountNowhere) {
  const Scene scene = scenes::build("stack", {{"bodies", 3}}).front();
  std::vector<BodyState> states = start_states(scene);
  const std::int64_t all = touching_pairs(scene, states).pairs();
  BodyState& top = states.back();
  top.exists = false;
  top.pose.position = {1e6f, -1e6f, 0.0f};
  top.linear_velocity = {1.0f, 2.0f, 3.0f};
  EXPECT_EQ(touching_pairs(scene, states).pairs(), all - 1);
  const BodyFigures figures = Evaluator(scene).body_figures(states);
  EXPECT_EQ(figures.bodies_left, 0);
  EXPECT_EQ(figures.kinetic_energy, 0.0);
  EXPECT_EQ(figures.top_drop, 0.0);
}

}  // namespace
}  // namespace scree::bench
