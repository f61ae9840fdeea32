// Laws of snapshots as values: their content, restoring, and the effect of arbitrary bytes.
#include <core/geometry/hull/hull_build.h>
#include <core/state/snapshot/snapshot_bytes.h>
#include <core/state/snapshot/snapshot_columns.h>
#include <core/state/snapshot/snapshot_hulls.h>
#include <core/world/math.h>
#include <core/world/state_table.h>
#include <scree/scree.h>
#include <tests/core/constraints/joint_samples.h>
#include <tests/core/geometry/mesh/meshes.h>
#include <tests/core/world/world_fixture.h>

#include <cstring>
#include <set>
#include <vector>

namespace scree::test {
namespace {

using Bytes = std::vector<std::byte>;

constexpr float kStep = 1.0f / 60.0f;

Hull tetrahedron() {
  const Vec3 points[] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  return Hull(points);
}
Hull block() {
  std::vector<Vec3> points;
  for (const float x : {-0.5f, 0.4f})
    for (const float y : {-0.3f, 0.6f})
      for (const float z : {-0.7f, 0.5f}) points.push_back({x, y, z});
  points.push_back({0.0f, 1.0f, 0.1f});
  return Hull(points);
}

// Some of everything: all types of bodies and shapes, compounds, hulls with scales, sleepers, forces not yet
// applied, free and reused slots, events, changes since the last step.
struct Zoo {
  World world{WorldSettings{.contact_events = ContactEvents::begin_end}};
  std::vector<BodyId> bodies;
  std::vector<ShapeId> shapes;
  std::vector<JointId> joints;

  BodyId add(const BodyDef& def, const Geometry& geometry, const ShapeOptions& options = {}) {
    bodies.push_back(world.create_body(def));
    shapes.push_back(
        world.add_shape(bodies.back(), geometry, {.friction = 0.7f, .restitution = 0.2f}, options));
    return bodies.back();
  }

