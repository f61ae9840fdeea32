// Laws of the numbers of user joints: they return what they were set to, whatever other joints come and go,
// and what is out of range is refused by name and changes nothing.
#include <core/constraints/user_rows.h>
#include <scree/scree.h>
#include <tests/core/world/world_fixture.h>

#include <functional>
#include <limits>
#include <random>

namespace scree::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

std::vector<std::byte> bytes_of(const World& world) {
  Snapshot snapshot;
  save(world, snapshot);
  return write_snapshot(snapshot);
}

UserRow row_of(float first) {
  return {.jacobian = {{first, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}},
          .target = {0.5f, -1, 3, 0.25f},
          .bounds = {-first, first}};
}
std::vector<UserRow> rows_of(const World& world, JointId joint) {
  std::vector<UserRow> rows(world.user_rows(joint, {}));
  world.user_rows(joint, rows);
  return rows;
}

struct Workshop {
  World world;
  BodyId a = world.create_body({}), b = world.create_body({.position = {1, 0, 0}});
  JointId join(const UserJoint& user = {}) { return world.create_joint({.body_a = a, .body_b = b}, user); }

  void refuse(const std::function<void()>& call, const std::string& said) {
    const std::vector<std::byte> before = bytes_of(world);
    const std::string error = error_of(call);
    EXPECT_NE(error.find(said), std::string::npos) << '"' << error << "\" without \"" << said << '"';
    EXPECT_TRUE(bytes_of(world) == before) << error;
  }
};

TEST(UserJoints, BeginWithRowsThatMoveNothing) {
  Workshop w;
  const JointId joint = w.join({{RowKind::held, RowKind::motor}});
  EXPECT_EQ(rows_of(w.world, joint), std::vector<UserRow>(2));
  EXPECT_FALSE(w.world.is_frozen(joint));
}

TEST(UserJoints, ReturnTheNumbersThatTheyWereGiven) {
  Workshop w;
  const JointId joint = w.join({{RowKind::held, RowKind::limit, RowKind::spring}});
  const std::vector<UserRow> rows{row_of(1), row_of(2), {.bounds = {-kInfinity, kInfinity}}};
  w.world.set_user_rows(joint, rows);
  EXPECT_EQ(rows_of(w.world, joint), rows);
  UserRow first;
  EXPECT_EQ(w.world.user_rows(joint, {&first, 1}), 3u);
  EXPECT_EQ(first, rows[0]);
}

// The numbers of a joint stay with it while others are created and destroyed beside it, in any order.
TEST(UserJoints, KeepTheirNumbersWhileOthersComeAndGo) {
  Workshop w;
  std::mt19937 random(1);
  std::vector<std::pair<JointId, float>> joints;
  for (int round = 0; round < 2000; ++round) {
    const bool destroys = !joints.empty() && random() % 5 < 2;
    if (destroys) {
      const std::size_t which = random() % joints.size();
      w.world.destroy_joint(joints[which].first);
      joints.erase(joints.begin() + static_cast<std::ptrdiff_t>(which));
    } else {
      const auto first = static_cast<float>(round + 1);
      joints.emplace_back(w.join(), first);
      w.world.create_joint({.body_a = kWorld, .body_b = w.b}, BallJoint{});
      const UserRow row = row_of(first);
      w.world.set_user_rows(joints.back().first, {&row, 1});
    }
  }
  EXPECT_GT(joints.size(), 10u);
  World copy;
  copy.share_handles(w.world);
  restore(copy, read_snapshot(bytes_of(w.world)));
  for (const auto& [joint, first] : joints) {
    EXPECT_EQ(rows_of(w.world, joint), std::vector<UserRow>{row_of(first)});
    EXPECT_EQ(rows_of(copy, joint), std::vector<UserRow>{row_of(first)});
  }
}

