// Laws of hulls in worlds: shared, counted, scaled, and released once unused.
#include <core/world/edit.h>
#include <core/world/state_table.h>
#include <tests/core/geometry/hull/hull_clouds.h>

#include <cstddef>
#include <limits>

namespace scree::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

const Hull& rock() {
  static const Hull hull(cube_cloud(60, 1));
  return hull;
}
const Hulls& hulls_of(World& world) { return internals(world).hulls; }
std::size_t used_slots(World& world) {
  const Hulls& hulls = hulls_of(world);
  return hulls.shared.size() - hulls.free_slots.size();
}

// Bytes of all columns of kind state, or of those of one store.
std::vector<std::byte> state_of(World& world, const std::string& of = "") {
  std::vector<std::byte> bytes;
  for_each_column(internals(world), [&](ColumnKind kind, const char* store, const char*, auto& column) {
    if (kind != ColumnKind::state || column.empty() || (!of.empty() && of != store)) return;
    const auto* first = reinterpret_cast<const std::byte*>(column.data());
    bytes.insert(bytes.end(), first, first + column.span().size_bytes());
  });
  return bytes;
}

TEST(HullStore, TenThousandBodiesShareOneHull) {
  constexpr std::size_t kBodies = 10'000;
  World with_hulls, with_boxes;
  std::vector<BodyId> ids(kBodies);
  const std::vector<BodyDef> defs(kBodies);
  with_boxes.create_bodies(defs, std::vector<Geometry>(kBodies, Box{}), {}, {}, ids);
  with_hulls.create_bodies(defs, std::vector<Geometry>(kBodies, ConvexHull{rock()}), {}, {}, ids);
  EXPECT_EQ(used_slots(with_hulls), 1u);
  EXPECT_EQ(hulls_of(with_hulls).shapes[0], static_cast<std::int32_t>(kBodies));
  const std::size_t more = with_hulls.memory_use().state - with_boxes.memory_use().state;
  EXPECT_GE(more, solid_of(rock()).bytes());
  EXPECT_LT(more, 2 * solid_of(rock()).bytes() + 2000);
  with_hulls.destroy_bodies(ids);
  EXPECT_EQ(used_slots(with_hulls), 0u);
  EXPECT_EQ(hulls_of(with_hulls).data[0], nullptr);
}

TEST(HullStore, ScaledHullsShareTheMemoryOfTheirOriginal) {
  World world;
  const BodyId body = world.create_body({});
  world.add_shape(body, ConvexHull{rock()});
  std::size_t bytes = hulls_of(world).shared.capacity() * sizeof(SharedHull) + solid_of(rock()).bytes();
  EXPECT_EQ(hull_bytes(hulls_of(world).shared), bytes);
  for (int i = 2; i < 10; ++i) {
    world.add_shape(body, ConvexHull{rock(), {1, 1, static_cast<float>(i)}});
    bytes = hulls_of(world).shared.capacity() * sizeof(SharedHull) + solid_of(rock()).bytes();
    for (std::size_t slot = 1; slot < hulls_of(world).shared.size(); ++slot)
      bytes += hulls_of(world).shared[slot].solid->bytes();
    EXPECT_EQ(hull_bytes(hulls_of(world).shared), bytes);
  }
}

TEST(HullStore, EqualHullsShareASlotHoweverTheyWereBuilt) {
  World world;
  const BodyId body = world.create_body({});
  world.add_shape(body, ConvexHull{rock()});
  world.add_shape(body, ConvexHull{Hull(cube_cloud(60, 1))});
  EXPECT_EQ(used_slots(world), 1u);
  world.add_shape(body, ConvexHull{rock(), {1, 1, 2}});
  world.add_shape(body, ConvexHull{Hull(cube_cloud(60, 1)), {1, 1, 2}});
  EXPECT_EQ(used_slots(world), 2u);
  world.add_shape(body, ConvexHull{Hull(cube_cloud(60, 2))});
  EXPECT_EQ(used_slots(world), 3u);
}

TEST(HullStore, GeometryIsReturnedAsItWasGiven) {
  World world;
  const ConvexHull given{rock(), {0.5f, 2.0f, 1.0f}};
  const ShapeId shape = world.add_shape(world.create_body({}), given);
  EXPECT_EQ(std::get<ConvexHull>(world.geometry(shape)), given);
  World moved = std::move(world);
  EXPECT_EQ(std::get<ConvexHull>(moved.geometry(shape)), given);
}

