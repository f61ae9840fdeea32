// Laws of saving changes: after any calls and steps since the last save, and in any snapshot, the saved bytes
// equal those of a snapshot made from the whole world.
#include <core/state/snapshot/snapshot.h>
#include <core/world/edit.h>
#include <gtest/gtest.h>
#include <tests/core/state/table_bytes.h>
#include <tests/determinism/golden.h>
#include <tests/determinism/many_threads.h>
#include <tests/determinism/player.h>

#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace scree::determinism {
namespace {

using Bytes = std::vector<std::byte>;

// The bytes of the whole world, independent of earlier saves. Leaves the world's marks alone.
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

// Saves repeatedly into some snapshots in turn.
class Ring {
 public:
  explicit Ring(std::size_t size) : kept_(size), bytes_(size) {}

  // Describes the first difference; empty if there is none.
  std::string save_next(World& world) {
    const std::size_t before = place_, place = place_ = (place_ + 1) % kept_.size();
    if (!kept_[place].is_empty() && write_snapshot(kept_[place]) != bytes_[place]) {
      return "a later save has changed a snapshot";
    }
    save(world, kept_[place]);
    bytes_[place] = bytes_of_all(world);
    if (write_snapshot(kept_[place]) != bytes_[place]) return difference(place, bytes_[place]);
    if (kept_[before].is_empty()) return {};
    keep_changes(kept_[before], kept_[place], changes_);
    apply_changes(kept_[before], changes_, again_);
    if (write_snapshot(again_) != bytes_[place]) return "changes make another snapshot";
    return {};
  }

 private:
  std::string difference(std::size_t place, const Bytes& all) const {
    World saved, expected;
    restore(saved, kept_[place]);
    restore(expected, read_snapshot(all));
    std::string first = "a saved snapshot differs from the world";
    const std::vector<test::ColumnBytes> left = test::columns_of(internals(expected)),
                                         right = test::columns_of(internals(saved));
    for (std::size_t i = 0; i < left.size(); ++i) {
      const std::size_t bytes = left[i].bytes();
      if (left[i].member.kind != ColumnKind::state) continue;
      if (bytes == right[i].bytes() &&
          (bytes == 0 || std::memcmp(left[i].first, right[i].first, bytes) == 0)) {
        continue;
      }
      first += ", " + test::name_of(left[i].member);
    }
    return first;
  }

  std::vector<Snapshot> kept_;
  std::vector<Bytes> bytes_;
  std::size_t place_ = 0;
  SnapshotChanges changes_;
  Snapshot again_;
};

// Fills the last pages of bodies, shapes and joints, so that objects of the next call get pages of their own:
// a neighbor's mark then cannot replace a missing mark.
void fill_pages(World& world, BodyId& rack) {
  const WorldData& data = internals(world);
  const auto is_full = [](std::size_t rows) { return rows % kPageRows == 0; };
  const BodyDef far_away{.type = BodyType::fixed, .position = {0.0f, -900.0f, 0.0f}};
  if (!world.is_alive(rack)) rack = world.create_body(far_away);
  while (!data.bodies.free_slots.empty() || !is_full(data.bodies.flags.size())) world.create_body(far_away);
  while (!data.shapes.free_slots.empty() || !is_full(data.shapes.flags.size())) {
    world.add_shape(rack, Sphere{0.1f});
  }
  while (!data.joints.free_slots.empty() || !is_full(data.joints.flags.size())) {
    world.create_joint({.body_a = kWorld, .body_b = rack, .enabled = false}, BallJoint{});
  }
}

struct Habit {
  std::uint64_t seed;
  int calls, bodies;
  std::size_t ring;
  int stride;          // calls between two saves
  bool fills = false;  // pages, so that new objects are alone in theirs

  friend std::ostream& operator<<(std::ostream& out, const Habit& habit) {
    return out << "seed " << habit.seed << ", ring of " << habit.ring << ", every " << habit.stride;
  }
};

std::vector<Habit> habits() {
  std::vector<Habit> all;
  const std::uint64_t seeds = wish("SCREE_RANDOM_SEQUENCES", wants_all_sequences() ? 12 : 4);
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    all.push_back({seed, 250, 24, 1, 1});
    all.push_back({seed, 250, 24, 4, 1});
    all.push_back({seed, 250, 24, 3, 5});
  }
  all.push_back({seeds + 1, 1200, 24, 2, 1});
  all.push_back({seeds + 2, 60, 600, 1, 1});
  all.push_back({seeds + 3, 60, 600, 3, 4});
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    all.push_back({seed, 80, 12, 1, 1, true});
    all.push_back({seed + 100, 160, 12, 2, 3, true});
  }
  return all;
}

class SavedAgain : public ManyThreads, public ::testing::WithParamInterface<Habit> {};

TEST_P(SavedAgain, HoldsTheWorldAfterEveryCallAndStep) {
  const Habit& habit = GetParam();
  const Sequence sequence = with_meshes(random_sequence(habit.seed, habit.calls, habit.bodies));
  Shift shift(schedules(false).back());
  Player player(shift, false, nullptr);
  Ring ring(habit.ring);
  int since = 0, looks = 0;
  BodyId rack;
  const auto look = [&](World& world) {
    // Not every time: filling takes the slots of destroyed objects and marks their pages.
    constexpr std::size_t kMostRows = 100 * kPageRows;
    if (habit.fills && looks++ % 3 == 0 && internals(world).bodies.flags.size() < kMostRows) {
      fill_pages(world, rack);
    }
    if (++since < habit.stride) return;
    since = 0;
    if (const std::string wrong = ring.save_next(world); !wrong.empty()) throw BrokenPromise(wrong);
  };
  player.before_steps(look);
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    try {
      player.make(sequence[i]);
      look(player.world());
    } catch (const BrokenPromise& broken) {
      FAIL() << broken.what() << " at call " << i << ", " << name_of(sequence[i].kind);
    }
  }
}

std::string habit_name(const ::testing::TestParamInfo<Habit>& habit) {
  return "habit_" + std::to_string(habit.index);
}
INSTANTIATE_TEST_SUITE_P(Habits, SavedAgain, ::testing::ValuesIn(habits()), habit_name);

class SavedScenes : public ManyThreads, public ::testing::WithParamInterface<Golden> {};

TEST_P(SavedScenes, AreSavedCompletelyAfterEveryStep) {
  const SceneCase& what = GetParam().what;
  Playback playback(what, ContactEvents::all);
  Shift shift(schedules(false).back());
  std::vector<Ring> often, seldom;
  for (std::size_t world = 0; world < playback.worlds().size(); ++world) {
    often.emplace_back(2);
    seldom.emplace_back(3);
  }
  const int stride = wants_full_matrix() ? 1 : 5;
  for (int i = 0; i < what.steps; ++i) {
    playback.advance(shift.at(i));
    for (std::size_t world = 0; world < often.size(); ++world) {
      if (i % stride == 0) {
        ASSERT_EQ(often[world].save_next(playback.worlds()[world]), "") << "step " << i;
      }
      if (i % (7 * stride) == 3) {
        ASSERT_EQ(seldom[world].save_next(playback.worlds()[world]), "") << "step " << i;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, SavedScenes, ::testing::ValuesIn(scene_goldens()), kGoldenName);

}  // namespace
}  // namespace scree::determinism
