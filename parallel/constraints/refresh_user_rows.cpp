// Before the step: the numbers of user joints from the callback of the world.
//
// The callback writes copies, in batches of kBatch joints that threads share. Nothing of the world changes
// before all batches have returned, so that one that throws leaves no trace. What has changed then goes to
// the columns of UserJoints and, where the world is recorded, to its recorder as the call that does the same.
#include <core/constraints/user_rows.h>
#include <core/state/recording_format/recorded_calls.h>
#include <parallel/constraints/constraints.h>
#include <parallel/crew/crew.h>
#include <parallel/stages.h>

#include <algorithm>
#include <vector>

namespace scree {

namespace {

// Joints that a call of the callback gets: enough to be worth the call, and several batches for 1,000 joints.
constexpr int kBatch = 64;

// The user joints that act and have an awake body, ascending by joint.
void list_asked(const WorldData& data, UserRefresh& refresh) {
  const UserJoints& users = data.user_joints;
  refresh.asked.clear();
  for (std::size_t row = 0; row < users.joint.size(); ++row) {
    const std::int32_t joint = users.joint[row];
    if ((data.joints.flags[joint] & kJointEnabled) == 0 || !is_joint_awake(data, joint)) continue;
    refresh.asked.push_back(joint);
  }
  std::sort(refresh.asked.begin(), refresh.asked.end());
  const std::size_t count = refresh.asked.size();
  refresh.ids.resize_discarding(count);
  refresh.verdicts.resize_discarding(count);
  refresh.jacobians.resize_discarding(count);
  refresh.targets.resize_discarding(count);
  refresh.bounds.resize_discarding(count);
}

template <class Entry, class Row>
std::span<Entry> entries(Column<Row>& column, int begin, int end) {
  static_assert(sizeof(Row) == sizeof(Entry) * kUserRows);
  return {reinterpret_cast<Entry*>(column.data() + begin), static_cast<std::size_t>(end - begin) * kUserRows};
}

void ask(const World& world, const WorldData& data, float dt, int begin, int end, UserRefresh& refresh) {
  const UserJoints& users = data.user_joints;
  for (int i = begin; i < end; ++i) {
    const std::int32_t joint = refresh.asked[i], user = data.joints.user[joint];
    refresh.ids[i] = joint_handle(data, joint);
    refresh.jacobians[i] = users.jacobians[user];
    refresh.targets[i] = users.targets[user];
    refresh.bounds[i] = users.bounds[user];
  }
  users.callback({world, dt,
                  std::as_const(refresh.ids)
                      .span()
                      .subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin)),
                  entries<RowJacobian>(refresh.jacobians, begin, end),
                  entries<RowTarget>(refresh.targets, begin, end),
                  entries<RowBounds>(refresh.bounds, begin, end)});
  for (int i = begin; i < end; ++i) {
    refresh.verdicts[i] = judge_user_rows(data, data.joints.user[refresh.asked[i]], refresh.jacobians[i],
                                          refresh.targets[i], refresh.bounds[i]);
  }
}

// What has changed, as the call that brings it about. An unsound joint that is frozen already has not.
void record(WorldData& data, const UserRefresh& refresh) {
  std::vector<JointId> joints;
  std::vector<UserRow> rows;
  const UserJoints& users = data.user_joints;
  for (std::size_t i = 0; i < refresh.asked.size(); ++i) {
    const std::int32_t user = data.joints.user[refresh.asked[i]];
    const bool freezes = refresh.verdicts[i] == UserVerdict::unsound && users.state[user] == kUserActs;
    if (refresh.verdicts[i] != UserVerdict::changed && !freezes) continue;
    joints.push_back(refresh.ids[i]);
    const int count = user_row_count(data.joints.parameters[refresh.asked[i]]);
    for (int row = 0; row < count; ++row) {
      rows.push_back(user_row(refresh.jacobians[i], refresh.targets[i], refresh.bounds[i], row));
    }
  }
  if (joints.empty()) return;
  const std::span<const JointId> all_joints(joints);
  const std::span<const UserRow> all_rows(rows);
  const CallRecord<RecordedCall::refresh_user_rows> call_record(data, all_joints, all_rows);
}

}  // namespace

void refresh_user_rows(const World& world, WorldData& data, float dt, Crew& crew) {
  UserRefresh& refresh = constraints_of(data).refresh;
  list_asked(data, refresh);
  const int count = static_cast<int>(refresh.asked.size());
  crew.run_ranges(count, kBatch, [&](int begin, int end, int) { ask(world, data, dt, begin, end, refresh); });
  if (data.recording.sink != nullptr) record(data, refresh);
  crew.run_ranges(count, kBatch, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) {
      if (refresh.verdicts[i] != UserVerdict::changed) continue;
      take_user_rows(data, data.joints.user[refresh.asked[i]], refresh.jacobians[i], refresh.targets[i],
                     refresh.bounds[i]);
    }
  });
  for (int i = 0; i < count; ++i) {
    if (refresh.verdicts[i] == UserVerdict::unsound) {
      freeze_user_joint(data, data.joints.user[refresh.asked[i]]);
    }
  }
}

}  // namespace scree
