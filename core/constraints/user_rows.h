// The numbers of user joints: what keeps WorldData::user_joints, and what becomes of numbers from outside.
#pragma once

#include <core/world/check.h>
#include <core/world/world_data.h>

#include <cstdint>
#include <span>

namespace scree {

// Makes room for so many more, so that entering them cannot fail.
void reserve_user_joints(WorldData& data, std::size_t more);
// Of a new joint of this kind: rows that move nothing.
void enter_user_joint(WorldData& data, std::int32_t joint);
// Of one that goes.
void leave_user_joint(WorldData& data, std::int32_t joint);
// Rows that the joint no longer has become as they were in a new one.
void drop_user_rows(WorldData& data, std::int32_t joint);

// How many rows the joint has.
int user_row_count(const JointParameters& parameters);

// Numbers for all rows of a joint.
struct UserNumbers {
  UserJacobians jacobians;
  UserTargets targets;
  UserBounds bounds;
};
// Of rows that move nothing.
extern const UserNumbers kNoUserNumbers;

void put_user_row(const UserRow& row, int number, UserNumbers& to);
UserRow user_row(const UserJacobians& jacobians, const UserTargets& targets, const UserBounds& bounds,
                 int number);
inline UserRow user_row(const UserJoints& users, std::int32_t user, int number) {
  return user_row(users.jacobians[user], users.targets[user], users.bounds[user], number);
}

bool is_user_row(const UserRow& row);  // within the ranges of scree/user_joint.h
// Throws Error that names the first number out of the ranges of scree/user_joint.h.
void check_user_row(Call call, int number, const UserRow& row);

// What numbers from a callback are to a joint, given by its row of UserJoints.
enum class UserVerdict : std::uint8_t { same, changed, unsound };
UserVerdict judge_user_rows(const WorldData& data, std::int32_t user, const UserJacobians& jacobians,
                            const UserTargets& targets, const UserBounds& bounds);
// Takes numbers that have changed and are sound: the joint acts. Writes this row of UserJoints alone.
void take_user_rows(WorldData& data, std::int32_t user, const UserJacobians& jacobians,
                    const UserTargets& targets, const UserBounds& bounds);
// The joint does nothing until it is given sound numbers.
void freeze_user_joint(WorldData& data, std::int32_t user);

// Whether a body that the joint can push is awake.
bool is_joint_awake(const WorldData& data, std::int32_t joint);

}  // namespace scree
