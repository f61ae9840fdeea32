// Laws of joint events: they are the joints that bore more than their thresholds, and nothing else.
#include <core/constraints/joint_parameters.h>
#include <tests/core/constraints/joint_samples.h>
#include <tests/physics/lab.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace scree::physics {
namespace {

constexpr Box kLoad{{0.5f, 0.5f, 0.5f}};

using Strained = std::vector<JointEvent>;

Strained strained(const World& world) { return {world.joint_events().begin(), world.joint_events().end()}; }

Strained strained_over(Lab& lab, int steps) {
  Strained events;
  for (int i = 0; i < steps; ++i) {
    lab.run(1);
    events.insert(events.end(), lab.world.joint_events().begin(), lab.world.joint_events().end());
  }
  return events;
}

JointDef hung_from_world(BodyId load, Vec3 anchor) {
  return {.body_a = kWorld, .body_b = load, .frame_a = {anchor, {}}, .frame_b = {anchor, {}}};
}

// A body hangs on a joint of a kind, or is driven by it, while it is pushed about.
struct Tested {
  Lab lab;
  JointId joint;

  Tested(const Joint& kind, JointDef def, Solver solver = Solver::soft_step) {
    WorldSettings settings = without_sleep();
    settings.solver = solver;
    lab.world.set_settings(settings);
    const BodyId post = lab.add({.type = BodyType::fixed, .position = {0, 0.7f, 0}}, kLoad);
    load = lab.add(
        {.position = {0.3f, -1, 0.1f}, .linear_velocity = {1, 0, 1}, .angular_velocity = {1, 2, 0}}, kLoad);
    def.body_a = type_of(kind) == JointType::mouse ? kWorld : post;
    def.body_b = load;
    def.frame_b = {{0, 0.6f, 0}, {}};
    joint = lab.world.create_joint(def, kind);
    if (type_of(kind) == JointType::user) {
      std::vector<UserRow> rows(lab.world.user_rows(joint, {}));
      for (std::size_t i = 0; i < rows.size(); ++i) {
        rows[i].jacobian.linear_b = {0, 1, 0};
        rows[i].jacobian.angular_b = {0.3f * static_cast<float>(i), 0, 1};
      }
      lab.world.set_user_rows(joint, rows);
    }
  }
  void run(int i) {
    if (i % 7 == 5) lab.world.add_impulse(load, {static_cast<float>(100 * i), 50, -200});
    lab.run(1);
  }

