// Laws of DistributedWorld: the bits of one process while bodies change owners, and saving and going on with
// another number of ranks.
#include <gtest/gtest.h>
#include <scree/distributed_world.h>
#include <scree/error.h>
#include <scree/step.h>
#include <tests/parallel/bodies/overload.h>
#include <tests/parallel/distributed/absent_rows.h>
#include <tests/parallel/distributed/local_ranks.h>
#include <tests/physics/lab.h>
#include <tools/scenes/scene.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace scree {
namespace {

using distributed_tests::all_of;
using distributed_tests::run_ranks;
using physics::kStep;

// What all ranks do alike before each step.
using Direct = std::function<void(World&, const std::vector<BodyId>&, int step)>;

struct Start {
  World world;
  std::vector<BodyId> bodies;
};

Start start_of(const std::string& name, const scenes::Parameters& parameters, bool sleeping = false) {
  scenes::Scene scene = scenes::build(name, parameters).front();
  scene.settings.sleeping = sleeping;
  Start start{World(scene.settings), {}};
  start.bodies = scenes::populate(start.world, scene);
  return start;
}

Start falling_column() { return start_of("pile", {{"bodies", 240}}); }

std::vector<std::uint64_t> hashes_of_one(const std::function<Start()>& make, int steps,
                                         const Direct& direct) {
  Start start = make();
  Workers workers(1);
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < steps; ++i) {
    if (direct) direct(start.world, start.bodies, i);
    step(start.world, kStep, workers);
    hashes.push_back(start.world.hash());
  }
  return hashes;
}

void expect_bits_of_one(const std::function<Start()>& make, int ranks, int steps,
                        const DistributedOptions& options, const Direct& direct = {}) {
  const std::vector<std::uint64_t> expected = hashes_of_one(make, steps, direct);
  std::vector<std::vector<std::uint64_t>> hashes(static_cast<std::size_t>(ranks));
  const auto errors = run_ranks(ranks, [&](int rank, Transport& transport) {
    Start start = make();
    Workers workers(1);
    DistributedWorld world(std::move(start.world), transport, options);
    for (int i = 0; i < steps; ++i) {
      distributed_tests::scramble_absent_rows(internals(world.world()));
      if (direct) direct(world.world(), start.bodies, i);
      distributed_tests::scramble_absent_rows(internals(world.world()));
      world.step(kStep, workers);
      hashes[static_cast<std::size_t>(rank)].push_back(world.hash());
    }
  });
  EXPECT_EQ(all_of(errors), "");
  for (const std::vector<std::uint64_t>& of_rank : hashes) EXPECT_EQ(of_rank, expected) << ranks << " ranks";
}

TEST(DistributedWorld, HasTheBitsOfOneProcessWhileBodiesChangeOwners) {
  for (const int ranks : {1, 2, 3, 4})
    expect_bits_of_one(falling_column, ranks, 120, {.steps_per_look = 3, .imbalance = 1.0f});
  expect_bits_of_one([] { return start_of("ragdolls", {{"ragdolls", 12}}); }, 3, 120, {.steps_per_look = 5});
}

TEST(DistributedWorld, CallsOfAllRanksHaveTheBitsOfOneProcess) {
  const Direct direct = [](World& world, const std::vector<BodyId>& bodies, int step) {
    physics::Random random(static_cast<std::uint64_t>(step) + 5);
    for (int i = 0; i < 6; ++i) {
      const auto place =
          static_cast<std::size_t>(random.uniform(0, static_cast<float>(bodies.size()) - 0.5f));
      const BodyId body = bodies[place];
      if (world.body_type(body) != BodyType::dynamic) continue;
      if (i % 3 == 0) world.set_linear_velocity(body, {random.uniform(-3, 3), 4, random.uniform(-3, 3)});
      if (i % 3 == 1) world.add_force(body, {0, 500.0f * random.uniform(0, 1), 0});
      if (i % 3 == 2 && step % 10 == 0) {
        world.set_pose(body,
                       {{random.uniform(-4, 4), 8.0f + random.uniform(0, 4), random.uniform(-4, 4)}, {}});
        world.set_angular_velocity(body, {0, 1, 0});
      }
    }
  };
  expect_bits_of_one(falling_column, 3, 100, {.steps_per_look = 4}, direct);
}