  explicit Zoo(int steps = 40, int size = 12) {
    add({.type = BodyType::fixed, .position = {0, -1, 0}}, Box{{20, 1, 20}});
    add({.type = BodyType::kinematic, .position = {2, 0.2f, 0}, .linear_velocity = {0.1f, 0, 0}},
        Box{{0.5f, 0.2f, 0.5f}});
    add_meshes();
    const Hull hulls[] = {tetrahedron(), block()};
    Random random(5);
    for (int i = 0; i < size; ++i) {
      const BodyDef def{
          .position = {random.between(-2, 2), 0.6f + 0.3f * static_cast<float>(i), random.between(-2, 2)},
          .locks = i % 7 == 0 ? AxisLocks::rotation_y : AxisLocks::none,
          .user_data = static_cast<std::uint64_t>(i)};
      switch (i % 5) {
        case 0:
          add(def, Sphere{0.3f});
          break;
        case 1:
          add(def, Capsule{0.3f, 0.2f}, {.local_pose = {{0.1f, 0, 0}, {}}});
          break;
        case 2:
          add(def, Box{{0.3f, 0.2f, 0.4f}});
          break;
        case 3:
          add(def, ConvexHull{hulls[0], {0.4f, 0.4f, 0.5f}});
          break;
        default:
          shapes.push_back(world.add_shape(add(def, ConvexHull{hulls[1]}), Sphere{0.2f}));
          break;
      }
    }
    add_joints();
    run(steps);
    world.destroy_body(bodies[3]);
    world.destroy_shape(shapes.back());
    bodies[3] = add({.position = {0, 9, 0}}, Box{});
    world.destroy_body(bodies[4]);
    world.add_force(bodies[5], {3, 4, 5});
    world.set_pose(bodies[6], {{0, 7, 0}, {}});
  }
  // One of two surfaces, one of two shapes, and one whose slot is free again. They are far away.
  void add_meshes() {
    const BodyId land = world.create_body({.type = BodyType::fixed, .position = {0, 0, 500}});
    test_solids::TestMesh ring = test_solids::torus_mesh(5, 2, 9, 6);
    ring.triangles.push_back(ring.triangles[7]);
    std::vector<std::uint8_t> surface(ring.triangles.size(), 255);
    surface[3] = 0;
    const Material ice{.friction = 0.01f};
    const TriangleMesh mesh(ring.vertices, ring.triangles, {surface, std::span(&ice, 1)});
    const test_solids::TestMesh box = test_solids::box_mesh({1, 2, 3}), ball = test_solids::ball_mesh(1, 1);
    const ShapeId gone = world.add_shape(land, TriangleMesh(ball.vertices, ball.triangles));
    world.add_shape(land, mesh);
    world.add_shape(land, mesh, {}, {.local_pose = {{30, 0, 0}, {}}});
    world.add_shape(land, TriangleMesh(box.vertices, box.triangles), {}, {.local_pose = {{60, 0, 0}, {}}});
    world.destroy_shape(gone);
  }
  // Of all kinds, each between a body and the next but one, or the world; some keep their bodies apart.
  void add_joints() {
    const std::size_t movable = bodies.size() - 2;
    for (const Joint& joint : sound_joints()) {
      const std::size_t number = joints.size(), next = 2 + (number + 2) % movable;
      const bool with_world = std::holds_alternative<MouseJoint>(joint) || number % 4 == 0;
      joints.push_back(
          world.create_joint({.body_a = with_world ? kWorld : bodies[2 + number % movable],
                              .body_b = bodies[next],
                              .frame_a = {with_world ? world.pose(bodies[next]).position : Vec3{}, {}},
                              .collide_connected = number % 3 == 0,
                              .hertz = 2.0f},
                             joint));
    }
    world.destroy_joint(joints[5]);
  }
  void run(int steps) {
    Workers workers(1);
    for (int i = 0; i < steps; ++i) step(world, kStep, workers);
  }
};

Bytes saved_bytes(const World& world) {
  Snapshot snapshot;
  save(world, snapshot);
  return write_snapshot(snapshot);
}

void run(World& world, int steps) {
  Workers workers(1);
  for (int i = 0; i < steps; ++i) step(world, kStep, workers);
}

TEST(Snapshot, HoldsTheSameBytesAfterEveryWay) {
  Zoo zoo;
  Snapshot snapshot;
  EXPECT_TRUE(snapshot.is_empty());
  save(zoo.world, snapshot);
  EXPECT_FALSE(snapshot.is_empty());
  EXPECT_EQ(snapshot.step(), zoo.world.stats().step);
  const Bytes bytes = write_snapshot(snapshot);
  EXPECT_EQ(write_snapshot(read_snapshot(bytes)), bytes);
  World other;
  restore(other, snapshot);
  EXPECT_EQ(saved_bytes(other), bytes);
  EXPECT_EQ(saved_bytes(clone(zoo.world)), bytes);
  EXPECT_EQ(saved_bytes(zoo.world), bytes);
}

TEST(Snapshot, OfANewWorldHoldsItsSettings) {
  const World world(WorldSettings{.gravity = {1, 2, 3}, .substeps = 7, .continuous = false});
  World copy = clone(world);
  EXPECT_EQ(copy.settings().gravity, (Vec3{1, 2, 3}));
  EXPECT_EQ(copy.settings().substeps, 7);
  EXPECT_FALSE(copy.settings().continuous);
  EXPECT_EQ(copy.body_count(), 0u);
  EXPECT_EQ(saved_bytes(copy), saved_bytes(world));
  EXPECT_EQ(write_snapshot(read_snapshot(saved_bytes(world))), saved_bytes(world));
}

TEST(Snapshot, RestoresWhatCallsReturn) {
  Zoo zoo;
  const World copy = clone(zoo.world);
  EXPECT_EQ(copy.body_count(), zoo.world.body_count());
  EXPECT_EQ(copy.shape_count(), zoo.world.shape_count());
  EXPECT_EQ(copy.hash(), zoo.world.hash());
  EXPECT_EQ(copy.stats().step, zoo.world.stats().step);
  for (std::uint32_t index = 0; index < 20; ++index) {
    const BodyId body = zoo.world.body_at(index);
    ASSERT_EQ(copy.body_at(index), body);
    if (!zoo.world.is_alive(body)) continue;
    EXPECT_EQ(copy.pose(body), zoo.world.pose(body));
    EXPECT_EQ(copy.linear_velocity(body), zoo.world.linear_velocity(body));
    EXPECT_EQ(copy.mass_properties(body).mass, zoo.world.mass_properties(body).mass);
    EXPECT_EQ(copy.user_data(body), zoo.world.user_data(body));
    EXPECT_EQ(copy.locks(body), zoo.world.locks(body));
    ShapeId left[4], right[4];
    const std::size_t count = zoo.world.shapes_of(body, left);
    ASSERT_EQ(copy.shapes_of(body, right), count);
    for (std::size_t k = 0; k < count; ++k) {
      ASSERT_EQ(left[k], right[k]);
      EXPECT_EQ(copy.local_pose(left[k]), zoo.world.local_pose(left[k]));
      EXPECT_EQ(copy.material(left[k]), zoo.world.material(left[k]));
      ASSERT_EQ(copy.geometry(left[k]).index(), zoo.world.geometry(left[k]).index());
      const Geometry geometry = zoo.world.geometry(left[k]);
      if (const auto* hull = std::get_if<ConvexHull>(&geometry)) {
        EXPECT_EQ(std::get<ConvexHull>(copy.geometry(left[k])), *hull);
      }
    }
  }
}

TEST(Snapshot, IsUnchangedByWhatHappensAfterwards) {
  Zoo zoo;
  Snapshot snapshot;
  save(zoo.world, snapshot);
  const Bytes bytes = write_snapshot(snapshot);
  zoo.run(20);
  zoo.world.destroy_body(zoo.bodies[7]);
  zoo.add({.position = {1, 5, 1}}, ConvexHull{block(), {0.5f, 0.6f, 0.7f}});
  zoo.run(20);
  EXPECT_EQ(write_snapshot(snapshot), bytes);
  const Bytes changed = saved_bytes(zoo.world);
  EXPECT_NE(changed, bytes);
  restore(zoo.world, snapshot);
  EXPECT_EQ(saved_bytes(zoo.world), bytes);
}

TEST(Snapshot, GoesOnAsTheWorldDid) {
  Zoo zoo, other(3, 30);
  Snapshot snapshot;
  save(zoo.world, snapshot);
  restore(other.world, read_snapshot(write_snapshot(snapshot)));
  World fresh = clone(zoo.world);
  for (int i = 0; i < 60; ++i) {
    zoo.run(1);
    other.run(1);
    run(fresh, 1);
    ASSERT_EQ(saved_bytes(other.world), saved_bytes(zoo.world)) << i;
    ASSERT_EQ(saved_bytes(fresh), saved_bytes(zoo.world)) << i;
  }
}

TEST(Snapshot, LaterCallsGiveTheSameResults) {
  Zoo zoo;
  World copy = clone(zoo.world);
  const auto change = [&](World& world) {
    const BodyId body = world.create_body({.position = {0, 4, 0}, .mass = 3.0f});
    const ShapeId shape = world.add_shape(body, ConvexHull{block(), {1.0f, 2.0f, 1.0f}});
    world.set_geometry(zoo.shapes[8], ConvexHull{tetrahedron()});
    world.set_body_type(zoo.bodies[9], BodyType::kinematic);
    world.set_kinematic_target(zoo.bodies[1], {{1, 0.3f, 0}, {}}, kStep);
    world.destroy_body(zoo.bodies[10]);
    run(world, 10);
    world.destroy_shape(shape);
    run(world, 10);
    return body;
  };
  EXPECT_EQ(change(zoo.world), change(copy));
  EXPECT_EQ(saved_bytes(copy), saved_bytes(zoo.world));
}

TEST(Snapshot, MakesExactlyTheHandlesOfItsMomentValid) {
  World world;
  const BodyId kept = world.create_body({});
  const BodyId destroyed = world.create_body({});
  const ShapeId shape = world.add_shape(kept, Sphere{});
  const BodyId dead = world.create_body({});
  world.destroy_body(dead);
  Snapshot snapshot;
  save(world, snapshot);
  world.destroy_body(destroyed);
  const BodyId in_its_place = world.create_body({});
  const BodyId at_the_end = world.create_body({});
  const ShapeId later = world.add_shape(at_the_end, Box{});
  ASSERT_EQ(in_its_place.index, destroyed.index);
  restore(world, snapshot);
  EXPECT_TRUE(world.is_alive(kept) && world.is_alive(destroyed) && world.is_alive(shape));
  for (const BodyId body : {dead, in_its_place, at_the_end}) EXPECT_FALSE(world.is_alive(body));
  EXPECT_FALSE(world.is_alive(later));
  EXPECT_NE(error_of([&] { world.pose(at_the_end); }), "");
  // Generations are back, too: the next body has the handle that one of these had.
  EXPECT_EQ(world.create_body({}), at_the_end);
}

TEST(Snapshot, SharesHulls) {
  Zoo zoo;
  std::vector<Snapshot> snapshots(50);
  for (Snapshot& snapshot : snapshots) save(zoo.world, snapshot);
  const auto& hulls = internals(zoo.world).hulls.shared;
  ASSERT_GE(hulls.size(), 2u);
  for (const Snapshot& snapshot : snapshots) {
    const SnapshotData& data = *SnapshotAccess::data(snapshot);
    for (std::size_t slot = 0; slot < hulls.size(); ++slot)
      EXPECT_EQ(data.hulls[slot].solid, hulls[slot].solid);
  }
  World other;
  restore(other, snapshots.back());
  EXPECT_EQ(internals(other).hulls.shared[0].solid, hulls[0].solid);
}

TEST(Snapshot, WritesEachHullOnce) {
  const Hull hull = block();
  const auto size_with = [&hull](int bodies) {
    World world;
    for (int i = 0; i < bodies; ++i) {
      world.add_shape(world.create_body({.position = {3.0f * static_cast<float>(i), 0, 0}}),
                      ConvexHull{hull});
    }
    return saved_bytes(world).size();
  };
  EXPECT_LT(size_with(60) - size_with(10), 50 * 320u);
}

TEST(Snapshot, RefusesInvalidStates) {
  World world;
  Snapshot empty, snapshot;
  EXPECT_EQ(error_of([&] { restore(world, empty); }), "restore: the snapshot is empty");
  EXPECT_EQ(error_of([&] { write_snapshot(empty); }), "write_snapshot: the snapshot is empty");
  const World moved = std::move(world);
  EXPECT_EQ(error_of([&] { save(world, snapshot); }), "save: the world has been moved from");
  save(moved, snapshot);
  EXPECT_EQ(error_of([&] { restore(world, snapshot); }), "restore: the world has been moved from");
  Snapshot other = std::move(snapshot);
  EXPECT_TRUE(snapshot.is_empty());
  EXPECT_FALSE(other.is_empty());
}

// --- changes ---

TEST(SnapshotChanges, ReproduceTheLaterSnapshot) {
  Zoo zoo;
  Snapshot base, later, again;
  SnapshotChanges changes;
  EXPECT_TRUE(changes.is_empty());
  save(zoo.world, base);
  for (int i = 0; i < 30; ++i) {
    if (i == 10) zoo.world.destroy_body(zoo.bodies[7]);
    if (i == 20) zoo.add({.position = {1, 5, 1}}, ConvexHull{block(), {0.5f, 0.6f, 0.7f}});
    if (i == 25) zoo.world.destroy_bodies(std::vector<BodyId>{zoo.bodies[1], zoo.bodies[8], zoo.bodies[9]});
    zoo.run(1);
    save(zoo.world, later);
    keep_changes(base, later, changes);
    apply_changes(base, changes, again);
    ASSERT_EQ(write_snapshot(again), write_snapshot(later)) << i;
    World copy;
    restore(copy, again);
    ASSERT_EQ(saved_bytes(copy), saved_bytes(zoo.world)) << i;
  }
  keep_changes(later, later, changes);
  apply_changes(later, changes, again);
  EXPECT_EQ(write_snapshot(again), write_snapshot(later));
}

TEST(SnapshotChanges, AreSmallWhereLittleChanges) {
  World world;
  world.add_shape(world.create_body({.type = BodyType::fixed, .position = {0, -1, 0}}), Box{{50, 1, 50}});
  for (int i = 0; i < 300; ++i) {
    const BodyId body = world.create_body(
        {.position = {static_cast<float>(i % 20) - 10.0f, 0.4f, static_cast<float>(i / 20) - 8.0f}});
    world.add_shape(body, Box{{0.4f, 0.4f, 0.4f}});
  }
  run(world, 120);
  Snapshot base, later;
  SnapshotChanges changes;
  save(world, base);
  run(world, 30);
  save(world, later);
  keep_changes(base, later, changes);
  EXPECT_LT(changes.bytes(), later.bytes() / 10) << "all sleep";
  EXPECT_GT(changes.bytes(), 0u);
}

TEST(SnapshotChanges, AreRefusedWithAnotherBase) {
  Zoo zoo;
  Snapshot base, later, other, empty;
  SnapshotChanges changes, none;
  save(zoo.world, base);
  zoo.run(1);
  save(zoo.world, later);
  save(zoo.world, other);
  EXPECT_EQ(error_of([&] { keep_changes(empty, later, changes); }), "keep_changes: the snapshot is empty");
  EXPECT_EQ(error_of([&] { keep_changes(base, empty, changes); }), "keep_changes: the snapshot is empty");
  EXPECT_EQ(error_of([&] { apply_changes(base, none, other); }), "apply_changes: the changes are empty");
  keep_changes(base, later, changes);
  EXPECT_NE(error_of([&] { apply_changes(later, changes, other); }), "");
  EXPECT_NE(error_of([&] { apply_changes(base, changes, base); }), "");
  EXPECT_EQ(write_snapshot(later), saved_bytes(zoo.world)) << "a call that throws has changed nothing";
  save(zoo.world, base);
  EXPECT_NE(error_of([&] { apply_changes(base, changes, other); }), "");
}

TEST(StateTable, LetsSnapshotsPackEveryStateColumn) {
  World world;
  Snapshot snapshot;
  save(world, snapshot);
  Column<std::byte> columns;
  pack_columns(SnapshotAccess::data(snapshot)->pages->sheets, columns);
  const SavedColumns saved = find_columns(columns);
  std::multiset<std::string> packed, state{"bodies.core"};  // which takes longer to make than to copy
  for (std::size_t i = 0; i < saved.count; ++i) {
    packed.insert(std::string(saved.column[i].store) + "." + std::string(saved.column[i].name));
  }
  for_each_column(internals(world), [&](ColumnKind kind, const char* store, const char* name, const auto&) {
    if (kind == ColumnKind::state) state.insert(std::string(store) + "." + name);
  });
  EXPECT_EQ(packed, state);
}

// --- arbitrary bytes ---

// The effect of bytes: either an error with offset and reason, or a world that steps.
bool loads(const Bytes& bytes) {
  Snapshot snapshot;
  try {
    snapshot = read_snapshot(bytes);
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find("read_snapshot: byte "), 0u) << error.what();
    return false;
  }
  World world;
  restore(world, snapshot);
  run(world, 2);
  EXPECT_EQ(write_snapshot(snapshot), bytes);
  return true;
}

TEST(SnapshotBytes, AreRefusedAtEveryLengthButTheirOwn) {
  const Bytes bytes = saved_bytes(Zoo(10, 6).world);
  ASSERT_TRUE(loads(bytes));
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    ASSERT_FALSE(loads(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)))) << length;
  }
  Bytes longer = bytes;
  longer.push_back({});
  EXPECT_FALSE(loads(longer));
}

