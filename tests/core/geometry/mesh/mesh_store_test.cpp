// Laws of meshes in worlds: shared, counted, released once unused, only on bodies that nothing pushes.
#include <core/geometry/mesh/mesh_build.h>
#include <core/geometry/mesh/mesh_store.h>
#include <core/world/edit.h>
#include <core/world/state_table.h>
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <tests/core/geometry/mesh/meshes.h>

#include <cstddef>
#include <string>
#include <vector>

namespace scree {
namespace {

TriangleMesh mesh_of(const test_solids::TestMesh& mesh) {
  return TriangleMesh(mesh.vertices, mesh.triangles);
}
TriangleMesh box(float size, Vec3 shift = {}) {
  test_solids::TestMesh mesh = test_solids::box_mesh({size, size, size});
  mesh.map([shift](Vec3 v) { return v + shift; });
  return mesh_of(mesh);
}

const Meshes& meshes_of(World& world) { return internals(world).meshes; }
std::size_t used_slots(World& world) {
  const Meshes& meshes = meshes_of(world);
  return meshes.shared.size() - meshes.free_slots.size();
}
std::int32_t slot_of(World& world, ShapeId shape) { return internals(world).shapes.mesh[shape.index]; }

// Bytes of all columns of kind state.
std::vector<std::byte> state_of(World& world) {
  std::vector<std::byte> bytes;
  for_each_column(internals(world), [&](ColumnKind kind, const char*, const char*, auto& column) {
    if (kind != ColumnKind::state || column.empty()) return;
    const auto* first = reinterpret_cast<const std::byte*>(column.data());
    bytes.insert(bytes.end(), first, first + column.span().size_bytes());
  });
  return bytes;
}

template <class Call>
void expect_refused(World& world, ErrorCode code, const std::string& message, Call&& call) {
  const std::vector<std::byte> before = state_of(world);
  try {
    call();
    ADD_FAILURE() << "not refused: " << message;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code);
    EXPECT_EQ(error.what(), message);
  }
  EXPECT_EQ(state_of(world), before);
}

TEST(MeshStore, ShapesOfEqualMeshesShareOneSlot) {
  World world;
  const TriangleMesh mesh = box(1.0f);
  std::vector<BodyId> bodies;
  for (int i = 0; i < 100; ++i) {
    bodies.push_back(world.create_body({.type = i % 2 == 0 ? BodyType::fixed : BodyType::kinematic}));
    world.add_shape(bodies.back(), i % 3 == 0 ? box(1.0f) : mesh);
  }
  EXPECT_EQ(used_slots(world), 1u);
  EXPECT_EQ(meshes_of(world).shapes[0], 100);
  EXPECT_EQ(mesh_bytes(meshes_of(world).shared),
            mesh.memory() + meshes_of(world).shared.capacity() * sizeof(SharedMesh));
  world.destroy_bodies(bodies);
  EXPECT_EQ(used_slots(world), 0u);
  EXPECT_EQ(meshes_of(world).data[0], nullptr);
}

TEST(MeshStore, FreedSlotsAreUsedAgainLatestFirst) {
  World world;
  const BodyId body = world.create_body({.type = BodyType::fixed});
  ShapeId shapes[4];
  for (int i = 0; i < 4; ++i) shapes[i] = world.add_shape(body, box(1.0f + static_cast<float>(i)));
  world.destroy_shape(shapes[1]);
  world.destroy_shape(shapes[2]);
  EXPECT_EQ(slot_of(world, world.add_shape(body, box(20))), 2);
  EXPECT_EQ(slot_of(world, world.add_shape(body, box(21))), 1);
  EXPECT_EQ(slot_of(world, world.add_shape(body, box(22))), 4);
}

TEST(MeshStore, AMeshComesBackFromItsShape) {
  World world;
  const TriangleMesh mesh = mesh_of(test_solids::torus_mesh(2, 1, 10, 8));
  const ShapeId shape = world.add_shape(world.create_body({.type = BodyType::fixed}), mesh);
  EXPECT_EQ(std::get<TriangleMesh>(world.geometry(shape)), mesh);
  EXPECT_EQ(MeshAccess::solid(std::get<TriangleMesh>(world.geometry(shape))), MeshAccess::solid(mesh));
}

TEST(MeshStore, ReplacedGeometryReleasesItsMesh) {
  World world;
  const BodyId body = world.create_body({.type = BodyType::kinematic});
  const ShapeId shape = world.add_shape(body, Sphere{});
  world.set_geometry(shape, box(1.0f, {0, 5, 0}));
  EXPECT_EQ(used_slots(world), 1u);
  EXPECT_EQ(internals(world).shapes.type[shape.index], ShapeType::mesh);
  EXPECT_EQ(internals(world).shapes.local_pose[shape.index].position[1], 5.0f);
  world.set_geometry(shape, box(2.0f));
  EXPECT_EQ(used_slots(world), 1u);
  world.set_geometry(shape, Box{});
  EXPECT_EQ(used_slots(world), 0u);
  EXPECT_EQ(slot_of(world, shape), -1);
  EXPECT_EQ(internals(world).shapes.local_pose[shape.index].position[1], 0.0f);
}

TEST(MeshStore, AMeshStandsAtTheCenterOfItsBox) {
  World world;
  const BodyId body = world.create_body({.type = BodyType::fixed});
  const ShapeId shape = world.add_shape(body, box(1.0f, {3, 4, 5}), {}, {.local_pose = {{1, 1, 1}, {}}});
  const PoseRow& local = internals(world).shapes.local_pose[shape.index];
  EXPECT_EQ(local.position[0], 4.0f);
  EXPECT_EQ(local.position[1], 5.0f);
  EXPECT_EQ(local.position[2], 6.0f);
  EXPECT_EQ(world.local_pose(shape).position, (Vec3{1, 1, 1}));
  const ExtentRow& extent = internals(world).shapes.extent[shape.index];
  for (const float half : extent.half) EXPECT_EQ(half, 1.0f);
  EXPECT_NEAR(extent.radius, 1.7320508f, 1e-6f);
}

TEST(MeshStore, MeshesHaveNoMass) {
  World world;
  const BodyId bare = world.create_body({.type = BodyType::fixed});
  const BodyId ground = world.create_body({.type = BodyType::fixed});
  world.add_shape(ground, box(3.0f, {1, 2, 3}), {}, {.local_pose = {{5, 0, 0}, {}}});
  world.add_shape(ground, box(4.0f), {}, {.local_pose = {{-5, 0, 0}, {0, 0.6f, 0, 0.8f}}});
  const MassProperties expected = world.mass_properties(bare), actual = world.mass_properties(ground);
  EXPECT_EQ(actual.mass, expected.mass);
  EXPECT_EQ(actual.center, expected.center);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(actual.inertia[i], expected.inertia[i]);
  const BodyId cart = world.create_body({.type = BodyType::kinematic});
  world.add_shape(cart, Box{});
  const float mass = world.mass_properties(cart).mass;
  world.add_shape(cart, box(3.0f, {1, 2, 3}));
  EXPECT_EQ(world.mass_properties(cart).mass, mass);
}

TEST(MeshStore, DynamicBodiesCannotHaveThem) {
  World world;
  const TriangleMesh mesh = box(1.0f);
  const BodyId stone = world.create_body({}), ground = world.create_body({.type = BodyType::fixed});
  const ShapeId ball = world.add_shape(stone, Sphere{});
  const ShapeId floor = world.add_shape(ground, mesh);
  const std::string problem =
      "a triangle mesh belongs to fixed and kinematic bodies only, but the body is dynamic";
  expect_refused(world, ErrorCode::wrong_state, "World::add_shape: " + problem,
                 [&] { world.add_shape(stone, mesh); });
  expect_refused(world, ErrorCode::wrong_state, "World::add_shapes: definition 1: " + problem, [&] {
    ShapeId ids[2];
    world.add_shapes(stone, std::vector<ShapeDef>{{Box{}}, {box(2.0f)}}, ids);
  });
  expect_refused(world, ErrorCode::wrong_state, "World::set_geometry: " + problem,
                 [&] { world.set_geometry(ball, mesh); });
  expect_refused(world, ErrorCode::wrong_state, "World::create_bodies: definition 1: " + problem, [&] {
    BodyId ids[2];
    world.create_bodies(std::vector<BodyDef>{{.type = BodyType::fixed}, {}},
                        std::vector<Geometry>{box(5.0f), mesh}, {}, {}, ids);
  });
  expect_refused(world, ErrorCode::wrong_state,
                 "World::set_body_type: shape " + std::to_string(floor.index) +
                     " of the body is a triangle mesh, which belongs to fixed and kinematic bodies only",
                 [&] { world.set_body_type(ground, BodyType::dynamic); });
  world.set_body_type(ground, BodyType::kinematic);
  world.set_body_type(ground, BodyType::fixed);
  world.destroy_shape(floor);
  world.set_body_type(ground, BodyType::dynamic);
  EXPECT_EQ(used_slots(world), 0u);
}

TEST(MeshStore, SensorsCannotHaveThem) {
  World world;
  const BodyId ground = world.create_body({.type = BodyType::fixed});
  const std::string problem = "a triangle mesh is no sensor, but the shape is one";
  expect_refused(world, ErrorCode::invalid_value, "World::add_shape: " + problem,
                 [&] { world.add_shape(ground, box(1.0f), {}, {.sensor = true}); });
  const ShapeId sensor = world.add_shape(ground, Box{}, {}, {.sensor = true});
  expect_refused(world, ErrorCode::invalid_value, "World::set_geometry: " + problem,
                 [&] { world.set_geometry(sensor, box(1.0f)); });
}

TEST(MeshStore, EmptyMeshesAreRefused) {
  World world;
  const BodyId ground = world.create_body({.type = BodyType::fixed});
  expect_refused(world, ErrorCode::invalid_value,
                 "World::add_shape: the mesh is empty: it was made of no triangles, or moved from",
                 [&] { world.add_shape(ground, TriangleMesh()); });
}

TEST(MeshStore, BulkCreationWithABadMeshCreatesNothing) {
  World world;
  const BodyId body = world.create_body({.type = BodyType::fixed});
  ShapeId shapes[5];
  for (int i = 0; i < 5; ++i) shapes[i] = world.add_shape(body, box(1.0f + static_cast<float>(i)));
  for (const int i : {3, 0, 2}) world.destroy_shape(shapes[i]);
  std::vector<Geometry> geometries;
  for (int i = 0; i < 20; ++i) geometries.emplace_back(box(1.0f + static_cast<float>(i % 9)));
  geometries.emplace_back(TriangleMesh());
  std::vector<BodyId> ids(geometries.size());
  const std::vector<BodyDef> defs(geometries.size(), BodyDef{.type = BodyType::fixed});
  expect_refused(
      world, ErrorCode::invalid_value,
      "World::create_bodies: definition 20: the mesh is empty: it was made of no triangles, or moved from",
      [&] { world.create_bodies(defs, geometries, {}, {}, ids); });
  geometries.back() = box(50.0f);
  world.create_bodies(defs, geometries, {}, {}, ids);
  EXPECT_EQ(used_slots(world), 10u);
}

TEST(MeshStore, ClonesShareMeshes) {
  World world;
  const ShapeId shape = world.add_shape(world.create_body({.type = BodyType::fixed}), box(1.0f));
  World copy = clone(world);
  EXPECT_EQ(meshes_of(copy).shared[0].solid, meshes_of(world).shared[0].solid);
  EXPECT_EQ(meshes_of(copy).data[0], meshes_of(world).data[0]);
  world.destroy_shape(shape);
  EXPECT_EQ(used_slots(world), 0u);
  EXPECT_EQ(std::get<TriangleMesh>(copy.geometry(shape)), box(1.0f));
  copy.destroy_shape(shape);
  EXPECT_EQ(used_slots(copy), 0u);
}

TEST(MeshStore, WorldsWithMeshesStep) {
  World world;
  const BodyId ground = world.create_body({.type = BodyType::fixed});
  world.add_shape(ground, box(10.0f));
  const BodyId cart = world.create_body({.type = BodyType::kinematic, .linear_velocity = {50, 0, 0}});
  world.add_shape(cart, box(0.5f));
  world.add_shape(cart, Sphere{});
  const BodyId stone = world.create_body({.position = {100, 11, 0}});
  world.add_shape(stone, Sphere{});
  world.add_shape(world.create_body({.type = BodyType::fixed}), Box{}, {}, {.sensor = true});
  Workers workers(1);
  for (int i = 0; i < 30; ++i) step(world, 1.0f / 60.0f, workers);
  EXPECT_LT(world.pose(stone).position.y, 10.0f);
  EXPECT_NEAR(world.pose(cart).position.x, 25.0f, 1e-3f);
}

}  // namespace
}  // namespace scree
