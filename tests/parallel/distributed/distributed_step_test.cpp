// Laws of a world that is divided among ranks: its bits are those of a single world, whoever owns which body.
#include <tests/parallel/distributed/step_ranks.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace scree {
namespace {

using namespace distributed_tests;
using physics::Lab;

void fill_with_heap(Lab& lab) { physics::add_heap(lab, 120, 4); }

TEST(DistributedStep, AHeapHasTheBitsOfOneProcess) {
  for (const int ranks : {1, 2, 3, 4}) {
    for (const Owners& owners : {Owners(random_owner), Owners(owner_by_blocks)})
      expect_same_bits(fill_with_heap, owners, {.ranks = ranks, .steps = 120});
  }
}

TEST(DistributedStep, PilesHaveTheBitsOfOneProcess) {
  expect_same_bits(scene("pile", {{"bodies", 300}}), random_owner, {.ranks = 3, .steps = 100});
  expect_same_bits(scene("large_pyramid", {{"base", 14}}), random_owner, {.ranks = 4, .steps = 60});
  expect_same_bits(scene("convex_pile", {{"columns", 2}, {"layers", 10}}), owner_by_blocks, {.ranks = 3});
  expect_same_bits(scene("terrain", {{"bodies", 150}, {"triangles", 5000}}), random_owner, {.ranks = 2});
}

TEST(DistributedStep, JointsHaveTheBitsOfOneProcess) {
  expect_same_bits(scene("bridge", {{"planks", 20}, {"loads", 6}}), random_owner, {.ranks = 3, .steps = 100});
  expect_same_bits(scene("joint_grid", {{"columns", 12}, {"rows", 12}}), owner_by_blocks, {.ranks = 4});
  expect_same_bits(scene("ragdolls", {{"ragdolls", 12}}), random_owner, {.ranks = 4, .steps = 100});
  expect_same_bits(scene("motors", {{"machines", 2}}), random_owner, {.ranks = 3});
  expect_same_bits(scene("vehicles", {{"cars", 4}}), random_owner, {.ranks = 2});
}

// The strongest law: who owns a body never enters the arithmetic.
TEST(DistributedStep, OwnersMayBeRedrawnBeforeEachStep) {
  for (const int ranks : {2, 5})
    expect_same_bits(fill_with_heap, random_owner, {.ranks = ranks, .steps = 80, .steps_per_draw = 1});
  expect_same_bits(scene("convex_pile", {{"columns", 2}, {"layers", 10}}), random_owner,
                   {.ranks = 3, .steps = 60, .steps_per_draw = 3});
  expect_same_bits(scene("terrain", {{"bodies", 100}, {"triangles", 5000}}), random_owner,
                   {.ranks = 3, .steps = 60, .steps_per_draw = 2});
  expect_same_bits(scene("ragdolls", {{"ragdolls", 8}}), random_owner,
                   {.ranks = 4, .steps = 80, .steps_per_draw = 1});
  expect_same_bits(scene("motors", {{"machines", 2}}), random_owner, {.ranks = 3, .steps_per_draw = 1});
}

// Bullets through a plate and against each other, sticks that spin, a paddle, balls that lose a part of a
// step.
void fill_with_fast_bodies(Lab& lab) {
  lab.add_ground();
  lab.add({.position = {0, 2, 0}}, Box{{3, 2, 0.005f}});
  for (int i = 0; i < 12; ++i) {
    const float x = 0.45f * static_cast<float>(i) - 2.5f;
    const Vec3 way = {0.0f, 0.5f * static_cast<float>(i % 3), i % 2 == 0 ? 700.0f : -900.0f};
    lab.add({.position = {x, 1 + 0.2f * static_cast<float>(i % 4), i % 2 == 0 ? -20.0f : 24.0f},
             .linear_velocity = way},
            Sphere{0.05f}, {.restitution = 0.4f});
    lab.add({.position = {x, 6 + static_cast<float>(i), 3},
             .linear_velocity = {0, -60, 0},
             .angular_velocity = {0, 0, 40.0f - 7.0f * static_cast<float>(i)}},
            Capsule{0.6f, 0.04f});
    // In one line, so that they meet one after the other in the same step.
    lab.add({.position = {-30.0f + 2.0f * static_cast<float>(i), 0.8f, -6},
             .linear_velocity = {i < 6 ? 300.0f - 20.0f * static_cast<float>(i) : -200.0f, 0, 0}},
            Sphere{0.1f});
  }
  const BodyId paddle = lab.world.create_body(
      {.type = BodyType::kinematic, .position = {0, 1.5f, 6}, .angular_velocity = {0, 25, 0}});
  lab.world.add_shape(paddle, Box{{3, 1, 0.05f}});
  for (int i = 0; i < 10; ++i)
    lab.add({.position = {0.5f * static_cast<float>(i) - 2, 1 + 0.3f * static_cast<float>(i % 2), 6.5f}},
            Box{{0.15f, 0.15f, 0.15f}});
}

TEST(DistributedStep, FastBodiesHaveTheBitsOfOneProcess) {
  Lab lab(settings_for_ranks());
  fill_with_fast_bodies(lab);
  std::int64_t hits = 0;
  for (int i = 0; i < 60; ++i) {
    lab.run(1);
    hits += lab.world.stats().sweep_hits;
  }
  EXPECT_GE(hits, 20);
  for (const int ranks : {1, 2, 3, 7}) {
    for (const int steps_per_draw : {0, 1})
      expect_same_bits(fill_with_fast_bodies, random_owner,
                       {.ranks = ranks, .steps_per_draw = steps_per_draw});
  }
  for (const int steps_per_draw : {0, 7}) {
    expect_same_bits(fill_with_fast_bodies, random_owner,
                     {.ranks = 3, .steps = 200, .sleeping = true, .steps_per_draw = steps_per_draw});
  }
  expect_same_bits(scene("bullets", {{"bullets", 40}}), random_owner, {.ranks = 3, .steps_per_draw = 4});
  expect_same_bits(scene("ragdoll_rain", {{"ragdolls", 6}}), random_owner, {.ranks = 3, .steps = 90});
}

// Bodies of others that are far from a rank's own ones cost it nothing.
TEST(DistributedStep, RanksHaveTheBodiesNearTheirOwnAlone) {
  constexpr int kRanks = 4, kBodies = 200;
  const auto fill = [](Lab& lab) {
    lab.add_ground();
    for (int i = 0; i < kBodies; ++i) {
      const float x = static_cast<float>(i / 2);
      lab.add({.position = {x, 0.5f + static_cast<float>(i % 2), 0}}, Box{{0.5f, 0.5f, 0.5f}});
    }
  };
  LocalRanks local(kRanks);
  std::vector<std::size_t> awake(kRanks), ghosts(kRanks);
  const auto step_rank = [&](int rank) {
    Lab lab(settings_for_ranks());
    fill(lab);
    WorldData& data = internals(lab.world);
    std::vector<std::int32_t> owners;
    for (std::size_t body = 0; body < data.bodies.flags.size(); ++body)
      owners.push_back(static_cast<std::int32_t>(body) * kRanks / static_cast<std::int32_t>(kBodies + 10));
    divide_world(data, local.at(rank), owners);
    lab.run(3);
    awake[static_cast<std::size_t>(rank)] = data.bodies.awake.size();
    ghosts[static_cast<std::size_t>(rank)] = border_of(data)->ghosts.size();
    local.leave(rank);
  };
  std::vector<std::thread> threads;
  for (int rank = 1; rank < kRanks; ++rank) threads.emplace_back(step_rank, rank);
  step_rank(0);
  for (std::thread& thread : threads) thread.join();
  std::size_t all = 0;
  for (int rank = 0; rank < kRanks; ++rank) {
    const auto place = static_cast<std::size_t>(rank);
    all += awake[place] - ghosts[place];
    EXPECT_GT(ghosts[place], 0u);
    EXPECT_LE(ghosts[place], 10u);
    EXPECT_LT(awake[place], 75u);
  }
  EXPECT_EQ(all, std::size_t{kBodies});
}

// Newton's cradle and a heap of balls that bounce.
TEST(DistributedStep, ImpactsHaveTheBitsOfOneProcess) {
  const auto cradle = [](Lab& lab) {
    const Material elastic{.friction = 0.1f, .restitution = 1.0f};
    for (int i = 0; i < 9; ++i) {
      const float x = static_cast<float>(i) + (i == 0 ? -1.5f : 0.0f);
      lab.add({.position = {x, 3, 0}, .linear_velocity = {i == 0 ? 8.0f : 0.0f, 0, 0}}, Sphere{0.5f},
              elastic);
    }
    lab.add_ground(elastic);
  };
  const auto heap = [](Lab& lab) { physics::add_heap(lab, 60, 9, {.friction = 0.5f, .restitution = 0.6f}); };
  for (const int ranks : {2, 3, 9}) {
    expect_same_bits(cradle, random_owner, {.ranks = ranks});
    expect_same_bits(heap, random_owner, {.ranks = ranks, .steps = 90});
  }
}

TEST(DistributedStep, PlatformsOfEveryRankMoveAlike) {
  const auto fill = [](Lab& lab) {
    const BodyId table = lab.world.create_body(
        {.type = BodyType::kinematic, .linear_velocity = {0.4f, 0, 0}, .angular_velocity = {0, 1.5f, 0}});
    lab.world.add_shape(table, Box{{4, 0.5f, 4}});
    for (int i = 0; i < 30; ++i) {
      const float x = static_cast<float>(i % 5) - 2.0f, z = static_cast<float>(i / 5 % 3) - 1.0f;
      lab.add({.position = {x, 1.0f + static_cast<float>(i / 15), z}}, Box{{0.4f, 0.3f, 0.4f}});
    }
  };
  expect_same_bits(fill, random_owner, {.ranks = 3, .steps = 120});
}

TEST(DistributedStep, RanksMayHaveDifferentThreadsAndInstructionSets) {
  std::vector<Isa> sets;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (is_supported(isa)) sets.push_back(isa);
  }
  for (const int threads : {1, 2})
    expect_same_bits(fill_with_heap, random_owner, {.ranks = 4, .threads = threads, .sets = sets});
}

