// collide(): the rows that it writes, how rows follow changes of the list, colors, and the list of touching
// rows.
#include <gtest/gtest.h>
#include <parallel/narrow_phase/narrow_phase.h>
#include <parallel/stages.h>

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

namespace scree {
namespace {

// Spheres of radius 0.5 m; those that are 1 m apart touch.
struct Scene {
  WorldData data;

  std::int32_t add(BodyType type, ShapeType shape, Vec3 position, std::uint8_t flags = 0) {
    const std::size_t body = std::max<std::size_t>(data.bodies.type.size(), kFirstBody);
    data.bodies.resize(body + 1);
    data.bodies.type[body] = type;
    data.bodies.flags[body] = static_cast<std::uint8_t>(kBodyAlive | flags);
    const PoseRow pose{{position.x, position.y, position.z}, 0, {0, 0, 0, 1}};
    data.bodies.pose[body] = pose;
    const std::size_t index = data.shapes.type.size();
    data.shapes.resize(index + 1);
    data.shapes.type[index] = shape;
    data.shapes.body[index] = static_cast<std::int32_t>(body);
    data.shapes.pose[index] = pose;
    data.shapes.extent[index] = {{0.5f, 0.5f, 0.5f}, 0.5f};
    if (shape == ShapeType::capsule) data.shapes.extent[index] = {{0, 0.25f, 0}, 0.25f};
    data.shapes.material[index] = {0.5f, 0, 0, 3 | 4 << 8, {0, 0, 0}, 0};
    return static_cast<std::int32_t>(index);
  }
  void lift(std::int32_t shape, float height) {
    const auto index = static_cast<std::size_t>(shape);
    data.shapes.pose[index].position[1] = height;
    data.bodies.pose[static_cast<std::size_t>(data.shapes.body[index])].position[1] = height;
  }
  std::uint8_t& flags_of(std::int32_t shape) {
    return data.bodies.flags[static_cast<std::size_t>(data.shapes.body[static_cast<std::size_t>(shape)])];
  }
  // As find_pairs does: kept pairs keep their contacts, the rows of other contacts become free.
  void set_pairs(const std::vector<ShapePair>& list) {
    Contacts& contacts = data.contacts;
    std::swap(contacts.pairs, contacts.pairs_before);
    PairRows &pairs = contacts.pairs, &before = contacts.pairs_before;
    pairs.resize(list.size());
    contacts.last_place.resize(list.size());
    for (std::size_t row = 0; row < list.size(); ++row) {
      pairs.pair[row] = list[row];
      contacts.last_place[row] = pairs.contact[row] = -1;
      for (std::size_t old = 0; old < before.pair.size(); ++old) {
        if (before.pair[old].a == list[row].a && before.pair[old].b == list[row].b) {
          contacts.last_place[row] = static_cast<std::int32_t>(old);
          pairs.contact[row] = std::exchange(before.contact[old], -1);
        }
      }
    }
    for (const std::int32_t contact : before.contact) {
      if (contact < 0) continue;
      contacts.now.points[static_cast<std::size_t>(contact)] = 0;
      contacts.free_rows.push_back(contact);
    }
    contacts.list_kept = false;
    contacts.last_number = contacts.list_number++;
  }
  void step() {
    Crew crew(workers);
    collide(data, crew);
  }
  // The pairs that are listed as touching, in the order of the list.
  std::vector<std::int32_t> touching() const {
    std::vector<std::int32_t> rows;
    for (const std::int32_t contact : data.contacts.active) {
      const Column<std::int32_t>& all = data.contacts.pairs.contact;
      rows.push_back(static_cast<std::int32_t>(std::find(all.begin(), all.end(), contact) - all.begin()));
    }
    return rows;
  }
  bool touches(std::size_t row) const { return data.contacts.pairs.contact[row] >= 0; }
  std::size_t contact(std::size_t row) const {
    return static_cast<std::size_t>(data.contacts.pairs.contact[row]);
  }
  Manifold& manifold(std::size_t row) { return data.contacts.now.manifold[contact(row)]; }
  std::uint8_t& color(std::size_t row) { return data.contacts.now.color[contact(row)]; }

