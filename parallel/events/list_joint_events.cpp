// Lists the joints that bore more than their thresholds in some substep. Costs nothing while no joint has
// any.
#include <core/world/edit.h>
#include <parallel/crew/list_where.h>
#include <parallel/events/joint_questions.h>
#include <parallel/stages.h>

namespace scree {

void list_joint_events(WorldData& data, Crew& crew) {
  const Joints& joints = data.joints;
  if (joints.reporting == 0) return;
  Events& events = data.events;
  list_where(
      crew, joints.active.size(), events.strained_places, events.strained,
      [&](std::int32_t i) {
        const std::int32_t joint = joints.active[i];
        return (joints.flags[joint] & kJointReports) != 0 &&
               is_above(peak_of(joints.reaction[joint]), joints.thresholds[joint]);
      },
      [&](std::int32_t i) {
        const std::int32_t joint = joints.active[i];
        const JointPeak peak = peak_of(joints.reaction[joint]);
        return JointEvent{joint_handle(data, joint), peak.force, peak.torque};
      });
}

}  // namespace scree
