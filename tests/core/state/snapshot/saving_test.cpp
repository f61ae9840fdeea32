// Laws of saving a large world repeatedly: saving into an old snapshot gives the content of a new one. The
// snapshot shares unchanged pages with the others, and saving into another snapshot does not change it.
#include <core/state/snapshot/snapshot.h>
#include <core/world/edit.h>
#include <scree/scree.h>
#include <tests/core/world/world_fixture.h>

#include <functional>
#include <utility>
#include <vector>

namespace scree::test {
namespace {

using Bytes = std::vector<std::byte>;

constexpr float kDt = 1.0f / 60.0f;

Bytes bytes_of_all(World& world) {
  WorldData& data = internals(world);
  LastSave last = std::exchange(data.last_save, {});
  place_matter(data);
  Snapshot whole;
  SnapshotAccess::data(whole) = std::make_unique<SnapshotData>();
  save_world(data, *SnapshotAccess::data(whole), false);
  data.last_save = std::move(last);
  return write_snapshot(whole);
}

std::size_t pages_in(const Snapshot& snapshot) {
  std::size_t pages = 0;
  for (const Sheet& sheet : SnapshotAccess::data(snapshot)->pages->sheets.sheet)
    pages += pages_of(sheet.rows);
  return pages;
}

// Number of pages of the later snapshot that differ from the base's.
std::size_t new_pages(const Snapshot& base, const Snapshot& later) {
  SnapshotChanges changes;
  keep_changes(base, later, changes);
  return SnapshotAccess::data(changes)->pages.size();
}

// More than a group of pages of boxes at rest, a chain, and balls that come down on some of them.
struct Field {
  World world;
  std::vector<BodyId> boxes;
  std::vector<BodyId> balls;
  std::vector<JointId> joints;