  Workers workers{1};
};

using RowList = std::vector<std::int32_t>;

TEST(Collide, ListsTouchingRowsOfAwakeDynamicBodiesInAscendingOrder) {
  Scene scene;
  const ShapeType kinds[] = {ShapeType::box, ShapeType::sphere, ShapeType::capsule};
  std::vector<ShapePair> pairs;
  RowList expected;
  for (int k = 0; k < 3000; ++k) {
    const float x = 10.0f * float(k), gap = k % 4 == 0 ? 0.3f : 0.0f;
    const float reach = (k % 3 == 2 ? 0.25f : 0.5f) + ((k / 3) % 3 == 2 ? 0.25f : 0.5f);
    const std::int32_t a = scene.add(BodyType::dynamic, kinds[k % 3], {x, 0, 0});
    const std::int32_t b = scene.add(BodyType::dynamic, kinds[(k / 3) % 3], {x + reach + gap, 0, 0});
    pairs.push_back({a, b});
    if (gap == 0.0f) expected.push_back(k);
  }
  scene.set_pairs(pairs);
  scene.step();
  EXPECT_EQ(scene.touching(), expected);
  for (std::size_t row = 0; row < pairs.size(); ++row) {
    EXPECT_EQ(scene.touches(row), row % 4 != 0) << row;
  }
}

TEST(Collide, ContactsKeepTheirRowsWhenTheListChanges) {
  Scene scene;
  for (int k = 0; k < 4; ++k) scene.add(BodyType::dynamic, ShapeType::sphere, {float(k), 0, 0});
  scene.set_pairs({{0, 1}, {2, 3}});
  scene.step();
  for (std::size_t row = 0; row < 2; ++row) {
    scene.manifold(row).normal_impulse[0] = 1.0f + float(row);
    EXPECT_EQ(scene.color(row), kNoColor);
    scene.color(row) = static_cast<std::uint8_t>(5 + row);
  }
  scene.data.contacts.list_kept = true;
  scene.step();
  EXPECT_EQ(scene.manifold(1).normal_impulse[0], 2.0f);
  EXPECT_EQ(scene.color(1), 6);
  const std::size_t kept = scene.contact(1);

  scene.set_pairs({{1, 2}, {2, 3}});
  scene.step();
  EXPECT_EQ(scene.manifold(0).normal_impulse[0], 0.0f);
  EXPECT_EQ(scene.color(0), kNoColor);
  EXPECT_EQ(scene.contact(1), kept);
  EXPECT_EQ(scene.manifold(1).normal_impulse[0], 2.0f);
  EXPECT_EQ(scene.color(1), 6);
}

TEST(Collide, APairThatSeparatesLosesItsRowAndColor) {
  Scene scene;
  scene.add(BodyType::dynamic, ShapeType::sphere, {0, 0, 0});
  scene.add(BodyType::dynamic, ShapeType::sphere, {1, 0, 0});
  scene.set_pairs({{0, 1}});
  scene.step();
  scene.color(0) = 3;
  scene.data.shapes.pose[1].position[0] = 1.5f;
  scene.data.contacts.list_kept = true;
  scene.step();
  EXPECT_FALSE(scene.touches(0));
  EXPECT_TRUE(scene.touching().empty());
  EXPECT_EQ(scene.data.contacts.free_rows.size(), scene.data.contacts.now.pair.size());
  scene.data.shapes.pose[1].position[0] = 1.0f;
  scene.step();
  EXPECT_EQ(scene.color(0), kNoColor);
}

// Contacts begin and end at random. Each row is free or belongs to one pair, and knows its pair and its
// points.
TEST(Collide, EveryRowIsAContactOrFree) {
  Scene scene;
  std::vector<ShapePair> pairs;
  constexpr int kPairs = 12000;  // more than a round of rows
  for (int k = 0; k < kPairs; ++k) {
    const ShapeType type = k % 2 == 0 ? ShapeType::sphere : ShapeType::box;
    scene.add(BodyType::dynamic, type, {10.0f * float(k), 0, 0});
    scene.add(BodyType::dynamic, type, {10.0f * float(k) + 1, 0, 0});
    pairs.push_back({2 * k, 2 * k + 1});
  }
  scene.workers = Workers(2);
  std::uint32_t state = 1;
  for (int round = 0; round < 6; ++round) {
    std::vector<ShapePair> list;
    RowList expected;
    for (const ShapePair& pair : pairs) {
      state = state * 1664525u + 1013904223u;
      const bool apart = (state >> 24) % 3 == 0;
      scene.lift(pair.b, apart ? 2.0f : 0.0f);
      if ((state >> 16) % 5 == 0) continue;
      if (!apart) expected.push_back(static_cast<std::int32_t>(list.size()));
      list.push_back(pair);
    }
    scene.set_pairs(list);
    scene.step();
    const Contacts& contacts = scene.data.contacts;
    ASSERT_EQ(contacts.active.size(), expected.size());
    std::vector<int> users(contacts.now.pair.size());
    for (const std::int32_t row : contacts.free_rows) {
      ++users[static_cast<std::size_t>(row)];
      ASSERT_EQ(contacts.now.points[static_cast<std::size_t>(row)], 0);
    }
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const auto row = static_cast<std::size_t>(expected[i]);
      ASSERT_TRUE(scene.touches(row));
      ASSERT_EQ(contacts.active[i], contacts.pairs.contact[row]);
      ++users[scene.contact(row)];
      ASSERT_EQ(contacts.now.pair[scene.contact(row)].a, list[row].a);
      ASSERT_EQ(contacts.now.points[scene.contact(row)], scene.manifold(row).info & kManifoldPointMask);
    }
    ASSERT_EQ(users, std::vector<int>(users.size(), 1));
    EXPECT_LT(contacts.now.pair.size(), 2 * kPairs / 3 + kPairs);  // not a row for every pair of every round
  }
}

TEST(Collide, SleepingContactsKeepEveryByte) {
  Scene scene;
  scene.add(BodyType::fixed, ShapeType::box, {0, 0, 0});
  scene.add(BodyType::dynamic, ShapeType::box, {0, 0.995f, 0});
  scene.add(BodyType::dynamic, ShapeType::box, {0, 1.99f, 0});
  scene.add(BodyType::dynamic, ShapeType::box, {0, 2.985f, 0});
  scene.set_pairs({{0, 1}, {1, 2}, {2, 3}});
  scene.step();
  EXPECT_EQ(scene.touching(), (RowList{0, 1, 2}));
  for (std::size_t row = 0; row < 3; ++row) {
    scene.manifold(row).normal_impulse[1] = 3.0f + float(row);
    scene.color(row) = 7;
  }
  for (const std::int32_t asleep : {1, 2}) scene.flags_of(asleep) |= kBodyAsleep;
  scene.data.shapes.pose[1].position[1] += 0.001f;  // a second collide would show
  const Manifold before[] = {scene.manifold(0), scene.manifold(1)};
  scene.data.contacts.list_kept = true;
  scene.step();
  EXPECT_EQ(scene.touching(), (RowList{2}));
  for (std::size_t row = 0; row < 2; ++row) {
    EXPECT_EQ(std::memcmp(&scene.manifold(row), &before[row], sizeof(Manifold)), 0);
  }

  scene.set_pairs({{0, 1}, {0, 3}, {1, 2}, {2, 3}});
  scene.step();
  EXPECT_EQ(scene.touching(), (RowList{3}));
  EXPECT_EQ(std::memcmp(&scene.manifold(0), &before[0], sizeof(Manifold)), 0);
  EXPECT_EQ(std::memcmp(&scene.manifold(2), &before[1], sizeof(Manifold)), 0);
  EXPECT_EQ(scene.color(0), 7);
  EXPECT_EQ(scene.color(2), 7);
  EXPECT_FALSE(scene.touches(1));
}

TEST(Collide, BodyAIsFixedOrKinematicWhereOneIs) {
  Scene scene;
  scene.add(BodyType::dynamic, ShapeType::box, {0, 0.995f, 0});
  scene.add(BodyType::fixed, ShapeType::box, {0, 0, 0});
  scene.add(BodyType::kinematic, ShapeType::box, {0, 1.99f, 0});
  scene.set_pairs({{0, 1}, {0, 2}, {1, 2}});
  scene.step();
  const Manifold manifold[] = {scene.manifold(0), scene.manifold(1)};
  EXPECT_EQ(manifold[0].info, 4u | kManifoldStatic);
  EXPECT_EQ(manifold[0].row_a, kFixedRow);
  EXPECT_EQ(manifold[0].row_b, scene.data.shapes.body[0]);
  EXPECT_FLOAT_EQ(manifold[0].normal[1], 1.0f);
  EXPECT_EQ(manifold[1].info, 4u | kManifoldStatic);
  EXPECT_EQ(manifold[1].row_a, scene.data.shapes.body[2]);
  EXPECT_EQ(manifold[1].row_b, scene.data.shapes.body[0]);
  EXPECT_FLOAT_EQ(manifold[1].normal[1], -1.0f);
  EXPECT_FALSE(scene.touches(2));
}

TEST(Collide, StillKinematicBodiesListOnlyNewContactsWithSleepingBodies) {
  Scene scene;
  scene.add(BodyType::kinematic, ShapeType::box, {0, 0, 0});
  scene.add(BodyType::dynamic, ShapeType::box, {0, 0.995f, 0}, kBodyAsleep);
  scene.set_pairs({{0, 1}});
  scene.step();
  EXPECT_EQ(scene.manifold(0).info, 4u | kManifoldStatic);
  EXPECT_EQ(scene.touching(), (RowList{0}));

  scene.data.shapes.pose[1].position[1] += 0.001f;  // a second collide would show
  const Manifold before = scene.manifold(0);
  scene.data.contacts.list_kept = true;
  scene.step();
  EXPECT_TRUE(scene.touching().empty());
  EXPECT_EQ(std::memcmp(&scene.manifold(0), &before, sizeof before), 0);
  scene.set_pairs({{0, 1}});
  scene.step();
  EXPECT_TRUE(scene.touching().empty());
  EXPECT_EQ(std::memcmp(&scene.manifold(0), &before, sizeof before), 0);
}

TEST(Collide, MovingKinematicBodiesListContactsWithSleepingBodies) {
  Scene scene;
  const std::int32_t platform = scene.add(BodyType::kinematic, ShapeType::box, {0, 0, 0});
  scene.add(BodyType::dynamic, ShapeType::box, {0, 0.995f, 0}, kBodyAsleep);
  const std::int32_t body = scene.data.shapes.body[static_cast<std::size_t>(platform)];
  VelocityRow& velocity = scene.data.bodies.velocity[static_cast<std::size_t>(body)];
  velocity.angular[1] = 0.01f;
  scene.set_pairs({{0, 1}});
  scene.step();
  EXPECT_EQ(scene.touching(), (RowList{0}));
  scene.data.contacts.list_kept = true;
  scene.step();
  EXPECT_EQ(scene.touching(), (RowList{0}));
  velocity = {};
  scene.step();
  EXPECT_TRUE(scene.touching().empty());
}

TEST(Collide, ASteadyStepKeepsItsMemory) {
  Scene scene;
  std::vector<ShapePair> pairs;
  for (int k = 0; k < 500; ++k) scene.add(BodyType::dynamic, ShapeType::sphere, {float(k), 0, 0});
  for (int k = 0; k + 1 < 500; ++k) pairs.push_back({k, k + 1});
  scene.set_pairs(pairs);
  scene.step();
  const auto places = [&] {
    std::vector<const void*> result{scene.data.contacts.active.data()};
    scene.data.narrow_phase->report(
        "narrow_phase", [&](const Member&, const void* rows, std::size_t, std::size_t, std::size_t) {
          result.push_back(rows);
        });
    return result;
  };
  const std::vector<const void*> before = places();
  scene.data.contacts.list_kept = true;
  scene.step();
  EXPECT_EQ(places(), before);
}

TEST(Collide, AnEmptyWorldHasNothingToDo) {
  Scene scene;
  scene.step();
  EXPECT_TRUE(scene.touching().empty());
}

}  // namespace
}  // namespace scree