TEST(SnapshotBytes, AreRefusedAtEveryOtherLengthEvenWithAValidChecksum) {
  const Bytes bytes = saved_bytes(Zoo(10, 6).world);
  constexpr std::size_t kSizeEnd = 32, kHashEnd = 40;  // where the head has them
  for (std::size_t length = kSizeEnd; length < bytes.size(); ++length) {
    Bytes cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
    if (length >= kHashEnd) {
      seal_snapshot(cut);
    } else {
      const std::uint64_t size = length;
      std::memcpy(cut.data() + kSizeEnd - sizeof size, &size, sizeof size);
    }
    ASSERT_FALSE(loads(cut)) << length;
  }
}

TEST(SnapshotBytes, AreRefusedIfABitIsWrong) {
  const Bytes bytes = saved_bytes(Zoo(10, 6).world);
  Random random(3);
  for (int i = 0; i < 2000; ++i) {
    Bytes wrong = bytes;
    wrong[random.below(wrong.size())] ^= static_cast<std::byte>(1u << random.below(8));
    ASSERT_FALSE(loads(wrong));
  }
}

TEST(SnapshotBytes, NeverCorruptAWorld) {
  const Bytes bytes = saved_bytes(Zoo(30, 8).world);
  Random random(4);
  int loaded = 0;
  for (int i = 0; i < 10000; ++i) {
    Bytes wrong = bytes;
    const std::size_t flips = 1 + random.below(3);
    for (std::size_t flip = 0; flip < flips; ++flip) {
      wrong[40 + random.below(wrong.size() - 40)] ^= static_cast<std::byte>(1u << random.below(8));
    }
    seal_snapshot(wrong);
    loaded += loads(wrong) ? 1 : 0;
  }
  EXPECT_GT(loaded, 100);  // a flipped bit of a velocity is a velocity
  EXPECT_LT(loaded, 9900);
}

