// The frames of a block of joints as the step moves them. Private to the joint kernels.
#pragma once

#include <simd/joint_block.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// When the step began.
struct FrameLanes {
  LaneFloats arm_a[3], arm_b[3];  // from the centers of mass to the anchors
  LaneFloats offset[3];           // from anchor a to anchor b
  LaneFloats frame_a[4], frame_b[4];
};

inline void store4(LaneFloats (&to)[4], Q4 q) {
  store(to[0], q.x);
  store(to[1], q.y);
  store(to[2], q.z);
  store(to[3], q.w);
}
inline Q4 load4(const LaneFloats (&from)[4]) {
  return {load(from[0]), load(from[1]), load(from[2]), load(from[3])};
}

inline void store_frames(FrameLanes& lanes, const JointPlacement& at) {
  store3(lanes.arm_a, at.arm_a);
  store3(lanes.arm_b, at.arm_b);
  store3(lanes.offset, at.center_offset + at.arm_b - at.arm_a);
  store4(lanes.frame_a, at.frame_a);
  store4(lanes.frame_b, at.frame_b);
}

// Now, in world axes.
struct FramesNow {
  V3 arm_a, arm_b, offset;
  Q4 rotation_a, rotation_b;
};
inline FramesNow move_frames(const FrameLanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b) {
  const V3 first_a = load3(lanes.arm_a), first_b = load3(lanes.arm_b);
  FramesNow now;
  now.arm_a = rotate(delta_a.rotation, first_a);
  now.arm_b = rotate(delta_b.rotation, first_b);
  // As small changes of the first offset: their precision does not depend on the arms' lengths.
  now.offset = load3(lanes.offset) + (delta_b.position - delta_a.position) + (now.arm_b - first_b) -
               (now.arm_a - first_a);
  now.rotation_a = delta_a.rotation * load4(lanes.frame_a);
  now.rotation_b = delta_b.rotation * load4(lanes.frame_b);
  return now;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
