// Islands: who sleeps and wakes together.
#include <tests/physics/lab.h>

#include <algorithm>

namespace scree {
namespace {

using physics::Lab;

struct Row {
  explicit Row(int stacks) : lab(WorldSettings{}) {
    lab.add_ground({}, {}, 500.0f);
    for (int i = 0; i < stacks; ++i) {
      for (int k = 0; k < 3; ++k) {
        bodies.push_back(
            lab.add({.position = {4.0f * static_cast<float>(i), 0.5f + static_cast<float>(k), 0}}, Box{}));
      }
    }
  }
  std::size_t awake() const {
    return static_cast<std::size_t>(
        std::count_if(bodies.begin(), bodies.end(), [&](BodyId body) { return lab.world.is_awake(body); }));
  }
  Lab lab;
  std::vector<BodyId> bodies;
};

TEST(Islands, FixedGroundDoesNotJoinThem) {
  Row row(10);
  std::int64_t islands = 0;
  for (int i = 0; i < 240; ++i) {
    row.lab.run(1);
    islands = std::max(islands, row.lab.world.stats().islands);
  }
  EXPECT_EQ(islands, 10);
  EXPECT_EQ(row.awake(), 0u);
}

TEST(Islands, WakingOneBodyWakesItsIslandOnly) {
  Row row(5);
  row.lab.run(240);
  ASSERT_EQ(row.awake(), 0u);
  row.lab.world.wake(row.bodies[4]);
  row.lab.run(1);
  EXPECT_EQ(row.awake(), 3u);
  for (const std::size_t index : {3u, 4u, 5u}) EXPECT_TRUE(row.lab.world.is_awake(row.bodies[index]));
}

TEST(Islands, AChainOfStacksIsOneIsland) {
  // Planks from stack to stack join them.
  Row row(5);
  std::vector<BodyId> planks;
  for (int i = 0; i < 4; ++i) {
    planks.push_back(
        row.lab.add({.position = {4.0f * static_cast<float>(i) + 2.0f, 3.1f, i % 2 == 0 ? 0.25f : -0.25f}},
                    Box{{2.2f, 0.1f, 0.2f}}));
  }
  row.lab.run(400);
  ASSERT_EQ(row.awake(), 0u);
  row.lab.world.wake(row.bodies[0]);
  row.lab.run(1);
  EXPECT_EQ(row.awake(), row.bodies.size());
  for (const BodyId plank : planks) EXPECT_TRUE(row.lab.world.is_awake(plank));
}

TEST(Islands, SleepTheSameForAnyThreadCount) {
  std::vector<std::uint64_t> hashes;
  for (const int threads : {1, 2, 4}) {
    Row row(30);
    row.lab.workers = Workers(threads);
    row.lab.run(100);
    row.lab.world.add_impulse(row.bodies[7], {300.0f, 0, 0});
    row.lab.run(200);
    hashes.push_back(row.lab.world.hash());
  }
  EXPECT_EQ(hashes[1], hashes[0]);
  EXPECT_EQ(hashes[2], hashes[0]);
}

}  // namespace
}  // namespace scree
