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
#include <tests/core/geometry/mesh/meshes.h>
#include <tests/core/state/table_bytes.h>

#include <cstring>
#include <functional>
#include <set>
#include <string>
#include <vector>

namespace scree::test {
namespace {

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
  world.add_shape(ground, Box{{50, 1, 50}}, {}, {.local_pose = {{0, 1.5f, 0}, {}}, .sensor = true});
  world.add_shape(ground, HalfSpace{}, {}, {.local_pose = {{0, -20, 0}, {}}});
  ShapeId meshes[3];
  for (int i = 0; i < 3; ++i) {
    test_solids::TestMesh mesh = test_solids::box_mesh({1, 1, 1 + static_cast<float>(i)});
    meshes[i] = world.add_shape(ground, TriangleMesh(mesh.vertices, mesh.triangles), {},
                                {.local_pose = {{0, 0, 100}, {}}});
  }
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
  world.create_joint({.body_a = kWorld, .body_b = bodies[6]}, UserJoint{});
  Workers one(1);
  for (int i = 0; i < 60; ++i) step(world, 1.0f / 60.0f, one);
  for (int i = 0; i < 3; ++i) {  // that move on
    world.wake(bodies[static_cast<std::size_t>(i)]);
    step(world, 1.0f / 60.0f, one);
  }
  world.destroy_shape(meshes[0]);
  world.destroy_body(bodies.back());  // frees slots of a body, a shape and a contact
  world.destroy_body(bodies[4]);      // and of a hull's shape and a joint, which is lost
  const BodyId gone = world.create_body({});
  world.add_shape(gone, ConvexHull{Hull(cube_cloud(12, 5))});
  const BodyId kept = world.create_body({});
  world.add_shape(kept, ConvexHull{Hull(cube_cloud(14, 6))});
  world.destroy_body(gone);
  world.wake(bodies[6]);
  ShapeId first;
  world.shapes_of(bodies[0], {&first, 1});
  const ContactAnswer answer{meshes[1], first, -1, {}};
  world.answer_contact_hooks({&answer, 1});
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
std::size_t row_to_change(const WorldData& data, const ColumnBytes& column) {
  if (!is_of_contacts(column.member.rows)) return column.rows - 1;
  for (std::size_t row = 0; row < column.rows; ++row) {
    if (data.contacts.now.points[row] != 0) return row;
  }
  return 0;
}

TEST(StateTable, TheBusyWorldHasRowsInEveryColumnOfKindState) {
  World world = make_busy_world();
  for (const auto& [member, first, row_bytes, rows] : columns_of(internals(world))) {
    EXPECT_TRUE(member.kind != ColumnKind::state || rows > 0) << name_of(member);
  }
}

TEST(StateTable, SnapshotsHoldEachColumnOfKindStateAndNoOther) {
  World world = make_busy_world();
  const std::uint64_t hash = state_hash(world);
  for (const ColumnBytes& column : columns_of(internals(world))) {
    if (column.rows == 0) continue;
    const Member& member = column.member;
    EXPECT_EQ(member.sheet != SheetId::none, member.kind == ColumnKind::state || member.is.kept)
        << name_of(member);
    unsigned char& byte = *column.row(row_to_change(internals(world), column));
    byte ^= 0x40;
    EXPECT_EQ(state_hash(world) != hash, member.sheet != SheetId::none) << name_of(member);
    byte ^= 0x40;
  }
  EXPECT_EQ(state_hash(world), hash);
}

TEST(StateTable, RestoresEverythingThatSnapshotsHold) {
  World world = make_busy_world();
  for (const ColumnBytes& column : columns_of(internals(world))) {
    if (column.rows == 0 || column.member.sheet == SheetId::none) continue;
    const std::size_t row = row_to_change(internals(world), column);
    *column.row(row) ^= 0x40;
    const Snapshot snapshot = saved(world);
    WorldData loaded;
    const Sheets& sheets = SnapshotAccess::data(snapshot)->pages->sheets;
    reserve_columns(sheets, loaded);
    load_sheets(sheets, loaded, false);
    const std::string name = name_of(column.member);
    for (const ColumnBytes& again : columns_of(loaded)) {
      if (name_of(again.member) != name) continue;
      ASSERT_LT(row, again.rows);
      EXPECT_EQ(std::memcmp(again.row(row), column.row(row), column.row_bytes), 0) << name;
    }
    *column.row(row) ^= 0x40;
  }
}

TEST(StateTable, ComparingWorldsNamesEachColumnOfKindStateAndNoOther) {
  World world = make_busy_world(), other = make_busy_world();
  ASSERT_EQ(first_column_difference(other, world), "");
  for (const ColumnBytes& column : columns_of(internals(world))) {
    if (column.rows == 0) continue;
    const std::size_t row = row_to_change(internals(world), column);
    *column.row(row) ^= 0x40;
    const std::string found = first_column_difference(other, world);
    const std::string expected = name_of(column.member) + ", row " + std::to_string(row) + ", byte 0 of";
    EXPECT_EQ(found.substr(0, expected.size()),
              column.member.kind == ColumnKind::state ? expected : std::string());
    *column.row(row) ^= 0x40;
  }
}

TEST(StateTable, SnapshotsHoldEachValueOfKindStateAndNoOther) {
  World world = make_busy_world();
  const std::uint64_t hash = state_hash(world);
  std::set<std::string> held;
  for (const auto& [member, byte] : values_of(internals(world))) {
    *byte ^= 1;
    EXPECT_EQ(state_hash(world) != hash, member.kind == ColumnKind::state) << name_of(member);
    World other = make_busy_world();
    internals(other).load_values(SnapshotAccess::data(saved(world))->world);
    EXPECT_EQ(state_hash(other) != hash, member.kind == ColumnKind::state) << name_of(member);
    *byte ^= 1;
    if (member.kind == ColumnKind::state) held.insert(name_of(member));
  }
  EXPECT_EQ(state_hash(world), hash);
  EXPECT_TRUE(held.count("world.last_dt") == 1 && held.count("contacts.pairs_stale") == 1);
}

TEST(StateTable, ComparingWorldsNamesEachValueOfKindState) {
  World world = make_busy_world();
  const World other = clone(world);
  for (const auto& [member, byte] : values_of(internals(world))) {
    if (member.kind != ColumnKind::state) continue;
    *byte ^= 1;
    const std::string found = first_state_difference(other, world);
    EXPECT_EQ(found.rfind(name_of(member) == "world.step_count" ? "the step counter" : name_of(member), 0),
              0u)
        << name_of(member) << ": " << found;
    *byte ^= 1;
  }
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
      "world.settings:96 world.step_count:8 world.last_dt:4 world.last_substep:4 shapes.wake_requested:1 "
      "contacts.manifolds_stale:1 contacts.pairs_stale:1 ");
  EXPECT_EQ(layout_of_columns(), 0x3f73b46e8f682ac6u);
  EXPECT_EQ(kSnapshotVersion, 7u);
}

TEST(StateTable, ForgettingEmptiesAllListsThatAreNotStateAndKeepsTheRest) {
  World world = make_busy_world();
  WorldData& data = internals(world);
  const std::uint64_t hash = state_hash(world);
  ASSERT_FALSE(data.bodies.awake.empty());
  data.forget(ColumnKind::state);
  for (const auto& [member, first, row_bytes, rows] : columns_of(data)) {
    if (member.kind == ColumnKind::state || member.rows != SheetId::none) continue;
    EXPECT_EQ(rows, 0u) << name_of(member);
  }
  WorldData fresh;
  const std::vector<ValueBytes> initial = values_of(fresh), forgotten = values_of(data);
  for (std::size_t i = 0; i < initial.size(); ++i) {
    const Member& member = forgotten[i].member;
    EXPECT_TRUE(member.kind == ColumnKind::state || *forgotten[i].first == *initial[i].first)
        << name_of(member);
  }
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
  EXPECT_EQ(parts, 5);
  EXPECT_GT(columns, 80);
}

// Sets the row to the value that the rule forbids.
void break_rule(const ValueRule& rule, unsigned char* row, std::size_t bytes) {
  std::memset(row, rule.what == ValueRule::What::not_zero ? 0 : 0xff, bytes);
}

// The error of reading the world's snapshot; empty if there is none.
std::string refusal_of(World& world) {
  try {
    read_snapshot(write_snapshot(saved(world)));
  } catch (const Error& refused) {
    return refused.what();
  }
  return {};
}

TEST(StateTable, ARowThatBreaksARuleIsRefusedByTheNameOfItsColumn) {
  int rules = 0;
  WorldData table;
  for (const ColumnBytes& declared : columns_of(table)) {
    const Member& member = declared.member;
    const std::string name = name_of(member);
    const bool has_list = member.is.each_once != SheetId::none;
    if (member.sheet == SheetId::none || (member.is.rule.what == ValueRule::What::any && !has_list)) continue;
    ++rules;
    World world = make_busy_world();
    internals(world).last_save = {};
    std::size_t broken = 0;
    for (const ColumnBytes& column : columns_of(internals(world))) {
      if (name_of(column.member) != name) continue;
      broken = column.rows - 1;
      if (member.rows == SheetId::bodies) broken = kFirstBody;  // the ground
      if (member.rows == SheetId::shapes || member.rows == SheetId::joints) broken = 0;
      break_rule(member.is.rule, column.row(broken), column.row_bytes);
    }
    const std::string error = refusal_of(world);
    EXPECT_NE(error.find(name + ", row " + std::to_string(broken) + ": "), std::string::npos)
        << name << ": " << error;
  }
  EXPECT_GE(rules, 25);
}

TEST(StateTable, ARowBehindTheLastOneOfAnotherStoreIsRefused) {
  World world;  // without a body: its first one would be the next
  WorldData& data = internals(world);
  data.shapes.resize(1);
  data.shapes.free_slots.push_back(0);
  data.shapes.body[0] = kFirstBody;
  const std::string error = refusal_of(world);
  EXPECT_NE(error.find("shapes.body, row 0: does not exist"), std::string::npos) << error;
}

TEST(StateTable, ABodyThatHasWokenTwiceIsRefused) {
  World world = make_busy_world();
  WorldData& data = internals(world);
  data.last_save = {};
  ASSERT_FALSE(data.events.woken.empty());
  const SlotName woken = data.events.woken[0];
  data.events.woken.push_back(woken);
  const std::string error = refusal_of(world);
  EXPECT_NE(error.find("events.woken, row " + std::to_string(data.events.woken.size() - 1) + ": "),
            std::string::npos)
      << error;
}

TEST(StateTable, ColumnsOfAnotherLengthThanTheirStoreAreRefused) {
  WorldData table;
  for (const ColumnBytes& declared : columns_of(table)) {
    const Member& member = declared.member;
    const std::string name = name_of(member);
    const bool limited = member.is.each_once != SheetId::none || member.is.all_or_none != SheetId::none;
    if (member.sheet == SheetId::none || member.form != MemberForm::list || !limited) continue;
    World world = make_busy_world();
    for_each_column_member(internals(world), [&name](const Member& other, auto& column) {
      if (name_of(other) == name) column.resize(1000);
    });
    const std::string error = refusal_of(world);
    EXPECT_NE(error.find(name + ", row 0: wrong number of rows"), std::string::npos) << name << ": " << error;
  }
}

}  // namespace
}  // namespace scree::test
