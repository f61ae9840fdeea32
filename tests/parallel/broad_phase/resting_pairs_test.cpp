// Laws of resting pairs: each is found from both of its shapes, and the lists hold no other pairs. A change
// reads only the pairs that it concerns, and its results are those of a search of all pairs.
#include "field.h"

#include <core/state/snapshot/snapshot_bytes.h>
#include <core/world/pair_key.h>
#include <core/world/resting_pairs.h>
#include <core/world/wake.h>
#include <gtest/gtest.h>
#include <parallel/broad_phase/broad_phase.h>
#include <scree/scree.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <vector>

namespace scree {
namespace {

using testing::Field;
using testing::Random;

constexpr float kRestingStep = 1.0f / 60.0f;

std::size_t index_of(std::int32_t row) { return static_cast<std::size_t>(row); }

std::vector<std::int32_t> rows_of(WorldData& data, std::int32_t shape) {
  std::vector<std::int32_t> rows;
  for_each_resting(data, shape, [&](std::int32_t row, std::int32_t other) {
    const ShapePair pair = data.contacts.resting.pair[index_of(row)];
    EXPECT_EQ(pair.a == shape ? pair.b : pair.a, other);
    rows.push_back(row);
  });
  std::sort(rows.begin(), rows.end());
  return rows;
}

// The lists match the rows, for every shape.
void expect_sound_lists(WorldData& data) {
  const Contacts& contacts = data.contacts;
  std::vector<std::vector<std::int32_t>> expected(data.shapes.flags.size());
  std::set<std::uint64_t> keys;
  for (std::size_t row = 0; row < contacts.resting.pair.size(); ++row) {
    const ShapePair pair = contacts.resting.pair[row];
    expected[index_of(pair.a)].push_back(static_cast<std::int32_t>(row));
    expected[index_of(pair.b)].push_back(static_cast<std::int32_t>(row));
    keys.insert(key_of(pair));
  }
  EXPECT_EQ(keys.size(), contacts.resting.pair.size()) << "a pair stands there twice";
  ASSERT_EQ(contacts.resting_links.size(), contacts.resting.pair.size());
  for (std::size_t shape = 0; shape < expected.size(); ++shape) {
    ASSERT_EQ(rows_of(data, static_cast<std::int32_t>(shape)), expected[shape]) << "shape " << shape;
  }
}

TEST(RestingPairs, AreFoundFromBothShapesUnderRandomCalls) {
  Workers workers(2);
  Field field(5, 600);
  field.hulls = true;
  std::size_t most = 0;
  for (int i = 0; i < 500; ++i) {
    for (int k = i % 5; k > 0; --k) field.change_something();
    step(field.world, kRestingStep, workers);
    WorldData& data = internals(field.world);
    expect_sound_lists(data);
    if (HasFatalFailure()) return;
    // All pairs of two frozen shapes are there, or rest in the next step.
    for (const ShapePair& pair : data.contacts.resting.pair) {
      ASSERT_TRUE(is_frozen_tree(broad_phase_of(data).tree_of[index_of(pair.a)]) &&
                  is_frozen_tree(broad_phase_of(data).tree_of[index_of(pair.b)]));
    }
    most = std::max(most, data.contacts.resting.pair.size());
  }
  EXPECT_GT(most, 50u);
}

TEST(RestingPairs, ReportTheirForcesInTheOrderOfThePairs) {
  Workers workers(1);
  Field field(6, 300);
  WorldSettings settings = field.world.settings();
  settings.contact_forces = true;
  field.world.set_settings(settings);
  std::size_t most = 0, unordered = 0;
  for (int i = 0; i < 400; ++i) {
    for (int k = i % 3; k > 0; --k) field.change_something();
    step(field.world, kRestingStep, workers);
    const WorldData& data = internals(field.world);
    const Column<ShapePair>& resting = data.contacts.resting.pair;
    unordered += std::is_sorted(resting.begin(), resting.end(), comes_before) ? 0 : 1;
    std::vector<ContactForces> told(data.contacts.now.pair.size());
    told.resize(field.world.contact_forces(told));
    const auto key = [](const ContactForces& x) { return pair_key(x.shape_a.index, x.shape_b.index); };
    for (std::size_t k = 1; k < told.size(); ++k) ASSERT_LT(key(told[k - 1]), key(told[k])) << i;
    // Of each shape, those of all that name it.
    std::map<std::uint32_t, std::vector<std::uint64_t>> of_shape;
    for (const ContactForces& x : told) {
      of_shape[x.shape_a.index].push_back(key(x));
      of_shape[x.shape_b.index].push_back(key(x));
    }
    for (std::uint32_t shape = 0; shape < data.shapes.flags.size(); ++shape) {
      const ShapeId id{shape, data.shapes.generation[shape]};
      if (!field.world.is_alive(id)) continue;
      std::vector<ContactForces> some(told.size());
      some.resize(field.world.contact_forces_of(id, some));
      std::vector<std::uint64_t> keys;
      for (const ContactForces& x : some) keys.push_back(key(x));
      ASSERT_EQ(keys, of_shape[shape]) << "step " << i << ", shape " << shape;
    }
    most = std::max(most, told.size());
  }
  EXPECT_GT(most, 30u);
  EXPECT_GT(unordered, 100u);
}

// Hash of a row.
struct Held {
  std::int32_t contact;
  ContactAxis axis;
  TouchRow touches;
};

Held held_of(std::int32_t contact, std::int32_t a, std::int32_t b) {
  Held held{contact, {}, {}};
  std::memset(static_cast<void*>(&held.axis), static_cast<int>(contact % 251), sizeof held.axis);
  held.touches.pair.shape_a.index = static_cast<std::uint32_t>(a);
  held.touches.pair.shape_b.index = static_cast<std::uint32_t>(b);
  held.touches.events = 1 + static_cast<std::uint32_t>(contact) % 3;
  return held;
}

TEST(RestingPairs, KeepTheirDataWhileOtherPairsComeAndGo) {
  World world;
  WorldData& data = internals(world);
  Contacts& contacts = data.contacts;
  constexpr std::int32_t kShapes = 60;
  data.shapes.resize(kShapes);
  Random random(8);
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> expected;  // pair -> contact
  std::int32_t next = 0;
  for (int round = 0; round < 300; ++round) {
    PairRows more;
    for (std::uint32_t i = random.below(40); i > 0; --i) {
      const auto a = static_cast<std::int32_t>(random.below(kShapes - 1));
      const auto b =
          a + 1 + static_cast<std::int32_t>(random.below(static_cast<std::uint32_t>(kShapes - 1 - a)));
      if (!expected.emplace(std::pair{a, b}, next).second) continue;
      more.pair.push_back({a, b});
      more.contact.push_back(next);
      more.axis.push_back(held_of(next++, a, b).axis);
    }
    const std::size_t first = contacts.resting.pair.size();
    add_resting(data, more);
    data.events.resting.resize(contacts.resting.pair.size());
    for (std::size_t row = first; row < contacts.resting.pair.size(); ++row) {
      const ShapePair pair = contacts.resting.pair[row];
      data.events.resting[row] = held_of(contacts.resting.contact[row], pair.a, pair.b).touches;
    }
    // Few, most or all of them go.
    const std::uint32_t share = round % 50 == 49 ? 1 : round % 10 == 9 ? 2 : 6;
    Column<std::int32_t> rows;
    for (std::size_t row = 0; row < contacts.resting.pair.size(); ++row) {
      if (share > 1 && random.below(6) >= 6 / share) continue;
      rows.push_back(static_cast<std::int32_t>(row));
      const ShapePair pair = contacts.resting.pair[row];
      expected.erase({pair.a, pair.b});
    }
    remove_resting(data, rows);
    ASSERT_EQ(contacts.resting.pair.size(), expected.size());
    ASSERT_EQ(contacts.resting.axis.size(), expected.size());
    ASSERT_EQ(data.events.resting.size(), expected.size());
    expect_sound_lists(data);
    for (std::size_t row = 0; row < expected.size(); ++row) {
      const ShapePair pair = contacts.resting.pair[row];
      const Held held = held_of(expected.at({pair.a, pair.b}), pair.a, pair.b);
      ASSERT_EQ(contacts.resting.contact[row], held.contact);
      ASSERT_EQ(std::memcmp(&contacts.resting.axis[row], &held.axis, sizeof held.axis), 0);
      ASSERT_EQ(std::memcmp(&data.events.resting[row], &held.touches, sizeof held.touches), 0);
    }
  }
}

TEST(RestingPairs, GetAxesOnceAShapeBecomesAHull) {
  World world;
  WorldData& data = internals(world);
  data.shapes.resize(4);
  PairRows round, hull;
  round.pair.push_back({0, 1});
  round.contact.push_back(-1);
  hull.pair.push_back({0, 2});
  hull.contact.push_back(-1);
  hull.axis.push_back(held_of(7, 0, 2).axis);
  add_resting(data, round);
  EXPECT_TRUE(data.contacts.resting.axis.empty());
  add_resting(data, hull);
  round.pair[0] = {1, 3};
  add_resting(data, round);
  ASSERT_EQ(data.contacts.resting.axis.size(), 3u);
  const ContactAxis none{};
  EXPECT_EQ(std::memcmp(&data.contacts.resting.axis[0], &none, sizeof none), 0);
  EXPECT_EQ(std::memcmp(&data.contacts.resting.axis[1], &hull.axis[0], sizeof none), 0);
  EXPECT_EQ(std::memcmp(&data.contacts.resting.axis[2], &none, sizeof none), 0);
}

// Sleepers on one floor, in rows of ten side by side, each an island.
class Rows {
 public:
  static constexpr int kLength = 10;

