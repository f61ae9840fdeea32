// Laws of the list of active joints: it equals the list made from all joints, after any calls and any sleep,
// and its cost follows the size of changes.
#include <tests/parallel/hand_made_world.h>

#include <core/world/wake.h>
#include <gtest/gtest.h>
#include <parallel/islands/islands.h>
#include <scree/scree.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace scree {
namespace {

using testing::Random;

constexpr float kDt = 1.0f / 60.0f;

// Chains of balls on a floor, some on a post, which fall asleep, break and are pulled about.
class Chains {
 public:
  explicit Chains(std::uint64_t seed) : random_(seed) {
    WorldSettings settings;
    settings.sleep_time = 0.1f;
    world = World(settings);
    floor_ = world.create_body({.type = BodyType::fixed, .position = {0, -1, 0}});
    world.add_shape(floor_, Box{{200, 1, 200}});
    for (int i = 0; i < 60; ++i) add_chain();
  }

  void add_chain() {
    const Vec3 at{random_.uniform(-50, 50), 0.3f, random_.uniform(-50, 50)};
    const int links = 2 + static_cast<int>(random_.below(5));
    for (int i = 0; i < links; ++i) {
      bodies_.push_back(world.create_body({.position = at + Vec3{0.7f * static_cast<float>(i), 0, 0}}));
      world.add_shape(bodies_.back(), Sphere{0.3f}, {.rolling_resistance = 0.1f});
      if (i > 0) join(bodies_[bodies_.size() - 2], bodies_.back(), {0.35f, 0, 0}, {-0.35f, 0, 0});
    }
    if (random_.below(3) == 0) join(floor_, bodies_.back(), at + Vec3{4, 1.5f, 0}, {0.35f, 0, 0});
    if (random_.below(4) == 0) join(kWorld, bodies_.back(), at + Vec3{4, 0.3f, 0}, {0.35f, 0, 0});
  }

  // A call of every kind that changes which joints are active.
  void change_something() {
    switch (random_.below(9)) {
      case 0:
        return add_chain();
      case 1:
        if (bodies_.size() > 100) world.destroy_body(take(bodies_));
        return drop_dead();
      case 2:
        if (joints_.size() > 40) world.destroy_joint(take(joints_));
        return;
      case 3:
        return world.set_joint_enabled(any(joints_), random_.below(2) == 0);
      case 4:
        return world.set_joint_strength(any(joints_), random_.below(2) == 0 ? 0.01f : 1e6f, 1e6f);
      case 5:
        return world.set_linear_velocity(any(bodies_), {2, 1, 0});
      case 6:
        return world.set_body_type(any(bodies_), random_type());
      case 7:
        return world.set_pose(any(bodies_), {{random_.uniform(-50, 50), 0.5f, random_.uniform(-50, 50)}, {}});
      default:
        return world.set_collide_connected(any(joints_), random_.below(2) == 0);
    }
  }

  World world;

 private:
  template <class Id>
  Id any(const std::vector<Id>& list) {
    return list[random_.below(static_cast<std::uint32_t>(list.size()))];
  }
  template <class Id>
  Id take(std::vector<Id>& list) {
    const Id id = any(list);
    std::erase(list, id);
    return id;
  }
  void drop_dead() {
    std::erase_if(joints_, [&](JointId joint) { return !world.is_alive(joint); });
  }
  void join(BodyId a, BodyId b, Vec3 at_a, Vec3 at_b) {
    const JointDef def{.body_a = a, .body_b = b, .frame_a = {at_a, {}}, .frame_b = {at_b, {}}};
    joints_.push_back(world.create_joint(def, BallJoint{}));
  }
  BodyType random_type() {
    const BodyType types[] = {BodyType::fixed, BodyType::kinematic, BodyType::dynamic, BodyType::dynamic};
    return types[random_.below(4)];
  }

