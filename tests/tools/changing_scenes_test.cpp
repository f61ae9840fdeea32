// Laws of the scenes in which bodies arrive and leave.
#include <gtest/gtest.h>
#include <tools/scenes/scene.h>

#include <algorithm>
#include <string>
#include <vector>

namespace scree::scenes {
namespace {

const std::vector<std::pair<std::string, Parameters>>& changing_scenes() {
  static const std::vector<std::pair<std::string, Parameters>> kScenes = {
      {"large_world", {{"bodies", 2500}}},
      {"streaming", {{"bodies", 60}, {"blocks", 5}}},
      {"spawning", {{"bodies", 12}, {"life", 50}}}};
  return kScenes;
}

Scene build_one(const std::string& name, const Parameters& parameters) {
  return build(name, parameters).front();
}

TEST(ChangingScenes, EveryLaterBodyArrivesOnceAndLeavesAfterItArrived) {
  for (const auto& [name, parameters] : changing_scenes()) {
    const Scene scene = build_one(name, parameters);
    ASSERT_FALSE(scene.changes.empty()) << name;
    EXPECT_TRUE(std::is_sorted(
        scene.changes.begin(), scene.changes.end(),
        [](const SceneChange& left, const SceneChange& right) { return left.step < right.step; }))
        << name;
    std::vector<bool> there(scene.bodies.size()), been(scene.bodies.size());
    for (std::size_t i = 0; i < there.size(); ++i) there[i] = been[i] = !scene.bodies[i].comes_later;
    for (const SceneChange& change : scene.changes) {
      ASSERT_LT(change.step, scene.steps);
      ASSERT_LE(change.first + change.count, scene.bodies.size());
      for (std::uint32_t i = change.first; i < change.first + change.count; ++i) {
        EXPECT_EQ(there[i], !change.creates) << name << " body " << i;
        EXPECT_TRUE(!change.creates || !been[i]) << name << " body " << i << " comes twice";
        there[i] = change.creates;
        been[i] = true;
      }
    }
    EXPECT_TRUE(std::all_of(been.begin(), been.end(), [](bool came) { return came; })) << name;
  }
}

TEST(ChangingScenes, AWorldHoldsTheBodiesThatHaveArrivedAndNotLeft) {
  for (const auto& [name, parameters] : changing_scenes()) {
    const Scene scene = build_one(name, parameters);
    const Scene script = script_of(scene);
    World world(scene.settings);
    Workers workers(1);
    std::vector<BodyId> bodies = populate(world, scene);
    std::size_t expected = world.body_count();
    for (int i = 0; i < scene.steps; ++i) {
      for (const SceneChange& change : changes_at(scene, i)) {
        expected = change.creates ? expected + change.count : expected - change.count;
      }
      direct(world, script, bodies, i, scene.dt);
      ASSERT_EQ(world.body_count(), expected) << name << " step " << i;
      if (i % 8 == 0) step(world, scene.dt, workers);
    }
    for (const BodyId body : bodies) expected -= world.is_alive(body) ? 1 : 0;
    EXPECT_EQ(expected, 0u) << name;
  }
}

TEST(ChangingScenes, BodiesThatHaveAlreadyLeftAreSkipped) {
  const Scene scene = build_one("spawning", {{"bodies", 10}, {"life", 5}});
  World world(scene.settings);
  std::vector<BodyId> bodies = populate(world, scene);
  direct(world, scene, bodies, 0, scene.dt);
  world.destroy_body(bodies[1]);
  for (int i = 1; i <= 5; ++i) direct(world, scene, bodies, i, scene.dt);
  EXPECT_EQ(world.body_count(), 1u + 50u);
}

TEST(ChangingScenes, BallsOfTheLargeWorldComeOneAtATimeAndFallAsleep) {
  const Scene scene = build_one("large_world", {{"bodies", 10000}, {"interval", 20}});
  for (const SceneChange& change : scene.changes) EXPECT_EQ(change.count, 1u);
  World world(scene.settings);
  Workers workers(1);
  std::vector<BodyId> bodies = populate(world, scene);
  std::size_t slept = 0;
  for (int i = 0; i < scene.steps; ++i) {
    direct(world, scene, bodies, i, scene.dt);
    step(world, scene.dt, workers);
    slept += world.sleep_begins().size();
  }
  EXPECT_GE(slept, 20u);
  for (const BodyId body : bodies) EXPECT_GT(world.pose(body).position.y, -2.0f) << "stays on the plain";
}

TEST(ChangingScenes, TheStreamMovesOnByABlockASecond) {
  const Scene scene = build_one("streaming", {{"bodies", 60}, {"blocks", 5}});
  std::size_t blocks_come = 0, blocks_go = 0;
  for (const SceneChange& change : scene.changes) {
    if (change.count != 60) continue;
    const Vec3 place = scene.bodies[change.first].def.position;
    ++(change.creates ? blocks_come : blocks_go);
    EXPECT_EQ(scene.bodies[change.first].def.type, BodyType::fixed);
    EXPECT_EQ(change.step % 60, 59);
    const float second = static_cast<float>(change.step / 60);
    EXPECT_EQ(place.x, 10.0f * (change.creates ? second + 5.0f : second));
  }
  EXPECT_EQ(blocks_come, 10u);
  EXPECT_EQ(blocks_go, 10u);
}

TEST(ChangingScenes, SpawnedBodiesDoNotOverlapEarlierOnes) {
  const Scene scene = build_one("spawning", {{"bodies", 20}});
  World world(scene.settings);
  Workers workers(1);
  std::vector<BodyId> bodies = populate(world, scene);
  for (int i = 0; i < 60; ++i) {
    direct(world, scene, bodies, i, scene.dt);
    step(world, 0.0f, workers);  // collides only
    EXPECT_EQ(world.stats().contacts, 0) << "bodies in the air touch no other when they arrive, step " << i;
    if (world.stats().contacts > 0) break;
    if (i >= 20) break;
    step(world, scene.dt, workers);
  }
}

}  // namespace
}  // namespace scree::scenes
