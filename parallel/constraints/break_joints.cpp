// Breaks joints: disables those whose reaction in a substep was above their strength, and lists them for the
// caller.
#include <core/world/edit.h>
#include <parallel/constraints/constraints.h>
#include <parallel/crew/crew.h>
#include <parallel/distributed/border.h>
#include <parallel/events/joint_questions.h>
#include <parallel/stages.h>

#include <algorithm>

namespace scree {

namespace {

bool has_broken(const Joints& joints, std::int32_t joint) {
  return is_above(peak_of(joints.reaction[joint]), joints.strength[joint]);
}

std::span<const std::int32_t> joints_of(const Constraints& constraints, std::int32_t chunk) {
  const simd::ConstraintChunk& c = constraints.joint_chunks[chunk];
  const std::int32_t* const first = constraints.joint_lanes.begin() + c.first_lane;
  return {first, first + c.lanes};
}

}  // namespace

void break_joints(WorldData& data, Crew& crew) {
  Constraints& constraints = constraints_of(data);
  Joints& joints = data.joints;
  Column<std::int32_t>& chunks = constraints.breaking_chunks;
  chunks.clear();
  for (std::size_t chunk = 0; chunk < constraints.joint_chunks.size(); ++chunk) {
    if (constraints.joint_chunks[chunk].peaks) chunks.push_back(static_cast<std::int32_t>(chunk));
  }
  crew.run(static_cast<int>(chunks.size()), [&](int i, int) {
    std::int32_t& chunk = chunks[i];
    const std::span<const std::int32_t> rows = joints_of(constraints, chunk);
    if (std::none_of(rows.begin(), rows.end(), [&](std::int32_t joint) { return has_broken(joints, joint); }))
      chunk = -1;
  });
  Column<JointId>& broken = data.events.broken;
  for (const std::int32_t chunk : chunks) {
    if (chunk < 0) continue;
    for (const std::int32_t joint : joints_of(constraints, chunk)) {
      if (has_broken(joints, joint)) broken.push_back(joint_handle(data, joint));
    }
  }
  std::sort(broken.begin(), broken.end(), [](JointId a, JointId b) { return a.index < b.index; });
  if (Border* const border = border_of(data)) share_broken(*border, data, broken);
  for (const JointId id : broken) {
    const auto joint = static_cast<std::int32_t>(id.index);
    std::uint8_t& flags = joints.flags[id.index];
    flags = static_cast<std::uint8_t>(flags & ~kJointEnabled);
    joints.marks.mark(joint);
    joints_changed(data, joint, (flags & kJointCollides) == 0);
    wake_ends(data, joint);  // a tired body may hang on nothing now
  }
  std::size_t told = 0;
  for (const JointId id : broken) {
    const JointBodies ends = joints.bodies[static_cast<std::int32_t>(id.index)];
    if (tells_of(border_of(data), ends.a, ends.b)) broken[told++] = id;
  }
  broken.resize(told);
}

}  // namespace scree