// Calls wake what sleeps, on ranks that know nothing of what it touches, too.
TEST(DistributedWorld, WakesWhatSleepsAsOneProcessDoes) {
  const auto make = [] { return start_of("pile", {{"bodies", 120}}, true); };
  const Direct direct = [](World& world, const std::vector<BodyId>& bodies, int step) {
    if (step < 400 || step % 50 != 0) return;
    const BodyId body = bodies[bodies.size() - 1 - static_cast<std::size_t>(step / 50)];
    world.set_linear_velocity(body, {0.5f, 3, 0});
  };
  Start one = make();
  Workers workers(1);
  bool have_slept = false;
  for (int i = 0; i < 400; ++i) {
    step(one.world, kStep, workers);
    have_slept = have_slept || one.world.stats().awake_bodies == 0;
  }
  EXPECT_TRUE(have_slept);
  for (const int ranks : {2, 4}) expect_bits_of_one(make, ranks, 520, {.steps_per_look = 8}, direct);
}

// A living body that is drawn at random; of the ground, none.
BodyId draw_body(const World& world, physics::Random& random, std::uint32_t rows) {
  const auto draw = [&] {
    return static_cast<std::uint32_t>(random.uniform(2, static_cast<float>(rows) - 0.01f));
  };
  BodyId body = world.body_at(draw());
  for (int tries = 0; tries < 50 && !world.is_alive(body); ++tries) body = world.body_at(draw());
  return body;
}

void create_at_random(World& world, physics::Random& random) {
  const float kind = random.uniform(0, 1);
  const BodyId body = world.create_body(
      {.type = kind < 0.8f   ? BodyType::dynamic
               : kind < 0.9f ? BodyType::kinematic
                             : BodyType::fixed,
       .position = {random.uniform(-3, 3), random.uniform(4, 12), random.uniform(-3, 3)},
       .linear_velocity = {random.uniform(-2, 2), kind < 0.8f ? -5.0f : 0.3f, random.uniform(-2, 2)}});
  if (kind < 0.5f) world.add_shape(body, Box{{0.3f, 0.4f, 0.2f}});
  if (kind >= 0.3f) world.add_shape(body, Sphere{0.3f}, {}, {.local_pose = {{0.2f, 0, 0}, {}}});
}

// Of every kind that changes which bodies there are and who moves them.
void call_at_random(World& world, physics::Random& random, std::uint32_t rows) {
  const BodyId body = draw_body(world, random, rows), other = draw_body(world, random, rows);
  const Vec3 somewhere = {random.uniform(-3, 3), random.uniform(3, 9), random.uniform(-3, 3)};
  const int call = static_cast<int>(random.uniform(0, 9.99f));
  if (!world.is_alive(body) || !world.is_alive(other)) return;
  JointId joint[1];
  switch (call) {
    case 0:
      return world.destroy_body(body);
    case 1:
      return world.set_body_type(body, static_cast<BodyType>(static_cast<int>(random.uniform(0, 2.99f))));
    case 2:
      world.add_shape(body, Capsule{0.2f, 0.15f}, {.density = 500});
      return;
    case 3:
      if (body != other)
        world.create_joint({.body_a = body, .body_b = other, .break_force = random.uniform(50, 4000)},
                           BallJoint{});
      return;
    case 4:
      if (world.joints_of(body, joint) > 0) world.destroy_joint(joint[0]);
      return;
    case 5:
      if (world.body_type(body) == BodyType::dynamic) world.add_impulse(body, {200, 500, 100});
      return;
    case 6:
      return world.set_pose(body, {somewhere, {}});
    case 7:
      if (world.body_type(body) != BodyType::fixed) world.set_linear_velocity(body, {0, 3, 1});
      return;
    default:
      create_at_random(world, random);
  }
}

TEST(DistributedWorld, RandomCallsHaveTheBitsOfOneProcess) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto make = [] { return start_of("pile", {{"bodies", 60}}, true); };
    const Direct direct = [seed](World& world, const std::vector<BodyId>&, int step) {
      physics::Random random(1000 * seed + static_cast<std::uint64_t>(step));
      if (step % 3 != 0) return;
      const auto rows = static_cast<std::uint32_t>(world.poses().size());
      for (int i = 0; i < 3; ++i) call_at_random(world, random, rows);
    };
    expect_bits_of_one(make, 2 + static_cast<int>(seed % 3), 200, {.steps_per_look = 5}, direct);
  }
}

