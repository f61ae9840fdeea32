// Laws of the state table and of the code generated from it.
#include <core/world/state_table.h>
#include <tests/core/world/world_fixture.h>

#include <memory>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace scree::test {
namespace {

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
