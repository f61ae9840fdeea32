// Laws of handles and worlds: which handles a world accepts, and that refusing one changes nothing.
#include <core/state/recording_format/recorded_calls.h>
#include <scree/scree.h>
#include <tests/core/world/world_fixture.h>

#include <array>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <regex>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <vector>

namespace scree::test {
namespace {

constexpr float kDt = 1.0f / 60.0f;  // s

// Such worlds have equal handles, except for the number of the world in them.
struct Twin {
  World world{WorldSettings{.contact_events = ContactEvents::all, .contact_forces = true}};
  BodyId floor = world.create_body({.type = BodyType::fixed, .position = {0, -1, 0}});
  ShapeId ground = world.add_shape(floor, Box{{9, 1, 9}});
  BodyId body = world.create_body({.position = {0, 0.5f, 0}});
  ShapeId shape = world.add_shape(body, Box{});
  BodyId other = world.create_body({.position = {3, 0.5f, 0}});
  ShapeId other_shape = world.add_shape(other, Sphere{});
  JointId joint =
      world.create_joint({.body_a = floor, .body_b = other, .frame_a = {{3, 1.5f, 0}, {}}}, DistanceJoint{});
  Workers workers{1};

  std::vector<std::byte> bytes() const {
    Snapshot snapshot;
    save(world, snapshot);
    return write_snapshot(snapshot);
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) step(world, kDt, workers);
  }
};

std::optional<ErrorCode> code_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.code();
  }
  return {};
}

template <class First>
First handle_in(const Twin& twin) {
  if constexpr (std::is_same_v<First, BodyId>) return twin.body;
  if constexpr (std::is_same_v<First, ShapeId>) return twin.shape;
  if constexpr (std::is_same_v<First, JointId>) return twin.joint;
}

// Each call by its name, and its effect on a world with handles of a twin.
using Calls = std::vector<std::pair<std::string, std::function<void(World&, const Twin&)>>>;

template <class Types>
struct CallOf;
template <class First, class... Rest>
struct CallOf<std::tuple<First, Rest...>> {
  template <class Function>
  static void add(Calls& calls, const char* name, Function function) {
    if constexpr (std::is_same_v<First, BodyId> || std::is_same_v<First, ShapeId> ||
                  std::is_same_v<First, JointId>) {
      calls.push_back({name, [function](World& world, const Twin& twin) {
                         function(world, handle_in<First>(twin), Rest{}...);
                       }});
    }
  }
};

// Those of the table of calls that change a world, and what is in lists and definitions.
Calls changing_calls() {
  Calls calls;
#define SCREE_ADD_CALL(call, function, ...)                                                        \
  CallOf<CallArguments<RecordedCall::call>::Types>::add(                                           \
      calls, #function, [](World& world, const auto& first, const auto&... rest) {                 \
        if constexpr (requires { world.function(first, rest...); }) {                              \
          static_cast<void>(world.function(first, rest...));                                       \
        } else if constexpr (requires { world.function(first, rest..., std::span<ShapeId>{}); }) { \
          world.function(first, rest..., std::span<ShapeId>{});                                    \
        }                                                                                          \
      });
  SCREE_RECORDED_CALLS(SCREE_ADD_CALL)
#undef SCREE_ADD_CALL
  calls.push_back({"destroy_bodies", [](World& world, const Twin& twin) {
                     world.destroy_bodies(std::array{world.body_at(twin.floor.index), twin.body});
                   }});
  calls.push_back({"refresh_user_rows", [](World& world, const Twin& twin) {
                     world.refresh_user_rows({&twin.joint, 1}, {});
                   }});
  for (const bool second : {false, true}) {
    calls.push_back(
        {"answer_contact_hooks", [=](World& world, const Twin& twin) {
           ShapeId own;
           world.shapes_of(world.body_at(second ? twin.floor.index : twin.other.index), {&own, 1});
           const ContactAnswer answer =
               second ? ContactAnswer{own, twin.shape, -1, {}} : ContactAnswer{twin.shape, own, -1, {}};
           world.answer_contact_hooks({&answer, 1});
         }});
  }
  calls.push_back({"create_joint", [](World& world, const Twin& twin) {
                     world.create_joint({.body_a = twin.body, .body_b = kWorld}, BallJoint{});
                   }});
  calls.push_back({"create_joint", [](World& world, const Twin& twin) {
                     world.create_joint({.body_a = kWorld, .body_b = twin.body}, BallJoint{});
                   }});
  calls.push_back({"create_joints", [](World& world, const Twin& twin) {
                     const JointDef defs[] = {{.body_a = world.body_at(twin.floor.index), .body_b = kWorld},
                                              {.body_a = twin.body, .body_b = kWorld}};
                     const Joint joints[2];
                     JointId ids[2];
                     world.create_joints(defs, joints, ids);
                   }});
  return calls;
}

