// Laws of the calls that create, change, read and destroy joints.
#include <core/constraints/joint_parameters.h>
#include <scree/scree.h>
#include <tests/core/constraints/joint_samples.h>
#include <tests/core/world/world_fixture.h>

#include <algorithm>
#include <functional>
#include <map>

namespace scree::test {
namespace {

std::vector<BodyId> add_bodies(World& world, std::size_t count) {
  std::vector<BodyId> bodies(count);
  world.create_bodies(std::vector<BodyDef>(count), bodies);
  return bodies;
}

std::vector<JointId> joints_of(const World& world, BodyId body) {
  std::vector<JointId> joints(world.joints_of(body, {}));
  EXPECT_EQ(world.joints_of(body, joints), joints.size());
  return joints;
}

bool is_jointed(const World& world, BodyId body) {
  return (internals(world).bodies.motion[body.index].flags & kMotionJointed) != 0;
}

// Expects that the lists of all bodies hold the living joints, forwards and backwards.
void expect_sound_lists(const World& world) {
  const WorldData& data = internals(world);
  std::map<std::int32_t, int> listed;
  for (std::size_t row = 0; row < data.bodies.flags.size(); ++row) {
    const auto body = static_cast<std::int32_t>(row);
    std::int32_t before = -1;
    for (std::int32_t joint = data.bodies.first_joint[row]; joint >= 0;
         joint = next_joint(data.joints, joint, body)) {
      const auto index = static_cast<std::size_t>(joint);
      ASSERT_NE(data.joints.flags[index] & kJointAlive, 0);
      ASSERT_EQ(link_of(data.joints.previous[index], data.joints.bodies[index], body), before);
      ++listed[joint];
      before = joint;
    }
    const bool flagged = (data.bodies.motion[row].flags & kMotionJointed) != 0;
    ASSERT_EQ(flagged, before >= 0);
  }
  std::size_t alive = 0;
  for (std::size_t row = 0; row < data.joints.flags.size(); ++row) {
    if ((data.joints.flags[row] & kJointAlive) == 0) continue;
    ++alive;
    const JointBodies ends = data.joints.bodies[row];
    const int wanted = (is_listed(ends.a) ? 1 : 0) + (is_listed(ends.b) ? 1 : 0);
    ASSERT_EQ(listed[static_cast<std::int32_t>(row)], wanted);
  }
  ASSERT_EQ(world.joint_count(), alive);
}

TEST(Joints, ReturnWhatTheyWereCreatedWith) {
  World world;
  const std::vector<BodyId> bodies = add_bodies(world, 2);
  for (const std::vector<Joint>& joints : {plain_joints(), sound_joints()}) {
    for (const Joint& joint : joints) {
      SCOPED_TRACE(name_of(type_of(joint)));
      JointDef def{.body_a = bodies[0],
                   .body_b = bodies[1],
                   .frame_a = {{1, 2, 3}, {0.5f, 0.5f, -0.5f, 0.5f}},
                   .frame_b = {{4, 5, 6}, {0, 1, 0, 0}},
                   .collide_connected = true,
                   .enabled = false,
                   .hertz = 3.0f,
                   .damping_ratio = 0.25f,
                   .break_force = 10.0f,
                   .break_torque = 20.0f,
                   .event_force = 0.0f,
                   .event_torque = 15.0f,
                   .user_data = 77};
      if (type_of(joint) == JointType::mouse) def.body_a = kWorld;
      const JointId id = world.create_joint(def, joint);
      EXPECT_TRUE(world.is_alive(id));
      EXPECT_EQ(world.joint_type(id), type_of(joint));
      EXPECT_TRUE(world.joint(id) == joint);
      EXPECT_TRUE(world.joint_def(id) == def);
      EXPECT_EQ(world.user_data(id), 77u);
      EXPECT_FALSE(world.is_enabled(id));
      EXPECT_TRUE(world.collides_connected(id));
      EXPECT_EQ(world.joint_reaction(id), JointReaction{});
      const JointId other = world.create_joint({.body_a = kWorld, .body_b = bodies[1]}, joint);
      EXPECT_TRUE(world.is_enabled(other));
      EXPECT_FALSE(world.collides_connected(other));
      EXPECT_TRUE(world.joint_def(other) == (JointDef{.body_a = kWorld, .body_b = bodies[1]}));
    }
  }
  EXPECT_EQ(world.joint_count(), 4u * kJointTypeCount);
  expect_sound_lists(world);
}

TEST(Joints, ReturnWhatTheyWereSetTo) {
  World world;
  const BodyId body = add_bodies(world, 1)[0];
  const std::vector<Joint> first = sound_joints(), second = sound_joints(0.25f);
  for (std::size_t i = 0; i < first.size(); ++i) {
    SCOPED_TRACE(name_of(type_of(first[i])));
    const JointId id = world.create_joint({.body_a = kWorld, .body_b = body}, first[i]);
    world.set_joint_stiffness(id, 5.0f, 0.5f);
    EXPECT_TRUE(world.joint(id) == first[i]);
    world.set_joint(id, second[i]);
    EXPECT_TRUE(world.joint(id) == second[i]);
    EXPECT_FALSE(world.joint(id) == first[i]);
    world.set_joint_strength(id, 2.0f, kNoLimit);
    world.set_joint_event_thresholds(id, 1.0f, 0.0f);
    const Pose frame_a{{9, 8, 7}, {1, 0, 0, 0}}, frame_b{{6, 5, 4}, {0, 0, 1, 0}};
    world.set_joint_frames(id, frame_a, frame_b);
    world.set_collide_connected(id, true);
    world.set_joint_enabled(id, false);
    world.set_user_data(id, 5);
    EXPECT_TRUE(world.joint_def(id) == (JointDef{.body_a = kWorld,
                                                 .body_b = body,
                                                 .frame_a = frame_a,
                                                 .frame_b = frame_b,
                                                 .collide_connected = true,
                                                 .enabled = false,
                                                 .hertz = 5.0f,
                                                 .damping_ratio = 0.5f,
                                                 .break_force = 2.0f,
                                                 .event_force = 1.0f,
                                                 .event_torque = 0.0f,
                                                 .user_data = 5}));
    world.set_joint_enabled(id, true);
    EXPECT_TRUE(world.is_enabled(id));
    EXPECT_TRUE(world.joint(id) == second[i]);
  }
}

TEST(Joints, RotationsAreRenormalized) {
  World world;
  const BodyId body = add_bodies(world, 1)[0];
  const Quat longer{0.0f, 1.0005f, 0.0f, 0.0f}, unit{0.0f, 1.0f, 0.0f, 0.0f};
  const JointId id =
      world.create_joint({.body_a = kWorld, .body_b = body, .frame_a = {{}, longer}, .frame_b = {{}, longer}},
                         BallJoint{.drive = {.target = longer}});
  EXPECT_EQ(world.joint_def(id).frame_a.rotation, unit);
  EXPECT_EQ(world.joint_def(id).frame_b.rotation, unit);
  EXPECT_EQ(std::get<BallJoint>(world.joint(id)).drive.target, unit);
}

TEST(Joints, FlagsFollowLimitsDrivesStrengthAndThresholds) {
  World world;
  const BodyId body = add_bodies(world, 1)[0];
  const JointId id = world.create_joint({.body_a = kWorld, .body_b = body}, HingeJoint{});
  const auto has = [&](JointFlag flag) { return (internals(world).joints.flags[id.index] & flag) != 0; };
  const auto reporting = [&] { return internals(world).joints.reporting; };
  EXPECT_FALSE(has(kJointRich) || has(kJointBreaks) || has(kJointReports));
  world.set_joint(id, HingeJoint{{.lower = -1.0f, .upper = 1.0f}});
  EXPECT_TRUE(has(kJointRich));
  world.set_joint(id, HingeJoint{});
  EXPECT_FALSE(has(kJointRich));
  world.set_joint_strength(id, kNoLimit, 3.0f);
  EXPECT_TRUE(has(kJointBreaks));
  world.set_joint_strength(id, kNoLimit, kNoLimit);
  EXPECT_FALSE(has(kJointBreaks));
  for (int time = 0; time < 2; ++time) {
    world.set_joint_event_thresholds(id, kNoLimit, 0.0f);
    EXPECT_TRUE(has(kJointReports) && !has(kJointBreaks));
    EXPECT_EQ(reporting(), 1);
  }
  const World other = clone(world);
  EXPECT_EQ(internals(other).joints.reporting, 1);
  world.set_joint_event_thresholds(id, kNoLimit, kNoLimit);
  EXPECT_FALSE(has(kJointReports));
  EXPECT_EQ(reporting(), 0);
  const JointId second =
      world.create_joint({.body_a = kWorld, .body_b = body, .event_force = 5.0f}, HingeJoint{});
  EXPECT_EQ(reporting(), 1);
  world.destroy_joint(second);
  EXPECT_EQ(reporting(), 0);
}

TEST(Joints, GoWithTheirBodies) {
  World world;
  const std::vector<BodyId> bodies = add_bodies(world, 4);
  const auto join = [&](BodyId a, BodyId b) {
    return world.create_joint({.body_a = a, .body_b = b}, BallJoint{});
  };
  const JointId first = join(bodies[0], bodies[1]), second = join(bodies[2], bodies[0]);
  const JointId third = join(kWorld, bodies[0]), other = join(bodies[1], bodies[2]),
                last = join(bodies[3], kWorld);
  EXPECT_EQ(joints_of(world, bodies[0]), (std::vector{third, second, first}));
  world.destroy_body(bodies[0]);
  for (const JointId joint : {first, second, third}) EXPECT_FALSE(world.is_alive(joint));
  EXPECT_EQ(joints_of(world, bodies[1]), std::vector{other});
  EXPECT_EQ(joints_of(world, bodies[2]), std::vector{other});
  expect_sound_lists(world);
  world.destroy_bodies(std::vector{bodies[1], bodies[2], bodies[3]});
  EXPECT_EQ(world.joint_count(), 0u);
  std::vector<JointId> lost;
  for (const SlotName& joint : internals(world).events.lost) {
    lost.push_back(handle_of<JointId>(internals(world), joint));
  }
  const std::vector<JointId> wanted{third, second, first, other, last};
  EXPECT_EQ(lost, wanted);
  EXPECT_TRUE(world.destroyed_joints().empty()) << "of a step that is to come";
  Workers workers(1);
  step(world, 1.0f / 60.0f, workers);
  const std::span<const JointId> told = world.destroyed_joints();
  EXPECT_EQ(std::vector<JointId>(told.begin(), told.end()), wanted);
  step(world, 1.0f / 60.0f, workers);
  EXPECT_TRUE(world.destroyed_joints().empty());
}

TEST(Joints, DestroyedByACallAreNotListedAsLostWithTheirBodies) {
  World world;
  const BodyId body = add_bodies(world, 1)[0];
  const JointId joint = world.create_joint({.body_a = kWorld, .body_b = body}, BallJoint{});
  EXPECT_TRUE(is_jointed(world, body));
  world.destroy_joint(joint);
  EXPECT_FALSE(world.is_alive(joint));
  EXPECT_FALSE(is_jointed(world, body));
  EXPECT_TRUE(internals(world).events.lost.empty());
}

TEST(Joints, DefaultHandlesAreNotAlive) {
  World world;
  EXPECT_FALSE(world.is_alive(JointId{}));
  EXPECT_NE(error_of([&] { world.joint(JointId{}); }).find("names no joint"), std::string::npos);
  const JointId joint =
      world.create_joint({.body_a = kWorld, .body_b = add_bodies(world, 1)[0]}, BallJoint{});
  EXPECT_EQ(joint.index, 0u);
  EXPECT_FALSE(world.is_alive(JointId{}));
}

TEST(Joints, ASlotIsReusedUnderANewGeneration) {
  World world;
  const BodyId body = add_bodies(world, 1)[0];
  const auto join = [&] {
    return world.create_joint({.body_a = kWorld, .body_b = body, .user_data = 9}, WeldJoint{});
  };
  const JointId first = join(), second = join(), third = join();
  world.destroy_joint(second);
  world.destroy_joint(first);
  const JointId again = join(), more = join();
  EXPECT_EQ(again.index, first.index);  // the slot freed last
  EXPECT_EQ(more.index, second.index);
  EXPECT_NE(again.generation, first.generation);
  EXPECT_FALSE(world.is_alive(first));
  EXPECT_NE(error_of([&] { world.destroy_joint(first); }).find("no joint lives under index 0"),
            std::string::npos);
  EXPECT_EQ(joints_of(world, body), (std::vector{more, again, third}));
}

TEST(Joints, ASlotWithoutGenerationsLeftStaysEmpty) {
  World world;
  const BodyId body = add_bodies(world, 1)[0];
  JointId joint = world.create_joint({.body_a = kWorld, .body_b = body}, BallJoint{});
  internals(world).joints.generation[joint.index] = joint.generation = 0xffffffffu;
  world.destroy_joint(joint);
  EXPECT_NE(world.create_joint({.body_a = kWorld, .body_b = body}, BallJoint{}).index, joint.index);
  EXPECT_FALSE(world.is_alive(JointId{joint.index, 0}));
}

TEST(Joints, AWorldThatWasMovedFromThrows) {
  World world;
  const BodyId body = add_bodies(world, 1)[0];
  const JointId joint = world.create_joint({.body_a = kWorld, .body_b = body}, BallJoint{});
  World other = std::move(world);
  EXPECT_TRUE(other.is_alive(joint));
  EXPECT_FALSE(world.is_alive(joint));  // NOLINT(bugprone-use-after-move): the law under test
  EXPECT_EQ(world.joint_count(), 0u);
  EXPECT_TRUE(world.broken_joints().empty() && world.destroyed_joints().empty());
  EXPECT_THROW(world.joint(joint), Error);
  EXPECT_THROW(world.create_joint({.body_a = kWorld, .body_b = body}, BallJoint{}), Error);
}

// --- waking, and lists to rebuild ---

// Two sleeping bodies and a joint, as after a step.
struct Sleepers {
  World world;
  std::vector<BodyId> bodies = add_bodies(world, 3);
  JointId joint = world.create_joint({.body_a = bodies[0], .body_b = bodies[1]}, HingeJoint{});

