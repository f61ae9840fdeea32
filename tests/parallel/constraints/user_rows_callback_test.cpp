// The callback of user joints: which joints it is asked for, what becomes of its numbers, and what happens
// when it gives unsound ones or throws.
#include <core/world/math.h>
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <tests/parallel/recording/recording_fixture.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace scree {
namespace {

using test::TemporaryFile;

constexpr float kStep = 1.0f / 60.0f;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Pendulums far apart: balls on rods of 1 m, whose row a callback makes.
struct Pendulums {
  explicit Pendulums(int count, const WorldSettings& settings = {.sleeping = false}) : world(settings) {
    for (int i = 0; i < count; ++i) {
      const Vec3 hook = hook_of(i);
      bodies.push_back(world.create_body({.position = {hook.x + 1, hook.y, hook.z}}));
      world.add_shape(bodies.back(), Sphere{0.1f});
      joints.push_back(world.create_joint(
          {.body_a = kWorld, .body_b = bodies.back(), .frame_a = {hook, {}}, .user_data = std::uint64_t(i)},
          UserJoint{}));
    }
  }
  static Vec3 hook_of(int number) { return {5.0f * static_cast<float>(number), 0, 0}; }

  static UserRow row_of(const World& of, JointId joint) {
    const JointDef def = of.joint_def(joint);
    const Vec3 out = of.pose(def.body_b).position - def.frame_a.position;
    const float distance = length(out);
    return {.jacobian = {.linear_b = (1 / distance) * out}, .target = {.error = distance - 1}};
  }
  static void put(const UserRowBatch& batch, std::size_t i, const UserRow& row) {
    batch.jacobians[kMaxUserRows * i] = row.jacobian;
    batch.targets[kMaxUserRows * i] = row.target;
    batch.bounds[kMaxUserRows * i] = row.bounds;
  }
  static void refresh(const UserRowBatch& batch) {
    for (std::size_t i = 0; i < batch.joints.size(); ++i) put(batch, i, row_of(batch.world, batch.joints[i]));
  }
  // Those of `spoilt` get what spoil() makes of their rows.
  template <class Spoil>
  static UserRowCallback spoiling(std::set<JointId> spoilt, Spoil spoil) {
    return [=](const UserRowBatch& batch) {
      for (std::size_t i = 0; i < batch.joints.size(); ++i) {
        UserRow row = row_of(batch.world, batch.joints[i]);
        if (spoilt.contains(batch.joints[i])) spoil(row);
        put(batch, i, row);
      }
    };
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) step(world, kStep, workers);
  }
  std::vector<std::byte> bytes() const {
    Snapshot snapshot;
    save(world, snapshot);
    return write_snapshot(snapshot);
  }
  float distance(int number) const {
    return length(world.pose(bodies[static_cast<std::size_t>(number)]).position - hook_of(number));
  }

  World world;
  Workers workers{1};
  std::vector<BodyId> bodies;
  std::vector<JointId> joints;
};

TEST(UserRowCallback, MakesTheMotionOfAllJoints) {
  Pendulums p(200);
  p.world.set_user_row_callback(Pendulums::refresh);
  p.run(120);
  for (int i = 0; i < 200; ++i) EXPECT_NEAR(p.distance(i), 1, 0.01) << i;
}

TEST(UserRowCallback, IsAskedOnceForEachEnabledAwakeJointInOrder) {
  for (const int threads : {1, 4}) {
    Pendulums p(1000);
    p.world.set_joint_enabled(p.joints[3], false);
    p.world.destroy_joint(p.joints[700]);
    Workers workers(threads);
    std::mutex mutex;
    std::vector<std::vector<JointId>> batches;
    p.world.set_user_row_callback([&](const UserRowBatch& batch) {
      const std::lock_guard lock(mutex);
      EXPECT_EQ(&batch.world, &p.world);
      EXPECT_EQ(batch.dt, kStep);
      EXPECT_EQ(batch.jacobians.size(), kMaxUserRows * batch.joints.size());
      EXPECT_EQ(batch.targets.size(), kMaxUserRows * batch.joints.size());
      EXPECT_EQ(batch.bounds.size(), kMaxUserRows * batch.joints.size());
      batches.emplace_back(batch.joints.begin(), batch.joints.end());
    });
    step(p.world, kStep, workers);
    std::sort(batches.begin(), batches.end());
    std::vector<JointId> asked;
    for (const auto& batch : batches) asked.insert(asked.end(), batch.begin(), batch.end());
    std::vector<JointId> expected = p.joints;
    expected.erase(expected.begin() + 700);
    expected.erase(expected.begin() + 3);
    EXPECT_EQ(asked, expected) << threads;
  }
}

TEST(UserRowCallback, GetsThePresentNumbers) {
  Pendulums p(3);
  const UserRow row{.jacobian = {.linear_b = {1, 2, 3}}, .target = {.speed = 4}, .bounds = {-5, 6}};
  p.world.set_user_rows(p.joints[1], {&row, 1});
  p.world.set_user_row_callback([&](const UserRowBatch& batch) {
    ASSERT_EQ(batch.joints.size(), 3u);
    EXPECT_EQ(batch.jacobians[kMaxUserRows], row.jacobian);
    EXPECT_EQ(batch.targets[kMaxUserRows], row.target);
    EXPECT_EQ(batch.bounds[kMaxUserRows], row.bounds);
    EXPECT_EQ(batch.jacobians[0], RowJacobian{});
  });
  p.run(1);
}

TEST(UserRowCallback, GivesTheSameBitsForEveryThreadCountAndInstructionSet) {
  const auto run = [](int threads, Isa isa) {
    Pendulums p(500);
    Workers workers(WorkersOptions{.threads = threads, .isa = isa});
    p.world.set_user_row_callback(Pendulums::refresh);
    for (int i = 0; i < 60; ++i) step(p.world, kStep, workers);
    return p.bytes();
  };
  const std::vector<std::byte> expected = run(1, Isa::scalar);
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    for (const int threads : {1, 3}) EXPECT_TRUE(run(threads, isa) == expected) << threads;
  }
}

