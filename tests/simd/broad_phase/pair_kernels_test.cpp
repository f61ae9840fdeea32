// The kernels of the broad phase by themselves, against all pairs one by one in scalar code.
// tests/parallel/broad_phase has the laws of bounds and pairs of whole worlds.
#include <core/plain/rows.h>
#include <simd/dispatch/kernels.h>
#include <tests/simd/all_kernels.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

namespace scree::kernel_tests {
namespace {

using simd::kBlock;

constexpr float kLargestFloat = std::numeric_limits<float>::max();
constexpr float kFarthest = 1e18f;  // m; bounds reach no farther than this
constexpr ShapePair kUnwritten{-7, -7};

// Shape counts around the width of a block, and trees of one, two and three levels.
constexpr int kCounts[] = {1, 2, 15, 16, 17, 31, 33, 255, 256, 257, 700, 4200};

struct PairNumbers {
  std::mt19937 engine;
  explicit PairNumbers(unsigned seed) : engine(seed) {}
  int pick(int count) { return std::uniform_int_distribution<int>(0, count - 1)(engine); }
  float between(float low, float high) { return std::uniform_real_distribution<float>(low, high)(engine); }
};

// --- boxes ---

BoundsRow box_of(const float (&center)[3], const float (&half)[3], float radius) {
  BoundsRow row{};
  for (int axis = 0; axis < 3; ++axis) {
    row.lower[axis] = center[axis] - half[axis];
    row.upper[axis] = center[axis] + half[axis];
  }
  row.sphere_radius = radius;
  return row;
}

// As update_bounds makes them of shapes without finite bounds.
BoundsRow empty_box() {
  return {{kLargestFloat, kLargestFloat, kLargestFloat},
          0.0f,
          {-kLargestFloat, -kLargestFloat, -kLargestFloat},
          0.0f};
}

// Small boxes in space that a shape shares with about ten others; on a grid of whole numbers many touch
// without overlapping. One of forty is empty, huge, or as wide as all others together.
std::vector<BoundsRow> random_boxes(int count, bool on_grid, unsigned seed) {
  PairNumbers numbers(seed);
  const float reach = 1.0f + std::cbrt(static_cast<float>(count));
  std::vector<BoundsRow> rows;
  for (int i = 0; i < count; ++i) {
    float center[3], half[3];
    for (int axis = 0; axis < 3; ++axis) {
      center[axis] = numbers.between(-reach, reach);
      half[axis] = numbers.between(0.2f, 1.5f);
      if (!on_grid) continue;
      center[axis] = std::round(center[axis]);
      half[axis] = std::ceil(half[axis]);
    }
    float radius = numbers.between(0.5f, 1.7f) * std::hypot(half[0], half[1], half[2]);
    if (on_grid) radius = std::round(radius);
    const int kind = numbers.pick(160);
    if (kind == 0) {
      rows.push_back(empty_box());
      continue;
    }
    if (kind == 1) std::fill(half, half + 3, radius = 0.25f * kFarthest);
    if (kind == 2) half[0] = half[2] = radius = 2.0f * reach;
    if (kind == 3) center[1] = 0.5f * kFarthest;
    rows.push_back(box_of(center, half, radius));
  }
  return rows;
}

bool boxes_overlap(const BoundsRow& a, const BoundsRow& b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(a.lower[axis] <= b.upper[axis] && b.lower[axis] <= a.upper[axis])) return false;
  }
  return true;
}
bool spheres_overlap(const BoundsRow& a, const BoundsRow& b) {
  float way[3];
  for (int axis = 0; axis < 3; ++axis) {
    way[axis] = (a.lower[axis] + a.upper[axis]) * 0.5f - (b.lower[axis] + b.upper[axis]) * 0.5f;
  }
  const float sum = a.sphere_radius + b.sphere_radius;
  return way[0] * way[0] + way[1] * way[1] + way[2] * way[2] <= sum * sum;
}