TEST(SnapshotBytes, NeverCorruptAWorldWithArbitraryNumbers) {
  // Changes whole words instead of bits, to reach indices and counts.
  const Bytes bytes = saved_bytes(Zoo(30, 8).world);
  constexpr std::uint32_t kWords[] = {0,          1,          2,          0x7fffffff, 0xffffffff,
                                      0x80000000, 0x7fc00000, 0x7f800000, 64};
  Random random(5);
  for (std::size_t at = 40; at + 4 <= bytes.size(); at += 4) {
    Bytes wrong = bytes;
    const std::uint32_t word = kWords[random.below(std::size(kWords))];
    std::memcpy(wrong.data() + at, &word, sizeof word);
    seal_snapshot(wrong);
    loads(wrong);
  }
}

TEST(SnapshotBytes, ListAllFreeRowsOfContacts) {
  Zoo zoo;
  internals(zoo.world).contacts.now.resize(internals(zoo.world).contacts.now.points.size() + 1000);
  EXPECT_NE(error_of([&] { read_snapshot(saved_bytes(zoo.world)); }).find("some free row is not listed"),
            std::string::npos);
}

TEST(SnapshotBytes, RefuseManifoldsOfRowsThatNoBodyHas) {
  World world;
  ShapeId spheres[2];
  for (ShapeId& sphere : spheres) sphere = world.add_shape(world.create_body({}), Sphere{1.0f});
  add_touching(world, spheres[0], spheres[1]);
  Manifold& manifold = internals(world).contacts.now.manifold[0];
  manifold.info = 1;
  world.destroy_shape(spheres[0]);  // so that no check looks for the manifold's bodies
  for (const std::int32_t row : {0, 1, kFirstBody - 1}) {
    manifold.row_a = kFixedRow;
    manifold.row_b = row;
    EXPECT_NE(
        error_of([&] { read_snapshot(saved_bytes(world)); }).find("is not between the bodies of its pair"),
        std::string::npos)
        << row;
  }
  manifold.row_b = kFirstBody;
  EXPECT_EQ(error_of([&] { read_snapshot(saved_bytes(world)); }), "");
  manifold.row_a = 1;
  EXPECT_NE(
      error_of([&] { read_snapshot(saved_bytes(world)); }).find("is not between the bodies of its pair"),
      std::string::npos);
}

