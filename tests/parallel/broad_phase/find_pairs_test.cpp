// Laws of find_pairs: the list against brute force, its order, its memory of the last list, and kept rows.
#include <tests/parallel/broad_phase/pair_lists.h>

#include <gtest/gtest.h>
#include <parallel/broad_phase/broad_phase.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>

namespace scree {
namespace {

using testing::add_random_body;
using testing::brute_force;
using testing::expect_canonical;
using testing::Follower;
using testing::HandMadeWorld;
using testing::kPairStep;
using testing::listed;
using testing::Pair;
using testing::Random;
using testing::random_filter;
using testing::step;

TEST(FindPairs, ListEqualsBruteForceForEveryInstructionSet) {
  for (const WorkersOptions& options : testing::all_workers()) {
    Workers workers(options);
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      HandMadeWorld world;
      Random random(seed);
      world.add_box(BodyType::fixed, {0, -5, 0}, {400, 1, 400});
      const int bodies = seed == 1 ? 3 : 200 * static_cast<int>(seed);
      for (int i = 0; i < bodies; ++i) {
        const std::uint32_t kind = random.below(8);
        const BodyType type = kind == 0   ? BodyType::fixed
                              : kind == 1 ? BodyType::kinematic
                                          : BodyType::dynamic;
        add_random_body(world, random, type, {4, 4, 4}, 2.0f, 1 + static_cast<int>(random.below(3)) / 2,
                        random_filter(random));
      }
      Follower follower;
      for (int i = 0; i < 40; ++i) {
        {
          Crew crew(workers);
          world.refresh();
          find_pairs(world.data, crew);
        }
        const std::vector<Pair> list = listed(world.data);
        const std::set<Pair> expected = brute_force(world.data);
        expect_canonical(list);
        ASSERT_TRUE(std::equal(list.begin(), list.end(), expected.begin(), expected.end()))
            << list.size() << " " << expected.size();
        EXPECT_EQ(world.data.stats.pairs, static_cast<std::int64_t>(list.size()));
        follower.check_and_move(world.data);
        world.integrate(kPairStep);
        Crew crew(workers);
        update_bounds(world.data, kPairStep, crew);
      }
    }
  }
}

// Blocks of the tree then meet more leaves than a descent collects.
TEST(FindPairs, ListEqualsBruteForceInAWideFieldWithOneShapeThatOverlapsAll) {
  for (const WorkersOptions& options : testing::all_workers()) {
    Workers workers(options);
    HandMadeWorld world;
    Random random(6);
    const auto place = [&] {
      return Vec3{random.uniform(-40, 40), random.uniform(0, 1), random.uniform(-40, 40)};
    };
    for (int i = 0; i < 2500; ++i) {
      const BodyType type = i % 2 == 0 ? BodyType::fixed : BodyType::dynamic;
      world.add_shape(world.add_body(type, place()), ShapeType::sphere, {{0, 0, 0}, 0.3f});
    }
    world.add_box(BodyType::dynamic, {0, -0.5f, 0}, {45, 0.6f, 45});
    for (int i = 0; i < 3; ++i) {
      step(world, workers);
      const std::vector<Pair> list = listed(world.data);
      const std::set<Pair> expected = brute_force(world.data);
      EXPECT_GT(expected.size(), 1500u);
      expect_canonical(list);
      ASSERT_TRUE(std::equal(list.begin(), list.end(), expected.begin(), expected.end()))
          << list.size() << " " << expected.size();
      // The dynamic shapes go far apart, so that the boxes of most shapes of a block do not overlap.
      for (std::int32_t body = kFirstBody; body < kFirstBody + 2500; ++body) {
        if (world.data.bodies.type[static_cast<std::size_t>(body)] == BodyType::dynamic)
          world.move_by_call(body, place());
      }
    }
  }
}

TEST(FindPairs, HistoryFollowsPairsThroughBirthAndDeath) {
  for (const WorkersOptions& options : testing::all_workers()) {
    Workers workers(options);
    HandMadeWorld world;
    Random random(5);
    Follower follower;
    std::vector<std::int32_t> bodies;
    int kept = 0;
    for (int i = 0; i < 100; ++i) {
      const std::uint32_t births = i % 10 == 0 ? 60 : random.below(4);
      for (std::uint32_t k = 0; k < births; ++k) {
        bodies.push_back(add_random_body(world, random, BodyType::dynamic, {4, 4, 4}, 1.0f));
        follower.forget(world.data.bodies.first_shape[static_cast<std::size_t>(bodies.back())]);
      }
      for (std::uint32_t k = random.below(3); k > 0 && !bodies.empty(); --k) {
        const std::size_t victim = random.below(static_cast<std::uint32_t>(bodies.size()));
        world.destroy_body(bodies[victim]);
        bodies.erase(bodies.begin() + static_cast<std::ptrdiff_t>(victim));
      }
      if (!bodies.empty() && i % 3 == 0) world.move_by_call(bodies.front(), random.point({4, 4, 4}));
      step(world, workers);
      const std::vector<Pair> list = listed(world.data);
      expect_canonical(list);
      kept += follower.check_and_move(world.data);
    }
    EXPECT_GT(kept, 1000);
  }
}

// True boxes and spheres, each grown by half the speculative distance.
TEST(FindPairs, NoPairWithinTheSpeculativeDistanceIsMissed) {
  Workers workers(1);
  for (const float speed : {0.3f, 1.0f, 20.0f}) {
    HandMadeWorld world;
    Random random(9);
    for (int i = 0; i < 300; ++i) add_random_body(world, random, BodyType::dynamic, {5, 5, 5}, speed);
    int kept = 0;
    for (int i = 0; i < 60; ++i) {
      {
        Crew crew(workers);
        world.refresh();
        find_pairs(world.data, crew);
      }
      kept += world.data.contacts.list_kept ? 1 : 0;
      std::set<Pair> list;
      for (const Pair& pair : listed(world.data)) list.insert(pair);
      const Shapes& shapes = world.data.shapes;
      for (std::int32_t a = 0; a < 300; ++a) {
        for (std::int32_t b = a + 1; b < 300; ++b) {
          const std::int32_t index[2] = {a, b};
          double center[2][3], half[2][3], radius[2];
          for (int side = 0; side < 2; ++side) {
            const auto s = static_cast<std::size_t>(index[side]);
            const PoseRow& pose = world.data.bodies.pose[static_cast<std::size_t>(shapes.body[s])];
            const ExtentRow& e = shapes.extent[s];
            const Quat q{pose.rotation[0], pose.rotation[1], pose.rotation[2], pose.rotation[3]};
            const Vec3 x = rotate(q, {1, 0, 0}), y = rotate(q, {0, 1, 0}), z = rotate(q, {0, 0, 1});
            const float columns[3][3] = {{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
            double square = 0;
            for (int axis = 0; axis < 3; ++axis) {
              center[side][axis] = pose.position[axis];
              half[side][axis] = e.radius + 0.5 * kSpeculativeDistance;
              for (int k = 0; k < 3; ++k) half[side][axis] += std::abs(columns[axis][k]) * double{e.half[k]};
              square += double{e.half[axis]} * e.half[axis];
            }
            radius[side] = std::sqrt(square) + e.radius + 0.5 * kSpeculativeDistance;
          }
          bool meet = true;
          double distance = 0;
          for (int axis = 0; axis < 3; ++axis) {
            const double offset = std::abs(center[0][axis] - center[1][axis]);
            meet = meet && offset <= half[0][axis] + half[1][axis];
            distance += offset * offset;
          }
          if (meet && std::sqrt(distance) <= radius[0] + radius[1]) {
            EXPECT_TRUE(list.contains({a, b}));
          }
        }
      }
      world.integrate(kPairStep);
      Crew crew(workers);
      update_bounds(world.data, kPairStep, crew);
    }
    if (speed < 0.5f) {
      EXPECT_GT(kept, 0);
    }
  }
}

TEST(FindPairs, ListIsKeptWhileEveryShapeStaysInItsFatBounds) {
  Workers workers(1);
  HandMadeWorld world;
  Random random(2);
  for (int i = 0; i < 100; ++i) add_random_body(world, random, BodyType::dynamic, {3, 3, 3}, 0.0f);
  step(world, workers);
  EXPECT_FALSE(world.data.contacts.list_kept);
  const std::vector<Pair> first = listed(world.data);
  for (int i = 0; i < 20; ++i) {
    step(world, workers);
    EXPECT_TRUE(world.data.contacts.list_kept);
    EXPECT_EQ(listed(world.data), first);
  }
  world.add_sphere(BodyType::dynamic, {0, 0, 0}, 1.0f);
  step(world, workers);
  EXPECT_FALSE(world.data.contacts.list_kept);
  EXPECT_GT(listed(world.data).size(), first.size());
}

TEST(FindPairs, AnUnchangedListIsKept) {
  Workers workers(1);
  HandMadeWorld world;
  world.add_box(BodyType::fixed, {0, -1, 0}, {10, 1, 10});
  world.add_sphere(BodyType::dynamic, {0, 0.5f, 0}, 0.5f);
  world.add_sphere(BodyType::dynamic, {0, 50, 0}, 0.5f);
  world.data.bodies.velocity[kFirstBody + 2].linear[1] = 20.0f;  // leaves its bounds in every step
  step(world, workers);
  EXPECT_EQ(listed(world.data), (std::vector<Pair>{{0, 1}}));
  for (int i = 0; i < 5; ++i) {
    step(world, workers);
    EXPECT_TRUE(world.data.contacts.list_kept);
  }
}

TEST(FindPairs, FiltersDecideBothWays) {
  Workers workers(1);
  const auto pairs = [&](Filter x, Filter y) {
    HandMadeWorld world;
    world.add_sphere(BodyType::dynamic, {0, 0, 0}, 0.5f, x);
    world.add_sphere(BodyType::dynamic, {0.5f, 0, 0}, 0.5f, y);
    step(world, workers);
    return listed(world.data).size();
  };
  EXPECT_EQ(pairs({}, {}), 1u);
  EXPECT_EQ(pairs({.category = 2}, {.mask = 2}), 1u);
  EXPECT_EQ(pairs({.category = 2}, {.mask = 4}), 0u);
  EXPECT_EQ(pairs({.mask = 0}, {}), 0u);
  EXPECT_EQ(pairs({.group = -3}, {.group = -3}), 0u);
  EXPECT_EQ(pairs({.group = -3}, {.group = -4}), 1u);
  EXPECT_EQ(pairs({.mask = 0, .group = 3}, {.mask = 0, .group = 3}), 1u);
  EXPECT_EQ(pairs({.mask = 0, .group = 3}, {.mask = 0, .group = 2}), 0u);
}

TEST(FindPairs, AChangedFilterCountsInTheNextStep) {
  Workers workers(1);
  HandMadeWorld world;
  world.add_sphere(BodyType::dynamic, {0, 0, 0}, 0.5f);
  world.add_sphere(BodyType::dynamic, {0.5f, 0, 0}, 0.5f);
  step(world, workers);
  EXPECT_EQ(listed(world.data).size(), 1u);
  world.data.shapes.filter[0].mask = 0;
  world.data.contacts.pairs_stale = true;
  step(world, workers);
  EXPECT_TRUE(listed(world.data).empty());
}

TEST(FindPairs, ShapesOfOneBodyAndOfTwoBodiesThatCannotBePushedAreNotPaired) {
  Workers workers(1);
  HandMadeWorld world;
  const std::int32_t body = world.add_body(BodyType::dynamic, {0, 0, 0});
  for (int i = 0; i < 3; ++i) world.add_shape(body, ShapeType::sphere, {{0, 0, 0}, 0.5f});
  step(world, workers);
  EXPECT_TRUE(listed(world.data).empty());
  world.add_sphere(BodyType::kinematic, {50, 0, 0}, 0.5f);  // shapes 3 and 4
  world.add_sphere(BodyType::fixed, {50, 0, 0}, 0.5f);
  world.add_sphere(BodyType::kinematic, {50, 0, 0}, 0.5f);
  step(world, workers);
  EXPECT_TRUE(listed(world.data).empty());
}

TEST(FindPairs, RowsOfSleepingPairsSurvive) {
  for (const WorkersOptions& options : testing::all_workers()) {
    Workers workers(options);
    HandMadeWorld world;
    Random random(4);
    world.add_box(BodyType::fixed, {0, -5, 0}, {100, 1, 100});
    std::vector<std::int32_t> bodies;
    for (int i = 0; i < 200; ++i) {
      bodies.push_back(add_random_body(world, random, BodyType::dynamic, {4, 4, 4}, 0.0f));
    }
    Follower follower;
    step(world, workers);
    follower.check_and_move(world.data);
    const std::vector<Pair> all = listed(world.data);
    for (const std::int32_t body : bodies) world.set_asleep(body, true);
    step(world, workers);
    EXPECT_EQ(listed(world.data), all);
    EXPECT_TRUE(world.data.contacts.pairs.pair.empty()) << "all of them rest";
    EXPECT_EQ(follower.check_and_move(world.data), static_cast<int>(all.size()));

    // Some bodies wake, a ball flies by, some fall asleep again: sleeping pairs keep their rows, the ball's
    // pairs come and go.
    const std::int32_t ball = world.add_sphere(BodyType::dynamic, {-9, 0, 0}, 0.4f);
    world.data.bodies
        .velocity[static_cast<std::size_t>(world.data.shapes.body[static_cast<std::size_t>(ball)])]
        .linear[0] = 20.0f;
    std::size_t most = 0;
    for (int i = 0; i < 60; ++i) {
      for (int k = 0; k < 10; ++k) {
        world.set_asleep(bodies[random.below(static_cast<std::uint32_t>(bodies.size()))],
                         random.below(2) == 0);
      }
      step(world, workers);
      const std::vector<Pair> list = listed(world.data);
      EXPECT_TRUE(std::includes(list.begin(), list.end(), all.begin(), all.end()));
      EXPECT_GE(follower.check_and_move(world.data), static_cast<int>(all.size()));
      most = std::max(most, list.size());
    }
    EXPECT_GT(most, all.size());
    EXPECT_EQ(listed(world.data), all);
  }
}

TEST(FindPairs, ASleepingShapeThatACallMovesAwayLosesItsRows) {
  Workers workers(1);
  HandMadeWorld world;
  world.add_sphere(BodyType::dynamic, {0, 0, 0}, 0.5f);
  world.add_sphere(BodyType::dynamic, {0.9f, 0, 0}, 0.5f);
  world.add_sphere(BodyType::dynamic, {1.8f, 0, 0}, 0.5f);
  step(world, workers);
  for (std::int32_t body = kFirstBody; body < kFirstBody + 3; ++body) world.set_asleep(body, true);
  step(world, workers);
  EXPECT_EQ(listed(world.data), (std::vector<Pair>{{0, 1}, {1, 2}}));
  world.move_by_call(kFirstBody, {-20, 0, 0});
  step(world, workers);
  EXPECT_EQ(listed(world.data), (std::vector<Pair>{{1, 2}}));
}

TEST(FindPairs, SleepingBodiesArePairedWithKinematicAndNewFixedBodies) {
  Workers workers(1);
  HandMadeWorld world;
  world.add_sphere(BodyType::dynamic, {0, 0, 0}, 0.5f);
  world.add_sphere(BodyType::kinematic, {0.9f, 0, 0}, 0.5f);
  world.add_sphere(BodyType::fixed, {0.9f, 0.5f, 0}, 0.5f);
  world.set_asleep(kFirstBody, true);
  step(world, workers);
  EXPECT_EQ(listed(world.data), (std::vector<Pair>{{0, 1}, {0, 2}}));
}

TEST(FindPairs, AReusedSlotHasNoHistory) {
  Workers workers(1);
  HandMadeWorld world;
  Follower follower;
  world.add_sphere(BodyType::dynamic, {0, 0, 0}, 0.5f);
  const std::int32_t shape = world.add_sphere(BodyType::dynamic, {0.5f, 0, 0}, 0.5f);
  step(world, workers);
  follower.check_and_move(world.data);
  world.destroy_body(kFirstBody + 1);
  EXPECT_EQ(world.add_sphere(BodyType::dynamic, {0.5f, 0, 0}, 0.5f), shape);
  follower.forget(shape);
  step(world, workers);
  EXPECT_EQ(listed(world.data).size(), 1u);
  EXPECT_EQ(follower.check_and_move(world.data), 0);
  step(world, workers);
  EXPECT_EQ(follower.check_and_move(world.data), 1);
}

TEST(FindPairs, BodiesWithoutFinitePosesHaveNoPairs) {
  for (const WorkersOptions& options : testing::all_workers()) {
    Workers workers(options);
    HandMadeWorld world;
    Random random(6);
    for (int i = 0; i < 100; ++i) add_random_body(world, random, BodyType::dynamic, {2, 2, 2}, 0.5f);
    step(world, workers);
    const float values[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                            1e30f};
    for (std::size_t i = 0; i < 30; ++i) {
      world.data.bodies.pose[kFirstBody + i].position[i % 3] = values[i % 3];
      world.data.bodies.velocity[kFirstBody + i].angular[0] = values[(i + 1) % 3];
    }
    for (int i = 0; i < 20; ++i) step(world, workers);
    for (const Pair& pair : listed(world.data)) EXPECT_GE(pair.first, 30);
    EXPECT_FALSE(listed(world.data).empty());
  }
}

TEST(FindPairs, EmptyWorldsAndLoneBodiesHaveNoPairs) {
  Workers workers(1);
  HandMadeWorld world;
  for (int i = 0; i < 3; ++i) step(world, workers);
  EXPECT_TRUE(listed(world.data).empty());
  world.add_sphere(BodyType::dynamic, {0, 0, 0}, 0.5f);
  for (int i = 0; i < 3; ++i) step(world, workers);
  EXPECT_TRUE(listed(world.data).empty());
  world.destroy_body(kFirstBody);
  for (int i = 0; i < 3; ++i) step(world, workers);
  EXPECT_TRUE(listed(world.data).empty());
}

TEST(FindPairs, ManyBodiesAtOnePlaceAreAllPairs) {
  Workers workers(WorkersOptions{.threads = 2});
  HandMadeWorld world;
  for (int i = 0; i < 500; ++i) world.add_sphere(BodyType::dynamic, {1, 2, 3}, 0.5f);
  step(world, workers);
  expect_canonical(listed(world.data));
  EXPECT_EQ(listed(world.data).size(), 500u * 499u / 2u);
}

// Rows of an owner that the kernel ranks, that one thread sorts, and that all do; then there are shapes for
// three levels of nodes.
TEST(FindPairs, AWideGroundIsPairedWithAllShapesOnIt) {
  for (const WorkersOptions& options : testing::all_workers()) {
    Workers workers(options);
    for (const int side : {15, 17, 45, 50, 90}) {
      HandMadeWorld world;
      world.add_box(BodyType::fixed, {0, -1, 0}, {400, 1, 400});
      for (int x = 0; x < side; ++x) {
        for (int z = 0; z < side; ++z) {
          world.add_sphere(BodyType::dynamic, {2.0f * float(x), 0.5f, 2.0f * float(z)}, 0.5f);
        }
      }
      step(world, workers);
      const std::vector<Pair> list = listed(world.data);
      ASSERT_EQ(list.size(), static_cast<std::size_t>(side * side));
      for (std::size_t i = 0; i < list.size(); ++i)
        EXPECT_EQ(list[i], Pair(0, static_cast<std::int32_t>(i) + 1));
    }
  }
}

TEST(FindPairs, ABodyFarFromAllOthersDoesNotSpoilTheOrder) {
  Workers workers(1);
  HandMadeWorld world;
  Random random(8);
  for (int i = 0; i < 2000; ++i) add_random_body(world, random, BodyType::dynamic, {10, 10, 10}, 0.0f);
  world.add_sphere(BodyType::dynamic, {0, -1e7f, 0}, 0.5f);
  step(world, workers);
  // Leaf blocks of 16 neighbors are small; in one cell they would span the whole pile.
  const PairTree& tree = broad_phase_of(world.data).trees[static_cast<int>(TreeKind::awake)];
  double mean = 0.0;
  for (int block = 0; block < leaf_blocks(tree) - 1; ++block) {
    const simd::NodeBlock& node = tree.nodes[0][static_cast<std::size_t>(block / simd::kBlock)];
    mean += node.bounds[3][block % simd::kBlock] - node.bounds[0][block % simd::kBlock];
  }
  EXPECT_LT(mean / (leaf_blocks(tree) - 1), 10.0);
}

}  // namespace
}  // namespace scree