TEST(UserJoints, GoWithTheirBodies) {
  Workshop w;
  const JointId joint = w.join(),
                other = w.world.create_joint({.body_a = kWorld, .body_b = w.b}, UserJoint{});
  const UserRow row = row_of(3);
  w.world.set_user_rows(other, {&row, 1});
  w.world.destroy_body(w.a);
  EXPECT_FALSE(w.world.is_alive(joint));
  EXPECT_EQ(rows_of(w.world, other), std::vector<UserRow>{row});
}

TEST(UserJoints, LoseTheNumbersOfRowsThatTheyNoLongerHave) {
  Workshop w;
  const JointId joint = w.join({{RowKind::held, RowKind::held, RowKind::held}});
  w.world.set_user_rows(joint, std::vector<UserRow>{row_of(1), row_of(2), row_of(3)});
  w.world.set_joint(joint, UserJoint{{RowKind::limit}});
  EXPECT_EQ(rows_of(w.world, joint), std::vector<UserRow>{row_of(1)});
  w.world.set_joint(joint, UserJoint{{RowKind::motor, RowKind::motor, RowKind::held, RowKind::held}});
  EXPECT_EQ(rows_of(w.world, joint), (std::vector<UserRow>{row_of(1), {}, {}, {}}));
}

TEST(UserJoints, RefuseKindsOfRowsThatAreNone) {
  Workshop w;
  const auto refuse = [&](const UserJoint& user, const std::string& said) {
    w.refuse([&] { w.join(user); }, "World::create_joint: " + said);
  };
  refuse({{RowKind::none}}, "user rows[0] is none, must be a row");
  refuse({{RowKind::held, RowKind::none, RowKind::held}},
         "user rows[2] is a row behind rows[1], which is none");
  refuse({{RowKind::held, static_cast<RowKind>(9)}}, "user rows[1] is 9, must lie in [0, 4]");
}

struct Wrong {
  std::string said;
  void (*make)(UserRow& row);
};
const Wrong kWrong[] = {
    {"jacobian.linear_a is nan", [](UserRow& row) { row.jacobian.linear_a.y = kNan; }},
    {"jacobian.angular_a is inf", [](UserRow& row) { row.jacobian.angular_a.x = kInfinity; }},
    {"jacobian.linear_b is 2000000, must lie in [-1000000, 1000000]",
     [](UserRow& row) { row.jacobian.linear_b.z = 2e6f; }},
    {"jacobian.angular_b is -1.00000002e+30", [](UserRow& row) { row.jacobian.angular_b.z = -1e30f; }},
    {"target.error is 2000000", [](UserRow& row) { row.target.error = 2e6f; }},
    {"target.speed is nan", [](UserRow& row) { row.target.speed = kNan; }},
    {"target.hertz is 0", [](UserRow& row) { row.target.hertz = 0; }},
    {"target.damping_ratio is -1", [](UserRow& row) { row.target.damping_ratio = -1; }},
    {"bounds are 2 and 1",
     [](UserRow& row) {
       row.bounds = {2, 1};
     }},
    {"bounds are nan and 1",
     [](UserRow& row) {
       row.bounds = {kNan, 1};
     }},
    {"bounds are inf and inf",
     [](UserRow& row) {
       row.bounds = {kInfinity, kInfinity};
     }},
    {"bounds are -inf and -inf",
     [](UserRow& row) {
       row.bounds = {-kInfinity, -kInfinity};
     }},
};

TEST(UserJoints, RefuseNumbersOutOfRangeByTheirNamesAndAreFrozenByThemInARefresh) {
  for (const auto& [said, make] : kWrong) {
    Workshop w;
    const JointId joint = w.join({{RowKind::held, RowKind::held}});
    std::vector<UserRow> rows{row_of(1), row_of(2)};
    w.world.set_user_rows(joint, rows);
    make(rows[1]);
    w.refuse([&] { w.world.set_user_rows(joint, rows); }, "World::set_user_rows: rows[1]." + said);
    w.world.refresh_user_rows({&joint, 1}, rows);
    EXPECT_TRUE(w.world.is_frozen(joint)) << said;
    EXPECT_EQ(rows_of(w.world, joint), (std::vector<UserRow>{row_of(1), row_of(2)}));
  }
}

