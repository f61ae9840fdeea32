// Laws of cylinders, cones and roundings as calls see them: what was given comes back, copies are the same,
// and what is out of range is refused.
#include <core/world/edit.h>
#include <scree/snapshot.h>
#include <tests/core/world/world_fixture.h>

#include <cstring>
#include <functional>
#include <limits>
#include <vector>

namespace scree::test {
namespace {

constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();
constexpr float kNoEnd = std::numeric_limits<float>::infinity();

Hull pyramid_hull() {
  const std::vector<Vec3> points{{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}, {0, 1.5f, 0}};
  return Hull(points);
}

std::vector<Geometry> round_shapes() {
  return {Cylinder{0.75f, 0.25f},         Cone{1.25f, 0.5f},
          Box{{1, 2, 3}, 0.125f},         ConvexHull{pyramid_hull(), {1, 2, 0.5f}, 0.375f},
          Cylinder{1e-4f, 1e3f},          Cone{1e3f, 1e-4f},
          Box{{1e-4f, 1e5f, 1e5f}, 1e5f}, ConvexHull{pyramid_hull(), {1, 1, 1}, 1e5f}};
}

void expect_same(const Geometry& found, const Geometry& given) {
  ASSERT_EQ(found.index(), given.index());
  if (const auto* cylinder = std::get_if<Cylinder>(&given)) {
    EXPECT_EQ(std::get<Cylinder>(found).half_height, cylinder->half_height);
    EXPECT_EQ(std::get<Cylinder>(found).radius, cylinder->radius);
  } else if (const auto* cone = std::get_if<Cone>(&given)) {
    EXPECT_EQ(std::get<Cone>(found).half_height, cone->half_height);
    EXPECT_EQ(std::get<Cone>(found).radius, cone->radius);
  } else if (const auto* box = std::get_if<Box>(&given)) {
    EXPECT_EQ(std::get<Box>(found).half_extents, box->half_extents);
    EXPECT_EQ(std::get<Box>(found).rounding, box->rounding);
  } else {
    EXPECT_EQ(std::get<ConvexHull>(found), std::get<ConvexHull>(given));
  }
}

struct RoundZoo {
  World world;
  std::vector<Geometry> given = round_shapes();
  std::vector<ShapeId> shapes;

