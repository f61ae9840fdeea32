// Laws of columns, of the state table and of what is generated from it.
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
TEST(Column, LargeOnesKeepTheirRowsAndNewRowsAreZero) {
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
// Pages of the program's memory that are there.
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

// Bytes of addresses that the program has.
double address_bytes() {
  std::ifstream file("/proc/self/statm");
  double all = 0.0;
  file >> all;
  return all * 4096.0;
}

TEST(Column, GrowsWhereTheSystemHasAddressesForItsRowsAlone) {
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

TEST(Column, MemoryEndsBehindThePadding) {
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
        "contacts.free_rows", "contacts.touching"}) {
    EXPECT_EQ(names.count(name), 1u) << name;
  }
}

TEST(StateTable, StoresHoldNothingThatTheTableForgets) {
  // A new column beside the lists must be added to for_each_column; a new plain member raises its limit here.
  constexpr std::size_t kPlainBytesOfBodies = 24 + sizeof(Bodies::moments);
  constexpr std::size_t kPlainBytesOfShapes = 24, kPlainBytesOfContacts = 56;
  constexpr std::size_t kPlainBytesOfHulls = sizeof(Hulls::shared) + sizeof(Hulls::slot_of);
  std::size_t bodies = 0, shapes = 0, contacts = 0, hulls = 0;
  World world;
  for_each_column(internals(world), [&](ColumnKind, const char* store, const char*, auto& column) {
    const std::string name = store;
    if (name == "bodies") bodies += sizeof column;
    if (name == "shapes") shapes += sizeof column;
    if (name == "hulls") hulls += sizeof column;
    if (name.rfind("contacts", 0) == 0) contacts += sizeof column;
  });
  EXPECT_LE(sizeof(Bodies) - bodies, kPlainBytesOfBodies);
  EXPECT_LE(sizeof(Shapes) - shapes, kPlainBytesOfShapes);
  EXPECT_LE(sizeof(Hulls) - hulls, kPlainBytesOfHulls);
  EXPECT_LE(sizeof(Contacts) - contacts, kPlainBytesOfContacts);
}

TEST(StateTable, LastStepsPairsAreScratch) {
  World world;
  for_each_column(internals(world), [&](ColumnKind kind, const char* store, const char* name, auto&) {
    if (std::string(store) == "contacts.pairs_before") {
      EXPECT_EQ(kind, ColumnKind::scratch) << name;
    }
  });
}

struct CountedPart : Part {
  void report(const Visit& visit) const override {
    visit(ColumnKind::state, "colors", nullptr, 10, 1000);
    visit(ColumnKind::scratch, "blocks", nullptr, 20, 5000);
  }
};

TEST(MemoryUse, IsTheSumOverTheTable) {
  World world;
  std::vector<BodyId> ids(1000);
  world.create_bodies(std::vector<BodyDef>(1000), std::vector<Geometry>(1000), {}, {}, ids);
  internals(world).islands = std::make_unique<CountedPart>();
  std::size_t sums[3] = {};
  for_each_column(internals(world), [&](ColumnKind kind, const char*, const char*, auto& column) {
    sums[static_cast<int>(kind)] += column.capacity_bytes();
  });
  const MemoryUse use = world.memory_use();
  EXPECT_EQ(use.state, sums[0] + 1000);
  EXPECT_EQ(use.derived, sums[1]);
  EXPECT_EQ(use.scratch, sums[2] + 5000);
  EXPECT_GE(use.state, 1000 * (sizeof(PoseRow) + sizeof(VelocityRow)));
}

}  // namespace
}  // namespace scree::test