TEST(UserJoints, RefuseAnotherNumberOfRowsAndJointsOfOtherKinds) {
  Workshop w;
  const JointId joint = w.join({{RowKind::held, RowKind::held}}), one = w.join();
  const JointId ball = w.world.create_joint({.body_a = kWorld, .body_b = w.b}, BallJoint{});
  const std::vector<UserRow> rows(3);
  const JointId both[] = {joint, one}, mixed[] = {joint, ball};
  w.refuse([&] { w.world.set_user_rows(joint, rows); }, "World::set_user_rows: 3 rows, but the joint has 2");
  w.refuse([&] { w.world.set_user_rows(ball, rows); }, "World::set_user_rows: joint 2 is no user joint");
  w.refuse([&] { w.world.user_rows(ball, {}); }, "World::user_rows: joint 2 is no user joint");
  w.refuse([&] { w.world.refresh_user_rows(both, std::span(rows).first(2)); },
           "World::refresh_user_rows: 2 rows, but the joints have 3");
  w.refuse([&] { w.world.refresh_user_rows(mixed, rows); },
           "World::refresh_user_rows: definition 1: joint 2 is no user joint");
  EXPECT_FALSE(w.world.is_frozen(ball));
  w.world.refresh_user_rows(both, rows);
}

// --- snapshots from outside ---

TEST(UserJoints, BytesThatBreakTheirLawsAreRefused) {
  struct Broken {
    const char* said;
    void (*make)(UserJoints& users, Joints& joints);
  };
  const Broken broken[] = {
      {"user_joints.joint, row 0: is no user joint", [](auto& users, auto&) { users.joint[0] = 2; }},
      {"user_joints.joint, row 1: is no user joint, or stands there twice",
       [](auto& users, auto&) { users.joint[1] = users.joint[0]; }},
      {"user_joints.joint, row 1: does not exist", [](auto& users, auto&) { users.joint[1] = 100; }},
      {"user_joints.state, row 0: is no state", [](auto& users, auto&) { users.state[0] = 3; }},
      {"user_joints.jacobians, row 1: have numbers out of range",
       [](auto& users, auto&) { users.bounds[1].row[0][0] = 1e30f; }},
      {"user_joints.jacobians, row 1: have numbers out of range",
       [](auto& users, auto&) { users.jacobians[1].row[0][11] = kNan; }},
      {"user_joints.jacobians, row 1: have numbers of rows that the joint lacks",
       [](auto& users, auto&) { users.jacobians[1].row[3][0] = 1; }},
      {"joints.type, row 1: is that of a user joint, which has no numbers",
       [](auto& users, auto&) { users.resize(1); }},
      {"joints.parameters, row 1: is not that of such a joint",
       [](auto&, auto& joints) { joints.parameters[1].user.row[0] += 256; }},
      {"user rows[0] is none", [](auto&, auto& joints) { joints.parameters[1].user.row[0] = 0; }},
  };
  for (const auto& [said, make] : broken) {
    Workshop w;
    w.join();
    const JointId joint = w.join();
    w.world.create_joint({.body_a = kWorld, .body_b = w.b}, BallJoint{});
    const UserRow row = row_of(5);
    w.world.set_user_rows(joint, {&row, 1});
    read_snapshot(bytes_of(w.world));
    WorldData& data = internals(w.world);
    make(data.user_joints, data.joints);
    data.last_save = {};
    const std::string error = error_of([&] { read_snapshot(bytes_of(w.world)); });
    EXPECT_NE(error.find(said), std::string::npos) << error << " without " << said;
  }
}

}  // namespace
}  // namespace scree::test