// --- trees ---

struct Tree {
  std::vector<std::int32_t> order;  // whole blocks; -1: empty
  std::vector<simd::LeafBlock> leaves;
  std::vector<std::vector<simd::NodeBlock>> nodes;

  int blocks() const { return static_cast<int>(leaves.size()); }
  simd::TreeView view() const {
    simd::TreeView view{};
    view.leaves = leaves.data();
    view.levels = static_cast<int>(nodes.size());
    for (std::size_t level = 0; level < nodes.size(); ++level) view.nodes[level] = nodes[level].data();
    return view;
  }
};

// About one in seven.
bool is_moved(std::int32_t shape) { return shape * 5 % 7 == 3; }

// Every fourth three shapes in a row are of one body.
std::int32_t body_of(std::int32_t shape) { return shape / 3 % 4 == 2 ? shape / 3 : 1'000'000 + shape; }

// Blocks of `members`, with some empty places among them if `gaps`.
Tree make_tree(const std::vector<std::int32_t>& members, bool gaps, const std::vector<BoundsRow>& rows,
               const std::vector<std::uint8_t>& special, const simd::PairKernels& kernels) {
  Tree tree;
  for (const std::int32_t shape : members) {
    if (gaps && shape % 5 == 0) tree.order.push_back(-1);
    tree.order.push_back(shape);
  }
  while (tree.order.size() % kBlock != 0) tree.order.push_back(-1);
  tree.leaves.resize(tree.order.size() / kBlock);
  simd::NodeBlock empty{};
  for (int axis = 0; axis < 3; ++axis) {
    std::fill(empty.bounds[axis], empty.bounds[axis] + kBlock, kLargestFloat);
    std::fill(empty.bounds[axis + 3], empty.bounds[axis + 3] + kBlock, -kLargestFloat);
  }
  std::size_t blocks = tree.leaves.size();
  do {
    blocks = (blocks + kBlock - 1) / kBlock;
    tree.nodes.emplace_back(blocks, empty);
  } while (blocks > 1);
  const simd::RefitTask task{tree.order.data(), rows.data(), tree.leaves.data(), tree.nodes[0].data()};
  const int middle = tree.blocks() / 2;  // in two parts, as threads would
  kernels.refit_leaves(task, middle, tree.blocks());
  kernels.refit_leaves(task, 0, middle);
  for (std::size_t i = 0; i < tree.order.size(); ++i) {
    simd::LeafBlock& leaf = tree.leaves[i / kBlock];
    if (i % kBlock == 0) leaf.special = 0;
    const std::int32_t shape = tree.order[i];
    if (i % kBlock == 0) leaf.moved = 0;
    if (shape >= 0 && is_moved(shape)) leaf.moved |= 1u << (i % kBlock);
    leaf.body[i % kBlock] = shape < 0 ? -1 : body_of(shape);
    if (shape >= 0 && special[static_cast<std::size_t>(shape)] != 0) leaf.special |= 1u << (i % kBlock);
  }
  for (std::size_t level = 1; level < tree.nodes.size(); ++level) {
    kernels.refit_nodes(tree.nodes[level - 1].data(), tree.nodes[level].data(), 0,
                        static_cast<int>(tree.nodes[level - 1].size()));
  }
  return tree;
}

std::vector<std::int32_t> numbered_shapes(int first, int last) {
  std::vector<std::int32_t> shapes(static_cast<std::size_t>(last - first));
  std::iota(shapes.begin(), shapes.end(), first);
  return shapes;
}

