// Sleep: an island at rest falls asleep as a whole, stays asleep, and wakes as a whole.
#include <core/world/world_data.h>
#include <tests/physics/lab.h>

#include <algorithm>
#include <span>

namespace scree::physics {
namespace {

std::size_t awake_count(const Lab& lab, const std::vector<BodyId>& bodies) {
  return static_cast<std::size_t>(
      std::count_if(bodies.begin(), bodies.end(), [&](BodyId body) { return lab.world.is_awake(body); }));
}

std::vector<BodyId> add_stack(Lab& lab, int count, float x, float base = 0.0f) {
  std::vector<BodyId> boxes;
  for (int i = 0; i < count; ++i) {
    boxes.push_back(lab.add({.position = {x, base + 0.5f + static_cast<float>(i), 0}}, Box{}));
  }
  return boxes;
}

TEST(Sleep, AHeapFallsAsleepAndStays) {
  Lab lab{WorldSettings{}};
  const std::vector<BodyId> heap = add_heap(lab, 60, 5, {.friction = 0.7f, .rolling_resistance = 0.02f});
  int steps = 0;
  while (awake_count(lab, heap) > 0 && steps < 1800) lab.run(10), steps += 10;
  ASSERT_EQ(awake_count(lab, heap), 0u) << "after " << steps << " steps";
  const std::uint64_t hash = lab.world.hash();
  lab.run(300);
  EXPECT_EQ(lab.world.hash(), hash);
  EXPECT_EQ(lab.world.stats().awake_bodies, 0);
}

TEST(Sleep, AStackHitByABallWakesAsAWhole) {
  Lab lab{WorldSettings{}};
  lab.add_ground();
  const std::vector<BodyId> hit = add_stack(lab, 6, 0.0f), spared = add_stack(lab, 6, 20.0f);
  lab.run(240);
  ASSERT_EQ(awake_count(lab, hit) + awake_count(lab, spared), 0u);
  lab.add({.position = {-3, 5.5f, 0}, .linear_velocity = {12, 0, 0}}, Sphere{0.4f});
  bool woke_as_a_whole = false;
  for (int i = 0; i < 60 && !woke_as_a_whole; ++i) {
    lab.run(1);
    const std::size_t awake = awake_count(lab, hit);
    EXPECT_TRUE(awake == 0 || awake == hit.size()) << awake << " are awake";
    woke_as_a_whole = awake == hit.size();
  }
  EXPECT_TRUE(woke_as_a_whole);
  EXPECT_EQ(awake_count(lab, spared), 0u);
  lab.run(30);
  EXPECT_GT(lab.velocity(hit.back()).norm(), 0.1) << "the top has been hit";
}

TEST(Sleep, DestroyingTheSupportWakes) {
  Lab lab{WorldSettings{}};
  lab.add_ground();
  const BodyId support = lab.add({.type = BodyType::fixed, .position = {0, 1, 0}}, Box{{1, 1, 1}});
  const std::vector<BodyId> stack = add_stack(lab, 5, 0.0f, 2.0f);
  lab.run(240);
  ASSERT_EQ(awake_count(lab, stack), 0u);
  lab.world.destroy_body(support);
  lab.run(2);
  EXPECT_EQ(awake_count(lab, stack), stack.size());
  lab.run(300);
  EXPECT_LT(lab.height(stack.front()), 0.6);
}

TEST(Sleep, OnlyANewVelocityOfAKinematicBodyWakesWhatRestsOnIt) {
  Lab lab{WorldSettings{}};
  const BodyId table = lab.add({.type = BodyType::kinematic}, Box{{5, 0.5f, 5}});
  const BodyId crate = lab.add({.position = {0, 1, 0}}, Box{});
  lab.run(120);
  ASSERT_FALSE(lab.world.is_awake(crate));
  for (int i = 0; i < 3; ++i) {
    lab.world.set_linear_velocity(table, {});
    lab.world.set_angular_velocity(table, {});
    EXPECT_FALSE(lab.world.is_awake(crate));
    lab.run(1);
    EXPECT_FALSE(lab.world.is_awake(crate));
  }
  lab.world.set_angular_velocity(table, {0, 0.1f, 0});
  EXPECT_TRUE(lab.world.is_awake(crate));
}

TEST(Sleep, PullingOutTheLowestBoxWakes) {
  Lab lab{WorldSettings{}};
  lab.add_ground();
  const std::vector<BodyId> stack = add_stack(lab, 5, 0.0f);
  lab.run(240);
  ASSERT_EQ(awake_count(lab, stack), 0u);
  lab.world.destroy_body(stack.front());
  lab.run(60);
  for (std::size_t i = 1; i < stack.size(); ++i) {
    EXPECT_LT(lab.height(stack[i]), 0.2 + static_cast<double>(i)) << "box " << i << " hangs in the air";
  }
}

TEST(Sleep, AFixedOrKinematicBodyThatArrivesInASleeperWakesIt) {
  for (const BodyType type : {BodyType::fixed, BodyType::kinematic}) {
    Lab lab{WorldSettings{}};
    lab.add_ground();
    const Box wall{{0.5f, 1, 0.5f}};
    std::vector<std::vector<BodyId>> stacks;
    for (const float x : {0.0f, 10.0f, 20.0f, 30.0f, 40.0f}) stacks.push_back(add_stack(lab, 2, x));
    const BodyId moved = lab.add({.type = type, .position = {15, 1, 0}}, wall);
    const BodyId grown = lab.add({.type = type, .position = {20.8f, 1, 0}}, Sphere{0.01f});
    const BodyId bare = lab.world.create_body({.type = type, .position = {30.8f, 1, 0}});
    const BodyId ghost = lab.world.create_body({.type = type, .position = {40.8f, 1, 0}});
    const ShapeId ghost_shape = lab.world.add_shape(ghost, wall, {}, {.filter = {.mask = 0}});
    lab.run(240);
    for (const auto& stack : stacks) ASSERT_EQ(awake_count(lab, stack), 0u);

    lab.add({.type = type, .position = {0.8f, 1, 0}}, wall);
    lab.world.set_pose(moved, Pose{{10.8f, 1, 0}, {}});
    ShapeId shape{};
    ASSERT_EQ(lab.world.shapes_of(grown, {&shape, 1}), 1u);
    lab.world.set_geometry(shape, wall);
    lab.world.add_shape(bare, wall);
    lab.world.set_filter(ghost_shape, {});
    lab.run(2);
    for (std::size_t i = 0; i < stacks.size(); ++i) {
      SCOPED_TRACE(i);
      EXPECT_EQ(awake_count(lab, stacks[i]), stacks[i].size());
    }
    lab.run(60);
    for (std::size_t i = 0; i < stacks.size(); ++i) {
      EXPECT_LT(lab.position(stacks[i].front()).x(), 10.0 * static_cast<double>(i) - 0.1)
          << "stack " << i << " must be pushed out of the wall";
    }
  }
}

TEST(Sleep, AKinematicBodyThatStopsInASleeperWakesIt) {
  Lab lab{WorldSettings{}};
  lab.add_ground();
  const std::vector<BodyId> stack = add_stack(lab, 2, 0.0f);
  // From beyond the reach of any contact to 0.1 m within the stack, in one step.
  const BodyId wall =
      lab.add({.type = BodyType::kinematic, .position = {-1.4f, 1, 0}}, Box{{0.5f, 0.9f, 0.5f}});
  lab.run(240);
  ASSERT_EQ(awake_count(lab, stack), 0u);
  lab.world.set_linear_velocity(wall, {30, 0, 0});
  lab.run(1);
  ASSERT_EQ(awake_count(lab, stack), 0u);
  lab.world.set_linear_velocity(wall, {});
  lab.run(1);
  EXPECT_EQ(awake_count(lab, stack), stack.size());
  lab.run(60);
  EXPECT_GT(lab.position(stack.front()).x(), 0.05) << "pushed out of the wall";
}

TEST(Sleep, AFixedOrKinematicBodyPutAFewCentimetersIntoASleeperWakesIt) {
  for (const BodyType type : {BodyType::fixed, BodyType::kinematic}) {
    Lab lab{WorldSettings{}};
    lab.add_ground();
    const std::vector<BodyId> stack = add_stack(lab, 2, 0.0f);
    // Too far away to touch, near enough for a row among the candidate pairs.
    const BodyId wall = lab.add({.type = type, .position = {1.03f, 1, 0}}, Box{{0.5f, 1, 0.5f}});
    lab.run(240);
    ASSERT_EQ(awake_count(lab, stack), 0u);
    lab.world.set_pose(wall, Pose{{0.96f, 1, 0}, {}});
    lab.run(1);
    EXPECT_EQ(awake_count(lab, stack), stack.size());
    lab.run(60);
    EXPECT_LT(lab.position(stack.front()).x(), -0.02) << "pushed out of the wall";
  }
}

TEST(Sleep, AMassCenterThatMovesInTheGroundMovesNoBody) {
  for (const BodyType type : {BodyType::fixed, BodyType::kinematic}) {
    Lab lab{WorldSettings{}};
    const BodyId ground = lab.add({.type = type, .position = {0, -1, 0}}, Box{{50, 1, 50}});
    const std::vector<BodyId> stack = add_stack(lab, 2, 0.0f);
    lab.run(240);
    ASSERT_EQ(awake_count(lab, stack), 0u);
    const double height = lab.height(stack.front());
    lab.world.set_mass_properties(ground, {.center = {0, 0.04f, 0}});
    lab.run(1);
    lab.world.wake(stack.front());
    for (int i = 0; i < 60; ++i) {
      lab.run(1);
      ASSERT_NEAR(lab.height(stack.front()), height, 1e-4) << "after " << i << " steps";
    }
  }
}

TEST(Sleep, AMovingKinematicBodyPushesSleepers) {
  Lab lab{WorldSettings{}};
  lab.add_ground();
  const std::vector<BodyId> stack = add_stack(lab, 2, 0.0f);
  const BodyId wall = lab.add({.type = BodyType::kinematic, .position = {-3, 1, 0}}, Box{{0.5f, 0.9f, 0.5f}});
  lab.run(240);
  ASSERT_EQ(awake_count(lab, stack), 0u);
  lab.world.set_linear_velocity(wall, {1, 0, 0});
  lab.run(240);
  EXPECT_NEAR(lab.position(wall).x(), 1.0, 1e-3);
  EXPECT_GT(lab.position(stack.front()).x(), 1.95) << "the wall has passed through";
}

TEST(Sleep, SleepingContactsAreCounted) {
  Lab lab{WorldSettings{}};
  lab.add_ground();
  const std::vector<BodyId> stack = add_stack(lab, 4, 0.0f);
  lab.run(240);
  ASSERT_EQ(awake_count(lab, stack), 0u);
  EXPECT_EQ(lab.world.stats().contacts, 4);
}

std::vector<BodyId> listed(std::span<const BodyId> list) { return {list.begin(), list.end()}; }

TEST(Sleep, EventsListTheBodiesThatFellAsleepAndWoke) {
  Lab lab{WorldSettings{}};
  lab.add_ground();
  const std::vector<BodyId> stack = add_stack(lab, 4, 0.0f), other = add_stack(lab, 2, 20.0f);
  std::vector<BodyId> begun;
  for (int i = 0; i < 240; ++i) {
    lab.run(1);
    EXPECT_TRUE(lab.world.sleep_ends().empty());
    for (const BodyId& body : lab.world.sleep_begins()) begun.push_back(body);
  }
  std::sort(begun.begin(), begun.end());
  std::vector<BodyId> all = stack;
  all.insert(all.end(), other.begin(), other.end());
  EXPECT_EQ(begun, all) << "each body once";

  lab.world.wake(stack[0]);
  lab.world.wake(other[1]);
  lab.world.destroy_body(other[1]);
  EXPECT_TRUE(lab.world.sleep_ends().empty()) << "the list covers only the last step";
  lab.run(1);
  EXPECT_EQ(listed(lab.world.sleep_ends()),
            (std::vector<BodyId>{stack[0], stack[1], stack[2], stack[3], other[0]}))
      << "the woken body, the body that leans on it and the one that lost a neighbor, no destroyed body";
  lab.run(1);
  EXPECT_TRUE(lab.world.sleep_ends().empty());
}

TEST(Sleep, PairsOfSleepersRestInAListThatStepsDoNotRead) {
  Lab lab{WorldSettings{}};
  lab.add_ground();
  const std::vector<BodyId> stack = add_stack(lab, 6, 0.0f);
  const Contacts& contacts = internals(lab.world).contacts;
  lab.run(240);
  ASSERT_EQ(awake_count(lab, stack), 0u);
  EXPECT_TRUE(contacts.pairs.pair.empty());
  EXPECT_EQ(contacts.resting.pair.size(), 6u);
  lab.add({.position = {20, 30, 0}, .linear_velocity = {0, 0, 20}, .can_sleep = false}, Sphere{});
  lab.run(200);
  EXPECT_EQ(contacts.resting.pair.size(), 6u);
  EXPECT_EQ(lab.world.stats().contacts, 7);
  EXPECT_EQ(lab.world.stats().pairs, 7);
  lab.world.wake(stack[3]);
  lab.run(2);
  EXPECT_TRUE(contacts.resting.pair.empty());
  EXPECT_EQ(lab.world.stats().contacts, 7);
}

TEST(Sleep, MovingBodiesStayAwakeWithASleepTimeOfZero) {
  WorldSettings settings;
  settings.sleep_time = 0.0f;
  Lab lab{settings};
  lab.add_ground();
  const BodyId ball = lab.add({.position = {0, 20, 0}, .linear_velocity = {10, 0, 0}}, Sphere{0.5f});
  const BodyId box = lab.add({.position = {5, 0.5f, 5}}, Box{});
  lab.run(60);
  EXPECT_TRUE(lab.world.is_awake(ball));
  EXPECT_NEAR(lab.position(ball).x(), 10.0, 1e-3);
  EXPECT_FALSE(lab.world.is_awake(box));
}

TEST(Sleep, NoBodySleepsWhileItIsSwitchedOff) {
  Lab lab(without_sleep());
  lab.add_ground();
  const std::vector<BodyId> stack = add_stack(lab, 4, 0.0f);
  for (int i = 0; i < 300; ++i) {
    lab.run(1);
    ASSERT_EQ(awake_count(lab, stack), stack.size());
  }
}

TEST(Sleep, SwitchingItOffWakesEveryBody) {
  Lab lab{WorldSettings{}};
  lab.add_ground();
  const std::vector<BodyId> stack = add_stack(lab, 4, 0.0f);
  lab.run(240);
  ASSERT_EQ(awake_count(lab, stack), 0u);
  lab.world.set_settings(without_sleep());
  lab.run(120);
  EXPECT_EQ(awake_count(lab, stack), stack.size());
}

TEST(Sleep, ScenesFallAsleepAndStayAsleep) {
  struct Case {
    const char* name;
    scenes::Parameters parameters;
  };
  for (const Case& item :
       {Case{"large_pyramid", {{"base", 40}}}, Case{"many_pyramids", {{"columns", 3}, {"rows", 3}}},
        Case{"junkyard", {{"columns", 6}, {"layers", 3}}}, Case{"pile", {{"bodies", 200}}},
        Case{"pile", {{"bodies", 1000}, {"seed", 12}}}}) {
    const scenes::Scene scene = scenes::build(item.name, item.parameters).front();
    WorldSettings settings = scene.settings;
    settings.sleeping = true;
    Lab lab(settings);
    populate(lab.world, scene);
    int steps = 0;
    do lab.run(10), steps += 10;
    while (lab.world.stats().awake_bodies > 0 && steps < 2400);
    ASSERT_EQ(lab.world.stats().awake_bodies, 0) << item.name << " after " << steps << " steps";
    const std::uint64_t hash = lab.world.hash();
    lab.run(200);
    EXPECT_EQ(lab.world.hash(), hash) << item.name;
  }
}

// A world without gravity in which the test sets velocities in the rows: calls would wake the bodies.
struct Weightless : Lab {
  Weightless() : Lab(WorldSettings{.gravity = {}}) {}
  VelocityRow& moves(BodyId body) { return internals(world).bodies.velocity[body.index]; }
};

TEST(Sleep, ABodyThatTremblesInPlaceFallsAsleep) {
  Weightless lab;
  const BodyId shaken = lab.add({}, Box{}), turned = lab.add({.position = {9, 0, 0}}, Box{});
  for (int i = 0; i < 40; ++i) {
    const float sense = i % 2 == 0 ? 1.0f : -1.0f;
    lab.moves(shaken).linear[0] = 0.3f * sense;  // six times the sleep threshold, over 5 mm
    lab.moves(turned).angular[1] = 0.6f * sense;
    lab.run(1);
  }
  EXPECT_FALSE(lab.world.is_awake(shaken));
  EXPECT_FALSE(lab.world.is_awake(turned));
}

TEST(Sleep, ABodyThatShakesTooFastStaysAwake) {
  Weightless lab;
  const BodyId shaken = lab.add({}, Box{});
  for (int i = 0; i < 300; ++i) {
    lab.moves(shaken).linear[0] = i % 2 == 0 ? 0.5f : -0.5f;
    lab.run(1);
    ASSERT_TRUE(lab.world.is_awake(shaken)) << "after " << i << " steps";
  }
}

TEST(Sleep, AConstantSpeedAboveThatOfSleepKeepsAwakeAndOneBelowDoesNot) {
  Weightless lab;
  const BodyId creeps = lab.add({.linear_velocity = {0.052f, 0, 0}}, Box{});
  const BodyId turns = lab.add({.position = {9, 0, 0}, .angular_velocity = {0, 0.104f, 0}}, Box{});
  const BodyId slow = lab.add({.position = {18, 0, 0}, .linear_velocity = {0.048f, 0, 0}}, Box{});
  const BodyId slow_turn = lab.add({.position = {27, 0, 0}, .angular_velocity = {0, 0.096f, 0}}, Box{});
  lab.run(40);
  EXPECT_FALSE(lab.world.is_awake(slow));
  EXPECT_FALSE(lab.world.is_awake(slow_turn));
  for (int i = 40; i < 600; ++i) {
    lab.run(1);
    ASSERT_TRUE(lab.world.is_awake(creeps)) << "after " << i << " steps";
    ASSERT_TRUE(lab.world.is_awake(turns)) << "after " << i << " steps";
  }
  EXPECT_NEAR(lab.position(creeps).x(), 0.52, 1e-3);
}

TEST(Sleep, ATimeAtRestDoesNotCountOnceTheBodyMovesOn) {
  Weightless lab;
  const BodyId body = lab.add({.can_sleep = false}, Box{});
  const float& timer = internals(lab.world).bodies.sleep_time[body.index];
  lab.run(600);
  ASSERT_GE(timer, 0.5f);
  lab.moves(body).linear[0] = 0.06f;
  lab.run(120);
  for (int i = 0; i < 300; ++i) {
    lab.run(1);
    ASSERT_LT(timer, 0.5f) << "after " << i << " steps";
  }
}

TEST(Sleep, ABallAtTheTopOfItsFlightOrBounceStaysAwake) {
  Lab lab{WorldSettings{.restitution_threshold = 0.0f}};
  lab.add_ground();
  const BodyId thrown = lab.add({.position = {5, 1, 0}, .linear_velocity = {0, 3, 0}}, Sphere{0.2f});
  const BodyId bounces = lab.add({.position = {0, 0.32f, 0}}, Sphere{0.2f}, {.restitution = 1.0f});
  for (int i = 0; i < 120; ++i) {
    lab.run(1);
    ASSERT_TRUE(i >= 40 || lab.world.is_awake(thrown)) << "after " << i << " steps";
    ASSERT_TRUE(lab.world.is_awake(bounces)) << "after " << i << " steps";
  }
}

TEST(Sleep, BodiesThatRockOnABallOrRollSlowlyComeToRestIfTheyMaySleep) {
  Lab lab{WorldSettings{}};
  lab.add_ground();
  lab.add({.type = BodyType::fixed, .position = {0, 0.5f, 0}}, Sphere{0.5f});
  const BodyId stone = lab.add({.position = {0, 1.19f, 0}, .rotation = rotation_about({0, 0, 1}, 0.05)},
                               Box{{0.3f, 0.2f, 0.3f}});
  const auto roll = [&](float z, bool can_sleep) {
    const BodyDef def{.position = {5, 0.3f, z},
                      .linear_velocity = {0.09f, 0, 0},
                      .angular_velocity = {0, 0, -0.3f},
                      .can_sleep = can_sleep};
    return lab.add(def, Sphere{0.3f});
  };
  const BodyId sleeper = roll(5.0f, true), other = roll(9.0f, false);
  lab.run(600);
  EXPECT_FALSE(lab.world.is_awake(stone));
  EXPECT_FALSE(lab.world.is_awake(sleeper));
  EXPECT_NEAR(lab.velocity(other).x(), 0.09, 1e-3) << "there is no rolling resistance";
}

TEST(Sleep, ABodyThatMayNotSleepKeepsItsIslandAwake) {
  Lab lab{WorldSettings{}};
  lab.add_ground();
  std::vector<BodyId> stack = add_stack(lab, 3, 0.0f);
  stack.push_back(lab.add({.position = {0, 3.5f, 0}, .can_sleep = false}, Box{}));
  const std::vector<BodyId> other = add_stack(lab, 3, 10.0f);
  lab.run(300);
  EXPECT_EQ(awake_count(lab, stack), stack.size());
  EXPECT_EQ(awake_count(lab, other), 0u);
}

TEST(Sleep, NoBodySleepsOnAMovingPlatform) {
  Lab lab{WorldSettings{}};
  lab.add({.type = BodyType::kinematic, .linear_velocity = {0.01f, 0, 0}}, Box{{3, 0.2f, 3}});
  const BodyId box = lab.add({.position = {0, 0.5f, 0}}, Box{{0.3f, 0.3f, 0.3f}});
  lab.run(300);
  EXPECT_TRUE(lab.world.is_awake(box));
}

TEST(Sleep, AForceWakes) {
  Lab lab{WorldSettings{}};
  lab.add_ground();
  const BodyId box = lab.add({.position = {0, 0.5f, 0}}, Box{});
  lab.run(200);
  ASSERT_FALSE(lab.world.is_awake(box));
  lab.world.add_force(box, {2e4f, 0, 0});
  lab.run(1);
  EXPECT_TRUE(lab.world.is_awake(box));
  EXPECT_GT(lab.velocity(box).x(), 0.1);
}

}  // namespace
}  // namespace scree::physics