// Joints of bodies that are kinematic for a while go on where they were, on whichever rank.
TEST(DistributedWorld, JointsOfBodiesThatChangeTheirTypeHaveTheBitsOfOneProcess) {
  const auto make = [] {
    Start start{World(WorldSettings{}), {}};
    for (int i = 0; i < 16; ++i) {
      const BodyId link = start.world.create_body({.type = i == 0 ? BodyType::fixed : BodyType::dynamic,
                                                   .position = {0.5f * static_cast<float>(i), 6, 0}});
      start.world.add_shape(link, Box{{0.22f, 0.1f, 0.1f}});
      if (i > 0) {
        start.world.create_joint({.body_a = start.bodies.back(),
                                  .body_b = link,
                                  .frame_a = {{0.25f, 0, 0}, {}},
                                  .frame_b = {{-0.25f, 0, 0}, {}}},
                                 BallJoint{});
      }
      start.bodies.push_back(link);
    }
    return start;
  };
  const Direct direct = [](World& world, const std::vector<BodyId>& bodies, int step) {
    if (step % 7 != 3) return;
    physics::Random random(static_cast<std::uint64_t>(step));
    for (int i = 0; i < 3; ++i) {
      const BodyId body = bodies[static_cast<std::size_t>(random.uniform(1, 15.99f))];
      const bool dynamic = world.body_type(body) == BodyType::dynamic;
      world.set_body_type(body, dynamic ? BodyType::kinematic : BodyType::dynamic);
    }
  };
  for (const int ranks : {2, 4}) expect_bits_of_one(make, ranks, 160, {.steps_per_look = 6}, direct);
}

// A call takes away what a sleeper rests on just before it changes owners.
TEST(DistributedWorld, SleepersThatAreGivenAwayWakeAsInOneProcess) {
  const auto make = [] {
    Start start{World(WorldSettings{}), {}};
    for (int i = 0; i < 24; ++i) {
      const float x = 1.5f * static_cast<float>(i % 12);
      start.bodies.push_back(start.world.create_body(
          {.type = i < 12 ? BodyType::fixed : BodyType::dynamic, .position = {x, i < 12 ? 0.5f : 1.5f, 0}}));
      start.world.add_shape(start.bodies.back(), Box{{0.5f, 0.5f, 0.5f}});
    }
    return start;
  };
  const Direct direct = [](World& world, const std::vector<BodyId>& bodies, int step) {
    if (step >= 120 && step < 240 && step % 10 == 0)
      world.destroy_body(bodies[static_cast<std::size_t>(step / 10 - 12)]);
    if (step >= 110 && step % 10 == 9)  // so that the space is cut anew
      world.add_shape(world.create_body({.position = {20, 3, 0}}), Sphere{0.3f});
  };
  for (const int ranks : {2, 3})
    expect_bits_of_one(make, ranks, 260, {.steps_per_look = 10, .imbalance = 1.0f}, direct);
}

// Where floats are 1 mm apart.
TEST(DistributedWorld, AFarPileHasTheBitsOfOneProcess) {
  const auto make = [] {
    scenes::Scene scene = scenes::build("pile", {{"bodies", 100}}).front();
    for (scenes::SceneBody& body : scene.bodies) {
      body.def.position.x += 15000.0f;
      body.def.position.z -= 9000.0f;
    }
    Start start{World(scene.settings), {}};
    start.bodies = scenes::populate(start.world, scene);
    return start;
  };
  expect_bits_of_one(make, 3, 100, {.steps_per_look = 6});
}

TEST(DistributedWorld, SequentialImpulsesHaveTheBitsOfOneProcess) {
  for (const std::uint32_t seed : {0u, 7u}) {
    const auto make = [&](const char* name, const scenes::Parameters& parameters) {
      return [=] {
        scenes::Scene scene = scenes::build(name, parameters).front();
        scene.settings.solver = Solver::sequential_impulse;
        scene.settings.solver_options.shuffle_seed = seed;
        Start start{World(scene.settings), {}};
        start.bodies = scenes::populate(start.world, scene);
        return start;
      };
    };
    expect_bits_of_one(make("pile", {{"bodies", 120}}), 3, 100, {.steps_per_look = 6});
    expect_bits_of_one(make("ragdolls", {{"ragdolls", 8}}), 2, 60, {.steps_per_look = 6});
  }
}

