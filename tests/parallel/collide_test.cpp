// collide(): which rows it touches, where rows go when the list changes, colors and the list of touching
// rows.
#include <gtest/gtest.h>
#include <parallel/narrow_phase.h>
#include <parallel/stages.h>

#include <cstring>
#include <set>
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
  std::uint8_t& flags_of(std::int32_t shape) {
    return data.bodies.flags[static_cast<std::size_t>(data.shapes.body[static_cast<std::size_t>(shape)])];
  }
  // As find_pairs does: new rows in `now`, the old ones in `before`.
  void set_pairs(const std::vector<ShapePair>& pairs) {
    Contacts& contacts = data.contacts;
    contacts.before.resize(pairs.size());
    std::swap(contacts.now, contacts.before);
    contacts.now.resize(pairs.size());
    contacts.previous.resize(pairs.size());
    for (std::size_t row = 0; row < pairs.size(); ++row) {
      contacts.now.pair[row] = pairs[row];
      contacts.previous[row] = -1;
      for (std::size_t old = 0; old < old_pairs.size(); ++old) {
        if (old_pairs[old].a == pairs[row].a && old_pairs[old].b == pairs[row].b) {
          contacts.previous[row] = static_cast<std::int32_t>(old);
        }
      }
    }
    old_pairs = pairs;
    contacts.list_kept = false;
  }
  void step() {
    Crew crew(workers);
    collide(data, crew);
  }
  std::vector<std::int32_t> touching() const {
    return {data.contacts.touching.begin(), data.contacts.touching.end()};
  }
  std::uint32_t info(std::size_t row) const { return data.contacts.now.manifold[row].info; }

  std::vector<ShapePair> old_pairs;
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
    EXPECT_EQ((scene.info(row) & kManifoldPointMask) != 0, row % 4 != 0) << row;
  }
}

TEST(Collide, RowsMoveWithTheirImpulsesWhereTheListChanges) {
  Scene scene;
  std::vector<std::int32_t> shapes;
  for (int k = 0; k < 4; ++k)
    shapes.push_back(scene.add(BodyType::dynamic, ShapeType::sphere, {float(k), 0, 0}));
  scene.set_pairs({{0, 1}, {2, 3}});
  scene.step();
  for (std::size_t row = 0; row < 2; ++row) {
    scene.data.contacts.now.manifold[row].normal_impulse[0] = 1.0f + float(row);
    EXPECT_EQ(scene.data.contacts.now.color[row], kNoColor);
    scene.data.contacts.now.color[row] = static_cast<std::uint8_t>(5 + row);
  }
  scene.data.contacts.list_kept = true;
  scene.step();
  EXPECT_EQ(scene.data.contacts.now.manifold[1].normal_impulse[0], 2.0f);
  EXPECT_EQ(scene.data.contacts.now.color[1], 6);

  scene.set_pairs({{1, 2}, {2, 3}});
  scene.step();
  EXPECT_EQ(scene.data.contacts.now.manifold[0].normal_impulse[0], 0.0f);
  EXPECT_EQ(scene.data.contacts.now.color[0], kNoColor);
  EXPECT_EQ(scene.data.contacts.now.manifold[1].normal_impulse[0], 2.0f);
  EXPECT_EQ(scene.data.contacts.now.color[1], 6);
}

TEST(Collide, ARowThatPartsLosesItsColor) {
  Scene scene;
  scene.add(BodyType::dynamic, ShapeType::sphere, {0, 0, 0});
  scene.add(BodyType::dynamic, ShapeType::sphere, {1, 0, 0});
  scene.set_pairs({{0, 1}});
  scene.step();
  scene.data.contacts.now.color[0] = 3;
  scene.data.shapes.pose[1].position[0] = 1.5f;
  scene.data.contacts.list_kept = true;
  scene.step();
  EXPECT_EQ(scene.info(0), 0u);
  EXPECT_EQ(scene.data.contacts.now.color[0], kNoColor);
  EXPECT_TRUE(scene.touching().empty());
}

