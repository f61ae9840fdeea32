// Writes the binary files of the corpus, small worlds that reach every branch of the formats. Run it again
// after a change of format: scree_make_corpus FOLDER, with tests/fuzz/corpus for the folder. Scene files are
// text, and edited by hand.
#include <scree/distributed_world.h>
#include <scree/recording.h>
#include <scree/scree.h>
#include <tests/fuzz/laws.h>
#include <tools/scenes/random.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace scree::fuzz {
namespace {

constexpr float kDt = 1.0f / 60.0f;

void run(World& world, int steps) {
  for (int i = 0; i < steps; ++i) step(world, kDt, narrow_workers());
}

void add_ground(World& world) {
  const BodyId ground = world.create_body({.type = BodyType::fixed, .position = {0.0f, -1.0f, 0.0f}});
  world.add_shape(ground, Box{{5.0f, 1.0f, 5.0f}});
}

BodyId add(World& world, Vec3 position, const Geometry& geometry, const ShapeOptions& options = {}) {
  const BodyId body = world.create_body({.position = position});
  world.add_shape(body, geometry, {}, options);
  return body;
}

Hull wedge() {
  const Vec3 points[] = {{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f},
                         {0.0f, 0.0f, 1.0f}, {1.0f, 0.0f, 1.0f}, {0.0f, 1.0f, 1.0f}};
  return Hull(points);
}

Hull tetrahedron() {
  const Vec3 points[] = {
      {1.0f, 1.0f, 1.0f}, {1.0f, -1.0f, -1.0f}, {-1.0f, 1.0f, -1.0f}, {-1.0f, -1.0f, 1.0f}};
  return Hull(points);
}

World falling_ball() {
  World world;
  add(world, {0.0f, 5.0f, 0.0f}, Sphere{0.5f});
  run(world, 2);
  return world;
}

World box_on_ground() {
  World world;
  add_ground(world);
  add(world, {0.0f, 0.5f, 0.0f}, Box{});
  run(world, 10);
  return world;
}

World sleeping_pair() {
  World world(WorldSettings{.sleep_time = 0.05f});
  add_ground(world);
  add(world, {0.0f, 0.5f, 0.0f}, Box{});
  add(world, {0.0f, 1.5f, 0.0f}, Box{});
  run(world, 60);
  return world;
}

World rounds() {
  World world;
  add_ground(world);
  add(world, {0.0f, 0.3f, 0.0f}, Capsule{0.3f, 0.2f}, {.local_pose = {{0.1f, 0.0f, 0.0f}, {}}});
  add(world, {0.2f, 0.8f, 0.1f}, Sphere{0.3f});
  run(world, 15);
  return world;
}

World hulls() {
  World world;
  add_ground(world);
  const Hull solid = wedge();
  add(world, {0.0f, 0.1f, 0.0f}, ConvexHull{solid});
  add(world, {0.2f, 1.2f, 0.0f}, ConvexHull{solid, {0.5f, 1.0f, 0.5f}});
  add(world, {2.0f, 1.0f, 0.0f}, ConvexHull{tetrahedron(), {0.4f, 0.4f, 0.4f}});
  run(world, 20);
  return world;
}

// Two triangles, one of them with a material of its own, and a box of meshes that two shapes share.
TriangleMesh slope() {
  const std::vector<Vec3> vertices{
      {-2.0f, 0.0f, -2.0f}, {-2.0f, 0.2f, 2.0f}, {2.0f, 0.0f, -2.0f}, {2.0f, 0.3f, 2.0f}};
  const std::vector<MeshTriangle> triangles{{0, 1, 2}, {1, 3, 2}};
  const std::uint8_t surface[2] = {0, 255};
  const Material ice{.friction = 0.02f};
  return TriangleMesh(vertices, triangles, {surface, std::span(&ice, 1)});
}
TriangleMesh pyramid() {
  const std::vector<Vec3> vertices{
      {-1.0f, 0.0f, -1.0f}, {1.0f, 0.0f, -1.0f}, {1.0f, 0.0f, 1.0f}, {-1.0f, 0.0f, 1.0f}, {0.0f, 1.0f, 0.0f}};
  const std::vector<MeshTriangle> triangles{{0, 4, 1}, {1, 4, 2}, {2, 4, 3}, {3, 4, 0}, {0, 1, 2}, {0, 2, 3}};
  return TriangleMesh(vertices, triangles);
}

World meshes() {
  World world;
  const BodyId ground = world.create_body({.type = BodyType::fixed});
  world.add_shape(ground, slope());
  world.add_shape(ground, pyramid(), {}, {.local_pose = {{5.0f, 0.0f, 0.0f}, {}}});
  world.add_shape(ground, pyramid(), {}, {.local_pose = {{-5.0f, 0.0f, 0.0f}, {}}});
  const BodyId cart = world.create_body({.type = BodyType::kinematic, .linear_velocity = {1.0f, 0.0f, 0.0f}});
  const ShapeId gone = world.add_shape(cart, slope(), {}, {.local_pose = {{0.0f, 9.0f, 0.0f}, {}}});
  add(world, {0.0f, 0.7f, 0.0f}, Box{});
  run(world, 5);
  world.set_geometry(gone, Sphere{});
  return world;
}

// So far apart that they meet nothing.
World round_shapes() {
  World world;
  const ConvexHull rock{tetrahedron(), {0.5f, 1.0f, 0.5f}, 0.25f};
  for (const Geometry& geometry : {Geometry{Cylinder{0.5f, 0.25f}}, Geometry{Cone{0.5f, 0.25f}},
                                   Geometry{Box{{0.5f, 0.25f, 0.5f}, 0.125f}}, Geometry{rock}}) {
    add(world, {4.0f * static_cast<float>(world.body_count()), 1.0f, 0.0f}, geometry);
  }
  const BodyId ground = world.create_body({.type = BodyType::fixed, .position = {0.0f, -9.0f, 0.0f}});
  world.add_shape(ground, Cylinder{1.0f, 50.0f});
  world.add_shape(ground, ConvexHull{tetrahedron(), {0.5f, 1.0f, 0.5f}}, {}, {.sensor = true});
  run(world, 3);
  return world;
}

// With answers for hooks that are still to be taken.
World half_space() {
  World world;
  const BodyId ground = world.create_body({.type = BodyType::fixed, .rotation = {0.0f, 0.0f, 0.6f, 0.8f}});
  const ShapeId plane = world.add_shape(ground, HalfSpace{}, {}, {.contact_hooks = ContactHooks::all});
  const BodyId ball = add(world, {-1.0f, 0.6f, 0.0f}, Sphere{});
  ShapeId shape;
  world.shapes_of(ball, {&shape, 1});
  run(world, 3);
  const ContactAnswer answers[] = {{plane, shape, -1, {}}, {plane, shape, 0, {.friction = 0.1f}}};
  world.answer_contact_hooks(answers);
  return world;
}

World kinematic_and_materials() {
  World world;
  const BodyId belt =
      world.create_body({.type = BodyType::kinematic, .linear_velocity = {0.5f, 0.0f, 0.0f}, .user_data = 7});
  world.add_shape(
      belt, Box{{2.0f, 0.2f, 2.0f}},
      {.friction = 0.9f, .surface_velocity = {1.0f, 0.0f, 0.0f}, .friction_mix = MixRule::maximum});
  const BodyId ball =
      world.create_body({.position = {0.0f, 0.6f, 0.0f}, .locks = AxisLocks::translation_z, .mass = 3.0f});
  world.add_shape(ball, Sphere{0.4f},
                  {.restitution = 0.5f, .rolling_resistance = 0.05f, .patch_radius = 0.1f},
                  {.filter = {2u, 3u, -1}, .user_data = 9});
  run(world, 10);
  world.set_kinematic_target(belt, {{0.5f, 0.0f, 0.0f}, {}}, kDt);
  return world;
}

// Free slots, handles of the second generation, a shape added after the last step, forces not yet applied.
World between_steps() {
  World world(WorldSettings{.contact_events = ContactEvents::all, .contact_forces = true});
  add_ground(world);
  std::vector<BodyId> bodies;
  for (int i = 0; i < 5; ++i) {
    bodies.push_back(add(world, {0.7f * static_cast<float>(i) - 1.5f, 0.45f, 0.0f}, Box{{0.4f, 0.5f, 0.4f}}));
  }
  run(world, 12);
  world.destroy_body(bodies[1]);
  world.destroy_body(bodies[3]);
  add(world, {0.0f, 2.0f, 0.0f}, Sphere{});
  world.add_force(bodies[0], {1.0f, 2.0f, 3.0f});
  world.add_shape(bodies[2], Sphere{0.2f}, {}, {.local_pose = {{0.0f, 0.5f, 0.0f}, {}}});
  world.set_pose(bodies[4], {{1.0f, 3.0f, 0.0f}, {}});
  world.set_mass_properties(bodies[2], {.mass = 2.0f});
  return world;
}

// One of each kind between a body and the next one.
std::vector<Joint> all_joints() {
  const JointAxis driven{.lower = -0.5f, .upper = 0.5f, .drive = Drive::spring, .max_force = 50.0f};
  const RotationDrive drive{.drive = Drive::motor, .velocity = {0.0f, 1.0f, 0.0f}, .max_torque = 5.0f};
  SixDegreeJoint held;
  held.offset[1] = driven;
  held.angle[2] = {.lower = 0.0f, .upper = 0.0f};
  return {BallJoint{},
          BallJoint{.cone_limit = 0.5f, .drive = drive},
          HingeJoint{driven},
          SliderJoint{driven},
          DistanceJoint{{.lower = 0.5f, .upper = 2.0f}},
          WeldJoint{.angular_hertz = 5.0f},
          held,
          WheelJoint{.spin = {.drive = Drive::motor, .speed = 3.0f}},
          UniversalJoint{.second = driven},
          PlanarJoint{.offset_z = driven},
          GearJoint{-2.0f},
          RackAndPinionJoint{0.5f},
          PulleyJoint{.point_a = {0.0f, 5.0f, 0.0f}, .point_b = {2.0f, 5.0f, 0.0f}, .length = 8.0f},
          MotorJoint{.rotation = drive, .max_force = 30.0f}};
}

// A free slot, a slot of the second generation, joints that went with their body, and one with the world.
World jointed() {
  World world;
  add_ground(world);
  std::vector<BodyId> bodies;
  std::vector<JointId> joints;
  for (const Joint& joint : all_joints()) {
    const float x = 1.5f * static_cast<float>(bodies.size());
    bodies.push_back(add(world, {x, 2.0f, 0.0f}, Box{{0.4f, 0.2f, 0.3f}}));
    const BodyId before = bodies.size() > 1 ? bodies[bodies.size() - 2] : kWorld;
    joints.push_back(world.create_joint({.body_a = before,
                                         .body_b = bodies.back(),
                                         .frame_a = {{before == kWorld ? x - 0.7f : 0.8f, 0.0f, 0.0f}, {}},
                                         .frame_b = {{-0.7f, 0.0f, 0.0f}, {}},
                                         .break_force = 1e6f,
                                         .event_torque = 10.0f},
                                        joint));
  }
  world.create_joint({.body_a = kWorld, .body_b = bodies[3]},
                     MouseJoint{.target = {4.0f, 3.0f, 0.0f}, .max_force = 100.0f});
  const JointId stated = world.create_joint({.body_a = kWorld, .body_b = bodies[1]},
                                            UserJoint{{RowKind::limit, RowKind::spring}});
  const UserRow stated_rows[] = {{.jacobian = {.linear_b = {0.0f, 1.0f, 0.0f}}, .target = {.error = 1.0f}},
                                 {.jacobian = {.angular_b = {0.0f, 1.0f, 0.0f}}, .bounds = {-5.0f, 5.0f}}};
  world.set_user_rows(stated, stated_rows);
  run(world, 5);
  world.destroy_joint(joints[2]);
  world.destroy_joint(joints[4]);
  world.create_joint({.body_a = bodies[0], .body_b = bodies[2], .enabled = false}, HingeJoint{});
  world.destroy_body(bodies[7]);
  return world;
}

// As many bodies as fill more than one block of a column.
World more_than_a_block() {
  World world(WorldSettings{.sleeping = false});
  add_ground(world);
  for (int i = 0; i < 70; ++i) {
    const auto x = static_cast<float>(i % 9), z = static_cast<float>(i / 9);
    add(world, {x - 4.0f, 0.3f, z - 4.0f}, Sphere{0.3f});
  }
  run(world, 3);
  return world;
}

// --- recordings: calls on a world while it is recorded ---

void only_steps(World& world) {
  add_ground(world);
  add(world, {0.0f, 0.6f, 0.0f}, Box{});
  run(world, 4);
}

void calls_of_bodies(World& world) {
  const BodyDef defs[] = {{.position = {1.0f, 2.0f, 0.0f}}, {.type = BodyType::kinematic, .user_data = 5}};
  const Geometry geometries[] = {Sphere{0.3f}, Box{}};
  BodyId bare[2], balls[2];
  world.create_bodies(defs, bare);
  world.create_bodies(defs, geometries, {.restitution = 0.5f}, {}, balls);
  run(world, 1);
  world.set_linear_velocity(balls[0], {1.0f, 0.0f, 0.0f});
  world.set_angular_velocity(balls[0], {0.0f, 1.0f, 0.0f});
  world.set_kinematic_target(balls[1], {{0.1f, 0.0f, 0.0f}, {}}, kDt);
  world.add_force(balls[0], {1.0f, 2.0f, 3.0f});
  world.add_force_at(balls[0], {1.0f, 2.0f, 3.0f}, {1.0f, 2.0f, 0.5f});
  world.add_torque(balls[0], {0.1f, 0.2f, 0.3f});
  world.add_impulse(balls[0], {0.1f, 0.2f, 0.3f});
  world.add_impulse_at(balls[0], {0.1f, 0.2f, 0.3f}, {1.0f, 2.0f, 0.5f});
  world.add_angular_impulse(balls[0], {0.1f, 0.2f, 0.3f});
  run(world, 1);
  world.set_mass_properties(balls[0], {.mass = 2.0f});
  world.set_linear_damping(balls[0], 0.1f);
  world.set_angular_damping(balls[0], 0.2f);
  world.set_gravity_factor(balls[0], 0.5f);
  world.set_locks(balls[0], AxisLocks::rotation_x);
  world.set_can_sleep(balls[0], false);
  world.set_user_data(balls[0], 77);
  world.set_body_type(bare[0], BodyType::fixed);
  world.set_pose(balls[0], {{0.0f, 3.0f, 0.0f}, {}});
  world.wake(balls[0]);
  run(world, 1);
  world.reset_mass(balls[0]);
  world.destroy_body(bare[1]);
  world.destroy_bodies(balls);
  run(world, 1);
}

void calls_of_shapes(World& world) {
  const BodyId body = add(world, {0.0f, 1.0f, 0.0f}, Capsule{});
  const ShapeId hull = world.add_shape(body, ConvexHull{wedge(), {0.5f, 1.0f, 1.0f}});
  run(world, 1);
  world.set_geometry(hull, ConvexHull{tetrahedron()});
  world.set_material(hull, {.friction = 0.1f, .surface_velocity = {1.0f, 0.0f, 0.0f}});
  world.set_filter(hull, {2u, 3u, 1});
  world.set_contact_events(hull, ContactEvents::all);
  world.set_local_pose(hull, {{0.1f, 0.0f, 0.0f}, {}});
  world.set_user_data(hull, 8);
  const BodyId ground = world.create_body({.type = BodyType::fixed, .position = {0.0f, -9.0f, 0.0f}});
  const ShapeId land = world.add_shape(ground, slope());
  world.set_contact_hooks(hull, ContactHooks::all);
  const ContactAnswer answers[] = {{hull, land, -1, {}}, {hull, land, 1, {.friction = 0.2f}}};
  world.answer_contact_hooks(answers);
  world.add_shape(ground, pyramid());
  run(world, 1);
  world.set_geometry(land, pyramid());
  world.set_geometry(hull, ConvexHull{tetrahedron(), {1.0f, 1.0f, 1.0f}, 0.25f});
  world.set_geometry(hull, Cylinder{});
  world.set_geometry(hull, Cone{});
  world.set_geometry(hull, Box{{0.5f, 0.5f, 0.5f}, 0.125f});
  world.destroy_shape(hull);
  WorldSettings settings;
  settings.substeps = 2;
  world.set_settings(settings);
  run(world, 1);
}

void calls_of_joints(World& world) {
  const BodyId a = add(world, {0.0f, 1.0f, 0.0f}, Box{}), b = add(world, {1.5f, 1.0f, 0.0f}, Box{});
  const std::vector<Joint> joints = all_joints();
  std::vector<JointDef> defs(joints.size());
  for (JointDef& def : defs) def = {.body_a = a, .body_b = b, .frame_a = {{0.75f, 0.0f, 0.0f}, {}}};
  std::vector<JointId> ids(joints.size());
  world.create_joints(defs, joints, ids);
  const JointId mouse =
      world.create_joint({.body_a = kWorld, .body_b = b}, MouseJoint{.target = {1.0f, 2.0f, 0.0f}});
  const JointId stated = world.create_joint({.body_a = kWorld, .body_b = b}, UserJoint{});
  UserRow row{.jacobian = {.linear_b = {0.0f, 1.0f, 0.0f}}};
  world.set_user_rows(stated, {&row, 1});
  row.target.error = std::numeric_limits<float>::infinity();  // freezes it
  world.refresh_user_rows({&stated, 1}, {&row, 1});
  run(world, 1);
  for (std::size_t i = 1; i < ids.size(); ++i) world.set_joint_enabled(ids[i], false);
  world.set_joint(mouse, MouseJoint{.target = {1.0f, 3.0f, 0.0f}, .max_force = 20.0f});
  world.set_joint_frames(ids[0], {{0.7f, 0.0f, 0.0f}, {}}, {{-0.7f, 0.0f, 0.0f}, {}});
  world.set_joint_stiffness(ids[0], 4.0f, 0.5f);
  world.set_joint_strength(ids[0], 1000.0f, 50.0f);
  world.set_joint_event_thresholds(ids[0], 100.0f, 5.0f);
  world.set_collide_connected(ids[0], true);
  world.set_user_data(ids[0], 6);
  run(world, 1);
  world.destroy_joint(ids[1]);
  world.destroy_body(a);
  run(world, 1);
}

void back_in_time(World& world) {
  add_ground(world);
  add(world, {0.0f, 0.7f, 0.0f}, ConvexHull{tetrahedron(), {0.5f, 0.5f, 0.5f}});
  run(world, 2);
  Snapshot snapshot;
  save(world, snapshot);
  add(world, {0.0f, 2.0f, 0.0f}, Sphere{});
  run(world, 2);
  restore(world, snapshot);
  run(world, 2);
}

struct Seed {
  const char* name;
  std::function<World()> make;
};
const std::vector<Seed>& seeds() {
  static const std::vector<Seed> all = {{"empty", [] { return World(); }},
                                        {"falling_ball", falling_ball},
                                        {"box_on_ground", box_on_ground},
                                        {"sleeping_pair", sleeping_pair},
                                        {"rounds", rounds},
                                        {"hulls", hulls},
                                        {"meshes", meshes},
                                        {"half_space", half_space},
                                        {"round_shapes", round_shapes},
                                        {"kinematic_and_materials", kinematic_and_materials},
                                        {"between_steps", between_steps},
                                        {"joints", jointed},
                                        {"more_than_a_block", more_than_a_block}};
  return all;
}

struct RecordedSeed {
  const char* name;
  int keyframe_spacing;
  bool finished;
  void (*work)(World& world);
};
constexpr RecordedSeed kRecordings[] = {
    {"steps", 1000, true, only_steps},       {"keyframes", 1, true, only_steps},
    {"unfinished", 2, false, only_steps},    {"bodies", 1000, true, calls_of_bodies},
    {"shapes", 1000, true, calls_of_shapes}, {"restored", 3, true, back_in_time},
    {"joints", 1000, true, calls_of_joints}};

void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw Error(path.string() + ": cannot be written");
  std::printf("%s: %zu bytes\n", path.c_str(), bytes.size());
}