// Bodies whose state becomes non-finite, with those that they touch, by whoever owns these.
TEST(DistributedWorld, QuarantinesAsOneProcessDoes) {
  const Direct direct = [](World& world, const std::vector<BodyId>& bodies, int step) {
    if (step >= 40 && step < 100 && step % 10 == 0)
      physics::overload(world, bodies[bodies.size() - 1 - static_cast<std::size_t>(step)]);
  };
  constexpr int kSteps = 140;
  using Lists = std::vector<std::set<std::uint32_t>>;  // by step
  const auto note = [](const World& world, int step, Lists& restored, Lists& quarantined) {
    for (const BodyId body : world.restored_bodies())
      restored[static_cast<std::size_t>(step)].insert(body.index);
    for (const BodyId body : world.quarantined_bodies())
      quarantined[static_cast<std::size_t>(step)].insert(body.index);
  };
  Start one = falling_column();
  Workers workers(1);
  Lists restored(kSteps), quarantined(kSteps), found_restored(kSteps), found_quarantined(kSteps);
  std::vector<std::uint64_t> hashes;
  std::size_t at_fault = 0, others = 0;
  for (int i = 0; i < kSteps; ++i) {
    direct(one.world, one.bodies, i);
    step(one.world, kStep, workers);
    hashes.push_back(one.world.hash());
    note(one.world, i, restored, quarantined);
    at_fault += one.world.quarantined_bodies().size();
    others += one.world.restored_bodies().size();
  }
  EXPECT_GT(at_fault, 3u);
  EXPECT_GT(others, at_fault + 3);
  std::mutex mutex;
  const auto errors = run_ranks(4, [&](int, Transport& transport) {
    Start start = falling_column();
    Workers of_rank(1);
    DistributedWorld world(std::move(start.world), transport, {.steps_per_look = 6, .imbalance = 1.0f});
    for (int i = 0; i < kSteps; ++i) {
      direct(world.world(), start.bodies, i);
      world.step(kStep, of_rank);
      ASSERT_EQ(world.hash(), hashes[static_cast<std::size_t>(i)]) << "step " << i;
      const std::lock_guard lock(mutex);
      note(world.world(), i, found_restored, found_quarantined);
    }
  });
  EXPECT_EQ(all_of(errors), "");
  EXPECT_EQ(found_restored, restored);
  EXPECT_EQ(found_quarantined, quarantined);
}

// Calls about bodies that are absent on rank 0 are in what it saves before the next step.
TEST(DistributedWorld, SavesWhatCallsHaveJustDone) {
  const auto make = [] { return start_of("pile", {{"bodies", 120}}); };
  const auto change = [](World& world, const std::vector<BodyId>& bodies) {
    for (std::size_t i = 5; i < bodies.size(); i += 7)
      world.set_mass_properties(bodies[i],
                                {.mass = 300, .center = {0.05f, 0, 0}, .inertia = {9, 9, 9, 0, 0, 0}});
    for (std::size_t i = 6; i < bodies.size(); i += 31) {
      world.set_body_type(bodies[i], BodyType::kinematic);
      world.set_kinematic_target(bodies[i], {{0, 3, 0}, {}}, kStep);
    }
  };
  Start one = make();
  Workers workers(1);
  for (int i = 0; i < 60; ++i) step(one.world, kStep, workers);
  change(one.world, one.bodies);
  Snapshot together;
  const std::string file =
      (std::filesystem::temp_directory_path() / ("scree_just_done_" + std::to_string(getpid()))).string();
  const auto errors = run_ranks(3, [&](int rank, Transport& transport) {
    Start start = make();
    Workers of_rank(1);
    DistributedWorld world(std::move(start.world), transport);
    for (int i = 0; i < 60; ++i) world.step(kStep, of_rank);
    distributed_tests::scramble_absent_rows(internals(world.world()));
    change(world.world(), start.bodies);
    distributed_tests::scramble_absent_rows(internals(world.world()));
    world.checkpoint(file, of_rank);
    Snapshot snapshot;
    world.save(snapshot, of_rank);
    if (rank == 0) together = std::move(snapshot);
  });
  EXPECT_EQ(all_of(errors), "");
  World saved{WorldSettings{}};
  restore(saved, together);
  World read = read_checkpoint(file);
  std::remove(file.c_str());
  for (int i = 0; i < 60; ++i) {
    for (World* const world : {&one.world, &saved, &read}) step(*world, kStep, workers);
    ASSERT_EQ(saved.hash(), one.world.hash()) << "step " << i;
    ASSERT_EQ(read.hash(), one.world.hash()) << "step " << i;
  }
}