  BodyId load;
};

std::vector<Joint> tested_kinds() {
  std::vector<Joint> kinds = test::plain_joints();
  for (const Joint& joint : test::sound_joints()) kinds.push_back(joint);
  return kinds;
}

TEST(JointEvents, OfAHingeTellItsLoad) {
  for (const float share : {0.99f, 1.01f}) {
    Lab lab;
    const BodyId load = lab.add({.position = {0, -1, 0}}, kLoad);
    const auto weight = static_cast<float>(lab.mass(load) * kGravity);
    JointDef def = hung_from_world(load, {});
    def.frame_b = {{0, 1, 0}, {}};
    const JointId joint = lab.world.create_joint(def, HingeJoint{});
    EXPECT_TRUE(strained_over(lab, 60).empty());
    lab.world.set_joint_event_thresholds(joint, share * weight, kNoLimit);
    for (int i = 0; i < 10; ++i) {
      lab.run(1);
      const Strained events = strained(lab.world);
      ASSERT_EQ(events.size(), share < 1 ? 1u : 0u);
      if (share > 1) continue;
      EXPECT_EQ(events[0].joint, joint);
      EXPECT_NEAR(events[0].force, weight, 1e-3f * weight);
      EXPECT_NEAR(events[0].torque, 0.0f, 1e-3f * weight);
    }
    EXPECT_TRUE(lab.world.is_enabled(joint));
    EXPECT_TRUE(lab.world.broken_joints().empty());
  }
}

TEST(JointEvents, OfABracketTellItsTorque) {
  for (const float share : {0.98f, 1.02f}) {
    Lab lab;
    const BodyId load = lab.add({.position = {2, 0, 0}}, kLoad);
    const auto torque = static_cast<float>(2.0 * lab.mass(load) * kGravity);
    JointDef def = hung_from_world(load, {});
    def.frame_b = {{-2, 0, 0}, {}};
    const JointId joint = lab.world.create_joint(def, WeldJoint{});
    lab.run(120);
    lab.world.set_joint_event_thresholds(joint, kNoLimit, share * torque);
    lab.run(1);
    ASSERT_EQ(lab.world.joint_events().size(), share < 1 ? 1u : 0u);
    if (share < 1) {
      EXPECT_NEAR(lab.world.joint_events()[0].torque, torque, 0.01f * torque);
    }
  }
}

// For all kinds: with a threshold of nothing the events tell what the joint bears, above another one they are
// those among these that are greater, and a joint of that strength breaks in the first such step.
TEST(JointEvents, AreTheReactionsAboveTheThresholdsAndJointsOfThatStrengthBreakInThem) {
  int kinds_that_break = 0;
  for (const Joint& kind : tested_kinds()) {
    SCOPED_TRACE(name_of(type_of(kind)));
    Tested all(kind, {.event_force = 0.0f, .event_torque = 0.0f});
    std::vector<JointEvent> told;
    std::vector<float> forces, torques;
    for (int i = 0; i < 60; ++i) {
      all.run(i);
      const Strained events = strained(all.lab.world);
      const JointReaction last = all.lab.world.joint_reaction(all.joint);
      told.push_back(events.empty() ? JointEvent{} : events[0]);
      ASSERT_EQ(events.size(), told.back().force > 0.0f || told.back().torque > 0.0f ? 1u : 0u) << i;
      EXPECT_GE(told.back().force, 0.9999f * length(last.force)) << i;
      EXPECT_GE(told.back().torque, 0.9999f * length(last.torque)) << i;
      forces.push_back(told.back().force);
      torques.push_back(told.back().torque);
    }
    for (const bool by_force : {true, false}) {
      std::vector<float> sorted = by_force ? forces : torques;
      std::nth_element(sorted.begin(), sorted.begin() + 45, sorted.end());
      const float threshold = sorted[45];
      if (!(threshold > 0.0f)) continue;
      const float force = by_force ? threshold : kNoLimit, torque = by_force ? kNoLimit : threshold;
      Tested some(kind, {.event_force = force, .event_torque = torque});
      Tested weak(kind, {.break_force = force, .break_torque = torque});
      Tested both(
          kind, {.break_force = force, .break_torque = torque, .event_force = force, .event_torque = torque});
      bool broken = false;
      for (int i = 0; i < 60; ++i) {
        for (Tested* tested : {&some, &weak, &both}) tested->run(i);
        const JointEvent& expected = told[static_cast<std::size_t>(i)];
        const bool above = (by_force ? expected.force : expected.torque) > threshold;
        const Strained events = strained(some.lab.world);
        ASSERT_EQ(events.size(), above ? 1u : 0u) << i;
        if (above) {
          EXPECT_EQ(events[0].force, expected.force);
          EXPECT_EQ(events[0].torque, expected.torque);
        }
        if (broken) {
          EXPECT_TRUE(both.lab.world.joint_events().empty()) << i;
          continue;
        }
        ASSERT_EQ(weak.lab.world.broken_joints().size(), above ? 1u : 0u) << i;
        ASSERT_EQ(both.lab.world.broken_joints().size(), above ? 1u : 0u) << i;
        ASSERT_EQ(both.lab.world.joint_events().size(), above ? 1u : 0u) << i;
        broken = above;
      }
      kinds_that_break += broken ? 1 : 0;
    }
  }
  EXPECT_GT(kinds_that_break, 30);
}

TEST(JointEvents, ComeWithEverySolver) {
  for (int solver = 0; solver < kSolverCount; ++solver) {
    Tested hung(BallJoint{}, {.event_force = 1.0f}, static_cast<Solver>(solver));
    for (int i = 0; i < 20; ++i) {
      hung.run(i);
      const Strained events = strained(hung.lab.world);
      ASSERT_EQ(events.size(), 1u) << solver << ", step " << i;
      EXPECT_GE(events[0].force, 0.9999f * length(hung.lab.world.joint_reaction(hung.joint).force)) << solver;
    }
  }
}

// Nets of joints, some of which are asked about; the bodies in the middle have so many that they are hubs.
struct Net {
  Lab lab;
  std::vector<JointId> joints;