TEST(UserRowCallback, ThatThrowsLeavesTheWorldAsItWasAndItsExceptionArrives) {
  for (const int threads : {1, 4}) {
    Pendulums p(500);
    Workers workers(threads);
    p.world.set_user_row_callback(Pendulums::refresh);
    for (int i = 0; i < 10; ++i) step(p.world, kStep, workers);
    const std::vector<std::byte> before = p.bytes();
    const std::uint64_t hash = p.world.hash(), steps = p.world.stats().step;
    p.world.set_user_row_callback([&](const UserRowBatch& batch) {
      for (RowJacobian& jacobian : batch.jacobians) jacobian.linear_b = {kNan, 7, 7};
      for (const JointId joint : batch.joints) {
        if (joint == p.joints[100] || joint == p.joints[400])
          throw std::runtime_error(joint == p.joints[100] ? "the first" : "another");
      }
    });
    try {
      step(p.world, kStep, workers);
      ADD_FAILURE() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "the first");
    }
    EXPECT_EQ(p.world.hash(), hash);
    EXPECT_EQ(p.world.stats().step, steps);
    EXPECT_TRUE(p.bytes() == before);
    // It goes on as if nothing had happened.
    Pendulums other(500);
    other.world.set_user_row_callback(Pendulums::refresh);
    p.world.set_user_row_callback(Pendulums::refresh);
    step(p.world, kStep, workers);
    other.run(11);
    EXPECT_EQ(p.world.hash(), other.world.hash());
  }
}

