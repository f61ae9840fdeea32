// Laws of snapshots of a part of a world: rows of absent bodies are zero, and nothing is made of them.
#include <core/state/snapshot/absent_rows.h>
#include <core/state/snapshot/saved_columns.h>
#include <core/state/snapshot/snapshot.h>
#include <core/state/snapshot/snapshot_bytes.h>
#include <gtest/gtest.h>
#include <scree/snapshot.h>
#include <scree/world.h>

#include <cstring>
#include <memory>
#include <string>
#include <vector>

namespace scree {
namespace {

// Ten boxes, of which the row of the fourth is that of an absent body. Nobody has made a part of it
// otherwise, so the columns can be written to.
struct PartOfAWorld {
  PartOfAWorld() {
    for (int i = 0; i < 10; ++i) {
      const BodyId id = world.create_body({.position = {static_cast<float>(2 * i), 1, 0}, .user_data = 7});
      world.add_shape(id, Box{{0.5f, 0.4f, 0.3f}});
    }
    place_all();
    body = static_cast<std::int32_t>(world.body_at(kFirstBody + 3).index);
    shape = data().bodies.first_shape[body];
    for_each_saved_column(data(), [&](const Member& member, auto& column) {
      if (!is_of_present(member)) return;
      const std::int32_t row = member.rows == SheetId::bodies ? body : shape;
      std::memset(static_cast<void*>(&column[row]), 0, sizeof column[row]);
    });
    data().shapes.tree[shape] = TreeKind::none;
  }
  // Cores are saved.
  void place_all() { clone(world); }
  WorldData& data() { return internals(world, "test"); }
  Snapshot saved(bool is_part) {
    Snapshot snapshot;
    std::unique_ptr<SnapshotData>& to = SnapshotAccess::data(snapshot);
    to = std::make_unique<SnapshotData>();
    save_world(data(), *to, false);
    to->is_part = is_part;
    return snapshot;
  }
  std::string problem(bool is_part = true) {
    try {
      check_saved(*SnapshotAccess::data(saved(is_part)));
    } catch (const RefusedBytes& refused) {
      return refused.reason;
    }
    return "none";
  }

  World world;
  std::int32_t body = 0, shape = 0;
};

TEST(AbsentRows, AreZeroInAPartAndNothingElseMayBe) {
  PartOfAWorld part;
  EXPECT_EQ(part.problem(), "none");
  EXPECT_EQ(part.problem(false), "bodies.pose, row " + std::to_string(part.body) + ": is no placement");
}

TEST(AbsentRows, SurviveBytesAndARestore) {
  PartOfAWorld part;
  const std::vector<std::byte> bytes = write_snapshot(part.saved(true));
  EXPECT_THROW(read_snapshot(bytes), Error);
  World other;
  restore(other, read_part_snapshot(bytes));
  const WorldData& data = internals(other, "test");
  for (std::size_t row = kFirstBody; row < data.bodies.flags.size(); ++row) {
    const auto body = static_cast<std::int32_t>(row);
    EXPECT_EQ(is_absent(data.bodies, body), body == part.body) << row;
    EXPECT_EQ(is_zero_row(data.bodies.transform[row]), body == part.body) << "derived of what is not there";
    EXPECT_EQ(data.bodies.user_data[row], body == part.body ? 0u : 7u);
  }
  EXPECT_TRUE(is_zero_row(data.shapes.local_pose[part.shape]));
}

// Each column by itself.
TEST(AbsentRows, AreRefusedWhereTheyAreNotZero) {
  int columns = 0;
  PartOfAWorld part;
  for_each_saved_column(part.data(), [&](const Member& member, auto& column) {
    if (!is_of_present(member)) return;
    const std::int32_t row = member.rows == SheetId::bodies ? part.body : part.shape;
    auto* const bytes = reinterpret_cast<unsigned char*>(&column[row]);
    bytes[sizeof column[row] - 1] = 1;
    const std::string problem = part.problem();
    // A body that has a pose is there, and then lacks all else.
    const bool is_pose = std::string(member.name) == "pose" && member.rows == SheetId::bodies;
    EXPECT_NE(problem.find(is_pose ? "is no placement" : "is of a body that is absent, and not zero"),
              std::string::npos)
        << member.store << "." << member.name << ": " << problem;
    bytes[sizeof column[row] - 1] = 0;
    ++columns;
  });
  EXPECT_GT(columns, 15);
  EXPECT_EQ(part.problem(), "none");
}

TEST(AbsentRows, NeitherSleepNorStandInATree) {
  PartOfAWorld part;
  part.data().bodies.flags[part.body] |= std::uint8_t{kBodyAsleep};
  EXPECT_NE(part.problem().find("bodies that are absent do not sleep"), std::string::npos);
  part.data().bodies.flags[part.body] =
      static_cast<std::uint8_t>(part.data().bodies.flags[part.body] & ~kBodyAsleep);
  part.data().shapes.tree[part.shape] = TreeKind::awake;
  EXPECT_NE(part.problem().find("is another than its body's"), std::string::npos);
}

}  // namespace
}  // namespace scree