TEST(PairKernels, LeavesHoldTheBoundsOfTheirShapesAndNodesTheBoxesOfTheirChildren) {
  for (const simd::Kernels* kernels : all_kernels()) {
    for (const int count : kCounts) {
      const std::vector<BoundsRow> rows = random_boxes(count, false, 1);
      const std::vector<std::uint8_t> special(rows.size());
      const Tree tree = make_tree(numbered_shapes(0, count), true, rows, special, kernels->pair);
      for (std::size_t i = 0; i < tree.order.size(); ++i) {
        const simd::LeafBlock& leaf = tree.leaves[i / kBlock];
        const std::size_t lane = i % kBlock;
        const std::int32_t shape = tree.order[i];
        ASSERT_EQ(leaf.shape[lane], shape);
        const BoundsRow row = shape < 0 ? empty_box() : rows[static_cast<std::size_t>(shape)];
        for (std::size_t axis = 0; axis < 3; ++axis) {
          ASSERT_EQ(leaf.bounds[axis][lane], row.lower[axis]) << kernels->name;
          ASSERT_EQ(leaf.bounds[axis + 3][lane], row.upper[axis]) << kernels->name;
          if (shape >= 0) {
            ASSERT_EQ(leaf.center[axis][lane], (row.lower[axis] + row.upper[axis]) * 0.5f);
          }
        }
        if (shape >= 0) {
          ASSERT_EQ(leaf.radius[lane], row.sphere_radius);
        }
      }
      for (std::size_t level = 0; level < tree.nodes.size(); ++level) {
        const std::size_t children = level == 0 ? tree.leaves.size() : tree.nodes[level - 1].size();
        for (std::size_t child = 0; child < tree.nodes[level].size() * kBlock; ++child) {
          BoundsRow box = empty_box();
          for (std::size_t lane = 0; child < children && lane < kBlock; ++lane) {
            const auto& bounds = level == 0 ? tree.leaves[child].bounds : tree.nodes[level - 1][child].bounds;
            for (std::size_t axis = 0; axis < 3; ++axis) {
              box.lower[axis] = std::min(box.lower[axis], bounds[axis][lane]);
              box.upper[axis] = std::max(box.upper[axis], bounds[axis + 3][lane]);
            }
          }
          for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto& bounds = tree.nodes[level][child / kBlock].bounds;
            ASSERT_EQ(bounds[axis][child % kBlock], box.lower[axis]) << kernels->name << " level " << level;
            ASSERT_EQ(bounds[axis + 3][child % kBlock], box.upper[axis]);
          }
        }
      }
    }
  }
}

TEST(PairKernels, RefitWritesOnlyTheBlocksOfItsRange) {
  constexpr int kShapes = 5 * kBlock;
  const std::vector<BoundsRow> rows = random_boxes(kShapes, false, 2);
  const std::vector<std::int32_t> order = numbered_shapes(0, kShapes);
  for (const simd::Kernels* kernels : all_kernels()) {
    std::vector<simd::LeafBlock> leaves(5);
    std::vector<simd::NodeBlock> nodes(1), parents(1);
    for (simd::LeafBlock& leaf : leaves) std::memset(&leaf, 0x55, sizeof leaf);
    std::memset(nodes.data(), 0x55, sizeof nodes[0]);
    std::memset(parents.data(), 0x55, sizeof parents[0]);
    const auto leaves_before = leaves;
    const auto node_before = nodes[0], parent_before = parents[0];
    kernels->pair.refit_leaves({order.data(), rows.data(), leaves.data(), nodes.data()}, 1, 3);
    kernels->pair.refit_nodes(nodes.data(), parents.data(), 0, 0);
    for (const std::size_t block : {0u, 3u, 4u}) {
      EXPECT_EQ(std::memcmp(&leaves[block], &leaves_before[block], sizeof leaves[block]), 0);
    }
    for (std::size_t side = 0; side < 6; ++side) {
      for (std::size_t lane = 0; lane < kBlock; ++lane) {
        const bool unchanged = nodes[0].bounds[side][lane] == node_before.bounds[side][lane];
        EXPECT_EQ(unchanged, lane != 1 && lane != 2) << kernels->name << " lane " << lane;
      }
    }
    EXPECT_EQ(std::memcmp(parents.data(), &parent_before, sizeof parent_before), 0);
  }
}