using Spoil = void (*)(UserRow& row);
constexpr std::pair<const char*, Spoil> kUnsound[] = {
    {"a NaN in the Jacobian", [](UserRow& row) { row.jacobian.angular_a.y = kNan; }},
    {"an infinite number", [](UserRow& row) { row.jacobian.linear_b.x = kInfinity; }},
    {"a large number", [](UserRow& row) { row.jacobian.linear_b.x = 1e30f; }},
    {"an error that is NaN", [](UserRow& row) { row.target.error = kNan; }},
    {"an infinite speed", [](UserRow& row) { row.target.speed = -kInfinity; }},
    {"hertz of 0", [](UserRow& row) { row.target.hertz = 0; }},
    {"negative damping", [](UserRow& row) { row.target.damping_ratio = -1; }},
    {"bounds in the wrong order",
     [](UserRow& row) {
       row.bounds = {2, 1};
     }},
    {"a bound that is NaN", [](UserRow& row) { row.bounds.upper = kNan; }},
    {"an infinite force",
     [](UserRow& row) {
       row.bounds = {kInfinity, kInfinity};
     }},
};

TEST(UserRowCallback, UnsoundNumbersFreezeTheirJointWithOneEventAndNothingElse) {
  for (const auto& [what, spoil] : kUnsound) {
    SCOPED_TRACE(what);
    Pendulums p(100), sound(100);
    p.world.set_user_row_callback(Pendulums::refresh);
    sound.world.set_user_row_callback(Pendulums::refresh);
    p.run(30);
    sound.run(30);
    std::vector<UserRow> before(1), after(1);
    p.world.user_rows(p.joints[70], before);
    p.world.set_user_row_callback(Pendulums::spoiling({p.joints[70]}, spoil));
    p.run(1);
    sound.run(1);
    ASSERT_EQ(p.world.frozen_joints().size(), 1u);
    EXPECT_EQ(p.world.frozen_joints()[0], p.joints[70]);
    EXPECT_TRUE(p.world.is_frozen(p.joints[70]));
    EXPECT_FALSE(p.world.is_frozen(p.joints[69]));
    p.world.user_rows(p.joints[70], after);
    EXPECT_EQ(after, before);  // the last sound ones
    const float speed = p.world.linear_velocity(p.bodies[70]).y;
    p.run(29);
    sound.run(29);
    EXPECT_TRUE(p.world.frozen_joints().empty());
    EXPECT_NEAR(p.world.linear_velocity(p.bodies[70]).y, speed - 29 * 9.81f * kStep, 1e-3);  // it falls
    for (std::size_t i = 0; i < 100; ++i) {
      if (i == 70) continue;
      EXPECT_EQ(p.world.pose(p.bodies[i]), sound.world.pose(sound.bodies[i])) << i;
    }
    p.world.set_user_row_callback(Pendulums::refresh);
    p.run(1);
    EXPECT_FALSE(p.world.is_frozen(p.joints[70]));
  }
}

TEST(UserRowCallback, AFrozenJointActsAgainAfterNumbersFromACall) {
  Pendulums p(1);
  const UserRow hold{.jacobian = {.linear_b = {0, 1, 0}}};
  UserRow bad = hold;
  bad.target.error = kNan;
  p.world.refresh_user_rows(p.joints, {&bad, 1});
  EXPECT_TRUE(p.world.is_frozen(p.joints[0]));
  p.world.set_user_rows(p.joints[0], {&hold, 1});
  EXPECT_FALSE(p.world.is_frozen(p.joints[0]));
  p.run(30);
  EXPECT_NEAR(p.world.pose(p.bodies[0]).position.y, 0, 2e-3);  // not 1.2 m below
}

TEST(UserRowCallback, IsNotAskedByAStepOfNoLength) {
  Pendulums p(3);
  int asked = 0;
  p.world.set_user_row_callback([&](const UserRowBatch&) { ++asked; });
  step(p.world, 0, p.workers);
  EXPECT_EQ(asked, 0);
  step(p.world, kStep, p.workers);
  EXPECT_EQ(asked, 1);
}

TEST(UserRowCallback, IsAskedByStepsOfManyWorlds) {
  std::vector<std::unique_ptr<Pendulums>> many;
  std::vector<World*> worlds;
  std::vector<int> asked(8);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    many.push_back(std::make_unique<Pendulums>(3));
    worlds.push_back(&many.back()->world);
    many.back()->world.set_user_row_callback([&asked, i](const UserRowBatch& batch) {
      ++asked[i];
      Pendulums::refresh(batch);
    });
  }
  Workers workers(2);
  for (int i = 0; i < 60; ++i) step(worlds, kStep, workers);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    EXPECT_EQ(asked[i], 60);
    EXPECT_NEAR(many[i]->distance(1), 1, 0.01);
  }
}

