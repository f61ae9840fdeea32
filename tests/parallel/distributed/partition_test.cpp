// Laws of recursive coordinate bisection.
#include <gtest/gtest.h>
#include <parallel/distributed/partition.h>
#include <tests/parallel/distributed/local_ranks.h>
#include <tests/physics/lab.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace scree {
namespace {

using distributed_tests::all_of;
using distributed_tests::run_ranks;

std::vector<WeightedPoint> random_points(int count, std::uint64_t seed) {
  physics::Random random(seed);
  std::vector<WeightedPoint> points;
  for (int i = 0; i < count; ++i) {
    const float far = i % 50 == 0 ? 100.0f : 1.0f;
    points.push_back({{far * random.uniform(-5, 5), random.uniform(0, 1), far * random.uniform(-3, 3)},
                      1 + static_cast<std::int32_t>(random.uniform(0, 9))});
  }
  return points;
}

// Each rank has every point whose place it draws.
std::vector<Partition> cut(const std::vector<WeightedPoint>& points, int ranks, std::uint64_t seed) {
  std::vector<Partition> partitions(static_cast<std::size_t>(ranks));
  const auto errors = run_ranks(ranks, [&](int rank, Transport& transport) {
    physics::Random random(seed);
    std::vector<WeightedPoint> own;
    for (const WeightedPoint& point : points) {
      if (static_cast<int>(random.uniform(0, static_cast<float>(ranks) - 1e-4f)) == rank)
        own.push_back(point);
    }
    partitions[static_cast<std::size_t>(rank)] = cut_space(transport, own);
  });
  EXPECT_EQ(all_of(errors), "");
  return partitions;
}

std::vector<std::int64_t> weights_of(const Partition& partition, const std::vector<WeightedPoint>& points) {
  std::vector<std::int64_t> weights(partition.cuts.size(), 0);
  for (const WeightedPoint& point : points)
    weights[static_cast<std::size_t>(partition.rank_of(point.position))] += point.weight;
  return weights;
}

TEST(Partition, GivesAllRanksTheSameWeight) {
  const std::vector<WeightedPoint> points = random_points(4000, 3);
  std::int64_t all = 0;
  for (const WeightedPoint& point : points) all += point.weight;
  for (const int ranks : {1, 2, 3, 5, 8, 13}) {
    const Partition partition = cut(points, ranks, 1).front();
    for (const std::int64_t weight : weights_of(partition, points)) {
      EXPECT_NEAR(static_cast<double>(weight), static_cast<double>(all) / ranks, 40.0) << ranks << " ranks";
    }
  }
}

TEST(Partition, DoesNotDependOnWhoHasWhichPoint) {
  std::vector<WeightedPoint> points = random_points(500, 8);
  for (WeightedPoint& point : points) point.position[0] *= 8.0f;  // the longest axis of each part
  const std::vector<Partition> one = cut(points, 6, 1), other = cut(points, 6, 2);
  for (const std::vector<Partition>* partitions : {&one, &other}) {
    for (const Partition& partition : *partitions) {
      for (std::size_t i = 1; i < partition.cuts.size(); ++i) {
        EXPECT_EQ(partition.cuts[i].axis, one[0].cuts[i].axis);
        EXPECT_EQ(partition.cuts[i].at, one[0].cuts[i].at);
      }
    }
  }
}

TEST(Partition, EachPointLiesInTheBoxOfItsRankAlone) {
  const Partition partition = cut(random_points(300, 5), 7, 1).front();
  for (const WeightedPoint& point : random_points(1000, 6)) {
    const std::int32_t rank = partition.rank_of(point.position);
    for (std::int32_t other = 0; other < 7; ++other) {
      const PartitionBox box = box_of(partition, other);
      bool inside = true;
      for (int axis = 0; axis < 3; ++axis)
        inside = inside && box.lower[axis] <= point.position[axis] && point.position[axis] < box.upper[axis];
      EXPECT_EQ(inside, other == rank);
    }
  }
}

// Bodies that have fallen off the world do not turn the cuts: a flat pile is never cut in layers, which would
// have most of its bodies at borders.
TEST(Partition, StraysDecideAboutNoAxis) {
  for (const int strays : {0, 1, 30}) {
    for (const float depth : {-300.0f, -20000.0f, -1e9f}) {
      physics::Random random(11);
      std::vector<WeightedPoint> points;
      for (int i = 0; i < 5000; ++i)
        points.push_back({{random.uniform(-45, 45), random.uniform(0, 5), random.uniform(-20, 20)}, 3});
      for (int i = 0; i < strays; ++i)
        points.push_back({{40.0f, depth * random.uniform(0.1f, 1.0f), static_cast<float>(i)}, 3});
      const Partition partition = cut(points, 4, 1).front();
      for (std::size_t i = 1; i < partition.cuts.size(); ++i) EXPECT_NE(partition.cuts[i].axis, 1);
      EXPECT_EQ(partition.cuts[2].axis, 0);
      for (const std::int64_t weight : weights_of(partition, points))
        EXPECT_NEAR(static_cast<double>(weight), 0.25 * 3.0 * static_cast<double>(points.size()), 40.0);
    }
  }
}

// Nor do they keep a cut from being fine enough, however far out they are.
TEST(Partition, StraysAlongACutLeaveTheLoadsEven) {
  for (const float far : {1e5f, 1e9f, 1e20f, 3e38f}) {
    physics::Random random(12);
    std::vector<WeightedPoint> points;
    for (int i = 0; i < 5000; ++i)
      points.push_back({{random.uniform(-45, 45), random.uniform(0, 5), random.uniform(-5, 5)}, 3});
    for (int i = 0; i < 8; ++i) points.push_back({{i % 2 == 0 ? far : -far, 1, 0}, 3});
    const Partition partition = cut(points, 4, 1).front();
    for (const std::int64_t weight : weights_of(partition, points))
      EXPECT_NEAR(static_cast<double>(weight), 0.25 * 3.0 * static_cast<double>(points.size()), 60.0) << far;
  }
}

TEST(Partition, TakesPointsInOnePlaceAndNoPoints) {
  const std::vector<WeightedPoint> same(100, WeightedPoint{{1, 2, 3}, 4});
  const std::vector<std::int64_t> weights = weights_of(cut(same, 4, 1).front(), same);
  EXPECT_EQ(*std::max_element(weights.begin(), weights.end()), 400);
  const Partition none = cut({}, 4, 1).front();
  const float origin[3] = {0, 0, 0};
  const std::int32_t rank = none.rank_of(origin);
  EXPECT_GE(rank, 0);
  EXPECT_LT(rank, 4);
}

}  // namespace
}  // namespace scree
