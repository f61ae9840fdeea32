// Laws of reading: const functions change nothing, so any number of threads may call them at once.
#include <core/state/recording_format/value_bytes.h>
#include <core/world/state_table.h>
#include <scree/scree.h>
#include <tests/determinism/many_threads.h>

#include <bit>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace scree {

// Mixes numbers into one, depending on their order. write_value takes it as a writer.
class ReadingDigest {
 public:
  template <class Number>
  void put(Number number) {
    if constexpr (std::is_same_v<Number, float>) {
      add(std::bit_cast<std::uint32_t>(number));
    } else if constexpr (std::is_same_v<Number, double>) {
      add(std::bit_cast<std::uint64_t>(number));
    } else {
      add(static_cast<std::uint64_t>(number));
    }
  }
  void put_hull(const Hull& hull) { put(hull.vertices().size()); }
  void put_mesh(const TriangleMesh& mesh) { put(mesh.triangle_count()); }
  std::uint64_t value() const { return value_; }

 private:
  void add(std::uint64_t bits) { value_ = (value_ ^ bits) * 0x9e3779b97f4a7c15u + (value_ >> 29); }
  std::uint64_t value_ = 1;
};

namespace determinism {
namespace {

constexpr float kReadStep = 1.0f / 60.0f;  // s

struct Names {
  std::vector<BodyId> bodies;
  std::vector<ShapeId> shapes;
  std::vector<JointId> joints;
};

// Calls every const function of a world and mixes the results.
class Reader {
 public:
  Reader(const World& world, const Names& names) : world_(world), names_(names) {
    for (const BodyId body : names_.bodies) read(body);
    for (const ShapeId shape : names_.shapes) read(shape);
    for (const JointId joint : names_.joints) read(joint);
    read_world();
    read_events();
    ask_queries();
  }
  std::uint64_t value() const { return digest_.value(); }
  const std::set<std::string>& called() const { return called_; }

 private:
  template <class Value>
  void say(const char* call, const Value& value) {
    called_.insert(call);
    write_value(digest_, value);
  }
  void say(const char* call, const ContactForces& forces) {
    say(call, forces.shape_a);
    say(call, forces.body_b);
    say(call, impulse_on_b(forces));
    say(call, forces.color);
    for (const ContactForcePoint& point : forces.points) say(call, point.normal_impulse);
  }
  void say(const char* call, const ContactEvent& event) {
    say(call, event.shape_a);
    say(call, event.body_b);
    say(call, event.normal_impulse);
  }
  void say(const char* call, const ContactEnd& end) { say(call, end.shape_a); }
  void say(const char* call, const SensorEvent& event) {
    say(call, event.sensor);
    say(call, event.visitor_body);
  }
  void say(const char* call, const JointEvent& event) {
    say(call, event.joint);
    say(call, event.force);
  }
  void say(const char* call, const Velocity& velocity) { say(call, velocity.linear); }
  template <class Rows>
  void say_all(const char* call, const Rows& rows) {
    say(call, rows.size());
    for (const auto& row : rows) say(call, row);
  }