// Each rank colors and solves what its own bodies take part in, and no more.
TEST(DistributedStep, RanksDivideTheContacts) {
  constexpr int kRanks = 2;
  Lab whole(settings_for_ranks());
  const auto fill = scene("large_pyramid", {{"base", 30}});
  fill(whole);
  whole.run(2);
  const std::size_t all = internals(whole.world).contacts.active.size();
  LocalRanks local(kRanks);
  std::vector<std::size_t> contacts(kRanks);
  const auto step_rank = [&](int rank) {
    Lab lab(settings_for_ranks());
    fill(lab);
    WorldData& data = internals(lab.world);
    const auto rows = static_cast<std::int32_t>(data.bodies.flags.size());
    std::vector<std::int32_t> owners;
    for (std::int32_t body = 0; body < rows; ++body) owners.push_back(body < rows / 2 ? 0 : 1);
    divide_world(data, local.at(rank), owners);
    lab.run(2);
    contacts[static_cast<std::size_t>(rank)] = data.contacts.active.size();
    EXPECT_GT(border_of(data)->transport.sent().bytes, 0);
    local.leave(rank);
  };
  std::thread other(step_rank, 1);
  step_rank(0);
  other.join();
  EXPECT_GT(contacts[0] + contacts[1], all) << "those across the border on both sides";
  EXPECT_LT(contacts[0] + contacts[1], all + all / 10);
  EXPECT_LT(std::max(contacts[0], contacts[1]), all * 6 / 10);
}

