// Laws of handles and of the calls that create and destroy.
#include <tests/core/world/world_fixture.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

namespace scree::test {
namespace {

TEST(Handles, DefaultHandlesAreNotAlive) {
  World world;
  EXPECT_FALSE(world.is_alive(BodyId{}));
  EXPECT_FALSE(world.is_alive(ShapeId{}));
  const BodyId body = world.create_body({});
  const ShapeId shape = world.add_shape(body, Sphere{});
  EXPECT_EQ(shape.index, 0u);
  EXPECT_FALSE(world.is_alive(BodyId{}));
  EXPECT_FALSE(world.is_alive(ShapeId{}));
  EXPECT_NE(error_of([&] { world.pose(BodyId{}); }).find("names no body"), std::string::npos);
  EXPECT_NE(error_of([&] { world.geometry(ShapeId{}); }).find("names no shape"), std::string::npos);
}

TEST(Handles, BodiesStartBehindTheReservedRows) {
  World world;
  EXPECT_EQ(world.create_body({}).index, static_cast<std::uint32_t>(kFirstBody));
  const WorldData& data = internals(world);
  for (std::uint32_t row = 0; row < static_cast<std::uint32_t>(kFirstBody); ++row) {
    EXPECT_EQ(world.body_at(row), BodyId{});
    EXPECT_FALSE(world.is_alive(BodyId{row, data.bodies.generation[row]}));
    EXPECT_EQ(world.poses()[row], Pose{});
    EXPECT_EQ(data.bodies.delta[row].rotation[3], 1.0f);
    EXPECT_EQ(data.bodies.inertia[row].inverse_mass, 0.0f);
  }
}

TEST(Handles, ASlotIsReusedUnderANewGeneration) {
  World world;
  const BodyId old_body = world.create_body({});
  const ShapeId old_shape = world.add_shape(old_body, Sphere{});
  world.destroy_body(old_body);
  EXPECT_FALSE(world.is_alive(old_body));
  EXPECT_FALSE(world.is_alive(old_shape));
  const BodyId body = world.create_body({});
  const ShapeId shape = world.add_shape(body, Sphere{});
  EXPECT_EQ(body.index, old_body.index);
  EXPECT_EQ(shape.index, old_shape.index);
  EXPECT_NE(body.generation, old_body.generation);
  EXPECT_NE(shape.generation, old_shape.generation);
  EXPECT_FALSE(world.is_alive(old_body));
  EXPECT_FALSE(world.is_alive(old_shape));
  EXPECT_TRUE(world.is_alive(body));
}

TEST(Handles, TheSlotFreedLastIsTakenFirst) {
  World world;
  std::vector<BodyId> bodies(5);
  world.create_bodies(std::vector<BodyDef>(5), bodies);
  world.destroy_body(bodies[1]);
  world.destroy_body(bodies[3]);
  world.destroy_body(bodies[0]);
  std::vector<BodyId> again(4);
  world.create_bodies(std::vector<BodyDef>(4), again);
  EXPECT_EQ(again[0].index, bodies[0].index);
  EXPECT_EQ(again[1].index, bodies[3].index);
  EXPECT_EQ(again[2].index, bodies[1].index);
  EXPECT_EQ(again[3].index, bodies[4].index + 1);
}

TEST(Handles, ASlotWithoutGenerationsLeftStaysEmpty) {
  World world;
  BodyId body = world.create_body({});
  internals(world).bodies.generation[row_of(body)] = 0xffffffffu;
  body.generation = 0xffffffffu;
  world.destroy_body(body);
  EXPECT_NE(world.create_body({}).index, body.index);
  EXPECT_FALSE(world.is_alive(BodyId{body.index, 0}));
}

TEST(Handles, HandlesOfAnEmptierWorldAreRejected) {
  World full, empty;
  BodyId body;
  for (int i = 0; i < 3; ++i) body = full.create_body({});
  const ShapeId shape = full.add_shape(body, Sphere{});
  EXPECT_FALSE(empty.is_alive(body));
  EXPECT_THROW(empty.pose(body), Error);
  EXPECT_THROW(empty.destroy_body(body), Error);
  EXPECT_THROW(empty.destroy_shape(shape), Error);
  EXPECT_EQ(empty.body_count(), 0u);
}

TEST(Handles, BodyAtFindsTheLiving) {
  World world;
  const BodyId first = world.create_body({}), second = world.create_body({});
  EXPECT_EQ(world.body_at(first.index), first);
  world.destroy_body(first);
  EXPECT_EQ(world.body_at(first.index), BodyId{});
  EXPECT_EQ(world.body_at(second.index), second);
  EXPECT_EQ(world.body_at(1000), BodyId{});
}

TEST(Handles, ShapesAreListedOldestFirst) {
  World world;
  const BodyId body = world.create_body({});
  std::vector<ShapeId> made;
  for (int i = 0; i < 4; ++i) made.push_back(world.add_shape(body, Sphere{}));
  std::vector<ShapeId> listed(4);
  EXPECT_EQ(world.shapes_of(body, listed), 4u);
  EXPECT_EQ(listed, made);
  std::vector<ShapeId> few(2);
  EXPECT_EQ(world.shapes_of(body, few), 4u);
  EXPECT_EQ(few, std::vector<ShapeId>(made.begin(), made.begin() + 2));
  world.destroy_shape(made[1]);
  EXPECT_EQ(world.shapes_of(body, listed), 3u);
  EXPECT_EQ(listed[0], made[0]);
  EXPECT_EQ(listed[1], made[2]);
  EXPECT_EQ(listed[2], made[3]);
}

TEST(Handles, AWorldThatWasMovedFromThrowsAndTheNewOneLivesOn) {
  World world;
  const BodyId body = world.create_body({.position = {1, 2, 3}});
  World other = std::move(world);
  EXPECT_EQ(other.pose(body).position, (Vec3{1, 2, 3}));
  EXPECT_THROW(world.pose(body), Error);  // NOLINT(bugprone-use-after-move): the law under test
  EXPECT_THROW(world.create_body({}), Error);
  EXPECT_THROW(world.settings(), Error);
  EXPECT_THROW(world.stats(), Error);
  EXPECT_EQ(world.body_count(), 0u);
  EXPECT_TRUE(world.poses().empty());
  EXPECT_FALSE(world.is_alive(body));
}

// A world as plain maps. Random calls must agree with it.
struct Model {
  struct Body {
    Vec3 position;
    std::uint64_t user_data;
    std::vector<ShapeId> shapes;
  };
  std::map<BodyId, Body> bodies;
  std::map<ShapeId, std::pair<BodyId, float>> shapes;  // owner, sphere radius
  std::vector<BodyId> dead_bodies;
  std::vector<ShapeId> dead_shapes;

