// What a distributed world refuses, alike on all ranks, which then go on.
#include <gtest/gtest.h>
#include <scree/distributed_world.h>
#include <scree/error.h>
#include <scree/recording.h>
#include <scree/step.h>
#include <tests/parallel/distributed/local_ranks.h>
#include <tests/physics/lab.h>
#include <tools/scenes/scene.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace scree {
namespace {

using distributed_tests::all_of;
using distributed_tests::run_ranks;
using physics::kStep;

// With the bodies of a scene.
struct FallingPile {
  World world;
  std::vector<BodyId> bodies;
};
FallingPile falling_pile() {
  const scenes::Scene scene = scenes::build("pile", {{"bodies", 240}}).front();
  FallingPile pile{World(scene.settings), {}};
  pile.bodies = scenes::populate(pile.world, scene);
  return pile;
}

TEST(DistributedRefusal, PartsOfItAreRefusedByCallsThatNeedTheWhole) {
  const auto errors = run_ranks(2, [&](int, Transport& transport) {
    Workers workers(1);
    DistributedWorld world(falling_pile().world, transport);
    world.step(kStep, workers);
    Snapshot snapshot, other;
    save(falling_pile().world, other);
    EXPECT_THROW(world.world().hash(), Error);
    EXPECT_THROW(save(world.world(), snapshot), Error);
    EXPECT_THROW(restore(world.world(), other), Error);
    EXPECT_THROW(clone(world.world()), Error);
    EXPECT_THROW(Recorder(world.world(), "/dev/null"), Error);
    world.step(kStep, workers);
  });
  EXPECT_EQ(all_of(errors), "");
}

TEST(DistributedRefusal, OptionsThatDifferAreRefusedByAllRanks) {
  const auto errors = run_ranks(2, [&](int rank, Transport& transport) {
    DistributedWorld world(falling_pile().world, transport, {.steps_per_look = rank == 0 ? 16 : 8});
  });
  for (const std::string& error : errors)
    EXPECT_EQ(error, "DistributedWorld: the option steps_per_look of rank 1 is not that of rank 0");
}

TEST(DistributedRefusal, WorldsThatDifferAreRefusedByAllRanks) {
  const auto errors = run_ranks(3, [&](int rank, Transport& transport) {
    FallingPile start = falling_pile();
    if (rank == 2) start.world.set_user_data(start.bodies.back(), 7);
    DistributedWorld world(std::move(start.world), transport);
  });
  for (const std::string& error : errors)
    EXPECT_EQ(error, "DistributedWorld: the world of rank 2 is not that of rank 0");
}

TEST(DistributedRefusal, RefusesBadOptions) {
  const auto refused = [](const DistributedOptions& options) {
    return run_ranks(1, [&](int, Transport& transport) {
      DistributedWorld world(falling_pile().world, transport, options);
    })[0];
  };
  EXPECT_NE(refused({.steps_per_look = -1}).find("steps_per_look is -1"), std::string::npos);
  EXPECT_NE(refused({.imbalance = 0.5f}).find("imbalance is 0.5"), std::string::npos);
  EXPECT_NE(refused({.imbalance = std::nanf("")}).find("at least 1"), std::string::npos);
  EXPECT_EQ(refused({.steps_per_look = 0}), "");
  EXPECT_THROW(LocalRanks(0), Error);
  EXPECT_THROW(LocalRanks(5000), Error);
}

TEST(DistributedRefusal, RefusesWhatIsNotSupported) {
  const auto refused = [](const std::function<void(World&)>& change) {
    return run_ranks(1, [&](int, Transport& transport) {
      World world = falling_pile().world;
      change(world);
      DistributedWorld distributed(std::move(world), transport);
    })[0];
  };
  const std::string far = refused([](World& world) { world.create_body({.position = {0, 20000, -3}}); });
  EXPECT_NE(far.find("16384 m"), std::string::npos) << far;
  EXPECT_NE(far.find("20000"), std::string::npos) << far;
}

// All ranks refuse alike, and go on when what they refuse is gone; nothing of it is recorded but the calls.
TEST(DistributedRefusal, GoesOnWhereABodyWasTooFarOut) {
  World one = falling_pile().world;
  Workers workers(1);
  const auto create_far = [](World& world) {
    const BodyId body = world.create_body({.position = {0, 0, -17000}});
    world.add_shape(body, Sphere{1});
    return body;
  };
  std::vector<std::uint64_t> expected;
  for (int i = 0; i < 20; ++i) {
    if (i == 5 || i == 12) one.destroy_body(create_far(one));
    step(one, kStep, workers);
    expected.push_back(one.hash());
  }
  const std::string file =
      (std::filesystem::temp_directory_path() / ("scree_far_" + std::to_string(getpid()) + ".scree"))
          .string();
  const auto errors = run_ranks(3, [&](int rank, Transport& transport) {
    DistributedWorld world(falling_pile().world, transport);
    Workers of_rank(1);
    world.record(file, of_rank);
    const auto expect_refused = [](auto&& call) {
      try {
        call();
        ADD_FAILURE() << "nothing was refused";
      } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("-17000"), std::string::npos) << error.what();
      }
    };
    std::uint32_t row = 0;
    for (int i = 0; i < 20; ++i) {
      BodyId far;
      if (i == 5) far = create_far(world.world());
      if (i == 5) row = far.index;  // which the next one has, too
      if (i == 12) {
        expect_refused([&] {
          world.give(
              [&](World& part) {
                if (rank == 1) create_far(part);
              },
              of_rank);
        });
        far = world.world().body_at(row);
      }
      if (i == 5 || i == 12) {
        expect_refused([&] { world.step(kStep, of_rank); });
        expect_refused([&] { world.hash(); });
        world.world().destroy_body(far);
      }
      world.step(kStep, of_rank);
      ASSERT_EQ(world.hash(), expected[static_cast<std::size_t>(i)]) << "step " << i;
    }
    world.finish_recording(of_rank);
  });
  EXPECT_EQ(all_of(errors), "");
  Player player(file);
  EXPECT_FALSE(player.verify(0, 20, workers));
  EXPECT_EQ(player.info().last_step, 20u);
  std::filesystem::remove(file);
}

