// Laws of recordings by many ranks: a single process plays and verifies them.
#include <gtest/gtest.h>
#include <scree/distributed_world.h>
#include <scree/error.h>
#include <scree/recording.h>
#include <scree/step.h>
#include <tests/parallel/distributed/eventful_pile.h>
#include <tests/parallel/distributed/local_ranks.h>
#include <tests/physics/lab.h>
#include <tools/scenes/scene.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace scree {
namespace {

using distributed_tests::all_of;
using distributed_tests::run_ranks;
using physics::kStep;

std::string file_name(const std::string& name) {
  // Tests may run beside one another, in processes of their own.
  const std::string own = "scree_ranks_" + std::to_string(getpid()) + "_" + name + ".scree";
  return (std::filesystem::temp_directory_path() / own).string();
}

// Falls, sleeps and wakes, with a hinge and a sensor, and events of all kinds.
World make_world(std::vector<BodyId>& bodies) {
  distributed_tests::EventfulPile pile = distributed_tests::make_eventful_pile(90);
  bodies = pile.bodies;
  pile.world.create_joint({.body_a = bodies[bodies.size() - 1], .body_b = bodies[bodies.size() - 2]},
                          HingeJoint{});
  return std::move(pile.world);
}

void act(World& world, const std::vector<BodyId>& bodies, int step) {
  if (step == 40) world.set_linear_velocity(bodies.back(), {2, 6, 1});
  if (step == 55) world.destroy_body(bodies[bodies.size() / 2]);
  if (step == 70)
    world.add_shape(world.create_body({.position = {0.2f, 9, 0.1f}}), Sphere{0.4f}, {.density = 4000});
  if (step == 350) world.set_linear_velocity(bodies[bodies.size() - 4], {1, 5, 0});
}

void record_alone(const std::string& file, int steps, const RecorderOptions& options) {
  std::vector<BodyId> bodies;
  World world = make_world(bodies);
  Recorder recorder(world, file, options);
  Workers workers(1);
  for (int i = 0; i < steps; ++i) {
    act(world, bodies, i);
    step(world, kStep, workers);
  }
  recorder.finish();
}

void record_on_ranks(const std::string& file, int ranks, int steps, const RecorderOptions& options) {
  const auto errors = run_ranks(ranks, [&](int rank, Transport& transport) {
    std::vector<BodyId> bodies;
    World whole = make_world(bodies);
    DistributedWorld world(std::move(whole), transport, {.steps_per_look = 7, .imbalance = 1.0f});
    Workers workers(1);
    world.record(file, workers, options);
    EXPECT_EQ(world.recorder() != nullptr, rank == 0);
    for (int i = 0; i < steps; ++i) {
      act(world.world(), bodies, i);
      world.step(kStep, workers);
    }
    world.finish_recording(workers);
  });
  EXPECT_EQ(all_of(errors), "");
}

// Whole states at keyframes included, but for the order of contacts.
TEST(DistributedRecording, ASingleProcessVerifiesIt) {
  constexpr int kSteps = 420;
  const RecorderOptions options{.keyframe_spacing = 60};
  const std::string alone = file_name("alone"), together = file_name("together");
  record_alone(alone, kSteps, options);
  for (const int ranks : {1, 4}) {
    record_on_ranks(together, ranks, kSteps, options);
    Player player(together);
    EXPECT_EQ(player.info().last_step, static_cast<std::uint64_t>(kSteps));
    EXPECT_EQ(player.info().keyframes, 8u);
    EXPECT_TRUE(player.info().finished);
    Workers workers(1);
    for (const std::uint64_t from : {0u, 60u, 240u, 360u}) {
      const auto found = player.verify(from, kSteps, workers);
      EXPECT_FALSE(found) << ranks << " ranks, from " << from << ": " << found->step << " "
                          << found->difference;
    }
    Player single(alone);
    const auto found = compare(single, player, workers);
    EXPECT_FALSE(found) << ranks << " ranks: " << found->step << " " << found->difference;
  }
  std::remove(alone.c_str());
  std::remove(together.c_str());
}

// Each rank reads its share of a keyframe, whatever number of ranks wrote it.
TEST(DistributedRecording, AnyNumberOfRanksPlaysIt) {
  constexpr int kSteps = 130, kMore = 20;
  const std::string alone = file_name("for_all"), together = file_name("by_four");
  record_alone(alone, kSteps, {.keyframe_spacing = 50});
  record_on_ranks(together, 4, kSteps, {.keyframe_spacing = 50});
  Workers workers(1);
  Player player(alone);
  player.seek(kSteps, workers);
  World after = player.branch();
  std::vector<std::uint64_t> future{after.hash()};
  for (int i = 0; i < kMore; ++i) {
    step(after, kStep, workers);
    future.push_back(after.hash());
  }
  for (const std::string& file : {together, alone}) {
    for (const int ranks : {1, 3, 4, 6}) {
      for (const std::uint64_t from : {0u, 77u, 130u}) {
        const auto errors = run_ranks(ranks, [&](int, Transport& transport) {
          Workers own_workers(1);
          DistributedWorld world = play_recording(file, from, kSteps, transport, own_workers);
          ASSERT_EQ(world.hash(), future[0]) << ranks << " ranks, from " << from;
          for (int i = 1; i <= kMore; ++i) {
            world.step(kStep, own_workers);
            ASSERT_EQ(world.hash(), future[static_cast<std::size_t>(i)]) << ranks << " ranks, step " << i;
          }
        });
        EXPECT_EQ(all_of(errors), "");
      }
    }
  }
  std::remove(alone.c_str());
  std::remove(together.c_str());
}

TEST(DistributedRecording, WhatCannotBePlayedIsRefusedByAllRanks) {
  const std::string file = file_name("refused"), other = file_name("refused_other");
  record_on_ranks(file, 3, 20, {.keyframe_spacing = 8});
  record_on_ranks(other, 2, 21, {.keyframe_spacing = 8});
  const auto told_by_all = [&](const std::string& file_of_last, std::uint64_t from, std::uint64_t to,
                               std::uint64_t to_of_last) {
    const auto errors = run_ranks(3, [&](int rank, Transport& transport) {
      Workers workers(1);
      const bool is_last = rank == 2;
      play_recording(is_last ? file_of_last : file, from, is_last ? to_of_last : to, transport, workers);
    });
    // But for the name of the file, which is each rank's own.
    const auto reason = [](const std::string& told) { return told.substr(told.rfind(": ") + 1); };
    EXPECT_EQ(reason(errors[0]), reason(errors[1]));
    EXPECT_EQ(reason(errors[0]), reason(errors[2]));
    return errors[0];
  };
  const auto expect_told = [](const std::string& told, const std::string& reason) {
    EXPECT_NE(told.find(reason), std::string::npos) << told;
  };
  expect_told(told_by_all(file, 0, 21, 21), "step is 21, must lie in [0, 20]");
  expect_told(told_by_all(file, 9, 8, 8), "step 9 comes after step 8");
  expect_told(told_by_all("/no/such/file", 0, 20, 20), "rank 2: Player: /no/such/file: cannot be read");
  expect_told(told_by_all(other, 16, 20, 20), "ranks play other recordings, or other steps");
  expect_told(told_by_all(other, 0, 20, 20), "ranks play other recordings, or other steps");
  expect_told(told_by_all(file, 16, 20, 19), "ranks play other recordings, or other steps");
  std::string bytes;
  {
    std::ifstream in(file, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
  }
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  std::ofstream(other, std::ios::binary) << bytes;
  const auto errors = run_ranks(2, [&](int, Transport& transport) {
    Workers workers(1);
    play_recording(other, 0, 20, transport, workers);
  });
  EXPECT_EQ(errors[0], errors[1]);
  EXPECT_NE(errors[0].find(other), std::string::npos) << errors[0];
  std::remove(file.c_str());
  std::remove(other.c_str());
}

// A hook that throws on one rank keeps none from going on, in a step with a keyframe, too: all go on as one
// process does in which it throws.
TEST(DistributedRecording, GoesOnWhereAHookThrows) {
  const std::string file = file_name("throws");
  constexpr int kSteps = 140;
  const auto make = [] {
    scenes::Scene scene = scenes::build("pile", {{"bodies", 60}}).front();
    for (scenes::SceneShape& shape : scene.shapes) shape.options.contact_hooks = ContactHooks::all;
    World world(scene.settings);
    scenes::populate(world, scene);
    return world;
  };
  const auto set_hooks = [](World& world, const int& taken, bool throws) {
    world.set_contact_filter([&taken, throws](const ContactFilterBatch& batch) {
      for (std::size_t i = 0; i < batch.pairs.size(); ++i)
        batch.collide[i] = batch.pairs[i].shape_b.index % 9 != 0 ? 1 : 0;
      if (throws && taken >= 119 && taken % 2 == 1) throw std::runtime_error("a filter that fails");
    });
    world.set_contact_rule([&taken, throws](const ContactRuleBatch& batch) {
      for (ContactRules& rules : batch.rules) rules.friction = 0.05f;
      if (throws && taken >= 119 && taken % 3 == 0) throw std::runtime_error("a rule that fails");
    });
  };
  const auto step_on = [](auto&& take_step) {
    try {
      take_step();
    } catch (const std::runtime_error& error) {
      return std::string(error.what()).find("that fails") != std::string::npos ? 1 : 1000;
    }
    return 0;
  };
  World one = make();
  Workers workers(1);
  int steps_taken = 0;
  set_hooks(one, steps_taken, true);
  std::vector<std::uint64_t> hashes;
  for (; steps_taken < kSteps; ++steps_taken) {
    step_on([&] { step(one, kStep, workers); });
    hashes.push_back(one.hash());
  }
  const auto errors = run_ranks(3, [&](int rank, Transport& transport) {
    DistributedWorld world(make(), transport);
    int taken = 0, thrown = 0;
    set_hooks(world.world(), taken, rank == 1);
    Workers of_rank(1);
    world.record(file, of_rank, {.keyframe_spacing = 20});
    for (; taken < kSteps; ++taken) {
      thrown += step_on([&] { world.step(kStep, of_rank); });
      ASSERT_EQ(world.hash(), hashes[static_cast<std::size_t>(taken)]) << "step " << taken;
    }
    EXPECT_EQ(thrown > 0, rank == 1);
    EXPECT_LT(thrown, 1000);
    world.finish_recording(of_rank);
  });
  EXPECT_EQ(all_of(errors), "");
  Player player(file);
  EXPECT_EQ(player.info().keyframes, 8u);
  const auto found = player.verify(0, kSteps, workers);
  EXPECT_FALSE(found) << found->step << " " << found->difference;
  std::remove(file.c_str());
}

// Of a recording that begins in the middle, and of one that goes on from a checkpoint of many ranks.
TEST(DistributedRecording, ComparesWithThatOfASingleProcess) {
  const std::string alone = file_name("alone"), together = file_name("middle"),
                    resumed = file_name("resumed");
  const std::string checkpoint = file_name("checkpoint");
  constexpr int kBefore = 90, kSteps = 60;
  std::vector<BodyId> bodies;
  World one = make_world(bodies);
  Workers workers(1);
  for (int i = 0; i < kBefore; ++i) step(one, kStep, workers);
  const auto record_one = [&](World& world, const std::string& file) {
    Recorder recorder(world, file, {.keyframe_spacing = 20});
    for (int i = 0; i < kSteps; ++i) step(world, kStep, workers);
    recorder.finish();
  };
  record_one(one, alone);
  const auto errors = run_ranks(3, [&](int, Transport& transport) {
    std::vector<BodyId> all;
    DistributedWorld world(make_world(all), transport, {.steps_per_look = 7, .imbalance = 1.0f});
    Workers of_rank(1);
    for (int i = 0; i < kBefore; ++i) world.step(kStep, of_rank);
    world.checkpoint(checkpoint, of_rank);
    world.record(together, of_rank, {.keyframe_spacing = 20});
    for (int i = 0; i < kSteps; ++i) world.step(kStep, of_rank);
    world.finish_recording(of_rank);
  });
  EXPECT_EQ(all_of(errors), "");
  World read = read_checkpoint(checkpoint);
  record_one(read, resumed);
  for (const std::string& other : {together, resumed}) {
    Player left(alone), right(other);
    const auto found = compare(left, right, workers);
    EXPECT_FALSE(found) << other << ": " << found->step << " " << found->difference;
  }
  for (const std::string& file : {alone, together, resumed, checkpoint}) std::remove(file.c_str());
}

// Answers of hooks come from all ranks.
TEST(DistributedRecording, HoldsWhatHooksOfAllRanksAnswer) {
  const std::string file = file_name("hooks");
  constexpr int kSteps = 90;
  const auto errors = run_ranks(3, [&](int, Transport& transport) {
    scenes::Scene scene = scenes::build("pile", {{"bodies", 80}}).front();
    for (scenes::SceneShape& shape : scene.shapes) shape.options.contact_hooks = ContactHooks::all;
    World whole(scene.settings);
    scenes::populate(whole, scene);
    DistributedWorld world(std::move(whole), transport, {.steps_per_look = 8});
    world.world().set_contact_filter([](const ContactFilterBatch& batch) {
      for (std::size_t i = 0; i < batch.pairs.size(); ++i)
        batch.collide[i] = (batch.pairs[i].shape_a.index + batch.pairs[i].shape_b.index) % 11 != 0 ? 1 : 0;
    });
    world.world().set_contact_rule([](const ContactRuleBatch& batch) {
      for (std::size_t i = 0; i < batch.pairs.size(); ++i)
        batch.rules[i].friction = 0.1f * static_cast<float>(batch.pairs[i].shape_b.index % 7);
    });
    Workers workers(1);
    world.record(file, workers, {.keyframe_spacing = 20});
    for (int i = 0; i < kSteps; ++i) world.step(kStep, workers);
    world.finish_recording(workers);
  });
  EXPECT_EQ(all_of(errors), "");
  Player player(file);
  EXPECT_GT(player.info().calls, 50u);
  Workers workers(1);
  const auto found = player.verify(0, kSteps, workers);
  EXPECT_FALSE(found) << found->step << " " << found->difference;
  std::remove(file.c_str());
}

// Rods between balls, whose numbers a callback makes; from step 40 on, those of some are none.
World make_rods(std::vector<JointId>& rods) {
  World world(WorldSettings{});
  world.add_shape(world.create_body({.type = BodyType::fixed}), HalfSpace{});
  BodyId last = kWorld;
  for (int i = 0; i < 24; ++i) {
    const BodyId ball =
        world.create_body({.position = {static_cast<float>(i % 12), 2.0f + static_cast<float>(i / 12), 0}});
    world.add_shape(ball, Sphere{0.2f});
    if (i % 12 != 0) rods.push_back(world.create_joint({.body_a = last, .body_b = ball}, UserJoint{}));
    last = ball;
  }
  return world;
}

UserRowCallback make_rod_numbers(const int& steps_taken) {
  return [&steps_taken](const UserRowBatch& batch) {
    for (std::size_t i = 0; i < batch.joints.size(); ++i) {
      const JointDef def = batch.world.joint_def(batch.joints[i]);
      const Vec3 out = batch.world.pose(def.body_b).position - batch.world.pose(def.body_a).position;
      const float distance = std::sqrt(out.x * out.x + out.y * out.y + out.z * out.z);
      const Vec3 along = (1.0f / distance) * out;
      const bool spoilt = steps_taken >= 40 && batch.joints[i].index % 5 == 2;
      batch.jacobians[kMaxUserRows * i] = {.linear_a = -along, .linear_b = along};
      batch.targets[kMaxUserRows * i] = {.error = spoilt ? std::nanf("") : distance - 1.0f};
    }
  };
}

TEST(DistributedRecording, HoldsWhatCallbacksOfAllRanksWrite) {
  const std::string file = file_name("rods");
  constexpr int kSteps = 300;
  std::vector<JointId> rods;
  World one = make_rods(rods);
  Workers workers(1);
  int steps_taken = 0;
  one.set_user_row_callback(make_rod_numbers(steps_taken));
  std::vector<std::uint64_t> hashes;
  for (; steps_taken < kSteps; ++steps_taken) {
    step(one, kStep, workers);
    hashes.push_back(one.hash());
  }
  EXPECT_EQ(one.stats().awake_bodies, 0);  // in the end all sleep
  const auto errors = run_ranks(4, [&](int, Transport& transport) {
    std::vector<JointId> joints;
    int taken = 0;
    DistributedWorld world(make_rods(joints), transport, {.steps_per_look = 7, .imbalance = 1.0f});
    world.world().set_user_row_callback(make_rod_numbers(taken));
    Workers of_rank(1);
    world.record(file, of_rank, {.keyframe_spacing = 50});
    for (; taken < kSteps; ++taken) {
      world.step(kStep, of_rank);
      ASSERT_EQ(world.hash(), hashes[static_cast<std::size_t>(taken)]) << "step " << taken;
    }
    world.finish_recording(of_rank);
    for (std::size_t i = 0; i < rods.size(); ++i)
      EXPECT_EQ(world.world().is_frozen(joints[i]), one.is_frozen(rods[i]));
  });
  EXPECT_EQ(all_of(errors), "");
  Player player(file);
  const auto found = player.verify(0, kSteps, workers);
  EXPECT_FALSE(found) << found->step << " " << found->difference;
  std::remove(file.c_str());
}

}  // namespace
}  // namespace scree