  explicit Field(std::size_t count = 9000) {
    WorldSettings settings;
    settings.sleep_time = 0.1f;
    world = World(settings);
    std::vector<BodyDef> defs(count);
    for (std::size_t i = 0; i < count; ++i) {
      defs[i] = {.type = BodyType::fixed,
                 .position = {2.0f * static_cast<float>(i % 100), 0.0f, 2.0f * static_cast<float>(i / 100)}};
    }
    boxes.resize(count);
    world.create_bodies(defs, std::vector<Geometry>(count, Box{}), {}, {}, boxes);
    for (std::size_t i = 0; i < 200 && i * 40 < count; ++i) {
      const Pose below = world.pose(boxes[i * 40]);
      balls.push_back(world.create_body({.position = below.position + Vec3{0.0f, 0.76f, 0.0f}}));
      world.add_shape(balls.back(), Sphere{0.25f});
    }
    for (std::size_t i = 0; i + 1 < balls.size(); ++i) {
      joints.push_back(
          world.create_joint({.body_a = balls[i], .body_b = balls[i + 1], .enabled = false}, BallJoint{}));
    }
  }
  void run(int steps) {
    Workers workers(1);
    for (int i = 0; i < steps; ++i) step(world, kDt, workers);
  }
};

ShapeId world_shape(const World& world, BodyId body) {
  ShapeId shape;
  world.shapes_of(body, {&shape, 1});
  return shape;
}

TEST(Saving, AgainGivesTheContentOfANewSnapshot) {
  Field field;
  World& world = field.world;
  const auto set_sleep_time = [&](float time) {
    WorldSettings settings = world.settings();
    settings.sleep_time = time;
    world.set_settings(settings);
  };
  const std::vector<BodyId> many(field.boxes.begin() + 4000, field.boxes.begin() + 8000);
  const std::vector<BodyDef> defs(100, BodyDef{.type = BodyType::fixed, .position = {0, -300, 0}});
  std::vector<BodyId> ids(defs.size());
  const std::function<void()> changes[] = {
      [] {},
      [&] { field.run(1); },
      [&] { field.run(60); },
      [&] { world.destroy_body(field.boxes[100]); },
      [&] { world.destroy_bodies(many); },
      [&] { world.create_bodies(defs, ids); },
      [&] { world.create_bodies(defs, std::vector<Geometry>(100, Sphere{}), {}, {}, ids); },
      [&] {
        world.create_body({.position = {0, 50, 0}});
      },
      [&] { field.run(1); },
      [&] { world.wake(field.balls[7]); },
      [&] { field.run(1); },
      [&] { world.set_material(world_shape(world, field.boxes[3001]), {.friction = 0.1f}); },
      [&] { field.run(1); },
      [&] {
        world.set_pose(field.boxes[3000], {{0, 90, 0}, {}});
      },
      [&] { field.run(1); },
      [&] { world.destroy_joint(field.joints[100]); },
      [&] { world.set_joint_enabled(field.joints[3], true); },
      [&] { field.run(2); },
      [&] { set_sleep_time(0.05f); },
      [&] { field.run(40); },
      [&] { set_sleep_time(0.02f); },
      [&] { world.set_body_type(field.balls[9], BodyType::kinematic); },
      [&] {
        world.add_shape(field.boxes[2000], Box{}, {}, {.local_pose = {{0, 3, 0}, {}}});
      },
      [&] { world.destroy_shape(world_shape(world, field.boxes[2000])); },
      [&] { world.set_user_data(field.boxes[1500], 77); },
      [&] { world.destroy_joint(field.joints[50]); },
      [&] { world.create_joint({.body_a = field.balls[50], .body_b = field.balls[80]}, BallJoint{}); },
      [&] { world.destroy_body(field.balls[60]); },
      [&] { field.run(1); },
  };
  Snapshot often, first;
  std::vector<Snapshot> ring(3);
  save(world, first);
  const Bytes first_bytes = write_snapshot(first);
  for (std::size_t i = 0; i < std::size(changes); ++i) {
    changes[i]();
    const Bytes all = bytes_of_all(world);
    save(world, often);
    ASSERT_EQ(write_snapshot(often), all) << "change " << i;
    if (i % 2 == 0) {
      save(world, ring[i % ring.size()]);
      ASSERT_EQ(write_snapshot(ring[i % ring.size()]), all) << "change " << i;
    }
  }
  EXPECT_EQ(write_snapshot(first), first_bytes);
}

TEST(Saving, SharesPagesThatHaveNotChanged) {
  Field field;
  field.run(90);
  ASSERT_EQ(field.world.stats().awake_bodies, 0);
  Snapshot before, after;
  save(field.world, before);
  ASSERT_GT(pages_in(before), 500u);
  field.run(3);
  save(field.world, after);
  EXPECT_EQ(new_pages(before, after), 0u) << "all rest";
  field.world.destroy_body(field.boxes[5001]);
  field.run(1);
  save(field.world, after);
  EXPECT_LE(new_pages(before, after), 8u) << "a body, its shape, their free slots";
  field.world.wake(field.balls[0]);
  field.run(1);
  save(field.world, after);
  EXPECT_LE(new_pages(before, after), 40u);
}

TEST(Saving, OfAWorldThatIsRestoredSharesPagesWithTheSnapshot) {
  Field field;
  field.run(90);
  Snapshot before, after;
  save(field.world, before);
  field.world.destroy_bodies(field.boxes);
  restore(field.world, before);
  save(field.world, after);
  EXPECT_EQ(new_pages(before, after), 0u);
  EXPECT_EQ(write_snapshot(after), bytes_of_all(field.world));
}

TEST(Saving, IntoASnapshotOfAnotherWorldKeepsThemApart) {
  Field field(300), other(500);
  Snapshot shared, own;
  for (int i = 0; i < 6; ++i) {
    save(field.world, own);
    save(other.world, shared);
    ASSERT_EQ(write_snapshot(shared), bytes_of_all(other.world));
    field.run(1);
    other.world.destroy_body(other.boxes[static_cast<std::size_t>(i)]);
    save(field.world, shared);
    ASSERT_EQ(write_snapshot(shared), bytes_of_all(field.world));
    other.run(1);
    restore(other.world, i % 2 == 0 ? shared : own);
    field.world.destroy_body(field.boxes[static_cast<std::size_t>(i)]);
    save(field.world, shared);
    other.run(1);
    Snapshot fresh;
    save(other.world, fresh);
    ASSERT_EQ(write_snapshot(fresh), bytes_of_all(other.world)) << "its base has been saved into since";
    other = Field(500);
  }
}

TEST(Saving, WorksAfterSnapshotsAndWorldsAreMoved) {
  Field field(300);
  Snapshot first;
  save(field.world, first);
  Snapshot moved = std::move(first);
  World elsewhere = std::move(field.world);
  elsewhere.destroy_body(field.boxes[3]);
  save(elsewhere, moved);
  EXPECT_EQ(write_snapshot(moved), bytes_of_all(elsewhere));
  save(elsewhere, first);
  EXPECT_EQ(write_snapshot(first), bytes_of_all(elsewhere));
  elsewhere.destroy_body(field.boxes[4]);
  first = Snapshot();  // the last one that was saved into
  save(elsewhere, moved);
  EXPECT_EQ(write_snapshot(moved), bytes_of_all(elsewhere));
  const Bytes bytes = write_snapshot(moved);
  elsewhere = World();
  EXPECT_EQ(write_snapshot(moved), bytes);
  save(elsewhere, moved);
  EXPECT_EQ(write_snapshot(moved), bytes_of_all(elsewhere));
}

TEST(Saving, OfAShrunkWorldDropsTheRemovedRows) {
  Field field;
  Snapshot large, again;
  save(field.world, large);
  World small;
  small.create_body({});
  save(small, again);
  const Bytes bytes = write_snapshot(again);
  save(field.world, again);
  restore(field.world, read_snapshot(bytes));
  save(field.world, again);
  EXPECT_EQ(write_snapshot(again), bytes);
  restore(field.world, large);
  save(field.world, again);
  EXPECT_EQ(write_snapshot(again), write_snapshot(large));
  SnapshotChanges changes;
  Snapshot made;
  save(small, again);
  keep_changes(large, again, changes);
  apply_changes(large, changes, made);
  EXPECT_EQ(write_snapshot(made), bytes);
}

TEST(Changes, OfAWorldAtRestStaySmallWhenABodyIsDestroyed) {
  Field field;
  field.run(90);
  Snapshot before, after;
  save(field.world, before);
  field.world.destroy_body(field.boxes[5001]);
  field.run(1);
  save(field.world, after);
  SnapshotChanges changes;
  keep_changes(before, after, changes);
  EXPECT_LT(changes.bytes(), before.bytes() / 50);
  // As many as between snapshots that share nothing.
  SnapshotChanges compared;
  keep_changes(read_snapshot(write_snapshot(before)), read_snapshot(write_snapshot(after)), compared);
  EXPECT_EQ(compared.bytes(), changes.bytes());
}

}  // namespace
}  // namespace scree::test
