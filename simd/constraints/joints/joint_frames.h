// How the anchors and frames of a block of joints lie: where the step began, and as it moves them. Private to
// the joint kernels.
#pragma once

#include <simd/constraints/joints/joint_block.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

inline Q4 load4(const LaneFloats (&from)[4]) {
  return {load(from[0]), load(from[1]), load(from[2]), load(from[3])};
}
inline void store4(LaneFloats (&to)[4], Q4 q) {
  store(to[0], q.x);
  store(to[1], q.y);
  store(to[2], q.z);
  store(to[3], q.w);
}

// Where the anchors lie: arms from the centers of mass, and the way from anchor a to anchor b.
struct Anchors {
  V3 arm_a, arm_b, offset;
};
struct AnchorLanes {
  LaneFloats arm_a[3], arm_b[3], offset[3];  // when the step began
};

inline Anchors store_anchors(const JointPlacement& at, AnchorLanes& lanes) {
  const Anchors now{at.arm_a, at.arm_b, at.center_offset + at.arm_b - at.arm_a};
  store3(lanes.arm_a, now.arm_a);
  store3(lanes.arm_b, now.arm_b);
  store3(lanes.offset, now.offset);
  return now;
}
// At the present poses. The offset is the first one and small changes of it: its precision does not depend on
// the arms' lengths.
inline Anchors move_anchors(const AnchorLanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b) {
  const V3 first_a = load3(lanes.arm_a), first_b = load3(lanes.arm_b);
  const V3 arm_a = rotate(delta_a.rotation, first_a), arm_b = rotate(delta_b.rotation, first_b);
  return {
      arm_a, arm_b,
      load3(lanes.offset) + (delta_b.position - delta_a.position) + (arm_b - first_b) - (arm_a - first_a)};
}

// Rotations of both frames, in world axes.
struct Frames {
  Q4 a, b;
};
struct FrameLanes {
  LaneFloats a[4], b[4];  // when the step began
};

inline Frames store_frames(const JointPlacement& at, FrameLanes& lanes) {
  store4(lanes.a, at.frame_a);
  store4(lanes.b, at.frame_b);
  return {at.frame_a, at.frame_b};
}
inline Frames move_frames(const FrameLanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b) {
  return {delta_a.rotation * load4(lanes.a), delta_b.rotation * load4(lanes.b)};
}

// Takes frame a to frame b, in world axes.
inline V3 rotation_error(const Frames& frames) { return rotation_vector(frames.b * conjugate(frames.a)); }

// The direction square to two unit vectors, and the sine of their angle. Where that is `least` or less they
// lie along one line, and any direction square to the first will do.
struct Normal {
  V3 direction;
  F sine;
};
inline Normal normal_of(V3 from, V3 to, float least) {
  const V3 normal = cross(from, to);
  const F sine = length(normal), one(1.0f);
  const M some = sine > F(least);
  return {select(some, normal * (one / select(some, sine, one)), tangent_of(from)), sine};
}

// Sine below which the axis of a turn is lost in rounding.
constexpr float kLeastSwing = 1e-7f;

// The shortest turn of one unit vector to another: its angle and axis.
struct Swing {
  V3 axis;
  F angle;
};
inline Swing swing(V3 from, V3 to) {
  const Normal normal = normal_of(from, to, kLeastSwing);
  return {normal.direction, atan2(normal.sine, dot(from, to))};
}

// Both together.
struct Placed {
  Anchors anchors;
  Frames frames;
};
struct PlacedLanes {
  AnchorLanes anchors;
  FrameLanes frames;
};

inline Placed store_placed(const JointPlacement& at, PlacedLanes& lanes) {
  return {store_anchors(at, lanes.anchors), store_frames(at, lanes.frames)};
}
inline Placed move_placed(const PlacedLanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b) {
  return {move_anchors(lanes.anchors, delta_a, delta_b), move_frames(lanes.frames, delta_a, delta_b)};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