// Fixed bodies may be anywhere.
TEST(DistributedRefusal, NoFixedBodyFarOutBecomesDynamic) {
  const auto errors = run_ranks(3, [&](int, Transport& transport) {
    DistributedWorld world(falling_pile().world, transport);
    Workers workers(1);
    world.step(kStep, workers);
    const BodyId body = world.world().create_body({.type = BodyType::fixed, .position = {0, 20000, 0}});
    world.world().add_shape(body, Box{});
    world.step(kStep, workers);
    world.world().set_body_type(body, BodyType::dynamic);
    EXPECT_THROW(world.step(kStep, workers), Error);
    world.world().set_body_type(body, BodyType::fixed);
    world.step(kStep, workers);
  });
  EXPECT_EQ(all_of(errors), "");
}

// Parts that follow the one with the far body are taken by all ranks, too.
TEST(DistributedRefusal, WhatIsGivenWithABodyTooFarOutIsOnAllRanks) {
  constexpr int kBodies = 60000;  // some MiB of calls, more than one part
  const auto create = [](World& world) {
    for (int i = 0; i < kBodies; ++i) {
      const float x = 3.0f * static_cast<float>(i % 300), z = 3.0f * static_cast<float>(i / 300);
      world.add_shape(world.create_body({.position = {x, i == 10 ? 20000.0f : 5.0f, z}}), Sphere{0.5f});
    }
  };
  World one{WorldSettings{}};
  create(one);
  one.destroy_body(one.body_at(static_cast<std::uint32_t>(one.poses().size()) - kBodies + 10));
  Workers workers(1);
  step(one, kStep, workers);
  const auto errors = run_ranks(3, [&](int rank, Transport& transport) {
    DistributedWorld world(World(WorldSettings{}), transport);
    Workers of_rank(1);
    EXPECT_THROW(world.give(
                     [&](World& part) {
                       if (rank == 1) create(part);
                     },
                     of_rank),
                 Error);
    EXPECT_EQ(world.world().body_count(), static_cast<std::size_t>(kBodies));
    EXPECT_THROW(world.hash(), Error);
    World& part = world.world();
    part.destroy_body(part.body_at(static_cast<std::uint32_t>(part.poses().size()) - kBodies + 10));
    world.step(kStep, of_rank);
    EXPECT_EQ(world.hash(), one.hash());
  });
  EXPECT_EQ(all_of(errors), "");
}