// --- joins ---

struct Found {
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs;  // sorted
  bool special = false;
  int of_one_body = 0;  // that overlap; counted by brute force

  bool operator==(const Found& other) const { return pairs == other.pairs && special == other.special; }
};

// Joins as find_pairs does, with room for so many pairs at first, and checks that no row behind it is
// written.
Found join(const Tree& query, const Tree& target, const simd::PairKernels& kernels, std::int64_t room,
           bool moved_only = false, bool spares_moved = false) {
  simd::JoinTask task{};
  task.moved_only = moved_only;
  task.spares_moved = spares_moved;
  task.query = query.leaves.data();
  task.query_boxes = query.nodes[0].data();
  task.target = target.view();
  task.self = &query == &target;
  std::vector<ShapePair> pairs;
  simd::JoinState state{};
  const int end = query.blocks();
  for (int last = -1; state.block < end;) {
    task.capacity = std::max(room, state.needed);
    pairs.resize(static_cast<std::size_t>(state.count));
    pairs.resize(static_cast<std::size_t>(task.capacity) + kBlock, kUnwritten);
    task.pairs = pairs.data();
    kernels.join(task, end, state);
    for (std::size_t i = static_cast<std::size_t>(task.capacity); i < pairs.size(); ++i) {
      EXPECT_EQ(pairs[i].a, kUnwritten.a) << "behind the room for " << task.capacity;
    }
    EXPECT_LE(state.count + (state.block == end ? 0 : kBlock), std::max(task.capacity, state.needed));
    if (state.block < end) {
      EXPECT_GT(state.needed, task.capacity);
    }
    if (state.block == last && state.needed <= task.capacity) {
      ADD_FAILURE() << "no progress";
      break;
    }
    last = state.block;
  }
  Found found;
  for (std::size_t i = 0; i < static_cast<std::size_t>(state.count); ++i) {
    EXPECT_LT(pairs[i].a, pairs[i].b);
    found.pairs.emplace_back(pairs[i].a, pairs[i].b);
  }
  std::sort(found.pairs.begin(), found.pairs.end());
  found.special = state.special;
  return found;
}

Found all_pairs(const std::vector<std::int32_t>& query, const std::vector<std::int32_t>& target,
                const std::vector<BoundsRow>& rows, const std::vector<std::uint8_t>& special) {
  Found found;
  const bool self = &query == &target;
  for (std::size_t i = 0; i < query.size(); ++i) {
    for (std::size_t k = self ? i + 1 : 0; k < target.size(); ++k) {
      const auto a = static_cast<std::size_t>(query[i]), b = static_cast<std::size_t>(target[k]);
      if (!boxes_overlap(rows[a], rows[b]) || !spheres_overlap(rows[a], rows[b])) continue;
      if (body_of(query[i]) == body_of(target[k])) {
        ++found.of_one_body;
        continue;
      }
      found.pairs.push_back(std::minmax({query[i], target[k]}));
      found.special = found.special || special[a] != 0 || special[b] != 0;
    }
  }
  std::sort(found.pairs.begin(), found.pairs.end());
  return found;
}

// A tenth of a percent of the shapes, so that many joins have none.
std::vector<std::uint8_t> few_special(int count, unsigned seed) {
  PairNumbers numbers(seed);
  std::vector<std::uint8_t> special(static_cast<std::size_t>(count));
  for (std::uint8_t& it : special) it = numbers.pick(1000) == 0;
  return special;
}

// Members in random order, so that blocks spread over all of the space: most descents find more leaf blocks
// than they can collect, and each shape descends by itself.
std::vector<std::int32_t> shuffled_shapes(std::vector<std::int32_t> members, unsigned seed) {
  std::mt19937 engine(seed);
  std::shuffle(members.begin(), members.end(), engine);
  return members;
}
// Along one axis, so that a descent leaves most of the tree out.
std::vector<std::int32_t> sorted_along_x(std::vector<std::int32_t> members,
                                         const std::vector<BoundsRow>& rows) {
  std::sort(members.begin(), members.end(), [&](std::int32_t a, std::int32_t b) {
    return std::pair(rows[static_cast<std::size_t>(a)].lower[0], a) <
           std::pair(rows[static_cast<std::size_t>(b)].lower[0], b);
  });
  return members;
}

