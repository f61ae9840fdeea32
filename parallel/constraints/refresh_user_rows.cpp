// Before the step: the numbers of user joints from the callback of the world.
//
// The callback writes copies, in batches of kBatch joints that threads share. Nothing of the world changes
// before all batches have returned, so that one that throws leaves no trace. (Where ranks share the world,
// the callback is called within the step, when all bodies are there, and one that throws keeps its rank's
// numbers.) What has changed then goes to the columns of UserJoints and, where the world is recorded, to its
// recorder as the call that does the same.
#include <core/constraints/user_rows.h>
#include <core/state/recording_format/recorded_calls.h>
#include <parallel/constraints/constraints.h>
#include <parallel/crew/crew.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/messages.h>
#include <parallel/stages.h>

#include <algorithm>
#include <exception>
#include <utility>
#include <vector>

namespace scree {

namespace {

// Joints that a call of the callback gets: enough to be worth the call, and several batches for 1,000 joints.
constexpr int kBatch = 64;

// Whether this rank knows that the joint has an awake body that it pushes; each rank knows its own bodies.
bool is_known_awake(const WorldData& data, std::int32_t joint) {
  const Border* const border = border_of(data);
  if (border == nullptr) return is_joint_awake(data, joint);
  const JointBodies ends = data.joints.bodies[joint];
  const auto is_own_awake = [&](std::int32_t body) {
    return border->owns(body) && (data.bodies.flags[body] & kBodyAsleep) == 0;
  };
  return is_own_awake(ends.a) || is_own_awake(ends.b);
}

// Of the ranks of a joint's bodies, the one that asks about it.
bool asks_about(const Border& border, const JointBodies& ends) {
  return border.owns(border.owner_of(ends.a) != kEveryRank ? ends.a : ends.b);
}

void size_refresh(UserRefresh& refresh) {
  const std::size_t count = refresh.asked.size();
  refresh.ids.resize_discarding(count);
  refresh.verdicts.resize_discarding(count);
  refresh.jacobians.resize_discarding(count);
  refresh.targets.resize_discarding(count);
  refresh.bounds.resize_discarding(count);
}

bool is_user_joint(const WorldData& data, std::int32_t joint) {
  const Joints& joints = data.joints;
  return joint >= 0 && std::cmp_less(joint, joints.flags.size()) &&
         (joints.flags[joint] & kJointAlive) != 0 && joints.user[joint] >= 0;
}

// What has changed, told by the rank that has asked.
struct ToldRows {
  UserJacobians jacobians;
  UserTargets targets;
  UserBounds bounds;
  std::int32_t joint;
  UserVerdict verdict;
};

// All ranks take what any has changed, so that all have the same numbers, and rank 0 may record them.
void share_changes(WorldData& data, Border& border, UserRefresh& refresh) {
  std::vector<ToldRows> told;
  for (std::size_t i = 0; i < refresh.asked.size(); ++i) {
    if (refresh.verdicts[i] == UserVerdict::same) continue;
    ToldRows& rows = told.emplace_back();
    rows.jacobians = refresh.jacobians[i];
    rows.targets = refresh.targets[i];
    rows.bounds = refresh.bounds[i];
    rows.joint = refresh.asked[i];
    rows.verdict = refresh.verdicts[i];
  }
  told = gather_lists(border.transport, told, [&](const ToldRows& rows) {
    return is_user_joint(data, rows.joint) &&
           (rows.verdict == UserVerdict::changed || rows.verdict == UserVerdict::unsound);
  });
  std::sort(told.begin(), told.end(),
            [](const ToldRows& one, const ToldRows& other) { return one.joint < other.joint; });
  refresh.asked.clear();
  for (const ToldRows& rows : told) refresh.asked.push_back(rows.joint);
  size_refresh(refresh);
  for (std::size_t i = 0; i < told.size(); ++i) {
    refresh.ids[i] = joint_handle(data, told[i].joint);
    refresh.jacobians[i] = told[i].jacobians;
    refresh.targets[i] = told[i].targets;
    refresh.bounds[i] = told[i].bounds;
    refresh.verdicts[i] = told[i].verdict;
  }
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

// The user joints that act and have an awake body, ascending by joint.
void list_asked_joints(WorldData& data) {
  UserRefresh& refresh = constraints_of(data).refresh;
  const UserJoints& users = data.user_joints;
  std::vector<std::int32_t> known;
  refresh.asked.clear();
  for (std::size_t row = 0; row < users.joint.size(); ++row) {
    const std::int32_t joint = users.joint[row];
    if ((data.joints.flags[joint] & kJointEnabled) == 0 || !is_known_awake(data, joint)) continue;
    if (data.border == nullptr) {
      refresh.asked.push_back(joint);
    } else {
      known.push_back(joint);
    }
  }
  if (Border* const border = border_of(data)) {
    known = gather_lists(border->transport, known,
                         [&](std::int32_t joint) { return is_user_joint(data, joint); });
    keep_each_once(known);
    for (const std::int32_t joint : known) {
      if (asks_about(*border, data.joints.bodies[joint])) refresh.asked.push_back(joint);
    }
  }
  std::sort(refresh.asked.begin(), refresh.asked.end());
  size_refresh(refresh);
}

void refresh_user_rows(const World& world, WorldData& data, float dt, Crew& crew) {
  UserRefresh& refresh = constraints_of(data).refresh;
  const auto ask_all = [&] {
    crew.run_ranges(static_cast<int>(refresh.asked.size()), kBatch,
                    [&](int begin, int end, int) { ask(world, data, dt, begin, end, refresh); });
  };
  if (Border* const border = border_of(data)) {
    try {
      ask_all();
    } catch (...) {  // as of hooks of contacts: the others are on their way into the step
      data.hooks.thrown = std::current_exception();
      refresh.asked.clear();
    }
    share_changes(data, *border, refresh);
  } else {
    ask_all();
  }
  const int count = static_cast<int>(refresh.asked.size());
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