  explicit Rows(int count, ContactEvents events = ContactEvents::none) {
    WorldSettings settings;
    settings.sleep_time = 0.05f;
    settings.contact_events = events;
    settings.contact_forces = true;
    world = World(settings);
    floor = world.create_body({.type = BodyType::fixed, .position = {0, -1, 0}});
    world.add_shape(floor, Box{{2000, 1, 2000}});
    for (int i = 0; i < count * kLength; ++i) {
      const int row = i / kLength;
      boxes.push_back(world.create_body(
          {.position = {static_cast<float>(i % kLength) + 20.0f * static_cast<float>(row % 50), 0.5f,
                        2.0f * static_cast<float>(row / 50)}}));
      world.add_shape(boxes.back(), Box{});
    }
    settle();
  }
  // Number of resting pairs read until all bodies sleep again.
  std::int64_t settle() {
    std::int64_t looks = 0;
    int quiet = 0;
    for (int i = 0; i < 300 && quiet < 3; ++i) {
      looks += looks_of_step();
      quiet = world.stats().awake_bodies == 0 ? quiet + 1 : 0;
    }
    EXPECT_EQ(quiet, 3);
    return looks;
  }
  std::int64_t looks_of_step() {
    const std::int64_t before = internals(world).contacts.resting_looks;
    step(world, kRestingStep, workers_);
    return internals(world).contacts.resting_looks - before;
  }