  BodyId pick_body(Random& random) const {
    return std::next(bodies.begin(), static_cast<std::ptrdiff_t>(random.below(bodies.size())))->first;
  }
  ShapeId pick_shape(Random& random) const {
    return std::next(shapes.begin(), static_cast<std::ptrdiff_t>(random.below(shapes.size())))->first;
  }
  void destroy_body(BodyId body) {
    for (const ShapeId shape : bodies[body].shapes) {
      shapes.erase(shape);
      dead_shapes.push_back(shape);
    }
    bodies.erase(body);
    dead_bodies.push_back(body);
  }
};

void expect_equal(const World& world, const Model& model) {
  ASSERT_EQ(world.body_count(), model.bodies.size());
  ASSERT_EQ(world.shape_count(), model.shapes.size());
  for (const auto& [id, body] : model.bodies) {
    ASSERT_TRUE(world.is_alive(id));
    EXPECT_EQ(world.pose(id).position, body.position);
    EXPECT_EQ(world.poses()[id.index].position, body.position);
    EXPECT_EQ(world.user_data(id), body.user_data);
    std::vector<ShapeId> shapes(body.shapes.size() + 1);
    shapes.resize(world.shapes_of(id, shapes));
    EXPECT_EQ(shapes, body.shapes);
  }
  for (const auto& [id, shape] : model.shapes) {
    ASSERT_TRUE(world.is_alive(id));
    EXPECT_EQ(world.body_of(id), shape.first);
    EXPECT_EQ(std::get<Sphere>(world.geometry(id)).radius, shape.second);
  }
  for (const BodyId id : model.dead_bodies) EXPECT_FALSE(world.is_alive(id));
  for (const ShapeId id : model.dead_shapes) EXPECT_FALSE(world.is_alive(id));
}

void expect_sound_lists(World& world) {
  const Shapes& shapes = internals(world).shapes;
  const std::set<std::int32_t> dirty(shapes.dirty.begin(), shapes.dirty.end());
  EXPECT_EQ(dirty.size(), shapes.dirty.size()) << "a slot is listed twice";
  for (std::size_t row = 0; row < shapes.flags.size(); ++row) {
    const bool is_dirty = (shapes.flags[row] & kShapeDirty) != 0;
    EXPECT_EQ(is_dirty, dirty.count(static_cast<std::int32_t>(row)) == 1);
    const bool alive = (shapes.flags[row] & kShapeAlive) != 0;
    EXPECT_EQ(alive, shapes.tree[row] != TreeKind::none);
    if ((shapes.flags[row] & kShapeNew) != 0) {
      EXPECT_TRUE(alive && is_dirty);
    }
  }
}

void random_call(World& world, Model& model, Random& random) {
  const auto random_position = [&] {
    return Vec3{random.between(-9, 9), random.between(-9, 9), random.between(-9, 9)};
  };
  switch (random.below(8)) {
    case 0: {
      const Vec3 position = random_position();
      const std::uint64_t tag = random.next();
      const auto type = static_cast<BodyType>(random.below(3));
      model.bodies[world.create_body({.type = type, .position = position, .user_data = tag})] = {
          position, tag, {}};
      break;
    }
    case 1: {
      std::vector<BodyDef> defs(random.below(6));
      std::vector<Geometry> geometries;
      for (BodyDef& def : defs) {
        def.position = random_position();
        def.user_data = random.next();
        geometries.push_back(Sphere{random.between(0.1f, 2.0f)});
      }
      std::vector<BodyId> ids(defs.size());
      world.create_bodies(defs, geometries, {}, {}, ids);
      for (std::size_t i = 0; i < ids.size(); ++i) {
        std::vector<ShapeId> shape(1);
        ASSERT_EQ(world.shapes_of(ids[i], shape), 1u);
        model.bodies[ids[i]] = {defs[i].position, defs[i].user_data, shape};
        model.shapes[shape[0]] = {ids[i], std::get<Sphere>(geometries[i]).radius};
      }
      break;
    }
    case 2:
    case 3: {
      if (model.bodies.empty()) break;
      const BodyId body = model.pick_body(random);
      const float radius = random.between(0.1f, 2.0f);
      const ShapeId shape = world.add_shape(body, Sphere{radius});
      model.shapes[shape] = {body, radius};
      model.bodies[body].shapes.push_back(shape);
      break;
    }
    case 4: {
      if (model.bodies.empty()) break;
      const BodyId body = model.pick_body(random);
      world.destroy_body(body);
      model.destroy_body(body);
      break;
    }
    case 5: {
      if (model.shapes.empty()) break;
      const ShapeId shape = model.pick_shape(random);
      std::vector<ShapeId>& siblings = model.bodies[model.shapes[shape].first].shapes;
      siblings.erase(std::find(siblings.begin(), siblings.end(), shape));
      world.destroy_shape(shape);
      model.shapes.erase(shape);
      model.dead_shapes.push_back(shape);
      break;
    }
    case 6: {
      if (model.bodies.empty()) break;
      const BodyId body = model.pick_body(random);
      const Vec3 position = random_position();
      world.set_pose(body, {position, {}});
      model.bodies[body].position = position;
      break;
    }
    case 7: {
      if (model.shapes.empty()) break;
      const ShapeId shape = model.pick_shape(random);
      const float radius = random.between(0.1f, 2.0f);
      world.set_geometry(shape, Sphere{radius});
      model.shapes[shape].second = radius;
      break;
    }
  }
}

TEST(Handles, RandomCallsAgreeWithAPlainModel) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    World world;
    Model model;
    Random random(seed);
    for (int call = 0; call < 400; ++call) {
      random_call(world, model, random);
      if (call % 40 == 39) {
        expect_equal(world, model);
        expect_sound_lists(world);
      }
      if (call % 100 == 99) consume_dirty(world);
    }
  }
}

TEST(Handles, TheSameCallsGiveTheSameHandlesAndHash) {
  std::uint64_t hashes[2];
  std::vector<BodyId> ids[2];
  const World both;
  for (int run = 0; run < 2; ++run) {
    World world;
    world.share_handles(both);
    Model model;
    Random random(77);
    for (int call = 0; call < 300; ++call) random_call(world, model, random);
    hashes[run] = world.hash();
    for (const auto& [id, body] : model.bodies) ids[run].push_back(id);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(ids[0], ids[1]);
}

}  // namespace
}  // namespace scree::test