// Two heaps that touch, of which each rank has one.
void record_on_ranks(const std::string& file) {
  LocalRanks ranks(2);
  const auto run_rank = [&](int rank) {
    World whole;
    whole.add_shape(whole.create_body({.type = BodyType::fixed, .position = {0, -1, 0}}), Box{{9, 1, 9}});
    for (int i = 0; i < 6; ++i) {
      const float side = i % 2 == 0 ? -0.45f : 0.45f;
      const BodyId body = whole.create_body({.position = {side, 0.5f + static_cast<float>(i / 2), 0}});
      whole.add_shape(body, Box{{0.5f, 0.5f, 0.5f}});
    }
    DistributedWorld world(std::move(whole), ranks.at(rank));
    Workers workers(1);
    world.record(file, workers, {.keyframe_spacing = 2});
    for (int i = 0; i < 4; ++i) world.step(1.0f / 60.0f, workers);
    world.finish_recording(workers);
  };
  std::thread other(run_rank, 1);
  run_rank(0);
  other.join();
}

void make_corpus(const std::filesystem::path& folder) {
  for (const Seed& seed : seeds()) {
    const World world = seed.make();
    write_file(folder / "snapshot" / (std::string(seed.name) + ".snapshot"), bytes_of(world));
  }
  std::filesystem::create_directories(folder / "recording");
  for (const RecordedSeed& seed : kRecordings) {
    const std::filesystem::path file = folder / "recording" / (std::string(seed.name) + ".recording");
    World world;
    Recorder recorder(world, file.string(), {.keyframe_spacing = seed.keyframe_spacing});
    seed.work(world);
    recorder.finish();
    // An unfinished recording lacks the end, or more.
    constexpr std::size_t kCut = 70;
    if (!seed.finished) std::filesystem::resize_file(file, std::filesystem::file_size(file) - kCut);
    std::printf("%s: %zu bytes\n", file.c_str(), static_cast<std::size_t>(std::filesystem::file_size(file)));
  }
  record_on_ranks((folder / "recording" / "ranks.recording").string());
}

}  // namespace
}  // namespace scree::fuzz

int main(int count, char** arguments) {
  try {
    if (count != 2) throw scree::Error("usage: scree_make_corpus FOLDER");
    scree::fuzz::make_corpus(arguments[1]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "scree_make_corpus: %s\n", error.what());
    return 1;
  }
}