  void read(BodyId body) {
    say("is_alive", world_.is_alive(body));
    say("body_at", world_.body_at(body.index));
    if (!world_.is_alive(body)) return;
    say("body_type", world_.body_type(body));
    say("pose", world_.pose(body));
    say("linear_velocity", world_.linear_velocity(body));
    say("angular_velocity", world_.angular_velocity(body));
    say("velocity_at", world_.velocity_at(body, {1, 2, 3}));
    say("center_of_mass", world_.center_of_mass(body));
    say("mass_properties", world_.mass_properties(body));
    say("linear_damping", world_.linear_damping(body));
    say("angular_damping", world_.angular_damping(body));
    say("gravity_factor", world_.gravity_factor(body));
    say("locks", world_.locks(body));
    say("can_sleep", world_.can_sleep(body));
    say("full_sweep", world_.full_sweep(body));
    say("is_awake", world_.is_awake(body));
    say("is_quarantined", world_.is_quarantined(body));
    say("user_data", world_.user_data(body));
    std::vector<ShapeId> shapes(world_.shapes_of(body, {}));
    world_.shapes_of(body, shapes);
    say_all("shapes_of", shapes);
    std::vector<JointId> joints(world_.joints_of(body, {}));
    world_.joints_of(body, joints);
    say_all("joints_of", joints);
    std::vector<ContactForces> forces(world_.contact_forces_of(body, {}));
    world_.contact_forces_of(body, forces);
    say_all("contact_forces_of", forces);
  }
  void read(ShapeId shape) {
    say("is_alive", world_.is_alive(shape));
    if (!world_.is_alive(shape)) return;
    say("body_of", world_.body_of(shape));
    say("geometry", world_.geometry(shape));
    say("material", world_.material(shape));
    say("filter", world_.filter(shape));
    say("contact_events", world_.contact_events(shape));
    say("contact_hooks", world_.contact_hooks(shape));
    say("is_sensor", world_.is_sensor(shape));
    if (world_.is_sensor(shape)) {
      std::vector<ShapeId> visitors(world_.visitors_of(shape, {}));
      world_.visitors_of(shape, visitors);
      say_all("visitors_of", visitors);
    }
    say("local_pose", world_.local_pose(shape));
    say("user_data", world_.user_data(shape));
    std::vector<ContactForces> forces(world_.contact_forces_of(shape, {}));
    world_.contact_forces_of(shape, forces);
    say_all("contact_forces_of", forces);
  }
  void read(JointId joint) {
    say("is_alive", world_.is_alive(joint));
    if (!world_.is_alive(joint)) return;
    say("joint_type", world_.joint_type(joint));
    say("joint", world_.joint(joint));
    say("joint_def", world_.joint_def(joint));
    say("is_enabled", world_.is_enabled(joint));
    say("collides_connected", world_.collides_connected(joint));
    say("user_data", world_.user_data(joint));
    say("joint_pose", world_.joint_pose(joint));
    const JointReaction reaction = world_.joint_reaction(joint);
    say("joint_reaction", reaction.force);
    say("is_frozen", world_.is_frozen(joint));
    if (world_.joint_type(joint) != JointType::user) return;
    UserRow rows[kMaxUserRows];
    say_all("user_rows", std::span(rows).first(world_.user_rows(joint, rows)));
  }
  void read_world() {
    say("body_count", world_.body_count());
    say("shape_count", world_.shape_count());
    say("joint_count", world_.joint_count());
    say("has_user_row_callback", world_.has_user_row_callback());
    say("has_contact_filter", world_.has_contact_filter());
    say("has_contact_rule", world_.has_contact_rule());
    say_all("poses", world_.poses());
    say_all("velocities", world_.velocities());
    say("settings", world_.settings());
    say("stats", world_.stats().step);
    say("hash", world_.hash());
    world_.memory_use();  // depends only on which lists are made by now
    called_.insert("memory_use");
    std::vector<ContactForces> forces(world_.contact_forces({}));
    world_.contact_forces(forces);
    say_all("contact_forces", forces);
  }
  void read_events() {
    say_all("contact_begins", world_.contact_begins());
    say_all("contact_persists", world_.contact_persists());
    say_all("contact_ends", world_.contact_ends());
    say_all("contact_hits", world_.contact_hits());
    say_all("sensor_begins", world_.sensor_begins());
    say_all("sensor_ends", world_.sensor_ends());
    say_all("restored_bodies", world_.restored_bodies());
    say_all("quarantined_bodies", world_.quarantined_bodies());
    say_all("sleep_begins", world_.sleep_begins());
    say_all("sleep_ends", world_.sleep_ends());
    say_all("broken_joints", world_.broken_joints());
    say_all("joint_events", world_.joint_events());
    say_all("frozen_joints", world_.frozen_joints());
    say_all("destroyed_joints", world_.destroyed_joints());
  }

  // These are no functions of World, and the lists that they make are no part of the state.
  void ask_queries() {
    for (int i = 0; i < 8; ++i) {
      const float x = 4.0f * static_cast<float>(i) - 12.0f;
      for (const CastHit& hit : cast_ray_all(world_, {{x, 12, 0.1f}, {1, -20, 0.5f}})) {
        digest_.put(hit.shape.index);
        digest_.put(hit.fraction);
      }
      for (const NearHit& hit : near_point(world_, {x, 1, 0}, 2.0f)) {
        digest_.put(hit.shape.index);
        digest_.put(hit.distance);
      }
    }
  }