  Sleepers() {
    for (const BodyId body : bodies) world.add_shape(body, Sphere{});
    rest();
  }
  void rest() {
    consume_dirty(world);
    for (const BodyId body : bodies) put_to_sleep(world, body);
    Joints& joints = internals(world).joints;
    for (const std::int32_t row : joints.changed) joints.is_changed[static_cast<std::size_t>(row)] = 0;
    joints.changed.clear();
    internals(world).contacts.pairs_stale = false;
  }
  // Which of the three bodies are awake.
  std::string awake() const {
    std::string names;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if ((internals(world).bodies.flags[bodies[i].index] & kBodyAsleep) == 0)
        names += static_cast<char>('a' + i);
    }
    return names;
  }
  std::string changed() const {
    const WorldData& data = internals(world);
    return std::string(!data.joints.changed.empty() ? "active " : "") +
           (data.contacts.pairs_stale ? "pairs " : "");
  }
};

TEST(JointWaking, ChangesWakeBothBodiesAndNoOthers) {
  Sleepers s;
  World& world = s.world;
  const std::vector<std::function<void()>> calls = {
      [&] { world.set_joint(s.joint, HingeJoint{{.drive = Drive::motor, .speed = 1.0f}}); },
      [&] {
        world.set_joint_frames(s.joint, {{1, 0, 0}, {}}, {});
      },
      [&] { world.set_joint_stiffness(s.joint, 2.0f, 1.0f); },
      [&] { world.set_joint_enabled(s.joint, false); },
      [&] { world.set_joint_enabled(s.joint, true); },
      [&] { world.set_collide_connected(s.joint, true); },
      [&] {
        world.set_pose(s.bodies[0], {{5, 0, 0}, {}});
      },
      [&] { world.destroy_joint(s.joint); },
      [&] { world.create_joint({.body_a = s.bodies[1], .body_b = s.bodies[0]}, BallJoint{}); },
      [&] { world.destroy_joint(joints_of(world, s.bodies[0])[0]); }};
  for (std::size_t i = 0; i < calls.size(); ++i) {
    s.rest();
    calls[i]();
    EXPECT_EQ(s.awake(), "ab") << "call " << i;
  }
}

TEST(JointWaking, CallsThatChangeNothingWakeNoBody) {
  Sleepers s;
  World& world = s.world;
  const Quat odd{0.2f, 0.4f, -0.4f, 0.8f};  // which no square root makes exactly one long
  const JointId ball =
      world.create_joint({.body_a = s.bodies[0], .body_b = s.bodies[1]}, BallJoint{.drive = {.target = odd}});
  s.rest();
  world.set_joint(s.joint, HingeJoint{});
  world.set_joint(s.joint, world.joint(s.joint));
  world.set_joint(ball, BallJoint{.drive = {.target = odd}});
  world.set_joint(ball, world.joint(ball));
  world.set_collide_connected(s.joint, false);
  world.set_joint_strength(s.joint, 1.0f, 1.0f);
  world.set_joint_event_thresholds(s.joint, 1.0f, 1.0f);
  world.set_user_data(s.joint, 3);
  EXPECT_EQ(s.awake(), "");
  EXPECT_EQ(s.changed(), "");
}

TEST(JointWaking, ADestroyedBodyWakesTheBodiesItWasJoinedWith) {
  Sleepers s;
  s.world.destroy_body(s.bodies[0]);
  EXPECT_FALSE((internals(s.world).bodies.flags[s.bodies[1].index] & kBodyAsleep) != 0);
  EXPECT_TRUE((internals(s.world).bodies.flags[s.bodies[2].index] & kBodyAsleep) != 0);
}

TEST(JointWaking, ADisabledJointWakesNoBody) {
  Sleepers s;
  s.world.set_joint_enabled(s.joint, false);
  s.rest();
  s.world.set_pose(s.bodies[0], {{5, 0, 0}, {}});
  EXPECT_EQ(s.awake(), "a");
}

TEST(JointWaking, AKinematicBodySetInMotionWakesTheBodiesItIsJoinedWith) {
  Sleepers s;
  s.world.set_body_type(s.bodies[0], BodyType::kinematic);
  s.rest();
  s.world.set_linear_velocity(s.bodies[0], {1, 0, 0});
  EXPECT_FALSE((internals(s.world).bodies.flags[s.bodies[1].index] & kBodyAsleep) != 0);
}

TEST(JointChanges, MarkTheListsThatMustBeRebuilt) {
  Sleepers s;
  World& world = s.world;
  const auto expect = [&](const char* wanted, const std::function<void()>& call) {
    s.rest();
    call();
    EXPECT_EQ(s.changed(), wanted);
  };
  const BodyId a = s.bodies[0], b = s.bodies[1];
  JointId made;
  expect("active pairs ", [&] { made = world.create_joint({.body_a = a, .body_b = b}, BallJoint{}); });
  expect("active pairs ", [&] { world.set_collide_connected(made, true); });
  expect("active ", [&] { world.set_joint_enabled(made, false); });
  expect("active ", [&] { world.destroy_joint(made); });
  expect("active pairs ", [&] { world.set_joint_enabled(s.joint, false); });
  expect("active pairs ", [&] { world.destroy_joint(s.joint); });
  expect("active ", [&] { world.create_joint({.body_a = kWorld, .body_b = b}, BallJoint{}); });
  expect("active ",
         [&] { world.create_joint({.body_a = a, .body_b = b, .collide_connected = true}, BallJoint{}); });
}

TEST(JointChanges, AReenabledJointStartsWithoutImpulses) {
  Sleepers s;
  Joints& joints = internals(s.world).joints;
  const auto fill = [&] {
    for (float& impulse : joints.impulses[s.joint.index].impulse) impulse = 3.0f;
    joints.reaction[s.joint.index].force[1] = 2.0f;
  };
  fill();
  s.world.set_joint(s.joint, HingeJoint{{.drive = Drive::motor, .speed = 1.0f}});
  s.world.set_joint_enabled(s.joint, true);
  EXPECT_EQ(joints.impulses[s.joint.index].impulse[4], 3.0f);
  EXPECT_EQ(s.world.joint_reaction(s.joint).force, (Vec3{0, 2, 0}));
  s.world.set_joint_enabled(s.joint, false);
  EXPECT_EQ(s.world.joint_reaction(s.joint), JointReaction{});
  fill();
  s.world.set_joint_enabled(s.joint, true);
  for (const float impulse : joints.impulses[s.joint.index].impulse) EXPECT_EQ(impulse, 0.0f);
}

// --- lists ---

TEST(JointLists, StayConsistentUnderRandomCalls) {
  World world;
  Random random(11);
  std::vector<BodyId> bodies = add_bodies(world, 12);
  std::vector<JointId> joints;
  const auto pick_body = [&] { return bodies[random.below(bodies.size())]; };
  for (int i = 0; i < 3000; ++i) {
    std::erase_if(joints, [&](JointId joint) { return !world.is_alive(joint); });
    switch (random.below(8)) {
      case 0:
        if (!joints.empty()) world.destroy_joint(joints[random.below(joints.size())]);
        break;
      case 1: {
        const std::size_t which = random.below(bodies.size());
        world.destroy_body(bodies[which]);
        bodies[which] = world.create_body({});
        break;
      }
      default: {
        const BodyId a = random.below(4) == 0 ? kWorld : pick_body(), b = pick_body();
        if (a == b) break;
        const bool turned = random.below(2) == 0;
        joints.push_back(
            world.create_joint({.body_a = turned ? b : a, .body_b = turned ? a : b}, BallJoint{}));
        break;
      }
    }
    expect_sound_lists(world);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(joints.size(), 5u);
}

TEST(JointLists, TensOfThousandsAreDestroyedInAnyOrder) {
  // A fixed body and the world with so many joints that quadratic time would be a minute.
  constexpr std::size_t kCount = 60000;
  for (const bool newest_first : {false, true}) {
    World world;
    const BodyId ground = world.create_body({.type = BodyType::fixed});
    const std::vector<BodyId> bodies = add_bodies(world, kCount);
    std::vector<JointDef> defs(2 * kCount);
    for (std::size_t i = 0; i < kCount; ++i) {
      defs[i] = {.body_a = ground, .body_b = bodies[i]};
      defs[kCount + i] = {.body_a = kWorld, .body_b = bodies[i]};
    }
    std::vector<JointId> ids(2 * kCount);
    world.create_joints(defs, std::vector<Joint>(2 * kCount), ids);
    EXPECT_EQ(world.joints_of(ground, {}), kCount);
    if (newest_first) std::reverse(ids.begin(), ids.end());
    for (const JointId id : ids) world.destroy_joint(id);
    EXPECT_EQ(world.joints_of(ground, {}), 0u);
    EXPECT_EQ(world.joint_count(), 0u);
  }
}

}  // namespace
}  // namespace scree::test