  World world;
  BodyId floor;
  std::vector<BodyId> boxes;

 private:
  Workers workers_{1};
};

// Resting pairs read for one change each, with the steps until all bodies sleep again.
std::vector<std::int64_t> looks_of_changes(int count, ContactEvents events) {
  Rows rows(count, events);
  World& world = rows.world;
  EXPECT_GE(internals(world).contacts.resting.pair.size(), static_cast<std::size_t>(19 * count));
  std::vector<std::int64_t> looks;
  looks.push_back(rows.settle());  // nothing happens
  world.wake(rows.boxes[13]);
  looks.push_back(rows.settle());
  world.destroy_body(rows.boxes[25]);
  looks.push_back(rows.settle());
  world.set_linear_velocity(rows.boxes[31], {0, 1, 0});
  looks.push_back(rows.settle());
  ShapeId shape;
  world.shapes_of(rows.boxes[45], {&shape, 1});
  world.set_material(shape, {.friction = 0.9f});
  looks.push_back(rows.settle());
  world.set_contact_events(shape, ContactEvents::all);
  looks.push_back(rows.settle());
  const BodyId ball = world.create_body({.position = {5.0f, 2.0f, 0}});
  world.add_shape(ball, Sphere{0.4f}, {.rolling_resistance = 0.3f});
  looks.push_back(rows.settle());
  const std::int64_t before = internals(world).contacts.resting_looks;
  std::vector<ContactForces> told(10);
  world.contact_forces_of(rows.boxes[45], told);
  looks.push_back(internals(world).contacts.resting_looks - before);
  return looks;
}

TEST(RestingPairs, AChangeReadsAsFewInALargeWorldAsInASmallOne) {
  for (const ContactEvents events : {ContactEvents::none, ContactEvents::begin_end}) {
    const std::vector<std::int64_t> few = looks_of_changes(60, events), many = looks_of_changes(600, events);
    EXPECT_EQ(few, many);
    EXPECT_EQ(few[0], 0);
    for (std::size_t i = 1; i < few.size(); ++i) {
      // A row has 19 pairs. Each is read from both ends: once to follow it and, in the next step, once to
      // remove it.
      EXPECT_GT(few[i], 0) << "change " << i;
      EXPECT_LE(few[i], 4 * 2 * 19) << "change " << i;
    }
  }
}

TEST(RestingPairs, OfAMovedFloorAreAllRead) {
  Rows rows(100);
  const std::size_t pairs = internals(rows.world).contacts.resting.pair.size();
  rows.world.set_pose(rows.floor, {{0, -1.001f, 0}, {}});
  EXPECT_GE(rows.looks_of_step(), 1000);
  EXPECT_EQ(rows.world.stats().awake_bodies, 1000);
  rows.looks_of_step();
  EXPECT_TRUE(internals(rows.world).contacts.resting.pair.empty());
  rows.settle();
  EXPECT_EQ(internals(rows.world).contacts.resting.pair.size(), pairs);
}

// The sleepers connected with the body by contacts and joints, by a search of all of them.
std::set<BodyId> island_of(World& world, BodyId body) {
  const WorldData& data = internals(world);
  std::vector<std::int32_t> root(data.bodies.flags.size());
  std::iota(root.begin(), root.end(), 0);
  const auto unite = [&](std::int32_t a, std::int32_t b) {
    if ((data.bodies.flags[index_of(a)] & data.bodies.flags[index_of(b)] & kBodyAsleep) == 0) return;
    const std::int32_t from = root[index_of(a)], to = root[index_of(b)];
    std::replace(root.begin(), root.end(), from, to);
  };
  for (std::size_t row = 0; row < data.contacts.now.pair.size(); ++row) {
    const ShapePair pair = data.contacts.now.pair[row];
    if (data.contacts.now.points[row] != 0)
      unite(data.shapes.body[index_of(pair.a)], data.shapes.body[index_of(pair.b)]);
  }
  for (std::size_t row = 0; row < data.joints.flags.size(); ++row) {
    constexpr std::uint8_t kWhole = kJointAlive | kJointEnabled;
    if ((data.joints.flags[row] & kWhole) == kWhole)
      unite(data.joints.bodies[row].a, data.joints.bodies[row].b);
  }
  std::set<BodyId> island;
  for (std::uint32_t i = 0; i < root.size(); ++i) {
    if (root[i] == root[body.index] && (data.bodies.flags[i] & kBodyAsleep) != 0)
      island.insert(body_handle(data, static_cast<std::int32_t>(i)));
  }
  return island;
}

std::vector<std::uint64_t> listed_contacts(const WorldData& data) {
  std::vector<std::uint64_t> keys;
  for (const std::int32_t contact : data.contacts.active)
    keys.push_back(key_of(data.contacts.now.pair[index_of(contact)]));
  return keys;
}

// All contacts with an awake body, in the order of their pairs.
std::vector<std::uint64_t> awake_contacts(const WorldData& data) {
  std::vector<std::uint64_t> keys;
  for (std::size_t row = 0; row < data.contacts.now.pair.size(); ++row) {
    const ShapePair pair = data.contacts.now.pair[row];
    if (data.contacts.now.points[row] == 0) continue;
    if (is_awake_dynamic(data.bodies, data.shapes.body[index_of(pair.a)]) ||
        is_awake_dynamic(data.bodies, data.shapes.body[index_of(pair.b)])) {
      keys.push_back(key_of(pair));
    }
  }
  std::sort(keys.begin(), keys.end());
  return keys;
}

TEST(RousedIslands, AreWhatContactsAndJointsConnect) {
  Random random(12);
  std::size_t largest = 0;
  for (int trial = 0; trial < 12; ++trial) {
    Workers workers(1);
    WorldSettings settings;
    settings.sleep_time = 0.05f;
    World world(settings);
    world.add_shape(world.create_body({.type = BodyType::fixed, .position = {0, -1, 0}}), Box{{200, 1, 200}});
    std::vector<BodyId> boxes;
    for (int i = 0; i < 150; ++i) {  // on a grid, of which half the places are taken
      boxes.push_back(world.create_body(
          {.position = {static_cast<float>(random.below(18)), 0.5f,
                        1.002f * static_cast<float>(i % 15) + 40.0f * static_cast<float>(i / 75)}}));
      world.add_shape(boxes.back(), Box{{0.499f, 0.5f, 0.499f}});
    }
    for (int i = 0; i < 25; ++i) {
      const BodyId a = boxes[random.below(150)], b = boxes[random.below(150)];
      if (a == b) continue;
      const float apart = length(world.pose(a).position - world.pose(b).position);
      world.create_joint({.body_a = a, .body_b = b, .enabled = random.below(4) != 0},
                         DistanceJoint{.length = {.lower = 0.0f, .upper = apart + 1.0f}});
    }
    for (int i = 0; i < 600 && (i < 3 || world.stats().awake_bodies > 0); ++i)
      step(world, kRestingStep, workers);
    ASSERT_EQ(world.stats().awake_bodies, 0) << trial;
    step(world, kRestingStep, workers);
    const BodyId first = boxes[random.below(150)];
    const std::set<BodyId> expected = island_of(world, first);
    world.wake(first);
    step(world, kRestingStep, workers);
    const std::set<BodyId> woken(world.sleep_ends().begin(), world.sleep_ends().end());
    EXPECT_EQ(woken, expected) << trial;
    EXPECT_EQ(listed_contacts(internals(world)), awake_contacts(internals(world))) << trial;
    largest = std::max(largest, expected.size());
  }
  EXPECT_GT(largest, 20u);
}

template <class Rows>
bool same_bytes(const Rows& x, const Rows& y) {
  return x.size() == y.size() && (x.empty() || std::memcmp(x.data(), y.data(), x.size_bytes()) == 0);
}

// A restored world reads all resting pairs to list its events.
TEST(RestingPairs, ListTheSameEventsAsASearchOfAllPairs) {
  constexpr ContactEvents kAsked[] = {ContactEvents::none, ContactEvents::begin_end, ContactEvents::persist,
                                      ContactEvents::all};
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
    Workers workers(1), others(3);
    Field field(seed, 400);
    Random random(seed + 100);
    Snapshot snapshot;
    World restored;
    std::size_t begins = 0, ends = 0;
    std::int64_t most_at_rest = 0, fewest_looks = 1000;
    for (int i = 0; i < 400; ++i) {
      for (int k = i % 3; k > 0; --k) field.change_something();
      WorldData& data = internals(field.world);
      if (random.below(20) == 0 || (i % 100 == 50 && seed % 2 == 0)) {
        WorldSettings settings = field.world.settings();
        settings.contact_events = kAsked[random.below(4)];
        field.world.set_settings(settings);
      }
      if (random.below(3) == 0) {
        const std::uint32_t shape = random.below(static_cast<std::uint32_t>(data.shapes.flags.size()));
        const ShapeId id{shape, data.shapes.generation[shape]};
        if (field.world.is_alive(id)) field.world.set_contact_events(id, kAsked[random.below(4)]);
      }
      save(field.world, snapshot);
      restore(restored, snapshot);
      const float dt = random.below(10) == 0 ? 0.0f : kRestingStep;
      const std::int64_t looks = data.contacts.resting_looks;
      step(field.world, dt, workers);
      step(restored, dt, others);
      fewest_looks = std::min(fewest_looks, data.contacts.resting_looks - looks);
      ASSERT_TRUE(same_bytes(field.world.contact_begins(), restored.contact_begins())) << seed << " " << i;
      ASSERT_TRUE(same_bytes(field.world.contact_persists(), restored.contact_persists()))
          << seed << " " << i;
      ASSERT_TRUE(same_bytes(field.world.contact_ends(), restored.contact_ends())) << seed << " " << i;
      EXPECT_EQ(data.events.resting_touches,
                std::count_if(data.events.resting.begin(), data.events.resting.end(),
                              [](const TouchRow& row) { return row.events != 0; }));
      most_at_rest = std::max(most_at_rest, data.events.resting_touches);
      begins += field.world.contact_begins().size();
      ends += field.world.contact_ends().size();
    }
    EXPECT_GT(begins, 50u);
    EXPECT_GT(ends, 50u);
    EXPECT_GT(most_at_rest, 20);
    EXPECT_EQ(fewest_looks, 0);
  }
}

// Bytes of a world with sleepers that `damage` has changed before it was saved.
template <class Damage>
std::string refusal_of(Damage&& damage) {
  Rows rows(3, ContactEvents::all);
  damage(internals(rows.world));
  Snapshot snapshot;
  save(rows.world, snapshot);
  try {
    World other;
    restore(other, read_snapshot(write_snapshot(snapshot)));
    Workers workers(1);
    step(other, kRestingStep, workers);
    step(rows.world, kRestingStep, workers);
    EXPECT_EQ(other.hash(), rows.world.hash());
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(RestingPairs, AreRefusedInSnapshotsThatNoWorldCouldMake) {
  const auto expect = [](const std::string& reason, auto&& damage) {
    const std::string refusal = refusal_of(damage);
    EXPECT_NE(refusal.find(reason), std::string::npos) << refusal << " instead of " << reason;
  };
  const auto first = [](WorldData& data) -> TouchRow& { return data.events.resting[0]; };
  expect("stands there twice", [](WorldData& data) {
    data.contacts.resting.pair[1] = data.contacts.resting.pair[0];
    data.contacts.resting.contact[1] = -1;
    data.events.resting[1] = {};
  });
  expect("contacts.resting.pair, row 2: names no two shapes",
         [](WorldData& data) { data.contacts.resting.pair[2].b = 1000; });
  expect("contacts.resting.pair, row 0: stands in both lists", [](WorldData& data) {
    data.contacts.pairs.pair.push_back(data.contacts.resting.pair[0]);
    data.contacts.pairs.contact.push_back(-1);
  });
  expect("events.resting, row 0: asks for nothing, or is another pair's",
         [&](WorldData& data) { first(data).events = 4; });
  expect("events.resting, row 0: asks for nothing, or is another pair's",
         [&](WorldData& data) { first(data).events = 0; });
  expect("events.resting, row 0: asks for nothing, or is another pair's",
         [&](WorldData& data) { first(data).pair.shape_b.index += 1; });
  expect("events.resting, row 0: stands among those that move, too",
         [&](WorldData& data) { data.events.touching.push_back(first(data)); });
  expect("events.resting, row 0: wrong number of rows",
         [](WorldData& data) { data.events.resting.pop_back(); });
}

TEST(RestingPairs, MayLieInAnyOrder) {
  EXPECT_EQ(refusal_of([](WorldData& data) {
              std::reverse(data.contacts.resting.pair.begin(), data.contacts.resting.pair.end());
              std::reverse(data.contacts.resting.contact.begin(), data.contacts.resting.contact.end());
              std::reverse(data.events.resting.begin(), data.events.resting.end());
              link_resting(data);
            }),
            "");
}

}  // namespace
}  // namespace scree