TEST(SnapshotBytes, ListAllFreeSlots) {
  const auto refusal_without_one = [](auto&& slots_of) {
    Zoo zoo;
    slots_of(zoo.world).pop_back();
    return error_of([&] { read_snapshot(saved_bytes(zoo.world)); });
  };
  const std::string body =
      refusal_without_one([](World & world) -> auto& { return internals(world).bodies.free_slots; });
  EXPECT_NE(body.find("bodies.free_slots, row 0: some free slot is not listed"), std::string::npos) << body;
  const std::string shape =
      refusal_without_one([](World & world) -> auto& { return internals(world).shapes.free_slots; });
  EXPECT_NE(shape.find("shapes.free_slots, row 0: some free slot is not listed"), std::string::npos) << shape;
}

TEST(SnapshotBytes, HoldSlotsWhoseGenerationsAreUsedUp) {
  Zoo zoo;
  BodyId body = zoo.bodies[5];
  internals(zoo.world).bodies.generation[body.index] = body.generation = 0xffffffffu;
  ShapeId shape = zoo.shapes[6];
  internals(zoo.world).shapes.generation[shape.index] = shape.generation = 0xffffffffu;
  zoo.world.destroy_body(body);
  zoo.world.destroy_shape(shape);
  World other;
  restore(other, read_snapshot(saved_bytes(zoo.world)));
  EXPECT_EQ(saved_bytes(other), saved_bytes(zoo.world));
}