TEST(UserRowCallback, ThatThrowsKeepsNoOtherWorldFromItsStep) {
  for (const int threads : {1, 2, 6}) {  // more worlds than threads, and fewer
    std::vector<std::unique_ptr<Pendulums>> many;
    std::vector<World*> worlds;
    for (std::size_t i = 0; i < 4; ++i) {
      many.push_back(std::make_unique<Pendulums>(3));
      worlds.push_back(&many.back()->world);
      many.back()->world.set_user_row_callback([i](const UserRowBatch&) {
        if (i == 1 || i == 3) throw std::runtime_error(std::to_string(i));
      });
    }
    Workers workers(threads);
    try {
      step(worlds, kStep, workers);
      ADD_FAILURE() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "1");
    }
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(worlds[i]->stats().step, i % 2 == 0 ? 1u : 0u);
  }
}

// --- sleep and islands ---

TEST(UserRowCallback, LeavesJointsOfSleepingBodiesUntilACallWakesThem) {
  Pendulums p(2, {.sleep_time = 0.1f});
  const UserRow hold{.jacobian = {.linear_b = {0, 1, 0}}};
  for (const JointId joint : p.joints) p.world.set_user_rows(joint, {&hold, 1});
  std::vector<JointId> asked;
  p.world.set_user_row_callback(
      [&](const UserRowBatch& batch) { asked.assign(batch.joints.begin(), batch.joints.end()); });
  p.run(60);
  asked.clear();
  p.run(1);
  EXPECT_FALSE(p.world.is_awake(p.bodies[0]));
  EXPECT_TRUE(asked.empty());
  p.world.set_user_rows(p.joints[0], {&hold, 1});  // nothing new
  EXPECT_FALSE(p.world.is_awake(p.bodies[0]));
  UserRow lift = hold;
  lift.target.speed = 1;
  p.world.set_user_rows(p.joints[0], {&lift, 1});
  EXPECT_TRUE(p.world.is_awake(p.bodies[0]));
  EXPECT_FALSE(p.world.is_awake(p.bodies[1]));
  p.run(1);
  EXPECT_EQ(asked, std::vector<JointId>{p.joints[0]});
  p.world.refresh_user_rows({&p.joints[1], 1}, {&lift, 1});
  EXPECT_TRUE(p.world.is_awake(p.bodies[1]));
}

TEST(UserRowCallback, BodiesThatRowsTieSleepAndWakeTogether) {
  World world({.gravity = {0, 0, 0}, .sleep_time = 0.1f});
  Workers one(1);
  std::vector<BodyId> bodies;
  for (int i = 0; i < 3; ++i) {
    bodies.push_back(world.create_body({.position = {3.0f * static_cast<float>(i), 0, 0}}));
    world.add_shape(bodies.back(), Sphere{0.5f});
  }
  const UserRow apart{.jacobian = {.linear_a = {-1, 0, 0}, .linear_b = {1, 0, 0}}};
  for (std::size_t i = 0; i < 2; ++i) {
    const JointId joint =
        world.create_joint({.body_a = bodies[i], .body_b = bodies[i + 1]}, UserJoint{{RowKind::held}});
    world.set_user_rows(joint, {&apart, 1});
  }
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) step(world, kStep, one);
  };
  run(30);
  for (const BodyId body : bodies) EXPECT_FALSE(world.is_awake(body));
  world.set_linear_velocity(bodies[0], {1, 0, 0});
  run(2);
  for (const BodyId body : bodies) {
    EXPECT_TRUE(world.is_awake(body));
    EXPECT_NEAR(world.linear_velocity(body).x, 1.0f / 3.0f, 1e-3);
  }
}

// --- snapshots and recordings ---

