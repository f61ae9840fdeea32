// Joints among contacts: collision, sleep and waking, breaking, hubs, colors.
#include <parallel/constraints/constraints.h>
#include <tests/core/constraints/joint_samples.h>
#include <tests/physics/lab.h>

#include <algorithm>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

namespace scree::physics {
namespace {

constexpr Box kBox{{0.5f, 0.5f, 0.5f}};

WorldSettings with_sleep() { return {}; }

JointDef between(BodyId a, Vec3 anchor_a, BodyId b, Vec3 anchor_b) {
  return {.body_a = a, .body_b = b, .frame_a = {anchor_a, {}}, .frame_b = {anchor_b, {}}};
}

// Two boxes on the ground that overlap by half a meter, held by a joint.
struct Overlapping {
  Lab lab;
  BodyId a, b;
  JointId joint;

  explicit Overlapping(bool collide) {
    lab.add_ground();
    a = lab.add({.position = {0, 0.5f, 0}}, kBox);
    b = lab.add({.position = {0.5f, 0.5f, 0}}, kBox);
    JointDef def = between(a, {0.25f, 0, 0}, b, {-0.25f, 0, 0});
    def.collide_connected = collide;
    joint = lab.world.create_joint(def, BallJoint{});
  }
  bool collide() {
    const WorldData& data = internals(lab.world);
    return std::any_of(data.contacts.active.begin(), data.contacts.active.end(), [&](std::int32_t row) {
      const Manifold& m = data.contacts.now.manifold[static_cast<std::size_t>(row)];
      const std::set<std::uint32_t> bodies{static_cast<std::uint32_t>(m.row_a),
                                           static_cast<std::uint32_t>(m.row_b)};
      return bodies == std::set<std::uint32_t>{a.index, b.index};
    });
  }
};

TEST(JointedBodies, CollideOnlyIfTheJointAllowsIt) {
  Overlapping apart(false), together(true);
  apart.lab.run(5);
  together.lab.run(5);
  EXPECT_FALSE(apart.collide());
  EXPECT_TRUE(together.collide());
}

TEST(JointedBodies, CollideAgainOnceTheJointIsGone) {
  using Change = void (*)(Overlapping&);
  for (const Change change :
       {Change([](Overlapping& o) { o.lab.world.destroy_joint(o.joint); }),
        Change([](Overlapping& o) { o.lab.world.set_joint_enabled(o.joint, false); }),
        Change([](Overlapping& o) { o.lab.world.set_collide_connected(o.joint, true); })}) {
    Overlapping overlapping(false);
    overlapping.lab.run(5);
    ASSERT_FALSE(overlapping.collide());
    change(overlapping);
    overlapping.lab.run(1);
    EXPECT_TRUE(overlapping.collide());
  }
}

TEST(JointedBodies, StopCollidingWhenTheyAreJoined) {
  Overlapping overlapping(true);
  overlapping.lab.run(2);
  ASSERT_TRUE(overlapping.collide());
  overlapping.lab.world.set_collide_connected(overlapping.joint, false);
  overlapping.lab.run(1);
  EXPECT_FALSE(overlapping.collide());
}

// --- sleep ---

// A row of balls that hangs in a slack chain between two fixed points.
std::vector<BodyId> hang_chain(Lab& lab, int count) {
  std::vector<BodyId> links;
  BodyId before = kWorld;
  for (int i = 0; i < count; ++i) {
    const BodyId link = lab.add({.position = {0, -0.5f - static_cast<float>(i), 0}}, Capsule{0.3f, 0.1f});
    lab.world.create_joint(between(before, i == 0 ? Vec3{} : Vec3{0, -0.5f, 0}, link, {0, 0.5f, 0}),
                           BallJoint{});
    links.push_back(before = link);
  }
  return links;
}

TEST(JointedBodies, FallAsleepAndWakeAsOneIsland) {
  Lab lab(with_sleep());
  const std::vector<BodyId> links = hang_chain(lab, 8);
  lab.run(300);
  for (const BodyId link : links) ASSERT_FALSE(lab.world.is_awake(link));
  lab.world.add_impulse(links.back(), {1, 0, 0});
  lab.run(1);
  for (const BodyId link : links) EXPECT_TRUE(lab.world.is_awake(link));
  EXPECT_EQ(lab.world.sleep_ends().size(), links.size());
}

TEST(JointedBodies, StayAwakeWhileOneMoves) {
  Lab lab(with_sleep());
  const std::vector<BodyId> links = hang_chain(lab, 4);
  const BodyId spinner = lab.add({.position = {0, -4.5f, 0}, .angular_velocity = {0, 20, 0}}, Sphere{0.1f});
  lab.world.create_joint(between(links.back(), {0, -0.5f, 0}, spinner, {}), BallJoint{});
  lab.run(300);
  EXPECT_GT(lab.spin(spinner).norm(), 1.0);
  for (const BodyId link : links) EXPECT_TRUE(lab.world.is_awake(link));
}

TEST(JointedBodies, WakeWhenAKinematicBodyPullsAtThem) {
  Lab lab(with_sleep());
  const BodyId hook = lab.world.create_body({.type = BodyType::kinematic});
  const BodyId load = lab.add({.position = {0, -1, 0}}, kBox);
  lab.world.create_joint(between(hook, {}, load, {0, 1, 0}), BallJoint{});
  lab.run(300);
  ASSERT_FALSE(lab.world.is_awake(load));
  lab.world.set_linear_velocity(hook, {0, 1, 0});
  lab.run(60);
  EXPECT_TRUE(lab.world.is_awake(load));
  EXPECT_NEAR(lab.height(load), 0.0, 0.02);
}

TEST(JointedBodies, WakeWhenTheirJointIsDestroyed) {
  Lab lab(with_sleep());
  const std::vector<BodyId> links = hang_chain(lab, 3);
  lab.run(300);
  ASSERT_FALSE(lab.world.is_awake(links[2]));
  JointId joint;
  ASSERT_EQ(lab.world.joints_of(links[2], {&joint, 1}), 1u);
  lab.world.destroy_joint(joint);
  lab.run(30);
  EXPECT_LT(lab.velocity(links[2]).y(), -4.0);
}

// --- events ---

TEST(Joint, BreaksAboveItsStrengthAndIsListed) {
  for (const float strength : {0.9f, 1.1f}) {
    Lab lab;
    const BodyId load = lab.add({.position = {0, -1, 0}}, kBox);
    JointDef def = between(kWorld, {}, load, {0, 1, 0});
    def.break_force = strength * static_cast<float>(lab.mass(load) * kGravity);
    const JointId joint = lab.world.create_joint(def, BallJoint{});
    std::vector<JointId> broken;
    for (int i = 0; i < 60; ++i) {
      lab.run(1);
      broken.insert(broken.end(), lab.world.broken_joints().begin(), lab.world.broken_joints().end());
    }
    EXPECT_EQ(broken, strength < 1 ? std::vector<JointId>{joint} : std::vector<JointId>{});
    EXPECT_EQ(lab.world.is_enabled(joint), strength > 1);
    EXPECT_EQ(lab.height(load) < -2.0, strength < 1);
  }
}

// A load that falls into its rope. The rope is taut within one substep, whichever substep of the step this
// is.
TEST(Joint, BreaksByAShockShorterThanAStep) {
  for (int i = 0; i < 16; ++i) {
    Lab lab;
    const BodyId load =
        lab.add({.position = {0, -1.0f - 0.01f * static_cast<float>(i), 0}, .mass = 1.0f}, kBox);
    JointDef def = between(kWorld, {}, load, {});
    def.break_force = 500.0f;  // at 8 m/s, stopped in a substep of 1/240 s, it takes 2 kN
    const JointId joint = lab.world.create_joint(def, DistanceJoint{{.upper = 5.0f}});
    lab.run(80);
    EXPECT_FALSE(lab.world.is_enabled(joint)) << i;
    EXPECT_LT(lab.height(load), -5.5) << i;
  }
}

// A soft rope is a spring with the rope's length as its rest length. It stops the load by v / (2 pi f) and
// never pulls harder than a spring.
TEST(Joint, OfASoftRopeStopsAFallAsASpringDoes) {
  const double rate = 2.0 * std::numbers::pi * 1.0, speed = 10.0;
  for (int i = 0; i < 24; ++i) {
    Lab lab(without_gravity());
    const BodyId load = lab.add({.position = {0, -1.0f - 0.01f * static_cast<float>(i), 0},
                                 .linear_velocity = {0, -10.0f, 0},
                                 .mass = 1.0f},
                                kBox);
    JointDef def = between(kWorld, {}, load, {});
    def.hertz = 1.0f;
    def.damping_ratio = 0.0f;
    def.break_force = static_cast<float>(1.2 * speed * rate);
    const JointId joint = lab.world.create_joint(def, DistanceJoint{{.upper = 2.0f}});
    double lowest = 0.0;
    for (int step = 0; step < 60; ++step) {
      lab.run(1);
      lowest = std::min(lowest, lab.height(load));
    }
    EXPECT_NEAR(-2.0 - lowest, speed / rate, 0.06 * speed / rate) << i;
    EXPECT_NEAR(lab.velocity(load).y(), 0.95 * speed, 0.05 * speed) << i;  // implicit springs lose a little
    EXPECT_TRUE(lab.world.is_enabled(joint)) << i;
  }
}

TEST(Joint, ThatBreaksLetsABodyFallEvenIfItIsAboutToSleep) {
  int broken = 0;
  for (int calm = 1; calm < 90; ++calm) {
    Lab lab(with_sleep());
    const BodyId load = lab.add({.position = {0, -1, 0}}, kBox);
    const JointId joint = lab.world.create_joint(between(kWorld, {}, load, {0, 1, 0}), BallJoint{});
    lab.run(calm);
    lab.world.set_joint_strength(joint, 1.0f, kNoLimit);
    lab.run(1);
    if (lab.world.broken_joints().empty()) continue;  // the load had fallen asleep before
    ++broken;
    const double weight = lab.mass(load) * kGravity;
    EXPECT_NEAR(lab.world.joint_reaction(joint).force.y, weight, 0.2 * weight)
        << "the reaction that broke the joint";
    lab.run(30);
    EXPECT_LT(lab.velocity(load).y(), -4.0) << calm;
    EXPECT_EQ(lab.world.joint_reaction(joint), JointReaction{});
  }
  EXPECT_GT(broken, 20);
  EXPECT_LT(broken, 89);
}

TEST(Joint, ReportsNoForceFromBeforeItSlept) {
  Lab lab(with_sleep());
  const std::vector<BodyId> links = hang_chain(lab, 2);
  JointId joint;
  ASSERT_EQ(lab.world.joints_of(links[1], {&joint, 1}), 1u);
  lab.run(10);
  EXPECT_GT(lab.world.joint_reaction(joint).force.y, 0.0f);
  lab.run(290);
  ASSERT_FALSE(lab.world.is_awake(links[1]));
  EXPECT_EQ(lab.world.joint_reaction(joint), JointReaction{});
  lab.world.wake(links[1]);
  EXPECT_EQ(lab.world.joint_reaction(joint), JointReaction{}) << "no step has loaded the joint yet";
  lab.run(1);
  EXPECT_GT(lab.world.joint_reaction(joint).force.y, 0.0f);
}

TEST(Joint, ReportsTheForceThatItTransmits) {
  Lab lab;
  const BodyId load = lab.add({.position = {0, -1, 0}}, kBox);
  const JointId joint = lab.world.create_joint(between(kWorld, {}, load, {0, 1, 0}), BallJoint{});
  lab.run(120);
  const double weight = lab.mass(load) * kGravity;
  EXPECT_NEAR(lab.world.joint_reaction(joint).force.y / weight, 1.0, 0.01);
}

TEST(Joint, IsDestroyedWithItsBodyAndListedByTheNextStep) {
  Lab lab;
  const BodyId a = lab.add({.position = {0, 5, 0}}, kBox), b = lab.add({.position = {0, 3, 0}}, kBox);
  const JointId joint = lab.world.create_joint(between(a, {0, -1, 0}, b, {0, 1, 0}), BallJoint{});
  lab.run(1);
  lab.world.destroy_body(a);
  EXPECT_FALSE(lab.world.is_alive(joint));
  lab.run(1);
  ASSERT_EQ(lab.world.destroyed_joints().size(), 1u);
  EXPECT_EQ(lab.world.destroyed_joints()[0], joint);
  lab.run(1);
  EXPECT_TRUE(lab.world.destroyed_joints().empty());
}

// --- hubs and colors ---

// A heavy ball with balls on short arms all around it, all in free flight. The heavy ball is the first body
// of every joint, or the second.
std::vector<BodyId> add_hedgehog(Lab& lab, int count, float radius, const Joint& joint = BallJoint{},
                                 bool first = true) {
  std::vector<BodyId> bodies{lab.add({.mass = 50.0f}, Sphere{0.9f})};
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, azimuth = 2.399963 * i, r = std::sqrt(1.0 - z * z);
    const Vec3 out{static_cast<float>(r * std::cos(azimuth)), static_cast<float>(r * std::sin(azimuth)),
                   static_cast<float>(z)};
    const BodyId ball = lab.add({.position = 2.0f * out, .mass = 1.0f}, Sphere{radius});
    lab.world.create_joint(first ? between(bodies[0], out, ball, -out) : between(ball, -out, bodies[0], out),
                           joint);
    bodies.push_back(ball);
  }
  return bodies;
}

std::ptrdiff_t joint_chunks_of_hubs(World& world) {
  const Constraints& constraints = constraints_of(internals(world));
  return std::count_if(constraints.joint_chunks.begin(), constraints.joint_chunks.end(),
                       [](const simd::ConstraintChunk& c) { return c.hub != simd::BodySide::none; });
}

Eigen::Vector3d momentum_of(Lab& lab, const std::vector<BodyId>& bodies) {
  Eigen::Vector3d momentum(0, 0, 0);
  for (const BodyId body : bodies) momentum += lab.mass(body) * lab.velocity(body);
  return momentum;
}

TEST(JointHub, OfHundredsOfJointsIsSolvedInGroupsAndKeepsItsMomentum) {
  WorldSettings settings = without_gravity();
  Lab lab(settings);
  const std::vector<BodyId> bodies = add_hedgehog(lab, 300, 0.01f);
  lab.world.add_impulse(bodies[17], {0, 5, 0});
  lab.run(1);
  EXPECT_GT(joint_chunks_of_hubs(lab.world), 0);
  lab.run(120);
  EXPECT_NEAR((momentum_of(lab, bodies) - Eigen::Vector3d(0, 5, 0)).norm(), 0.0, 1e-3);
  std::vector<JointId> joints(300);
  ASSERT_EQ(lab.world.joints_of(bodies[0], joints), 300u);
  for (const JointId joint : joints) {
    EXPECT_LT(to_eigen(lab.world.joint_pose(joint).position).norm(), 0.005);
  }
}

// Pairs of bodies test what each kind holds. No small balls here: a ball that slides along an axis at the end
// of a long arm spins without bounds once the arm is perpendicular to that axis.
TEST(JointHub, OfEveryKindKeepsItsMomentumAndGainsNoEnergy) {
  for (const Joint& joint : test::plain_joints()) {
    const auto type = static_cast<JointType>(joint.index());
    if (type == JointType::mouse || type == JointType::pulley) continue;  // these pull at the world
    for (const bool first : {true, false}) {
      Lab lab(without_gravity());
      const std::vector<BodyId> bodies = add_hedgehog(lab, 100, 0.2f, joint, first);
      lab.world.add_impulse(bodies[17], {0, 5, 0});
      lab.run(1);
      EXPECT_GT(joint_chunks_of_hubs(lab.world), 0) << joint.index();
      for (int i = 0; i < 6; ++i) {
        lab.run(10);
        EXPECT_LT(lab.world.stats().kinetic_energy, 12.5 * 1.001)  // J, (5 kg m/s)^2 / (2 1 kg)
            << "kind " << joint.index() << (first ? ", first" : ", second");
      }
      EXPECT_NEAR((momentum_of(lab, bodies) - Eigen::Vector3d(0, 5, 0)).norm(), 0.0, 1e-3) << joint.index();
    }
  }
}

// More joints than there are colors: the others are solved in groups, as a hub's joints are.
TEST(JointHub, APlatformHangsLevelFromHundredsOfRopes) {
  Lab lab;
  const BodyId platform = lab.add({.mass = 5000.0f}, Box{{10, 0.25f, 7.5f}});
  for (int i = 0; i < 300; ++i) {
    const Vec3 place{static_cast<float>(i % 20) - 9.5f, 0.25f, static_cast<float>(i / 20) - 7.0f};
    JointDef def = between(kWorld, place + Vec3{0, 5, 0}, platform, place);
    if (i % 2 == 0) {
      std::swap(def.body_a, def.body_b);
      std::swap(def.frame_a, def.frame_b);
    }
    lab.world.create_joint(def, DistanceJoint{{.upper = 5.0f}});
  }
  lab.run(1);
  EXPECT_GT(joint_chunks_of_hubs(lab.world), 0);
  for (int i = 0; i < 120; ++i) {
    lab.run(1);
    EXPECT_NEAR(lab.position(platform).y(), 0.0, 2e-3);
    EXPECT_LT(lab.velocity(platform).norm() + lab.spin(platform).norm(), 0.02);
  }
  double carried = 0.0;
  std::vector<JointId> joints(300);
  ASSERT_EQ(lab.world.joints_of(platform, joints), 300u);
  for (const JointId joint : joints) carried += std::abs(lab.world.joint_reaction(joint).force.y);
  EXPECT_NEAR(carried, 5000.0 * kGravity, 0.01 * 5000.0 * kGravity);
}

TEST(JointColoring, NoColorSharesADynamicBody) {
  Lab lab;
  lab.add_ground();
  std::vector<BodyId> bodies;
  for (int i = 0; i < 200; ++i) {
    const Vec3 place{static_cast<float>(i % 10), 0.6f + static_cast<float>(i / 100),
                     static_cast<float>(i / 10 % 10)};
    bodies.push_back(lab.add({.position = place}, Sphere{0.55f}));
  }
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    lab.world.create_joint(between(bodies[i], {0.1f, 0, 0}, bodies[(i * 2654435761u >> 7) % i], {0, 0.1f, 0}),
                           BallJoint{});
  }
  lab.run(3);
  WorldData& data = internals(lab.world);
  const Constraints& constraints = constraints_of(data);
  std::set<std::pair<int, std::int32_t>> taken;
  std::size_t joints = 0;
  for (std::size_t i = 0; i < constraints.edges.size(); ++i) {
    const Edge& edge = constraints.edges[i];
    if (edge.color == kOverflowColor || edge.kind == EdgeKind::hub_a || edge.kind == EdgeKind::hub_b)
      continue;
    joints += i >= data.contacts.active.size() ? 1 : 0;
    const int color = edge.kind == EdgeKind::pushed_b ? 100 + edge.color : edge.color;
    EXPECT_TRUE(taken.insert({color, edge.body_b}).second) << "color " << color << ", body " << edge.body_b;
    if (edge.kind != EdgeKind::pushed_b) {
      EXPECT_TRUE(taken.insert({color, edge.body_a}).second) << "color " << color << ", body " << edge.body_a;
    }
  }
  EXPECT_GT(joints, 100u);
}

}  // namespace
}  // namespace scree::physics