// The bytes of a tetrahedron, one face of which goes from its first corner to a point in its middle and back.
Bytes spiked_hull() {
  ByteWriter writer;
  const Hull hull = tetrahedron();
  write_hulls({SharedHull{ConvexHull{hull}, HullAccess::solid(hull)}}, writer);
  const Bytes whole = writer.take();
  constexpr std::size_t kNumbers = 4, kVertices = 76, kPoints = 124, kCounts = 172, kLoops = 180;
  std::uint32_t numbers[] = {5, 4, 14};  // vertices, faces, corners
  Vec3 corner[4];
  std::memcpy(corner, whole.data() + kVertices, sizeof corner);
  std::uint8_t face[3];
  std::memcpy(face, whole.data() + kLoops, sizeof face);
  const Vec3 middle = (corner[face[0]] + corner[face[1]] + corner[face[2]]) * (1.0f / 3.0f);
  const std::uint16_t count = 5;
  const std::uint8_t spike[] = {face[0], 4};

  Bytes bytes(whole.begin(), whole.begin() + kPoints);
  const auto append = [&bytes](const void* from, std::size_t size) {
    const auto* first = static_cast<const std::byte*>(from);
    bytes.insert(bytes.end(), first, first + size);
  };
  std::memcpy(bytes.data() + kNumbers, numbers, sizeof numbers);
  append(&middle, sizeof middle);
  append(whole.data() + kPoints, kCounts - kPoints);
  append(&middle, sizeof middle);
  append(&count, sizeof count);
  append(whole.data() + kCounts + sizeof count, kLoops - kCounts - sizeof count);
  append(spike, sizeof spike);
  append(whole.data() + kLoops, whole.size() - kLoops);
  return bytes;
}

