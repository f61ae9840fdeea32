// Laws of DistributedWorld::give: what each rank creates for all has the bits of one process.
#include <gtest/gtest.h>
#include <scree/distributed_world.h>
#include <scree/error.h>
#include <scree/step.h>
#include <sys/resource.h>
#include <tests/parallel/distributed/absent_rows.h>
#include <tests/parallel/distributed/local_ranks.h>
#include <tests/physics/lab.h>
#include <tools/scenes/scene.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace scree {
namespace {

using distributed_tests::all_of;
using distributed_tests::run_ranks;
using physics::kStep;

// What each of several parts creates and changes, and how it joins what the one before has.
void fill_part(World& world, int part, int parts, int round) {
  const float x = 6.0f * static_cast<float>(part) / static_cast<float>(parts) - 3.0f;
  const std::vector<Vec3> corners = {
      {0.3f, 0, 0}, {-0.3f, 0, 0.1f}, {0, 0.4f, 0}, {0, 0, 0.35f}, {0, -0.2f, 0}};
  const Hull hull(corners);
  BodyId before = world.body_at(static_cast<std::uint32_t>(world.poses().size()) - 1);
  for (int i = 0; i < 12; ++i) {
    const BodyId body = world.create_body(
        {.position = {x + 0.1f * static_cast<float>(i % 3), 1.0f + static_cast<float>(i + 5 * round), 0.2f},
         .user_data = 100u * static_cast<std::uint64_t>(part) + static_cast<std::uint64_t>(i)});
    if (i % 3 == 0) world.add_shape(body, Box{{0.3f, 0.2f, 0.4f}}, {.friction = 0.3f});
    if (i % 3 == 1) world.add_shape(body, ConvexHull{hull, {1, 1, 1}}, {.density = 700});
    if (i % 3 != 0)
      world.add_shape(body, Sphere{0.25f}, {.restitution = 0.3f}, {.local_pose = {{0, 0.3f, 0}, {}}});
    if (i == 0 && world.is_alive(before))
      world.create_joint({.body_a = before, .body_b = body}, DistanceJoint{{.upper = 2.0f}});
    if (i == 5) world.add_impulse(body, {100, 0, 50});
    if (i == 7) world.set_body_type(body, BodyType::kinematic);
    if (i == 9) world.destroy_body(before);
    before = body;
  }
}

World with_floor() {
  World world{WorldSettings{}};
  world.add_shape(world.create_body({.type = BodyType::fixed, .position = {0, -1, 0}}), Box{{20, 1, 20}});
  return world;
}

TEST(DistributedGive, WhatEachRankGivesHasTheBitsOfOneProcess) {
  constexpr int kRanks = 3, kSteps = 120;
  Workers workers(1);
  World one = with_floor();
  std::vector<std::uint64_t> expected;
  for (int i = 0; i < kSteps; ++i) {
    for (int part = 0; part < kRanks && i % 40 == 0; ++part) fill_part(one, part, kRanks, i / 40);
    step(one, kStep, workers);
    expected.push_back(one.hash());
  }
  const auto errors = run_ranks(kRanks, [&](int rank, Transport& transport) {
    Workers of_rank(1);
    DistributedWorld world(with_floor(), transport, {.steps_per_look = 7, .imbalance = 1.0f});
    for (int i = 0; i < kSteps; ++i) {
      if (i % 40 == 0) world.give([&](World& part) { fill_part(part, rank, kRanks, i / 40); }, of_rank);
      distributed_tests::scramble_absent_rows(internals(world.world()));
      world.step(kStep, of_rank);
      ASSERT_EQ(world.hash(), expected[static_cast<std::size_t>(i)]) << "step " << i;
      ASSERT_EQ(world.world().body_count(), internals(world.world()).bodies.alive);
    }
  });
  EXPECT_EQ(all_of(errors), "");
}

// Bodies with several shapes, joints, meshes, hulls, bodies that come later or are driven.
TEST(DistributedGive, ASceneOfWhichEachRankGivesAShareHasTheBitsOfOneProcess) {
  const std::pair<const char*, scenes::Parameters> kScenes[] = {
      {"pile", {{"bodies", 60}}},      {"motors", {{"machines", 2}}},
      {"wheel_pile", {{"wheels", 6}}}, {"ragdoll_rain", {{"ragdolls", 3}, {"triangles", 200}}},
      {"drum", {{"bodies", 50}}},      {"spawning", {{"bodies", 10}, {"life", 10}}},
      {"streaming", {{"blocks", 3}}},
  };
  for (const auto& entry : kScenes) {
    const std::string name = entry.first;
    const scenes::Scene scene = scenes::build(name, entry.second).front();
    World one(scene.settings);
    std::vector<BodyId> expected = scenes::populate(one, scene);
    const std::vector<BodyId> at_first = expected;
    Workers workers(1);
    std::vector<std::uint64_t> hashes;
    for (int i = 0; i < 40; ++i) {
      scenes::direct(one, scene, expected, i, scene.dt);
      step(one, scene.dt, workers);
      hashes.push_back(one.hash());
    }
    const auto errors = run_ranks(3, [&](int, Transport& transport) {
      Workers of_rank(1);
      DistributedWorld world(World(scene.settings), transport, {.steps_per_look = 6, .imbalance = 1.0f});
      std::vector<BodyId> bodies = scenes::populate(world, scene, of_rank);
      ASSERT_EQ(bodies.size(), at_first.size()) << name;
      for (std::size_t i = 0; i < bodies.size(); ++i)
        ASSERT_TRUE(bodies[i].index == at_first[i].index && bodies[i].generation == at_first[i].generation)
            << name << ", body " << i;
      for (int i = 0; i < 40; ++i) {
        distributed_tests::scramble_absent_rows(internals(world.world()));
        scenes::direct(world.world(), scene, bodies, i, scene.dt);
        world.step(scene.dt, of_rank);
        ASSERT_EQ(world.hash(), hashes[static_cast<std::size_t>(i)]) << name << ", step " << i;
      }
    });
    EXPECT_EQ(all_of(errors), "") << name;
  }
}

// Kinematic bodies are on all ranks until one makes them dynamic: then they are its own, or where they lie.
TEST(DistributedGive, ManyBodiesThatBecomeDynamicHaveTheBitsOfOneProcess) {
  const auto make = [] {
    World world = with_floor();
    for (int i = 0; i < 300; ++i) {
      const float x = 0.7f * static_cast<float>(i % 20) - 7.0f, y = 0.5f + 0.7f * static_cast<float>(i / 20);
      world.add_shape(world.create_body({.type = BodyType::kinematic, .position = {x, y, 0}}), Sphere{0.3f});
    }
    return world;
  };
  const auto loosen = [](World& world, int part) {
    for (std::uint32_t row = 10u + 100u * static_cast<std::uint32_t>(part);
         row < 100u + 100u * static_cast<std::uint32_t>(part); ++row)
      world.set_body_type(world.body_at(row), BodyType::dynamic);
  };
  Workers workers(1);
  World one = make();
  std::vector<std::uint64_t> expected;
  for (int i = 0; i < 60; ++i) {
    for (int part = 0; part < 3 && i == 5; ++part) loosen(one, part);
    step(one, kStep, workers);
    expected.push_back(one.hash());
  }
  const auto errors = run_ranks(3, [&](int rank, Transport& transport) {
    Workers of_rank(1);
    DistributedWorld world(make(), transport);
    for (int i = 0; i < 60; ++i) {
      if (i == 5) world.give([&](World& part) { loosen(part, rank); }, of_rank);
      world.step(kStep, of_rank);
      ASSERT_EQ(world.hash(), expected[static_cast<std::size_t>(i)]) << "step " << i;
    }
  });
  EXPECT_EQ(all_of(errors), "");
}

TEST(DistributedGive, WhatAllRanksDoTogetherIsRefusedInIt) {
  const auto errors = run_ranks(2, [&](int rank, Transport& transport) {
    Workers of_rank(1);
    DistributedWorld world(with_floor(), transport);
    const std::vector<std::function<void()>> together = {
        [&] { world.step(kStep, of_rank); }, [&] { world.hash(); }, [&] { world.give({}, of_rank); },
        [&] { scree::step(world.world(), kStep, of_rank); }, [] { throw 3; }};
    for (std::size_t i = 0; i < together.size(); ++i) {
      const char* const part = i + 1 < together.size() ? "must wait" : "no std::exception";
      try {
        world.give(
            [&](World&) {
              if (rank == 1) together[i]();
            },
            of_rank);
        ADD_FAILURE() << i;
      } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
      }
    }
    world.step(kStep, of_rank);
    world.hash();
  });
  EXPECT_EQ(all_of(errors), "");
}