Calls reading_calls() {
  Calls calls;
#define SCREE_READ(function, handle, ...)                                                       \
  calls.push_back({#function, [](World& world, const Twin& twin) {                              \
                     static_cast<void>(world.function(twin.handle __VA_OPT__(, ) __VA_ARGS__)); \
                   }});
  SCREE_READ(body_type, body)
  SCREE_READ(pose, body)
  SCREE_READ(linear_velocity, body)
  SCREE_READ(angular_velocity, body)
  SCREE_READ(velocity_at, body, Vec3{})
  SCREE_READ(center_of_mass, body)
  SCREE_READ(mass_properties, body)
  SCREE_READ(linear_damping, body)
  SCREE_READ(angular_damping, body)
  SCREE_READ(gravity_factor, body)
  SCREE_READ(locks, body)
  SCREE_READ(can_sleep, body)
  SCREE_READ(full_sweep, body)
  SCREE_READ(is_awake, body)
  SCREE_READ(is_quarantined, body)
  SCREE_READ(user_data, body)
  SCREE_READ(user_data, shape)
  SCREE_READ(user_data, joint)
  SCREE_READ(shapes_of, body, std::span<ShapeId>{})
  SCREE_READ(joints_of, body, std::span<JointId>{})
  SCREE_READ(contact_forces_of, body, std::span<ContactForces>{})
  SCREE_READ(contact_forces_of, shape, std::span<ContactForces>{})
  SCREE_READ(body_of, shape)
  SCREE_READ(geometry, shape)
  SCREE_READ(material, shape)
  SCREE_READ(filter, shape)
  SCREE_READ(contact_events, shape)
  SCREE_READ(contact_hooks, shape)
  SCREE_READ(is_sensor, shape)
  SCREE_READ(visitors_of, shape, std::span<ShapeId>{})
  SCREE_READ(local_pose, shape)
  SCREE_READ(joint_type, joint)
  SCREE_READ(joint, joint)
  SCREE_READ(joint_def, joint)
  SCREE_READ(is_enabled, joint)
  SCREE_READ(collides_connected, joint)
  SCREE_READ(joint_pose, joint)
  SCREE_READ(joint_reaction, joint)
  SCREE_READ(user_rows, joint, std::span<UserRow>{})
  SCREE_READ(is_frozen, joint)
#undef SCREE_READ
  return calls;
}

// The functions of World that take a handle.
std::set<std::string> functions_with_handles() {
  std::ifstream file(SCREE_WORLD_HEADER);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const std::string bare =
      std::regex_replace(text.substr(text.find("class SCREE_API World")), std::regex("//[^\n]*"), "");
  const std::regex call("([a-z_]+)\\(([^()]*)\\)");
  const std::regex handle("\\b(BodyId|ShapeId|JointId|JointDef|span<const BodyId>) ?>? ");
  std::set<std::string> names;
  for (std::sregex_iterator it(bare.begin(), bare.end(), call), last; it != last; ++it) {
    if (std::regex_search((*it)[2].str(), handle)) names.insert((*it)[1].str());
  }
  names.erase("is_alive");
  names.erase("create_bodies");  // hands them out
  return names;
}

TEST(ForeignHandles, AreRefusedByEveryCallWhichChangesNothing) {
  std::set<std::string> tested;
  for (const Calls& calls : {changing_calls(), reading_calls()}) {
    for (const auto& each : calls) {
      const std::string& name = each.first;
      const auto& call = each.second;
      tested.insert(name);
      Twin own;
      const Twin foreign;
      ASSERT_EQ(own.body.index, foreign.body.index);
      ASSERT_EQ(own.body.generation, foreign.body.generation);
      const std::vector<std::byte> before = own.bytes();
      EXPECT_EQ(code_of([&] { call(own.world, foreign); }), ErrorCode::foreign_handle) << name;
      EXPECT_TRUE(own.bytes() == before) << name;
      // The error names only the wrong world.
      EXPECT_NE(code_of([&] { call(own.world, own); }), ErrorCode::foreign_handle) << name;
    }
  }
  for (const std::string& name : functions_with_handles()) EXPECT_TRUE(tested.contains(name)) << name;
}

TEST(ForeignHandles, AreNotAlive) {
  const Twin own, foreign;
  EXPECT_TRUE(own.world.is_alive(own.body));
  EXPECT_FALSE(own.world.is_alive(foreign.body));
  EXPECT_FALSE(own.world.is_alive(foreign.shape));
  EXPECT_FALSE(own.world.is_alive(foreign.joint));
  EXPECT_NE(own.body, foreign.body);
  EXPECT_NE(error_of([&] { own.world.pose(foreign.body); }).find("belongs to another world"),
            std::string::npos);
}

TEST(Handles, OfIndexAndGenerationAreTakenByAnyWorld) {
  const Twin first, second;
  const BodyId body{first.body.index, first.body.generation};
  const ShapeId shape{first.shape.index, first.shape.generation};
  const JointId joint{first.joint.index, first.joint.generation};
  for (const Twin* twin : {&first, &second}) {
    EXPECT_TRUE(twin->world.is_alive(body));
    EXPECT_EQ(twin->world.body_of(shape), twin->body);
    EXPECT_EQ(twin->world.joint_def(joint).body_b, twin->other);
  }
}

