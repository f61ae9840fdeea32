// Calls that give user joints their numbers.
#include <core/constraints/user_rows.h>
#include <core/state/recording_format/recorded_calls.h>
#include <core/world/check.h>
#include <core/world/edit.h>
#include <core/world/fp_environment.h>
#include <scree/world.h>

#include <string>
#include <utility>

namespace scree {

namespace {

// The row of UserJoints of a handle from a caller.
std::int32_t checked_user(Call call, const WorldData& data, JointId id) {
  const std::int32_t joint = checked_row(call, data, id);
  if (data.joints.type[joint] != JointType::user) {
    fail(call, "joint " + std::to_string(joint) + " is no user joint");
  }
  return data.joints.user[joint];
}

int row_count(const WorldData& data, std::int32_t user) {
  return user_row_count(data.joints.parameters[data.user_joints.joint[user]]);
}

void judge_and_take(WorldData& data, std::int32_t user, const UserNumbers& numbers) {
  const std::int32_t joint = data.user_joints.joint[user];
  switch (judge_user_rows(data, user, numbers.jacobians, numbers.targets, numbers.bounds)) {
    case UserVerdict::same:
      break;
    case UserVerdict::changed:
      take_user_rows(data, user, numbers.jacobians, numbers.targets, numbers.bounds);
      if (!is_joint_awake(data, joint)) wake_ends(data, joint);
      break;
    case UserVerdict::unsound:
      freeze_user_joint(data, user);
      break;
  }
}

}  // namespace

void World::set_user_rows(JointId joint, std::span<const UserRow> rows) {
  constexpr Call call{"set_user_rows"};
  const FpEnvironment environment;
  WorldData& data = opened(call, data_);
  const CallRecord<RecordedCall::set_user_rows> call_record(data, joint, rows);
  const std::int32_t user = checked_user(call, data, joint);
  if (std::cmp_not_equal(rows.size(), row_count(data, user))) {
    fail(call,
         std::to_string(rows.size()) + " rows, but the joint has " + std::to_string(row_count(data, user)));
  }
  UserNumbers numbers = kNoUserNumbers;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    check_user_row(call, static_cast<int>(i), rows[i]);
    put_user_row(rows[i], static_cast<int>(i), numbers);
  }
  if (judge_user_rows(data, user, numbers.jacobians, numbers.targets, numbers.bounds) == UserVerdict::same)
    return;
  take_user_rows(data, user, numbers.jacobians, numbers.targets, numbers.bounds);
  wake_ends(data, data.user_joints.joint[user]);
}

std::size_t World::user_rows(JointId joint, std::span<UserRow> out) const {
  constexpr Call call{"user_rows"};
  const WorldData& data = opened(call, data_);
  const std::int32_t user = checked_user(call, data, joint);
  const auto count = static_cast<std::size_t>(row_count(data, user));
  for (std::size_t i = 0; i < count && i < out.size(); ++i) {
    out[i] = user_row(data.user_joints, user, static_cast<int>(i));
  }
  return count;
}

void World::refresh_user_rows(std::span<const JointId> joints, std::span<const UserRow> rows) {
  constexpr Call call{"refresh_user_rows"};
  const FpEnvironment environment;
  WorldData& data = opened(call, data_);
  const CallRecord<RecordedCall::refresh_user_rows> call_record(data, joints, rows);
  std::size_t wanted = 0;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const std::int32_t user = checked_user(item_of(call, joints.size(), i), data, joints[i]);
    wanted += static_cast<std::size_t>(row_count(data, user));
  }
  if (rows.size() != wanted) {
    fail(call, std::to_string(rows.size()) + " rows, but the joints have " + std::to_string(wanted));
  }
  const UserRow* row = rows.data();
  for (const JointId joint : joints) {
    const std::int32_t user = data.joints.user[joint.index];
    UserNumbers numbers = kNoUserNumbers;
    for (int i = 0, count = row_count(data, user); i < count; ++i) put_user_row(*row++, i, numbers);
    data.joints.marks.mark(joint.index);
    judge_and_take(data, user, numbers);
  }
}

bool World::is_frozen(JointId joint) const {
  constexpr Call call{"is_frozen"};
  const WorldData& data = opened(call, data_);
  const std::int32_t row = checked_row(call, data, joint);
  return data.joints.type[row] == JointType::user &&
         data.user_joints.state[data.joints.user[row]] != kUserActs;
}

void World::set_user_row_callback(UserRowCallback callback) {
  opened({"set_user_row_callback"}, data_).user_joints.callback = std::move(callback);
}

bool World::has_user_row_callback() const noexcept {
  return data_ != nullptr && data_->user_joints.callback != nullptr;
}

std::span<const JointId> World::frozen_joints() const noexcept {
  if (data_ == nullptr) return {};
  return std::as_const(data_->events.frozen).span();
}

}  // namespace scree