TEST(PairKernels, AJoinWithItselfFindsEveryPairOnce) {
  std::size_t pairs = 0;
  int specials[2] = {}, of_one_body = 0;
  for (const int count : kCounts) {
    for (const bool on_grid : {false, true}) {
      const auto seed = static_cast<unsigned>(2 * count + on_grid);
      const std::vector<BoundsRow> rows = random_boxes(count, on_grid, seed);
      const std::vector<std::uint8_t> special = few_special(count, seed);
      for (const auto& members : {shuffled_shapes(numbered_shapes(0, count), seed),
                                  sorted_along_x(numbered_shapes(0, count), rows)}) {
        const Found expected = all_pairs(members, members, rows, special);
        for (const simd::Kernels* kernels : all_kernels()) {
          const Tree tree = make_tree(members, on_grid, rows, special, kernels->pair);
          EXPECT_TRUE(join(tree, tree, kernels->pair, 512) == expected) << kernels->name << ' ' << count;
        }
        pairs += expected.pairs.size();
        of_one_body += expected.of_one_body;
        ++specials[expected.special ? 1 : 0];
      }
    }
  }
  EXPECT_GT(pairs, 50'000u);
  EXPECT_GT(of_one_body, 100);
  EXPECT_GT(std::min(specials[0], specials[1]), 3);
}

TEST(PairKernels, AJoinOfTwoTreesFindsThePairsOfTheirShapes) {
  std::size_t pairs = 0;
  for (const int query_count : {1, 16, 17, 300}) {
    for (const int target_count : {1, 15, 16, 33, 257, 4200}) {
      const int count = query_count + target_count;
      const auto seed = static_cast<unsigned>(count);
      const std::vector<BoundsRow> rows = random_boxes(count, target_count % 2 == 0, seed);
      const std::vector<std::uint8_t> special = few_special(count, seed);
      const std::vector<std::int32_t> mixed = shuffled_shapes(numbered_shapes(0, count), seed);
      const std::vector<std::int32_t> query(mixed.begin(), mixed.begin() + query_count);
      const auto target = sorted_along_x({mixed.begin() + query_count, mixed.end()}, rows);
      const Found expected = all_pairs(query, target, rows, special);
      for (const simd::Kernels* kernels : all_kernels()) {
        const Tree a = make_tree(query, true, rows, special, kernels->pair);
        const Tree b = make_tree(target, false, rows, special, kernels->pair);
        EXPECT_TRUE(join(a, b, kernels->pair, 512) == expected) << kernels->name << ' ' << count;
        EXPECT_TRUE(join(b, a, kernels->pair, 512) == expected) << kernels->name << ' ' << count;
      }
      pairs += expected.pairs.size();
    }
  }
  EXPECT_GT(pairs, 10'000u);
}

// Also where each shape descends by itself.
TEST(PairKernels, AJoinOfMovedShapesFindsEachOfTheirPairsOnce) {
  std::size_t pairs = 0;
  const auto without_others = [](Found found, auto&& counts) {
    std::erase_if(found.pairs, [&](const auto& pair) { return !counts(pair); });
    return found.pairs;
  };
  for (const int count : {5, 16, 60, 700, 4200}) {
    const auto seed = static_cast<unsigned>(count);
    const std::vector<BoundsRow> rows = random_boxes(count, count % 2 == 0, seed);
    const std::vector<std::uint8_t> none(rows.size());
    for (const auto& members : {shuffled_shapes(numbered_shapes(0, count), seed),
                                sorted_along_x(numbered_shapes(0, count), rows)}) {
      const auto middle = members.begin() + count / 3;
      const std::vector<std::int32_t> query(members.begin(), middle), target(middle, members.end());
      const auto expected = without_others(all_pairs(members, members, rows, none), [](const auto& pair) {
        return is_moved(pair.first) || is_moved(pair.second);
      });
      const auto expected_of_two =
          without_others(all_pairs(query, target, rows, none), [&](const auto& pair) {
            const bool first_asks = std::find(query.begin(), query.end(), pair.first) != query.end();
            return is_moved(first_asks ? pair.first : pair.second);
          });
      auto expected_of_unmoved = expected_of_two;
      std::erase_if(expected_of_unmoved,
                    [](const auto& pair) { return is_moved(pair.first) && is_moved(pair.second); });
      for (const simd::Kernels* kernels : all_kernels()) {
        const Tree tree = make_tree(members, true, rows, none, kernels->pair);
        EXPECT_TRUE(join(tree, tree, kernels->pair, 512, true).pairs == expected) << kernels->name;
        const Tree a = make_tree(query, false, rows, none, kernels->pair);
        const Tree b = make_tree(target, true, rows, none, kernels->pair);
        EXPECT_TRUE(join(a, b, kernels->pair, 512, true).pairs == expected_of_two) << kernels->name;
        EXPECT_TRUE(join(a, b, kernels->pair, 512, true, true).pairs == expected_of_unmoved) << kernels->name;
      }
      pairs += expected.size();
    }
  }
  EXPECT_GT(pairs, 5'000u);
}

TEST(PairKernels, BoundsThatTouchMakeAPairAndOnesBarelyApartDoNot) {
  for (const simd::Kernels* kernels : all_kernels()) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const float gap : {0.0f, 1.0f}) {
        float center[3] = {1, 1, 1};
        const float half[3] = {0.5f, 0.5f, 0.5f};
        std::vector<BoundsRow> rows{box_of(center, half, 0.75f)};
        center[axis] = 2.0f;
        rows.push_back(box_of(center, half, 0.75f));
        if (gap > 0.0f) rows[1].lower[axis] = std::nextafter(rows[1].lower[axis], 9.0f);
        const Tree tree = make_tree(numbered_shapes(0, 2), false, rows, {0, 0}, kernels->pair);
        EXPECT_EQ(join(tree, tree, kernels->pair, 512).pairs.size(), gap > 0.0f ? 0u : 1u) << kernels->name;
        // The same of spheres.
        rows = {box_of({0, 0, 0}, {9, 9, 9}, 2.0f), box_of({0, 0, 0}, {9, 9, 9}, 3.0f)};
        rows[1].lower[axis] += 5.0f;
        rows[1].upper[axis] += 5.0f;
        if (gap > 0.0f) rows[0].sphere_radius = 2.0f - 0x1p-20f;
        const Tree other = make_tree(numbered_shapes(0, 2), false, rows, {0, 0}, kernels->pair);
        EXPECT_EQ(join(other, other, kernels->pair, 512).pairs.size(), gap > 0.0f ? 0u : 1u) << kernels->name;
      }
    }
  }
}

