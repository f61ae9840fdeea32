// Laws of recordings: replaying one repeats the history of its world.
#include <core/state/world_difference.h>
#include <sys/stat.h>
#include <tests/core/geometry/mesh/meshes.h>
#include <tests/parallel/recording/recording_fixture.h>

#include <fcntl.h>
#include <atomic>
#include <chrono>
#include <set>
#include <thread>

namespace scree::test {
namespace {

constexpr RecorderOptions kOften{.keyframe_spacing = 20, .flush_interval = 0.02f};

// Makes every call of the table.
void call_everything(Heap& heap) {
  World& world = heap.world;
  const auto body = [&heap](std::size_t i) { return heap.bodies[i]; };
  world.create_body({.position = {1, 9, 1}, .mass = 2.0f, .user_data = 7});
  std::vector<BodyId> ids(3);
  world.create_bodies(std::vector<BodyDef>(3, BodyDef{.position = {4, 1, 4}}), ids);
  const std::vector<BodyDef> defs{{.position = {3, 5, 0}}, {.position = {3, 7, 0}}, {.position = {3, 9, 0}}};
  const std::vector<Geometry> geometries{Box{}, ConvexHull{wedge(), {1.0f, 2.0f, 1.0f}}, Capsule{}};
  std::vector<BodyId> more(3);
  world.create_bodies(defs, geometries, {.friction = 0.3f}, {.user_data = 3}, more);
  world.destroy_body(ids[1]);
  world.destroy_bodies(std::vector<BodyId>{ids[0], body(2)});
  world.set_body_type(body(3), BodyType::kinematic);
  world.set_pose(body(4), {{0, 8, 0}, {0, 0, 0.6f, 0.8f}});
  world.set_linear_velocity(body(5), {1, 2, 3});
  world.set_angular_velocity(body(5), {3, 2, 1});
  world.set_kinematic_target(body(1), {{2.1f, 0.3f, 0.1f}, {}}, kDt);
  world.set_mass_properties(body(6), {.mass = 3.0f});
  world.set_mass_properties(body(7), {.mass = 4.0f});
  world.reset_mass(body(7));
  world.set_linear_damping(body(8), 0.1f);
  world.set_angular_damping(body(8), 0.2f);
  world.set_gravity_factor(body(8), 0.9f);
  world.set_locks(body(9), AxisLocks::rotation_x | AxisLocks::translation_z);
  world.set_can_sleep(body(9), false);
  world.wake(body(10));
  world.set_user_data(body(10), 11);
  world.add_force(body(11), {1, 1, 1});
  world.add_force_at(body(11), {0, 2, 0}, {1, 1, 1});
  world.add_torque(body(11), {0, 0, 1});
  world.add_impulse(body(12), {0, 1, 0});
  world.add_impulse_at(body(12), {0, 0, 1}, {1, 2, 3});
  world.add_angular_impulse(body(12), {0, 0.1f, 0});
  const ShapeId shape =
      world.add_shape(more[0], Sphere{0.4f}, {.restitution = 0.5f}, {.local_pose = {{0, 1, 0}, {}}});
  const ShapeId gone = world.add_shape(more[2], ConvexHull{wedge()});
  world.destroy_shape(gone);
  std::vector<ShapeId> shapes(2);
  world.add_shapes(more[1],
                   std::vector<ShapeDef>{{ConvexHull{wedge()}}, {Box{}, {.density = 2.0f}, {.user_data = 4}}},
                   shapes);
  world.set_geometry(shape, ConvexHull{wedge(), {0.5f, 0.5f, 0.5f}});
  const BodyId land = world.create_body({.type = BodyType::fixed, .position = {0, -50, 0}});
  const test_solids::TestMesh ring = test_solids::torus_mesh(5, 2, 9, 6),
                              block = test_solids::box_mesh({1, 2, 3});
  const ShapeId hills = world.add_shape(land, TriangleMesh(ring.vertices, ring.triangles));
  world.add_shape(land, TriangleMesh(ring.vertices, ring.triangles));
  world.set_geometry(hills, TriangleMesh(block.vertices, block.triangles));
  world.set_material(shape, {.friction = 0.9f, .density = 500.0f});
  world.set_filter(shape, {.category = 3, .mask = 0xff, .group = 1});
  world.set_contact_events(shape, ContactEvents::all);
  world.set_local_pose(shape, {{0, 0.5f, 0.5f}, {}});
  world.set_user_data(shape, 12);
  WorldSettings settings = world.settings();
  settings.gravity.x = 0.5f;
  world.set_settings(settings);

  const JointDef def{
      .body_a = more[0], .body_b = more[1], .frame_a = {{0, 1, 0}, {}}, .frame_b = {{0, -1, 0}, {}}};
  const JointId joint = world.create_joint(def, HingeJoint{});
  std::vector<JointId> joints(2);
  world.create_joints(
      std::vector<JointDef>{{.body_a = kWorld, .body_b = more[2]}, {.body_a = kWorld, .body_b = body(13)}},
      std::vector<Joint>{BallJoint{.cone_limit = 1.0f}, MouseJoint{.target = {1, 2, 3}}}, joints);
  world.destroy_joint(joints[0]);
  world.set_joint(joint, HingeJoint{{.drive = Drive::motor, .speed = 2.0f, .max_force = 5.0f}});
  world.set_joint_frames(joint, {{0, 1.1f, 0}, {}}, {{0, -0.9f, 0}, {}});
  world.set_joint_stiffness(joint, 5.0f, 0.5f);
  world.set_joint_strength(joint, 1e6f, 1e6f);
  world.set_joint_event_thresholds(joint, 1.0f, 0.5f);
  world.set_joint_enabled(joint, false);
  world.set_joint_enabled(joint, true);
  world.set_collide_connected(joint, true);
  world.set_user_data(joint, 13);
  const JointId stated = world.create_joint({.body_a = kWorld, .body_b = more[2]}, UserJoint{});
  UserRow row{.jacobian = {.linear_b = {0, 1, 0}}};
  world.set_user_rows(stated, {&row, 1});
  row.target.speed = 0.5f;
  world.refresh_user_rows({&stated, 1}, {&row, 1});
  world.set_contact_hooks(shape, ContactHooks::all);
  std::vector<ShapeId> named = {shapes[0], shapes[1], hills};
  std::sort(named.begin(), named.end());
  const ContactAnswer answers[] = {
      {named[0], named[1], -1, {}},
      {named[0], named[2], 1, {.friction = 0.5f, .surface_velocity = {1, 2, 3}}}};
  world.answer_contact_hooks(answers);
}

TEST(Recording, HoldsEveryCallThatChangesAWorld) {
  const TemporaryFile file;
  Heap heap;
  heap.run(30);
  Recorder recorder(heap.world, file.path());
  call_everything(heap);
  heap.run(20);
  recorder.finish();
  std::set<int> numbers;
  TakenApart parts(file.bytes());
  std::uint64_t calls = 0;
  for (const TakenApart::Chunk& chunk : parts.chunks) {
    if (chunk.head.kind != ChunkKind::calls) continue;
    calls += chunk.head.count;
    places_of_steps(chunk.content, [&](RecordedCall call) { numbers.insert(static_cast<int>(call)); });
  }
  for (int call = 0; call < static_cast<int>(RecordedCall::count); ++call) {
    EXPECT_TRUE(numbers.contains(call)) << name_of(static_cast<RecordedCall>(call)) << " is not recorded";
  }
  Player player(file.path());
  EXPECT_EQ(player.info().calls, calls);
  EXPECT_EQ(player.info().first_step, 30u);
  EXPECT_EQ(player.info().last_step, 50u);
  EXPECT_TRUE(player.info().finished);
  EXPECT_EQ(verified(player, heap.workers), "");
  EXPECT_EQ(first_difference(heap.world, player.world()), "");
  EXPECT_EQ(player.position(), 50u);
}

TEST(Recording, PlaysStepByStepWithTheSameHashesAndEvents) {
  const TemporaryFile file;
  Heap heap;
  std::vector<std::uint64_t> hashes;
  std::vector<std::size_t> begins;
  {
    Recorder recorder(heap.world, file.path(), kOften);
    for (int i = 0; i < 70; ++i) {
      if (i % 10 == 3) heap.add({.position = {0.1f * static_cast<float>(i), 4, 0}}, Sphere{0.4f});
      heap.run(1);
      hashes.push_back(heap.world.hash());
      begins.push_back(heap.world.contact_begins().size());
    }
    EXPECT_EQ(recorder.steps(), 70u);
    EXPECT_EQ(recorder.error(), "");
  }
  Player player(file.path());
  EXPECT_TRUE(player.info().finished) << "the recorder's end is the recording's";
  EXPECT_EQ(player.position(), 0u);
  EXPECT_FALSE(player.recorded_hash());
  for (std::size_t i = 0; i < hashes.size(); ++i) {
    ASSERT_TRUE(player.step(heap.workers));
    ASSERT_EQ(player.world().hash(), hashes[i]) << i;
    ASSERT_EQ(player.recorded_hash(), hashes[i]);
    ASSERT_EQ(player.position(), i + 1);
    ASSERT_EQ(player.world().contact_begins().size(), begins[i]);
  }
  EXPECT_FALSE(player.step(heap.workers));
  EXPECT_EQ(player.position(), 70u);
  EXPECT_EQ(keyframe_steps(player), (std::vector<std::uint64_t>{0, 20, 40, 60, 70}));
}

TEST(Recording, PlaysTheSameFromEveryStep) {
  const TemporaryFile file;
  Heap heap;
  std::vector<std::uint64_t> hashes{heap.world.hash()};
  Recorder recorder(heap.world, file.path(), kOften);
  for (int i = 0; i < 90; ++i) {
    if (i % 7 == 2) heap.world.add_impulse(heap.bodies[2 + static_cast<std::size_t>(i) % 5], {0, 3, 1});
    heap.run(1);
    hashes.push_back(heap.world.hash());
  }
  recorder.finish();
  Player player(file.path());
  for (std::uint64_t step = 0; step <= 90; step += 1) {
    const std::uint64_t target = step * 37 % 91;  // to and fro
    player.seek(target, heap.workers);
    ASSERT_EQ(player.position(), target);
    ASSERT_EQ(player.world().hash(), hashes[target]) << target;
    ASSERT_EQ(player.world().stats().step, target);
    ASSERT_TRUE(player.world().contact_begins().empty());
    ASSERT_EQ(player.recorded_hash().value_or(hashes[target]), hashes[target]);
    if (target == 90) continue;
    ASSERT_TRUE(player.step(heap.workers));
    ASSERT_EQ(player.world().hash(), hashes[target + 1]);
  }
  EXPECT_EQ(error_of_call([&] { player.seek(91, heap.workers); }),
            "Player::seek: step is 91, must lie in [0, 90]");
  EXPECT_EQ(error_of_call([&] { player.verify(5, 4, heap.workers); }),
            "Player::verify: step 5 comes after step 4");
}

TEST(Recording, BranchesIntoWorldsOfTheirOwn) {
  const TemporaryFile file;
  Heap heap;
  Recorder recorder(heap.world, file.path(), kOften);
  heap.run(50);
  recorder.finish();
  Player player(file.path());
  player.seek(30, heap.workers);
  World branch = player.branch();
  World other = player.branch();
  branch.set_linear_velocity(branch.body_at(heap.bodies[4].index), {5, 5, 5});
  for (int i = 0; i < 20; ++i) {
    player.step(heap.workers);
    step(other, kDt, heap.workers);
    step(branch, kDt, heap.workers);
  }
  EXPECT_EQ(first_difference(heap.world, player.world()), "");
  EXPECT_EQ(first_difference(heap.world, other), "");
  EXPECT_NE(first_difference(heap.world, branch), "");
}

TEST(Recording, GoesOnThroughRestoredSnapshots) {
  const TemporaryFile file;
  Heap heap, other(30);
  Recorder recorder(heap.world, file.path(), kOften);
  Snapshot early, foreign;
  heap.run(10);
  save(heap.world, early);
  other.run(25);
  save(other.world, foreign);
  heap.world.set_linear_velocity(heap.bodies[5], {0, 9, 0});
  heap.run(25);
  heap.world.add_force(heap.bodies[5], {1, 1, 1});
  restore(heap.world, early);
  heap.world.add_impulse(heap.bodies[6], {0, 1, 0});
  heap.run(15);
  restore(heap.world, foreign);
  heap.run(15);
  recorder.finish();
  Player player(file.path());
  EXPECT_EQ(player.info().last_step, 65u) << "each step counts, though the world's counter went back";
  EXPECT_EQ(heap.world.stats().step, 40u);
  EXPECT_EQ(verified(player, heap.workers), "");
  EXPECT_EQ(first_difference(heap.world, player.world()), "");
  player.seek(36, heap.workers);
  EXPECT_EQ(player.world().stats().step, 11u);
}

TEST(Recording, FollowsAWorldThatMoves) {
  const TemporaryFile file;
  Heap heap;
  Recorder recorder(heap.world, file.path());
  heap.run(5);
  World moved = std::move(heap.world);
  for (int i = 0; i < 5; ++i) step(moved, kDt, heap.workers);
  heap.world = std::move(moved);
  heap.run(5);
  Recorder elsewhere = std::move(recorder);
  heap.run(5);
  EXPECT_TRUE(elsewhere.is_recording());
  EXPECT_FALSE(recorder.is_recording());
  elsewhere.finish();
  EXPECT_FALSE(elsewhere.is_recording());
  heap.run(5);
  EXPECT_EQ(elsewhere.steps(), 20u);
  Player player(file.path());
  EXPECT_EQ(player.info().last_step, 20u);
  EXPECT_EQ(verified(player, heap.workers), "");
}

TEST(Recording, EndsWithItsWorld) {
  const TemporaryFile destroyed, assigned;
  Workers workers(1);
  std::unique_ptr<Recorder> recorder;
  {
    Heap heap;
    recorder = std::make_unique<Recorder>(heap.world, destroyed.path());
    heap.run(7);
  }
  EXPECT_FALSE(recorder->is_recording());
  recorder->finish();
  Heap heap;
  Recorder second(heap.world, assigned.path());
  heap.run(3);
  heap.world = World();
  EXPECT_FALSE(second.is_recording());
  step(heap.world, kDt, workers);
  EXPECT_EQ(second.steps(), 3u);
  for (const TemporaryFile* file : {&destroyed, &assigned}) {
    Player player(file->path());
    EXPECT_TRUE(player.info().finished);
    EXPECT_EQ(player.info().last_step, file == &destroyed ? 7u : 3u);
    EXPECT_EQ(verified(player, workers), "");
  }
}

TEST(Recording, LeavesOutFailedAndReadingCalls) {
  const TemporaryFile file;
  Heap heap;
  heap.run(40);
  for (std::size_t i = 4; i < 10; ++i) heap.world.destroy_body(heap.bodies[i]);
  Recorder recorder(heap.world, file.path(), kOften);
  heap.run(1);
  // Definitions that would go into rows that were used before, until one is found wrong.
  std::vector<BodyDef> defs(4);
  defs[0].position = {7, 7, 7};
  defs[3].mass = -1.0f;
  std::vector<Geometry> shapes(4, ConvexHull{wedge(), {3.0f, 3.0f, 3.0f}});
  std::vector<BodyId> ids(4);
  EXPECT_NE(error_of_call([&] { heap.world.create_bodies(defs, ids); }), "");
  EXPECT_NE(error_of_call([&] { heap.world.create_bodies(defs, shapes, {}, {}, ids); }), "");
  defs[3].mass.reset();
  shapes[3] = ConvexHull{wedge(), {1e-9f, 1.0f, 1.0f}};
  EXPECT_NE(error_of_call([&] { heap.world.create_bodies(defs, shapes, {}, {}, ids); }), "");
  EXPECT_NE(error_of_call([&] { heap.world.set_pose(heap.bodies[5], {}); }), "");
  EXPECT_NE(error_of_call([&] { step(heap.world, -1.0f, heap.workers); }), "");
  const World copy = clone(heap.world);
  static_cast<void>(heap.world.is_awake(heap.bodies[11]));
  static_cast<void>(heap.world.mass_properties(heap.bodies[11]));
  heap.run(30);
  recorder.finish();
  Player player(file.path());
  EXPECT_EQ(player.info().calls, 0u);
  EXPECT_EQ(verified(player, heap.workers), "");
}

TEST(Recording, DoesNotDependOnReadsOfWhichBodiesWillWake) {
  const TemporaryFile file;
  Heap heap(0);
  heap.add({.position = {-3, 0.5f, 0}}, Box{});
  heap.add({.position = {-5, 0.5f, 0}}, Box{});
  heap.run(60);
  ASSERT_FALSE(heap.world.is_awake(heap.bodies[2]));
  Recorder recorder(heap.world, file.path(), kOften);
  // The floor is set to its current pose: bodies that lie on it must wake.
  heap.world.set_pose(heap.bodies[0], {{0, -1, 0}, {}});
  EXPECT_TRUE(heap.world.is_awake(heap.bodies[2]));
  EXPECT_TRUE(heap.world.is_awake(heap.bodies[3]));
  heap.world.destroy_body(heap.bodies[2]);
  heap.run(40);
  recorder.finish();
  Player player(file.path());
  EXPECT_EQ(player.info().calls, 2u);
  EXPECT_EQ(verified(player, heap.workers), "");
}

TEST(Recording, RefusesWhatCannotBeRecorded) {
  const TemporaryFile file, second;
  Heap heap;
  Recorder recorder(heap.world, file.path());
  EXPECT_EQ(error_of_call([&] { Recorder(heap.world, second.path()); }),
            "Recorder: the world is being recorded already");
  EXPECT_TRUE(recorder.is_recording());
  World moved = std::move(heap.world);
  EXPECT_EQ(error_of_call([&] { Recorder(heap.world, second.path()); }),
            "Recorder: the world has been moved from");
  World world;
  const auto refusal = [&](const RecorderOptions& options) {
    return error_of_call([&] { Recorder(world, second.path(), options); });
  };
  EXPECT_NE(refusal({.keyframe_spacing = 0}).find("keyframe_spacing is 0"), std::string::npos);
  EXPECT_NE(refusal({.compression_level = 20}).find("compression_level is 20"), std::string::npos);
  EXPECT_NE(refusal({.flush_interval = std::numeric_limits<float>::quiet_NaN()}).find("flush_interval"),
            std::string::npos);
  const std::string nowhere = second.path() + "/nothing/here";
  EXPECT_NE(error_of_call([&] { Recorder(world, nowhere); }).find(nowhere), std::string::npos);
  EXPECT_NE(error_of_call([&] { Player player(nowhere); }).find(nowhere), std::string::npos);
  Recorder works(world, second.path());
}

TEST(Recording, WritesEachHullOnce) {
  const TemporaryFile file;
  Heap heap(0);
  const Hull hull = wedge();
  Recorder recorder(heap.world, file.path(), {.keyframe_spacing = 5});
  for (int i = 0; i < 20; ++i) {
    heap.add({.position = {0, 2.0f + static_cast<float>(i), 0}}, ConvexHull{wedge()});
    heap.add({.position = {3, 2.0f + static_cast<float>(i), 0}}, ConvexHull{hull, {1.0f, 1.5f, 1.0f}});
    heap.run(1);
  }
  recorder.finish();
  Player player(file.path());
  EXPECT_EQ(player.info().hulls, 2u) << "the hull, and the scaled one";
  EXPECT_EQ(verified(player, heap.workers), "");
}

TEST(Recording, HoldsCylindersConesAndRoundings) {
  const TemporaryFile file;
  Heap heap(0);
  Recorder recorder(heap.world, file.path(), {.keyframe_spacing = 3});
  const ConvexHull rock{wedge(), {1.0f, 1.5f, 1.0f}, 0.25f};
  const std::vector<Geometry> given{Cylinder{0.5f, 0.25f}, Cone{0.75f, 0.5f}, Box{{0.5f, 1, 1}, 0.125f}, rock,
                                    ConvexHull{wedge(), {1.0f, 1.5f, 1.0f}}};
  std::vector<ShapeId> shapes;
  for (const Geometry& geometry : given) {
    const BodyId body =
        heap.world.create_body({.position = {4.0f * static_cast<float>(shapes.size()), 9, 0}});
    shapes.push_back(heap.world.add_shape(body, Sphere{}));
    heap.run(2);
    heap.world.set_geometry(shapes.back(), geometry);
    heap.run(2);
  }
  recorder.finish();
  Player player(file.path());
  EXPECT_EQ(player.info().hulls, 2u) << "the hull, and the scaled one; roundings have none of their own";
  EXPECT_EQ(verified(player, heap.workers), "");
  EXPECT_EQ(first_difference(heap.world, player.world()), "");
  const Shapes& played = internals(player.world()).shapes;
  const ShapeType types[] = {ShapeType::cylinder, ShapeType::cone, ShapeType::rounded_box,
                             ShapeType::rounded_hull, ShapeType::hull};
  for (std::size_t i = 0; i < given.size(); ++i) EXPECT_EQ(played.type[shapes[i].index], types[i]);
}

TEST(Recording, WritesEachMeshOnce) {
  const TemporaryFile file;
  Heap heap(0);
  const test_solids::TestMesh ring = test_solids::torus_mesh(5, 2, 9, 6),
                              block = test_solids::box_mesh({1, 2, 3});
  const TriangleMesh before(block.vertices, block.triangles);
  heap.add({.type = BodyType::fixed, .position = {0, -100, 0}}, before);
  Recorder recorder(heap.world, file.path(), {.keyframe_spacing = 5});
  for (int i = 0; i < 20; ++i) {
    const Vec3 place{0, -200.0f - 20.0f * static_cast<float>(i), 0};
    heap.add({.type = BodyType::fixed, .position = place}, TriangleMesh(ring.vertices, ring.triangles));
    heap.add({.type = BodyType::fixed, .position = place}, before);
    heap.run(1);
  }
  Snapshot snapshot;
  save(heap.world, snapshot);
  heap.run(1);
  restore(heap.world, snapshot);
  heap.run(1);
  recorder.finish();
  Player player(file.path());
  EXPECT_EQ(player.info().meshes, 2u);
  EXPECT_EQ(verified(player, heap.workers), "");
  player.seek(player.info().last_step, heap.workers);
  EXPECT_EQ(first_state_difference(player.world(), heap.world), "");
}

TEST(Recording, TakesCallsOfAnySize) {
  const TemporaryFile file;
  World world;
  Workers workers(1);
  Recorder recorder(world, file.path());
  constexpr std::size_t kMany = 200'000;
  std::vector<BodyDef> defs(kMany);
  for (std::size_t i = 0; i < kMany; ++i) {
    defs[i] = {.type = BodyType::fixed, .position = {static_cast<float>(i), 0, 0}, .user_data = i * i};
  }
  std::vector<BodyId> ids(kMany);
  world.create_bodies(defs, ids);
  step(world, kDt, workers);
  world.destroy_bodies(ids);
  step(world, kDt, workers);
  recorder.finish();
  Player player(file.path());
  EXPECT_EQ(player.info().calls, 2u);
  ASSERT_TRUE(player.step(workers));
  EXPECT_EQ(player.world().body_count(), kMany);
  ASSERT_TRUE(player.step(workers));
  EXPECT_EQ(player.world().hash(), world.hash());
}

TEST(Recording, HoldsGivenPosesEvenIfTheyDoNotChangeTheWorld) {
  const TemporaryFile file;
  Heap heap;
  heap.world.set_mass_properties(
      heap.bodies[4],
      {.mass = 2.0f, .center = {0.1f, 0.07f, -0.03f}, .inertia = {0.3f, 0.4f, 0.5f, 0.0f, 0.0f, 0.0f}});
  Recorder recorder(heap.world, file.path());
  for (int i = 0; i < 30; ++i) {
    for (const BodyId body : heap.bodies) heap.world.set_pose(body, heap.world.poses()[body.index]);
    heap.world.set_local_pose(heap.shapes[4], heap.world.poses()[heap.bodies[4].index]);
    heap.run(1);
  }
  recorder.finish();
  Player player(file.path());
  EXPECT_EQ(verified(player, heap.workers), "");
}

TEST(Recording, StaysReadableHoweverWellItCompresses) {
  const TemporaryFile file;
  World world;
  Workers workers(1);
  Recorder recorder(world, file.path());
  const std::vector<BodyDef> defs(100'000);  // all the same
  std::vector<BodyId> ids(defs.size());
  world.create_bodies(defs, ids);
  step(world, kDt, workers);
  recorder.finish();
  Player player(file.path());
  EXPECT_LT(player.info().file_bytes, player.info().raw_bytes / 20);
  EXPECT_EQ(verified(player, workers), "");
}

// A file that accepts no data while no process reads it.
TEST(Recording, WaitsForAFileThatIsTooSlow) {
  const TemporaryFile pipe;
  ASSERT_EQ(mkfifo(pipe.path().c_str(), 0600), 0);
  std::atomic<bool> reading = true;
  std::atomic<int> calls = 0;
  Bytes bytes;
  std::thread reader([&] {
    const int from = open(pipe.path().c_str(), O_RDONLY);
    std::byte block[1 << 16];
    for (;;) {
      while (!reading) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      const ssize_t count = read(from, block, sizeof block);
      if (count <= 0) break;
      bytes.insert(bytes.end(), block, block + count);
    }
    close(from);
  });
  Workers workers(1);
  constexpr std::size_t kMany = 20'000;
  std::vector<BodyDef> defs(kMany);
  std::uint64_t number = 1;
  for (BodyDef& def : defs) def.user_data = number = number * 6364136223846793005u + 1442695040888963407u;
  constexpr int kCalls = 60;  // of 1.6 MB
  std::uint64_t last_hash = 0;
  {
    World world;
    Recorder recorder(world, pipe.path());
    reading = false;
    std::thread caller([&] {
      std::vector<BodyId> ids(kMany);
      for (int i = 0; i < kCalls; ++i) {
        world.create_bodies(defs, ids);
        world.destroy_bodies(ids);
        ++calls;
      }
      step(world, kDt, workers);
    });
    for (int before = -1; before != calls;) {
      before = calls;
      std::this_thread::sleep_for(std::chrono::milliseconds(500));
    }
    EXPECT_GT(calls, 10);
    EXPECT_LT(calls, kCalls) << "not all fit into the 64 MiB that may be pending";
    reading = true;
    caller.join();
    recorder.finish();
    last_hash = world.hash();
  }
  reader.join();
  Player player(bytes);
  EXPECT_EQ(player.info().calls, 2u * kCalls);
  ASSERT_TRUE(player.step(workers));
  EXPECT_EQ(player.world().hash(), last_hash);
}

TEST(Recording, OfWorldsThatAreSteppedTogetherIsOneEach) {
  constexpr std::size_t kWorlds = 6;
  std::vector<std::unique_ptr<Heap>> heaps;
  std::vector<std::unique_ptr<TemporaryFile>> files;
  std::vector<Recorder> recorders;
  std::vector<World*> worlds;
  for (std::size_t i = 0; i < kWorlds; ++i) {
    heaps.push_back(std::make_unique<Heap>(static_cast<int>(4 + i)));
    worlds.push_back(&heaps.back()->world);
    files.push_back(std::make_unique<TemporaryFile>());
    if (i > 0) recorders.emplace_back(*worlds.back(), files.back()->path(), kOften);
  }
  Workers workers(3);
  for (int i = 0; i < 50; ++i) step(worlds, kDt, workers);
  for (Recorder& recorder : recorders) recorder.finish();
  for (std::size_t i = 1; i < kWorlds; ++i) {
    Player player(files[i]->path());
    EXPECT_EQ(verified(player, workers), "");
    EXPECT_EQ(first_difference(*worlds[i], player.world()), "");
  }
}

}  // namespace
}  // namespace scree::test
