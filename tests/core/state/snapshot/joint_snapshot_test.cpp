// Laws of snapshots with joints: what restoring reproduces, and what is refused.
#include <core/constraints/joint_parameters.h>
#include <core/world/edit.h>
#include <scree/scree.h>
#include <tests/core/constraints/joint_samples.h>
#include <tests/core/world/world_fixture.h>

#include <cstring>
#include <functional>
#include <limits>

namespace scree::test {
namespace {

using Bytes = std::vector<std::byte>;

Bytes bytes_of(const World& world) {
  Snapshot snapshot;
  save(world, snapshot);
  return write_snapshot(snapshot);
}

// All kinds of joints, some with the world, a free slot, and joints that have gone with their body.
struct Workshop {
  World world;
  std::vector<BodyId> bodies{5};
  std::vector<JointId> joints;

  Workshop() {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      bodies[i] = world.create_body({.position = {2.0f * static_cast<float>(i), 0, 0}});
      world.add_shape(bodies[i], Sphere{0.3f}, {}, {.local_pose = {{0.1f, 0.2f, 0.3f}, {}}});
    }
    std::size_t next = 0;
    for (const Joint& joint : sound_joints()) {
      const bool with_world = type_of(joint) == JointType::mouse || next % 5 == 4;
      joints.push_back(world.create_joint({.body_a = with_world ? kWorld : bodies[next % 4],
                                           .body_b = bodies[(next + 1) % 4],
                                           .frame_a = {{1, 2, 3}, {0.5f, 0.5f, 0.5f, 0.5f}},
                                           .collide_connected = next % 2 == 0,
                                           .enabled = next % 3 != 0,
                                           .hertz = next % 2 == 0 ? 0.0f : 3.0f,
                                           .break_force = next % 4 == 0 ? 5.0f : kNoLimit,
                                           .event_torque = next % 3 == 1 ? 2.0f : kNoLimit,
                                           .user_data = next},
                                          joint));
      ++next;
    }
    world.create_joint({.body_a = bodies[4], .body_b = bodies[0]}, WeldJoint{});
    world.destroy_joint(joints[3]);
    joints.erase(joints.begin() + 3);
    world.destroy_body(bodies[4]);
    internals(world).joints.impulses[joints[0].index].impulse[2] = 7.0f;
    internals(world).joints.reaction[joints[0].index].force[0] = 7.0f;
  }
  Joints& rows() { return internals(world).joints; }
  std::size_t row_of(JointType type) const {
    for (const JointId joint : joints) {
      if (world.joint_type(joint) == type) return joint.index;
    }
    ADD_FAILURE() << "no joint of the kind " << name_of(type);
    return 0;
  }
};

void expect_same_joints(const World& left, const World& right, const Workshop& w) {
  EXPECT_EQ(left.joint_count(), right.joint_count());
  for (const JointId joint : w.joints) {
    ASSERT_TRUE(left.is_alive(joint) && right.is_alive(joint));
    EXPECT_TRUE(left.joint(joint) == right.joint(joint));
    EXPECT_TRUE(left.joint_def(joint) == right.joint_def(joint));
    EXPECT_EQ(left.joint_pose(joint), right.joint_pose(joint));
  }
  const auto listed = [](const World& world, BodyId body) {
    std::vector<JointId> ids(world.joints_of(body, {}));
    world.joints_of(body, ids);
    return ids;
  };
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(listed(left, w.bodies[i]), listed(right, w.bodies[i]));
}

TEST(JointSnapshot, HoldsTheSameBytesAfterEveryWay) {
  Workshop w;
  const Bytes bytes = bytes_of(w.world);
  EXPECT_EQ(write_snapshot(read_snapshot(bytes)), bytes);
  const World copy = clone(w.world);
  EXPECT_EQ(bytes_of(copy), bytes);
  expect_same_joints(copy, w.world, w);
  World other;
  other.share_handles(w.world);
  const BodyId body = other.create_body({});
  other.create_joint({.body_a = kWorld, .body_b = body}, BallJoint{});
  restore(other, read_snapshot(bytes));
  EXPECT_EQ(bytes_of(other), bytes);
  expect_same_joints(other, w.world, w);
}

TEST(JointSnapshot, RebuildsDerivedRows) {
  Workshop w;
  const World copy = clone(w.world);
  const Joints &left = internals(copy).joints, &right = w.rows();
  EXPECT_TRUE(left.all_changed);
  EXPECT_EQ(left.alive, right.alive);
  for (const JointId joint : w.joints) {
    const std::size_t row = joint.index;
    EXPECT_EQ(std::memcmp(&left.frames[row], &right.frames[row], sizeof(JointFrames)), 0);
    EXPECT_EQ(std::memcmp(&left.previous[row], &right.previous[row], sizeof(JointBodies)), 0);
    EXPECT_EQ(copy.joint_reaction(joint), JointReaction{}) << "of a step that this world has not made";
  }
  EXPECT_EQ(left.impulses[w.joints[0].index].impulse[2], 7.0f);
  EXPECT_EQ(internals(copy).events.lost.size(), 1u);
}

TEST(JointSnapshot, LaterCallsGiveTheSameResults) {
  Workshop w;
  World copy = clone(w.world);
  const auto change = [&](World& world) {
    std::vector<JointId> made;
    for (int i = 0; i < 4; ++i)
      made.push_back(world.create_joint({.body_a = kWorld, .body_b = w.bodies[0]}, GearJoint{}));
    world.destroy_joint(w.joints[1]);
    world.destroy_body(w.bodies[2]);
    world.set_mass_properties(w.bodies[0], {.center = {1, 2, 3}});
    made.push_back(world.create_joint({.body_a = w.bodies[0], .body_b = w.bodies[1]}, HingeJoint{}));
    return made;
  };
  EXPECT_EQ(change(copy), change(w.world));
  EXPECT_EQ(bytes_of(copy), bytes_of(w.world));
}

TEST(JointSnapshot, MakesExactlyTheHandlesOfItsMomentValid) {
  Workshop w;
  Snapshot snapshot;
  save(w.world, snapshot);
  w.world.destroy_joint(w.joints[2]);
  const JointId later = w.world.create_joint({.body_a = kWorld, .body_b = w.bodies[0]}, BallJoint{});
  const JointId last = w.world.create_joint({.body_a = kWorld, .body_b = w.bodies[0]}, BallJoint{});
  restore(w.world, snapshot);
  EXPECT_TRUE(w.world.is_alive(w.joints[2]));
  EXPECT_FALSE(w.world.is_alive(later) || w.world.is_alive(last));
}

TEST(JointSnapshot, KeepsItsMemoryInProportion) {
  // Equal rows compress well, but only up to a bound: a short file must not need much memory.
  World world;
  const BodyId body = world.create_body({});
  constexpr std::size_t kCount = 10000;
  const std::vector<JointDef> defs(kCount, {.body_a = kWorld, .body_b = body});
  std::vector<JointId> ids(kCount);
  world.create_joints(defs, std::vector<Joint>(kCount, WheelJoint{}), ids);
  std::size_t row_bytes = 0;
  internals(world).joints.for_each_column(
      [&](ColumnKind, const char*, auto& column) { row_bytes += sizeof(*column.data()); });
  EXPECT_GT(bytes_of(world).size(), kCount * row_bytes / 8);
}

// --- what is refused ---

struct Wrong {
  const char* what;
  const char* said;
  std::function<void(Workshop&, Joints&, Bodies&, std::size_t row)> make;
};

const std::vector<Wrong>& wrongs() {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  static const std::vector<Wrong> all = {
      {"flags", "joints.flags, row 1: cannot be set",
       [](auto&, auto& j, auto&, auto row) { j.flags[row] |= 64; }},
      {"rich", "joints.flags, row 1: are not those of the joint",
       [](auto&, auto& j, auto&, auto row) { j.flags[row] ^= kJointRich; }},
      {"breaks", "joints.flags, row 1: are not those of the joint",
       [](auto&, auto& j, auto&, auto row) { j.flags[row] ^= kJointBreaks; }},
      {"reports", "joints.flags, row 1: are not those of the joint",
       [](auto&, auto& j, auto&, auto row) { j.flags[row] ^= kJointReports; }},
      {"flags of the dead", "joints.flags, row 3: cannot be set",
       [](auto&, auto& j, auto&, auto) { j.flags[3] = kJointEnabled; }},
      {"type", "joints.type, row 1: is no type of joints",
       [](auto&, auto& j, auto&, auto row) { j.type[row] = static_cast<JointType>(kJointTypeCount); }},
      {"another type", "joints.parameters, row 1: is not that of such a joint",
       [](auto&, auto& j, auto&, auto row) { j.type[row] = JointType::gear; }},
      {"generation", "joints.generation, row 1: a living joint has none",
       [](auto&, auto& j, auto&, auto row) { j.generation[row] = 0; }},
      {"body behind the end", "joints.bodies, row 1: do not exist",
       [](auto&, auto& j, auto& b, auto row) {
         j.bodies[row].a = static_cast<std::int32_t>(b.flags.size());
       }},
      {"negative body", "joints.bodies, row 1: do not exist",
       [](auto&, auto& j, auto&, auto row) { j.bodies[row].b = -1; }},
      {"reserved body", "joints.bodies, row 1: do not exist",
       [](auto&, auto& j, auto&, auto row) { j.bodies[row].a = 2; }},
      {"body of the dead", "joints.bodies, row 3: do not exist",
       [](auto&, auto& j, auto&, auto) { j.bodies[3].a = 100; }},
      {"dead body", "no body lives",
       [](auto& w, auto& j, auto&, auto row) {
         j.bodies[row].a = static_cast<std::int32_t>(w.bodies[4].index);
       }},
      {"itself", "body_a and body_b are both body",
       [](auto&, auto& j, auto&, auto row) { j.bodies[row].a = j.bodies[row].b; }},
      {"another body", "stands in its list twice",
       [](auto& w, auto& j, auto&, auto row) {
         j.bodies[row].a = static_cast<std::int32_t>(w.bodies[3].index);
       }},
      {"body of a mouse", "must be the world",
       [](auto& w, auto& j, auto&, auto) {
         j.bodies[w.row_of(JointType::mouse)].a = static_cast<std::int32_t>(w.bodies[0].index);
       }},
      {"frame", "frame_a.position is nan",
       [](auto&, auto& j, auto&, auto row) { j.frame_a[row].position.y = kNan; }},
      {"turned frame", "frame_b.rotation has length",
       [](auto&, auto& j, auto&, auto row) { j.frame_b[row].rotation.w = 3.0f; }},
      {"limit", "hinge angle.lower is nan",
       [](auto&, auto& j, auto&, auto row) { j.parameters[row].axis[0].lower = kNan; }},
      {"drive", "hinge angle.drive is ",
       [](auto&, auto& j, auto&, auto row) { j.parameters[row].axis[0].drive = 77; }},
      {"drive past a byte", "joints.parameters, row 1: is not that of such a joint",
       [](auto&, auto& j, auto&, auto row) { j.parameters[row].axis[0].drive += 256; }},
      {"unused axis", "joints.parameters, row 1: is not that of such a joint",
       [](auto&, auto& j, auto&, auto row) { j.parameters[row].axis[4].target = 1.0f; }},
      {"angular stiffness", "joints.parameters, row 1: is not that of such a joint",
       [](auto&, auto& j, auto&, auto row) { j.parameters[row].angular_hertz = 9.0f; }},
      {"stiffness", "hertz is -1", [](auto&, auto& j, auto&, auto row) { j.parameters[row].hertz = -1.0f; }},
      {"strength", "break_torque is 0",
       [](auto&, auto& j, auto&, auto row) { j.strength[row].torque = 0.0f; }},
      {"threshold", "event_force is nan",
       [](auto&, auto& j, auto&, auto row) { j.thresholds[row].force = kNan; }},
      {"circle", "stands in its list twice",
       [](auto&, auto& j, auto&, auto row) { j.next[row].b = static_cast<std::int32_t>(row); }},
      {"list out of range", "joints.next, row 1: is no joint of the body",
       [](auto&, auto& j, auto&, auto row) { j.next[row].b = 1000; }},
      {"negative link", "joints.next, row 1: is no joint of the body",
       [](auto&, auto& j, auto&, auto row) { j.next[row].b = -2; }},
      {"cut list", "joints.bodies, row ", [](auto&, auto& j, auto&, auto row) { j.next[row + 4].b = -1; }},
      {"first", "bodies.first_joint, row ",
       [](auto& w, auto&, auto& b, auto) { b.first_joint[w.bodies[0].index] = 3; }},
      {"list of the dead", "a dead body has none",
       [](auto& w, auto&, auto& b, auto) { b.first_joint[w.bodies[4].index] = 0; }},
      {"list of the world", "the fixed world's rows cannot be changed",
       [](auto&, auto&, auto& b, auto) { b.first_joint[kFixedRow] = 4; }},
      {"link of the world", "joints.next, row 4: the world has no list",
       [](auto&, auto& j, auto&, auto) { j.next[4].a = 1; }},
      {"no flag of motion", "the wrong flag for joints",
       [](auto& w, auto&, auto& b, auto) { b.motion[w.bodies[0].index].flags ^= kMotionJointed; }},
      {"free slot", "joints.free_slots, row 0: names a row that cannot be listed",
       [](auto&, auto& j, auto&, auto row) { j.free_slots[0] = static_cast<std::int32_t>(row); }},
      {"lost", "events.lost, row 0: names no joint",
       [](auto& w, auto&, auto&, auto) { internals(w.world).events.lost[0].index = 1000; }},
      {"rows", "joints.impulses, row 0: wrong number of rows",
       [](auto&, auto& j, auto&, auto) {  // the columns of a sheet, which have as many rows as each other
         j.impulses.resize(j.impulses.size() + 1);
         j.color.resize(j.color.size() + 1);
       }},
      {"more free slots", "joints.free_slots, row 0: wrong number of rows",
       [](auto&, auto& j, auto&, auto) { j.free_slots.resize(100); }}};
  return all;
}

TEST(JointSnapshot, RefusesStatesThatNoCallsCouldMake) {
  const Workshop sound;
  ASSERT_EQ(sound.world.joint_type(sound.joints[1]), JointType::hinge);
  for (const Wrong& wrong : wrongs()) {
    Workshop w;
    ASSERT_EQ(w.joints[1].index, 1u);
    place_matter(internals(w.world));  // while its lists are sound
    wrong.make(w, w.rows(), internals(w.world).bodies, 1);
    const std::string error = error_of([&] { read_snapshot(bytes_of(w.world)); });
    EXPECT_EQ(error.find("read_snapshot: byte "), 0u) << wrong.what;
    EXPECT_NE(error.find(wrong.said), std::string::npos) << wrong.what << ": " << error;
  }
}

TEST(JointSnapshot, AcceptsAnyStoredImpulse) {
  Workshop w;
  for (float& impulse : w.rows().impulses[1].impulse) impulse = std::numeric_limits<float>::quiet_NaN();
  w.rows().color[1] = 63;
  EXPECT_EQ(error_of([&] { read_snapshot(bytes_of(w.world)); }), "");
}

}  // namespace
}  // namespace scree::test