// What has flown far is no new body, though it is kinematic for a while. Files hold it, and any number of
// ranks goes on from them.
TEST(DistributedRefusal, BodiesMayMoveFar) {
  World one{WorldSettings{}};
  const auto create = [](World& world) {
    for (int i = 0; i < 6; ++i)
      world.add_shape(world.create_body({.position = {10.0f * static_cast<float>(i), 0, 16383},
                                         .linear_velocity = {0, 0, 300}}),
                      Sphere{0.5f});
  };
  create(one);
  const auto change = [](World& world, int i) {
    const BodyId body = world.body_at(static_cast<std::uint32_t>(world.poses().size()) - 3);
    if (i == 5) world.set_body_type(body, BodyType::kinematic);
    if (i == 8) world.set_body_type(body, BodyType::dynamic);
  };
  Workers workers(1);
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < 20; ++i) {
    change(one, i);
    step(one, kStep, workers);
    hashes.push_back(one.hash());
  }
  const std::string name =
      (std::filesystem::temp_directory_path() / ("scree_far_" + std::to_string(getpid()))).string();
  const std::string checkpoint = name + "_checkpoint", recording = name + "_recording";
  for (const int writers : {1, 2}) {
    auto errors = run_ranks(writers, [&](int, Transport& transport) {
      World whole{WorldSettings{}};
      create(whole);
      DistributedWorld world(std::move(whole), transport);
      Workers of_rank(1);
      world.record(recording, of_rank, {.keyframe_spacing = 10});
      for (int i = 0; i < 20; ++i) {
        if (i == 12) world.checkpoint(checkpoint, of_rank);
        change(world.world(), i);
        world.step(kStep, of_rank);
        ASSERT_EQ(world.hash(), hashes[static_cast<std::size_t>(i)]) << "step " << i;
      }
      world.finish_recording(of_rank);
    });
    EXPECT_EQ(all_of(errors), "");
    for (const int readers : {1, 3}) {
      errors = run_ranks(readers, [&](int, Transport& transport) {
        Workers of_rank(1);
        DistributedWorld world = read_checkpoint(checkpoint, transport, of_rank);
        for (std::size_t i = 12; i < 20; ++i) {
          world.step(kStep, of_rank);
          ASSERT_EQ(world.hash(), hashes[i]) << "step " << i;
        }
        DistributedWorld played = play_recording(recording, 10, 20, transport, of_rank);
        EXPECT_EQ(played.hash(), hashes.back());
      });
      EXPECT_EQ(all_of(errors), "") << writers << " writers, " << readers << " readers";
    }
  }
  std::filesystem::remove(checkpoint);
  std::filesystem::remove(recording);
}

// A recording of the name stays as it is.
TEST(DistributedRefusal, OfABodyTooFarOutComesBeforeAFileIsOpened) {
  const std::string file =
      (std::filesystem::temp_directory_path() / ("scree_kept_" + std::to_string(getpid()))).string();
  std::ofstream(file) << "kept";
  const auto errors = run_ranks(2, [&](int, Transport& transport) {
    DistributedWorld world(falling_pile().world, transport);
    Workers of_rank(1);
    world.world().create_body({.position = {0, 17000, 0}});
    EXPECT_THROW(world.record(file, of_rank), Error);
  });
  EXPECT_EQ(all_of(errors), "");
  EXPECT_EQ(std::filesystem::file_size(file), 4u);
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace scree