TEST(HullStore, AScaledHullIsTheHullOfTheScaledCorners) {
  World world;
  const Vec3 scale{2.0f, 0.5f, 3.0f};
  world.add_shape(world.create_body({}), ConvexHull{rock(), scale});
  const HullData& data = *hulls_of(world).data[0];
  const HullSolid& scaled = *hulls_of(world).shared[0].solid;
  ASSERT_EQ(static_cast<std::size_t>(data.vertex_count), rock().vertices().size());
  for (std::size_t i = 0; i < rock().vertices().size(); ++i) {
    const Vec3& v = rock().vertices()[i];
    EXPECT_NEAR(data.vertex[0][i] + scaled.origin[0], double{v.x} * scale.x, 2e-6);
    EXPECT_NEAR(data.vertex[1][i] + scaled.origin[1], double{v.y} * scale.y, 2e-6);
    EXPECT_NEAR(data.vertex[2][i] + scaled.origin[2], double{v.z} * scale.z, 2e-6);
  }
  const ExtentRow& extent = internals(world).shapes.extent[0];
  for (std::size_t i = 0; i < static_cast<std::size_t>(data.vertex_count); ++i) {
    for (int k = 0; k < 3; ++k) EXPECT_LE(std::abs(data.vertex[k][i]), extent.half[k]);
  }
  EXPECT_EQ(extent.radius, data.outer_radius);
}

TEST(HullStore, FreedSlotsAreUsedAgainLatestFirst) {
  World world;
  const BodyId body = world.create_body({});
  ShapeId shapes[4];
  for (std::uint64_t i = 0; i < 4; ++i)
    shapes[i] = world.add_shape(body, ConvexHull{Hull(cube_cloud(8, 10 + i))});
  world.destroy_shape(shapes[1]);
  world.destroy_shape(shapes[2]);
  const auto slot_of = [&](ShapeId shape) { return internals(world).shapes.hull[shape.index]; };
  EXPECT_EQ(slot_of(world.add_shape(body, ConvexHull{Hull(cube_cloud(8, 20))})), 2);
  EXPECT_EQ(slot_of(world.add_shape(body, ConvexHull{Hull(cube_cloud(8, 21))})), 1);
  EXPECT_EQ(slot_of(world.add_shape(body, ConvexHull{Hull(cube_cloud(8, 22))})), 4);
}

TEST(HullStore, ReplacedGeometryReleasesItsHull) {
  World world;
  const BodyId body = world.create_body({});
  const ShapeId shape = world.add_shape(body, Sphere{});
  world.set_geometry(shape, ConvexHull{Hull(turned(cube_cloud(60, 1), {}, {0, 5, 0}))});
  EXPECT_EQ(used_slots(world), 1u);
  EXPECT_NEAR(world.center_of_mass(body).y, 5.0, 0.2);
  place_matter(internals(world));
  EXPECT_NEAR(internals(world).shapes.local_pose[shape.index].position[1], 0.0, 1e-5);
  world.set_geometry(shape, ConvexHull{rock(), {2, 2, 2}});
  EXPECT_EQ(used_slots(world), 1u);
  world.set_geometry(shape, Box{});
  EXPECT_EQ(used_slots(world), 0u);
  EXPECT_EQ(internals(world).shapes.hull[shape.index], -1);
  place_matter(internals(world));
  EXPECT_EQ(internals(world).shapes.local_pose[shape.index].position[1], 0.0f);
}

TEST(HullStore, AFixedBodysHullStandsAtItsCentroid) {
  World world;
  const Hull hull(turned(cube_cloud(60, 1), {}, {0, 5, 0}));
  const ShapeId shape =
      world.add_shape(world.create_body({.type = BodyType::fixed}), ConvexHull{hull, {1, 2, 1}});
  const PoseRow& local = internals(world).shapes.local_pose[shape.index];
  EXPECT_NEAR(local.position[0], hull.centroid().x, 1e-6);
  EXPECT_NEAR(local.position[1], 2.0f * hull.centroid().y, 2e-6);
  EXPECT_EQ(world.local_pose(shape), Pose{});
}

