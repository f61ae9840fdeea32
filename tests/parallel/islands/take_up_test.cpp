// Laws of the update of an ascending list by a list of changes.
#include <core/world/column.h>
#include <parallel/islands/take_up.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace scree::test {
namespace {

TEST(TakeUp, KeepsOfTheChangedRowsThoseAskedForAndAllOthers) {
  constexpr std::int32_t kRows = 40;
  std::mt19937 random(3);
  for (int trial = 0; trial < 2000; ++trial) {
    const auto often = 1 + random() % 5;  // one row of so many is in the list; and is changed; and is kept
    std::set<std::int32_t> expected;
    std::set<std::int32_t> kept;
    Column<std::int32_t> list, changed, scratch;
    Column<std::uint8_t> is_changed;
    is_changed.resize(kRows);
    for (std::int32_t row = 0; row < kRows; ++row) {
      if (random() % often == 0) expected.insert(row);
      if (random() % (6 - often) == 0) kept.insert(row);
    }
    for (const std::int32_t row : expected) list.push_back(row);
    for (std::int32_t row = 0; row < kRows; ++row) {
      if (random() % often != 0) continue;
      changed.push_back(row);
      is_changed[row] = 1;
      expected.erase(row);
      if (kept.contains(row)) expected.insert(row);
    }
    take_up(list, changed, is_changed, scratch, [&](std::int32_t row) { return kept.contains(row); });
    ASSERT_EQ(std::vector<std::int32_t>(list.begin(), list.end()),
              std::vector<std::int32_t>(expected.begin(), expected.end()));
  }
}

#ifdef SCREE_ASSERTIONS

TEST(TakeUpDeathTest, ChangesAreTakenUpInOrder) {
  Column<std::int32_t> list, changed, scratch;
  for (std::int32_t row = 0; row < 4; ++row) list.push_back(row);
  Column<std::uint8_t> is_changed;
  is_changed.resize(4);
  const auto keep = [](std::int32_t) { return true; };
  for (const std::int32_t row : {2, 1}) changed.push_back(row);
  EXPECT_DEATH(take_up(list, changed, is_changed, scratch, keep), "changed");
  changed.clear();
  std::swap(list[0], list[1]);
  EXPECT_DEATH(take_up(list, changed, is_changed, scratch, keep), "list");
}

#endif

}  // namespace
}  // namespace scree::test