  RoundZoo() {
    for (const Geometry& geometry : given) {
      const BodyId body = world.create_body({.position = {static_cast<float>(shapes.size()), 0, 0}});
      shapes.push_back(world.add_shape(body, geometry, {.density = 1e-3f}));
    }
  }
  void expect_given(const World& other) const {
    for (std::size_t i = 0; i < given.size(); ++i) expect_same(other.geometry(shapes[i]), given[i]);
  }
};

TEST(RoundShapes, ComeBackAsTheyWereGiven) {
  const RoundZoo zoo;
  zoo.expect_given(zoo.world);
}

TEST(RoundShapes, WithoutARoundingAreTheSharpOnes) {
  World world;
  const BodyId body = world.create_body({});
  const ShapeId box = world.add_shape(body, Box{{1, 1, 1}, -0.0f});
  const ShapeId hull = world.add_shape(body, ConvexHull{pyramid_hull(), {1, 1, 1}, 0.0f});
  EXPECT_EQ(internals(world).shapes.type[box.index], ShapeType::box);
  EXPECT_EQ(internals(world).shapes.type[hull.index], ShapeType::hull);
  world.set_geometry(box, Box{{1, 1, 1}, 1e-6f});
  EXPECT_EQ(internals(world).shapes.type[box.index], ShapeType::rounded_box);
  world.set_geometry(box, Cone{});
  EXPECT_EQ(internals(world).shapes.type[box.index], ShapeType::cone);
  EXPECT_EQ(internals(world).shapes.extent[box.index].radius, 0.0f);
}

TEST(RoundShapes, GoThroughSnapshotsAndClones) {
  RoundZoo zoo;
  zoo.expect_given(clone(zoo.world));
  Snapshot snapshot;
  save(zoo.world, snapshot);
  const std::vector<std::byte> bytes = write_snapshot(snapshot);
  World other;
  restore(other, read_snapshot(bytes));
  for (std::size_t i = 0; i < zoo.given.size(); ++i) {
    const ShapeId shape = shape_handle(internals(other), static_cast<std::int32_t>(zoo.shapes[i].index));
    expect_same(other.geometry(shape), zoo.given[i]);
  }
  Snapshot again;
  save(other, again);
  EXPECT_EQ(write_snapshot(again), bytes);
  for (const ShapeId shape : zoo.shapes) zoo.world.set_geometry(shape, Box{{1, 1, 1}, 0.5f});
  restore(zoo.world, snapshot);
  zoo.expect_given(zoo.world);
}

TEST(RoundShapes, ThatAreDamagedInASnapshotAreRefused) {
  const auto refused = [](const std::function<void(WorldData&, const RoundZoo&)>& damage) {
    RoundZoo zoo;
    damage(internals(zoo.world), zoo);
    Snapshot snapshot;
    save(zoo.world, snapshot);
    try {
      read_snapshot(write_snapshot(snapshot));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("not refused");
  };
  const auto extent = [&](std::size_t shape, auto change) {
    const std::string error = refused([&](WorldData& data, const RoundZoo& zoo) {
      change(data.shapes.extent[zoo.shapes[shape].index]);
      data.shapes.marks.mark(static_cast<std::int32_t>(zoo.shapes[shape].index));
    });
    EXPECT_NE(error.find("shapes.extent"), std::string::npos) << error;
  };
  EXPECT_EQ(refused([](WorldData&, const RoundZoo&) {}), "not refused");
  for (const float bad : {kNoNumber, kNoEnd, 0.0f, -1.0f, 2e5f}) {
    for (const std::size_t shape : {std::size_t{0}, std::size_t{1}}) {
      extent(shape, [bad](ExtentRow& row) { row.half[0] = row.half[2] = bad; });
      extent(shape, [bad](ExtentRow& row) { row.half[1] = bad; });
    }
    extent(2, [bad](ExtentRow& row) { row.half[1] = bad; });
    extent(2, [bad](ExtentRow& row) { row.radius = bad; });
  }
  extent(0, [](ExtentRow& row) { row.half[2] *= 2.0f; });
  extent(1, [](ExtentRow& row) { row.radius = 0.5f; });
  extent(3, [](ExtentRow& row) { row.half[0] *= 0.5f; });
  extent(3, [](ExtentRow& row) { row.radius *= 0.5f; });
  const auto type = [&](std::size_t shape, ShapeType other) {
    return refused([&](WorldData& data, const RoundZoo& zoo) {
      data.shapes.type[zoo.shapes[shape].index] = other;
      data.shapes.marks.mark(static_cast<std::int32_t>(zoo.shapes[shape].index));
    });
  };
  EXPECT_NE(type(3, ShapeType::hull).find("shapes.hull"), std::string::npos);
  EXPECT_NE(type(0, ShapeType::rounded_hull).find("shapes.hull"), std::string::npos);
  EXPECT_NE(type(0, static_cast<ShapeType>(kShapeTypeCount)).find("is no type of shapes"), std::string::npos);
}

TEST(RoundShapes, OutOfRangeAreRefusedWithValueAndLimit) {
  World world;
  const BodyId body = world.create_body({});
  const ShapeId shape = world.add_shape(body, Box{});
  const auto refuse = [&](const Geometry& geometry, const std::string& message) {
    EXPECT_EQ(error_of([&] { world.add_shape(body, geometry); }), "World::add_shape: " + message);
    EXPECT_EQ(error_of([&] { world.set_geometry(shape, geometry); }), "World::set_geometry: " + message);
    EXPECT_EQ(world.shape_count(), 1u);
  };
  const std::string extents = ", must lie in [9.99999975e-05, 100000]",
                    roundings = ", must lie in [0, 100000]";
  refuse(Cylinder{0.0f, 1.0f}, "cylinder half_height is 0" + extents);
  refuse(Cylinder{1.0f, -1.0f}, "cylinder radius is -1" + extents);
  refuse(Cylinder{1.0f, kNoNumber}, "cylinder radius is nan" + extents);
  refuse(Cone{kNoEnd, 1.0f}, "cone half_height is inf" + extents);
  refuse(Cone{1.0f, 0.0f}, "cone radius is 0" + extents);
  refuse(Cone{1.0f, 2e5f}, "cone radius is 200000" + extents);
  refuse(Box{{1, 1, 1}, -0.5f}, "box rounding is -0.5" + roundings);
  refuse(Box{{1, 1, 1}, kNoNumber}, "box rounding is nan" + roundings);
  refuse(Box{{0, 1, 1}, 0.5f}, "box half_extents.x is 0" + extents);
  refuse(ConvexHull{pyramid_hull(), {1, 1, 1}, -1e-9f}, "hull rounding is -9.99999972e-10" + roundings);
  refuse(ConvexHull{pyramid_hull(), {1, 1, 1}, kNoEnd}, "hull rounding is inf" + roundings);
}

}  // namespace
}  // namespace scree::test