TEST(UserRowCallback, StaysInARestoreAndIsNotInASnapshot) {
  Pendulums p(5);
  p.world.set_user_row_callback(Pendulums::refresh);
  p.run(10);
  Snapshot snapshot;
  save(p.world, snapshot);
  p.run(20);
  const std::uint64_t hash = p.world.hash();
  restore(p.world, snapshot);
  EXPECT_TRUE(p.world.has_user_row_callback());
  p.run(20);
  EXPECT_EQ(p.world.hash(), hash);
  World other;
  restore(other, snapshot);
  EXPECT_FALSE(other.has_user_row_callback());
  EXPECT_FALSE(clone(p.world).has_user_row_callback());
  // Joints go on with the numbers that they have, and from the moment at which the callback is back as
  // before.
  other.set_user_row_callback(Pendulums::refresh);
  for (int i = 0; i < 20; ++i) step(other, kStep, p.workers);
  EXPECT_EQ(other.hash(), hash);
}

TEST(UserRowCallback, NumbersAreInSnapshots) {
  Pendulums p(5);
  p.world.set_user_row_callback(Pendulums::refresh);
  p.run(10);
  p.world.set_user_row_callback({});
  UserRow bad;
  bad.target.error = kNan;
  p.world.refresh_user_rows({&p.joints[2], 1}, {&bad, 1});
  const std::vector<std::byte> before = p.bytes();
  World copy;
  copy.share_handles(p.world);
  restore(copy, read_snapshot(before));
  for (const JointId joint : p.joints) {
    UserRow expected, row;
    p.world.user_rows(joint, {&expected, 1});
    copy.user_rows(joint, {&row, 1});
    EXPECT_EQ(row, expected);
    EXPECT_EQ(copy.is_frozen(joint), p.world.is_frozen(joint));
  }
  step(copy, kStep, p.workers);
  p.run(1);
  EXPECT_EQ(copy.hash(), p.world.hash());
  ASSERT_EQ(copy.frozen_joints().size(), 1u);  // the event had not come before
  EXPECT_EQ(copy.frozen_joints()[0], p.joints[2]);
}

TEST(UserRowCallback, IsNotNeededToPlayARecording) {
  const TemporaryFile file;
  Pendulums p(100);
  p.world.set_user_row_callback(Pendulums::refresh);
  p.run(5);
  Recorder recorder(p.world, file.path(), {.keyframe_spacing = 10});
  p.run(15);
  p.world.set_user_row_callback(Pendulums::spoiling({p.joints[7]}, [](UserRow& row) {
    row.bounds = {1, 0};
  }));
  p.run(15);
  p.world.destroy_body(p.bodies[20]);
  p.world.set_user_row_callback(Pendulums::refresh);
  p.run(15);
  recorder.finish();
  for (const int threads : {1, 3}) {
    Player player(file.path());
    Workers workers(threads);
    const auto found = player.verify(player.info().first_step, player.info().last_step, workers);
    EXPECT_FALSE(found.has_value()) << found->difference;
    player.seek(21, workers);
    EXPECT_TRUE(player.world().is_frozen({p.joints[7].index, p.joints[7].generation}));
    player.seek(50, workers);
    EXPECT_EQ(player.world().hash(), p.world.hash());
    EXPECT_FALSE(player.world().has_user_row_callback());
  }
}

TEST(UserRowCallback, OnlyNumbersThatChangeAreRecorded) {
  const auto bytes_of = [](bool changes) {
    const TemporaryFile file;
    Pendulums p(50, {.gravity = {0, 0, 0}, .sleeping = false});
    p.world.set_user_row_callback([changes](const UserRowBatch& batch) {
      for (RowTarget& target : batch.targets) target.speed = changes ? target.speed + 1e-3f : 0.5f;
    });
    p.run(1);
    Recorder recorder(p.world, file.path());
    p.run(100);
    recorder.finish();
    Player player(file.path());
    return player.info().calls;
  };
  EXPECT_EQ(bytes_of(false), 0u);
  EXPECT_EQ(bytes_of(true), 100u);
}

}  // namespace
}  // namespace scree
