// Laws of columns and of the marks of their pages.
#include <core/world/column.h>
#include <core/world/state_table.h>
#include <tests/core/world/world_fixture.h>

#include <cstring>
#include <fstream>
#include <new>
#include <utility>
#include <vector>

#ifdef __linux__
#include <sys/resource.h>
#endif

namespace scree::test {
namespace {

struct alignas(32) WideRow {
  float values[8];
};

template <class Row>
bool is_aligned(const Column<Row>& column) {
  return reinterpret_cast<std::uintptr_t>(column.data()) % Column<Row>::kAlignment == 0;
}

TEST(Column, RowsLieOnCacheLinesAndSurviveGrowth) {
  Column<WideRow> column;
  for (int i = 0; i < 1000; ++i) {
    column.push_back({{static_cast<float>(i)}});
    ASSERT_TRUE(is_aligned(column));
  }
  for (int i = 0; i < 1000; ++i)
    EXPECT_EQ(column[static_cast<std::size_t>(i)].values[0], static_cast<float>(i));
  Column<std::uint8_t> bytes;
  bytes.resize(3);
  EXPECT_TRUE(is_aligned(bytes));
}

// Resizes a column of 3 rows, and drops 1 of 4, by integers of one type.
template <class Integer>
void expect_sizes_by() {
  Column<std::int32_t> column;
  column.reserve(Integer{3});
  EXPECT_TRUE(column.empty());
  EXPECT_GE(column.capacity_bytes(), 3 * sizeof(std::int32_t));
  column.resize(Integer{3});
  for (const std::int32_t value : column) EXPECT_EQ(value, 0);
  EXPECT_EQ(column.size(), 3u);
  column[Integer{2}] = 7;
  column.resize_for_overwrite(Integer{4});
  EXPECT_EQ(column.size(), 4u);
  EXPECT_EQ(column[Integer{2}], 7);
  column.drop_back(Integer{1});
  EXPECT_EQ(column.size(), 3u);
  column.resize_discarding(Integer{5});
  EXPECT_EQ(column.size(), 5u);
  column.resize(Integer{0});
  EXPECT_TRUE(column.empty());
}

TEST(Column, SizesAndRowsAreAnyIntegers) {
  expect_sizes_by<std::size_t>();
  expect_sizes_by<std::int64_t>();
  expect_sizes_by<std::int32_t>();
  expect_sizes_by<std::uint32_t>();
  expect_sizes_by<std::uint8_t>();
}

TEST(PageMarks, RowsAreAnyIntegers) {
  PageMarks marks;
  marks.cover(3 * kPageRows);
  marks.mark(std::int32_t{0});
  marks.mark(2 * kPageRows);
  EXPECT_NE(marks[0], 0);
  EXPECT_EQ(marks[1], 0);
  EXPECT_NE(marks[2], 0);
}

TEST(Column, NewRowsAreZeroInReusedMemoryToo) {
  Column<std::int32_t> column;
  column.resize(100);
  for (std::int32_t& value : column) value = 7;
  column.resize(10);
  column.resize(100);
  for (std::size_t i = 0; i < 100; ++i) EXPECT_EQ(column[i], i < 10 ? 7 : 0);
  column.drop_back(95);
  column.resize(100000);
  for (std::size_t i = 0; i < column.size(); ++i) ASSERT_EQ(column[i], i < 5 ? 7 : 0);
  column.resize_discarding(200000);
  column.clear();
  column.resize(1000);
  for (const std::int32_t value : column) ASSERT_EQ(value, 0);
}

// Large ones lie in pages of their own.
TEST(Column, LargeColumnsKeepTheirRowsAndNewRowsAreZero) {
  Column<std::int32_t> column;
  std::size_t filled = 0;
  for (std::size_t size = 1000; size < 20'000'000; size = size * 3 / 2) {
    column.resize(size);
    ASSERT_TRUE(is_aligned(column));
    for (std::size_t i = 0; i < filled; ++i) ASSERT_EQ(column[i], static_cast<std::int32_t>(i)) << size;
    for (std::size_t i = filled; i < size; ++i) ASSERT_EQ(column[i], 0) << size;
    filled = size / 2;  // the rest is not written to
    for (std::size_t i = 0; i < filled; ++i) column[i] = static_cast<std::int32_t>(i);
  }
  column[column.size() - 1] = 7;
  const std::size_t size = column.size();
  column.drop_back(10);
  column.resize(size);
  EXPECT_EQ(column[size - 1], 0);
  std::int32_t past[16];  // may be read
  std::memcpy(past, column.data() + size, sizeof past);
  Column<std::int32_t> other;
  other.swap(column);
  EXPECT_TRUE(column.empty());
  EXPECT_EQ(other[100], 100);
  other.resize_discarding(4 * size);
  other.clear();
  other.push_back(5);
  EXPECT_EQ(other[0], 5);
  EXPECT_GE(other.capacity_bytes(), 4 * size * sizeof(std::int32_t));
}

TEST(Column, LargeScratchThatGrowsALittleStaysWhereItIs) {
  if (!has_page_memory()) GTEST_SKIP() << "memory is watched";
  Column<std::int32_t> column;
  column.resize_discarding(1'000'000);
  const std::int32_t* const rows = column.data();
  column.resize_discarding(1'000'001);
  EXPECT_EQ(column.data(), rows);
  EXPECT_GE(column.capacity_bytes(), 1'000'001 * sizeof(std::int32_t));
}

#ifdef __linux__
// Resident pages of the program's memory.
double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  double all = 0.0, resident = 0.0;
  file >> all >> resident;
  return resident * 4096.0;
}

TEST(Column, UnwrittenRowsTakeNoMemory) {
  if (!has_page_memory()) GTEST_SKIP() << "memory is watched";
  constexpr std::size_t kRows = 4'000'000;
  const double before = resident_bytes();
  Column<WideRow> column;
  for (std::size_t rows = 1000; rows < kRows; rows += rows / 8) column.resize(rows);
  column.resize(kRows);
  for (std::size_t i = 0; i < kRows / 8; ++i) column[i].values[0] = 1.0f;
  float sum = 0.0f;
  for (const WideRow& row : column) sum += row.values[0];
  EXPECT_EQ(sum, static_cast<float>(kRows / 8));
  EXPECT_LT(resident_bytes() - before, 0.2 * kRows * sizeof(WideRow));
}

TEST(Column, ZeroedRowsTakeNoMemory) {
  if (!has_page_memory()) GTEST_SKIP() << "memory is watched";
  constexpr std::size_t kRows = 1'000'000;
  const double before = resident_bytes();
  Column<WideRow> column;
  column.resize(kRows);
  for (WideRow& row : column) row.values[0] = 1.0f;
  EXPECT_GT(resident_bytes() - before, 0.9 * kRows * sizeof(WideRow));
  column.zero(kRows / 10, kRows);
  EXPECT_LT(resident_bytes() - before, 0.2 * kRows * sizeof(WideRow));
  EXPECT_EQ(column[kRows / 10 - 1].values[0], 1.0f);
}

// Bytes of the program's address space.
double address_bytes() {
  std::ifstream file("/proc/self/statm");
  double all = 0.0;
  file >> all;
  return all * 4096.0;
}

TEST(Column, GrowsEvenWithAddressSpaceOnlyForItsRows) {
  if (!has_page_memory()) GTEST_SKIP() << "memory is watched";
  constexpr std::size_t kRows = 1'000'000;
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
  rlimit tight = before;
  tight.rlim_cur = static_cast<rlim_t>(address_bytes() + 2.5 * kRows * sizeof(WideRow));
  ASSERT_EQ(setrlimit(RLIMIT_AS, &tight), 0);
  Column<WideRow> column;
  column.resize(kRows / 2);
  column[kRows / 2 - 1].values[0] = 3.0f;
  EXPECT_NO_THROW(column.resize(kRows));
  EXPECT_EQ(column[kRows / 2 - 1].values[0], 3.0f);
  EXPECT_THROW(column.resize(10 * kRows), std::bad_alloc);
  EXPECT_EQ(column.size(), kRows);
  EXPECT_EQ(column[kRows / 2 - 1].values[0], 3.0f);
  EXPECT_EQ(setrlimit(RLIMIT_AS, &before), 0);
}

TEST(MemoryUse, AFixedBodyWithItsBoxTakesUnder400BytesBeforeItIsStepped) {
  if (!has_page_memory()) GTEST_SKIP() << "memory is watched";
  constexpr std::size_t kBodies = 200'000;
  const std::vector<BodyDef> defs(kBodies, {.type = BodyType::fixed});
  const std::vector<Geometry> boxes(kBodies, Box{});
  std::vector<BodyId> ids(kBodies);
  const double before = resident_bytes();
  World world;
  world.create_bodies(defs, boxes, {}, {}, ids);
  EXPECT_LT(resident_bytes() - before, 400.0 * kBodies);
}
#endif

// With pages of its own and without.
TEST(Column, ZeroChangesTheRowsOfItsRangeAlone) {
  for (const std::int32_t size : {1, 100, 20'000, 200'000}) {
    Column<std::int32_t> column;
    column.resize(size);
    const std::int32_t bounds[][2] = {{0, 0},           {0, 1},       {size / 3, size / 2}, {size - 1, size},
                                      {size / 3, size}, {size, size}, {size / 7, size / 2}, {0, size}};
    for (const auto& [first, end] : bounds) {
      for (std::int32_t i = 0; i < size; ++i) column[i] = i + 1;
      column.zero(first, end);
      for (std::int32_t i = 0; i < size; ++i)
        ASSERT_EQ(column[i], i >= first && i < end ? 0 : i + 1) << first << " to " << end << " of " << size;
    }
    column[size - 1] = 7;
    column.drop_back(1);
    column.resize(size);
    EXPECT_EQ(column[size - 1], 0);
  }
}

TEST(Column, ReservedRowsNeedNoNewMemory) {
  Column<std::int32_t> column;
  column.reserve(1000);
  EXPECT_TRUE(column.empty());
  const std::int32_t* rows = column.data();
  for (int i = 0; i < 1000; ++i) column.push_back(i);
  EXPECT_EQ(column.data(), rows);
  EXPECT_GE(column.capacity_bytes(), 4000u);
}

TEST(Column, MemoryEndsAfterThePadding) {
  Column<WideRow> column;
  column.resize(5);
  WideRow past[2];  // 64 bytes behind the last row may be read
  std::memcpy(past, static_cast<const void*>(column.data() + 5), sizeof past);
  EXPECT_EQ(past[1].values[7], 0.0f);
}

TEST(Column, PushingAnElementOfItselfIsSafe) {
  Column<std::int32_t> column;
  column.push_back(42);
  for (int i = 0; i < 100; ++i) column.push_back(column[0]);
  EXPECT_EQ(column.back(), 42);
}

Column<std::int32_t> numbers(std::size_t count) {
  Column<std::int32_t> column;
  for (std::size_t i = 0; i < count; ++i) column.push_back(static_cast<std::int32_t>(i));
  return column;
}

#ifdef SCREE_ASSERTIONS

TEST(ColumnDeathTest, ARowBehindTheLastIsRefusedByAnyIntegerThatNamesIt) {
  Column<std::int32_t> column = numbers(3);
  EXPECT_EQ(column[2], 2);
  EXPECT_DEATH(column[3] = 0, "index < size_");
  EXPECT_DEATH(column[std::size_t{3}] = 0, "index < size_");
  EXPECT_DEATH(column[std::uint32_t{3}] = 0, "index < size_");
  EXPECT_DEATH(static_cast<void>(std::as_const(column)[3]), "index < size_");
}

TEST(ColumnDeathTest, ANegativeRowIsRefused) {
  Column<std::int32_t> column = numbers(3);
  EXPECT_DEATH(column[-1] = 0, "index < size_");
  EXPECT_DEATH(column[std::int64_t{-1}] = 0, "index < size_");
}

TEST(ColumnDeathTest, ANegativeSizeIsRefused) {
  Column<std::int32_t> column = numbers(3);
  EXPECT_DEATH(column.resize(-1), "in_range");
  EXPECT_DEATH(column.resize(std::int64_t{-1}), "in_range");
  EXPECT_DEATH(column.resize_for_overwrite(-1), "in_range");
  EXPECT_DEATH(column.resize_discarding(-1), "in_range");
  EXPECT_DEATH(column.reserve(-1), "in_range");
  EXPECT_DEATH(column.drop_back(-1), "in_range");
}

TEST(ColumnDeathTest, ARowThatWasDroppedIsRefusedThoughItsMemoryIsThere) {
  Column<std::int32_t> column = numbers(3);
  column.pop_back();
  EXPECT_DEATH(column[2] = 0, "index < size_");
}

TEST(ColumnDeathTest, AnEmptyColumnHasNoLastRow) {
  Column<std::int32_t> column;
  EXPECT_DEATH(static_cast<void>(column.back()), "size_ > 0");
  EXPECT_DEATH(column.pop_back(), "count <= size_");
  column = numbers(3);
  EXPECT_DEATH(column.drop_back(4), "count <= size_");
}

TEST(ColumnDeathTest, AColumnIsNotAppendedToItself) {
  Column<std::int32_t> column = numbers(3);
  EXPECT_DEATH(column.append(column.span()), "rows.empty");
}

TEST(PageMarksDeathTest, ANegativeRowIsNotMarked) {
  PageMarks marks;
  marks.cover(std::size_t{64});
  EXPECT_DEATH(marks.mark(-1), "in_range");
}

#else

TEST(Column, ABuildWithoutAssertionsDoesNotCheckRows) {
  Column<std::int32_t> column = numbers(3);
  column.pop_back();
  EXPECT_EQ(column[2], 2);  // its memory still exists
}

#endif

}  // namespace
}  // namespace scree::test
