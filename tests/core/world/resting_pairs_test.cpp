// Laws of the rows of pairs at rest; tests/parallel/broad_phase/resting_pairs_test.cpp has those of whole
// worlds.
#include <core/world/resting_pairs.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <set>
#include <utility>

namespace scree::test {
namespace {

constexpr std::int32_t kShapes = 12;

using Pair = std::pair<std::int32_t, std::int32_t>;

Pair ordered(std::int32_t a, std::int32_t b) { return {std::min(a, b), std::max(a, b)}; }

PairRows rows_of(const std::set<Pair>& pairs) {
  PairRows rows;
  for (const auto& [a, b] : pairs) {
    rows.pair.push_back({a, b});
    rows.contact.push_back(-1);
  }
  return rows;
}

// Every pair is found from each of its two shapes, under its row, and nothing else is found.
void expect_found(const WorldData& data, const std::set<Pair>& expected) {
  std::multiset<Pair> found;
  for (std::int32_t shape = 0; shape < kShapes; ++shape) {
    for_each_resting(data, shape, [&](std::int32_t row, std::int32_t other) {
      const ShapePair pair = data.contacts.resting.pair[row];
      EXPECT_EQ((Pair{pair.a, pair.b}), ordered(shape, other));
      found.insert({pair.a, pair.b});
    });
  }
  std::multiset<Pair> twice;
  for (const Pair& pair : expected) twice.insert({pair, pair});
  EXPECT_EQ(found, twice);
}

TEST(RestingRows, AreFoundFromBothShapesAfterAnyAdditionsAndRemovals) {
  std::mt19937 random(5);
  WorldData data;
  data.shapes.resize(kShapes);
  std::set<Pair> expected;
  for (int round = 0; round < 200; ++round) {
    std::set<Pair> more;
    for (auto tries = random() % 8; tries > 0; --tries) {
      const auto a = static_cast<std::int32_t>(random() % kShapes),
                 b = static_cast<std::int32_t>(random() % kShapes);
      if (a != b && !expected.contains(ordered(a, b))) more.insert(ordered(a, b));
    }
    add_resting(data, rows_of(more));
    expected.merge(more);
    expect_found(data, expected);
    // Few of the rows, and in other rounds most of them.
    const unsigned kept_of_ten = round % 2 == 0 ? 8 : 1;
    Column<std::int32_t> gone;
    for (std::int32_t row = 0; row < static_cast<std::int32_t>(data.contacts.resting.pair.size()); ++row) {
      if (random() % 10 < kept_of_ten) continue;
      gone.push_back(row);
      expected.erase({data.contacts.resting.pair[row].a, data.contacts.resting.pair[row].b});
    }
    remove_resting(data, gone);
    expect_found(data, expected);
    link_resting(data);
    expect_found(data, expected);
  }
}

#ifdef SCREE_ASSERTIONS

TEST(RestingRowsDeathTest, AreRemovedInOrder) {
  WorldData data;
  data.shapes.resize(kShapes);
  add_resting(data, rows_of({{0, 1}, {1, 2}, {2, 3}}));
  Column<std::int32_t> rows;
  for (const std::int32_t row : {1, 0}) rows.push_back(row);
  EXPECT_DEATH(remove_resting(data, rows), "rows");
}

#endif

}  // namespace
}  // namespace scree::test