  explicit Net(bool asked) {
    Random random(3);
    for (int net = 0; net < 3; ++net) {
      const Vec3 middle{20.0f * static_cast<float>(net), 5, 0};
      const BodyId hub = lab.add({.position = middle}, Sphere{1.0f});
      join(kWorld, hub, middle, asked);
      for (int i = 0; i < 60; ++i) {
        const Vec3 at = random.vector(3.0f);
        const BodyId end = lab.add({.position = middle + at}, Sphere{0.1f}, {.density = 3000.0f});
        join(hub, end, at, asked);
      }
    }
  }
  void join(BodyId a, BodyId b, Vec3 at, bool asked) {
    const std::size_t i = joints.size();
    const bool asks = asked && i % 3 == 0, breaks = i % 5 == 1;
    const JointDef def{.body_a = a,
                       .body_b = b,
                       .frame_a = {at, {}},
                       .break_force = breaks ? 150.0f : kNoLimit,
                       .event_force = asks ? 100.0f : kNoLimit};
    joints.push_back(i % 2 == 0 ? lab.world.create_joint(def, WeldJoint{})
                                : lab.world.create_joint(def, BallJoint{}));
  }
};

TEST(JointEvents, ChangeNoMotionAndAscend) {
  Net asked(true), plain(false);
  std::size_t events = 0, broken = 0;
  for (int i = 0; i < 120; ++i) {
    asked.lab.run(1);
    plain.lab.run(1);
    ASSERT_EQ(asked.lab.world.hash(), plain.lab.world.hash()) << i;
    ASSERT_TRUE(plain.lab.world.joint_events().empty());
    const Strained list = strained(asked.lab.world);
    for (std::size_t k = 0; k < list.size(); ++k) {
      EXPECT_TRUE(k == 0 || list[k - 1].joint.index < list[k].joint.index);
      EXPECT_EQ(list[k].joint.index % 3, 0u) << "nobody asked";
      EXPECT_GT(list[k].force, 100.0f);
    }
    events += list.size();
    broken += asked.lab.world.broken_joints().size();
  }
  EXPECT_GT(events, 1000u);
  EXPECT_GT(broken, 10u);
}

TEST(JointEvents, AreTheSameForEveryNumberOfThreads) {
  Net one(true), many(true);
  Workers workers{3};
  for (int i = 0; i < 60; ++i) {
    one.lab.run(1);
    step(many.lab.world, kStep, workers);
    const auto a = one.lab.world.joint_events(), b = many.lab.world.joint_events();
    ASSERT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
      return x.joint.index == y.joint.index && x.force == y.force && x.torque == y.torque;
    })) << i;
  }
}

TEST(JointEvents, AreNoneOfSleepingDisabledOrDestroyedJoints) {
  Lab lab{WorldSettings{}};
  const BodyId load = lab.add({.position = {0, -1, 0}}, kLoad);
  JointDef def = hung_from_world(load, {});
  def.frame_b = {{0, 1, 0}, {}};
  def.event_force = 0.0f;
  const JointId joint = lab.world.create_joint(def, WeldJoint{});
  lab.run(1);
  EXPECT_EQ(lab.world.joint_events().size(), 1u);
  lab.run(1, 0.0f);
  EXPECT_TRUE(lab.world.joint_events().empty()) << "a step of no length";
  lab.run(200);
  ASSERT_FALSE(lab.world.is_awake(load));
  EXPECT_TRUE(lab.world.joint_events().empty());
  lab.world.set_joint_event_thresholds(joint, 1.0f, 1.0f);
  lab.run(1);
  EXPECT_FALSE(lab.world.is_awake(load)) << "asking wakes nothing";
  EXPECT_TRUE(lab.world.joint_events().empty());
  lab.world.wake(load);
  lab.run(1);
  EXPECT_EQ(lab.world.joint_events().size(), 1u);
  lab.world.set_joint_enabled(joint, false);
  lab.run(1);
  EXPECT_TRUE(lab.world.joint_events().empty());
  lab.world.set_joint_enabled(joint, true);
  lab.run(1);
  EXPECT_EQ(lab.world.joint_events().size(), 1u);
  lab.world.destroy_joint(joint);
  ASSERT_EQ(lab.world.joint_events().size(), 1u) << "lists stay until the next step";
  EXPECT_FALSE(lab.world.is_alive(lab.world.joint_events()[0].joint));
  lab.run(1);
  EXPECT_TRUE(lab.world.joint_events().empty());
}

TEST(JointEvents, AfterARestoreAreThoseWithoutIt) {
  Net net(true);
  net.lab.run(10);
  Snapshot snapshot;
  save(net.lab.world, snapshot);
  const Strained expected = strained_over(net.lab, 30);
  EXPECT_GT(expected.size(), 100u);
  restore(net.lab.world, snapshot);
  EXPECT_EQ(strained_over(net.lab, 30), expected);
  Lab other;
  restore(other.world, snapshot);
  EXPECT_EQ(strained_over(other, 30), expected);
}

}  // namespace
}  // namespace scree::physics