TEST(Handles, HoldInAllBranches) {
  Twin twin;
  twin.run(3);
  Snapshot early, late;
  save(twin.world, early);
  World copy = clone(twin.world);
  World moved = clone(copy);
  World restored;
  restore(restored, early);
  twin.run(2);
  save(twin.world, late);
  SnapshotChanges changes;
  keep_changes(early, late, changes);
  Snapshot again;
  apply_changes(early, changes, again);
  World applied;
  restore(applied, again);
  World last = std::move(moved);
  for (const World* world : {&copy, &restored, &applied, &last}) {
    EXPECT_TRUE(world->is_alive(twin.body));
    EXPECT_TRUE(world->is_alive(twin.shape));
    EXPECT_EQ(world->body_at(twin.body.index), twin.body);
    EXPECT_EQ(world->joint_def(twin.joint).body_a, twin.floor);
  }
}

TEST(Handles, OfBothWorldsNameBodiesOfAWorldThatBecomesAnotherOne) {
  Twin twin, other, third;
  Snapshot snapshot;
  save(twin.world, snapshot);
  restore(other.world, snapshot);
  EXPECT_TRUE(other.world.is_alive(twin.body));
  EXPECT_EQ(other.world.body_at(twin.body.index), twin.body);
  EXPECT_TRUE(other.world.is_alive(other.body));
  EXPECT_EQ(other.world.pose(other.body), other.world.pose(twin.body));
  EXPECT_EQ(code_of([&] { other.world.pose(third.body); }), ErrorCode::foreign_handle);
  EXPECT_EQ(code_of([&] { twin.world.pose(other.body); }), ErrorCode::foreign_handle);
}

TEST(Handles, StayTheWorldsOwnWhereItIsRestoredFromBytes) {
  Twin twin;
  const Snapshot read = read_snapshot(twin.bytes());
  twin.run(5);
  restore(twin.world, read);
  EXPECT_TRUE(twin.world.is_alive(twin.body));
  World other;
  restore(other, read);
  EXPECT_EQ(code_of([&] { other.pose(twin.body); }), ErrorCode::foreign_handle);
  EXPECT_NE(other.body_at(twin.body.index), twin.body);
  EXPECT_TRUE(other.is_alive(other.body_at(twin.body.index)));
}

TEST(Handles, AreValidInWorldsThatShareHandles) {
  Twin twin;
  World other;
  other.share_handles(twin.world);
  EXPECT_EQ(other.create_body({}), twin.floor);
  other.share_handles(twin.world);  // which changes nothing
  Twin late;
  EXPECT_EQ(code_of([&] { late.world.share_handles(twin.world); }), ErrorCode::wrong_state);
  EXPECT_TRUE(late.world.is_alive(late.body));
}

TEST(Handles, OfEventsAreThoseOfTheWorld) {
  Twin twin;
  twin.run(1);
  ASSERT_FALSE(twin.world.contact_begins().empty());
  const ContactEvent& begin = twin.world.contact_begins()[0];
  EXPECT_EQ(begin.shape_a, twin.ground);
  EXPECT_EQ(begin.shape_b, twin.shape);
  EXPECT_EQ(begin.body_b, twin.body);
  std::vector<ContactForces> forces(1);
  ASSERT_GT(twin.world.contact_forces_of(twin.body, forces), 0u);
  EXPECT_EQ(forces[0].body_b, twin.body);
  bool slept = false;
  for (int i = 0; i < 200 && !slept; ++i) {
    twin.run(1);
    for (const BodyId body : twin.world.sleep_begins()) slept |= body == twin.body;
  }
  EXPECT_TRUE(slept);
  twin.world.wake(twin.body);
  twin.world.destroy_body(twin.other);
  twin.run(1);
  ASSERT_EQ(twin.world.destroyed_joints().size(), 1u);
  EXPECT_EQ(twin.world.destroyed_joints()[0], twin.joint);
  ASSERT_FALSE(twin.world.sleep_ends().empty());
  EXPECT_EQ(twin.world.sleep_ends()[0], twin.body);
  twin.world.set_pose(twin.body, {{0, 50, 0}, {}});
  twin.run(1);
  ASSERT_FALSE(twin.world.contact_ends().empty());
  EXPECT_EQ(twin.world.contact_ends()[0].shape_b, twin.shape);
}

// The first worlds of a process and later ones, with the same calls.
TEST(Handles, OfOtherWorldsChangeNoByteOfTheState) {
  std::vector<std::vector<std::byte>> bytes;
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < 3; ++i) {
    for (int others = 0; others < 100 * i; ++others) World();
    Twin twin;
    twin.run(120);
    twin.world.wake(twin.body);
    twin.world.destroy_body(twin.other);  // a joint is lost, and a body has woken: both are state
    bytes.push_back(twin.bytes());
    hashes.push_back(twin.world.hash());
  }
  EXPECT_TRUE(bytes[0] == bytes[1] && bytes[0] == bytes[2]);
  EXPECT_TRUE(hashes[0] == hashes[1] && hashes[0] == hashes[2]);
}

}  // namespace
}  // namespace scree::test