// A plate that carries 49 balls and hangs from as many as it takes joints to be a hub of these, too.
void fill_with_hub(Lab& lab, const Material& material) {
  lab.add_ground();
  const BodyId plate = lab.add({.position = {0, 3, 0}}, Box{{10, 0.5f, 10}}, material);
  for (int i = 0; i < 49; ++i) {
    const float x = 2.0f * static_cast<float>(i % 7) - 6.0f, z = 2.0f * static_cast<float>(i / 7) - 6.0f;
    lab.add({.position = {x, 4.05f + 0.01f * static_cast<float>(i), z}}, Sphere{0.5f}, material);
    if (i % 3 != 0) continue;
    const BodyId pendulum = lab.add({.position = {x, 1.5f, z}}, Box{{0.2f, 0.4f, 0.2f}});
    lab.world.create_joint(
        {.body_a = plate, .body_b = pendulum, .frame_a = {{x, -0.5f, z}, {}}, .frame_b = {{0, 1, 0}, {}}},
        BallJoint{});
  }
}

TEST(DistributedStep, HubsHaveTheBitsOfOneProcess) {
  Lab lab(settings_for_ranks());
  fill_with_hub(lab, {});
  lab.run(60);
  const Column<BodyColors>& bodies = constraints_of(internals(lab.world)).body_colors;
  EXPECT_TRUE(std::any_of(bodies.begin(), bodies.end(),
                          [](const BodyColors& colors) { return colors.degree > kHubDegree; }));
  for (const int ranks : {2, 3, 8})
    expect_same_bits([](Lab& one) { fill_with_hub(one, {}); }, random_owner, {.ranks = ranks, .steps = 120});
}

