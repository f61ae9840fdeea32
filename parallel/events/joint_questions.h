// A question about a joint that break_joints and list_joint_events share.
#pragma once

#include <core/plain/joint.h>

#include <cmath>

namespace scree {

// The largest force, N, and torque, N m, of the substeps of a step. Of joints in chunks with `peaks` only.
struct JointPeak {
  float force, torque;
};
inline JointPeak peak_of(const JointReactionRow& reaction) {
  return {std::sqrt(reaction.force_peak_squared), std::sqrt(reaction.torque_peak_squared)};
}

// `limit` is a JointStrength or JointThresholds.
template <class Limit>
bool is_above(const JointPeak& peak, const Limit& limit) {
  return peak.force > limit.force || peak.torque > limit.torque;
}

}  // namespace scree
