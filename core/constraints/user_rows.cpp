// Keeps the numbers of user joints; see user_rows.h.
#include <core/constraints/user_rows.h>
#include <core/world/edit.h>
#include <core/world/number_text.h>

#include <cstring>
#include <string>

namespace scree {

namespace {

// A user row as it lies in the columns.
static_assert(sizeof(RowJacobian) == sizeof(UserJacobians::row[0]) &&
              sizeof(RowTarget) == sizeof(UserTargets::row[0]) &&
              sizeof(RowBounds) == sizeof(UserBounds::row[0]));

constexpr UserNumbers make_no_numbers() {
  UserNumbers none{};
  for (int i = 0; i < kUserRows; ++i) {
    none.targets.row[i][2] = RowTarget{}.hertz;
    none.targets.row[i][3] = RowTarget{}.damping_ratio;
    none.bounds.row[i][0] = RowBounds{}.lower;
    none.bounds.row[i][1] = RowBounds{}.upper;
  }
  return none;
}

void put_numbers(UserJoints& users, std::size_t row, const UserNumbers& numbers) {
  users.jacobians[row] = numbers.jacobians;
  users.targets[row] = numbers.targets;
  users.bounds[row] = numbers.bounds;
}

bool within(float x, float limit) { return x >= -limit && x <= limit; }

bool is_sound(const float (&jacobian)[12], const float (&target)[4], const float (&bounds)[2]) {
  bool sound = true;
  for (const float x : jacobian) sound &= within(x, kMaxJointValue);
  sound &= within(target[0], kMaxJointValue) && within(target[1], kMaxJointValue);
  sound &= target[2] >= kMinHertz && target[2] <= kMaxHertz;
  sound &= target[3] >= 0.0f && target[3] <= kMaxDampingRatio;
  return sound && bounds[0] <= bounds[1] && bounds[0] < kNoLimit && bounds[1] > -kNoLimit;
}

template <class Rows>
bool same_rows(const Rows& a, const Rows& b, int count) {
  return std::memcmp(a.row, b.row, sizeof(a.row[0]) * static_cast<std::size_t>(count)) == 0;
}
template <class Rows>
void copy_rows(const Rows& from, Rows& to, int first, int end) {
  std::memcpy(to.row + first, from.row + first, sizeof(to.row[0]) * static_cast<std::size_t>(end - first));
}

int rows_of(const WorldData& data, std::int32_t user) {
  return user_row_count(data.joints.parameters[data.user_joints.joint[user]]);
}

}  // namespace

constinit const UserNumbers kNoUserNumbers = make_no_numbers();

void reserve_user_joints(WorldData& data, std::size_t more) {
  if (more == 0) return;
  const std::size_t rows = data.user_joints.joint.size() + more;
  data.user_joints.for_each_column([rows](ColumnKind, const char*, auto& column) { column.reserve(rows); });
}

void enter_user_joint(WorldData& data, std::int32_t joint) {
  UserJoints& users = data.user_joints;
  const std::size_t row = users.joint.size();
  users.resize(row + 1);
  users.joint[row] = joint;
  users.state[row] = kUserActs;
  put_numbers(users, row, kNoUserNumbers);
  data.joints.user[joint] = static_cast<std::int32_t>(row);
}

void leave_user_joint(WorldData& data, std::int32_t joint) {
  UserJoints& users = data.user_joints;
  const std::int32_t row = data.joints.user[joint];
  const auto last = static_cast<std::int32_t>(users.joint.size()) - 1;
  users.for_each_column([&](ColumnKind, const char*, auto& column) { column[row] = column[last]; });
  data.joints.user[users.joint[row]] = row;
  users.resize(static_cast<std::size_t>(last));
}

void drop_user_rows(WorldData& data, std::int32_t joint) {
  UserJoints& users = data.user_joints;
  const std::int32_t row = data.joints.user[joint];
  const int count = rows_of(data, row);
  copy_rows(kNoUserNumbers.jacobians, users.jacobians[row], count, kUserRows);
  copy_rows(kNoUserNumbers.targets, users.targets[row], count, kUserRows);
  copy_rows(kNoUserNumbers.bounds, users.bounds[row], count, kUserRows);
}

int user_row_count(const JointParameters& parameters) {
  int count = 0;
  while (count < kUserRows && parameters.user.row[count] != kUserNone) ++count;
  return count;
}

void put_user_row(const UserRow& row, int number, UserNumbers& to) {
  std::memcpy(to.jacobians.row[number], &row.jacobian, sizeof row.jacobian);
  std::memcpy(to.targets.row[number], &row.target, sizeof row.target);
  std::memcpy(to.bounds.row[number], &row.bounds, sizeof row.bounds);
}

UserRow user_row(const UserJacobians& jacobians, const UserTargets& targets, const UserBounds& bounds,
                 int number) {
  UserRow row;
  std::memcpy(static_cast<void*>(&row.jacobian), jacobians.row[number], sizeof row.jacobian);
  std::memcpy(static_cast<void*>(&row.target), targets.row[number], sizeof row.target);
  std::memcpy(static_cast<void*>(&row.bounds), bounds.row[number], sizeof row.bounds);
  return row;
}

bool is_user_row(const UserRow& row) {
  UserNumbers numbers = kNoUserNumbers;
  put_user_row(row, 0, numbers);
  return is_sound(numbers.jacobians.row[0], numbers.targets.row[0], numbers.bounds.row[0]);
}

void check_user_row(Call call, int number, const UserRow& row) {
  const std::string prefix = "rows[" + std::to_string(number) + "].";
  const auto name = [&](const char* field) { return prefix + field; };
  const auto range = [&](const char* field, float value, float low, float high) {
    if (!(value >= low && value <= high)) fail_range(call, name(field).c_str(), value, low, high);
  };
  const auto vector = [&](const char* field, Vec3 v) {
    if (within(v.x, kMaxJointValue) && within(v.y, kMaxJointValue) && within(v.z, kMaxJointValue)) return;
    check_vector(call, name(field).c_str(), v, kMaxJointValue);
  };
  vector("jacobian.linear_a", row.jacobian.linear_a);
  vector("jacobian.angular_a", row.jacobian.angular_a);
  vector("jacobian.linear_b", row.jacobian.linear_b);
  vector("jacobian.angular_b", row.jacobian.angular_b);
  range("target.error", row.target.error, -kMaxJointValue, kMaxJointValue);
  range("target.speed", row.target.speed, -kMaxJointValue, kMaxJointValue);
  range("target.hertz", row.target.hertz, kMinHertz, kMaxHertz);
  range("target.damping_ratio", row.target.damping_ratio, 0.0f, kMaxDampingRatio);
  const auto [lower, upper] = row.bounds;
  if (lower <= upper && lower < kNoLimit && upper > -kNoLimit) return;
  fail(call, name("bounds") + " are " + number_text(lower, 9) + " and " + number_text(upper, 9) +
                 ", the lower one must be at most the upper one, and neither an infinite force");
}

UserVerdict judge_user_rows(const WorldData& data, std::int32_t user, const UserJacobians& jacobians,
                            const UserTargets& targets, const UserBounds& bounds) {
  const int count = rows_of(data, user);
  for (int i = 0; i < count; ++i) {
    if (!is_sound(jacobians.row[i], targets.row[i], bounds.row[i])) return UserVerdict::unsound;
  }
  const UserJoints& users = data.user_joints;
  const bool same = users.state[user] == kUserActs && same_rows(jacobians, users.jacobians[user], count) &&
                    same_rows(targets, users.targets[user], count) &&
                    same_rows(bounds, users.bounds[user], count);
  return same ? UserVerdict::same : UserVerdict::changed;
}

void take_user_rows(WorldData& data, std::int32_t user, const UserJacobians& jacobians,
                    const UserTargets& targets, const UserBounds& bounds) {
  UserJoints& users = data.user_joints;
  const int count = rows_of(data, user);
  copy_rows(jacobians, users.jacobians[user], 0, count);
  copy_rows(targets, users.targets[user], 0, count);
  copy_rows(bounds, users.bounds[user], 0, count);
  users.state[user] = kUserActs;
}

void freeze_user_joint(WorldData& data, std::int32_t user) {
  UserJoints& users = data.user_joints;
  if (users.state[user] != kUserActs) return;
  const std::int32_t joint = users.joint[user];
  users.state[user] = kUserFreezes;
  data.joints.impulses[joint] = {};
  data.joints.marks.mark(joint);
}

bool is_joint_awake(const WorldData& data, std::int32_t joint) {
  const JointBodies ends = data.joints.bodies[joint];
  const auto is_awake = [&](std::int32_t body) {
    return data.bodies.type[body] == BodyType::dynamic && (data.bodies.flags[body] & kBodyAsleep) == 0;
  };
  return is_awake(ends.a) || is_awake(ends.b);
}

}  // namespace scree