// A step that the calls of give() try, and whose error they catch, is in no recording.
TEST(DistributedGive, AStepThatIsRefusedInItEndsNoRecording) {
  const std::string file =
      (std::filesystem::temp_directory_path() / ("scree_caught_" + std::to_string(getpid()) + ".scree"))
          .string();
  const auto errors = run_ranks(2, [&](int rank, Transport& transport) {
    Workers of_rank(1);
    DistributedWorld world(with_floor(), transport);
    world.record(file, of_rank);
    for (int i = 0; i < 6; ++i) {
      world.give(
          [&](World& part) {
            if (i == 2) fill_part(part, rank, 2, 0);
            EXPECT_THROW(scree::step(part, kStep, of_rank), Error);
            EXPECT_THROW(world.step(kStep, of_rank), Error);
          },
          of_rank);
      world.step(kStep, of_rank);
    }
    world.finish_recording(of_rank);
  });
  EXPECT_EQ(all_of(errors), "");
  Player player(file);
  Workers workers(1);
  EXPECT_EQ(player.info().last_step, 6u);
  EXPECT_TRUE(player.info().finished);
  EXPECT_FALSE(player.verify(0, 6, workers));
  std::filesystem::remove(file);
}

// A recording that fails keeps no call of rank 0 from the others.
TEST(DistributedGive, GoesOnWhereTheRecordingFails) {
  const std::string file =
      (std::filesystem::temp_directory_path() / ("scree_give_" + std::to_string(getpid()))).string();
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
  rlimit small = limit;
  small.rlim_cur = 40'000;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  std::vector<std::size_t> counts(2);
  const auto errors = run_ranks(2, [&](int rank, Transport& transport) {
    Workers of_rank(1);
    DistributedWorld world(with_floor(), transport);
    world.record(file, of_rank);
    const auto create = [&](World& part) {
      physics::Random random(3);
      for (int i = 0, behind = 0; i < 40000 && behind < 50; ++i) {
        const Vec3 place = {random.uniform(-90, 90), random.uniform(5, 90), random.uniform(-90, 90)};
        part.add_shape(part.create_body({.position = place}), Sphere{0.3f});
        if (i % 1000 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
        behind += world.recorder()->is_recording() ? 0 : 1;
      }
      EXPECT_FALSE(world.recorder()->is_recording());
    };
    world.give(rank == 0 ? std::function<void(World&)>(create) : nullptr, of_rank);
    counts[static_cast<std::size_t>(rank)] = world.world().body_count();
    world.step(kStep, of_rank);
    world.hash();
  });
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  EXPECT_EQ(all_of(errors), "");
  EXPECT_GT(counts[0], 50u);
  EXPECT_EQ(counts[1], counts[0]);
  std::remove(file.c_str());
}

// Of many bodies a rank keeps its own alone.
TEST(DistributedGive, RowsThatARankDoesNotHaveAreZero) {
  constexpr int kRanks = 3, kBodies = 20000;  // of each rank; more than one message holds
  std::vector<std::uint64_t> hashes(kRanks);
  World one = with_floor();
  const auto fill = [](World& world, int part) {
    std::vector<BodyDef> defs;
    std::vector<BodyId> of_first;
    for (int i = 0; i < kBodies; ++i) {
      defs.push_back({.position = {100.0f * static_cast<float>(part) + static_cast<float>(i % 20),
                                   static_cast<float>(i / 400), static_cast<float>(i / 20 % 20)},
                      .user_data = 7});
    }
    for (int begin = 0; begin < kBodies; begin += 5000) {
      std::vector<BodyId> ids(5000);
      const std::vector<Geometry> balls(5000, Sphere{0.4f});
      const std::span<const BodyDef> some = std::span(defs).subspan(static_cast<std::size_t>(begin), 5000);
      if (begin == 0) {
        world.create_bodies(some, ids);  // whose shapes come with later messages
        of_first = ids;
      } else {
        world.create_bodies(some, balls, {}, {}, ids);
      }
    }
    for (int i = 0; i < 5000; ++i) world.add_shape(of_first[static_cast<std::size_t>(i)], Sphere{0.4f});
  };
  for (int part = 0; part < kRanks; ++part) fill(one, part);
  const auto errors = run_ranks(kRanks, [&](int rank, Transport& transport) {
    Workers of_rank(1);
    DistributedWorld world(with_floor(), transport);
    world.give([&](World& part) { fill(part, rank); }, of_rank);
    EXPECT_EQ(world.hash(), one.hash());
    WorldData& data = internals(world.world());
    int absent = 0, filled = 0;
    distributed_tests::for_each_absent_row(data, [&](auto& store, std::size_t row) {
      ++absent;
      bool is_zero = true;
      for_each_local_column(store, LocalColumns::all, [&](const auto& column) {
        const auto* bytes = reinterpret_cast<const char*>(&column[row]);
        is_zero =
            is_zero && std::all_of(bytes, bytes + sizeof column[row], [](char byte) { return byte == 0; });
      });
      filled += is_zero ? 0 : 1;
    });
    EXPECT_EQ(absent, 2 * (kRanks - 1) * kBodies);  // bodies and shapes
    EXPECT_EQ(filled, 0);
  });
  EXPECT_EQ(all_of(errors), "");
}

TEST(DistributedGive, WhatARankThrowsWhileItGivesIsThrownByAll) {
  World one = with_floor();
  const auto fill = [](World& world, int rank) {
    for (int i = 0; i < 3; ++i) {
      const BodyId body = world.create_body({.position = {static_cast<float>(rank + 3 * i), 2, 0}});
      if (rank == 1 && i == 2) world.add_shape(body, Sphere{-1.0f});
      world.add_shape(body, Sphere{0.3f});
    }
  };
  std::string expected;
  try {
    for (int part = 0; part < 3; ++part) fill(one, part);
  } catch (const Error& error) {
    expected = error.what();
  }
  EXPECT_NE(expected, "");
  Workers workers(1);
  step(one, kStep, workers);
  const auto errors = run_ranks(3, [&](int rank, Transport& transport) {
    Workers of_rank(1);
    DistributedWorld world(with_floor(), transport);
    std::string found;
    try {
      world.give([&](World& part) { fill(part, rank); }, of_rank);
    } catch (const Error& error) {
      found = error.what();
    }
    EXPECT_EQ(found, expected);
    world.give({}, of_rank);
    world.step(kStep, of_rank);
    EXPECT_EQ(world.hash(), one.hash());
  });
  EXPECT_EQ(all_of(errors), "");
}

}  // namespace
}  // namespace scree
