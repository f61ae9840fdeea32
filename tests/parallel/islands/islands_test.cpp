// Islands: the bodies that sleep and wake together.
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

// Balls at random places of a lattice, each as wide as a cell: neighbors touch and nothing moves. Filled near
// the percolation threshold, so that islands are of every size.
class Lattice {
 public:
  static constexpr int kSide = 24;  // some 5000 balls and 5000 contacts: several chunks of each

  explicit Lattice(int threads) : lab_(WorldSettings{.gravity = {}, .sleep_time = 0.05f}) {
    lab_.workers = Workers(threads);
    physics::Random random(5);
    for (int i = 0; i < kSide * kSide * kSide; ++i) {
      filled_.push_back(random.uniform(0.0f, 1.0f) < 0.36f);
      if (!filled_.back()) continue;
      const Vec3 place{static_cast<float>(i % kSide), static_cast<float>(i / kSide % kSide),
                       static_cast<float>(i / kSide / kSide)};
      bodies_.push_back(lab_.add({.position = place}, Sphere{0.5f}));
      cells_.push_back(i);
    }
  }

  // Counted by flood fill.
  std::int64_t components() const {
    std::vector<bool> open = filled_;
    std::int64_t count = 0;
    std::vector<int> front;
    for (const int cell : cells_) {
      if (!open[static_cast<std::size_t>(cell)]) continue;
      ++count;
      front = {cell};
      open[static_cast<std::size_t>(cell)] = false;
      while (!front.empty()) {
        const int at = front.back();
        front.pop_back();
        for (const int next : neighbors(at)) {
          if (!open[static_cast<std::size_t>(next)]) continue;
          open[static_cast<std::size_t>(next)] = false;
          front.push_back(next);
        }
      }
    }
    return count;
  }

  // The largest number of islands that a step examines until all sleep.
  std::int64_t fall_asleep() {
    std::int64_t islands = 0;
    for (int i = 0; i < 20; ++i) {
      lab_.run(1);
      islands = std::max(islands, lab_.world.stats().islands);
    }
    return islands;
  }

  // The cells of the awake bodies.
  std::vector<int> awake() const {
    std::vector<int> cells;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (lab_.world.is_awake(bodies_[i])) cells.push_back(cells_[i]);
    }
    return cells;
  }

  Lab& lab() { return lab_; }
  const std::vector<BodyId>& bodies() const { return bodies_; }

 private:
  static std::vector<int> neighbors(int cell) {
    std::vector<int> result;
    for (const int stride : {1, kSide, kSide * kSide}) {
      const int place = cell / stride % kSide;
      if (place > 0) result.push_back(cell - stride);
      if (place + 1 < kSide) result.push_back(cell + stride);
    }
    return result;
  }

  Lab lab_;
  std::vector<bool> filled_;
  std::vector<BodyId> bodies_;
  std::vector<int> cells_;
};

TEST(Islands, AreTheConnectedComponentsOfTheContacts) {
  std::vector<std::vector<int>> woken;
  for (const int threads : {1, 2, 4}) {
    Lattice lattice(threads);
    EXPECT_EQ(lattice.fall_asleep(), lattice.components()) << threads << " threads";
    EXPECT_TRUE(lattice.awake().empty());
    for (std::size_t i = 0; i < lattice.bodies().size(); i += 97)
      lattice.lab().world.wake(lattice.bodies()[i]);
    lattice.lab().run(1);
    woken.push_back(lattice.awake());
  }
  EXPECT_GT(woken[0].size(), 100u);
  EXPECT_EQ(woken[1], woken[0]);
  EXPECT_EQ(woken[2], woken[0]);
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