TEST(HullStore, BadHullsAreRefusedAndChangeNothing) {
  World world;
  const BodyId body = world.create_body({});
  const ShapeId shape = world.add_shape(body, ConvexHull{rock()});
  const std::vector<std::byte> before = state_of(world);
  const std::pair<ConvexHull, std::string> mistakes[] = {
      {{}, "the hull is empty: it was made of no points, or moved from"},
      {{rock(), {0, 1, 1}}, "hull scale.x is 0, must lie in [9.99999972e-10, 1e+09]"},
      {{rock(), {1, -1, 1}}, "hull scale.y is -1, must lie in [9.99999972e-10, 1e+09]"},
      {{rock(), {1, 1, kNan}}, "hull scale.z is nan, must lie in [9.99999972e-10, 1e+09]"},
      {{rock(), {kInfinity, 1, 1}}, "hull scale.x is inf, must lie in [9.99999972e-10, 1e+09]"}};
  for (const auto& mistake : mistakes) {
    const ConvexHull& geometry = mistake.first;
    const std::string& message = mistake.second;
    EXPECT_EQ(error_of([&] { world.add_shape(body, geometry); }), "World::add_shape: " + message);
    EXPECT_EQ(error_of([&] { world.set_geometry(shape, geometry); }), "World::set_geometry: " + message);
  }
  const std::string thin = error_of([&] { world.add_shape(body, ConvexHull{rock(), {1, 1, 1e-5f}}); });
  EXPECT_EQ(thin.rfind("World::add_shape: the scaled hull: the points' hull is 1.9", 0), 0u) << thin;
  EXPECT_NE(thin.find(" m thick: a hull must be at least 0.0001 m thick"), std::string::npos) << thin;
  const std::string large = error_of([&] { world.set_geometry(shape, ConvexHull{rock(), {1e6f, 1, 1}}); });
  EXPECT_EQ(large.rfind("World::set_geometry: the scaled hull: point 0: x is -9", 0), 0u) << large;
  EXPECT_EQ(state_of(world), before);
}

TEST(HullStore, BulkCreationWithABadHullCreatesNothing) {
  World world;
  const BodyId body = world.create_body({});
  // Free slots of every kind, so that slots are taken back in the right order.
  ShapeId shapes[5];
  for (std::uint64_t i = 0; i < 5; ++i)
    shapes[i] = world.add_shape(body, ConvexHull{Hull(cube_cloud(8, 30 + i))});
  for (const int i : {3, 0, 2}) world.destroy_shape(shapes[i]);
  const std::vector<std::byte> before = state_of(world, "hulls");
  std::vector<Geometry> geometries;
  for (std::uint64_t i = 0; i < 20; ++i) {
    geometries.push_back(ConvexHull{Hull(cube_cloud(8, 30 + i % 9)), {1, 1, i % 2 == 0 ? 1.0f : 2.0f}});
    geometries.push_back(Box{});
  }
  geometries.back() = ConvexHull{rock(), {1, 1e-6f, 1}};
  std::vector<BodyId> ids(geometries.size());
  const std::vector<BodyDef> defs(geometries.size());
  const std::string message = error_of([&] { world.create_bodies(defs, geometries, {}, {}, ids); });
  EXPECT_EQ(message.rfind("World::create_bodies: definition 39: the scaled hull: ", 0), 0u) << message;
  EXPECT_EQ(state_of(world, "hulls"), before);
  EXPECT_EQ(world.body_count(), 1u);
  EXPECT_EQ(world.shape_count(), 2u);
  geometries.back() = Box{};
  world.create_bodies(defs, geometries, {}, {}, ids);
  EXPECT_EQ(world.shape_count(), 42u);
}

TEST(HullStore, TheSameCallsGiveTheSameState) {
  World worlds[2];
  for (World& world : worlds) {
    Random random(5);
    std::vector<ShapeId> shapes;
    const BodyId body = world.create_body({});
    for (int i = 0; i < 300; ++i) {
      const ConvexHull convex{Hull(cube_cloud(10, random.below(7))), {1, 1, random.between(0.5f, 0.6f)}};
      if (shapes.size() > 5 && random.below(2) == 0) {
        const std::size_t which = random.below(shapes.size());
        world.destroy_shape(shapes[which]);
        shapes.erase(shapes.begin() + static_cast<std::ptrdiff_t>(which));
      } else if (!shapes.empty() && random.below(3) == 0) {
        world.set_geometry(shapes[random.below(shapes.size())], convex);
      } else {
        shapes.push_back(world.add_shape(body, convex));
      }
    }
  }
  EXPECT_EQ(state_of(worlds[0]), state_of(worlds[1]));
}

}  // namespace
}  // namespace scree::test