TEST(PairKernels, EmptyPlacesAndShapesWithoutBoundsMeetNothing) {
  const BoundsRow huge = box_of({0, 0, 0}, {kFarthest, kFarthest, kFarthest}, kFarthest);
  for (const simd::Kernels* kernels : all_kernels()) {
    const std::vector<BoundsRow> rows{huge, empty_box(), empty_box(), huge};
    const std::vector<std::uint8_t> special{0, 1, 1, 0};
    const Tree tree = make_tree(numbered_shapes(0, 4), true, rows, special, kernels->pair);
    const Found found = join(tree, tree, kernels->pair, 512);
    const std::vector<std::pair<std::int32_t, std::int32_t>> expected{{0, 3}};
    EXPECT_EQ(found.pairs, expected) << kernels->name;
    EXPECT_FALSE(found.special);
    const Tree none = make_tree({-1}, false, rows, special, kernels->pair);
    EXPECT_TRUE(join(none, none, kernels->pair, 512).pairs.empty());
    EXPECT_TRUE(join(none, tree, kernels->pair, 512).pairs.empty());
    EXPECT_TRUE(join(tree, none, kernels->pair, 512).pairs.empty());
  }
}

TEST(PairKernels, AJoinGoesOnWhereItsRoomEnded) {
  constexpr int kShapes = 1200;
  const std::vector<BoundsRow> rows = random_boxes(kShapes, false, 9);
  const std::vector<std::uint8_t> special(rows.size());
  const std::vector<std::int32_t> members = sorted_along_x(numbered_shapes(0, kShapes), rows);
  const Found expected = all_pairs(members, members, rows, special);
  ASSERT_GT(expected.pairs.size(), 2000u);
  for (const simd::Kernels* kernels : all_kernels()) {
    const Tree tree = make_tree(members, false, rows, special, kernels->pair);
    const auto all = static_cast<std::int64_t>(expected.pairs.size());
    for (const std::int64_t room : {std::int64_t{0}, std::int64_t{1}, std::int64_t{kBlock}, std::int64_t{100},
                                    all, all + kBlock - 1, all + kBlock}) {
      EXPECT_TRUE(join(tree, tree, kernels->pair, room) == expected) << kernels->name << " room " << room;
    }
  }
}