  Random random_;
  BodyId floor_;
  std::vector<BodyId> bodies_;
  std::vector<JointId> joints_;
};

// The list by its definition.
std::vector<std::int32_t> joints_at_work(const WorldData& data) {
  std::vector<std::int32_t> list;
  const Joints& joints = data.joints;
  for (std::size_t row = 0; row < joints.flags.size(); ++row) {
    if ((joints.flags[row] & kJointAlive) == 0 || (joints.flags[row] & kJointEnabled) == 0) continue;
    const JointBodies ends = joints.bodies[row];
    if (is_awake_dynamic(data.bodies, ends.a) || is_awake_dynamic(data.bodies, ends.b))
      list.push_back(static_cast<std::int32_t>(row));
  }
  return list;
}

// Includes joints that broke and joints that calls have changed since.
void expect_list_of_definition(WorldData& data, Workers& workers) {
  Crew crew(workers);
  refresh_lists(data, crew);
  refresh_joints(data, crew);
  const std::vector<std::int32_t> wanted = joints_at_work(data);
  const Column<std::int32_t>& active = data.joints.active;
  ASSERT_TRUE(std::equal(active.begin(), active.end(), wanted.begin(), wanted.end()));
  for (const std::int32_t row : active) {
    const JointBodies ends = data.joints.bodies[static_cast<std::size_t>(row)];
    for (const std::int32_t body : {ends.a, ends.b}) {
      const auto index = static_cast<std::size_t>(body);
      if (data.bodies.type[index] != BodyType::fixed) continue;
      EXPECT_EQ(data.bodies.delta[index].position[0], 0.0f);
      EXPECT_EQ(data.bodies.delta[index].rotation[3], 1.0f);
      EXPECT_EQ(data.bodies.inertia[index].inverse_mass, 0.0f);
    }
  }
  for (std::size_t row = 0; row < data.joints.flags.size(); ++row) {
    if (std::binary_search(wanted.begin(), wanted.end(), static_cast<std::int32_t>(row))) continue;
    EXPECT_EQ(data.joints.reaction[row].force[1], 0.0f) << "of joint " << row << ", which does nothing";
  }
}

TEST(ActiveJoints, MatchTheirDefinitionUnderRandomCalls) {
  std::int64_t broken = 0;
  std::int32_t most_asleep = 0;
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    Workers workers(2);
    Chains chains(seed);
    for (int i = 0; i < 400; ++i) {
      for (int k = i % 5 == 0 ? 3 : 0; k > 0; --k) chains.change_something();
      step(chains.world, kDt, workers);
      broken += static_cast<std::int64_t>(chains.world.broken_joints().size());
      most_asleep = std::max(most_asleep, internals(chains.world).bodies.asleep);
      expect_list_of_definition(internals(chains.world), workers);
      if (HasFatalFailure()) FAIL() << "step " << i << " of seed " << seed;
    }
  }
  EXPECT_GT(broken, 20);
  EXPECT_GT(most_asleep, 50);
}

TEST(ActiveJoints, ARestoredWorldGoesOnWithTheSameBits) {
  Workers workers(1), others(3);
  Chains chains(5);
  Snapshot snapshot;
  World restored;
  for (int i = 0; i < 200; ++i) {
    for (int k = i % 3 == 0 ? 2 : 0; k > 0; --k) chains.change_something();
    save(chains.world, snapshot);
    restore(restored, snapshot);
    step(chains.world, kDt, workers);
    step(restored, kDt, others);
    ASSERT_EQ(chains.world.hash(), restored.hash()) << "step " << i;
    const Column<std::int32_t>&old = internals(chains.world).joints.active,
          &fresh = internals(restored).joints.active;
    ASSERT_TRUE(std::equal(old.begin(), old.end(), fresh.begin(), fresh.end())) << "step " << i;
  }
}

// Pairs of balls on a floor, each pair joined, and one single ball, all asleep.
struct Couples {
  World world;
  Workers workers{1};
  BodyId ball;
  std::vector<BodyId> first;