// Joints that break are disabled on all ranks, whoever has found out.
TEST(DistributedWorld, JointsBreakAsInOneProcess) {
  const auto make = [] {
    Start start{World(WorldSettings{}), {}};
    const BodyId ground = start.world.create_body({.type = BodyType::fixed});
    start.world.add_shape(ground, HalfSpace{});
    BodyId last = ground;
    for (int i = 0; i < 24; ++i) {
      const BodyId link = start.world.create_body({.position = {0.5f * static_cast<float>(i), 6, 0}});
      start.world.add_shape(link, Box{{0.22f, 0.1f, 0.1f}});
      start.world.create_joint({.body_a = last,
                                .body_b = link,
                                .frame_a = {i == 0 ? Vec3{-0.25f, 6, 0} : Vec3{0.25f, 0, 0}, {}},
                                .frame_b = {{-0.25f, 0, 0}, {}},
                                .break_force = 900.0f - 20.0f * static_cast<float>(i)},
                               BallJoint{});
      start.bodies.push_back(last = link);
    }
    return start;
  };
  Start one = make();
  Workers workers(1);
  std::size_t broken = 0;
  for (int i = 0; i < 150; ++i) {
    step(one.world, kStep, workers);
    broken += one.world.broken_joints().size();
  }
  EXPECT_GT(broken, 0u);
  for (const int ranks : {2, 3}) expect_bits_of_one(make, ranks, 150, {.steps_per_look = 4}, {});
}

// Contacts that come with a body find room whatever calls have said of their forces since the last step.
TEST(DistributedWorld, OwnersChangeWhileContactForcesAreTurnedOnAndOff) {
  const auto turn = [](World& world, int step) {
    WorldSettings settings = world.settings();
    settings.contact_forces = step % 2 == 0;
    world.set_settings(settings);
  };
  Start one = falling_column();
  Workers workers(1);
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < 80; ++i) {
    turn(one.world, i);
    step(one.world, kStep, workers);
    hashes.push_back(one.world.hash());
  }
  const auto errors = run_ranks(3, [&](int, Transport& transport) {
    DistributedWorld world(falling_column().world, transport, {.steps_per_look = 1, .imbalance = 1.0f});
    Workers of_rank(1);
    for (int i = 0; i < 80; ++i) {
      turn(world.world(), i);
      world.step(kStep, of_rank);
      ASSERT_EQ(world.hash(), hashes[static_cast<std::size_t>(i)]) << "step " << i;
    }
  });
  EXPECT_EQ(all_of(errors), "");
}

// No rank steps all bodies of a world that was empty when it was shared out.
TEST(DistributedWorld, SharesManyNewBodiesOutAtOnce) {
  const auto errors = run_ranks(4, [&](int, Transport& transport) {
    DistributedWorld world(World{}, transport);
    for (int i = 0; i < 800; ++i) {
      const Vec3 at = {1.1f * static_cast<float>(i % 20), 2.0f, 1.1f * static_cast<float>(i / 20)};
      world.world().add_shape(world.world().create_body({.position = at}), Sphere{0.5f});
    }
    Workers workers(1);
    world.step(kStep, workers);
    std::vector<RankStats> ranks(4);
    world.stats(ranks);
    for (const RankStats& rank : ranks) EXPECT_NEAR(static_cast<double>(rank.bodies), 200.0, 40.0);
  });
  EXPECT_EQ(all_of(errors), "");
}

// A world that goes back to what rank 0 has saved knows the handles that rank 0 has given.
TEST(DistributedWorld, SavesItsHandles) {
  for (const int ranks : {1, 3}) {
    const auto errors = run_ranks(ranks, [&](int rank, Transport& transport) {
      Workers workers(1);
      World world;
      const BodyId body = world.create_body({.position = {0, 3, 0}});
      world.add_shape(body, Sphere{0.5f});
      DistributedWorld shared(std::move(world), transport);
      shared.step(kStep, workers);
      Snapshot snapshot;
      shared.save(snapshot, workers);
      shared.save(snapshot, workers);  // into the same one
      if (rank != 0) return;
      World restored;
      restore(restored, snapshot);
      ASSERT_TRUE(restored.is_alive(body)) << ranks << " ranks";
      EXPECT_LT(restored.pose(body).position.y, 3.0f);
    });
    EXPECT_EQ(all_of(errors), "");
  }
}