// --- sorting ---

TEST(PairKernels, RankingSortsEveryRowUpToTheLongestAndLeavesLongerOnes) {
  constexpr std::int32_t kFirstOwner = 1000;
  PairNumbers numbers(4);
  std::vector<std::int32_t> lengths = {0, 1, 2, 255, 256, 257, 300, 0, 3};
  for (std::int32_t length = 0; length < 70; ++length) lengths.push_back(length);
  std::vector<std::int32_t> others, ends;
  for (const std::int32_t length : lengths) {
    std::vector<std::int32_t> row =
        shuffled_shapes(numbered_shapes(0, 3 * length + 1), static_cast<unsigned>(length));
    row.resize(static_cast<std::size_t>(length));
    for (std::int32_t& other : row) other = 5000 + 7 * other;
    others.insert(others.end(), row.begin(), row.end());
    ends.push_back(static_cast<std::int32_t>(others.size()));
  }
  const std::size_t count = others.size();
  for (int i = 0; i < kBlock; ++i) others.push_back(numbers.pick(9000) - 100);  // read, but not of any row
  for (const simd::Kernels* kernels : all_kernels()) {
    std::vector<ShapePair> pairs(count + kBlock, kUnwritten);
    kernels->pair.rank_rows(
        {others.data(), ends.data(), kFirstOwner, static_cast<std::int32_t>(ends.size()), pairs.data()});
    std::size_t begin = 0;
    for (std::size_t owner = 0; owner < ends.size(); ++owner) {
      const auto end = static_cast<std::size_t>(ends[owner]);
      std::vector<std::int32_t> sorted(others.begin() + static_cast<std::ptrdiff_t>(begin),
                                       others.begin() + static_cast<std::ptrdiff_t>(end));
      std::sort(sorted.begin(), sorted.end());
      const bool ranked = sorted.size() <= static_cast<std::size_t>(simd::kRankedRow);
      for (std::size_t i = begin; i < end; ++i) {
        EXPECT_EQ(pairs[i].a, ranked ? kFirstOwner + static_cast<std::int32_t>(owner) : kUnwritten.a);
        EXPECT_EQ(pairs[i].b, ranked ? sorted[i - begin] : kUnwritten.b) << kernels->name;
      }
      begin = end;
    }
    for (std::size_t i = count; i < pairs.size(); ++i) EXPECT_EQ(pairs[i].a, kUnwritten.a);
  }
}

}  // namespace
}  // namespace scree::kernel_tests
