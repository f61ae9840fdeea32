// Laws of assertions: builds with assertions check them, builds without do not evaluate them.
#include <core/plain/assert.h>
#include <core/world/column.h>
#include <core/world/resting_pairs.h>
#include <parallel/islands/take_up.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>

namespace scree::test {
namespace {

Column<std::int32_t> numbers(std::size_t count) {
  Column<std::int32_t> column;
  for (std::size_t i = 0; i < count; ++i) column.push_back(static_cast<std::int32_t>(i));
  return column;
}

#ifdef SCREE_ASSERTIONS

TEST(AssertDeathTest, AFailureNamesTheConditionAndItsPlace) {
  EXPECT_DEATH(SCREE_ASSERT(1 + 1 == 3), "assert_test\\.cpp:[0-9]+: assertion failed: 1 \\+ 1 == 3");
}

TEST(AssertDeathTest, ARowBehindTheLastIsRefusedByAnyIntegerThatNamesIt) {
  Column<std::int32_t> column = numbers(3);
  EXPECT_EQ(column[2], 2);
  EXPECT_DEATH(column[3] = 0, "index < size_");
  EXPECT_DEATH(column[std::size_t{3}] = 0, "index < size_");
  EXPECT_DEATH(column[std::uint32_t{3}] = 0, "index < size_");
  EXPECT_DEATH(static_cast<void>(std::as_const(column)[3]), "index < size_");
}

TEST(AssertDeathTest, ANegativeRowIsRefused) {
  Column<std::int32_t> column = numbers(3);
  EXPECT_DEATH(column[-1] = 0, "index < size_");
  EXPECT_DEATH(column[std::int64_t{-1}] = 0, "index < size_");
}

TEST(AssertDeathTest, ANegativeSizeIsRefused) {
  Column<std::int32_t> column = numbers(3);
  EXPECT_DEATH(column.resize(-1), "in_range");
  EXPECT_DEATH(column.resize(std::int64_t{-1}), "in_range");
  EXPECT_DEATH(column.resize_for_overwrite(-1), "in_range");
  EXPECT_DEATH(column.resize_discarding(-1), "in_range");
  EXPECT_DEATH(column.reserve(-1), "in_range");
  EXPECT_DEATH(column.drop_back(-1), "in_range");
}

TEST(AssertDeathTest, ANegativeRowIsNotMarked) {
  PageMarks marks;
  marks.cover(std::size_t{64});
  EXPECT_DEATH(marks.mark(-1), "in_range");
}

TEST(AssertDeathTest, ARowThatWasDroppedIsRefusedThoughItsMemoryIsThere) {
  Column<std::int32_t> column = numbers(3);
  column.pop_back();
  EXPECT_DEATH(column[2] = 0, "index < size_");
}

TEST(AssertDeathTest, AnEmptyColumnHasNoLastRow) {
  Column<std::int32_t> column;
  EXPECT_DEATH(static_cast<void>(column.back()), "size_ > 0");
  EXPECT_DEATH(column.pop_back(), "count <= size_");
  column = numbers(3);
  EXPECT_DEATH(column.drop_back(4), "count <= size_");
}

TEST(AssertDeathTest, AColumnIsNotAppendedToItself) {
  Column<std::int32_t> column = numbers(3);
  EXPECT_DEATH(column.append(column.span()), "rows.empty");
}

TEST(AssertDeathTest, ChangesAreTakenUpInOrder) {
  Column<std::int32_t> list = numbers(4), changed, scratch;
  Column<std::uint8_t> is_changed;
  is_changed.resize(4);
  const auto keep = [](std::int32_t) { return true; };
  for (const std::int32_t row : {2, 1}) changed.push_back(row);
  EXPECT_DEATH(take_up(list, changed, is_changed, scratch, keep), "changed");
  changed.clear();
  std::swap(list[0], list[1]);
  EXPECT_DEATH(take_up(list, changed, is_changed, scratch, keep), "list");
}

TEST(AssertDeathTest, PairsAtRestAreRemovedInOrder) {
  WorldData data;
  data.shapes.resize(4);
  PairRows pairs;
  pairs.resize(3);
  for (std::int32_t i = 0; i < 3; ++i) {
    pairs.pair[i] = {i, i + 1};
    pairs.contact[i] = -1;
  }
  add_resting(data, pairs);
  Column<std::int32_t> rows;
  for (const std::int32_t row : {1, 0}) rows.push_back(row);
  EXPECT_DEATH(remove_resting(data, rows), "rows");
}

#else

TEST(Assert, ABuildWithoutAssertionsNeverEvaluatesTheCondition) {
  int looked = 0;
  const auto look = [&] { return ++looked > 0; };
  SCREE_ASSERT(look());
  SCREE_ASSERT(!look());
  EXPECT_EQ(looked, 0);
}

TEST(Assert, ABuildWithoutAssertionsDoesNotCheckRows) {
  Column<std::int32_t> column = numbers(3);
  column.pop_back();
  EXPECT_EQ(column[2], 2);  // its memory still exists
}

#endif

}  // namespace
}  // namespace scree::test