TEST(Collide, SleepingRowsKeepEveryByte) {
  Scene scene;
  scene.add(BodyType::fixed, ShapeType::box, {0, 0, 0});
  scene.add(BodyType::dynamic, ShapeType::box, {0, 0.995f, 0});
  scene.add(BodyType::dynamic, ShapeType::box, {0, 1.99f, 0});
  scene.add(BodyType::dynamic, ShapeType::box, {0, 2.985f, 0});
  scene.set_pairs({{0, 1}, {1, 2}, {2, 3}});
  scene.step();
  EXPECT_EQ(scene.touching(), (RowList{0, 1, 2}));
  Contacts& contacts = scene.data.contacts;
  for (std::size_t row = 0; row < 3; ++row) {
    contacts.now.manifold[row].normal_impulse[1] = 3.0f + float(row);
    contacts.now.color[row] = 7;
  }
  for (const std::int32_t asleep : {1, 2}) scene.flags_of(asleep) |= kBodyAsleep;
  scene.data.shapes.pose[1].position[1] += 0.001f;  // were it collided again, it would show
  const std::vector<Manifold> before(contacts.now.manifold.begin(), contacts.now.manifold.end());
  contacts.list_kept = true;
  scene.step();
  EXPECT_EQ(scene.touching(), (RowList{2}));
  EXPECT_EQ(std::memcmp(&contacts.now.manifold[0], before.data(), 2 * sizeof(Manifold)), 0);

  scene.set_pairs({{0, 1}, {0, 3}, {1, 2}, {2, 3}});
  scene.step();
  EXPECT_EQ(scene.touching(), (RowList{3}));
  EXPECT_EQ(std::memcmp(&contacts.now.manifold[0], &before[0], sizeof(Manifold)), 0);
  EXPECT_EQ(std::memcmp(&contacts.now.manifold[2], &before[1], sizeof(Manifold)), 0);
  EXPECT_EQ(contacts.now.color[0], 7);
  EXPECT_EQ(contacts.now.color[2], 7);
  EXPECT_EQ(contacts.now.color[1], kNoColor);
}

TEST(Collide, BodyAIsFixedOrKinematicWhereOneIs) {
  Scene scene;
  scene.add(BodyType::dynamic, ShapeType::box, {0, 0.995f, 0});
  scene.add(BodyType::fixed, ShapeType::box, {0, 0, 0});
  scene.add(BodyType::kinematic, ShapeType::box, {0, 1.99f, 0});
  scene.set_pairs({{0, 1}, {0, 2}, {1, 2}});
  scene.step();
  const Manifold* manifold = scene.data.contacts.now.manifold.data();
  EXPECT_EQ(manifold[0].info, 4u | kManifoldStatic);
  EXPECT_EQ(manifold[0].row_a, kFixedRow);
  EXPECT_EQ(manifold[0].row_b, scene.data.shapes.body[0]);
  EXPECT_FLOAT_EQ(manifold[0].normal[1], 1.0f);
  EXPECT_EQ(manifold[1].info, 4u | kManifoldStatic);
  EXPECT_EQ(manifold[1].row_a, scene.data.shapes.body[2]);
  EXPECT_EQ(manifold[1].row_b, scene.data.shapes.body[0]);
  EXPECT_FLOAT_EQ(manifold[1].normal[1], -1.0f);
  EXPECT_EQ(manifold[2].info, 0u);
}

TEST(Collide, StillKinematicBodiesListSleepingOnesOnlyWhereTheyAreNew) {
  Scene scene;
  scene.add(BodyType::kinematic, ShapeType::box, {0, 0, 0});
  scene.add(BodyType::dynamic, ShapeType::box, {0, 0.995f, 0}, kBodyAsleep);
  scene.set_pairs({{0, 1}});
  scene.step();
  EXPECT_EQ(scene.info(0), 4u | kManifoldStatic);
  EXPECT_EQ(scene.touching(), (RowList{0}));

  scene.data.shapes.pose[1].position[1] += 0.001f;  // were it collided again, it would show
  const Manifold before = scene.data.contacts.now.manifold[0];
  scene.data.contacts.list_kept = true;
  scene.step();
  EXPECT_TRUE(scene.touching().empty());
  EXPECT_EQ(std::memcmp(&scene.data.contacts.now.manifold[0], &before, sizeof before), 0);
  scene.set_pairs({{0, 1}});
  scene.step();
  EXPECT_TRUE(scene.touching().empty());
  EXPECT_EQ(std::memcmp(&scene.data.contacts.now.manifold[0], &before, sizeof before), 0);
}

TEST(Collide, MovingKinematicBodiesListSleepingOnes) {
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
    std::vector<const void*> result{scene.data.contacts.touching.data()};
    scene.data.narrow_phase->report(
        [&](ColumnKind, const char*, const void* rows, std::size_t, std::size_t) { result.push_back(rows); });
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