  const World& world_;
  const Names& names_;
  ReadingDigest digest_;
  std::set<std::string> called_;
};

// Sleeping stacks on one floor beside moving bodies, with joints. After every few steps, calls that defer
// work: bodies to wake, mass properties, stale pairs.
struct Yard {
  World world{WorldSettings{.contact_events = ContactEvents::all, .contact_forces = true}};
  Names names;
  Workers workers{1};

  Yard() {
    add({.type = BodyType::fixed, .position = {0, -1, 0}}, Box{{40, 1, 40}});
    add({.type = BodyType::kinematic, .position = {-8, 0.2f, 0}}, Box{{1, 0.2f, 1}});
    for (int i = 0; i < 12; ++i) {
      const float x = 1.5f * static_cast<float>(i % 4), z = 1.5f * static_cast<float>(i / 4);
      add({.position = {x, 0.5f, z}}, Box{});
      add({.position = {x, 1.5f, z}}, Box{});
    }
    add({.position = {-8, 0.9f, 0}}, Box{});
    for (int i = 0; i < 6; ++i) add({.position = {-20, 2.0f + 1.2f * static_cast<float>(i), 0}}, Sphere{});
    const BodyId post = names.bodies[0];
    for (int i = 0; i < 3; ++i) {
      const BodyId link = add({.position = {20, 8.0f - static_cast<float>(i), 0}}, Capsule{});
      names.joints.push_back(
          world.create_joint({.body_a = i == 0 ? post : names.bodies[names.bodies.size() - 2],
                              .body_b = link,
                              .frame_a = {i == 0 ? Vec3{20, 9.5f, 0} : Vec3{0, -0.5f, 0}, {}},
                              .frame_b = {{0, 0.5f, 0}, {}}},
                             BallJoint{}));
    }
    names.joints.push_back(
        world.create_joint({.body_a = kWorld, .body_b = names.bodies.back()}, UserJoint{{RowKind::motor}}));
    // A fixed body of many shapes, whose mass is summed at the first read.
    for (int i = 0; i < 12; ++i) {
      names.shapes.push_back(
          world.add_shape(post, Sphere{0.1f}, {}, {.local_pose = {{30, static_cast<float>(i), 0}, {}}}));
    }
    names.shapes.push_back(world.add_shape(post, Sphere{3.0f}, {}, {.sensor = true}));
  }
  BodyId add(const BodyDef& def, const Geometry& geometry) {
    names.bodies.push_back(world.create_body(def));
    names.shapes.push_back(world.add_shape(names.bodies.back(), geometry));
    return names.bodies.back();
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) step(world, kReadStep, workers);
  }
  // Changes the world, for the `round`th time.
  void make_calls(int round) {
    const auto body = [&](int index) { return names.bodies[static_cast<std::size_t>(index)]; };
    world.destroy_body(body(2 + 2 * round));  // under a sleeping box
    names.shapes.push_back(world.add_shape(body(12), Sphere{0.2f}, {}, {.local_pose = {{0.6f, 0, 0}, {}}}));
    names.shapes.push_back(world.add_shape(body(30), Sphere{0.2f}, {}, {.local_pose = {{0.6f, 0, 0}, {}}}));
    if (round == 1) world.set_pose(body(1), {{-8, 0.21f, 0}, {}});
  }
};

// All bytes of the columns that are not scratch.
std::map<std::string, std::vector<std::byte>> columns_of(World& world, bool derived) {
  std::map<std::string, std::vector<std::byte>> columns;
  const auto keep = [&](ColumnKind kind, const std::string& name, const void* rows, std::size_t bytes) {
    if (kind == ColumnKind::scratch || (kind == ColumnKind::derived && !derived)) return;
    const auto* first = static_cast<const std::byte*>(rows);
    std::vector<std::byte>& to = columns[name];
    if (bytes > 0) to.insert(to.end(), first, first + bytes);
  };
  WorldData& data = internals(world);
  for_each_column(data, [&](ColumnKind kind, const char* store, const char* name, auto& column) {
    const auto span = std::as_const(column).span();
    keep(kind, std::string(store) + "." + name, span.data(), span.size_bytes());
  });
  for_each_part(data, [&](const char* store, const Part& part) {
    part.report(store, [&](const Member& member, const void* rows, std::size_t, std::size_t bytes,
                           std::size_t) { keep(member.kind, member.name, rows, bytes); });
  });
  return columns;
}

std::set<std::string> const_functions() {
  std::ifstream file(SCREE_WORLD_HEADER);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const std::string bare = std::regex_replace(text, std::regex("//[^\n]*"), std::string());
  const std::regex call("([a-z_]+)\\([^()]*\\)\\s+const\\b");
  std::set<std::string> names;
  for (std::sregex_iterator it(bare.begin(), bare.end(), call), last; it != last; ++it)
    names.insert((*it)[1].str());
  return names;
}

class ReadingCallers : public ManyThreads {};

TEST_F(ReadingCallers, TestsCallEveryConstFunction) {
  Yard yard;
  yard.run(2);
  EXPECT_EQ(Reader(yard.world, yard.names).called(), const_functions());
}

TEST_F(ReadingCallers, ChangeNoByteOfTheStateOrOfWhatFollowsFromIt) {
  Yard yard;
  yard.run(90);
  for (int round = 0; round < 3; ++round) {
    yard.make_calls(round);
    ASSERT_TRUE(internals(yard.world).shapes.wake_requested);
    ASSERT_FALSE(internals(yard.world).bodies.to_place.empty());
    const auto before = columns_of(yard.world, true);
    const Reader reader(yard.world, yard.names);
    for (const auto& [name, bytes] : columns_of(yard.world, true)) {
      EXPECT_TRUE(bytes == before.at(name)) << name;
    }
    yard.run(5);
  }
}

TEST_F(ReadingCallers, SaveAndCloneWithoutAChangeOfState) {
  Yard yard;
  yard.run(90);
  yard.make_calls(0);
  const auto before = columns_of(yard.world, false);
  Snapshot snapshot;
  save(yard.world, snapshot);
  const World copy = clone(yard.world);
  EXPECT_TRUE(columns_of(yard.world, false) == before);
  EXPECT_EQ(Reader(copy, yard.names).value() != 0, true);
}

// A box that lost its support counts as awake before a step wakes it, and reading this wakes no body.
TEST_F(ReadingCallers, SeeWhichBodiesTheNextStepWillWake) {
  Yard yard, unread;
  yard.run(90);
  unread.run(90);
  const BodyId lower = yard.names.bodies[2], upper = yard.names.bodies[3], aside = yard.names.bodies[5];
  ASSERT_FALSE(yard.world.is_awake(upper));
  yard.world.destroy_body(lower);
  unread.world.destroy_body(unread.names.bodies[2]);
  EXPECT_TRUE(yard.world.is_awake(upper));
  EXPECT_FALSE(yard.world.is_awake(aside));
  EXPECT_NE(internals(yard.world).bodies.flags[upper.index] & kBodyAsleep, 0);
  // The next read sees the change of another call.
  yard.world.destroy_body(yard.names.bodies[4]);
  unread.world.destroy_body(unread.names.bodies[4]);
  EXPECT_TRUE(yard.world.is_awake(aside));
  yard.run(1);
  unread.run(1);
  EXPECT_TRUE(yard.world.is_awake(upper));
  EXPECT_EQ(first_difference(unread.world, yard.world), "");
}

TEST_F(ReadingCallers, SeeTheSameFromFourThreadsAtOnce) {
  Yard yard, alone;
  for (int round = 0; round < 4; ++round) {
    yard.run(round == 0 ? 90 : 7);
    alone.run(round == 0 ? 90 : 7);
    if (round > 0) {
      yard.make_calls(round);
      alone.make_calls(round);
    }
    std::vector<std::uint64_t> seen(4), copied(4);
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      threads.emplace_back([&, i] {
        Snapshot snapshot;
        if (i % 2 == 0) save(yard.world, snapshot);
        seen[i] = Reader(yard.world, yard.names).value();
        copied[i] = clone(yard.world).hash();
      });
    }
    for (std::thread& thread : threads) thread.join();
    const std::uint64_t expected = Reader(alone.world, alone.names).value();
    for (std::size_t i = 0; i < seen.size(); ++i) {
      EXPECT_EQ(seen[i], expected) << "thread " << i << ", round " << round;
      EXPECT_EQ(copied[i], alone.world.hash());
    }
  }
  yard.run(20);
  alone.run(20);
  EXPECT_EQ(yard.world.hash(), alone.world.hash());
}

}  // namespace
}  // namespace determinism
}  // namespace scree
