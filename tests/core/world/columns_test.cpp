// Laws of columns, of the state table and of the code generated from it.
#include <core/world/state_table.h>
#include <tests/core/world/world_fixture.h>

#include <cstring>
#include <fstream>
#include <new>
#include <set>
#include <string>
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

TEST(StateTable, NamesEveryColumnOnce) {
  World world;
  std::set<std::string> names;
  std::size_t count = 0;
  for_each_column(internals(world), [&](ColumnKind, const char* store, const char* name, auto&) {
    names.insert(std::string(store) + "." + name);
    ++count;
  });
  EXPECT_EQ(names.size(), count);
  for (const char* name :
       {"bodies.pose", "bodies.free_slots", "bodies.awake", "shapes.fat_bounds", "shapes.dirty",
        "contacts.pairs.pair", "contacts.resting.pair", "contacts.pairs_before.pair", "contacts.now.manifold",
        "contacts.free_rows", "contacts.active"}) {
    EXPECT_EQ(names.count(name), 1u) << name;
  }
}

// Bytes of the members of a table, without counting nested tables twice.
template <class Data>
std::size_t bytes_of_members(Data& data) {
  std::size_t bytes = 0;
  Data::visit_members(data, TablePlace{}, [&bytes](const Member&, const auto& it) { bytes += sizeof it; });
  return bytes;
}

TEST(StateTable, CoversEveryMemberOfAWorld) {
  // The remainder is padding between members of different alignment: less than a word for each small one.
  World world;
  WorldData& data = internals(world);
  std::size_t small = 0;
  for_each_member(data, [&small](const Member&, const auto& it) { small += sizeof it < 8 ? 1 : 0; });
  EXPECT_LE(bytes_of_members(data), sizeof data);
  EXPECT_LT(sizeof data - bytes_of_members(data), 8 * (small + 1));
}

TEST(StateTable, LastStepsPairsAreScratch) {
  World world;
  for_each_column(internals(world), [&](ColumnKind kind, const char* store, const char* name, auto&) {
    if (std::string(store) == "contacts.pairs_before") {
      EXPECT_EQ(kind, ColumnKind::scratch) << name;
    }
  });
}

// clang-format off
#define SCREE_COUNTED_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER) \
  LIST (derived, double, colors)                               \
  LIST (scratch, float, blocks)                                \
  VALUE(scratch, std::int64_t, rounds, 7)
// clang-format on
SCREE_PART(CountedPart, SCREE_COUNTED_MEMBERS)

TEST(MemoryUse, IsTheSumOverTheTable) {
  World world;
  std::vector<BodyId> ids(1000);
  world.create_bodies(std::vector<BodyDef>(1000), std::vector<Geometry>(1000), {}, {}, ids);
  auto part = std::make_unique<CountedPart>();
  part->colors.reserve(100);
  part->blocks.reserve(1000);
  internals(world).islands = std::move(part);
  std::size_t sums[3] = {};
  for_each_member(internals(world), [&](const Member& member, const auto& it) {
    if constexpr (kIsColumn<std::remove_cvref_t<decltype(it)>>) {
      EXPECT_GE(it.capacity_bytes(), it.span().size_bytes()) << member.store << "." << member.name;
      sums[static_cast<int>(member.kind)] += it.capacity_bytes();
    } else {
      sums[static_cast<int>(member.kind)] += sizeof it;
    }
  });
  const MemoryUse use = world.memory_use();
  EXPECT_EQ(use.state, sums[0]);
  EXPECT_EQ(use.derived, sums[1] + 100 * sizeof(double));
  EXPECT_EQ(use.scratch, sums[2] + 1000 * sizeof(float) + sizeof(std::int64_t));
  EXPECT_GE(use.state, 1000 * (sizeof(PoseRow) + sizeof(VelocityRow)));
}

TEST(StateTable, ClearedPartsKeepOnlyTheirMemory) {
  CountedPart part;
  part.colors.push_back(1.0);
  part.blocks.push_back(1.0f);
  part.rounds = 9;
  const std::size_t bytes = part.colors.capacity_bytes();
  static_cast<Part&>(part).forget();
  EXPECT_TRUE(part.colors.empty() && part.blocks.empty());
  EXPECT_EQ(part.rounds, 7);
  EXPECT_EQ(part.colors.capacity_bytes(), bytes);
}

}  // namespace
}  // namespace scree::test
