// Laws of snapshots: a restored world continues as if it had never stopped, in every column of the state
// table, whatever world it was restored into and whatever backend it uses.
#include <core/state/snapshot/snapshot_columns.h>
#include <gtest/gtest.h>
#include <tests/determinism/golden.h>
#include <tests/determinism/many_threads.h>
#include <tests/determinism/player.h>

#include <algorithm>
#include <cstring>

namespace scree::determinism {
namespace {

// The first column in which two snapshots differ; empty if they are equal.
std::string difference(const Snapshot& expected, const Snapshot& actual) {
  Column<std::byte> left, right;
  pack_columns(SnapshotAccess::data(expected)->pages->sheets, left);
  pack_columns(SnapshotAccess::data(actual)->pages->sheets, right);
  const SavedColumns left_columns = find_columns(left), right_columns = find_columns(right);
  for (std::size_t i = 0; i < left_columns.count; ++i) {
    const SavedColumn &a = left_columns.column[i], &b = right_columns.column[i];
    if (a.rows == b.rows && a.bytes == b.bytes &&
        std::memcmp(left.data() + a.begin, right.data() + b.begin, a.bytes) == 0) {
      continue;
    }
    return std::string(a.store) + "." + std::string(a.name) + ": " + std::to_string(b.rows) +
           " rows, expected " + std::to_string(a.rows);
  }
  return {};
}

// Data of living bodies and shapes that a restore derives from the state.
std::string derived_difference(World& expected, World& actual) {
  const WorldData &left = internals(expected), &right = internals(actual);
  const auto differ = [](const auto& a, const auto& b, std::size_t row) {
    return std::memcmp(static_cast<const void*>(&a[row]), static_cast<const void*>(&b[row]), sizeof a[row]) !=
           0;
  };
  for (std::size_t row = 0; row < left.bodies.flags.size(); ++row) {
    if ((left.bodies.flags[row] & kBodyAlive) == 0) continue;
    const std::string place = " of row " + std::to_string(row);
    if (differ(left.bodies.transform, right.bodies.transform, row)) return "transform" + place;
    if (differ(left.bodies.core, right.bodies.core, row)) return "core" + place;
  }
  for (std::size_t row = 0; row < left.shapes.flags.size(); ++row) {
    if ((left.shapes.flags[row] & kShapeAlive) == 0) continue;
    if (differ(left.shapes.local_pose, right.shapes.local_pose, row)) {
      return "local_pose of row " + std::to_string(row);
    }
  }
  const bool counts = left.bodies.alive == right.bodies.alive && left.shapes.alive == right.shapes.alive &&
                      left.shapes.asking == right.shapes.asking;
  return counts ? std::string() : "the number of bodies or shapes";
}

std::string difference(std::vector<World>& expected, std::vector<World>& actual) {
  Snapshot left, right;
  for (std::size_t world = 0; world < expected.size(); ++world) {
    save(expected[world], left);
    save(actual[world], right);
    std::string found = difference(left, right);
    if (found.empty()) found = derived_difference(expected[world], actual[world]);
    if (!found.empty()) return "world " + std::to_string(world) + ", " + found;
  }
  return {};
}

class Snapshots : public ManyThreads, public ::testing::WithParamInterface<Golden> {};

TEST_P(Snapshots, ARestoredWorldCanTakeEveryStep) {
  const SceneCase& what = GetParam().what;
  Playback expected(what), actual(what);
  Shift reference({kReference}), shift(schedules(false).back());
  Snapshot snapshot;
  const int stride = wants_full_matrix() ? 1 : 10;
  for (int i = 0; i < what.steps; ++i) {
    for (std::size_t world = 0; i % stride == 0 && world < expected.worlds().size(); ++world) {
      save(expected.worlds()[world], snapshot);
      restore(actual.worlds()[world], snapshot);
    }
    if (i % stride == 0) {
      ASSERT_EQ(difference(expected.worlds(), actual.worlds()), "") << "restored before step " << i;
    }
    expected.advance(reference.at(i));
    actual.advance(shift.at(i));
    if (i % stride != 0) continue;
    ASSERT_EQ(difference(expected.worlds(), actual.worlds()), "") << "in step " << i;
  }
}

TEST_P(Snapshots, RestoredWorldsGoOnToTheEndWithTheSameEvents) {
  const SceneCase& what = GetParam().what;
  const int stride = wants_full_matrix() ? 1 : 10;
  for (const int from : {1, what.steps / 2}) {
    if (from == 1 && !wants_full_matrix()) continue;
    Playback expected(what, ContactEvents::all), strayed(what, ContactEvents::all);
    Playback fresh(what, ContactEvents::all);
    Shift reference({kReference}), shift(schedules(false).back()), wide(schedules(false).front());
    for (int i = 0; i < what.steps; ++i) {
      if (i == from) {
        for (std::size_t world = 0; world < expected.worlds().size(); ++world) {
          Snapshot snapshot;
          save(expected.worlds()[world], snapshot);
          lead_astray(strayed.worlds()[world], shift.at(i));
          restore(strayed.worlds()[world], snapshot);
          World blank;
          blank.share_handles(fresh.worlds()[world]);
          fresh.worlds()[world] = std::move(blank);
          restore(fresh.worlds()[world], read_snapshot(write_snapshot(snapshot)));
        }
      }
      expected.advance(reference.at(i));
      strayed.advance(shift.at(i));
      fresh.advance(wide.at(i));
      if (i % stride != 0) continue;
      ASSERT_EQ(difference(expected.worlds(), strayed.worlds()), "") << "strayed, in step " << i;
      ASSERT_EQ(difference(expected.worlds(), fresh.worlds()), "") << "fresh, in step " << i;
      for (std::size_t world = 0; world < expected.worlds().size(); ++world) {
        const std::uint64_t events = digest_of_events(expected.worlds()[world]);
        ASSERT_EQ(digest_of_events(strayed.worlds()[world]), events) << i;
        ASSERT_EQ(digest_of_events(fresh.worlds()[world]), events) << i;
      }
    }
    ASSERT_EQ(expected.hash(), GetParam().digest.last);
    Snapshot left, right;
    save(expected.worlds().front(), left);
    save(fresh.worlds().front(), right);
    ASSERT_EQ(write_snapshot(left), write_snapshot(right));
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Snapshots, ::testing::ValuesIn(scene_goldens()), kGoldenName);

class RandomSnapshots : public ManyThreads, public ::testing::WithParamInterface<std::uint64_t> {};

TEST_P(RandomSnapshots, CallsCannotDistinguishAWorldRestoredBeforeEachStep) {
  const Sequence sequence = with_meshes(random_sequence(GetParam(), 200, 24));
  const Played expected = play(sequence, {kReference}, false);
  ASSERT_EQ(expected.broken_promise, "");
  Shift shift(schedules(false).back());
  Player player(shift, false, nullptr);
  Snapshot snapshot;
  int steps = 0;
  player.before_steps([&](World& world) {
    save(world, snapshot);
    if (++steps % 3 == 0) {
      lead_astray(world, shift.at(steps));
      restore(world, snapshot);
    } else if (steps % 3 == 1) {
      world = clone(world);
    } else {
      restore(world, read_snapshot(write_snapshot(snapshot)));
    }
  });
  for (const Call& call : sequence) player.make(call);
  EXPECT_EQ(player.hashes(), expected.hashes);
}

// Only a restored world reads all resting pairs to list the events of contacts.
TEST_P(RandomSnapshots, EventsCannotDistinguishAWorldRestoredBeforeEachStep) {
  const Sequence sequence = random_sequence(GetParam(), 200, 24);
  const auto events_of = [&](bool restores) {
    Shift shift({kReference});
    Player player(shift, false, nullptr);
    Snapshot snapshot;
    std::vector<std::uint64_t> digests;
    player.before_steps([&](World& world) {
      digests.push_back(digest_of_events(world));
      if (!restores) return;
      save(world, snapshot);
      restore(world, snapshot);
    });
    for (const Call& call : sequence) player.make(call);
    return digests;
  };
  EXPECT_EQ(events_of(true), events_of(false));
}

std::uint64_t snapshot_seeds() { return wish("SCREE_RANDOM_SEQUENCES", wants_all_sequences() ? 20 : 4); }
INSTANTIATE_TEST_SUITE_P(Seeds, RandomSnapshots, ::testing::Range(std::uint64_t{1}, snapshot_seeds() + 1),
                         ::testing::PrintToStringParamName());

}  // namespace
}  // namespace scree::determinism
