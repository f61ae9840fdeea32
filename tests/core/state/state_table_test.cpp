// Laws of the state table: each member is treated as the table declares. The tests change each member in
// turn, by the table itself, so that declaring a new member also tests it.
#include <core/state/snapshot/saved_columns.h>
#include <core/state/snapshot/snapshot_bytes.h>
#include <core/state/snapshot/snapshot_columns.h>
#include <core/state/world_difference.h>
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <tests/core/constraints/joint_samples.h>
#include <tests/core/geometry/hull/hull_clouds.h>

#include <cstring>
#include <functional>
#include <set>
#include <string>
#include <vector>

namespace scree::test {
namespace {

std::string name_of(const Member& member) { return std::string(member.store) + "." + member.name; }

// A world with rows in every column that snapshots hold.
World make_busy_world() {
  WorldSettings settings;
  settings.sleep_time = 0.1f;
  settings.contact_events = ContactEvents::all;
  settings.contact_forces = true;
  World world(settings);
  const Hull rock(cube_cloud(30, 1));
  const BodyId ground = world.create_body({.type = BodyType::fixed, .position = {0, -1, 0}});
  world.add_shape(ground, Box{{50, 1, 50}});
  std::vector<BodyId> bodies;
  for (int i = 0; i < 12; ++i) {
    bodies.push_back(world.create_body({.position = {3.0f * static_cast<float>(i), 0.5f, 0}}));
    if (i % 3 == 0) world.add_shape(bodies.back(), Box{{0.5f, 0.5f, 0.5f}});
    if (i % 3 == 1) world.add_shape(bodies.back(), ConvexHull{rock});
    if (i % 3 == 2) world.add_shape(bodies.back(), Sphere{0.5f});
  }
  std::vector<JointId> joints;
  for (std::size_t i = 0; i < 4; ++i) {
    joints.push_back(world.create_joint({.body_a = bodies[i], .body_b = bodies[i + 1]}, BallJoint{}));
  }
  Workers one(1);
  for (int i = 0; i < 60; ++i) step(world, 1.0f / 60.0f, one);
  for (int i = 0; i < 3; ++i) {  // that move on
    world.wake(bodies[static_cast<std::size_t>(i)]);
    step(world, 1.0f / 60.0f, one);
  }
  world.destroy_body(bodies.back());  // frees slots of a body, a shape and a contact
  world.destroy_body(bodies[4]);      // and of a hull's shape and a joint, which is lost
  const BodyId gone = world.create_body({});
  world.add_shape(gone, ConvexHull{Hull(cube_cloud(12, 5))});
  const BodyId kept = world.create_body({});
  world.add_shape(kept, ConvexHull{Hull(cube_cloud(14, 6))});
  world.destroy_body(gone);
  world.wake(bodies[6]);
  return world;
}

// The bytes of the whole world, independent of earlier saves, after deferred work of calls.
Snapshot saved(World& world) {
  WorldData& data = internals(world);
  data.last_save = {};
  Snapshot snapshot;
  SnapshotAccess::data(snapshot) = std::make_unique<SnapshotData>();
  save_world(data, *SnapshotAccess::data(snapshot), false);
  return snapshot;
}
std::uint64_t state_hash(World& world) { return hash_of_state(*SnapshotAccess::data(saved(world))); }

// A row that is saved, because its object exists.
std::size_t row_to_change(const WorldData& data, const Member& member, std::size_t rows) {
  if (!is_of_contacts(member.rows)) return rows - 1;
  for (std::size_t row = 0; row < rows; ++row) {
    if (data.contacts.now.points[row] != 0) return row;
  }
  return 0;
}

template <class It>
constexpr bool kIsPlain = std::is_trivially_copyable_v<It> && !std::is_pointer_v<It>;

// Calls visit(Member, byte, row) for a byte of each column that has rows, or visit(Member, byte) for one of
// each value.
template <class Visit>
void for_each_byte_of_columns(WorldData& data, Visit&& visit) {
  for_each_column_member(data, [&](const Member& member, auto& column) {
    if (column.empty()) return;
    const std::size_t row = row_to_change(data, member, column.size());
    visit(member, reinterpret_cast<unsigned char*>(&column[row]), row);
  });
}
template <class Visit>
void for_each_value(WorldData& data, Visit&& visit) {
  for_each_member(data, [&](const Member& member, auto& it) {
    using It = std::remove_reference_t<decltype(it)>;
    if constexpr (!kIsColumn<It> && kIsPlain<It>) {
      if (member.form == MemberForm::value) visit(member, reinterpret_cast<unsigned char*>(&it));
    }
  });
}

TEST(StateTable, TheBusyWorldHasRowsInEveryColumnOfKindState) {
  World world = make_busy_world();
  for_each_column_member(internals(world), [](const Member& member, const auto& column) {
    EXPECT_TRUE(member.kind != ColumnKind::state || !column.empty()) << name_of(member);
  });
}

TEST(StateTable, SnapshotsHoldEachColumnOfKindStateAndNoOther) {
  World world = make_busy_world();
  const std::uint64_t hash = state_hash(world);
  for_each_byte_of_columns(internals(world), [&](const Member& member, unsigned char* byte, std::size_t) {
    EXPECT_EQ(member.sheet != SheetId::none, member.kind == ColumnKind::state || member.is.kept)
        << name_of(member);
    *byte ^= 0x40;
    EXPECT_EQ(state_hash(world) != hash, member.sheet != SheetId::none) << name_of(member);
    *byte ^= 0x40;
  });
  EXPECT_EQ(state_hash(world), hash);
}

TEST(StateTable, RestoresEverythingThatSnapshotsHold) {
  World world = make_busy_world();
  for_each_byte_of_columns(internals(world), [&](const Member& member, unsigned char* byte, std::size_t row) {
    if (member.sheet == SheetId::none) return;
    *byte ^= 0x40;
    const Snapshot snapshot = saved(world);
    WorldData loaded;
    const Sheets& sheets = SnapshotAccess::data(snapshot)->pages->sheets;
    reserve_columns(sheets, loaded);
    load_sheets(sheets, loaded);
    for_each_saved_column(loaded, [&](const Member& other, const auto& column) {
      if (name_of(other) != name_of(member)) return;
      ASSERT_LT(row, column.size());
      EXPECT_EQ(std::memcmp(static_cast<const void*>(&column[row]), byte, sizeof column[row]), 0)
          << name_of(member);
    });
    *byte ^= 0x40;
  });
}

TEST(StateTable, ComparingWorldsNamesEachColumnOfKindStateAndNoOther) {
  World world = make_busy_world(), other = make_busy_world();
  ASSERT_EQ(first_column_difference(other, world), "");
  for_each_byte_of_columns(internals(world), [&](const Member& member, unsigned char* byte, std::size_t row) {
    *byte ^= 0x40;
    const std::string found = first_column_difference(other, world);
    const std::string expected = name_of(member) + ", row " + std::to_string(row) + ", byte 0 of";
    EXPECT_EQ(found.substr(0, expected.size()), member.kind == ColumnKind::state ? expected : "");
    *byte ^= 0x40;
  });
}

TEST(StateTable, SnapshotsHoldEachValueOfKindStateAndNoOther) {
  World world = make_busy_world();
  const std::uint64_t hash = state_hash(world);
  std::set<std::string> held;
  for_each_value(internals(world), [&](const Member& member, unsigned char* byte) {
    *byte ^= 1;
    EXPECT_EQ(state_hash(world) != hash, member.kind == ColumnKind::state) << name_of(member);
    World other = make_busy_world();
    internals(other).load_values(SnapshotAccess::data(saved(world))->world);
    EXPECT_EQ(state_hash(other) != hash, member.kind == ColumnKind::state) << name_of(member);
    *byte ^= 1;
    if (member.kind == ColumnKind::state) held.insert(name_of(member));
  });
  EXPECT_EQ(state_hash(world), hash);
  EXPECT_TRUE(held.count("world.last_dt") == 1 && held.count("contacts.pairs_stale") == 1);
}

TEST(StateTable, ComparingWorldsNamesEachValueOfKindState) {
  World world = make_busy_world();
  const World other = clone(world);
  for_each_value(internals(world), [&](const Member& member, unsigned char* byte) {
    if (member.kind != ColumnKind::state) return;
    *byte ^= 1;
    const std::string found = first_state_difference(other, world);
    EXPECT_EQ(found.rfind(name_of(member) == "world.step_count" ? "the step counter" : name_of(member), 0),
              0u)
        << name_of(member) << ": " << found;
    *byte ^= 1;
  });
  EXPECT_EQ(first_state_difference(other, world), "");
}

// A change of this list changes the byte form.
TEST(StateTable, TheByteFormOfSnapshotsIsThatOfTheirVersion) {
  std::string values;
  const SavedWorld world;
  SavedWorld::visit_members(world, TablePlace{"world"}, [&values](const Member& member, const auto& it) {
    values += name_of(member) + ':' + std::to_string(sizeof it) + ' ';
  });
  EXPECT_EQ(
      values,
      "world.settings:60 world.step_count:8 world.last_dt:4 world.last_substep:4 shapes.wake_requested:1 "
      "contacts.manifolds_stale:1 contacts.pairs_stale:1 ");
  EXPECT_EQ(layout_of_columns(), 0x56ae789db124fad4u);
  EXPECT_EQ(kSnapshotVersion, 2u);
}

TEST(StateTable, ForgettingEmptiesAllListsThatAreNotStateAndKeepsTheRest) {
  World world = make_busy_world();
  WorldData& data = internals(world);
  const std::uint64_t hash = state_hash(world);
  ASSERT_FALSE(data.bodies.awake.empty());
  data.forget(ColumnKind::state);
  for_each_column_member(data, [](const Member& member, const auto& column) {
    if (member.kind == ColumnKind::state || member.rows != SheetId::none) return;
    EXPECT_TRUE(column.empty()) << name_of(member);
  });
  WorldData fresh;
  std::vector<unsigned char> initial;
  for_each_value(fresh, [&initial](const Member&, const unsigned char* byte) { initial.push_back(*byte); });
  std::size_t place = 0;
  for_each_value(data, [&](const Member& member, const unsigned char* byte) {
    EXPECT_TRUE(member.kind == ColumnKind::state || *byte == initial[place]) << name_of(member);
    ++place;
  });
  EXPECT_EQ(state_hash(world), hash);
}

TEST(StateTable, PartsOfARestoredWorldHaveNoRows) {
  World world = make_busy_world();
  Snapshot snapshot;
  save(world, snapshot);
  restore(world, snapshot);
  int parts = 0, columns = 0;
  for_each_part(internals(world), [&](const char* name, const Part& part) {
    ++parts;
    part.report(name,
                [&columns](const Member& member, const void*, std::size_t, std::size_t bytes, std::size_t) {
                  EXPECT_NE(member.kind, ColumnKind::state) << name_of(member);
                  if (member.form == MemberForm::value) return;
                  ++columns;
                  EXPECT_EQ(bytes, 0u) << name_of(member);
                });
  });
  EXPECT_EQ(parts, 4);
  EXPECT_GT(columns, 80);
}

// Sets the row to the value that the rule forbids.
void break_rule(const ValueRule& rule, unsigned char* row, std::size_t bytes) {
  std::memset(row, rule.what == ValueRule::What::not_zero ? 0 : 0xff, bytes);
}

TEST(StateTable, ARowThatBreaksARuleIsRefusedByTheNameOfItsColumn) {
  int rules = 0;
  const WorldData table;
  for_each_column_member(table, [&rules](const Member& member, const auto&) {
    const bool has_list = member.is.each_once != SheetId::none && std::string(member.name) != "woken";
    if (member.sheet == SheetId::none || (member.is.rule.what == ValueRule::What::any && !has_list)) return;
    ++rules;
    World world = make_busy_world();
    internals(world).last_save = {};
    std::size_t broken = 0;
    for_each_column_member(internals(world), [&](const Member& other, auto& column) {
      if (name_of(other) != name_of(member)) return;
      std::size_t row = column.size() - 1;
      if (other.rows == SheetId::bodies) row = kFirstBody;  // the ground
      if (other.rows == SheetId::shapes || other.rows == SheetId::joints) row = 0;
      broken = row;
      break_rule(other.is.rule, reinterpret_cast<unsigned char*>(&column[row]), sizeof column[row]);
    });
    std::string error;
    try {
      read_snapshot(write_snapshot(saved(world)));
    } catch (const Error& refused) {
      error = refused.what();
    }
    EXPECT_NE(error.find(name_of(member) + ", row " + std::to_string(broken) + ": "), std::string::npos)
        << name_of(member) << ": " << error;
  });
  EXPECT_GE(rules, 25);
}

TEST(StateTable, ColumnsOfAnotherLengthThanTheirStoreAreRefused) {
  const WorldData table;
  for_each_column_member(table, [](const Member& member, const auto&) {
    const bool limited = member.is.each_once != SheetId::none || member.is.all_or_none != SheetId::none;
    if (member.sheet == SheetId::none || member.form != MemberForm::list || !limited) return;
    World world = make_busy_world();
    for_each_column_member(internals(world), [&](const Member& other, auto& column) {
      if (name_of(other) == name_of(member)) column.resize(1000);
    });
    std::string error;
    try {
      read_snapshot(write_snapshot(saved(world)));
    } catch (const Error& refused) {
      error = refused.what();
    }
    EXPECT_NE(error.find(name_of(member) + ", row 0: wrong number of rows"), std::string::npos)
        << name_of(member) << ": " << error;
  });
}

}  // namespace
}  // namespace scree::test