  explicit Couples(int couples) {
    WorldSettings settings;
    settings.sleep_time = 0.05f;
    world = World(settings);
    world.add_shape(world.create_body({.type = BodyType::fixed, .position = {0, -1, 0}}),
                    Box{{1000, 1, 1000}});
    for (int i = 0; i < couples; ++i) {
      const float x = 2.0f * static_cast<float>(i % 100), z = 2.0f * static_cast<float>(i / 100);
      first.push_back(add_ball({x, 0.3f, z}));
      const BodyId second = add_ball({x + 0.8f, 0.3f, z});
      world.create_joint({.body_a = first.back(),
                          .body_b = second,
                          .frame_a = {{0.4f, 0, 0}, {}},
                          .frame_b = {{-0.4f, 0, 0}, {}}},
                         BallJoint{});
    }
    ball = add_ball({-5, 0.3f, 0});
    rest();
  }
  BodyId add_ball(Vec3 at) {
    const BodyId body = world.create_body({.position = at});
    world.add_shape(body, Sphere{0.3f}, {.rolling_resistance = 0.1f});
    return body;
  }
  // Steps until all are asleep; returns the number of joints that the last step examined.
  std::int64_t rest() {
    for (int i = 0; i < 300; ++i) {
      const std::int64_t judged = judged_in_a_step();
      if (internals(world).bodies.awake.empty()) return judged;
    }
    ADD_FAILURE() << "they do not fall asleep";
    return -1;
  }
  std::int64_t judged_in_a_step() {
    step(world, kDt, workers);
    return islands_of(internals(world)).joints_judged;
  }
};

TEST(ActiveJoints, ABodyWithoutJointsExaminesNone) {
  Couples couples(2000);
  couples.world.set_linear_velocity(couples.ball, {0.5f, 0, 0});
  EXPECT_EQ(couples.judged_in_a_step(), 0);
  EXPECT_EQ(couples.rest(), 0) << "where it fell asleep";
  const BodyId guest = couples.add_ball({-10, 5, 0});
  EXPECT_EQ(couples.judged_in_a_step(), 0);
  couples.world.destroy_body(guest);
  EXPECT_EQ(couples.judged_in_a_step(), 0);
}

TEST(ActiveJoints, AChangedBodyExaminesItsOwnJointsOnly) {
  Couples couples(2000);
  couples.world.set_linear_velocity(couples.first[7], {0.1f, 0, 0});
  const std::int64_t judged = couples.judged_in_a_step();
  EXPECT_GE(judged, 1);
  EXPECT_LE(judged, 2) << "once when it woke, once when the other one followed";
  EXPECT_EQ(internals(couples.world).joints.active.size(), 1u);
  EXPECT_EQ(couples.judged_in_a_step(), 0) << "no body has changed";
  EXPECT_EQ(couples.rest(), 1) << "where both fell asleep";
  couples.world.destroy_body(couples.first[8]);
  EXPECT_EQ(couples.judged_in_a_step(), 1);
}

TEST(ActiveJoints, AJointWhoseMovingBodyBecomesFixedIsNoLongerActive) {
  Couples couples(2000);
  WorldData& data = internals(couples.world);
  const auto row = static_cast<std::size_t>(couples.first[7].index);
  couples.world.set_linear_velocity(couples.first[7], {1, 0, 0});
  couples.judged_in_a_step();
  ASSERT_NE(data.bodies.delta[row].position[0], 0.0f) << "its way in the last step";
  couples.world.set_body_type(couples.first[7], BodyType::fixed);
  EXPECT_LT(couples.judged_in_a_step(), 10) << "not all joints again";
  EXPECT_EQ(data.joints.active.size(), 1u);
  EXPECT_EQ(data.bodies.delta[row].position[0], 0.0f);
  EXPECT_EQ(data.bodies.inertia[row].inverse_mass, 0.0f);
}

}  // namespace
}  // namespace scree
