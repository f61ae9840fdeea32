// Joints whose reaction in the step was above their strength: they are disabled, and listed for the caller.
#include <core/edit.h>
#include <parallel/stages.h>

namespace scree {

namespace {

// A reaction that is not finite tells nothing: its bodies are about to be restored.
bool is_above(const float (&reaction)[3], float strength) {
  const Vec3 v = to_vec3(reaction);
  return dot(v, v) > strength * strength;
}

}  // namespace

void break_joints(WorldData& data) {
  Joints& joints = data.joints;
  for (const std::int32_t joint : joints.active) {
    const auto row = static_cast<std::size_t>(joint);
    if ((joints.flags[row] & kJointBreaks) == 0) continue;
    const JointReactionRow& reaction = joints.reaction[row];
    const JointStrength strength = joints.strength[row];
    if (!is_above(reaction.force, strength.force) && !is_above(reaction.torque, strength.torque)) continue;
    joints.flags[row] = static_cast<std::uint8_t>(joints.flags[row] & ~kJointEnabled);
    data.events.broken.push_back({static_cast<std::uint32_t>(joint), joints.generation[row]});
    joints.active_changed = true;
    release_pairs(data, joint);
  }
}

}  // namespace scree