TEST(SnapshotBytes, RefuseAFaceThatVisitsACornerTwice) {
  const Bytes bytes = spiked_hull();
  EXPECT_NE(error_of([&] {
              ByteReader reader(bytes);
              read_hulls(reader);
            }).find("a hull's face has a corner twice"),
            std::string::npos);
}

TEST(SnapshotBytes, AreRefusedWithTheReason) {
  Bytes bytes = saved_bytes(Zoo(10, 6).world);
  const auto refusal = [&bytes](std::size_t at, std::uint32_t word) {
    Bytes wrong = bytes;
    std::memcpy(wrong.data() + at, &word, sizeof word);
    return error_of([&] { read_snapshot(wrong); });
  };
  EXPECT_EQ(refusal(0, 0), "read_snapshot: byte 0: this is no snapshot");
  EXPECT_EQ(refusal(8, 8), "read_snapshot: byte 8: the snapshot has version 8, this is version 7");
  EXPECT_EQ(refusal(12, 0x04030201), "read_snapshot: byte 12: the bytes are not in little-endian order");
  EXPECT_EQ(refusal(16, 0), "read_snapshot: byte 16: a version of Scree with other columns has written this");
  EXPECT_EQ(refusal(32, 0), "read_snapshot: byte 32: the checksum is wrong");
  EXPECT_EQ(error_of([&] { read_snapshot({}); }), "read_snapshot: byte 0: the snapshot ends too early");
}

}  // namespace
}  // namespace scree::test