// The other rank goes on with the impulses that the hub's owner has stored.
TEST(DistributedStep, BodiesThatCeaseToBeHubsHaveTheBitsOfOneProcess) {
  const auto fill = [](Lab& lab) {
    lab.add_ground();
    lab.add({.position = {0, 2, 0}, .rotation = physics::rotation_about({1, 0, 1}, 0.2)}, Box{{7, 0.5f, 7}});
    for (int i = 0; i < 49; ++i) {
      const float x = 1.8f * static_cast<float>(i % 7) - 5.4f, z = 1.8f * static_cast<float>(i / 7) - 5.4f;
      lab.add({.position = {x, 3.2f + 0.2f * (z - x), z}}, Sphere{0.5f}, {.friction = 0.4f});
    }
  };
  Lab lab(settings_for_ranks());
  fill(lab);
  const auto has_hub = [&] {
    const Column<BodyColors>& bodies = constraints_of(internals(lab.world)).body_colors;
    return std::any_of(bodies.begin(), bodies.end(),
                       [](const BodyColors& colors) { return colors.degree > kHubDegree; });
  };
  int with_hub = 0;
  for (int i = 0; i < 240; ++i) {
    lab.run(1);
    with_hub += has_hub() ? 1 : 0;
  }
  EXPECT_GT(with_hub, 0);
  EXPECT_FALSE(has_hub());
  for (const int ranks : {2, 3}) expect_same_bits(fill, random_owner, {.ranks = ranks, .steps = 240});
}

// A hub's owner alone finds when its contacts meet.
TEST(DistributedStep, HubsThatReboundAndRollHaveTheBitsOfOneProcess) {
  for (const Material& material :
       {Material{.restitution = 0.6f}, Material{.restitution = 0.3f, .rolling_resistance = 0.02f},
        Material{.surface_velocity = {0.5f, 0, 0}}}) {
    const auto fill = [&](Lab& lab) { fill_with_hub(lab, material); };
    for (const int ranks : {2, 5})
      expect_same_bits(fill, random_owner, {.ranks = ranks, .steps = 100, .steps_per_draw = 7});
  }
}

