// Joints as kernels read them: what a Joint asks for as JointParameters and back, exactly; and where the
// frames of a joint lie in its bodies. See plain/joint.h for what the entries mean.
#pragma once

#include <core/world/world_data.h>

#include <cstdint>

namespace scree {

// The joint must be valid, see check_joint; rotations are taken as they are. `hertz` and `damping_ratio` are
// JointDef's.
JointParameters parameters_of(const Joint& joint, float hertz, float damping_ratio);
Joint joint_of(JointType type, const JointParameters& parameters);

inline JointType type_of(const Joint& joint) { return static_cast<JointType>(joint.index()); }
const char* name_of(JointType type);

// The same joint with drives whose target is of unit length.
Joint normalized(Joint joint);
// Whether it has limits or drives, which kernels of plain joints leave out.
bool is_rich(const Joint& joint);

bool breaks(JointStrength strength);
bool reports(JointThresholds thresholds);
std::uint8_t flags_of(const JointDef& def, const Joint& joint);  // JointFlag
JointDef def_of(const WorldData& data, std::int32_t joint);      // as it is now

// From the joint's frames and its bodies' centers of mass.
JointFrames frames_of(const Bodies& bodies, JointBodies ends, const Pose& frame_a, const Pose& frame_b);

// A row of Bodies in the lists of joints: the world, which has none, is no body.
inline bool is_listed(std::int32_t body) { return body != kFixedRow; }
// Which link of a joint belongs to the list of one of its bodies.
inline std::int32_t& link_of(JointBodies& links, JointBodies ends, std::int32_t body) {
  return ends.a == body ? links.a : links.b;
}
inline std::int32_t link_of(const JointBodies& links, JointBodies ends, std::int32_t body) {
  return ends.a == body ? links.a : links.b;
}
inline std::int32_t other_end(JointBodies ends, std::int32_t body) {
  return ends.a == body ? ends.b : ends.a;
}

// The joint after this one in the list of a body, -1: none.
inline std::int32_t next_joint(const Joints& joints, std::int32_t joint, std::int32_t body) {
  const auto row = static_cast<std::size_t>(joint);
  return link_of(joints.next[row], joints.bodies[row], body);
}

}  // namespace scree
