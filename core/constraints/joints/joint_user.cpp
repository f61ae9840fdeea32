// User joints: the parameters are the kinds of their rows. The numbers stand in WorldData::user_joints, see
// core/constraints/user_rows.h. Kernels: simd/constraints/joints/joint_user.cpp.
#include <core/constraints/joints/joint_field_checks.h>
#include <core/constraints/joints/joint_fields.h>
#include <core/constraints/joints/joint_kinds.h>

#include <algorithm>

namespace scree::joint_kinds {

static_assert(kUserRows == kMaxUserRows);
static_assert(kUserNone == static_cast<std::uint32_t>(RowKind::none) &&
              kUserHeld == static_cast<std::uint32_t>(RowKind::held) &&
              kUserLimit == static_cast<std::uint32_t>(RowKind::limit) &&
              kUserMotor == static_cast<std::uint32_t>(RowKind::motor) &&
              kUserSpring == static_cast<std::uint32_t>(RowKind::spring));

void write(const UserJoint& user, JointParameters& to) {
  for (int i = 0; i < kUserRows; ++i) to.user.row[i] = static_cast<std::uint32_t>(user.rows[i]);
}

void read(const JointParameters& from, UserJoint& user) {
  for (int i = 0; i < kUserRows; ++i) user.rows[i] = static_cast<RowKind>(from.user.row[i]);
}

// What the kernels of plain joints leave out: more than kPlainUserRows rows, and all but held ones.
bool is_rich(const UserJoint& user) {
  const auto is_plain = [](RowKind row) { return row == RowKind::held || row == RowKind::none; };
  return user.rows[kPlainUserRows] != RowKind::none ||
         !std::all_of(std::begin(user.rows), std::end(user.rows), is_plain);
}

void renormalize(UserJoint&) {}

void check(Call call, const UserJoint& user) {
  const auto name = [](int row) { return "user rows[" + std::to_string(row) + "]"; };
  for (int row = 0; row < kMaxUserRows; ++row) {
    if (user.rows[row] > RowKind::spring) {
      fail_range(call, name(row).c_str(), static_cast<int>(user.rows[row]), 0,
                 static_cast<int>(RowKind::spring));
    }
    if (row > 0 && user.rows[row] != RowKind::none && user.rows[row - 1] == RowKind::none) {
      fail(call, name(row) + " is a row behind rows[" + std::to_string(row - 1) + "], which is none");
    }
  }
  if (user.rows[0] == RowKind::none) fail(call, name(0) + " is none, must be a row");
}

void check_ends(Call, const UserJoint&, JointBodies) {}

}  // namespace scree::joint_kinds