// A row of trays full of balls, which hinges and a beam across all of them connect, and a tray on a tray.
void fill_with_hubs(Lab& lab, const Material& material) {
  lab.add_ground();
  const auto add_tray = [&](Vec3 at, float half, float first) {
    const BodyId tray = lab.add({.position = at}, Box{{half, 0.1f, half}}, material);
    for (int i = 0; i < 40; ++i) {
      const float step = 0.47f, x = first + step * static_cast<float>(i % 6),
                  z = step * static_cast<float>(i / 6);
      lab.add({.position = at + Vec3{x, 0.31f, z - 1.3f}}, Sphere{0.2f}, material);
    }
    return tray;
  };
  BodyId last;
  for (int i = 0; i < 10; ++i) {
    const BodyId tray = add_tray({3.2f * static_cast<float>(i), 0.6f, 0}, 1.5f, -1.3f);
    if (i > 0) {
      lab.world.create_joint(
          {.body_a = last, .body_b = tray, .frame_a = {{1.6f, 0, 0}, {}}, .frame_b = {{-1.6f, 0, 0}, {}}},
          HingeJoint{});
    }
    last = tray;
  }
  lab.add({.position = {14.4f, 1.0f, 1.4f}}, Box{{16, 0.1f, 0.05f}}, material);
  add_tray({0, 0.6f, 6}, 3.0f, -2.9f);
  add_tray({0.6f, 0.8f, 6}, 1.5f, -0.9f);
}

TEST(DistributedStep, HubsThatTouchEachOtherHaveTheBitsOfOneProcess) {
  Lab lab(settings_for_ranks());
  fill_with_hubs(lab, {});
  std::array<int, 3> without_color{};  // of joints of two hubs, contacts of two, and those of a body of many
  for (int i = 0; i < 60; ++i) {
    lab.run(1);
    const Constraints& constraints = constraints_of(internals(lab.world));
    for (std::size_t edge = 0; edge < constraints.edges.size(); ++edge) {
      const Edge& one = constraints.edges[edge];
      if (one.color != kOverflowColor) continue;
      const bool is_joint = edge >= internals(lab.world).contacts.active.size();
      ++without_color[one.kind != EdgeKind::two_hubs ? 2 : is_joint ? 0 : 1];
    }
  }
  for (const int count : without_color) EXPECT_GT(count, 0);
  for (const Material& material : {Material{}, Material{.restitution = 0.4f}}) {
    const auto fill = [&](Lab& one) { fill_with_hubs(one, material); };
    for (const int ranks : {2, 4})
      expect_same_bits(fill, random_owner, {.ranks = ranks, .steps = 60, .steps_per_draw = 10});
  }
}

TEST(DistributedStep, RefusesWhatItDoesNotSupport) {
  std::vector<std::vector<std::uint64_t>> hashes;
  const auto owner_of_nobody = [](std::int32_t, int ranks) { return ranks; };
  const std::string wrong = step_ranks(fill_with_heap, owner_of_nobody, {.ranks = 2}, hashes);
  EXPECT_NE(wrong.find("is given to rank 2 of 2"), std::string::npos) << wrong;
}

TEST(DistributedStep, MessagesOfAnotherWorldAreRefused) {
  LocalRanks local(2);
  const std::int64_t one = 1;
  local.at(1).send(0, std::as_bytes(std::span(&one, 1)));
  std::int64_t two[2] = {};
  EXPECT_THROW(local.at(0).add_up(two), Error);
  // Worlds that differ by some bodies.
  std::vector<std::vector<std::uint64_t>> hashes;
  std::atomic<int> filled{0};
  const auto differs = [&](Lab& lab) { physics::add_heap(lab, 120 + 9 * filled++, 4); };
  const std::string error = step_ranks(differs, random_owner, {.ranks = 2, .steps = 200}, hashes);
  EXPECT_NE(error.find("its world is another one"), std::string::npos) << error;
}

TEST(DistributedStep, WhoWaitsForARankThatHasLeftGetsAnError) {
  LocalRanks local(2);
  local.leave(1);
  try {
    local.at(0).receive(1);
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "rank 1 has left");
  }
}

TEST(DistributedStep, SixtyFourRanksHaveTheBitsOfOneProcess) {
  expect_same_bits(fill_with_heap, random_owner, {.ranks = 64, .steps = 80});
}

}  // namespace
}  // namespace scree