TEST(DistributedWorld, GoesOnFromASnapshotWithAnyNumberOfRanks) {
  constexpr int kSaved = 50, kSteps = 90;
  const std::vector<std::uint64_t> expected = hashes_of_one(falling_column, kSteps, {});
  Snapshot snapshot;
  const auto errors = run_ranks(4, [&](int rank, Transport& transport) {
    Workers workers(1);
    DistributedWorld world(falling_column().world, transport, {.steps_per_look = 8});
    for (int i = 0; i < kSaved; ++i) world.step(kStep, workers);
    Snapshot own;
    world.save(own, workers);
    EXPECT_EQ(own.is_empty(), rank != 0);
    if (rank == 0) snapshot = std::move(own);
    for (int i = kSaved; i < kSteps; ++i) {
      world.step(kStep, workers);
      EXPECT_EQ(world.hash(), expected[static_cast<std::size_t>(i)]) << "after it was saved, step " << i;
    }
  });
  ASSERT_EQ(all_of(errors), "");
  World alone;
  restore(alone, snapshot);
  Workers workers(1);
  for (int i = kSaved; i < kSteps; ++i) {
    step(alone, kStep, workers);
    ASSERT_EQ(alone.hash(), expected[static_cast<std::size_t>(i)]) << "one process, step " << i;
  }
  const auto errors_of_three = run_ranks(3, [&](int, Transport& transport) {
    World restored;
    restore(restored, snapshot);
    Workers own_workers(1);
    DistributedWorld world(std::move(restored), transport);
    for (int i = kSaved; i < kSteps; ++i) {
      world.step(kStep, own_workers);
      EXPECT_EQ(world.hash(), expected[static_cast<std::size_t>(i)]) << "three ranks, step " << i;
    }
  });
  EXPECT_EQ(all_of(errors_of_three), "");
}

TEST(DistributedWorld, SharesTheLoadWhileAPileSpreads) {
  constexpr int kRanks = 4;
  std::vector<RankStats> stats;
  std::size_t bodies = 0;
  const auto errors = run_ranks(kRanks, [&](int rank, Transport& transport) {
    Start start = falling_column();
    Workers workers(1);
    DistributedWorld world(std::move(start.world), transport, {.steps_per_look = 4});
    for (int i = 0; i < 150; ++i) world.step(kStep, workers);
    std::vector<RankStats> all(kRanks);
    world.stats(all);
    EXPECT_THROW(world.stats(std::span(all).first(1)), Error);
    if (rank == 0) stats = all;
    std::int64_t owned = 0;
    for (const BodyId body : start.bodies) owned += world.owns(body) ? 1 : 0;
    EXPECT_EQ(owned, all[static_cast<std::size_t>(rank)].bodies);
    if (rank == 0) {
      bodies =
          static_cast<std::size_t>(std::count_if(start.bodies.begin(), start.bodies.end(), [&](BodyId body) {
            return world.world().body_type(body) == BodyType::dynamic;
          }));
    }
  });
  ASSERT_EQ(all_of(errors), "");
  ASSERT_EQ(stats.size(), std::size_t{kRanks});
  std::int64_t all = 0;
  for (const RankStats& one : stats) {
    all += one.bodies;
    EXPECT_GT(one.contacts, 0);
    EXPECT_GT(one.ghosts, 0);
    EXPECT_LT(one.load, 1.3);
    EXPECT_GT(one.bytes, one.messages);
    EXPECT_LE(one.waiting_ms, one.step_ms);
  }
  EXPECT_EQ(all, static_cast<std::int64_t>(bodies));
}

// Islands that slept before they were shared out wake like others.
TEST(DistributedWorld, SharesOutWorldsThatSleep) {
  const auto make = [] {
    Start start = start_of("pile", {{"bodies", 120}}, true);
    Workers workers(1);
    for (int i = 0; i < 400; ++i) step(start.world, kStep, workers);
    EXPECT_EQ(start.world.stats().awake_bodies, 0);
    return start;
  };
  const Direct direct = [](World& world, const std::vector<BodyId>& bodies, int step) {
    if (step % 40 == 10)
      world.set_linear_velocity(bodies[bodies.size() - 1 - static_cast<std::size_t>(step / 40)],
                                {0.5f, 4, 0.3f});
  };
  for (const int ranks : {2, 5}) expect_bits_of_one(make, ranks, 160, {.steps_per_look = 8}, direct);
}

}  // namespace
}  // namespace scree
