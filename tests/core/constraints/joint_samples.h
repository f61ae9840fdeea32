// Joints of all kinds, for the tests of the calls, of snapshots and of recordings.
#pragma once

#include <core/state/recording_format/value_bytes.h>
#include <scree/joint.h>

#include <type_traits>
#include <utility>
#include <vector>

namespace scree::test {

// Gives every number of a joint a different value, within the limits of most kinds.
class Fill {
 public:
  explicit Fill(float first) : next_(first) {}

  template <class Value>
  void operator()(Value& value) {
    if constexpr (std::is_same_v<Value, float>) {
      value = next_;
      next_ += 0.0078125f;
    } else if constexpr (std::is_same_v<Value, Drive>) {
      value = drives_++ % 2 == 0 ? Drive::spring : Drive::motor;
    } else if constexpr (std::is_same_v<Value, RowKind>) {
      value = static_cast<RowKind>(1 + rows_++ % 4);
    } else if constexpr (std::is_same_v<Value, bool>) {
      value = !value;
    } else {
      fields(value, *this);
    }
  }

 private:
  float next_;
  int drives_ = 0;
  int rows_ = next_ < 0.1f ? 0 : 1;
};

template <std::size_t... kKind>
std::vector<Joint> joints_of_all_kinds(float first, std::index_sequence<kKind...>) {
  std::vector<Joint> joints;
  const auto add = [&](auto kind) {
    Fill fill(first);
    fill(kind);
    joints.emplace_back(kind);
  };
  (add(std::variant_alternative_t<kKind, Joint>{}), ...);
  return joints;
}

// One joint of each kind with no two numbers equal; not all of them are valid.
inline std::vector<Joint> filled_joints(float first = 0.015625f) {
  return joints_of_all_kinds(first, std::make_index_sequence<kJointTypeCount>());
}

// One valid joint of each kind, with limits and drives where the kind allows them.
inline std::vector<Joint> sound_joints(float first = 0.015625f) {
  std::vector<Joint> joints = filled_joints(first);
  std::get<BallJoint>(joints[static_cast<std::size_t>(JointType::ball)]).drive.target = {0.5f, -0.5f, 0.5f,
                                                                                         0.5f};
  std::get<MotorJoint>(joints[static_cast<std::size_t>(JointType::motor)]).rotation.target = {0, 0, -1, 0};
  std::get<WheelJoint>(joints[static_cast<std::size_t>(JointType::wheel)]).spin = {
      .drive = Drive::motor, .speed = 5.0f, .max_force = 3.0f};
  return joints;
}

// One joint of each kind with default values.
inline std::vector<Joint> plain_joints() {
  std::vector<Joint> joints;
  for (const Joint& joint : filled_joints()) {
    joints.push_back(std::visit([](auto kind) { return Joint(decltype(kind){}); }, joint));
  }
  return joints;
}

}  // namespace scree::test
